/* Loops over arrays.  Included by strapdown_double.c and strapdown_float.c. */
#include "../rn_strapdown.c"

#include "strapdown_host.h"

static void to_real(real *out, const double *in, int n)
{
    for (int k = 0; k < n; k++) out[k] = (real)in[k];
}

static void to_double(double *out, const real *in, int n)
{
    for (int k = 0; k < n; k++) out[k] = (double)in[k];
}

static void begin(const rn_samples *samples, RN(imu_history) * history)
{
    for (int k = 0; k < 2; k++) to_real(history->past[k], samples->history + k * RN_SAMPLE, RN_SAMPLE);
}

static void sample_at(const rn_samples *samples, size_t k, real *sample)
{
    to_real(sample, samples->angle + 3 * k, 3);
    to_real(sample + 3, samples->velocity + 3 * k, 3);
}

static void preintegrate(const rn_samples *samples, double *out)
{
    RN(imu_history) history;
    begin(samples, &history);
    for (size_t i = 0, k = 0; i < samples->count; i++, out += RN_INCREMENTS) {
        RN(increments) sum;
        RN(increments_start)(&sum);
        for (size_t j = 0; j < samples->every; j++, k++) {
            real sample[RN_SAMPLE];
            sample_at(samples, k, sample);
            RN(increments_add)(&sum, &history, sample, (real)samples->dt);
        }
        to_double(out, sum.q, 4);
        to_double(out + 4, sum.v, 3);
        to_double(out + 7, sum.J, 9);
        to_double(out + 16, sum.H, 9);
    }
}

static size_t navigate(const rn_samples *samples, const double *start, double *out)
{
    RN(imu_history) history;
    real x[RN_NAVIGATION];
    begin(samples, &history);
    to_real(x, start, RN_NAVIGATION);
    for (size_t i = 0, k = 0; i < samples->count; i++, out += RN_NAVIGATION) {
        RN(increments) sum;
        RN(increments_start)(&sum);
        for (size_t j = 0; j < samples->every; j++, k++) {
            real sample[RN_SAMPLE];
            sample_at(samples, k, sample);
            RN(increments_add_plain)(&sum, &history, sample);
        }
        if (RN(navigation_step)(x, sum.q, sum.v, (real)(samples->dt * (double)samples->every))) return i;
        to_double(out, x, RN_NAVIGATION);
    }
    return samples->count;
}

static void carry(const double *start, const double *rows, size_t count, const double *place, const double *bias, double T,
                  double *out)
{
    real x[7], row[RN_INCREMENTS], where[6], b[6], dq[4], dv[3];
    to_real(x, start, 7);
    to_real(where, place, 6);
    for (size_t i = 0; i < count; i++) {
        to_real(row, rows + i * RN_INCREMENTS, RN_INCREMENTS);
        to_real(b, bias + 6 * i, 6);
        RN(increments_corrected)(row, b, b + 3, dq, dv);
        RN(static_step)(x, x + 4, dq, dv, where, where + 3, (real)T);
        to_double(out + 7 * i, x, 7);
    }
}

const rn_strapdown_host *RN_STRAPDOWN_HOST(void)
{
    static const rn_strapdown_host host = {preintegrate, navigate, carry};
    return &host;
}
