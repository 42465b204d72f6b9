/* The smoother over a whole recording, seen through doubles, for the Python extension. */
#ifndef RN_SMOOTH_HOST_H
#define RN_SMOOTH_HOST_H

#include <stddef.h>

typedef struct {
    const void *model;
    size_t n;
    const double *dt;    /* (n) from the row before [s]; 0: the same instant; NaN: a filter was started here */
    const double *u;     /* (n, nu) held from the row before */
    const double *q, *p; /* noise intensities, parameters */
    double *x, *P;       /* (n, nx) and (n, packed): the filter's in, the smoothed out */
} rn_smooth_batch;

/* Bytes of scratch a call needs. */
size_t rn_smooth_bytes_double(const void *model);
size_t rn_smooth_bytes_float(const void *model);

/* Smooth rows [from, to) with to < n, the last first, once the rows from `to` on are smoothed. */
void rn_smooth_rows_double(rn_smooth_batch *batch, size_t from, size_t to, void *scratch);
void rn_smooth_rows_float(rn_smooth_batch *batch, size_t from, size_t to, void *scratch);

#endif
