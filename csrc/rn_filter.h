/* One step of each filter over any model.  No allocation, no globals; every array belongs to the caller. */
#ifndef RN_FILTER_H
#define RN_FILTER_H

#include "rn_model.h"

/* What a reading told the filter before it was used, in the rows it is fused as (unscented: one a number); s is NaN for a
 * constant gain. */
typedef struct {
    real nu[RN_MAX_ROWS]; /* measured minus predicted, row after row */
    real s[RN_MAX_ROWS];  /* predicted variance of each */
    real nis;             /* sum of nu^2 / s */
    real weight;          /* 0: refused by the rule or by a covariance that lost definiteness */
} RN(seen);

/* Sigma-point spread: lambda = alpha^2 (n + kappa) - n; weights of the centre for mean and covariance. */
typedef struct {
    real spread;      /* n + lambda, the squared distance of the points in standard deviations */
    real mean_centre; /* lambda / (n + lambda) */
    real cov_centre;  /* the same + 1 - alpha^2 + beta */
} RN(unscented);

/* Constant-gain correction with the sensors whose bits are set in mask, their readings one after the other in z.
 * K: ne x rows of all sensors; r: residual rows of all sensors, zero where absent. */
void RN(fixed_correct)(const RN(model) * m, real *x, const real *K, const real *z, int mask, const real *p, real *r);

/* Numbers of scratch the unscented steps need. */
int RN(ukf_scratch)(const RN(model) * m);

/* Unscented prediction; returns 1 and changes nothing if P is not positive definite. */
int RN(ukf_predict)(const RN(model) * m, const RN(unscented) * w, real *x, real *P, const real *u, const real *q,
                    const real *p, real dt, real *scratch);

/* Unscented update, all or nothing like the extended one: refused if the rule says so, nis is not finite, or S or P is not
 * positive definite, P as far as the errors that the sensor sees: the next prediction looks at all of it. */
void RN(ukf_update)(const RN(model) * m, const RN(unscented) * w, int sensor, real *x, real *P, const real *z,
                    real variance, RN(rule) rule, const real *p, RN(seen) * seen, real *scratch);

/* Enlarge the covariance of a Kalman update to that of the H-infinity filter with bound gamma on L e; L: rows x n, scratch:
 * RN_PACKED(n).  margin: smallest pivot of gamma^2 I - L P L' over gamma^2.  Returns 1 and changes nothing where no such
 * filter exists. */
int RN(hinf_enlarge)(real *P, const real *L, int rows, int n, real gamma_squared, real *margin, real *scratch);

#endif
