/* Turns: unit quaternions with the scalar first, 3 x 3 matrices row after row. */
#ifndef RN_ALIGN_TURN_H
#define RN_ALIGN_TURN_H

#include "rn_real.h"

/* out = a b, of length one. */
RN_INLINE void product(const real *a, const real *b, real *out)
{
    const real w = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    const real x = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    const real y = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    const real z = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
    const real scale = R(1.0) / rn_sqrt(w * w + x * x + y * y + z * z);
    out[0] = w * scale;
    out[1] = x * scale;
    out[2] = y * scale;
    out[3] = z * scale;
}

/* The turn by rotation vector r. */
RN_INLINE void exponential(const real *r, real *q)
{
    const real square = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
    const real half = R(0.5) * rn_sqrt(square);
    const int small = square < R(1e-6);
    const real factor = small ? R(0.5) - square / R(48.0) : R(0.5) * rn_sin(half) / half;
    q[0] = small ? R(1.0) - square / R(8.0) : rn_cos(half);
    for (int i = 0; i < 3; i++) q[i + 1] = factor * r[i];
}

RN_INLINE void matrix(const real *q, real *C)
{
    const real w = q[0], x = q[1], y = q[2], z = q[3], two = R(2.0), one = R(1.0);
    C[0] = one - two * (y * y + z * z);
    C[1] = two * (x * y - w * z);
    C[2] = two * (x * z + w * y);
    C[3] = two * (x * y + w * z);
    C[4] = one - two * (x * x + z * z);
    C[5] = two * (y * z - w * x);
    C[6] = two * (x * z - w * y);
    C[7] = two * (y * z + w * x);
    C[8] = one - two * (x * x + y * y);
}

RN_INLINE void times_vector(const real *C, const real *v, real *out)
{
    for (int i = 0; i < 3; i++) out[i] = C[3 * i] * v[0] + C[3 * i + 1] * v[1] + C[3 * i + 2] * v[2];
}

RN_INLINE void times_matrix(const real *A, const real *B, real *out)
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) out[3 * i + j] = A[3 * i] * B[j] + A[3 * i + 1] * B[3 + j] + A[3 * i + 2] * B[6 + j];
    }
}

RN_INLINE void skew(const real *a, real *S)
{
    const real out[9] = {R(0.0), -a[2], a[1], a[2], R(0.0), -a[0], -a[1], a[0], R(0.0)};
    for (int i = 0; i < 9; i++) S[i] = out[i];
}

#endif
