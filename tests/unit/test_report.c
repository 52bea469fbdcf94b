/* report.json against a reader of JSON that is written here, and the table's width. */
#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "app/report.h"
#include "lib/io/json.h"
#include "tests/check.h"

/* A strict reader: RFC 8259. Every value is kept as "a/b/c" and its text, with strings decoded. */
struct value {
  char path[128], text[256];
};
struct reader {
  const char *s;
  bool bad;
  int n;
  struct value value[128];
};

static void space(struct reader *r) {
  r->s += strspn(r->s, " \t\r\n");
}

static bool take(struct reader *r, char c) {
  space(r);
  if (*r->s != c) return false;
  ++r->s;
  return true;
}

static void keep(struct reader *r, const char *path, const char *text) {
  CHECK(r->n < 128);
  if (r->n == 128) return;
  snprintf(r->value[r->n].path, sizeof r->value[0].path, "%s", path);
  snprintf(r->value[r->n++].text, sizeof r->value[0].text, "%s", text);
}

static void read_string(struct reader *r, char *out, size_t room) {
  size_t n = 0;
  if (!take(r, '"')) r->bad = true;
  while (!r->bad && *r->s != '"') {
    unsigned code = (unsigned char)*r->s++;
    if (code < 0x20 || n + 2 > room) r->bad = true;
    if (code == '\\') {
      const char c = *r->s++;
      static const char from[] = "\"\\/bfnrt", to[] = "\"\\/\b\f\n\r\t";
      if (c == 'u') {
        char hex[5] = "", *end;
        strncpy(hex, r->s, 4);
        code = (unsigned)strtoul(hex, &end, 16);
        if (end != hex + 4 || code > 0x7f) r->bad = true;
        if (!r->bad) r->s += 4;
      } else if (c != '\0' && strchr(from, c) != NULL) {
        code = (unsigned char)to[strchr(from, c) - from];
      } else {
        r->bad = true;
      }
    }
    out[n++] = (char)code;
  }
  out[n] = '\0';
  if (!r->bad) ++r->s;
}

/* -?(0|[1-9][0-9]*)(.[0-9]+)?([eE][+-]?[0-9]+)? */
static void read_number(struct reader *r, const char *path) {
  const char *s = r->s, *start = s;
  if (*s == '-') ++s;
  if (!isdigit((unsigned char)*s) || (*s == '0' && isdigit((unsigned char)s[1]))) r->bad = true;
  s += strspn(s, "0123456789");
  if (*s == '.') {
    if (!isdigit((unsigned char)s[1])) r->bad = true;
    s += 1 + strspn(s + 1, "0123456789");
  }
  if (*s == 'e' || *s == 'E') {
    s += s[1] == '+' || s[1] == '-' ? 2 : 1;
    if (!isdigit((unsigned char)*s)) r->bad = true;
    s += strspn(s, "0123456789");
  }
  char text[64];
  snprintf(text, sizeof text, "%.*s", (int)(s - start), start);
  keep(r, path, text);
  r->s = s;
}

static void read_value(struct reader *r, const char *path) {
  char text[256], inner[512];
  space(r);
  if (*r->s == '{') {
    ++r->s;
    if (take(r, '}')) return;
    do {
      read_string(r, text, sizeof text);
      snprintf(inner, sizeof inner, "%s%s%s", path, path[0] != '\0' ? "|" : "", text);
      if (!take(r, ':')) r->bad = true;
      if (!r->bad) read_value(r, inner);
    } while (!r->bad && take(r, ','));
    if (!take(r, '}')) r->bad = true;
  } else if (*r->s == '"') {
    read_string(r, text, sizeof text);
    keep(r, path, text);
  } else if (strncmp(r->s, "null", 4) == 0) {
    keep(r, path, "null");
    r->s += 4;
  } else {
    read_number(r, path);
  }
}

static const char *text_of(const struct reader *r, const char *path) {
  const char *found = NULL;
  for (int k = 0; k < r->n; ++k)
    if (strcmp(r->value[k].path, path) == 0) {
      CHECK(found == NULL); /* a key once */
      found = r->value[k].text;
    }
  if (found == NULL) fprintf(stderr, "no key %s\n", path);
  CHECK(found != NULL);
  return found != NULL ? found : "";
}

static void parse(struct reader *r, const char *json) {
  *r = (struct reader){.s = json};
  read_value(r, "");
  space(r);
  if (r->bad || *r->s != '\0') fprintf(stderr, "JSON is wrong at: %.60s\n", r->s);
  CHECK(!r->bad && *r->s == '\0');
}

static char path[] = "report-test-XXXXXX";

static void write_and_parse(struct reader *r, const struct kith_report *report) {
  static char json[16384];
  CHECK_OK(kith_report_write(report, path));
  FILE *f = fopen(path, "r");
  CHECK(f != NULL);
  json[f != NULL ? fread(json, 1, sizeof json - 1, f) : 0] = '\0';
  if (f != NULL) fclose(f);
  parse(r, json);
}

