/* study.c - from suites to points, then to what is written. */
#include "app/study/study.h"

#include <string.h>
#include "lib/io/atomic_file.h"

static kith_status prepare(struct kith_study *s, const struct kith_study_verb *verb) {
  static const char *const several[] = {"measure"};
  const char *measure[KITH_SUITE_MEASURES];
  double weight = 0;
  int n_jobs = 0;
  KITH_TRY(verb->read(s, false));
  KITH_TRY(kith_resize(&s->point, 0, (size_t)s->n, sizeof *s->point));
  for (int k = 0; k < s->n; ++k) {
    const int n = s->suite[k].n_methods * s->suite[k].n_values;
    KITH_TRY(kith_resize(&s->point[k], 0, (size_t)n, sizeof **s->point));
    for (int j = 0; j < n; ++j) {
      s->suite[k].job[j].threads = KITH_MAX(s->options->threads, 1);
      weight += s->suite[k].job[j].weight;
    }
    n_jobs += n;
  }
  for (int k = 0; k < s->suite->n_measures; ++k) measure[k] = s->suite->measure[k];
  s->campaign.quiet = s->options->quiet, s->campaign.cpu_limit = verb->cpu_limit;
  return kith_campaign_open(&s->campaign, s->suite->n_measures, s->n == 1 ? measure : several, n_jobs,
                            weight);
}

/* The first values of all methods first: what is interrupted has something of each. */
static kith_status run_all(struct kith_study *s) {
  for (int k = 0; k < s->n; ++k) {
    const struct kith_suite *suite = &s->suite[k];
    for (int a = 0; a < suite->n_measures; ++a) s->campaign.column[KITH_MEASURES + a] = suite->measure[a];
    for (int v = 0; v < suite->n_values; ++v)
      for (int j = v; j < suite->n_methods * suite->n_values; j += suite->n_values)
        KITH_TRY(kith_campaign_run(&s->campaign, &suite->job[j], &s->point[k][j]));
  }
  return kith_campaign_close(&s->campaign);
}

static kith_status write_all(const struct kith_study *s, const struct kith_study_verb *verb) {
  char path[KITH_PATH + 16];
  struct kith_atomic_file *file;
  KITH_TRY(verb->draw(s));
  snprintf(path, sizeof path, "%s/%s.md", s->campaign.directory, verb->name);
  KITH_TRY(kith_atomic_file_open(&file, path));
  verb->put(file->stream, s, true);
  KITH_TRY(kith_atomic_file_commit(&file, false));
  verb->put(stdout, s, false);
  printf("\n%d runs, %d failed; %s\n", s->campaign.n_jobs, s->campaign.n_failed, path);
  return KITH_OK;
}

static void clear(struct kith_study *s) {
  kith_campaign_close(&s->campaign);
  for (int k = 0; k < s->n; ++k) {
    kith_suite_clear(&s->suite[k]);
    if (s->point != NULL) kith_free(&s->point[k]);
  }
  kith_free(&s->suite);
  kith_free(&s->point);
}

enum kith_exit kith_study_run(const struct kith_study_verb *verb, const struct kith_options *options) {
  struct kith_study s = {.options = options};
  enum kith_exit code = KITH_EXIT_USAGE;
  kith_status status = kith_programs_find(&s.campaign.programs);
  if (status == KITH_OK && options->subject != NULL && strcmp(options->subject, "list") == 0) {
    status = verb->read(&s, true);
    if (status == KITH_OK) verb->list(&s);
    code = KITH_EXIT_OK;
  } else if (status == KITH_OK) {
    status = prepare(&s, verb);
    if (status == KITH_OK) {
      status = run_all(&s);
      if (status == KITH_OK) status = write_all(&s, verb);
      code = status == KITH_OK ? verb->verdict(&s) : KITH_EXIT_FAILED;
    }
  }
  if (status != KITH_OK) {
    fprintf(stderr, "kith: %s\n", kith_failure());
    if (code == KITH_EXIT_OK) code = KITH_EXIT_USAGE;
  }
  clear(&s);
  return code;
}
