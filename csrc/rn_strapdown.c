#include "rn_strapdown.h"

#define EARTH_RATE R(7.292115e-5)
#define SEMI_MAJOR R(6378137.0)
#define FLATTENING R(0.0033528106647474805)
#define ECCENTRICITY_SQUARED R(0.0066943799901413165)
#define GRAVITY_EQUATOR R(9.7803253359)
#define SOMIGLIANA R(0.00193185265241)
#define GRAVITY_RATIO R(0.00344978650684)
#define LATITUDE_LIMIT R(1.5690509975429023) /* 89.9 deg */

RN_INLINE void cross(const real *a, const real *b, real *out)
{
    const real x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
    out[0] = x;
    out[1] = y;
    out[2] = z;
}

RN_INLINE void times(const real *M, const real *v, real *out)
{
    for (int i = 0; i < 3; i++) out[i] = M[3 * i] * v[0] + M[3 * i + 1] * v[1] + M[3 * i + 2] * v[2];
}

RN_INLINE void matrix(const real *q, real *C)
{
    const real x = q[1] + q[1], y = q[2] + q[2], z = q[3] + q[3];
    const real xx = x * q[1], yy = y * q[2], zz = z * q[3];
    const real xy = x * q[2], xz = x * q[3], yz = y * q[3], wx = x * q[0], wy = y * q[0], wz = z * q[0];
    C[0] = R(1.0) - (yy + zz);
    C[1] = xy - wz;
    C[2] = xz + wy;
    C[3] = xy + wz;
    C[4] = R(1.0) - (xx + zz);
    C[5] = yz - wx;
    C[6] = xz - wy;
    C[7] = yz + wx;
    C[8] = R(1.0) - (xx + yy);
}

RN_INLINE void multiply(const real *a, const real *b, real *out)
{
    const real w = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    const real x = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    const real y = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    const real z = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
    out[0] = w;
    out[1] = x;
    out[2] = y;
    out[3] = z;
}

/* Unit quaternion of a rotation vector.  Below 0.2 rad the series is exact to rounding, in double too. */
RN_INLINE void from_rotvec(const real *r, real *q)
{
    const real x = R(0.25) * (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
    real s;
    if (x < R(0.01)) {
        q[0] = R(1.0) - x * (R(0.5) - x * (R(1.0) / R(24.0) - x * (R(1.0) / R(720.0) - x * (R(1.0) / R(40320.0)))));
        s = R(0.5) - x * (R(1.0) / R(12.0) - x * (R(1.0) / R(240.0) - x * (R(1.0) / R(10080.0) - x * (R(1.0) / R(725760.0)))));
    } else {
        const real half = rn_sqrt(x);
        q[0] = rn_cos(half);
        s = R(0.5) * rn_sin(half) / half;
    }
    for (int i = 0; i < 3; i++) q[1 + i] = s * r[i];
}

/* One Newton step to unit norm: exact to rounding for a product of unit quaternions. */
RN_INLINE void renormalize(real *q)
{
    const real s = R(0.5) * (R(3.0) - (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]));
    for (int i = 0; i < 4; i++) q[i] *= s;
}

/* q <- Exp(turn) * q * dq */
RN_INLINE void turn_both(real *q, const real *turn, const real *dq)
{
    real left[4], product[4];
    from_rotvec(turn, left);
    multiply(left, q, product);
    multiply(product, dq, q);
    renormalize(q);
}

void RN(increments_start)(RN(increments) * i)
{
    for (int k = 0; k < 4; k++) i->q[k] = k == 0 ? R(1.0) : R(0.0);
    for (int k = 0; k < 3; k++) i->v[k] = R(0.0);
    for (int k = 0; k < 9; k++) {
        i->J[k] = i->H[k] = R(0.0);
        i->C[k] = k % 4 == 0 ? R(1.0) : R(0.0);
    }
}

/* Rotation vector and velocity of a sample, with coning, rotation and sculling; the sample joins the history. */
RN_INLINE void correct_sample(RN(imu_history) * history, const real *sample, real *rotation, real *velocity)
{
    const real *angle = sample, *speed = sample + 3;
    real slope[6], coning[3], turned[3], twice[3], sculling[3], other[3];
    for (int k = 0; k < 6; k++) slope[k] = (R(4.0) * history->past[1][k] - history->past[0][k]) * (R(1.0) / R(24.0));
    cross(slope, angle, coning);
    cross(angle, speed, turned);
    cross(angle, turned, twice);
    cross(slope, speed, sculling);
    cross(slope + 3, angle, other);
    for (int k = 0; k < 3; k++) {
        rotation[k] = angle[k] + coning[k];
        velocity[k] = speed[k] + R(0.5) * turned[k] + (R(1.0) / R(6.0)) * twice[k] + (sculling[k] + other[k]);
    }
    for (int k = 0; k < 6; k++) {
        history->past[0][k] = history->past[1][k];
        history->past[1][k] = sample[k];
    }
}

RN_INLINE void turn(RN(increments) * i, const real *rotation)
{
    real step[4];
    from_rotvec(rotation, step);
    multiply(i->q, step, i->q);
    matrix(i->q, i->C);
}

void RN(increments_add)(RN(increments) * i, RN(imu_history) * history, const real *sample, real dt)
{
    const real half = R(0.5) * dt;
    real rotation[3], velocity[3], step[3];
    correct_sample(history, sample, rotation, velocity);
    times(i->C, velocity, step);
    for (int k = 0; k < 3; k++) i->v[k] += step[k];
    /* The bias has turned the axes by J and half a sample more, and acts on the sample itself: hence half steps. */
    for (int k = 0; k < 9; k++) i->J[k] += half * i->C[k];
    for (int k = 0; k < 3; k++) {
        i->H[k] -= step[1] * i->J[6 + k] - step[2] * i->J[3 + k];
        i->H[3 + k] -= step[2] * i->J[k] - step[0] * i->J[6 + k];
        i->H[6 + k] -= step[0] * i->J[3 + k] - step[1] * i->J[k];
    }
    turn(i, rotation);
    for (int k = 0; k < 9; k++) i->J[k] += half * i->C[k];
}

