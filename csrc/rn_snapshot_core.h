/* What the files of the snapshot solver share. */
#ifndef RN_SNAPSHOT_CORE_H
#define RN_SNAPSHOT_CORE_H

#include "rn_snapshot.h"

#define RN_FIX_STARTS 26 /* range differences in 3D: 2 + 4 + 16, two roots, the centre */
#define RN_FIX_STEPS 16

#ifdef RN_FLOAT
#define RN_FIX_EPS R(1.2e-7)
#define RN_FIX_TINY R(1e-30)
#define RN_FIX_RIDGE R(1e-6) /* share of the largest eigenvalue below which information is rounding */
#define RN_FIX_FLAT R(3e-6)     /* ratio of eigenvalues below which first-order numbers mean nothing */
#define RN_FIX_BLIND R(1e-4)
#else
#define RN_FIX_EPS R(2.2e-16)
#define RN_FIX_TINY R(1e-300)
#define RN_FIX_RIDGE R(1e-12)
#define RN_FIX_FLAT R(1e-10)
#define RN_FIX_BLIND R(1e-9)
#endif

/* Cost, half its gradient and its Gauss-Newton information (packed xx xy xz yy yz zz) at p. */
typedef struct {
    real p[3], cost, g[3], H[6];
} RN(fix_point);

/* Where a descent ended; of candidates the eigenvalues of H, ascending, and its eigenvectors as well. */
typedef struct {
    RN(fix_point) at;
    int steps, settled;
    real values[3], vectors[3][3];
} RN(fix_end);

/* Distances, unit vectors from anchor to tag and residuals, of differences without their weighted mean. */
typedef struct {
    real d[RN_FIX_ANCHORS], u[3][RN_FIX_ANCHORS], e[RN_FIX_ANCHORS];
} RN(fix_rays);

/* Directions in which a descent may move: the first f of b. */
typedef struct {
    int f;
    real b[2][3];
} RN(fix_basis);

/* Minima that the readings do not tell from the best, which is the first. */
typedef struct {
    int count, settled, steps;
    RN(fix_end) end[RN_FIX_STARTS];
} RN(fix_survey);

RN_INLINE real rn_larger(real a, real b) { return a > b ? a : b; }
RN_INLINE real rn_smaller(real a, real b) { return a < b ? a : b; }
RN_INLINE real rn_dot3(const real *a, const real *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* v' H v of a packed H. */
RN_INLINE real rn_form(const real *H, const real *v)
{
    return H[0] * v[0] * v[0] + H[3] * v[1] * v[1] + H[5] * v[2] * v[2] +
           R(2.0) * (H[1] * v[0] * v[1] + H[2] * v[0] * v[2] + H[4] * v[1] * v[2]);
}

/* The information that anchor i alone would have left if the common offset were known. */
RN_INLINE real rn_fix_own(const RN(fix_problem) * q, real sum, int i)
{
    return q->differences ? q->w[i] - q->w[i] * q->w[i] / sum : q->w[i];
}

static inline int RN(fix_dof)(const RN(fix_problem) * q) { return q->k - (q->differences != 0) + (q->z_info > 0) - q->d; }

real RN(fix_scale)(const RN(fix_problem) * q);
void RN(fix_cast)(const RN(fix_problem) * q, const real *p, RN(fix_rays) * rays);
real RN(fix_cost)(const RN(fix_problem) * q, const real *p);
void RN(fix_expand)(const RN(fix_problem) * q, RN(fix_point) * at, RN(fix_rays) * rays);
int RN(fix_factor)(real (*M)[3], real *b, int n);
void RN(fix_project)(const real *H, const real *g, const RN(fix_basis) * basis, int d, real (*M)[3], real *b);
void RN(fix_descend)(const RN(fix_problem) * q, const RN(fix_basis) * basis, int max_steps, RN(fix_end) * end);

void RN(fix_eigen)(const real *H, int n, real *values, real (*vectors)[3]);
int RN(fix_covariance)(const real *values, const real (*vectors)[3], int n, real *P);

int RN(fix_first)(const RN(fix_problem) * q, real *start);
int RN(fix_starts)(const RN(fix_problem) * q, real (*start)[3]);

void RN(fix_look)(const RN(fix_problem) * q, const RN(fix_options) * o, RN(fix_survey) * seen);
void RN(fix_across)(const RN(fix_problem) * q, const real *p, const real *direction, real length, RN(fix_end) * end);
void RN(fix_shares)(const RN(fix_problem) * q, const RN(fix_end) * centre, real radius, real *shares);
real RN(fix_stretch)(const RN(fix_problem) * q, const RN(fix_point) * at, const real *direction, real start, real rise);
int RN(fix_parted)(const RN(fix_problem) * q, const real *a, const real *b, real rise);

void RN(fix_judge)(const RN(fix_problem) * q, const RN(fix_options) * o, RN(fix_survey) * seen, RN(fix_result) * out);

#endif
