/* Writing a tree as YAML: the way back, through libyaml's emitter. */
#include <stdio.h>
#include <string.h>
#include <yaml.h>
#include "app/scene/config.h"

static bool emit(yaml_emitter_t *emitter, yaml_event_t *event, int made) {
  return made && yaml_emitter_emit(emitter, event);
}

static bool emit_text(yaml_emitter_t *emitter, const char *text, bool quoted) {
  yaml_event_t event;
  return emit(
      emitter, &event,
      yaml_scalar_event_initialize(&event, NULL, NULL, (const yaml_char_t *)text, (int)strlen(text), 1, 1,
                                   quoted ? YAML_SINGLE_QUOTED_SCALAR_STYLE : YAML_PLAIN_SCALAR_STYLE));
}

/* Lists of numbers and words stay on one line. */
static bool flat(const struct kith_config_node *node) {
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next)
    if (child->kind != KITH_CONFIG_SCALAR) return false;
  return true;
}

static bool emit_node(yaml_emitter_t *emitter, const struct kith_config_node *node) {
  yaml_event_t event;
  if (node->kind == KITH_CONFIG_SCALAR)
    return emit_text(emitter, node->null ? "null" : node->text, node->quoted);
  const bool map = node->kind == KITH_CONFIG_MAP;
  const int made =
      map ? yaml_mapping_start_event_initialize(&event, NULL, NULL, 1, YAML_BLOCK_MAPPING_STYLE)
          : yaml_sequence_start_event_initialize(
                &event, NULL, NULL, 1, flat(node) ? YAML_FLOW_SEQUENCE_STYLE : YAML_BLOCK_SEQUENCE_STYLE);
  if (!emit(emitter, &event, made)) return false;
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next) {
    if (map && !emit_text(emitter, child->key, false)) return false;
    if (!emit_node(emitter, child)) return false;
  }
  return emit(emitter, &event,
              map ? yaml_mapping_end_event_initialize(&event) : yaml_sequence_end_event_initialize(&event));
}

static bool emit_all(yaml_emitter_t *emitter, const struct kith_config_node *root) {
  yaml_event_t e;
  return emit(emitter, &e, yaml_stream_start_event_initialize(&e, YAML_UTF8_ENCODING)) &&
         emit(emitter, &e, yaml_document_start_event_initialize(&e, NULL, NULL, NULL, 1)) &&
         emit_node(emitter, root) && emit(emitter, &e, yaml_document_end_event_initialize(&e, 1)) &&
         emit(emitter, &e, yaml_stream_end_event_initialize(&e)) && yaml_emitter_flush(emitter);
}

kith_status kith_config_emit(const struct kith_config *config, char **text) {
  yaml_emitter_t emitter;
  size_t length;
  *text = NULL;
  FILE *file = open_memstream(text, &length);
  if (file == NULL) KITH_FAIL(NO_MEMORY, "no memory for the effective scene");
  bool done = yaml_emitter_initialize(&emitter);
  if (done) {
    yaml_emitter_set_output_file(&emitter, file);
    yaml_emitter_set_unicode(&emitter, 1);
    yaml_emitter_set_width(&emitter, -1);
    done = emit_all(&emitter, config->root);
    yaml_emitter_delete(&emitter);
  }
  if (fclose(file) == 0 && done) return KITH_OK;
  kith_free(text);
  KITH_FAIL(INTERNAL, "the effective scene cannot be written as YAML");
}
