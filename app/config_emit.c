/* Writing a tree as YAML: the way back, through libyaml's emitter. */
#include <string.h>
#include <yaml.h>
#include "app/config.h"

struct sink {
  char *text;
  size_t length, capacity;
  kith_status status;
};

static int sink_write(void *data, unsigned char *bytes, size_t size) {
  struct sink *sink = data;
  if (sink->length + size + 1 > sink->capacity) {
    const size_t capacity = 2 * (sink->length + size + 1);
    sink->status = kith_resize(&sink->text, sink->length, capacity, 1);
    if (sink->status != KITH_OK) return 0;
    sink->capacity = capacity;
  }
  memcpy(sink->text + sink->length, bytes, size);
  sink->length += size;
  sink->text[sink->length] = '\0';
  return 1;
}

static bool emit_text(yaml_emitter_t *emitter, const char *text, bool quoted) {
  yaml_event_t event;
  return yaml_scalar_event_initialize(&event, NULL, NULL, (const yaml_char_t *)text, (int)strlen(text), 1, 1,
                                      quoted ? YAML_SINGLE_QUOTED_SCALAR_STYLE : YAML_PLAIN_SCALAR_STYLE) &&
         yaml_emitter_emit(emitter, &event);
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
  if (!made || !yaml_emitter_emit(emitter, &event)) return false;
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next) {
    if (map && !emit_text(emitter, child->key, false)) return false;
    if (!emit_node(emitter, child)) return false;
  }
  return (map ? yaml_mapping_end_event_initialize(&event) : yaml_sequence_end_event_initialize(&event)) &&
         yaml_emitter_emit(emitter, &event);
}

static bool emit_all(yaml_emitter_t *emitter, const struct kith_config_node *root) {
  yaml_event_t event;
  return yaml_stream_start_event_initialize(&event, YAML_UTF8_ENCODING) &&
         yaml_emitter_emit(emitter, &event) &&
         yaml_document_start_event_initialize(&event, NULL, NULL, NULL, 1) &&
         yaml_emitter_emit(emitter, &event) && emit_node(emitter, root) &&
         yaml_document_end_event_initialize(&event, 1) && yaml_emitter_emit(emitter, &event) &&
         yaml_stream_end_event_initialize(&event) && yaml_emitter_emit(emitter, &event);
}

kith_status kith_config_emit(const struct kith_config *config, char **text) {
  *text = NULL;
  yaml_emitter_t emitter;
  struct sink sink = {0};
  if (!yaml_emitter_initialize(&emitter)) KITH_FAIL(NO_MEMORY, "no memory for a YAML emitter");
  yaml_emitter_set_output(&emitter, sink_write, &sink);
  yaml_emitter_set_unicode(&emitter, 1);
  yaml_emitter_set_width(&emitter, -1);
  const bool done = emit_all(&emitter, config->root);
  yaml_emitter_delete(&emitter);
  if (!done) {
    kith_free(&sink.text);
    KITH_TRY(sink.status);
    KITH_FAIL(INTERNAL, "the effective scene cannot be written as YAML");
  }
  *text = sink.text;
  return KITH_OK;
}
