/* test_config.c - YAML as a tree of nodes: what is refused, with line and message; overrides; files over base
 * files; writing, and reading again; suggestions for misspelled words. */
#include "app/scene/config.h"
#include <stdio.h>
#include <string.h>
#include "lib/core/choices.h"
#include "tests/unit/files.h"

static void refused(const char *text, const char *wanted) {
  struct kith_config *config;
  check_message(text, kith_config_parse(&config, "f", text, strlen(text)), wanted);
  CHECK(config == NULL);
}

static void syntax(void) {
  refused("", "f:1: the file is empty");
  refused("# nothing\n\n", "f:1: the file is empty");
  refused("---\n~\n", "f:2: the file is empty");
  refused("- a\n- b\n", "f:1: a list where a map belongs");
  refused("\nword\n", "f:2: 'word' where a map belongs");
  refused("a: 1\nb: 2\na: 3\n", "f:3: a: duplicate key, first on line 1");
  refused("m:\n  a: 1\n  a: 2\n", "f:3: m.a: duplicate key, first on line 2");
  refused("m: {x: 1,\n  \"x\": 2}\n", "f:2: m.x: duplicate key, first on line 1");
  refused("a: 1\nb: [1, 2\nc: 3\n",
          "f:3: not YAML: did not find expected ',' or ']' while parsing a flow sequence");
  refused("a: 1\nm: {b: x > 0 ? 1 : 2}\n",
          "f:2: not YAML: did not find expected ',' or '}' while parsing a flow "
          "mapping; a formula with a colon needs quotes");
  refused("a: 1\n\tb: 2\n", "f:2: not YAML: indented by a tab; take blanks");
  refused("a:\n  b: 1\n  \tc: 2\n", "f:3: not YAML: indented by a tab; take blanks");
  refused("a:\n\tb: 1\n", "f:2: not YAML: indented by a tab; take blanks");
  refused("a: {b: -1, -1, -1}\n",
          "f:1: a.-1: has no value; lists stand in brackets, formulas with a comma in quotes");
  refused("a:\n  - {b: max(x, y)}\n",
          "f:2: a.0.y): has no value; lists stand in brackets, formulas with a comma in quotes");
  refused("a: 'x\n", "f:2: not YAML: found unexpected end of stream while scanning a quoted scalar");
  refused("a: b: c\n", "f:1: not YAML: mapping values are not allowed in this context");
  refused("a: 1\nb: \x01\n", "f:2: not YAML: control characters are not allowed");
  refused("a: 1\n\nb: \xff\xfe\n", "f:3: not YAML: invalid leading UTF-8 octet");
  refused("a: &x 1\nb: *x\n", "f:1: a: anchors and aliases are not supported");
  refused("m: &x {}\n", "f:1: m: anchors and aliases are not supported");
  refused("a: 1\nb: *x\n", "f:2: b: anchors and aliases are not supported");
  refused("l:\n  - !!str 5\n", "f:2: l.0: tags are not supported");
  refused("a: !!seq [1]\n", "f:1: a: tags are not supported");
  refused("a: 1\n---\nb: 1\n", "f:2: a second document begins; one is read");
  refused("{[1]: 2}\n", "f:1: a key must be a word");
  refused("{{a: 1}: 2}\n", "f:1: a key must be a word");
  refused("'': 2\n", "f:1: a key must be a word");
  refused("a: \"x\\0y\"\n", "f:1: a: a NUL character in a value");
  refused("\"a\\0b\": 1\n", "f:1: a key must be a word");
  /* a message is one line, whatever the key */
  refused("\"a\\nb\": 1\n\"a\\nb\": 2\n", "f:2: a?b: duplicate key, first on line 1");
}

static void limits(void) {
  char text[8192] = "a: ";
  struct kith_config *config;
  for (int i = 0; i < 31; ++i) strcat(text, "[");
  for (int i = 0; i < 31; ++i) strcat(text, "]"); /* with the map itself 32 levels */
  CHECK_OK(kith_config_parse(&config, "f", text, strlen(text)));
  kith_config_destroy(&config);
  snprintf(text, sizeof text, "a:\n ");
  for (int i = 0; i < 32; ++i) strcat(text, "{b: ");
  CHECK_STATUS(KITH_BAD_INPUT, kith_config_parse(&config, "f", text, strlen(text)));
  CHECK(strncmp(kith_failure(), "f:2: a.b.b", 10) == 0 &&
        strstr(kith_failure(), "nested deeper than 32 levels") != NULL);
  size_t used = 0;
  for (int i = 0; i < 257; ++i) used += (size_t)snprintf(text + used, sizeof text - used, "k%d: 1\n", i);
  refused(text, "f:257: k256: more than 256 keys in one map");
}

