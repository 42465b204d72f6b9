/* The constant-gain attitude filter in 32-bit integers, for cores without a floating-point unit.  Qn means n fractional bits.
 * Where numbers lie and why no sum overflows is derived with the gains: docs/firmware.md, section 4.  Every product has
 * factors whose product fits 32 bits; nothing here divides, branches on data or calls. */
#ifndef RN_FIXED_H
#define RN_FIXED_H

#include <stdint.h>

#if defined(__GNUC__)
#define RN_FIXED_INLINE static inline __attribute__((always_inline, unused))
#else
#define RN_FIXED_INLINE static inline
#endif

/* Shifting a negative number right keeps its sign on every compiler for these cores; one that does not fails to compile. */
typedef char rn_shift_keeps_sign[((-1 >> 1) == -1) ? 1 : -1];

/* v / 2^n, to the nearest. */
RN_FIXED_INLINE int32_t rn_scaled(int32_t v, int n)
{
    return (v + ((int32_t)1 << (n - 1))) >> n;
}

/* q (Q30) <- q * (1 + e, h), e = (1 - |q|^2) / 2, with h in Q`bits`; to: the result in Q15. */
RN_FIXED_INLINE void rn_fixed_turn(int32_t q[4], const int32_t h[3], int bits, int32_t to[4])
{
    const int32_t w = q[0] >> 15;
    const int32_t x = q[1] >> 15;
    const int32_t y = q[2] >> 15;
    const int32_t z = q[3] >> 15;
    const int32_t e = (((int32_t)1 << 30) - ((w * w) + (x * x) + (y * y) + (z * z))) >> (31 - bits);
    q[0] = q[0] + (((e * w) - (h[0] * x) - (h[1] * y) - (h[2] * z)) >> (bits - 15));
    q[1] = q[1] + (((e * x) + (h[0] * w) + (h[2] * y) - (h[1] * z)) >> (bits - 15));
    q[2] = q[2] + (((e * y) + (h[1] * w) + (h[0] * z) - (h[2] * x)) >> (bits - 15));
    q[3] = q[3] + (((e * z) + (h[2] * w) + (h[1] * x) - (h[0] * y)) >> (bits - 15));
    to[0] = q[0] >> 15;
    to[1] = q[1] >> 15;
    to[2] = q[2] >> 15;
    to[3] = q[3] >> 15;
}

/* c (Q15) <- C_nb of q (Q15), by rows. */
RN_FIXED_INLINE void rn_fixed_matrix(const int32_t q[4], int32_t c[9])
{
    const int32_t xx = q[1] * q[1];
    const int32_t yy = q[2] * q[2];
    const int32_t zz = q[3] * q[3];
    const int32_t xy = q[1] * q[2];
    const int32_t xz = q[1] * q[3];
    const int32_t yz = q[2] * q[3];
    const int32_t wx = q[0] * q[1];
    const int32_t wy = q[0] * q[2];
    const int32_t wz = q[0] * q[3];
    c[0] = ((int32_t)1 << 15) - ((yy + zz) >> 14);
    c[1] = (xy - wz) >> 14;
    c[2] = (xz + wy) >> 14;
    c[3] = (xy + wz) >> 14;
    c[4] = ((int32_t)1 << 15) - ((xx + zz) >> 14);
    c[5] = (yz - wx) >> 14;
    c[6] = (xz - wy) >> 14;
    c[7] = (yz + wx) >> 14;
    c[8] = ((int32_t)1 << 15) - ((xx + yy) >> 14);
}

/* One row of C_nb (Q15) times a reading in counts: Q15. */
RN_FIXED_INLINE int32_t rn_fixed_row(const int32_t c[3], const int16_t v[3])
{
    return (c[0] * v[0]) + (c[1] * v[1]) + (c[2] * v[2]);
}

/* v <- v + C_bn w, with w in 15 - n fractional bits less than v. */
RN_FIXED_INLINE void rn_fixed_add(const int32_t c[9], const int32_t w[3], int n, int32_t v[3])
{
    v[0] = v[0] + (((c[0] * w[0]) + (c[3] * w[1]) + (c[6] * w[2])) >> n);
    v[1] = v[1] + (((c[1] * w[0]) + (c[4] * w[1]) + (c[7] * w[2])) >> n);
    v[2] = v[2] + (((c[2] * w[0]) + (c[5] * w[1]) + (c[8] * w[2])) >> n);
}

/* Not 0 if a number is 2^30 or more in size. */
RN_FIXED_INLINE uint32_t rn_fixed_large(const int32_t v[3])
{
    const uint32_t half = (uint32_t)1 << 30;
    return (((uint32_t)v[0] + half) | ((uint32_t)v[1] + half) | ((uint32_t)v[2] + half)) >> 31;
}

/* Not 0 if a number is outside -2^(bits-1) .. 2^(bits-1) - 1. */
RN_FIXED_INLINE uint32_t rn_fixed_wide(const int16_t v[3], int bits)
{
    const uint32_t half = (uint32_t)1 << (bits - 1);
    return (((uint32_t)v[0] + half) | ((uint32_t)v[1] + half) | ((uint32_t)v[2] + half)) >> bits;
}

#endif
