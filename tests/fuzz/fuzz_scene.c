/* Fuzzing of scenes: whatever the text is, reading it gives a scene, or one line with the place of the error.
 *
 * A scene that was read must be written as text that reads as the same scene. An input that begins with '@'
 * has an override in its first line.
 *
 *   fuzz_scene-3d [N [SEED]]      N inputs (20000) made from good scenes by a fixed generator; any compiler
 *   libfuzzer_scene-3d CORPUS     clang with -DKITH_LIBFUZZER=ON
 * -DKITH_SANITIZE=fuzzer-no-link,address,undefined */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "app/scene/scene.h"
#include "tests/fuzz/draw.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void fail(const char *what, const char *text) {
  fprintf(stderr, "fuzz_scene: %s: %s\n", what, text);
  abort();
}

static void check_refusal(kith_status status) {
  const char *message = kith_failure();
  if (status != KITH_BAD_INPUT) fail("not a BAD_INPUT", message);
  if (message[0] == '\0' || strpbrk(message, "\n\r") != NULL) fail("not one line", message);
  if (strncmp(message, "f:", 2) != 0 && strncmp(message, "--set", 5) != 0) fail("no place", message);
}

static void check_text(const char *text) {
  struct kith_scene *again;
  if (kith_scene_parse(&again, "f", text, strlen(text), 0, NULL) != KITH_OK)
    fail("written, not read", kith_failure());
  if (strcmp(again->text, text) != 0) fail("written, read, written differently", text);
  kith_scene_destroy(&again);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  struct kith_scene *scene;
  char override_[256] = "";
  const char *overrides[] = {override_}, *text = (const char *)data;
  if (size > 0 && data[0] == '@') {
    const uint8_t *end = memchr(data, '\n', size);
    const size_t line = end != NULL ? (size_t)(end - data) : size, length = KITH_MIN(line, sizeof override_);
    memcpy(override_, data + 1, length - 1);
    text += line, size -= line;
  }
  const kith_status status = kith_scene_parse(&scene, "f", text, size, override_[0] != '\0', overrides);
  if ((status == KITH_OK) != (scene != NULL)) fail("a scene without success, or the other way round", "");
  if (status == KITH_OK)
    check_text(scene->text);
  else
    check_refusal(status);
  kith_scene_destroy(&scene);
  return 0;
}

#ifndef KITH_LIBFUZZER

static const char *const seeds[] = {
    "scene: sod\ndimension: {1d: 1, 2d: 2, 3d: 3}\nresolution: 60 # comment\n"
    "domain: {lower: [-1, 0, 0], upper: [1, 0.2, 0.2], across: 8}\n"
    "boundaries: {x: reflecting, y: periodic, z: [open, reflecting]}\nmaterials:\n  gas: {eos: ideal, "
    "gamma: 1.4}\n"
    "regions:\n  - {material: gas, where: {x: [-1, 0]}, lattice: bcc, density: 1.0,   pressure: 1.0}\n"
    "  - {material: gas, where: {x: [0, 1]},  lattice: {2d: hcp, 3d: fcc, 1d: cubic}, density: 0.125, "
    "pressure: 0.1}\n"
    "method: {package: sph, kernel: wendland-c2, neighbors: 60, energy: compatible, viscosity: {name: "
    "limited, alpha: 1, "
    "beta: 2}}\nscheme: {name: leapfrog, cfl: 0.3}\nuntil: 0.2\nexact: {name: riemann, window: {x: [-0.5, "
    "0.5]}}\n"
    "output: {every: 0.05}\n",
    "dimension: {1d: 1, 2d: 2, 3d: 3}\nresolution: 20\nuntil: 0.05\nreproducible: true\ntraversal: pairs\n"
    "domain:\n  lower: [0, 0, 0]\n  upper: [1, 1, 1]\nboundaries:\n  x: reflecting\n  y: reflecting\n  z: "
    "reflecting\n"
    "materials:\n  air:\n    gamma: 1.6666666666666667\nregions:\n- material: air\n  density: 1\n  "
    "energy: 1e-6\n"
    "  jitter: 0.1\n  seed: 7\nenergy:\n  energy: 0.125\n  center: [0, 0, 0]\n  over: kernel\n  spacings: 2\n"
    "exact:\n  name: sedov\n  window:\n    r: [0.1, 0.9]\nneighbor: {search: tree, storage: csr}\n"
    "connectivity: {rebuild: displacement | entity-change, skin: 0.2, cull: false, reorder: 10}\n",
    "@scheme.cfl=0.1\ndimension: {1d: 1, 2d: 2, 3d: 3}\nresolution: 10\nuntil: 1\narrangement: "
    "equal-spacing\n"
    "domain: {lower: [-1, -1, -1], upper: [1, 1, 1]}\nmaterials: {a: {eos: stiffened, stiffness: 3}, b: "
    "{eos: isothermal, "
    "sound_speed: 2}}\nregions:\n  - {material: a, density: '1 + 0.1*sin(pi*x)', pressure: \"2 - r^2\", "
    "velocity: "
    "['-x/(r+1)', '-y', 0], where: {inside: r < 0.5}}\n"
    "  - {material: b, density: 1, pressure: 1, spacing: 0.1, frozen: yes, where: {x: [0, "
    "0.5], inside: 'x > 0 && y < 1'}}\n"
    "energy: [{energy: 1, over: ball, radius: 0.1}, {energy: 2}]\n"
    "exact: {name: acoustic-wave, density: 1, pressure: 1, gamma: 1.4, amplitude: 0.01}\n"
    "output: {plot: no, checkpoint: 5, checkpoint_at_end: true}\n",
};
enum { N_SEEDS = sizeof seeds / sizeof seeds[0], EXPENSIVE = 1, LARGEST = 1 << 16 };

