/* Strapdown integration: inertial samples to increments over an interval, increments to attitude, velocity, position.
 * No allocation, no globals; every array belongs to the caller.  Formulas: docs/strapdown.md.
 *
 * A sample is 6 numbers: body rate integrated over it [rad], specific force integrated over it [m/s]. */
#ifndef RN_STRAPDOWN_H
#define RN_STRAPDOWN_H

#include "rn_real.h"

#define RN_SAMPLE 6
#define RN_INCREMENTS 25
#define RN_NAVIGATION 10

/* The last two samples: [0] the older.  Before the first sample of a recording: both that sample, or continued backwards. */
typedef struct {
    real past[2][RN_SAMPLE];
} RN(imu_history);

/* Over an interval so far. */
typedef struct {
    real q[4]; /* attitude now, in body axes of the start */
    real v[3]; /* specific force integrated, in those axes [m/s] */
    real J[9]; /* by rows: q turns (left) by -J gyro_bias, v changes by -J accel_bias [s] */
    real H[9]; /* v changes by -H gyro_bias [m] */
    real C[9]; /* matrix of q */
} RN(increments);

void RN(increments_start)(RN(increments) * i);

/* Take in the next sample, `dt` seconds long. */
void RN(increments_add)(RN(increments) * i, RN(imu_history) * history, const real *sample, real dt);

/* The same without J and H. */
void RN(increments_add_plain)(RN(increments) * i, RN(imu_history) * history, const real *sample);

/* Rotation q (4) and velocity v (3) of finished increments, free of biases (gyro [rad/s], accelerometer [m/s^2]) to first
 * order.  row: q v J H, 25 numbers. */
void RN(increments_corrected)(const real *row, const real *gyro_bias, const real *accel_bias, real *q, real *v);

/* Attitude q (4) and velocity v (3) of a carrier that sways at one place, an interval of T seconds later.
 * dq, dv: rotation and velocity over the interval; earth_rate, gravity: in navigation axes. */
void RN(static_step)(real *q, real *v, const real *dq, const real *dv, const real *earth_rate, const real *gravity, real T);

/* Navigation state x (10): q_nb, v_n [m/s], latitude, longitude [rad], height [m], an interval of T seconds later, on
 * WGS-84.  Returns 1, with x moved, where the latitude leaves the limit or is not finite; else 0.
 * In float a latitude is good for half a metre only. */
int RN(navigation_step)(real *x, const real *dq, const real *dv, real T);

#endif
