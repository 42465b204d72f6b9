/* The number type of the kernel: double, or float when RN_FLOAT is defined.  One source serves both. */
#ifndef RN_REAL_H
#define RN_REAL_H

#include <math.h>

#ifdef RN_FLOAT
typedef float real;
#define R(v) v##f
#define RN(name) rnf_##name
#define rn_sqrt sqrtf
#define rn_sin sinf
#define rn_cos cosf
#define rn_tan tanf
#define rn_asin asinf
#define rn_acos acosf
#define rn_atan atanf
#define rn_atan2 atan2f
#define rn_exp expf
#define rn_log logf
#define rn_abs fabsf
#define rn_floor floorf
#else
typedef double real;
#define R(v) v
#define RN(name) rn_##name
#define rn_sqrt sqrt
#define rn_sin sin
#define rn_cos cos
#define rn_tan tan
#define rn_asin asin
#define rn_acos acos
#define rn_atan atan
#define rn_atan2 atan2
#define rn_exp exp
#define rn_log log
#define rn_abs fabs
#define rn_floor floor
#endif

#define RN_UNUSED(v) ((void)(v))

#if defined(_MSC_VER)
#define RN_INLINE static __forceinline
#elif defined(__GNUC__)
#define RN_INLINE static inline __attribute__((always_inline, unused))
#else
#define RN_INLINE static inline
#endif

/* Of a function that is one long loop over an array: worth vectorising even where the build says that none is. */
#if defined(__GNUC__) && !defined(__clang__)
#define RN_VECTORISED __attribute__((optimize("tree-loop-vectorize"), unused))
#elif defined(__GNUC__)
#define RN_VECTORISED __attribute__((unused))
#else
#define RN_VECTORISED
#endif

/* An angle taken into [-pi, pi). */
RN_INLINE real rn_wrap(real angle)
{
    const real turn = R(6.283185307179586);
    return angle - turn * rn_floor(angle / turn + R(0.5));
}

#endif
