/* stress.h - where a method stops working: `kith stress [SWEEP]`, all of them by default; `kith stress list`.
 *
 * A sweep turns one knob of one scene up a ladder, from mild to hard, for every method; a gate says what still counts as working. The
 * answer is where on the ladder the method passes: up to which value, as a rule. A run that fails, or takes more than two minutes of processor time, does
 * not pass, and the reason is kept. Sweeps and methods are data: stress_rows.h, one entry each.
 *
 * Points are kept in DIR/points.csv (-o, out/stress by default), so what was interrupted goes on (matrix.h). On stdout, and on the page
 * DIR/stress.html: a table, sweep by method. DIR/stress.csv has every point with its verdict, DIR/stress.svg the metrics over the knobs. */
#ifndef KITH_APP_STRESS_H
#define KITH_APP_STRESS_H

#include "app/matrix.h"
#include "app/options.h"

enum { KITH_RUNGS = 16, KITH_STRESS_METHODS = 16 };

struct kith_rung {
  double x;             /* of the knob; with names: its position */
  const char *name;     /* NULL: the number */
  const char *settings; /* parted by blanks */
};
enum kith_gate {
  KITH_AT_MOST,  /* the metric, at most the bound */
  KITH_AT_LEAST, /* at least the bound */
  KITH_OF_FIRST  /* over its value at the first rung of the same method, at most the bound */
};
struct kith_sweep {
  const char *name, *knob, *scene;
  int dimension;
  const char *settings, *metric;
  enum kith_gate gate;
  double bound;
  const char *reason;                /* of the gate */
  struct kith_rung rung[KITH_RUNGS]; /* ended by settings NULL */
};
struct kith_stress_method {
  const char *name, *settings;
};
extern const struct kith_sweep kith_sweeps[];
extern const int kith_n_sweeps, kith_n_stress_methods;
extern const struct kith_stress_method kith_stress_methods[];

/* What came of one sweep. */
struct kith_ladder {
  const struct kith_sweep *sweep;
  int n; /* rungs */
  struct kith_point point[KITH_STRESS_METHODS][KITH_RUNGS];
  bool pass[KITH_STRESS_METHODS][KITH_RUNGS];
  double shown[KITH_STRESS_METHODS][KITH_RUNGS]; /* the metric as it is judged */
};
/* Judges the points of a ladder. */
void kith_ladder_judge(struct kith_ladder *ladder);
/* "to 0.6", "20 - 40, 90", "none", "all (1000)"; with names "6 of 8". */
void kith_ladder_answer(const struct kith_ladder *ladder, int method, char text[128]);
/* "density.l1 at most 0.05" */
void kith_sweep_gate_text(const struct kith_sweep *sweep, char text[160]);

/* Exit code: 0; 3 if a method does not even pass the first rung of a ladder; 1 if the results cannot be written; 2 for an unknown
 * sweep, or settings that no run takes. */
enum kith_exit kith_stress(const struct kith_options *options);

/* --- stress_page.c --- */
/* stress.html, stress.svg, stress.csv. */
kith_status kith_stress_write(int n, const struct kith_ladder *ladders, const char *directory);

#endif