static void tree(void) {
  const char *text = "# comment\na: 1\nm:\n  x: [1, two, {z: 3}]\n  n:\nq: 'null'\n";
  struct kith_config *config;
  CHECK_OK(kith_config_parse(&config, "f", text, strlen(text)));
  const struct kith_config_node *m = kith_config_child(config->root, "m"),
                                *z = kith_config_at(config, "m.x.2.z");
  CHECK(m != NULL && m->kind == KITH_CONFIG_MAP && m->n == 2 && m->location.line == 3);
  CHECK(z != NULL && strcmp(z->text, "3") == 0 && z->location.line == 4);
  CHECK(kith_config_child(m, "n") == NULL && kith_config_child(m, "y") == NULL);
  CHECK(kith_config_child(NULL, "n") == NULL && kith_config_at(config, "m.x.3") == NULL);
  CHECK(kith_config_child(config->root, "q") != NULL); /* quoted, so it is a word */
  check_message("fail", kith_config_fail(z, NULL, "is %d", 3), "f:4: m.x.2.z: is 3");
  check_message("fail", kith_config_fail(m, "k", "two\nlines"), "f:3: m.k: two?lines");
  kith_config_destroy(&config);
  CHECK(config == NULL);
}

static void check_text(const char *what, const char *got, const char *wanted) {
  if (strcmp(got, wanted) == 0) return;
  ++check_failures;
  fprintf(stderr, "%s\ngave\n%swanted\n%s", what, got, wanted);
}

static void overridden(const char *text, const char *assignment, const char *wanted) {
  struct kith_config *config;
  char *out = NULL;
  CHECK_OK(kith_config_parse(&config, "f", text, strlen(text)));
  CHECK_OK(kith_config_override(config, assignment));
  CHECK_OK(kith_config_emit(config->root, false, &out));
  check_text(assignment, out, wanted);
  kith_free(&out);
  kith_config_destroy(&config);
}

static void not_overridden(const char *assignment, const char *wanted) {
  const char *text = "a: 1\nm: {x: 1}\nl: [{z: 1}, 2]\n";
  struct kith_config *config;
  CHECK_OK(kith_config_parse(&config, "f", text, strlen(text)));
  check_message(assignment, kith_config_override(config, assignment), wanted);
  kith_config_destroy(&config);
}

static void overrides(void) {
  overridden("a: 1\nb: 2\n", "a=3", "a: 3\nb: 2\n");
  overridden("a: 1\n", "b=x y", "a: 1\nb: x y\n");
  overridden("a: 1\n", "m.x.y=2", "a: 1\nm:\n  x:\n    y: 2\n");
  overridden("m:\n", "m.x=2", "m:\n  x: 2\n");
  overridden("m: {x: 1, y: 2}\n", "m.x={z: [1, 2]}", "m:\n  x:\n    z: [1, 2]\n  y: 2\n");
  overridden("m: {x: 1}\n", "m=5", "m: 5\n");
  overridden("l: [{z: 1}, 2]\n", "l.0.z=7", "l:\n- z: 7\n- 2\n");
  overridden("a: 1\n", "a=", "a: null\n");
  overridden("a: 1\n", "a=b=c", "a: b=c\n");
  overridden("a: 1\n", "a='-x/r'", "a: '-x/r'\n");
  not_overridden("a", "--set a: write it as key=value");
  not_overridden("=1", "--set =1: write it as key=value");
  not_overridden("", "--set : write it as key=value");
  not_overridden("a..b=1", "--set a..b=1: write it as key=value");
  not_overridden("m.=1", "--set m.=1: write it as key=value");
  not_overridden("a.b=1", "--set a: has no keys, it is '1'");
  not_overridden("l.2=1", "--set l.2: no such entry, the list has 2 (counted from 0)");
  not_overridden("l.1.x=1", "--set l.1: has no keys, it is '2'");
  not_overridden("m.x=[1",
                 "--set m.x: not YAML: did not find expected ',' or ']' while parsing a flow sequence");
  not_overridden("m.x={a: 1, a: 2}", "--set m.x.a: duplicate key");
  not_overridden("m.x=*y", "--set m.x: anchors and aliases are not supported");
  char deep[200] = "";
  for (int i = 0; i < 40; ++i) strcat(deep, "m.");
  strcat(deep, "m=1");
  struct kith_config *config;
  CHECK_OK(kith_config_parse(&config, "f", "m: {}", 5));
  CHECK_STATUS(KITH_BAD_INPUT, kith_config_override(config, deep));
  CHECK(strstr(kith_failure(), "nested deeper than 32 levels") != NULL);
  kith_config_destroy(&config);
}

