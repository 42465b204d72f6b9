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

/* The covariance about an attitude corrected by `turn`, whose error stands at `at` of n: J P J' with J the left Jacobian of the
 * turn (docs/models.md, section 3); for an error in body axes call it with the turn reversed. */
RN_INLINE void rn_transport(real *P, int n, int at, real t0, real t1, real t2)
{
    const real square = t0 * t0 + t1 * t1 + t2 * t2, a = rn_sqrt(square);
    real first = R(0.5) - square / R(24.0) + square * square / R(720.0);
    real second = R(1.0) / R(6.0) - square / R(120.0) + square * square / R(5040.0);
    if (!(square < R(0.01))) {
        first = (R(1.0) - rn_cos(a)) / square;
        second = (a - rn_sin(a)) / (square * a);
    }
    const real J[3][3] = {
        {R(1.0) + second * (t0 * t0 - square), second * t0 * t1 - first * t2, second * t0 * t2 + first * t1},
        {second * t0 * t1 + first * t2, R(1.0) + second * (t1 * t1 - square), second * t1 * t2 - first * t0},
        {second * t0 * t2 - first * t1, second * t1 * t2 + first * t0, R(1.0) + second * (t2 * t2 - square)}};
    for (int j = 0; j < n; j++) {
        real *in[3], v[3];
        for (int i = 0; i < 3; i++) {
            const int low = j < at + i ? j : at + i, high = j < at + i ? at + i : j;
            in[i] = P + low * (2 * n - low - 1) / 2 + high;
            v[i] = *in[i];
        }
        if (j >= at && j < at + 3) continue;
        for (int i = 0; i < 3; i++) *in[i] = J[i][0] * v[0] + J[i][1] * v[1] + J[i][2] * v[2];
    }
    real *B[3] = {P + at * (2 * n - at - 1) / 2 + at, P + (at + 1) * (2 * n - at - 2) / 2 + at + 1,
                  P + (at + 2) * (2 * n - at - 3) / 2 + at + 2};
    const real S[3][3] = {{B[0][0], B[0][1], B[0][2]}, {B[0][1], B[1][0], B[1][1]}, {B[0][2], B[1][1], B[2][0]}};
    for (int i = 0; i < 3; i++) {
        real row[3];
        for (int k = 0; k < 3; k++) row[k] = J[i][0] * S[0][k] + J[i][1] * S[1][k] + J[i][2] * S[2][k];
        for (int k = i; k < 3; k++) B[i][k - i] = row[0] * J[k][0] + row[1] * J[k][1] + row[2] * J[k][2];
    }
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
