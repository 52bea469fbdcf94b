/* force.h - the force pass of every package: packed particles, rows of partners in lanes, and the sums of a
 * pair function in both traversals.
 *
 * A package writes one function of a pair and compiles kith_force_evaluate with it, once per kernel
 * (KITH_FORCE_FORM): the loop over the pairs of a block. What loads the partners before it and sums the
 * rows behind it is the same for all and stands in force.c. The function reads
 *     i[m]      field m of the packed particle i
 *     J(m)      field m of its partner j; behind these the values of the edge from i to j, if there are any
 * and gives, through OUT(m),
 *     KITH_FORCE + a    f_a: the force on i; j gets -f
 *     KITH_HEAT         q_i: the heat of i: its part of the work f . (v_j - v_i), and what it gets from j
 *     KITH_PARTNER_HEAT q_j: the heat of j
 *     KITH_SIGNAL       the signal speed of the pair; 0 from KITH_SIGNAL_EDGE on
 * Exchanging i and j must give -f, q_j, q_i to round-off, and q_i + q_j = f . (v_j - v_i). Then
 *     m_i dv_i/dt = sum_j f,   m_i du_i/dt = sum_j q_i
 * conserve momentum and energy whatever the forces are; see package.h for both forms of the energy.
 *
 * Traversal `gather` evaluates the whole row of each node. Traversal `pairs` works by tiles, runs of
 * consecutive nodes, which lie close together as nodes follow a curve: a pair within a tile is evaluated
 * once, when its first end has its turn, and given to both; a pair across tiles is evaluated by each of them.
 * A tile is summed by one thread, in ascending order, and tiles depend on the number of nodes alone, so no
 * result depends on the number of threads. Nothing is stored per pair. Canonical rows (connectivity.h) are
 * always gathered, as their sums must not depend on the order of nodes; so are rows with block time steps
 * where nodes have flags (nodes.h). With block steps a pair is given with its weights. Forces and heats are
 * multiplied by f_couple of their pair, which is the same for both ends and so keeps them conserved.
 *
 * A barrier node (package.h) is a wall to its neighbors: as a partner of i it has the state of i, with the
 * velocity along the line that joins them reversed; it does no work and conducts no heat. */
#ifndef KITH_PHYSICS_PASSES_FORCE_H
#define KITH_PHYSICS_PASSES_FORCE_H

#include "lib/core/lanes.h"
#include "physics/passes/partners.h"
#include "physics/passes/rates.h"
#include "physics/passes/sweep.h"

/* The first fields of every packed particle. */
enum { KITH_PACKED_X = 0, KITH_PACKED_V = NDIM, KITH_PACKED_OWN = 2 * NDIM };
enum { KITH_FORCE, KITH_HEAT = NDIM, KITH_PARTNER_HEAT, KITH_SIGNAL, KITH_PAIR_VALUES };

/* From this part of a support on, where forces vanish, partners have no signal speed. On even lattices, as a
 * line with 4 neighbors, nodes stand at the edge of a support but for round-off, which would decide whether
 * they count, and so how long a step is. */
#define KITH_SIGNAL_EDGE (1 - 1e-6)
/* Is a partner within one of both supports, at these parts of them? (With `||` loops do not vectorize.) */
#define KITH_HAS_SIGNAL(qi, qj) (((qi) < KITH_SIGNAL_EDGE) | ((qj) < KITH_SIGNAL_EDGE))

/* Rows are processed in blocks; a lane holds one field of all partners of a block. The stride is not a power
 * of two, for then lanes would share cache sets. */
enum { KITH_STRIDE = KITH_BLOCK + 8 };

KITH_INLINE double *kith_lane(const struct kith_scratch *s, int k) {
  return s->lane + (size_t)k * KITH_STRIDE;
}

#define J(m) j[(m)*KITH_STRIDE]
#define OUT(m) out[(m)*KITH_STRIDE]
typedef void kith_pair_function(enum kith_kernel kernel, const void *constants, const double *restrict i,
                                const double *restrict j, double *restrict out);

