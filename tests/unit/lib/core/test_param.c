/* test_param.c - tables of parameters: values from text and back, ranges, choices, defaults, settings of
 * members of a family, and the messages of everything that is refused. */
#include "lib/core/param.h"
#include <string.h>
#include "tests/check.h"

struct plain {
  double one, three[3], sides[2], interval[2];
  int count, choice;
  uint64_t seed;
  bool flag, second;
  char name[8];
};
static const struct kith_param below[] = {
    {"second", KITH_PARAM_CHOICE, "b", "a|b", "", KITH_INTO(struct plain, second)}, {0}};
static const struct kith_param plain[] = {
    {"one", KITH_PARAM_NUMBER, NULL, "(0, 1]", "", KITH_INTO(struct plain, one)},
    {"three", KITH_PARAM_VECTOR, "[1, 2, 3]", "", "", KITH_INTO(struct plain, three)},
    {"sides", KITH_PARAM_SIDES, "4", "[0, inf)", "", KITH_INTO(struct plain, sides)},
    {"interval", KITH_PARAM_INTERVAL, "", "", "", KITH_INTO(struct plain, interval)},
    {"count", KITH_PARAM_INTEGER, "-7", "[-7, 7)", "", KITH_INTO(struct plain, count)},
    {"choice", KITH_PARAM_CHOICE, "two-b", "one|two_b|three", "", KITH_INTO(struct plain, choice)},
    {"seed", KITH_PARAM_INTEGER, "18446744073709551615", "", "", KITH_INTO(struct plain, seed)},
    {"flag", KITH_PARAM_BOOL, "yes", "", "", KITH_INTO(struct plain, flag)},
    {"name", KITH_PARAM_NAME, "x", "", "", KITH_INTO(struct plain, name)},
    {"below", KITH_PARAM_MAP, "", "", "", KITH_BELOW(below, MAP)},
    {0}};

static struct kith_member family(int k) {
  static const struct kith_member member[] = {{"plain", "with settings", plain, sizeof(struct plain)},
                                              {"no_settings", "none", NULL, 0},
                                              {NULL, NULL, NULL, 0}};
  return member[k];
}

static void defaults(void) {
  struct plain s = {.interval = {5, 6}};
  CHECK_OK(kith_params_defaults(plain, &s));
  CHECK(isnan(s.one) && s.three[2] == 3 && s.sides[0] == 4 && s.sides[1] == 4 && s.interval[1] == 6);
  CHECK(s.count == -7 && s.choice == 1 && s.seed == UINT64_MAX && s.flag && s.second);
  CHECK(strcmp(s.name, "x") == 0);
  char text[16];
  kith_param_format(kith_params_find(plain, "choice"), &s, text, sizeof text);
  CHECK(strcmp(text, "two-b") == 0);
  CHECK_STATUS(KITH_BAD_INPUT, kith_params_check(plain, "it", &s));
  CHECK(strcmp(kith_failure(), "it: one is nan, must be in (0, 1]") == 0);
  s.one = 1;
  CHECK_OK(kith_params_check(plain, "it", &s));
  s.sides[1] = -1;
  CHECK_STATUS(KITH_BAD_INPUT, kith_params_check(plain, "it", &s));
  CHECK(strcmp(kith_failure(), "it: sides[1] is -1, must be in [0, inf)") == 0);
  s.sides[1] = 0, s.count = 7;
  CHECK_STATUS(KITH_BAD_INPUT, kith_params_check(plain, "it", &s));
}

/* Every value is formatted as a text that parses to the same value. */
static void round_trip(void) {
  static const char *const given[] = {"one=0.1",
                                      "one=0x1.fffffffffffffp-1",
                                      "three=[-1,1e-300,3]",
                                      "sides=[2,0]",
                                      "interval=-1,1",
                                      "count=6",
                                      "choice=three",
                                      "seed=0",
                                      "flag=false",
                                      "name=abcdefg"};
  for (size_t k = 0; k < sizeof given / sizeof given[0]; ++k) {
    void *a, *b;
    char key[16], again[300] = "", text[256];
    CHECK_OK(kith_settings_create(&a, family(0), given[k]));
    snprintf(key, sizeof key, "%.*s", (int)strcspn(given[k], "="), given[k]);
    const struct kith_param *p = kith_params_find(plain, key);
    kith_param_format(p, a, text, sizeof text);
    for (char *c = text; *c != '\0'; ++c) /* blanks separate assignments */
      if (*c == ' ') memmove(c, c + 1, strlen(c));
    snprintf(again, sizeof again, "%s=%s", key, text);
    CHECK_OK(kith_settings_create(&b, family(0), again));
    CHECK(memcmp((char *)a + p->offset, (char *)b + p->offset, p->size) == 0);
    kith_params_clear(plain, a), kith_params_clear(plain, b);
    kith_free(&a), kith_free(&b);
  }
}

static void refused(const char *assignment, const char *wanted) {
  void *settings;
  check_message(assignment, kith_settings_create(&settings, family(0), assignment), wanted);
  CHECK(settings == NULL);
}

static void refusals(void) {
  refused("one=0", "plain: one: 0 is out of range (0, 1]");
  refused("one=1.0000001", "plain: one: 1.0000001 is out of range (0, 1]");
  refused("one=.nan", "plain: one: .nan is not a finite number");
  refused("one=1e999", "plain: one: 1e999 is not a finite number");
  refused("one=1x", "plain: one: '1x' is not a number");
  refused("three=1,2", "plain: three: 2 entries, wanted 3");
  refused("sides=-1", "plain: sides: -1 is out of range [0, inf)");
  refused("interval=1,1", "plain: interval: [1, 1] is empty: the first must be below the second");
  refused("count=7", "plain: count: 7 is out of range [-7, 7)");
  refused("count=1.5", "plain: count: '1.5' is not a whole number");
  refused("seed=-1", "plain: seed: -1 does not fit a 64-bit integer");
  refused("choice=thre", "plain: choice: 'thre' is not one of one, two-b, three; did you mean 'three'?");
  refused("flag=maybe", "plain: flag: 'maybe' is not one of true, false");
  refused("name=abcdefgh", "plain: name: 'abcdefgh' is longer than 7 letters");
  refused("nothing=1", "plain has no parameter nothing");
  refused("one", "plain: one: write it as key=value");
  void *none;
  CHECK_STATUS(KITH_BAD_INPUT, kith_settings_create(&none, family(1), "one=1"));
  CHECK(none == NULL && strcmp(kith_failure(), "no_settings has no parameter one") == 0);
}

static void members(void) {
  const struct kith_param chooser = {
      "who", KITH_PARAM_MEMBER, "plain", "", "", 0, sizeof(struct kith_selected), .family = family};
  struct kith_selected selected = {.name = ""};
  void *none;
  CHECK(kith_family_member(family, "no-settings").doc == family(1).doc);
  CHECK(kith_family_member(family, "plai").name == NULL);
  CHECK_OK(kith_settings_create(&none, family(1), " "));
  CHECK(none == NULL);
  CHECK_OK(kith_param_parse(&chooser, "no-settings", &selected));
  CHECK(strcmp(selected.name, "no-settings") == 0);
  CHECK_STATUS(KITH_BAD_INPUT, kith_param_parse(&chooser, "plane", &selected));
  CHECK(strcmp(kith_failure(), "'plane' is not one of plain, no-settings; did you mean 'plain'?") == 0);
}

int main(void) {
  defaults();
  round_trip();
  refusals();
  members();
  return check_failed();
}
