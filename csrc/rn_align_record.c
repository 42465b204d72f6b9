/* The readings kept: which of them stand out, and the averaged window in which lines are looked for. */
#include "rn_align.h"

#include <string.h>

static const real ABSENT = R(1e9); /* oddness of a missing reading */

const real *RN(align_reading)(const RN(align) * a, int k) { return a->record[k % RN_ALIGN_RECORD]; }

int RN(align_missing)(const real *reading) { return !(reading[RN_ALIGN_VELOCITY_AT] + reading[RN_ALIGN_VELOCITY_AT + 1] < R(1e9)); }

/* Median of one axis over the readings of [from, to) that are there, five at most; 0 if none is. */
real RN(align_median)(const RN(align) * a, int from, int to, int axis)
{
    real sorted[5];
    int count = 0;
    for (int k = from; k < to; k++) {
        const real value = RN(align_reading)(a, k)[RN_ALIGN_VELOCITY_AT + axis];
        if (RN(align_missing)(RN(align_reading)(a, k))) continue;
        int j = count++;
        for (; j > 0 && sorted[j - 1] > value; j--) sorted[j] = sorted[j - 1];
        sorted[j] = value;
    }
    return count ? sorted[count / 2] : R(0.0);
}

/* How far reading k of [from, to) is from the median of the five around it, the larger of north and east. */
real RN(align_oddness)(const RN(align) * a, int k, int from, int to)
{
    const int first = k - 2 < from ? from : k - 2, last = k + 3 > to ? to : k + 3;
    real worst = R(0.0);
    if (RN(align_missing)(RN(align_reading)(a, k))) return ABSENT;
    for (int axis = 0; axis < 2; axis++) {
        const real off = rn_abs(RN(align_reading)(a, k)[RN_ALIGN_VELOCITY_AT + axis] - RN(align_median)(a, first, last, axis));
        if (off > worst) worst = off;
    }
    return worst;
}

/* Beyond this oddness a reading is a gust. */
real RN(align_odd_limit)(const RN(align) * a, int from, int to)
{
    real limit = ABSENT;
    for (int pass = 0; pass < 2; pass++) {
        real sum = R(0.0), count = R(0.0);
        for (int k = from; k < to; k++) {
            const real off = RN(align_oddness)(a, k, from, to);
            if (off < limit) {
                sum += off;
                count += R(1.0);
            }
        }
        if (count > R(0.0)) limit = R(4.0) * sum / count;
    }
    const real least = R(6.0) * a->setup.reference_sd;
    return limit > least && limit < ABSENT ? limit : least;
}

/* Fill the window with what the reference velocity says beyond free motion from the given attitude, in averaged rows. */
void RN(align_fill_window)(RN(align) * a, const RN(align_core) * from, int start, int stop)
{
    RN(align_window) *w = &a->window;
    const int length = stop - start, group = (length + RN_ALIGN_SAMPLES - 1) / RN_ALIGN_SAMPLES;
    const real limit = RN(align_odd_limit)(a, start, stop), T = a->setup.period;
    /* A filter with neither wind nor noise: only its motion is used. */
    RN(align_filter) *f = &a->trial;
    const RN(align_wind) none = {R(0.0), R(1.0), 0, {R(0.0)}, {R(0.0)}};
    RN(align_filter_start)(f, &a->setup, &none, from);
    f->core.v[0] = f->core.v[1] = R(0.0);
    w->n = length / group;
    w->period = T * (real)group;
    w->noise_sd = a->setup.reference_sd / rn_sqrt((real)group);
    for (; start < stop - w->n * group; start++) RN(align_filter_motion)(f, &a->setup, RN(align_reading)(a, start));
    for (int row = 0; row < w->n; row++) {
        real sum[2] = {R(0.0)}, count = R(0.0);
        for (int k = start + row * group; k < start + (row + 1) * group; k++) {
            RN(align_filter_motion)(f, &a->setup, RN(align_reading)(a, k));
            if (RN(align_oddness)(a, k, start, stop) > limit) continue;
            for (int i = 0; i < 2; i++) sum[i] += RN(align_reading)(a, k)[RN_ALIGN_VELOCITY_AT + i] - f->core.v[i];
            count += R(1.0);
        }
        for (int i = 0; i < 2; i++) w->r[i][row] = count > R(0.0) ? sum[i] / count : R(0.0);
        w->weight[row] = count / (real)group;
    }
    /* Drift over the window: tilt, then gyro bias and Earth rate, then the walk of the bias. */
    const real span = (real)w->n * w->period, g = a->setup.gravity, bias = a->setup.gyro_bias_sd, earth = R(6e-5);
    const real bend = g * rn_sqrt(bias * bias + earth * earth) * span * span / R(12.0);
    const real walk = g * a->setup.gyro_bias_walk * span * span * rn_sqrt(span) / R(45.0);
    const real sd[5] = {R(3.0), R(3.0), bend + R(1e-4), walk + R(1e-4), R(0.5) * walk + R(1e-4)};
    memcpy(w->poly_sd, sd, sizeof sd);
}
