/* The scalar update every covariance filter shares: packed, symmetric by construction. */
#ifndef RN_UPDATE_H
#define RN_UPDATE_H

#include <string.h>

#include "rn_real.h"

/* A host trades flash for time and unrolls the loops, whose bounds are constants; a microcontroller does not. */
#if defined(RN_UNROLL) && defined(__clang__)
#define RN_UNROLLED _Pragma("clang loop unroll(full)")
#elif defined(RN_UNROLL) && defined(__GNUC__)
#define RN_UNROLLED _Pragma("GCC unroll 16")
#else
#define RN_UNROLLED
#endif

/* How a reading is weighted by how far off it is. */
enum { RN_RULE_GATE, RN_RULE_HUBER, RN_RULE_STUDENT };
typedef struct {
    int kind;
    real limit; /* gate: largest nis; Huber: sqrt(nis) where the weight starts to fall; Student-t: degrees of freedom */
} RN(rule);

/* The weight in [0, 1] of a reading with nis = sum nu^2 / s over its rows; 0, or NaN for a NaN: not to be used. */
RN_INLINE real rn_weight(RN(rule) rule, real nis, real rows)
{
    real weight = nis <= rule.limit && nis < (real)INFINITY ? R(1.0) : R(0.0);
    if (rule.kind == RN_RULE_HUBER)
        weight = rule.limit / rn_sqrt(nis);
    else if (rule.kind == RN_RULE_STUDENT)
        weight = (rule.limit + rows) / (rule.limit + nis);
    return weight > R(1.0) ? R(1.0) : weight;
}

/* Correction dx and covariance L of a full update, made those of an update whose gain is weighted: L <- P + weight (L - P). */
RN_INLINE void rn_soften(real *L, const real *P, int packed, real *dx, int n, real weight)
{
    for (int i = 0; i < packed; i++) L[i] = P[i] + weight * (L[i] - P[i]);
    for (int i = 0; i < n; i++) dx[i] *= weight;
}

/* PH = P h', s = h PH + variance, nu the residual left after what dx already explains; nis grows by nu^2 / s.
 * Returns 1 and leaves P and dx alone when s is NaN or has lost definiteness (0.999: margin for rounding). */
RN_INLINE int rn_scalar_update(real *P, real *dx, const real *PH, int n, real s, real variance, real nu, real *nis)
{
    const real inverse = R(1.0) / s;
    *nis += nu * nu * inverse;
    if (!(s > R(0.999) * variance)) return 1;
    int k = 0;
    RN_UNROLLED
    for (int i = 0; i < n; i++) {
        const real gain = PH[i] * inverse;
        dx[i] += gain * nu;
        RN_UNROLLED
        for (int j = i; j < n; j++) P[k++] -= gain * PH[j];
    }
    return 0;
}

#endif
