/* riemann.h - pressure and speed of the contact between two gases, along the normal of a face that moves with
 * it.
 *
 * HLLC (Toro, Spruce and Speares 1994, Shock Waves 4, 25): with wave speeds S_L = u_L - q_L / rho_L and S_R =
 * u_R + q_R / rho_R
 *     S* = (q_L u_L + q_R u_R + P_L - P_R) / (q_L + q_R),  P* = (q_R P_L + q_L P_R + q_L q_R (u_L - u_R)) /
 *     (q_L + q_R)
 * A face without mass flux needs only P* and S*, which follow from the mass fluxes q through the waves, and
 * these from the difference w of the velocities across the wave (w > 0 compresses):
 *     shock        q = rho (A w + sqrt(c^2 + A^2 w^2)),  A = (gamma + 1) / 4
 *     rarefaction  q = rho c (1 - R(x)) / x,  x = -gamma w / c,  R = (1 - x / n)^n,  n = 2 gamma / (gamma -
 *                  1)
 * both exact for ideal and stiffened gases and, with gamma = 1, for isothermal ones. R is replaced by (1 - x
 * / 8)^8 (1 + b x^2), equal to it up to x^2, so that only square roots are called and loops over pairs
 * vectorize. The jumps follow from S*, found in two rounds from S* of q = rho (c + 2 A w), w a share of the
 * approach: exact for two gases alike.
 *
 * Measured against the exact solver (tests/unit/physics/mfm/test_mfm_riemann.c), error of P*: 1e-6 for jumps
 * of 10 %, 0.002 for jumps of the order of the state; Sod's states -0.03. Estimates that give an expansion
 * the sound speed as its wave speed (Davis, Einfeldt, Toro's) are off by -0.3 there, and below zero at 1-2-3.
 *
 * Symmetric to the last bit: exchanged sides with reversed velocities give the same P* and the opposite S*.
 * Equal pressures and velocities are kept to the last bit. P* is never below the pressure of the gas at zero
 * density. */
#ifndef KITH_PHYSICS_MFM_RIEMANN_H
#define KITH_PHYSICS_MFM_RIEMANN_H

#include <math.h>
#include "lib/core/base.h"

/* gamma of the material; velocity along the normal, which points from left to right. */
struct mfm_side {
  double density, velocity, pressure, sound, gamma, inverse_gamma;
};

struct mfm_star {
  double pressure, velocity;
};

/* Returns the mass flux q through the wave that changes the velocity of `s` by w. c: the sound speed, not 0;
 * x: of the rarefaction, at least 1e-5; inverse_cx: 1 / (c x). */
KITH_INLINE double mfm_mass_flux(struct mfm_side s, double w, double c, double x, double inverse_cx) {
  const double a = 0.25 * (s.gamma + 1) * w, shock = a + sqrt(c * c + a * a);
  const double y = KITH_MAX(1 - 0.125 * x, 0.0), y2 = y * y, y4 = y2 * y2;
  const double b = 0.25 * s.inverse_gamma - 0.1875; /* 1 / 16 - (gamma - 1) / (4 gamma) */
  const double rest = y4 * y4 * KITH_MAX(1 + b * x * x, 0.0);
  return s.density * (w > 0 ? shock : c * c * (1 - rest) * inverse_cx);
}

KITH_INLINE struct mfm_star mfm_contact(struct mfm_side l, struct mfm_side r, double ql, double qr) {
  const double per_sum = 1 / KITH_MAX(ql + qr, 1e-300), dp = l.pressure - r.pressure,
               du = l.velocity - r.velocity, dq = 0.5 * (ql - qr);
  return (struct mfm_star){0.5 * (l.pressure + r.pressure) + (ql * qr * du - dq * dp) * per_sum,
                           0.5 * (l.velocity + r.velocity) + (dq * du + dp) * per_sum};
}

/* Returns the pressure at zero density: 0, of a stiffened gas -P0. */
KITH_INLINE double mfm_vacuum(struct mfm_side s) {
  return s.pressure - s.density * s.sound * s.sound * s.inverse_gamma;
}

KITH_INLINE struct mfm_star mfm_riemann(struct mfm_side l, struct mfm_side r) {
  const double zl = l.density * l.sound, zr = r.density * r.sound,
               approach = KITH_MAX(l.velocity - r.velocity, 0.0);
  const double push = 0.5 * approach / KITH_MAX(zl + zr, 1e-300);
  double ql = zl + l.density * (l.gamma + 1) * zr * push, qr = zr + r.density * (r.gamma + 1) * zl * push;
  struct mfm_star star = mfm_contact(l, r, ql, qr);
  /* A division takes the time of ten products: both sides share one. */
  const double cl = KITH_MAX(l.sound, 1e-100), cr = KITH_MAX(r.sound, 1e-100), inverse_c = 1 / (cl * cr);
  for (int k = 0; k < 2; ++k) {
    const double wl = l.velocity - star.velocity, wr = star.velocity - r.velocity;
    const double cxl = KITH_MAX(-l.gamma * wl, 1e-5 * cl), /* c x; the limit x -> 0 is c */
        cxr = KITH_MAX(-r.gamma * wr, 1e-5 * cr), inverse_cx = 1 / (cxl * cxr);
    ql = mfm_mass_flux(l, wl, cl, cxl * cr * inverse_c, cxr * inverse_cx);
    qr = mfm_mass_flux(r, wr, cr, cxr * cl * inverse_c, cxl * inverse_cx);
    star = mfm_contact(l, r, ql, qr);
  }
  star.pressure = KITH_MAX(star.pressure, KITH_MAX(mfm_vacuum(l), mfm_vacuum(r)));
  return star;
}

#endif
