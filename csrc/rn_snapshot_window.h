/* Position of a slow tag from the ranges or differences of a short window, among outliers: where a filter starts, and
 * where it starts again.  The readable form is robustnav.snapshot.window. */
#ifndef RN_SNAPSHOT_WINDOW_H
#define RN_SNAPSHOT_WINDOW_H

#include "rn_snapshot.h"

#ifndef RN_WINDOW_READINGS
#define RN_WINDOW_READINGS 64 /* in one window; of at most RN_FIX_ANCHORS places */
#endif
#define RN_WINDOW_GUESSES 8
#define RN_WINDOW_MINIMA 36

enum { RN_WINDOW_SPACE, RN_WINDOW_HEIGHT, RN_WINDOW_PLANE }; /* third coordinate unknown; with an sd; exact */

/* Readings, one a row: the distance to `first`, or where `pair` is set the distance to `second` minus that to `first`.
 * In float, subtract a point among the anchors. */
typedef struct {
    int m;
    real value[RN_WINDOW_READINGS], sd[RN_WINDOW_READINGS];
    real first[RN_WINDOW_READINGS][3], second[RN_WINDOW_READINGS][3];
    unsigned char pair[RN_WINDOW_READINGS];
    int down_known;
    real down, down_sd; /* third coordinate [m]; sd for RN_WINDOW_HEIGHT */
} RN(window);

/* The Student-t cost of the tag at a place for each reading, a track's for instance. */
real RN(window_cost)(const RN(window) * w, const real (*place)[3]);

/* Minima of the cost, the lowest first, into `out` (P is zero on an exact third axis, 1e12 m^2 where the readings say
 * nothing); returns how many: 0 with fewer than three readings, -1 with more places than RN_FIX_ANCHORS or
 * one that is not a number. */
int RN(window_minima)(const RN(window) * w, const real (*guess)[3], int guesses, RN(fix_candidate) * out);

#endif
