#include "app/forms.h"

#include <math.h>
#include <omp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include "app/matrix.h"
#include "app/symmetry.h"
#include "app/text.h"

struct form {
  char name[64];
  const char *gives_up;
  bool exact; /* gives up nothing */
  int dimension, n;
  char setting[16][192]; /* key=value */
  double seconds;
};
enum { MOST_FORMS = 8 };

struct forms {
  const struct kith_options *options;
  const struct kith_model *model;
  int n;
  struct form form[MOST_FORMS];
};

__attribute__((format(printf, 2, 3))) static void set(struct form *form, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(form->setting[form->n], sizeof form->setting[0], format, arguments);
  va_end(arguments);
  ++form->n;
}

static struct form *add(struct forms *forms, const char *name, bool exact, const char *gives_up) {
  struct form *form = &forms->form[forms->n++];
  *form = (struct form){.gives_up = gives_up, .exact = exact, .dimension = NDIM};
  snprintf(form->name, sizeof form->name, "%s", name);
  return form;
}

/* ---- which forms there are ---- */

static void fewer_dimensions(struct forms *forms, const struct kith_symmetry *symmetry) {
  if (symmetry->dimension == NDIM) return;
  for (int a = symmetry->dimension; a < NDIM; ++a) { /* what is dropped must go on for ever */
    const struct kith_boundary_ops *lower = forms->model->scene->boundary[a].lower;
    if (lower != forms->model->scene->boundary[a].upper) return;
    if (lower != &kith_boundary_periodic && lower != &kith_boundary_reflecting) return;
  }
  struct form *form =
      add(forms, symmetry->dimension == 1 ? "in 1-D" : "in 2-D", false,
          "whatever would break the symmetry: noise, shear, instabilities; keep one run in full");
  form->dimension = symmetry->dimension;
  set(form, "dimension=%d", symmetry->dimension);
  if (forms->model->scene->method.neighbors > 0) set(form, "method.neighbors=");
}

/* Forces from outside and frozen nodes are no part of the state that a symmetry was found in. */
static bool undisturbed(const struct forms *forms) {
  const struct kith_scene *scene = forms->model->scene;
  bool frozen = false;
  for (int k = 0; k < scene->n_regions; ++k)
    frozen = frozen || scene->region[k].frozen || scene->region[k].barrier;
  return !frozen && !kith_body_acts(&forms->model->hydro.body);
}

/* A mirrored state whose axis has boundaries that go on through mirrors. */
static bool foldable(const struct kith_scene *scene, const struct kith_symmetry *symmetry, int axis) {
  const struct kith_boundary_ops *lower = scene->boundary[axis].lower, *upper = scene->boundary[axis].upper;
  return symmetry->mirrored[axis] && axis < symmetry->dimension && lower == upper;
}

static void vector(struct form *form, const char *key, const double *v) {
  char text[128] = "";
  for (int a = 0; a < NDIM; ++a)
    snprintf(text + strlen(text), sizeof text - strlen(text), "%s%.10g", a > 0 ? "," : "", v[a]);
  set(form, "%s=[%s]", key, text);
}

static void mirrors(struct forms *forms, const struct kith_symmetry *symmetry) {
  static const char *const name[] = {"half, through a mirror", "quarter, through mirrors",
                                     "octant, through mirrors"};
  const struct kith_scene *scene = forms->model->scene;
  struct kith_box box = scene->domain;
  int folds = 0;
  for (int a = 0; a < NDIM; ++a)
    if (foldable(scene, symmetry, a)) box.lower[a] = 0.5 * (box.lower[a] + box.upper[a]), ++folds;
  if (folds == 0 || scene->n_deposits > 1) return;
  struct form *form =
      add(forms, name[folds - 1], true, "nothing, as long as the flow is its own mirror image");
  vector(form, "domain.lower", box.lower);
  vector(form, "domain.upper", box.upper);
  set(form, "domain.across=");
  for (int a = 0; a < NDIM; ++a)
    if (foldable(scene, symmetry, a))
      set(form, "boundaries.%c=%s", "xyz"[a],
          scene -> boundary[a].lower != NULL ? "reflecting" : "[reflecting, open]");
  if (scene->n_deposits == 1) set(form, "energy.energy=%.17g", ldexp(scene->deposit->energy, -folds));
}

