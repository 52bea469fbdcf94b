/* kith.c - the program `kith`: starts the program of the scene's dimension, kith-1d, kith-2d or kith-3d.
 *
 * The dimension is that of the last --set dimension=N, else of the scene's key `dimension`. If there is none
 * that can be used, kith-1d is started: its reader of scenes has the message for that. Nothing is judged
 * here. */
#include <getopt.h>
#include <limits.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <yaml.h>

/* 1, 2 or 3; 0 for anything else. */
static int dimension_of(const char *text) {
  char *end;
  const long dimension = strtol(text, &end, 10);
  end += strspn(end, " ");
  return end != text && *end == '\0' && dimension >= 1 && dimension <= 3 ? (int)dimension : 0;
}

static const char *scalar(yaml_document_t *document, int id) {
  const yaml_node_t *node = yaml_document_get_node(document, id);
  return node != NULL && node->type == YAML_SCALAR_NODE ? (const char *)node->data.scalar.value : "";
}

/* The text at a key of the root, "" if there is none. View. */
static const char *value_of(yaml_document_t *document, const char *key) {
  const yaml_node_t *root = yaml_document_get_root_node(document);
  if (root == NULL || root->type != YAML_MAPPING_NODE) return "";
  const yaml_node_pair_t *pair = root->data.mapping.pairs.start;
  for (; pair < root->data.mapping.pairs.top; ++pair)
    if (strcmp(scalar(document, pair->key), key) == 0) return scalar(document, pair->value);
  return "";
}

static int file_dimension(const char *path, int deep);

/* Its own, else that of its base, which is found from its folder. */
static int document_dimension(yaml_document_t *document, const char *path, int deep) {
  const char *own = value_of(document, "dimension"), *base = value_of(document, "base");
  if (own[0] != '\0' || base[0] == '\0' || deep > 8) return dimension_of(own);
  char of_base[PATH_MAX];
  const char *slash = strrchr(path, '/');
  const int folder = slash != NULL && base[0] != '/' ? (int)(slash + 1 - path) : 0;
  snprintf(of_base, sizeof of_base, "%.*s%s", folder, path, base);
  return file_dimension(of_base, deep + 1);
}

static int file_dimension(const char *path, int deep) {
  FILE *file = fopen(path, "r");
  yaml_parser_t parser;
  yaml_document_t document;
  int dimension = 0;
  if (file == NULL) return 0;
  if (yaml_parser_initialize(&parser)) {
    yaml_parser_set_input_file(&parser, file);
    if (yaml_parser_load(&parser, &document)) {
      dimension = document_dimension(&document, path, deep);
      yaml_document_delete(&document);
    }
    yaml_parser_delete(&parser);
  }
  fclose(file);
  return dimension;
}

/* The dimension that the arguments behind the verb ask for. Here it only matters which options take a value.
 */
static int scene_dimension(int argc, char **argv) {
  static const struct option options[] = {
      {"set", required_argument, NULL, 's'},     {"output", required_argument, NULL, 'o'},
      {"ranks", required_argument, NULL, 'v'},   {"network", required_argument, NULL, 'v'},
      {"threads", required_argument, NULL, 'v'}, {"until", required_argument, NULL, 'v'},
      {"steps", required_argument, NULL, 'v'},   {"restart", required_argument, NULL, 'v'},
      {"trace", required_argument, NULL, 'v'},   {NULL, 0, NULL, 0},
  };
  static const char key[] = "dimension=";
  const char *set = NULL, *scene = NULL;
  opterr = 0;
  /* The leading '-' gives arguments in order, as option 1, and leaves argv as it is. */
  for (int option; (option = getopt_long(argc, argv, "-o:", options, NULL)) != -1;) {
    if (option == 's' && strncmp(optarg, key, strlen(key)) == 0) set = optarg + strlen(key);
    if (option == 1 && scene == NULL) scene = optarg;
  }
  if (scene == NULL && optind < argc) scene = argv[optind]; /* behind "--" */
  if (set != NULL) return dimension_of(set);
  return scene != NULL ? file_dimension(scene, 0) : 0;
}

static int program_dimension(int argc, char **argv) {
  if (argc < 2) return 3;
  if (strcmp(argv[1], "run") == 0 || strcmp(argv[1], "plan") == 0) {
    const int dimension = scene_dimension(argc - 1, argv + 1);
    return dimension != 0 ? dimension : 1;
  }
  if (strcmp(argv[1], "bench") == 0) {
    const int dimension = scene_dimension(argc - 1, argv + 1);
    return dimension != 0 ? dimension : 3;
  }
  const bool many =
      strcmp(argv[1], "validate") == 0 || strcmp(argv[1], "chart") == 0 || strcmp(argv[1], "stress") == 0;
  return many ? 1 : 3;
}

int main(int argc, char **argv) {
  char path[PATH_MAX];
  const ssize_t length = readlink("/proc/self/exe", path, sizeof path - sizeof "-1d");
  if (length <= 0) {
    perror("kith: /proc/self/exe");
    return 1;
  }
  /* The three stand beside this program, and are named after it. */
  snprintf(path + length, sizeof "-1d", "-%dd", program_dimension(argc, argv));
  if (argc > 0) argv[0] = path;
  execv(path, argv);
  fprintf(stderr, "kith: cannot start ");
  perror(path);
  return 1;
}
