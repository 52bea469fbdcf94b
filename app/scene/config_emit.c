/* Writing a tree as YAML: the way back, through libyaml's documents. */
#include <stdio.h>
#include <string.h>
#include <yaml.h>
#include "app/scene/config.h"

static int add_text(yaml_document_t *document, const char *text, bool quoted) {
  return yaml_document_add_scalar(document, NULL, (const yaml_char_t *)text, (int)strlen(text),
                                  quoted ? YAML_SINGLE_QUOTED_SCALAR_STYLE : YAML_PLAIN_SCALAR_STYLE);
}

/* Lists of numbers and words stay on one line. */
static bool flat(const struct kith_config_node *node) {
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next)
    if (child->kind != KITH_CONFIG_SCALAR) return false;
  return true;
}

/* Its number in the document; 0: no memory. */
static int add_node(yaml_document_t *document, const struct kith_config_node *node) {
  const bool map = node->kind == KITH_CONFIG_MAP;
  if (node->kind == KITH_CONFIG_SCALAR)
    return add_text(document, node->null ? "null" : node->text, node->quoted);
  const int id = map ? yaml_document_add_mapping(document, NULL, YAML_BLOCK_MAPPING_STYLE)
                     : yaml_document_add_sequence(
                           document, NULL, flat(node) ? YAML_FLOW_SEQUENCE_STYLE : YAML_BLOCK_SEQUENCE_STYLE);
  for (const struct kith_config_node *child = node->first; id != 0 && child != NULL; child = child->next) {
    const int key = map ? add_text(document, child->key, false) : id, value = add_node(document, child);
    if (key == 0 || value == 0) return 0;
    if (!(map ? yaml_document_append_mapping_pair(document, id, key, value)
              : yaml_document_append_sequence_item(document, id, value)))
      return 0;
  }
  return id;
}

static bool emit(const struct kith_config_node *root, FILE *file) {
  yaml_emitter_t emitter;
  yaml_document_t document;
  if (!yaml_emitter_initialize(&emitter)) return false;
  yaml_emitter_set_output_file(&emitter, file);
  yaml_emitter_set_unicode(&emitter, 1);
  yaml_emitter_set_width(&emitter, -1);
  bool done = yaml_document_initialize(&document, NULL, NULL, NULL, 1, 1);
  if (done && add_node(&document, root) == 0) yaml_document_delete(&document), done = false;
  done = done && yaml_emitter_dump(&emitter, &document) && yaml_emitter_close(&emitter);
  yaml_emitter_delete(&emitter);
  return done;
}

kith_status kith_config_emit(const struct kith_config *config, char **text) {
  size_t length;
  *text = NULL;
  FILE *file = open_memstream(text, &length);
  if (file == NULL) KITH_FAIL(NO_MEMORY, "no memory for the effective scene");
  const bool done = emit(config->root, file);
  if (fclose(file) == 0 && done) return KITH_OK;
  kith_free(text);
  KITH_FAIL(INTERNAL, "the effective scene cannot be written as YAML");
}