/* What is written parses to the same tree, so writing that again gives the same text. */
static void write_and_read(const char *text) {
  struct kith_config *config, *again;
  char *first = NULL, *second = NULL;
  CHECK_OK(kith_config_parse(&config, "f", text, strlen(text)));
  CHECK_OK(kith_config_emit(config->root, false, &first));
  CHECK_OK(kith_config_parse(&again, "f", first, strlen(first)));
  CHECK_OK(kith_config_emit(again->root, false, &second));
  CHECK(strcmp(first, second) == 0);
  KITH_FREE(&first, &second);
  kith_config_destroy(&config);
  kith_config_destroy(&again);
}

static void writing(void) {
  write_and_read("a: 1.0\nb: [1, 2, 'x: y', \"t\\tn\\n\"]\nc: {}\nd: []\ne: ~\nf: 'null'\n");
  write_and_read("a: |\n  two\n  lines\nb: >\n  folded\n  words\nc: plain on\n  two lines\n");
  write_and_read("l:\n- - 1\n  - [2]\n- {x: 1, y: {z: }}\n");
  write_and_read("'a b': ''\n\"c: d\": '# no comment'\n'-': \"- x\"\n'{': \"é\"\n");
}

static void file_refused(const char *path, const char *what) {
  struct kith_config *config;
  char wanted[256];
  snprintf(wanted, sizeof wanted, "%s: %s", path, what);
  check_message(path, kith_config_read(&config, path), wanted);
  CHECK(config == NULL);
}

static void files(void) {
  const char *const path = path_in("s.yaml");
  struct kith_config *config;
  file_refused(directory, "is a directory, not a scene");
  file_refused(path, "No such file or directory");
  FILE *file = fopen(path, "wb");
  for (int i = 0; i < (1 << 20) + 1; ++i) fputc(i % 64 == 63 ? '\n' : '#', file);
  fclose(file);
  file_refused(path, "larger than 1 MiB, too large for a scene");
  file = fopen(path, "wb");
  fwrite(
      "\x7f"
      "ELF\x02\x01\x01\0\0\0",
      1, 10, file);
  fclose(file);
  CHECK_STATUS(KITH_BAD_INPUT, kith_config_read(&config, path));
  CHECK(check_says(":1: not YAML: control characters are not allowed"));
  write_text(path, "a: 1\n");
  CHECK_OK(kith_config_read(&config, path));
  kith_config_destroy(&config);
}

/* A scene over base.yaml in the same folder: the result, or the message (after the name of the folder). */
static void with_base(const char *text, const char *wanted, const char *message) {
  struct kith_config *config;
  const char *const path = path_in("s.yaml");
  char *out = NULL;
  write_text(path, text);
  if (message != NULL) {
    check_message(text, kith_config_read(&config, path), path_in(message));
    CHECK(config == NULL);
    return;
  }
  CHECK_OK(kith_config_read(&config, path));
  CHECK_OK(kith_config_emit(config->root, false, &out));
  check_text(text, out, wanted);
  kith_free(&out);
  kith_config_destroy(&config);
}

