/* The estimator: a bank of winds without lines, one filter with the lines found so far, and the record to find them in. */
#include "rn_align.h"

#include <string.h>

enum { LINES = RN_ALIGN_BANK, LEVELS = 5, RECENTRES = 3, REFERENCE = RN_ALIGN_VELOCITY_AT };

static const real LEVEL_TIME = R(2.0);   /* s before the filters start */
static const real FIRST_TIME = R(12.0);  /* s of record needed to tell a slow wind from a tilt */
static const real EARLY_TIME = R(60.0);  /* s: until then the window is the whole record */
static const real SHORT_WINDOW = R(20.0);
static const real SNAPSHOT_TIME = R(10.0);
static const real MEMORY = R(60.0);      /* s, forgetting of likelihood */
static const real BROAD_SD = R(0.5);     /* m/s: winds below it have no say before FIRST_TIME */
static const real REFIT_UNTIL = R(40.0); /* s: until then new lines always replace the old */
static const real ABSENT = R(1e9);       /* oddness of a missing reading */
static const real COARSE = R(1e-3);      /* rad/s: gyro biases beyond it are taken off the record as soon as they are known */
static const real RECENTRE_TIME[] = {R(5.0), R(12.0), R(30.0)};
static const real ANCHOR_TIME = R(45.0), ANCHOR_EVERY = R(15.0); /* s */
static const real HEALTHY = R(2.6);      /* smoothed misfit, 2 expected */

/* Winds of the bank: Markov sd [m/s] and time [s], and the log of how much rarer they are.  The first
 * LEVELS are also tried as the noise around lines.  Slow winds look like tilt: they must earn their place. */
static const real BANK[RN_ALIGN_BANK][3] = {
    {R(0.0), R(4.0), R(0.0)},   {R(0.1), R(2.0), R(0.0)},   {R(0.2), R(4.0), R(0.0)},
    {R(0.5), R(4.0), R(0.0)},   {R(1.5), R(4.0), R(0.0)},   {R(0.5), R(1.0), R(0.0)},
    {R(0.15), R(16.0), R(2.0)}, {R(0.4), R(16.0), R(2.0)},  {R(1.0), R(16.0), R(2.0)}};

static int steps(const RN(align) * a, real time) { return (int)(time / a->setup.period + R(0.5)); }

static const real *reading_at(const RN(align) * a, int k) { return a->record[k % RN_ALIGN_RECORD]; }

static int missing(const real *reading) { return !(reading[REFERENCE] + reading[REFERENCE + 1] < R(1e9)); }

/* Median of one axis over the readings of [from, to) that are there, five at most; 0 if none is. */
static real median(const RN(align) * a, int from, int to, int axis)
{
    real sorted[5];
    int count = 0;
    for (int k = from; k < to; k++) {
        const real value = reading_at(a, k)[REFERENCE + axis];
        if (missing(reading_at(a, k))) continue;
        int j = count++;
        for (; j > 0 && sorted[j - 1] > value; j--) sorted[j] = sorted[j - 1];
        sorted[j] = value;
    }
    return count ? sorted[count / 2] : R(0.0);
}

/* How far reading k of [from, to) is from the median of the five around it, the larger of north and east. */
static real oddness(const RN(align) * a, int k, int from, int to)
{
    const int first = k - 2 < from ? from : k - 2, last = k + 3 > to ? to : k + 3;
    real worst = R(0.0);
    if (missing(reading_at(a, k))) return ABSENT;
    for (int axis = 0; axis < 2; axis++) {
        const real off = rn_abs(reading_at(a, k)[REFERENCE + axis] - median(a, first, last, axis));
        if (off > worst) worst = off;
    }
    return worst;
}

