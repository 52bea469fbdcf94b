/* checkpoint_file.c - a checkpoint in memory: its creation, its end, its sections. */
#include "lib/io/checkpoint_file.h"

void kith_checkpoint_file_destroy(struct kith_checkpoint **c) {
  if (*c == NULL) return;
  kith_atomic_file_abandon(&(*c)->out);
  if ((*c)->in != NULL) fclose((*c)->in);
  kith_free(&(*c)->path);
  kith_free(&(*c)->scene);
  kith_free(&(*c)->section);
  kith_free(c);
}

kith_status kith_checkpoint_file_create(struct kith_checkpoint **out, const char *path) {
  struct kith_checkpoint *c = NULL;
  *out = NULL;
  KITH_TRY(kith_resize(&c, 0, 1, sizeof *c));
  const kith_status status = kith_resize(&c->path, 0, strlen(path) + 1, 1);
  if (status == KITH_OK)
    strcpy(c->path, path);
  else
    kith_checkpoint_file_destroy(&c);
  *out = c;
  return status;
}

struct section *kith_checkpoint_file_find(const struct kith_checkpoint *c, enum group group,
                                          const char *name) {
  for (uint32_t s = 0; s < c->header.sections; ++s)
    if (c->section[s].group == group && strcmp(c->section[s].name, name) == 0) return &c->section[s];
  return NULL;
}
