/* test_expression.c - formulas of scenes: values (against C, and against the table of the manual), which
 * formulas are constant, and what is refused. */
#include <stdio.h>
#include <string.h>
#include "app/scene/expression.h"
#include "tests/check.h"

static const double position[3] = {0.3, -0.4, 1.2};
static int dimension = 1;

static double value_of(const char *formula) {
  struct kith_expression *f = NULL;
  double value = NAN;
  CHECK_OK(kith_expression_create(&f, formula));
  if (f) CHECK_OK(kith_expression_at(f, dimension, position, &value));
  kith_expression_destroy(&f);
  CHECK(!f);
  return value;
}

static void values(void) {
  const double y = dimension > 1 ? position[1] : 0, z = dimension > 2 ? position[2] : 0;
  const double r = sqrt(position[0] * position[0] + y * y + z * z);
  CHECK(value_of("1.25") == 1.25);
  CHECK(value_of("-1e-6") == -1e-6);
  CHECK(value_of("x") == position[0]);
  CHECK(value_of("y") == y); /* 0 in 1-D */
  CHECK(value_of("z") == z);
  CHECK_CLOSE(value_of("r"), r, 1e-15); /* one rounding of a value near 1 */
  /* tolerance: a few roundings */
  CHECK_CLOSE(value_of("sin(2*pi*x) + e^y"), sin(2 * acos(-1.0) * position[0]) + exp(y), 4e-15);
  CHECK(value_of("x < 0.5 ? 2 : 3") == 2);
  CHECK(value_of("x == 0.3 && y <= 0 && z != 7") == 1);
  CHECK(value_of("1 +\n 2") == 3);
  CHECK(value_of("sqrt(4) + min(1, 2) + abs(-3)") == 6);
}

static void refuses(const char *formula, const char *reason) {
  struct kith_expression *f = NULL;
  CHECK_STATUS(KITH_BAD_INPUT, kith_expression_create(&f, formula));
  CHECK(!f);
  CHECK(check_says(reason));
  CHECK(!strchr(kith_failure(), '\n'));
  kith_expression_destroy(&f);
}

static void refused_formulas(void) {
  refuses("", "formula");
  refuses("1 +", "formula");
  refuses("1 + * 2", "position");
  refuses("q + 1", "q");
  refuses("sin(x", "formula");
  refuses("1, 2", "2 values");
  refuses("x = 3", "==");
  refuses("y +=\n 3", "==");
  refuses("vx", "vx");
  refuses("2*X", "Did you mean 'x'?");
  refuses("sin x", "sin(x)");
  refuses("1 + sqrt", "sqrt(x)");
}

static void not_finite(void) {
  struct kith_expression *f = NULL;
  const double zero[3] = {0, 0, 0}, one[3] = {1, 0, 0};
  double value;
  CHECK_OK(kith_expression_create(&f, "-x/r"));
  CHECK_STATUS(KITH_BAD_INPUT, kith_expression_at(f, 3, zero, &value));
  CHECK_OK(kith_expression_at(f, 3, one, &value)); /* a failure has no later effect */
  CHECK(value == -1);
  kith_expression_destroy(&f);
}

static bool constant(const char *formula) {
  struct kith_expression *f = NULL;
  CHECK_OK(kith_expression_create(&f, formula));
  const bool is = f && !isnan(kith_expression_constant(f));
  kith_expression_destroy(&f);
  return is;
}

static void constants(void) {
  CHECK(constant("1"));
  CHECK(constant("2*pi + e"));
  CHECK(!constant("x"));
  CHECK(!constant("1 + 0*r"));
}

/* Two formulas have variables of their own. */
static void separate_variables(void) {
  struct kith_expression *f = NULL, *g = NULL;
  const double here[3] = {1, 0, 0}, there[3] = {2, 0, 0};
  double a = 0, b = 0;
  CHECK_OK(kith_expression_create(&f, "x"));
  CHECK_OK(kith_expression_create(&g, "10*x"));
  CHECK_OK(kith_expression_at(f, 3, here, &a));
  CHECK_OK(kith_expression_at(g, 3, there, &b));
  CHECK(a == 1 && b == 20);
  CHECK_OK(kith_expression_at(f, 3, there, &a));
  CHECK(a == 2);
  kith_expression_destroy(&f);
  kith_expression_destroy(&g);
}

/* The rows `| \`formula\` | value |` of the manual, evaluated at (1, 2, 3). */
static void manual_table(void) {
  const double at[3] = {1, 2, 3};
  char line[256], formula[128];
  double value, printed;
  int n = 0;
  FILE *file = fopen(KITH_MANUAL "/scene.md", "r");
  CHECK(file != NULL);
  while (file != NULL && fgets(line, sizeof line, file) != NULL) {
    struct kith_expression *f = NULL;
    if (sscanf(line, "| `%127[^`]` | %lf |", formula, &printed) != 2) continue;
    CHECK_OK(kith_expression_create(&f, formula));
    if (f != NULL) CHECK_OK(kith_expression_at(f, 3, at, &value));
    if (f == NULL || fabs(value - printed) > 1e-15 * fabs(printed)) {
      fprintf(stderr, "%s is %.17g\n", formula, value);
      ++check_failures;
    }
    kith_expression_destroy(&f);
    ++n;
  }
  CHECK(n > 20);
  if (file != NULL) fclose(file);
}

int main(void) {
  for (; dimension <= 3; ++dimension) values();
  manual_table();
  refused_formulas();
  not_finite();
  constants();
  separate_variables();
  struct kith_expression *none = NULL;
  kith_expression_destroy(&none);
  return check_failed();
}