static const struct kith_stage stages[] = {
    {.path = "step", .name = "step", .calls = 210, .seconds = 12.25},
    {.path = "step/connectivity", .name = "connectivity", .depth = 1, .calls = 35, .seconds = 3.5},
    {.path = "step/connectivity/a name that is far too long for the table it stands in",
     .name = "a name that is far too long for the table it stands in",
     .depth = 2,
     .calls = UINT64_MAX,
     .seconds = 9.75},
};
static const struct kith_report_entry ledger[] = {{"ghosts_created", 5e12}, {"odd \"name\"", NAN}};

static const bool measured[KITH_N_MEASURES] = {
    [KITH_MEASURE_mcnally] = true, [KITH_MEASURE_separation] = true};

static struct kith_report sample(void) {
  return (struct kith_report){.scene = "so\"d\\ \n\t\x01 \xc3\xa9 \xff",
                              .package = "sph",
                              .kernel = "wendland-c2",
                              .scheme = "leapfrog",
                              .dimension = NDIM,
                              .ranks = 1,
                              .threads = 2,
                              .nodes = 24000,
                              .steps = 210,
                              .time = 0.2,
                              .wall_seconds = 12.5,
                              .cpu_seconds = 24.5,
                              .node_updates_per_second = 4.1e5,
                              .pairs_per_node = 30.25,
                              .pair_evaluations = 3.1e9,
                              .energy_drift = -1.5e-13,
                              .momentum_drift = INFINITY,
                              .angular_momentum_drift = 0.0625,
                              .kinetic = {0.5, 0.25, NAN},
                              .velocity_over_sound = {0.75, 0.125},
                              .measured = measured,
                              .measure = {[KITH_MEASURE_mcnally] = 0.125, [KITH_MEASURE_separation] = NAN},
                              .compared = true,
                              .norms = {.density = {0.1, 0.2, 0.3},
                                        .velocity = {1e-300, 5e-324, 1.7e308},
                                        .pressure = {NAN, 0, -0.0},
                                        .energy = {1.0 / 3, 2, 3},
                                        .speed = {7, 8, 9},
                                        .speed_peak = 0.875,
                                        .nodes = 23000,
                                        .blip = 0.01,
                                        .shock_radius = 0.349,
                                        .shock_exact = 0.35,
                                        .density_peak = 3.9},
                              .n_stages = 3,
                              .stages = stages,
                              .n_ledger = 2,
                              .ledger = ledger,
                              .floors = UINT64_MAX,
                              .version = "0.1.0",
                              .compiler = NULL,
                              .flags = ""};
}

static void keys(void) {
  static struct reader r;
  const struct kith_report report = sample();
  write_and_parse(&r, &report);
  CHECK(strcmp(text_of(&r, "scene"), "so\"d\\ \n\t\x01 \xc3\xa9 ?") == 0);
  CHECK(atoi(text_of(&r, "dimension")) == NDIM);
  CHECK(strcmp(text_of(&r, "package"), "sph") == 0 && strcmp(text_of(&r, "kernel"), "wendland-c2") == 0);
  CHECK(strcmp(text_of(&r, "scheme"), "leapfrog") == 0 && strcmp(text_of(&r, "ranks"), "1") == 0);
  CHECK(strcmp(text_of(&r, "threads"), "2") == 0 && strcmp(text_of(&r, "nodes"), "24000") == 0);
  CHECK(strcmp(text_of(&r, "steps"), "210") == 0 && strtod(text_of(&r, "time"), NULL) == 0.2);
  CHECK(strtod(text_of(&r, "wall_seconds"), NULL) == 12.5 &&
        strtod(text_of(&r, "cpu_seconds"), NULL) == 24.5);
  CHECK(strtod(text_of(&r, "node_updates_per_second"), NULL) == 4.1e5);
  CHECK(strtod(text_of(&r, "pairs_per_node"), NULL) == 30.25 &&
        strtod(text_of(&r, "pair_evaluations"), NULL) == 3.1e9);
  CHECK(strtod(text_of(&r, "energy_drift"), NULL) == -1.5e-13 &&
        strcmp(text_of(&r, "momentum_drift"), "null") == 0);
  CHECK(strtod(text_of(&r, "measures|mcnally"), NULL) == 0.125 &&
        strcmp(text_of(&r, "measures|separation"), "null") == 0);
  CHECK(strtod(text_of(&r, "norms|density|l1"), NULL) == 0.1 &&
        strtod(text_of(&r, "norms|density|linf"), NULL) == 0.3);
  CHECK(strtod(text_of(&r, "norms|velocity|l1"), NULL) == 1e-300 &&
        strtod(text_of(&r, "norms|velocity|l2"), NULL) == 5e-324);
  CHECK(strcmp(text_of(&r, "norms|pressure|l1"), "null") == 0 &&
        strtod(text_of(&r, "norms|energy|l1"), NULL) == 1.0 / 3);
  CHECK(strtod(text_of(&r, "angular_momentum_drift"), NULL) == 0.0625);
  CHECK(strtod(text_of(&r, "kinetic|start"), NULL) == 0.5 &&
        strtod(text_of(&r, "kinetic|end"), NULL) == 0.25 &&
        strcmp(text_of(&r, "kinetic|rebound"), "null") == 0);
  CHECK(strtod(text_of(&r, "velocity_over_sound|largest"), NULL) == 0.75 &&
        strtod(text_of(&r, "velocity_over_sound|end"), NULL) == 0.125);
  CHECK(strtod(text_of(&r, "norms|speed|l1"), NULL) == 7 &&
        strtod(text_of(&r, "norms|speed_peak"), NULL) == 0.875);
  CHECK(strtod(text_of(&r, "norms|blip"), NULL) == 0.01 &&
        strtod(text_of(&r, "norms|density_peak"), NULL) == 3.9);
  CHECK(strtod(text_of(&r, "norms|shock_radius"), NULL) == 0.349 &&
        strtod(text_of(&r, "norms|shock_exact"), NULL) == 0.35);
  CHECK(strtod(text_of(&r, "stages|step|seconds"), NULL) == 12.25 &&
        strcmp(text_of(&r, "stages|step|calls"), "210") == 0);
  CHECK(strcmp(text_of(&r, "stages|step/connectivity|calls"), "35") == 0);
  CHECK(strtod(text_of(&r, "ledger|ghosts_created"), NULL) == 5e12 &&
        strcmp(text_of(&r, "ledger|odd \"name\""), "null") == 0);
  CHECK(strcmp(text_of(&r, "floors"), "18446744073709551615") == 0 &&
        strcmp(text_of(&r, "version"), "0.1.0") == 0);
  CHECK(strcmp(text_of(&r, "compiler"), "null") == 0 && strcmp(text_of(&r, "flags"), "") == 0);
}