/* Beyond this oddness a reading is a gust. */
static real odd_limit(const RN(align) * a, int from, int to)
{
    real limit = ABSENT;
    for (int pass = 0; pass < 2; pass++) {
        real sum = R(0.0), count = R(0.0);
        for (int k = from; k < to; k++) {
            const real off = oddness(a, k, from, to);
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

/* Run a fresh filter over [from, to); in its first two seconds gusts are left out, later it judges them itself.  Returns
 * the score, log likelihood with forgetting, and the plain sum in *total. */
static real replay(RN(align) * a, RN(align_filter) * f, int from, int to, real score, real *total)
{
    const real keep = rn_exp(-a->setup.period / MEMORY), limit = odd_limit(a, from, from + steps(a, LEVEL_TIME));
    const int careful = from + steps(a, LEVEL_TIME);
    *total = R(0.0);
    for (int k = from; k < to; k++) {
        RN(align_filter_predict)(f, &a->setup, reading_at(a, k));
        if (k < careful ? oddness(a, k, from, careful) <= limit : !missing(reading_at(a, k))) {
            RN(align_filter_update)(f, &a->setup, reading_at(a, k) + REFERENCE);
            score = keep * score + f->log_likelihood;
            *total += f->log_likelihood;
        }
        RN(align_filter_bearing)(f, &a->setup, reading_at(a, k) + RN_ALIGN_FIELD_AT);
    }
    return score;
}

/* Start a filter; after a recentring linear about the origin. */
static void start_filter(const RN(align) * a, RN(align_filter) * f, const RN(align_wind) * wind)
{
    RN(align_filter_start)(f, &a->setup, wind, &a->origin);
    if (a->recentred > 0) RN(align_filter_anchor)(f);
}

/* Level, and run all filters over the whole record. */
static void restart(RN(align) * a)
{
    const int level = steps(a, LEVEL_TIME);
    RN(align_core) *origin = &a->origin;
    real total;
    RN(align_level)(a->record[0], level, origin->gyro_bias, origin->q);
    if (a->recentred == 0) RN(align_forget_odd_fields)(a->record[0], level, &a->setup, origin->q);
    for (int axis = 0; axis < 2; axis++) origin->v[axis] = median(a, 0, level < 5 ? level : 5, axis);
    for (int i = 0; i < RN_ALIGN_BANK + a->has_lines; i++) {
        RN(align_filter) *f = &a->filter[i];
        const RN(align_wind) wind = f->wind;
        start_filter(a, f, &wind);
        a->score[i] = replay(a, f, 0, a->count, R(0.0), &total) - R(3.0) * (real)wind.lines;
    }
}

/* While the bias of coarse gyros is learned, attitude and its turns move with every reading, and what moves seems to tell
 * tilt from the accelerometer's bias.  So, few times: start over, linear about that bias; then, now and again, about what
 * is estimated. */
static void recentre(RN(align) * a)
{
    const int again = a->count - steps(a, ANCHOR_TIME);
    RN(align_answer) said;
    if (!(a->setup.gyro_bias_sd > COARSE)) return;
    if (a->recentred < RECENTRES && a->count == steps(a, RECENTRE_TIME[a->recentred])) {
        RN(align_read)(a, &said);
        memcpy(a->origin.gyro_bias, said.gyro_bias, sizeof said.gyro_bias);
        a->recentred++;
        restart(a);
    }
    if (again < 0 || again % steps(a, ANCHOR_EVERY) != 0) return;
    for (int i = 0; i < RN_ALIGN_BANK + a->has_lines; i++) RN(align_filter_anchor)(&a->filter[i]);
}

/* Fill the window with what the reference velocity says beyond free motion from the given attitude, in averaged rows. */
static void fill_window(RN(align) * a, const RN(align_core) * from, int start, int stop)
{
    RN(align_window) *w = &a->window;
    const int length = stop - start, group = (length + RN_ALIGN_SAMPLES - 1) / RN_ALIGN_SAMPLES;
    const real limit = odd_limit(a, start, stop), T = a->setup.period;
    /* A filter with neither wind nor noise: only its motion is used. */
    RN(align_filter) *f = &a->trial;
    const RN(align_wind) none = {R(0.0), R(1.0), 0, {R(0.0)}, {R(0.0)}};
    RN(align_filter_start)(f, &a->setup, &none, from);
    f->core.v[0] = f->core.v[1] = R(0.0);
    w->n = length / group;
    w->period = T * (real)group;
    w->noise_sd = a->setup.reference_sd / rn_sqrt((real)group);
    for (; start < stop - w->n * group; start++) RN(align_filter_motion)(f, &a->setup, reading_at(a, start));
    for (int row = 0; row < w->n; row++) {
        real sum[2] = {R(0.0)}, count = R(0.0);
        for (int k = start + row * group; k < start + (row + 1) * group; k++) {
            RN(align_filter_motion)(f, &a->setup, reading_at(a, k));
            if (oddness(a, k, start, stop) > limit) continue;
            for (int i = 0; i < 2; i++) sum[i] += reading_at(a, k)[REFERENCE + i] - f->core.v[i];
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

/* The wind with the most evidence in the window: start at the likeliest without lines, then try less Markov noise. */
static void identify(RN(align) * a, RN(align_wind) * out)
{
    int level = 0;
    real best = R(0.0);
    RN(align_spectrum) found, kept;
    for (int i = 0; i < RN_ALIGN_BANK; i++) {
        const real value = RN(align_whiten)(&a->window, BANK[i][0], BANK[i][1]);
        if (i == 0 || value > best) {
            best = value;
            level = i < LEVELS ? i : level;
        }
    }
    memset(&kept, 0, sizeof kept);
    RN(align_search)(&a->window, BANK[level][0], BANK[level][1], best, &kept);
    for (int i = level - 1; i >= 0; i--) {
        found = kept;
        RN(align_search)(&a->window, BANK[i][0], BANK[i][1], kept.evidence, &found);
        if (!(found.evidence > kept.evidence)) break;
        kept = found;
        level = i;
    }
    /* A line not yet told from its neighbour leaves a remainder that shrinks as the window grows. */
    const real span = (real)a->window.n * a->window.period, ratio = FIRST_TIME / span;
    const int quiet = !(BANK[level][0] > R(0.0));
    out->markov_sd = quiet ? R(0.05) * (ratio < R(1.0) ? ratio * ratio * ratio : R(1.0)) : BANK[level][0];
    out->markov_time = quiet ? R(2.0) : BANK[level][1];
    out->lines = kept.lines;
    for (int l = 0; l < RN_ALIGN_LINES; l++) {
        const real sd = R(3.0) * kept.omega_sd[l], most = R(0.4) * kept.omega[l];
        out->omega[l] = kept.omega[l];
        out->omega_sd[l] = sd < most ? sd : most;
    }
}

/* Look for lines in [start, now) and let a filter with them compete; where lines held until then, also one without:
   it starts from what they taught, as no filter of the bank does. */
static void propose(RN(align) * a, int start)
{
    const int now = a->count;
    const RN(align_snapshot) *snap = &a->snapshot[start / steps(a, SNAPSHOT_TIME) % RN_ALIGN_SNAPSHOTS];
    RN(align_wind) wind;
    real total, past = R(0.0), score = R(0.0);
    fill_window(a, start == 0 ? &a->origin : &snap->core, start, now);
    identify(a, &wind);
    if (wind.lines == 0 && (start == 0 || !a->has_lines)) return;
    if (start == 0) {
        start_filter(a, &a->trial, &wind);
    } else {
        RN(align_filter_graft)(&a->trial, &a->setup, &wind, snap);
        score = snap->score;
    }
    score = replay(a, &a->trial, start, now, score, &total) - R(3.0) * (real)wind.lines;
    for (int k = start; k < now; k++) past += a->line_history[k % RN_ALIGN_RECORD];
    const int early = (real)now * a->setup.period < REFIT_UNTIL + R(0.5) * a->setup.period;
    if (a->has_lines && !early && total < past + R(5.0) + R(3.0) * (real)wind.lines) return;
    a->filter[LINES] = a->trial;
    a->score[LINES] = score;
    a->fit = R(2.0);
    a->has_lines = 1;
    for (int k = start; k < now; k++) a->line_history[k % RN_ALIGN_RECORD] = total / (real)(now - start);
}

/* Log weight of filter i. */
static real merit(const RN(align) * a, int i) { return i < LINES ? a->score[i] - BANK[i][2] : a->score[i]; }

static int leading(const RN(align) * a)
{
    int best = 0;
    for (int i = 1; i < RN_ALIGN_BANK + a->has_lines; i++) {
        if (merit(a, i) > merit(a, best)) best = i;
    }
    return best;
}

static void keep_snapshot(RN(align) * a)
{
    RN(align_filter) *f = &a->trial;
    RN(align_snapshot) *s = &a->snapshot[a->count / steps(a, SNAPSHOT_TIME) % RN_ALIGN_SNAPSHOTS];
    *f = a->filter[leading(a)];
    if (f->anchored) RN(align_filter_anchor)(f);
    s->core = f->core;
    s->anchored = f->anchored;
    s->score = a->score[leading(a)];
    for (int i = 0; i < f->common; i++) memcpy(s->P + i * f->common, f->P + i * f->n, (size_t)f->common * sizeof(real));
}

static void check(RN(align) * a)
{
    const real time = (real)a->count * a->setup.period;
    if (time < EARLY_TIME + R(0.05)) {
        propose(a, 0);
    } else if (!(a->has_lines && leading(a) == LINES && a->filter[LINES].wind.lines > 0 && a->fit < HEALTHY)) {
        propose(a, a->count - steps(a, EARLY_TIME));
        propose(a, a->count - steps(a, SHORT_WINDOW));
    }
    const real wait = time < R(19.9) ? R(1.0) : time < R(29.9) ? R(5.0) : R(10.0);
    a->next = a->count + steps(a, wait);
}

int RN(align_start)(RN(align) * a, const RN(align_setup) * s)
{
    const real rate = R(1.0) / s->period;
    if (!(rate > R(1.999) && rate < R(10.001)) || rn_abs(rate - rn_floor(rate + R(0.5))) > R(1e-3)) return -1;
    memset(a, 0, sizeof *a);
    a->setup = *s;
    a->next = steps(a, FIRST_TIME);
    for (int i = 0; i < RN_ALIGN_BANK; i++) {
        a->filter[i].wind.markov_sd = BANK[i][0];
        a->filter[i].wind.markov_time = BANK[i][1];
    }
    return 0;
}

void RN(align_step)(RN(align) * a, const real *reading)
{
    const real keep = rn_exp(-a->setup.period / MEMORY), blend = a->setup.period / R(5.0);
    const int level = steps(a, LEVEL_TIME);
    memcpy(a->record[a->count % RN_ALIGN_RECORD], reading, sizeof a->record[0]);
    a->count++;
    if (a->count <= level) {
        if (a->count == level) restart(a);
        return;
    }
    for (int i = 0; i < RN_ALIGN_BANK + a->has_lines; i++) {
        RN(align_filter) *f = &a->filter[i];
        RN(align_filter_predict)(f, &a->setup, reading);
        if (!missing(reading)) {
            RN(align_filter_update)(f, &a->setup, reading + REFERENCE);
            a->score[i] = keep * a->score[i] + f->log_likelihood;
        }
        RN(align_filter_bearing)(f, &a->setup, reading + RN_ALIGN_FIELD_AT);
    }
    if (a->has_lines && missing(reading)) a->line_history[(a->count - 1) % RN_ALIGN_RECORD] = R(0.0);
    if (a->has_lines && !missing(reading)) {
        a->line_history[(a->count - 1) % RN_ALIGN_RECORD] = a->filter[LINES].log_likelihood;
        a->fit += blend * (a->filter[LINES].misfit - a->fit);
    }
    if (a->count % steps(a, SNAPSHOT_TIME) == 0) keep_snapshot(a);
    recentre(a);
    if (a->count >= a->next) check(a);
}

/* The weights of the filters, from their scores. */
static void weigh(const RN(align) * a, real *weight)
{
    const int broad_only = a->count < steps(a, FIRST_TIME), active = RN_ALIGN_BANK + a->has_lines;
    real top = R(0.0), sum = R(0.0);
    int first = 1;
    for (int i = 0; i < active; i++) {
        if (broad_only && i < LINES && BANK[i][0] < BROAD_SD) continue;
        if (first || merit(a, i) > top) top = merit(a, i);
        first = 0;
    }
    for (int i = 0; i < RN_ALIGN_FILTERS; i++) {
        const int silent = i >= active || (broad_only && BANK[i][0] < BROAD_SD) || merit(a, i) < top - R(20.0);
        weight[i] = silent ? R(0.0) : rn_exp(merit(a, i) - top);
        sum += weight[i];
    }
    for (int i = 0; i < RN_ALIGN_FILTERS; i++) weight[i] /= sum;
}

int RN(align_read)(const RN(align) * a, RN(align_answer) * out)
{
    real weight[RN_ALIGN_FILTERS];
    RN(align_answer) each[RN_ALIGN_FILTERS];
    if (a->count < steps(a, LEVEL_TIME)) return 0;
    weigh(a, weight);
    for (int i = 0; i < RN_ALIGN_FILTERS; i++) {
        if (weight[i] > R(0.0)) RN(align_filter_answer)(&a->filter[i], &a->setup, &each[i]);
    }
    RN(align_mix)(each, weight, RN_ALIGN_FILTERS, out);
    return 1;
}
