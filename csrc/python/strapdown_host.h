/* Strapdown integration of whole arrays, seen through doubles: one interface for the double and the float build. */
#ifndef RN_STRAPDOWN_HOST_H
#define RN_STRAPDOWN_HOST_H

#include <stddef.h>

/* angle, velocity: (count * every, 3), history: (2, 6), `dt` a sample [s], T an interval [s]. */
typedef struct {
    const double *angle, *velocity, *history;
    size_t count, every; /* intervals, samples in each */
    double dt;
} rn_samples;

typedef struct {
    /* out: (count, 25) */
    void (*preintegrate)(const rn_samples *samples, double *out);
    /* start: (10); out: (count, 10).  Returns how many intervals ended within the latitude limit. */
    size_t (*navigate)(const rn_samples *samples, const double *start, double *out);
    /* start: q v (7); rows: (count, 25); place: earth rate, gravity (6); bias: (count, 6); out: (count, 7) */
    void (*carry)(const double *start, const double *rows, size_t count, const double *place, const double *bias, double T,
                  double *out);
} rn_strapdown_host;

const rn_strapdown_host *rn_strapdown_double(void);
const rn_strapdown_host *rn_strapdown_float(void);

#endif
