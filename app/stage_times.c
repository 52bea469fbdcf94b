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

static void measure(struct kith_ranks *ranks, const struct kith_profile *profile, const char *path, int n,
                    double *mean, double *most) {
  for (int s = 0; s < n; ++s, path += strlen(path) + 1) mean[s] = most[s] = seconds_of(profile, path);
  kith_ranks_sum(ranks, mean, n);
  kith_ranks_max(ranks, most, n);
  for (int s = 0; s < n; ++s) mean[s] /= kith_ranks_size(ranks);
}

kith_status kith_stage_times(struct kith_ranks *ranks, const struct kith_profile *profile, double **mean,
                             double **most) {
  char *text = NULL;
  uint64_t size[2]; /* letters, stages */
  if (ranks == NULL) return KITH_OK;
  KITH_TRY(kith_ranks_agree(ranks, join_paths(profile, &text, &size[0], &size[1])));
  kith_ranks_broadcast(ranks, 0, size, sizeof size);
  kith_status status = KITH_OK;
  if (kith_ranks_rank(ranks) != 0) status = kith_resize(&text, 0, size[0], 1);
  if (status == KITH_OK) status = kith_resize(mean, 0, size[1], sizeof **mean);
  if (status == KITH_OK) status = kith_resize(most, 0, size[1], sizeof **most);
  status = kith_ranks_agree(ranks, status);
  if (status == KITH_OK) kith_ranks_broadcast(ranks, 0, text, size[0]);
  if (status == KITH_OK) measure(ranks, profile, text, (int)size[1], *mean, *most);
  kith_free(&text);
  return status;
}
