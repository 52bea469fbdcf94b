/* faces.h - the faces between nodes of a meshless method: one vector area A_ij per pair, from i to j.
 *
 * Faces carry fluxes, so A_ji = -A_ij. One-point faces are computed in the pair function, from fields of
 * both ends, which is faster than to keep them. Integrated ones are kept as a pairwise field, from the node
 * that the pair starts at (connectivity.h). V = 1 / n is the volume of a node.
 *
 *   one-point   between neighbors (Hopkins 2015, MNRAS 450, 53):
 *                   A_ij = V_i psi~_j(x_i) - V_j psi~_i(x_j) = w_ij (V_i M_i^-1 + V_j M_j^-1) (x_j - x_i)
 *               with M_i and w_ij of slope.h, which has the reasons for these weights: -W'(q) / q by the mean
 *               of both supports, in 1-D W(q). Hopkins has W(r_ij / H_i) in M_i and in its part of A_ij.
 *               Both matrices are positive, so a face always points towards the neighbor.
 *               In a face V_i counts as 16 V_j at most, and V_j likewise. A node that has left the gas has
 *               its partners at the far edge of its support. The pressure of gas that is 10^4 times as dense
 *               would press on it there, through faces as large as its volume, and throw it away.
 *   integrated  between all nodes whose supports share a node, the integral by its definition:
 *                   A_ij = sum_k V_k (psi_i grad psi_j - psi_j grad psi_i)(x_k), psi_i(x) = W(x - x_i, H_i) /
 *                   s(x), s = sum_l W(x - x_l, H_l)
 *                        = sum_k (P_ik grad P_jk - P_jk grad P_ik),  P_ik = W(x_k - x_i, H_i) sqrt(V_k) /
 *                        s(x_k)
 *               as the derivatives of s cancel. k runs over the nodes in both supports, i and j among them.
 *               No matrix has to be inverted; overlap and rows of ghosts are required. A sum over few nodes
 *               is not the integral: on a lattice sum_j A_ij (x_j - x_i) is less than 2 V by 9, 5, 3 % in
 *               1-D, 2-D, 3-D, and so is every acceleration. So faces are stretched,
 *                   A_ij *= (s_i + s_j) / 2,  s_i = 2 V_i d / tr sum_j A_ij (x_j - x_i)
 *                                                  (1)
 *               exact on lattices; on nodes 0.3 spacings off (2-D) the error of the sum is 0.12 instead of
 *               0.19, that of one-point faces with w = W.
 *
 * On disordered nodes neither form closes, sum_j A_ij != 0, so a uniform pressure accelerates nodes.
 * Measured for nodes of unit volume, up to 0.3 spacings off a square lattice, 20 neighbors
 * (tests/unit/physics/mfm/test_mfm_faces.c):  mean |sum A|  0.38 one-point, 0.18 integrated;  mean sum |A|
 * 3.3, 2.5;  faces  19, 64. Less area is not less dissipation: open integrated faces disorder the nodes where
 * one-point faces order them, and Gresho's vortex is lost with them. Faces closed by a solver, with the
 * least sum of |dA|^2, were here before version 0.2. They hold an even pressure on any nodes to round-off,
 * but nothing then orders the nodes: the density of Gresho's vortex was off by 7 to 19 times as much as with
 * open faces, Sedov's in 2-D, Toro 3 and Noh in 1-D by twice, for 3 to 25 times the time. With volumes that
 * follow the faces, dV/dt = sum A . v, Toro 3 and Noh stop within 100 steps. */
#ifndef KITH_PHYSICS_MFM_FACES_H
#define KITH_PHYSICS_MFM_FACES_H

#include "lib/core/symmetric.h"
#include "physics/passes/slope.h"

/* Forms of the faces, choices in a scene. */
#define MFM_FACES_LIST(X) X(ONE_POINT, one_point) X(INTEGRATED, integrated)
enum mfm_faces_form {
#define X(name, word) MFM_FACES_##name,
  MFM_FACES_LIST(X)
#undef X
};

struct mfm_faces {
  /* Set by the caller. Borrowed. */
  enum mfm_faces_form form;
  struct kith_nodes *nodes;
  struct kith_halo *halo; /* of the hydro state; NULL: one process */
  enum kith_kernel kernel;
  double neighbors;             /* V = ball H^d / neighbors */
  struct kith_profile *profile; /* may be NULL */
  /* Fields, registered by kith_mfm_faces_init. */
  struct kith_field *matrix;     /* one-point: V M^-1, upper triangle: slope.h */
  struct kith_field *quadrature; /* integrated: sqrt(V) / s */
  struct kith_field *stretch;    /* integrated: s_i - 1 of (1) */

  /* The pairs that have an integrated face, as connectivity of their own, so that passes over pairs run on
   * it: views of the overlap of internal nodes and of its pairs. */
  struct kith_connectivity graph;
  struct kith_pairwise *area; /* of these pairs, from the first end to the second */

  /* integrated: the holders of each node k, that is itself and then the nodes whose support holds it,
   * ascending; for each of them P_jk and its gradient */
  struct kith_rows holders;
  double *value; /* [entries of holders][KITH_LANES] */
  size_t value_capacity;
};

/* Registers fields. */
kith_status kith_mfm_faces_init(struct mfm_faces *faces);
void kith_mfm_faces_clear(struct mfm_faces *faces);
struct kith_requirements kith_mfm_faces_requirements(const struct mfm_faces *faces);

/* Computes all integrated faces. Ghosts must have their supports; the fields of the faces are refreshed here.
 * Collective: all ranks agree on the status. */
kith_status kith_mfm_faces_build(struct mfm_faces *faces, const struct kith_connectivity *connectivity);

/* Computes the one-point face from i to j, d = x_j - x_i, r = |d|, from 1 / H and the matrix of both. The
 * components of the matrix of j are `stride` apart. */
KITH_INLINE void mfm_one_point_face(enum kith_kernel kernel, double r, const double *restrict d,
                                    double inverse_i, const double *restrict matrix_i, double inverse_j,
                                    const double *restrict matrix_j, int stride, double *restrict face) {
  const double largest_volume = 16, ratio = kith_pow_dim(inverse_i / inverse_j), /* V_j / V_i */
      share_i = KITH_MIN(1, largest_volume * ratio), share_j = KITH_MIN(1, largest_volume / ratio);
  double matrix[KITH_SYMMETRIC_SIZE];
  for (int m = 0; m < KITH_SYMMETRIC_SIZE; ++m)
    matrix[m] = share_i * matrix_i[m] + share_j * matrix_j[m * stride];
  kith_symmetric_times(kith_pair_weight(kernel, r, 2 * inverse_i * inverse_j / (inverse_i + inverse_j)),
                       matrix, 1, d, face);
}

#endif