static void bases(void) {
  char line[96];
  write_text(path_in("base.yaml"), "scene: b\na: 1\nm: {x: 1, y: 2}\nl: [{z: 1}, 2]\n");
  write_text(path_in("middle.yaml"), "base: base.yaml\n\nm.x: 5\n");
  write_text(path_in("round.yaml"), "base: s.yaml\n");
  with_base("base: base.yaml\n", "scene: null\na: 1\nm:\n  x: 1\n  y: 2\nl:\n- z: 1\n- 2\n", NULL);
  with_base("m.x: {q: [1, 2]}\nbase: base.yaml\nscene: s\nl.0.z: 7\nn.o: ~\na: 'x y'\n",
            "scene: s\na: 'x y'\nm:\n  x:\n    q: [1, 2]\n  y: 2\nl:\n- z: 7\n- 2\nn:\n  o: null\n", NULL);
  with_base("base: middle.yaml\nm.y: 6\nl: 3\n", "scene: null\na: 1\nm:\n  x: 5\n  y: 6\nl: 3\n", NULL);
  with_base("base: base.yaml\n\nl.2.z: 1\n", NULL,
            "s.yaml:3: l.2: no such entry, the list has 2 (counted from 0)");
  with_base("base: base.yaml\na.b: 1\n", NULL, "s.yaml:2: a: has no keys, it is '1'");
  with_base("base: base.yaml\na..b: 1\n", NULL, "s.yaml:2: a..b: an empty word between dots");
  with_base("base: base.yaml\nm.: 1\n", NULL, "s.yaml:2: m.: an empty word between dots");
  with_base("base: [1]\n", NULL, "s.yaml:1: base: not the name of a file");
  with_base("a: 1\nbase: round.yaml\n", NULL, "s.yaml:2: base: the 8th base in a row; do they go round?");
  snprintf(line, sizeof line, "s.yaml:2: base: %s/none.yaml: No such file or directory", directory);
  with_base("\nbase: none.yaml\n", NULL, line);
  /* Locations are those of the file in which a value stands. */
  struct kith_config *config;
  write_text(path_in("s.yaml"), "base: middle.yaml\n\n\nm.y: {u: 6}\n");
  CHECK_OK(kith_config_read(&config, path_in("s.yaml")));
  static const char *const at[][2] = {
      {"m.y.u", "s.yaml:4: m.y.u: no"}, {"m.x", "middle.yaml:3: m.x: no"}, {"a", "base.yaml:2: a: no"}};
  for (int k = 0; k < 3; ++k)
    check_message(at[k][0], kith_config_fail(kith_config_at(config, at[k][0]), NULL, "no"),
                  path_in(at[k][1]));
  kith_config_destroy(&config);
}

static void check_suggestion(const char *choices, const char *word, const char *wanted) {
  char found[32] = "none";
  kith_choices_suggest(choices, word, found, sizeof found);
  CHECK(strcmp(found, wanted) == 0);
}

static void choices(void) {
  char all[32];
  CHECK(kith_choices_index("|a|b_c|d", "b-c") == 1 && kith_choices_index("a|b", "") == -1 &&
        kith_choices_index("", "a") == -1);
  CHECK(kith_choices_index("tree|grid", "tre") == -1 && kith_choices_index("tree|grid", "trees") == -1);
  kith_choices_format("|tree|two_words|x", all, sizeof all);
  CHECK(strcmp(all, "tree, two-words, x") == 0);
  kith_choices_format("tree|two_words|and many many more words", all, 12);
  CHECK(strcmp(all, "tree, two-w") == 0);
  check_suggestion("kernel|neighbors|energy", "kernl", "kernel");
  check_suggestion("kernel|neighbors|energy", "neigbours", "neighbors");
  check_suggestion("kernel|energy", "krenel", "kernel");
  check_suggestion("cubic|bcc|fcc|hcp", "fc", "fcc");
  check_suggestion("cubic|bcc|fcc|hcp", "simple", "none");
  check_suggestion("ball|outside_ball", "outside ball", "outside-ball");
  check_suggestion("kernel", "", "none");
  check_suggestion("kernel", "a word that is much longer than any key", "none");
}

int main(void) {
  static const char *const made[] = {"s.yaml", "base.yaml", "middle.yaml", "round.yaml"};
  directory_make();
  syntax();
  limits();
  tree();
  overrides();
  writing();
  files();
  bases();
  choices();
  directory_remove(4, made);
  return check_failed();
}