void RN(increments_add_plain)(RN(increments) * i, RN(imu_history) * history, const real *sample)
{
    real rotation[3], velocity[3], step[3];
    correct_sample(history, sample, rotation, velocity);
    times(i->C, velocity, step);
    for (int k = 0; k < 3; k++) i->v[k] += step[k];
    turn(i, rotation);
}

void RN(increments_corrected)(const real *row, const real *gyro_bias, const real *accel_bias, real *q, real *v)
{
    const real *J = row + 7, *H = row + 16;
    real angle[3], by_accel[3], by_gyro[3], left[4];
    times(J, gyro_bias, angle);
    times(J, accel_bias, by_accel);
    times(H, gyro_bias, by_gyro);
    for (int k = 0; k < 3; k++) {
        angle[k] = -angle[k];
        v[k] = row[4 + k] - by_accel[k] - by_gyro[k];
    }
    from_rotvec(angle, left);
    multiply(left, row, q);
}

void RN(static_step)(real *q, real *v, const real *dq, const real *dv, const real *earth_rate, const real *gravity, real T)
{
    real C[9], a[3], mean[3], turned[3], back[3];
    matrix(q, C);
    times(C, dv, a);
    for (int k = 0; k < 3; k++) mean[k] = R(2.0) * v[k] + R(0.5) * a[k];
    cross(earth_rate, mean, turned);
    for (int k = 0; k < 3; k++) {
        v[k] += a[k] + T * (gravity[k] - turned[k]);
        back[k] = -T * earth_rate[k];
    }
    turn_both(q, back, dq);
}

/* The Earth under a point: radii of curvature through it along the meridian and across [m], normal gravity [m/s^2]. */
typedef struct {
    real sine, cosine, meridian, transverse, gravity;
} RN(earth);

RN_INLINE void earth_at(RN(earth) * e, real sine, real cosine, real height)
{
    const real s2 = sine * sine, under = R(1.0) / rn_sqrt(R(1.0) - ECCENTRICITY_SQUARED * s2);
    const real across = SEMI_MAJOR * under, ratio = height * (R(1.0) / SEMI_MAJOR);
    const real linear = R(2.0) * (R(1.0) + FLATTENING + GRAVITY_RATIO - R(2.0) * FLATTENING * s2);
    e->sine = sine;
    e->cosine = cosine;
    e->meridian = across * (R(1.0) - ECCENTRICITY_SQUARED) * under * under + height;
    e->transverse = across + height;
    e->gravity = GRAVITY_EQUATOR * (R(1.0) + SOMIGLIANA * s2) * under * (R(1.0) - ratio * (linear - R(3.0) * ratio));
}

/* Half an interval after latitude and height `at`, at velocity v.  The turn is small: 3e-5 rad in a second at 300 m/s. */
RN_INLINE void earth_half_way(RN(earth) * e, const real *at, const real *v, real T)
{
    const real sine = rn_sin(at[0]), cosine = rn_cos(at[0]);
    earth_at(e, sine, cosine, at[2]);
    const real half = R(0.5) * T, turn = half * v[0] / e->meridian, square = R(1.0) - R(0.5) * turn * turn;
    earth_at(e, sine * square + cosine * turn, cosine * square - sine * turn, at[2] - half * v[2]);
}

int RN(navigation_step)(real *x, const real *dq, const real *dv, real T)
{
    real *q = x, *v = x + 4, *position = x + 7;
    real C[9], a[3], mid[3], end[3], turned[3], lag[3], back[3];
    RN(earth) e;
    matrix(q, C);
    times(C, dv, a);
    earth_half_way(&e, position, v, T);
    const real per_north = R(1.0) / e.meridian, per_east = R(1.0) / e.transverse, per_cosine = R(1.0) / e.cosine;
    const real w_north = EARTH_RATE * e.cosine, w_down = -EARTH_RATE * e.sine, half = R(0.5) * T;
    const real per_turn = per_east * e.sine * per_cosine;

    /* half-way velocity, by the rates at the start velocity */
    real rate[3] = {R(2.0) * w_north + v[1] * per_east, -v[0] * per_north, R(2.0) * w_down - v[1] * per_turn};
    cross(rate, v, turned);
    for (int k = 0; k < 3; k++) mid[k] = v[k] + R(0.5) * a[k] - half * turned[k];
    mid[2] += half * e.gravity;

    rate[0] = R(2.0) * w_north + mid[1] * per_east;
    rate[1] = -mid[0] * per_north;
    rate[2] = R(2.0) * w_down - mid[1] * per_turn;
    cross(rate, mid, turned);
    rate[0] -= w_north;
    rate[2] -= w_down; /* now of navigation axes against inertial space */
    cross(rate, a, lag);
    for (int k = 0; k < 3; k++) {
        end[k] = v[k] + a[k] - T * (R(0.5) * lag[k] + turned[k]);
        back[k] = -T * rate[k];
    }
    end[2] += T * e.gravity;
    turn_both(q, back, dq);
    position[0] += half * (v[0] + end[0]) * per_north;
    position[1] += half * (v[1] + end[1]) * per_east * per_cosine;
    position[2] -= half * (v[2] + end[2]);
    for (int k = 0; k < 3; k++) v[k] = end[k];
    return !(position[0] >= -LATITUDE_LIMIT && position[0] <= LATITUDE_LIMIT);
}
