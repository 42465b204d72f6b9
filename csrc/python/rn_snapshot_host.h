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

#define RN_WINDOW_READINGS 512 /* a host has room for all that a fast link gives in half a second */
#define RN_WINDOW_HOST_MINIMA 36
#define RN_WINDOW_HOST_GUESSES 8

/* One window of m readings; arrays as in rn_snapshot_window.h. */
typedef struct {
    int m, guesses;
    const double *value, *sd, *first, *second; /* (m), (m), (m, 3), (m, 3) */
    const unsigned char *pair;
    int down_known;
    double down, down_sd;
    const double *guess; /* (guesses, 3) */
    const double *track; /* (m, 3) a place for each reading, or NULL */
    double *minima;      /* (RN_WINDOW_HOST_MINIMA, RN_FIX_OTHER_ROW) */
    double track_cost;   /* of track */
} rn_window_call;

/* Returns how many minima, -1 with too many places or one that is not a number. */
int rn_window_run_double(rn_window_call *call);
int rn_window_run_float(rn_window_call *call);

#endif
