/* The alignment through doubles.  Included by align_double.c and align_float.c, which name the functions. */
#include <string.h>

#include "rn_align.h"
#include "rn_align_host.h"

static void take_setup(RN(align_setup) * s, const double *from)
{
    real *to[RN_ALIGN_HOST_SETUP] = {&s->period,        &s->latitude,      &s->gravity,         &s->gyro_density,
                                     &s->gyro_bias_sd,  &s->gyro_bias_walk, &s->accel_density,  &s->accel_bias_sd,
                                     &s->accel_bias_walk, &s->reference_sd, &s->gust_sd,        &s->gust_share,
                                     &s->declination,   &s->compass_sd,    &s->compass_bias_sd};
    for (int i = 0; i < RN_ALIGN_HOST_SETUP; i++) *to[i] = (real)from[i];
}

static void take(real *to, const double *from, int count)
{
    for (int i = 0; i < count; i++) to[i] = (real)from[i];
}

static double *give(double *to, const real *from, int count)
{
    for (int i = 0; i < count; i++) *to++ = (double)from[i];
    return to;
}

static void give_answer(double *to, const RN(align_answer) * a)
{
    const real heading[3] = {a->heading, a->heading_var, a->concentration};
    to = give(to, a->q, 4);
    to = give(to, a->tilt, 2);
    to = give(to, a->tilt_cov, 3);
    to = give(to, heading, 3);
    to = give(to, a->gyro_bias, 3);
    to = give(to, a->accel_bias, 3);
    const real compass[2] = {a->compass_bias, a->compass_bias_var};
    to = give(to, a->wind, 2);
    give(to, compass, 2);
}

size_t RN_ALIGN_BYTES(void) { return sizeof(RN(align)); }

int RN_ALIGN_BEGIN(void *state, const double *setup)
{
    RN(align_setup) s;
    take_setup(&s, setup);
    return RN(align_start)(state, &s);
}

void RN_ALIGN_RUN(const rn_align_batch *b, size_t from, size_t to)
{
    RN(align) *a = b->state;
    RN(align_answer) answer;
    real reading[RN_ALIGN_READING];
    for (size_t k = from; k < to; k++) {
        take(reading, b->readings + k * RN_ALIGN_HOST_READING, RN_ALIGN_READING);
        RN(align_step)(a, reading);
        if ((k + 1) % b->every) continue;
        double *row = b->answer + ((k + 1) / b->every - 1) * RN_ALIGN_HOST_ANSWER;
        if (RN(align_read)(a, &answer)) {
            give_answer(row, &answer);
        } else {
            for (int i = 0; i < RN_ALIGN_HOST_ANSWER; i++) row[i] = (double)NAN;
        }
    }
}

void RN_ALIGN_ONE(const rn_align_one *one)
{
    RN(align_setup) setup;
    RN(align_wind) wind = {(real)one->wind[0], (real)one->wind[1], 0, {R(0.0)}, {R(0.0)}};
    RN(align_filter) f;
    RN(align_answer) answer;
    RN(align_core) at;
    real reading[RN_ALIGN_READING];
    take_setup(&setup, one->setup);
    take(wind.omega, one->wind + 2, RN_ALIGN_LINES);
    take(wind.omega_sd, one->wind + 2 + RN_ALIGN_LINES, RN_ALIGN_LINES);
    while (wind.lines < RN_ALIGN_LINES && wind.omega[wind.lines] > R(0.0)) wind.lines++;
    memset(&at, 0, sizeof at);
    take(at.q, one->q0, 4);
    take(at.v, one->v0, 2);
    RN(align_filter_start)(&f, &setup, &wind, &at);
    for (size_t k = 0; k < one->n; k++) {
        take(reading, one->readings + k * RN_ALIGN_HOST_READING, RN_ALIGN_READING);
        RN(align_filter_predict)(&f, &setup, reading);
        RN(align_filter_update)(&f, &setup, reading + RN_ALIGN_VELOCITY_AT);
        RN(align_filter_bearing)(&f, &setup, reading + RN_ALIGN_FIELD_AT);
        RN(align_filter_answer)(&f, &setup, &answer);
        give_answer(one->answer + k * RN_ALIGN_HOST_ANSWER, &answer);
        one->log_likelihood[k] = (double)f.log_likelihood;
    }
    double *to = give(one->state, f.core.q, 4);
    to = give(to, f.core.v, 2);
    to = give(to, f.core.gyro_bias, 3);
    to = give(to, f.core.accel_bias, 3);
    to = give(to, f.core.rate, 2);
    to = give(to, &f.core.compass_bias, f.common - RN_ALIGN_CORE);
    give(to, f.d, f.n - f.common);
    give(one->P, f.P, f.n * f.n);
}

int RN_ALIGN_LINES_IN(rn_align_lines *call)
{
    RN(align_window) w;
    RN(align_spectrum) found;
    const double span = (double)call->n * call->period;
    if (call->n < 1 || call->n > RN_ALIGN_SAMPLES || !(span >= 1.0 && span <= 1000.0)) return -1;
    memset(&w, 0, sizeof w);
    memset(&found, 0, sizeof found);
    w.n = (int)call->n;
    w.period = (real)call->period;
    w.noise_sd = (real)call->noise_sd;
    take(w.weight, call->weight, w.n);
    take(w.poly_sd, call->poly_sd, 5);
    for (int k = 0; k < w.n; k++) {
        for (int i = 0; i < 2; i++) w.r[i][k] = (real)call->r[2 * k + i];
    }
    call->alone = (double)RN(align_whiten)(&w, (real)call->markov_sd, (real)call->markov_time);
    RN(align_search)(&w, (real)call->markov_sd, (real)call->markov_time, (real)call->goal, &found);
    call->evidence = (double)found.evidence;
    call->lines = found.lines;
    give(call->omega, found.omega, RN_ALIGN_LINES);
    give(call->omega_sd, found.omega_sd, RN_ALIGN_LINES);
    return 0;
}
