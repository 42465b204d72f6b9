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