static void bare(void) {
  static struct reader r;
  const struct kith_report report = {.scene = "uniform"};
  write_and_parse(&r, &report);
  CHECK(strcmp(text_of(&r, "norms"), "null") == 0 && strcmp(text_of(&r, "package"), "null") == 0);
  CHECK(r.n == 29 && strcmp(text_of(&r, "ranks_detail"), "null") ==
                         0); /* the plain keys and norms: stages and ledger are empty objects */
  CHECK_STATUS(KITH_BAD_FILE, kith_report_write(&report, "no/such/report.json"));
}

/* Every byte by itself makes JSON that can be read, and every byte of ASCII comes back. */
static void strings(void) {
  static struct reader r;
  for (int c = 1; c < 256; ++c) {
    char text[2] = {(char)c, '\0'}, json[32] = "";
    FILE *f = fmemopen(json, sizeof json, "w");
    kith_json_string(f, text);
    fclose(f);
    parse(&r, json);
    CHECK(strcmp(r.value[0].text, c < 128 ? text : "?") == 0);
  }
}

/* No line beyond 100 columns, no trailing blanks, columns aligned by their right edge. */
static void table(void) {
  const struct kith_report report = sample();
  char *text = NULL;
  size_t size = 0;
  struct kith_report plain = report;
  plain.scene = "a scene whose name is so long that nobody would ever type it twice in a row, or even once";
  FILE *f = open_memstream(&text, &size);
  kith_report_print(&plain, f);
  const long tube = ftell(f);
  plain.norms.vortex = true;
  kith_report_print(&plain, f);
  plain.norms = (struct kith_norms){.nodes = 1};
  plain.kinetic.start = 0;
  kith_report_print(&plain, f);
  plain.compared = false, plain.n_stages = 0, plain.scene = NULL;
  kith_report_print(&plain, f);
  fclose(f);
  for (const char *line = text; *line != '\0';) {
    const size_t length = strcspn(line, "\n");
    if (length > 100) fprintf(stderr, "%zu columns: %.*s\n", length, (int)length, line);
    CHECK(length <= 100 && (length == 0 || line[length - 1] != ' '));
    line += length + (line[length] == '\n');
  }
  CHECK(strstr(text, "density") != NULL && strstr(text, "1.0000e-01") != NULL && strstr(text, "210") != NULL);
  /* Only what the scene is about: a vortex turns, gas at rest may begin to move. */
  const char *vortex = strstr(text, "of angular momentum 6.25e-02"),
             *rest = strstr(text, "velocity 7.50e-01 of sound");
  CHECK(vortex != NULL && vortex > text + tube && strstr(vortex + 1, "of angular momentum") == NULL);
  CHECK(rest != NULL && rest > vortex && strstr(rest + 30, "of sound") == NULL);
  CHECK(strstr(text, "azimuthal") > text + tube && strstr(text, "0.25 of 0.5") != NULL);
  CHECK(strstr(text, "    connectivity") != NULL || strstr(text, "  connectivity") != NULL);
  if (getenv("SHOW") != NULL) fputs(text, stdout);
  free(text);
}

int main(void) {
  CHECK(mkstemp(path) >= 0);
  keys();
  bare();
  strings();
  table();
  unlink(path);
  return check_failed();
}