static void settings(struct forms *forms) {
  const struct kith_package *package = &forms->model->package;
  const struct kith_requirements *built = &forms->model->connectivity->built;
  if (!kith_rebuilds_lasting(&forms->model->rebuilds)) {
    struct form *form = add(forms, "lists that last", true, "nothing but round-off");
    set(form, "connectivity.rebuild=displacement");
    set(form, "connectivity.skin=0.1");
  }
  if (built->overlap && package->faces == KITH_FACES_INTEGRATED)
    set(add(forms, "one-point faces", false, "order on disordered nodes; no overlap, no ghost rows"),
        "method.faces=one-point");
  if (NDIM > 1) {
    const int fewer = (int)round(2 * package->neighbors / 3);
    char name[32];
    snprintf(name, sizeof name, "%d neighbors", fewer);
    set(add(forms, name, false, "quiet: kernel sums see the lattice; chart it"), "method.neighbors=%d",
        fewer);
  }
  if (package->compatible)
    set(add(forms, "thermal energy", false, "energy to round-off: it drifts with the time step"),
        "method.energy=thermal");
}

/* Saves, and gives up nothing. */
static bool welcome(const struct form *form, double seconds) {
  return form->exact && form->seconds < seconds;
}

/* All that are welcome, if there is more than one. */
static void together(struct forms *forms, double seconds) {
  const int n = forms->n;
  int many = 0;
  for (int k = 0; k < n; ++k) many += welcome(&forms->form[k], seconds);
  if (many < 2) return;
  struct form *all = add(forms, "all that give up nothing", true, "nothing");
  for (int k = 0; k < n; ++k)
    for (int s = 0; welcome(&forms->form[k], seconds) && s < forms->form[k].n; ++s)
      set(all, "%s", forms->form[k].setting[s]);
}

/* ---- what they cost ---- */

/* The scene's own settings first, then those of the form. */
static kith_status plan_form(const struct forms *forms, struct form *form,
                             const struct kith_programs *programs, double until) {
  const struct kith_options *o = forms->options;
  struct kith_job job = {.scene = o->subject, .dimension = form->dimension};
  char text[KITH_JOB_SETTING], why[256];
  int code;
  for (int k = 0; k < o->n_overrides + form->n; ++k) {
    const char *setting = k < o->n_overrides ? o->overrides[k] : form->setting[k - o->n_overrides];
    if ((size_t)snprintf(text, sizeof text, "%s", setting) >= sizeof text)
      KITH_FAIL(BAD_INPUT, "--set %.30s... is too long to plan forms with", setting);
    char *value = strchr(text, '=');
    *value = '\0';
    KITH_TRY(kith_job_set(&job, text, value + 1));
  }
  snprintf(text, sizeof text, "%.17g", until);
  KITH_TRY(kith_job_set(&job, "until", text));
  return kith_job_plan(programs, omp_get_max_threads(), &job, &code, &form->seconds, why);
}

static void print_form(const struct form *form, double seconds) {
  char time[32], label[128], text[256], words[1024] = "";
  snprintf(label, sizeof label, "    %-26s%10s%8.2g", form->name, kith_text_seconds(time, form->seconds),
           form->seconds / seconds);
  snprintf(text, sizeof text, "%s", form->gives_up);
  kith_text_wrapped(stdout, 52, label, text);
  for (int k = 0; k < form->n; ++k)
    snprintf(words + strlen(words), sizeof words - strlen(words), "%s--set %s%s%s", k > 0 ? " " : "",
             strpbrk(form->setting[k], " []") != NULL ? "'" : "", form->setting[k],
             strpbrk(form->setting[k], " []") != NULL ? "'" : "");
  kith_text_wrapped(stdout, 6, "", words);
}

kith_status kith_forms_show(const struct kith_options *options, const struct kith_model *model, double until,
                            double seconds) {
  struct forms forms = {.options = options, .model = model};
  struct kith_symmetry symmetry;
  struct kith_programs programs;
  KITH_TRY(kith_symmetry_find(&symmetry, &model->hydro, &model->scene->domain));
  if (undisturbed(&forms)) {
    fewer_dimensions(&forms, &symmetry);
    mirrors(&forms, &symmetry);
  }
  settings(&forms);
  (void)kith_programs_find(&programs); /* they stand beside this one; the scenes are not needed */
  printf("\n  %-28s%10s%8s  %s\n", "cheaper forms", "cost", "ratio", "what each gives up");
  const int single = forms.n;
  for (int k = 0; k < forms.n; ++k) {
    KITH_TRY(plan_form(&forms, &forms.form[k], &programs, until));
    if (isfinite(forms.form[k].seconds)) print_form(&forms.form[k], seconds);
    if (k == single - 1) together(&forms, seconds);
  }
  return KITH_OK;
}
