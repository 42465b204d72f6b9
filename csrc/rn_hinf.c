/* The H-infinity half of an update: a Kalman covariance enlarged where the bound asks for it. */
#include "rn_filter.h"

#include <string.h>

/* Row by row the covariance half of a scalar measurement of variance -gamma^2; the d are the squared pivots of the Cholesky
 * factor of gamma^2 I - L P L', so that a d that is not positive is the failed existence condition itself. */
RN_VECTORISED int RN(hinf_enlarge)(real *P, const real *L, int rows, int n, real gamma_squared, real *margin, real *scratch)
{
    real PH[RN_MAX_STATE], *Q = scratch;
    memcpy(Q, P, (size_t)RN_PACKED(n) * sizeof(real));
    *margin = (real)INFINITY;
    for (int r = 0; r < rows; r++, L += n) {
        for (int i = 0; i < n; i++) PH[i] = R(0.0);
        for (int c = 0; c < n; c++) {
            const real weight = L[c];
            if (weight == R(0.0)) continue;
            int at = c;
            for (int i = 0; i < c; at += n - 1 - i, i++) PH[i] += weight * Q[at];
            for (int i = c; i < n; i++) PH[i] += weight * Q[at + i - c];
        }
        real d = gamma_squared;
        for (int c = 0; c < n; c++) d -= L[c] * PH[c];
        const real left = d / gamma_squared;
        if (!(left >= *margin)) *margin = left;
        if (!(d > R(0.0))) return 1;
        const real inverse = R(1.0) / d;
        for (int i = 0, k = 0; i < n; i++) {
            const real scaled = PH[i] * inverse;
            for (int j = i; j < n; j++) Q[k++] += scaled * PH[j];
        }
    }
    memcpy(P, Q, (size_t)RN_PACKED(n) * sizeof(real));
    return 0;
}
