/* What the constant-gain attitude filters share.  q_nb: Hamilton, w first, body to navigation; rotations are given as half
 * rotation vectors, (1, h) being the small quaternion.  Everything is inlined into straight-line code: no loop, no call, no
 * division, no library function.  Sums are ordered so that fused multiply-adds need no register copies. */
#ifndef RN_STEPS_H
#define RN_STEPS_H

#include "rn_real.h"

/* to <- q * (c, h) with c = 1.5 - (|q|^2 + |h|^2) / 2: a turn by 2 h in body axes and one Newton step to unit norm.  Returns c;
 * it is near 1, and not above 0 if h is absurd.  The angle is short by the share |2 h|^2 / 24. */
RN_INLINE real rn_turn_body(const real q[4], const real h[3], real to[4])
{
    const real squares = (q[0] * q[0]) + (q[1] * q[1]) + (q[2] * q[2]) + (q[3] * q[3]);
    const real c = R(1.5) - (R(0.5) * (squares + (h[0] * h[0]) + (h[1] * h[1]) + (h[2] * h[2])));
    to[0] = (c * q[0]) - (h[0] * q[1]) - (h[1] * q[2]) - (h[2] * q[3]);
    to[1] = (c * q[1]) + (h[0] * q[0]) + (h[2] * q[2]) - (h[1] * q[3]);
    to[2] = (c * q[2]) + (h[1] * q[0]) + (h[0] * q[3]) - (h[2] * q[1]);
    to[3] = (c * q[3]) + (h[2] * q[0]) + (h[1] * q[1]) - (h[0] * q[2]);
    return c;
}

/* to <- (1, t) * q: a turn by 2 t in navigation axes; the next rn_turn_body makes up for the norm. */
RN_INLINE void rn_turn_navigation(const real q[4], const real t[3], real to[4])
{
    to[0] = q[0] - ((q[1] * t[0]) + (q[2] * t[1]) + (q[3] * t[2]));
    to[1] = q[1] + ((q[3] * t[1]) - (q[2] * t[2]) + (q[0] * t[0]));
    to[2] = q[2] + ((q[1] * t[2]) - (q[3] * t[0]) + (q[0] * t[1]));
    to[3] = q[3] + ((q[2] * t[0]) - (q[1] * t[1]) + (q[0] * t[2]));
}

/* c <- C_nb / 2, by rows. */
RN_INLINE void rn_half_matrix(const real q[4], real c[9])
{
    c[1] = (q[1] * q[2]) - (q[0] * q[3]);
    c[3] = (q[1] * q[2]) + (q[0] * q[3]);
    c[2] = (q[1] * q[3]) + (q[0] * q[2]);
    c[6] = (q[1] * q[3]) - (q[0] * q[2]);
    c[5] = (q[2] * q[3]) - (q[0] * q[1]);
    c[7] = (q[2] * q[3]) + (q[0] * q[1]);
    c[0] = R(0.5) - (q[3] * q[3]) - (q[2] * q[2]);
    c[4] = R(0.5) - (q[3] * q[3]) - (q[1] * q[1]);
    c[8] = R(0.5) - (q[1] * q[1]) - (q[2] * q[2]);
}

/* One row of a matrix times a vector. */
RN_INLINE real rn_row(const real c[3], const real v[3])
{
    return (c[0] * v[0]) + (c[1] * v[1]) + (c[2] * v[2]);
}

/* to <- v + C_bn w, with C_nb / 2 in c and w twice as long as meant. */
RN_INLINE void rn_add_in_body(const real c[9], const real w[3], real v[3])
{
    v[0] = v[0] + (c[0] * w[0]) + (c[3] * w[1]) + (c[6] * w[2]);
    v[1] = v[1] + (c[1] * w[0]) + (c[4] * w[1]) + (c[7] * w[2]);
    v[2] = v[2] + (c[2] * w[0]) + (c[5] * w[1]) + (c[8] * w[2]);
}

/* u <- a x b. */
RN_INLINE void rn_cross(const real a[3], const real b[3], real u[3])
{
    u[0] = (a[1] * b[2]) - (a[2] * b[1]);
    u[1] = (a[2] * b[0]) - (a[0] * b[2]);
    u[2] = (a[0] * b[1]) - (a[1] * b[0]);
}

/* to <- d turned with the body: C_bn of a turn by 2 h times d, to third order in h. */
RN_INLINE void rn_turn_vector(const real d[3], const real h[3], real to[3])
{
    const real s = R(1.0) - (R(0.6666667) * ((h[0] * h[0]) + (h[1] * h[1]) + (h[2] * h[2])));
    real v[3];
    rn_cross(h, d, v);
    to[0] = d[0] - (R(2.0) * ((s * v[0]) - ((h[1] * v[2]) - (h[2] * v[1]))));
    to[1] = d[1] - (R(2.0) * ((s * v[1]) - ((h[2] * v[0]) - (h[0] * v[2]))));
    to[2] = d[2] - (R(2.0) * ((s * v[2]) - ((h[0] * v[1]) - (h[1] * v[0]))));
}

#endif
