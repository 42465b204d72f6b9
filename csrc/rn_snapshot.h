/* Position from ranges or range differences at one instant, with all the numbers of its verdict.
 *
 * The readable form is robustnav.snapshot; docs/snapshot.md says what is computed and why.  Nothing is allocated: a
 * problem takes about 1.4 kB (double), a result 2.5 kB, and a solution about 8 kB of stack.
 *
 *     RN(fix_problem) q = {.k = 4, .d = 3};          fill a, r, w (and z, z_info for a known height)
 *     RN(fix_arrange)(&q);                           once for the anchors in use
 *     RN(fix_solve)(&q, &options, &result);          ranges may change in between
 */
#ifndef RN_SNAPSHOT_H
#define RN_SNAPSHOT_H

#include "rn_real.h"

#define RN_FIX_ANCHORS 32   /* in one problem */
#define RN_FIX_FAULTS 4     /* left out together at most */
#define RN_FIX_OTHERS 32    /* candidates besides the best that a result holds */
#define RN_FIX_PROBE_DOF 36 /* entries of a table of quantiles: anchors, a height, and room */

enum { RN_FIX_UNIQUE, RN_FIX_AMBIGUOUS, RN_FIX_DEGENERATE, RN_FIX_INCONSISTENT, RN_FIX_TOO_FEW };
enum { RN_FIX_NONE, RN_FIX_SINGULAR, RN_FIX_UNSETTLED, RN_FIX_ON_ANCHOR, RN_FIX_MERGED, RN_FIX_BENT, RN_FIX_GDOP };
enum { RN_FIX_EXCLUDE, RN_FIX_STUDENT, RN_FIX_HUBER };

/* Metres; best near the origin, in float always: subtract the anchors' mean first. */
typedef struct {
    int k, d;        /* anchors in use; coordinates, 2 or 3 */
    int differences; /* r has an unknown common offset */
    real a[3][RN_FIX_ANCHORS], r[RN_FIX_ANCHORS];
    real w[RN_FIX_ANCHORS]; /* 1 / sd^2 of a range or an arrival */
    real z, z_info;         /* known third coordinate and 1 / sd^2; 0: unknown */
    /* by fix_arrange */
    real centre[3], axes[3][3]; /* mean; principal directions of the free coordinates, strongest first */
    real reach;                 /* of the farthest anchor from the mean */
} RN(fix_problem);

typedef struct {
    real quantile[RN_FIX_PROBE_DOF]; /* chi-square at the level of confidence, by degrees of freedom; entry 0 unused */
    real max_gdop;
    int repair, max_faults;
    int judge; /* 0: the position of the closed form's minimum and its covariance only */
} RN(fix_options);

typedef struct {
    real p[3], P[6], cost; /* P packed xx xy xz yy yz zz, NaN where singular */
} RN(fix_candidate);

typedef struct {
    int anchor;
    real error, sds; /* m, measured minus predicted; sd */
} RN(fix_suspect);

typedef struct {
    int verdict; /* of all readings */
    int judged;  /* of the readings that `best` rests on: differs from verdict when inconsistent */
    int cause;   /* why degenerate */
    int dof, steps, isolated;
    int others, rivals; /* of `other`: the minima of the same readings first, then other choices of anchors */
    int suspects;
    RN(fix_candidate) best, other[RN_FIX_OTHERS];
    RN(fix_suspect) suspect[RN_FIX_ANCHORS];
    real weights[RN_FIX_ANCHORS];
    real cost; /* of all readings */
    real gdop, hdop, vdop;
    real weak[3], weak_sd;
    real plane_point[3], plane_normal[3], plane_distance; /* distance NaN: no mirror */
    real unseen_shift;
} RN(fix_result);

/* Anchors, w and k have changed. */
void RN(fix_arrange)(RN(fix_problem) * problem);

void RN(fix_solve)(const RN(fix_problem) * problem, const RN(fix_options) * options, RN(fix_result) * result);

#endif
