/* arkode.h - the names of the Runge-Kutta tables of scheme arkode (SUNDIALS' ERKStep). */
#ifndef KITH_INTEGRATOR_SCHEMES_ARKODE_H
#define KITH_INTEGRATOR_SCHEMES_ARKODE_H

/* Runge-Kutta tables of ARKODE: its constant without ARKODE_, word of the scene. */
#define KITH_TABLE_LIST(X)                          \
  X(HEUN_EULER_2_1_2, heun_euler_2_1_2)             \
  X(BOGACKI_SHAMPINE_4_2_3, bogacki_shampine_4_2_3) \
  X(ARK324L2SA_ERK_4_2_3, ark324l2sa_erk_4_2_3)     \
  X(KNOTH_WOLKE_3_3, knoth_wolke_3_3)               \
  X(ZONNEVELD_5_3_4, zonneveld_5_3_4)               \
  X(ARK436L2SA_ERK_6_3_4, ark436l2sa_erk_6_3_4)     \
  X(ARK437L2SA_ERK_7_3_4, ark437l2sa_erk_7_3_4)     \
  X(SAYFY_ABURUB_6_3_4, sayfy_aburub_6_3_4)         \
  X(CASH_KARP_6_4_5, cash_karp_6_4_5)               \
  X(FEHLBERG_6_4_5, fehlberg_6_4_5)                 \
  X(DORMAND_PRINCE_7_4_5, dormand_prince_7_4_5)     \
  X(ARK548L2SA_ERK_8_4_5, ark548l2sa_erk_8_4_5)     \
  X(ARK548L2SAb_ERK_8_4_5, ark548l2sab_erk_8_4_5)   \
  X(VERNER_8_5_6, verner_8_5_6)                     \
  X(FEHLBERG_13_7_8, fehlberg_13_7_8)

#endif