/* Packs node or ghost i. */
typedef void kith_force_packed(const struct kith_package *package, kith_index i, double *restrict packed);

/* Gives partner j, a frozen node, the corrections of i (terms of grad h, moments of the kernel): it has none
 * of its own, and where some nodes are corrected and others are not, gas at rest moves. */
typedef void kith_force_copy_corrections(const double *restrict i, double *restrict j);

struct kith_force_pass;
/* Loads n <= KITH_BLOCK partners of i and evaluates the pairs; values of edges are in the lanes already.
 * `partner` has `known` entries, which may go on with those of later nodes: some way ahead they are
 * prefetched. shift: which images the partners are (lib/nodes/shifts.h); NULL: they are nodes. */
typedef void kith_force_block(const struct kith_force_pass *pass, kith_index i,
                              const kith_index *restrict partner, const uint16_t *shift, size_t n,
                              size_t known, struct kith_scratch *scratch);

/* What a pair function needs that no evaluation changes. */
struct kith_force_form {
  kith_force_packed *pack;
  kith_force_copy_corrections *copy_corrections; /* NULL: particles have no corrections */
  int n_packed;                                  /* doubles of a particle */
  kith_force_block *evaluate[KITH_N_KERNELS];
};

/* One evaluation of all pairs of the connectivity. */
struct kith_force_pass {
  const struct kith_force_form *form;
  const void *constants; /* handed to the pair function */
  /* Fields that ghosts need, exchanged once the particles of internal nodes are packed. */
  struct kith_field *const *exchanged;
  int n_exchanged;
  /* Values of edges, from the start of a pair, whose other end has - edge; NULL: none. How many they are. */
  const struct kith_pairwise *edge;
  int edges;
  bool no_slip; /* the velocity of a barrier is that of i reversed, not only along the line that joins them */
  /* The rest is filled by kith_force. */
  struct kith_package *package;
  const struct kith_connectivity *connectivity;
  double *packed; /* particles, in the memory of kith_nodes_work */
  double *ticks; /* [nodes][4] last, step, next; NULL: (1) of block_steps.h is the same for all pairs, or 1 */
  const uint8_t *barrier;  /* [nodes] or NULL */
  const uint8_t *flag;     /* [nodes] flags (nodes.h); NULL: not needed */
  const double *f_couple;  /* [pairs] or NULL: 1 for all */
  int lanes;               /* lanes of scratch, without what the nodes of a tile are given */
  struct kith_rates rates; /* where the sums go */
};

/* Packs the first fields of particle i. */
static inline void kith_force_pack(const struct kith_hydro *hydro, kith_index i, double *restrict packed) {
  for (int a = 0; a < NDIM; ++a) {
    packed[KITH_PACKED_X + a] = hydro->nodes->position->f64[(size_t)i * NDIM + a];
    packed[KITH_PACKED_V + a] = hydro->velocity->f64[(size_t)i * NDIM + a];
  }
}

/* Return the lanes of the edges, which follow the fields padded to whole groups of lanes, and those of the
 * values of the pairs, which follow the edges. */
KITH_INLINE double *kith_force_edges(const struct kith_force_pass *pass, const struct kith_scratch *s) {
  return kith_lane(s, (int)kith_lanes_padded((size_t)pass->form->n_packed));
}
KITH_INLINE double *kith_force_values(const struct kith_force_pass *pass, const struct kith_scratch *s) {
  return kith_lane(s, (int)kith_lanes_padded((size_t)pass->form->n_packed) + pass->edges);
}

/* Particles are prefetched this many partners before they are loaded: a row or two, the time that memory
 * takes to answer. */
enum { KITH_AHEAD = 96 };
KITH_INLINE void kith_force_prefetch(const double *packed, size_t n_packed) {
  for (size_t m = 0; m < n_packed; m += 8) __builtin_prefetch(packed + m); /* 64 bytes a line */
}

/* Moves partners to their images. */
void kith_force_shift(const struct kith_force_pass *pass, const uint16_t *shift, size_t n,
                      struct kith_scratch *s);