/* Pieces of text that are special in YAML, numbers, formulas and scenes. */
static const char words[] =
    "{;};[;];: ;:;- ;,;\n;\n  ;\t;#;';\";&a ;*a;!!str ;| ;>;---\n;...\n;%YAML 1.1\n;? ;~;null;.nan;.inf;"
    "1e999;-1;0;1e-320;0x1p4;99999999999999999999;true;{};[];1d: 1;3d: ;x;r;x/0;x=1;((((;sqrt(-1);x,y;?1:2;"
    "\\0;\xff;exact;energy;where;ball;noh;uniform;sedov;riemann;periodic;constant;across;velocity;@a.b=1\n;"
    "@regions.0=\n;@regions.0.velocity={1d: 2}\n;@energy=[[[\n;\xef\xbb\xbf;\xfe\xff";

/* Draws the scene to begin with; the one with a Sedov solution, which takes milliseconds, is drawn less
 * often. */
static const char *draw_seed(uint64_t *state) {
  const size_t seed = below(state, N_SEEDS);
  return seeds[seed == EXPENSIVE && below(state, 8) > 0 ? 0 : seed];
}

struct input {
  size_t size;
  char text[LARGEST];
};

static void cut(struct input *in, size_t at, size_t length) {
  length = KITH_MIN(length, in->size - at);
  memmove(in->text + at, in->text + at + length, in->size - at - length);
  in->size -= length;
}

static void insert(struct input *in, size_t at, const char *text, size_t length) {
  if (in->size + length > LARGEST) return;
  memmove(in->text + at + length, in->text + at, in->size - at);
  memcpy(in->text + at, text, length);
  in->size += length;
}

static void mutate(struct input *in, uint64_t *state) {
  const size_t at = below(state, in->size + 1), length = 1 + below(state, 1 + below(state, 40));
  char copy[64], word[64];
  draw_word(words, state, word);
  const char *seed = seeds[below(state, N_SEEDS)];
  const size_t from = below(state, strlen(seed));
  switch (below(state, 8)) {
    case 0:
      cut(in, at, length);
      break;
    case 1:
    case 2:
      insert(in, at, word, strlen(word));
      break;
    case 3: /* replaces letters by a word */
      cut(in, at, length);
      insert(in, at, word, strlen(word));
      break;
    case 4:
      insert(in, at, seed + from, KITH_MIN(length, strlen(seed) - from));
      break;
    case 5: /* copies a piece */
      memcpy(copy, in->text + at, KITH_MIN(length, in->size - at));
      insert(in, below(state, in->size + 1), copy, KITH_MIN(length, in->size - at));
      break;
    case 6:
      if (at < in->size) in->text[at] = (char)below(state, 256);
      break;
    default:
      if (at < in->size) in->text[at] = (char)(in->text[at] ^ (1 << below(state, 7)));
      break;
  }
}

int main(int argc, char **argv) {
  const long n = argc > 1 ? atol(argv[1]) : 20000;
  uint64_t state = argc > 2 ? strtoull(argv[2], NULL, 10) : 1;
  struct input *in = malloc(sizeof *in);
  if (in == NULL) return 1;
  for (long i = 0; i < n; ++i) {
    const char *seed = draw_seed(&state);
    in->size = strlen(seed);
    memcpy(in->text, seed, in->size);
    for (size_t m = below(&state, 6); m > 0; --m) mutate(in, &state);
    LLVMFuzzerTestOneInput((const uint8_t *)in->text, in->size);
  }
  free(in);
  return 0;
}

#endif
