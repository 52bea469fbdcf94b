/* study.h - what `kith chart` and `kith stress` have in common: suites are read, their jobs run one after the
 * other through a campaign, and a text and a figure written of the points. */
#ifndef KITH_APP_STUDY_STUDY_H
#define KITH_APP_STUDY_STUDY_H

#include "app/cli/options.h"
#include "app/study/suite.h"

struct kith_study {
  const struct kith_options *options;
  struct kith_campaign campaign;
  int n;
  struct kith_suite *suite;  /* owned */
  struct kith_point **point; /* owned, for each suite; [m * n_values + v] */
};

/* What differs. */
struct kith_study_verb {
  const char *name; /* of the text, NAME.md */
  double cpu_limit; /* seconds of processor time for a run; 0: none */
  void (*list)(const struct kith_study *study);
  kith_status (*read)(struct kith_study *study,
                      bool listing); /* suites, the directory; nothing is written yet */
  kith_status (*draw)(const struct kith_study *study);
  void (*put)(FILE *out, const struct kith_study *study, bool to_file); /* to DIR/NAME.md, or to stdout */
  enum kith_exit (*verdict)(const struct kith_study *study);
};

/* Exit code: that of `verdict`, 1 if the results cannot be written, 2 if what is read is wrong. */
enum kith_exit kith_study_run(const struct kith_study_verb *verb, const struct kith_options *options);

#endif