/* Gives partners of i that are frozen its corrections. */
void kith_force_correct_frozen(const struct kith_force_pass *pass, kith_index i, const kith_index *partner,
                               size_t n, struct kith_scratch *s);
/* Gives partners of i that are barriers the mirrored state of i. */
void kith_force_mirror(const struct kith_force_pass *pass, kith_index i, const kith_index *partner, size_t n,
                       struct kith_scratch *s);

/* Does what a kith_force_block has to. Whole vectors are evaluated, with stale values after the last pair:
 * the compiler may contract products and sums differently in the remainder of a loop, and the values of a
 * pair must not depend on its position, which depends on the ranks; and remainders are slow. */
KITH_INLINE void kith_force_evaluate(kith_pair_function *pair, enum kith_kernel kernel, size_t n_packed,
                                     const struct kith_force_pass *pass, kith_index i,
                                     const kith_index *restrict partner, const uint16_t *shift, size_t n,
                                     size_t known, struct kith_scratch *s) {
  const size_t size = kith_lanes_padded(n_packed);
  const double *restrict packed = pass->packed, *restrict self = packed + (size_t)i * size;
  double *restrict j = s->lane, *restrict out = kith_force_values(pass, s);
  for (size_t k = 0; k < n; k += KITH_LANES) {
    kith_index room[KITH_LANES];
    const kith_index *four = kith_lanes_entries(partner, k, n, room);
    for (size_t l = k + KITH_AHEAD; l < KITH_MIN(k + KITH_AHEAD + KITH_LANES, known); ++l)
      kith_force_prefetch(packed + (size_t)partner[l] * size, n_packed);
    for (size_t m = 0; m < size; m += KITH_LANES) {
      const double *from[KITH_LANES];
      kith_lanes field[KITH_LANES];
      for (size_t l = 0; l < KITH_LANES; ++l) from[l] = packed + (size_t)four[l] * size + m;
      kith_lanes_transpose(from, field);
      for (size_t q = 0; q < KITH_LANES; ++q) *(kith_lanes *)(&J(m + q) + k) = field[q];
    }
  }
  if (shift != NULL) kith_force_shift(pass, shift, n, s);
  if (pass->flag != NULL && pass->form->copy_corrections != NULL)
    kith_force_correct_frozen(pass, i, partner, n, s);
  if (pass->barrier != NULL) kith_force_mirror(pass, i, partner, n, s);
  const size_t lanes = (n + 7) / 8 * 8;
#pragma omp simd
  for (size_t k = 0; k < lanes; ++k) pair(kernel, pass->constants, self, j + k, out + k);
  s->count[KITH_COUNT_EVALUATIONS] += n;
}

/* Compiles kith_force_evaluate with the function PAIR, of particles of N_PACKED fields, once per kernel, so
 * that the kernel is a constant in the loop over pairs. PAIR_form is the form for kith_force. */
#define KITH_FORCE_FORM(pair, n_packed, pack, copy_corrections) \
  enum { pair##_packed = n_packed };                            \
  KITH_KERNEL_LIST_WITH(KITH_FORCE_BLOCK_, pair)                \
  static const struct kith_force_form pair##_form = {           \
      pack, copy_corrections, n_packed, {KITH_KERNEL_LIST_WITH(KITH_KERNEL_CHUNK_NAME_, pair)}};
#define KITH_FORCE_BLOCK_(pair, name, ...)                                                                \
  KITH_HOT static void pair##_##name(const struct kith_force_pass *pass, kith_index i,                    \
                                     const kith_index *restrict partner, const uint16_t *shift, size_t n, \
                                     size_t known, struct kith_scratch *s) {                              \
    kith_force_evaluate(pair, KITH_KERNEL_##name, pair##_packed, pass, i, partner, shift, n, known, s);   \
  }

/* Packs the particles, sums the pairs, and stores the rates (rates.h). */
kith_status kith_force(struct kith_package *package, const struct kith_connectivity *connectivity,
                       const struct kith_kick *kick, struct kith_force_pass *pass);

#endif
