/* The snapshot solver seen through doubles: one interface for the double and the float build. */
#ifndef RN_SNAPSHOT_HOST_H
#define RN_SNAPSHOT_HOST_H

#include <stddef.h>

/* Numbers a solution is reported in: verdict judged cause dof steps isolated others rivals suspects cost p(3) P(6)
 * gdop hdop vdop weak(3) weak_sd unseen_shift plane_point(3) plane_normal(3) plane_distance */
#define RN_FIX_ROW 34
#define RN_FIX_OTHER_ROW 10  /* p(3) P(6) cost */
#define RN_FIX_SUSPECT_ROW 3 /* anchor error sds */
#define RN_FIX_HOST_ANCHORS 32
#define RN_FIX_HOST_OTHERS 32
#define RN_FIX_QUANTILES 36

/* Epochs that share anchors.  NULL outputs are not written. */
typedef struct {
    size_t n;
    int k, d, differences;
    const double *anchors;  /* (k, d) */
    const double *readings; /* (n, k), differences (n, k - 1); NaN where missing */
    const double *sd;       /* (k) of a range or an arrival */
    double z, z_sd;         /* known third coordinate; z_sd 0: unknown */
    const double *quantile; /* (RN_FIX_QUANTILES) */
    double max_gdop;
    int repair, max_faults, judge;
    double *row;      /* (n, RN_FIX_ROW) */
    double *weights;  /* (n, k) */
    double *others;   /* (n, RN_FIX_HOST_OTHERS, RN_FIX_OTHER_ROW) */
    double *suspects; /* (n, RN_FIX_HOST_ANCHORS, RN_FIX_SUSPECT_ROW) */
} rn_fix_batch;

/* Epochs [from, to); the caller checks for interrupts between calls. */
void rn_fix_run_double(const rn_fix_batch *batch, size_t from, size_t to);
void rn_fix_run_float(const rn_fix_batch *batch, size_t from, size_t to);

#endif
