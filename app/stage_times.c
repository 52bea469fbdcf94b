#include "app/stage_times.h"

#include <string.h>

/* The paths of this rank's stages, each ended by 0. */
static kith_status join_paths(const struct kith_profile *profile, char **text, uint64_t *length,
                              uint64_t *n) {
  const struct kith_stage *stage;
  *n = (uint64_t)kith_profile_stages(profile, &stage);
  *length = 0;
  for (uint64_t s = 0; s < *n; ++s) *length += strlen(stage[s].path) + 1;
  KITH_TRY(kith_resize(text, 0, *length, 1));
  char *at = *text;
  for (uint64_t s = 0; s < *n; ++s) at = strcpy(at, stage[s].path) + strlen(stage[s].path) + 1;
  return KITH_OK;
}

static double seconds_of(const struct kith_profile *profile, const char *path) {
  const struct kith_stage *stage;
  const int n = kith_profile_stages(profile, &stage);
  for (int s = 0; s < n; ++s)
    if (strcmp(stage[s].path, path) == 0) return stage[s].seconds;
  return 0;
}

static void measure(struct kith_ranks *ranks, const struct kith_profile *profile, const char *path,
                    struct kith_stage_times *t) {
  for (int s = 0; s < t->n; ++s, path += strlen(path) + 1)
    t->least[s] = t->mean[s] = t->most[s] = seconds_of(profile, path);
  kith_ranks_min(ranks, t->least, t->n);
  kith_ranks_sum(ranks, t->mean, t->n);
  kith_ranks_max(ranks, t->most, t->n);
  for (int s = 0; s < t->n; ++s) t->mean[s] /= kith_ranks_size(ranks);
}

kith_status kith_stage_times(struct kith_ranks *ranks, const struct kith_profile *profile,
                             struct kith_stage_times *out) {
  char *text = NULL;
  uint64_t size[2]; /* letters, stages */
  *out = (struct kith_stage_times){0};
  if (ranks == NULL) return KITH_OK;
  KITH_TRY(kith_ranks_agree(ranks, join_paths(profile, &text, &size[0], &size[1])));
  kith_ranks_broadcast(ranks, 0, size, sizeof size);
  out->n = (int)size[1];
  kith_status status = KITH_OK;
  if (kith_ranks_rank(ranks) != 0) status = kith_resize(&text, 0, size[0], 1);
  if (status == KITH_OK) status = kith_resize(&out->least, 0, size[1], sizeof *out->least);
  if (status == KITH_OK) status = kith_resize(&out->mean, 0, size[1], sizeof *out->mean);
  if (status == KITH_OK) status = kith_resize(&out->most, 0, size[1], sizeof *out->most);
  status = kith_ranks_agree(ranks, status);
  if (status == KITH_OK) kith_ranks_broadcast(ranks, 0, text, size[0]);
  if (status == KITH_OK) measure(ranks, profile, text, out);
  kith_free(&text);
  return status;
}

void kith_stage_times_clear(struct kith_stage_times *times) {
  kith_free(&times->least);
  kith_free(&times->mean);
  kith_free(&times->most);
  times->n = 0;
}

void kith_stage_times_print(const struct kith_stage_times *times, const struct kith_profile *profile,
                            FILE *out) {
  enum { WIDTH = 36 };
  const struct kith_stage *stage;
  const int n = KITH_MIN(kith_profile_stages(profile, &stage), times->n);
  double root = 0;
  fprintf(out, "\n%-*s %9s %11s %11s %11s %9s %7s\n", WIDTH, "stage, seconds of all ranks", "calls", "least",
          "mean", "most", "most/mean", "share");
  for (int s = 0; s < n; ++s) {
    const int indent = KITH_MIN(2 * stage[s].depth, WIDTH - 8), room = WIDTH - indent;
    const double mean = times->mean[s];
    if (stage[s].depth == 0) root = mean;
    fprintf(out, "%*s%-*.*s %9llu %11.6f %11.6f %11.6f %9.2f %6.1f%%\n", indent, "", room, room,
            stage[s].name, (unsigned long long)stage[s].calls, times->least[s], mean, times->most[s],
            mean > 0 ? times->most[s] / mean : 1, root > 0 ? 100 * mean / root : 0);
  }
}
