/* expression.c - formulas of a scene by muParser. */
#include "app/scene/expression.h"

#include <math.h>
#include <muParserDLL.h>
#include <stdio.h>
#include <string.h>
#include "lib/core/choices.h"

struct kith_expression {
  muParserHandle_t parser; /* owned */
  char *formula;           /* owned, on one line */
  muFloat_t x[3], r, t;    /* the parser's variables point here */
  bool constant, timed;    /* it has no variables; it has t */
};

/* Refuses with the parser's message; for what it does not know, with what a formula may have. */
static kith_status refused(const struct kith_expression *self) {
  static const char words[] =
      "x|y|z|r|pi|e|sin|cos|tan|asin|acos|atan|atan2|sinh|cosh|tanh|asinh|acosh|atanh|exp|"
      "ln|log|log2|log10|sqrt|abs|sign|rint|min|max|sum|avg";
  char message[256], near[16], all[256];
  snprintf(message, sizeof message, "%s", mupGetErrorMsg(self->parser)); /* the token takes its place */
  if (strstr(message, "Unexpected token") == NULL && strstr(message, "Unexpected operator") == NULL)
    KITH_FAIL(BAD_INPUT, "formula '%s': %s", self->formula, message);
  const char *token = mupGetErrorToken(self->parser);
  if (kith_choices_index(words, token) >= 0) /* only a function without its parenthesis is not expected */
    KITH_FAIL(BAD_INPUT, "formula '%s': the argument of %s needs parentheses: %s(x)", self->formula, token,
              token);
  if (kith_choices_suggest(words, token, near, sizeof near))
    KITH_FAIL(BAD_INPUT, "formula '%s': %s Did you mean '%s'?", self->formula, message, near);
  kith_choices_format(words, all, sizeof all);
  KITH_FAIL(BAD_INPUT,
            "formula '%s': %s It may have numbers without units, + - * / ^ < <= > >= == != && || ? : (), %s",
            self->formula, message, all);
}

/* Refuses `x = 0`, which the parser would take as an assignment of value 0: always a slip for `==`. */
static kith_status no_assignment(const struct kith_expression *self) {
  const char *f = self->formula;
  for (size_t i = 0; f[i]; ++i) {
    if (f[i] != '=') continue;
    if (f[i + 1] == '=')
      ++i;
    else if (i == 0 || !strchr("<>!", f[i - 1]))
      KITH_FAIL(BAD_INPUT, "formula '%s': assignment at position %zu; did you mean '=='?", f, i);
  }
  return KITH_OK;
}

/* Evaluates the formula once, since the parser reads it then; the value does not matter here. */
static kith_status parse(struct kith_expression *self) {
  KITH_TRY(no_assignment(self));
  mupSetExpr(self->parser, self->formula);
  if (mupError(self->parser)) return refused(self);
  int values = 1;
  mupEvalMulti(self->parser, &values);
  if (mupError(self->parser)) return refused(self);
  if (values != 1) KITH_FAIL(BAD_INPUT, "formula '%s': %d values, wanted one", self->formula, values);
  const int variables = mupGetExprVarNum(self->parser);
  self->constant = variables == 0;
  for (int k = 0; k < variables; ++k) {
    const muChar_t *name;
    muFloat_t *place;
    mupGetExprVar(self->parser, (unsigned)k, &name, &place);
    self->timed |= place == &self->t;
  }
  return KITH_OK;
}

static kith_status build(struct kith_expression *self, const char *formula) {
  static const char *const names[] = {"x", "y", "z"};
  const size_t length = strlen(formula);
  KITH_TRY(kith_resize(&self->formula, 0, length + 1, 1));
  for (size_t i = 0; i < length; ++i)
    self->formula[i] = formula[i] == '\n' || formula[i] == '\r' ? ' ' : formula[i];
  self->parser = mupCreate(muBASETYPE_FLOAT);
  if (!self->parser) KITH_FAIL(NO_MEMORY, "formula '%s': no parser", self->formula);
  for (int a = 0; a < 3; ++a) mupDefineVar(self->parser, names[a], &self->x[a]);
  mupDefineVar(self->parser, "r", &self->r);
  mupDefineVar(self->parser, "t", &self->t);
  mupDefineConst(self->parser, "pi", 3.14159265358979323846);
  mupDefineConst(self->parser, "e", 2.71828182845904523536);
  return parse(self);
}

kith_status kith_expression_create(struct kith_expression **out, const char *formula) {
  *out = NULL;
  KITH_TRY(kith_resize(out, 0, 1, sizeof **out));
  const kith_status status = build(*out, formula);
  if (status != KITH_OK) kith_expression_destroy(out);
  return status;
}

void kith_expression_destroy(struct kith_expression **expression) {
  struct kith_expression *self = *expression;
  if (!self) return;
  if (self->parser) mupRelease(self->parser);
  kith_free(&self->formula);
  kith_free(expression);
}

void kith_expression_time(struct kith_expression *self, double time) {
  if (self != NULL) self->t = time;
}

kith_status kith_expression_at(struct kith_expression *self, int n, const double *x, double *value) {
  double r2 = 0;
  for (int a = 0; a < n; ++a) {
    self->x[a] = x[a];
    r2 += x[a] * x[a];
  }
  self->r = sqrt(r2);
  *value = mupEval(self->parser);
  if (mupError(self->parser)) {
    const kith_status status = refused(self);
    mupErrorReset(self->parser);
    return status;
  }
  if (!isfinite(*value))
    KITH_FAIL(BAD_INPUT, "formula '%s' is %g at (%g, %g, %g)", self->formula, *value, self->x[0], self->x[1],
              self->x[2]);
  return KITH_OK;
}

bool kith_expression_is_timed(const struct kith_expression *self) {
  return self != NULL && self->timed;
}

double kith_expression_constant(struct kith_expression *self) {
  double value = NAN;
  if (self == NULL || !self->constant) return NAN;
  return kith_expression_at(self, 0, NULL, &value) == KITH_OK ? value : NAN;
}
