/* The estimator: a bank of winds without lines, filters with the lines found so far, and the record to find them in. */
#include "rn_align.h"

#include <string.h>

enum {
    LINES = RN_ALIGN_BANK, /* where filters stand: the bank, those with lines, those for what may come next */
    NEXT = LINES + RN_ALIGN_LINED,
    END = RN_ALIGN_FILTERS,
    RECENTRES = 3,
    REFERENCE = RN_ALIGN_VELOCITY_AT
};

static const real LEVEL_TIME = R(2.0);   /* s before the filters start */
static const real FIRST_TIME = R(12.0);  /* s of record needed to tell a slow wind from a tilt */
static const real EARLY_TIME = R(60.0);  /* s: until then the window is the whole record */
static const real SHORT_WINDOW = R(20.0);
static const real SNAPSHOT_TIME = R(10.0);
static const real PREPARE_TIME = R(20.0); /* s, between starts of filters for the next wind */
static const real MEMORY = R(150.0);     /* s, forgetting of likelihood */
static const real BROAD_SD = R(0.5);     /* m/s: winds below it have no say before FIRST_TIME */
static const real REFIT_UNTIL = R(40.0); /* s: until then new lines always replace the old */
static const real COARSE = R(1e-3);      /* rad/s: gyro biases beyond it are taken off the record as soon as they are known */
static const real COARSE_BOTH = R(1e-6); /* rad/s: or beyond this times the accelerometer's biases over gravity */
static const real RECENTRE_TIME[] = {R(5.0), R(12.0), R(30.0)};
static const real HEALTHY = R(2.6);      /* smoothed misfit, 2 expected */
static const real NEGLIGIBLE = R(20.0);  /* nats below the best */
static const real LINE_PRIOR = R(3.0);   /* nats, of a line whose frequency was found in what is judged */
static const real CHANGE_COST = R(8.0);  /* nats: at ten readings a second a wind changes about once in five minutes */
static const real FASTER = R(4.0);       /* times: below that the bank has what comes next */
static const real CHANGE_FROM = R(40.0); /* s */

static int steps(const RN(align) * a, real time) { return (int)(time / a->setup.period + R(0.5)); }

/* Whether filter i has a say: in the first seconds, and after a change, smooth winds pass for tilts. */
static int says(const RN(align) * a, int i)
{
    const int early = a->count - a->changed < steps(a, FIRST_TIME);
    return a->on[i] && !(early && i < LINES && a->filter[i].wind.markov_sd < BROAD_SD);
}

/* The filter with the highest score of [from, to), -1 if none has a say. */
static int leading(const RN(align) * a, int from, int to)
{
    int best = -1;
    for (int i = from; i < to; i++) {
        if (says(a, i) && (best < 0 || a->score[i] > a->score[best])) best = i;
    }
    return best;
}

static const RN(align_snapshot) *snapshot_at(const RN(align) * a, int k)
{
    return &a->snapshot[k / steps(a, SNAPSHOT_TIME) % RN_ALIGN_SNAPSHOTS];
}

/* Run filter f with a wind from reading `from` to now: from the origin, linear about it after a recentring, or from what
 * was known at a snapshot.  In its first two seconds gusts are left out, later it judges them itself.  Returns its score;
 * past a snapshot the wind may have changed at any time since.  *total is the plain log likelihood. */
static real run_from(RN(align) * a, RN(align_filter) * f, const RN(align_wind) * wind, int from, real *total)
{
    const real keep = rn_exp(-a->setup.period / MEMORY);
    const int careful = from + steps(a, LEVEL_TIME);
    const real limit = RN(align_odd_limit)(a, from, careful);
    real score = R(0.0);
    *total = R(0.0);
    if (from == 0) {
        RN(align_filter_start)(f, &a->setup, wind, &a->origin);
        if (a->recentred > 0) RN(align_filter_anchor)(f);
    } else {
        RN(align_filter_graft)(f, &a->setup, wind, snapshot_at(a, from));
        score = a->best[(from - 1) % RN_ALIGN_RECORD] - CHANGE_COST;
    }
    for (int k = from; k < a->count; k++) {
        const real *reading = RN(align_reading)(a, k), least = a->best[k % RN_ALIGN_RECORD] - CHANGE_COST;
        RN(align_filter_predict)(f, &a->setup, reading);
        if (k < careful ? RN(align_oddness)(a, k, from, careful) <= limit : !RN(align_missing)(reading)) {
            RN(align_filter_update)(f, &a->setup, reading + REFERENCE);
            score = keep * score + f->log_likelihood;
            *total += f->log_likelihood;
        }
        if (from > 0 && score < least) score = least;
        RN(align_filter_bearing)(f, &a->setup, reading + RN_ALIGN_FIELD_AT);
    }
    return score - LINE_PRIOR * (real)wind->lines;
}

/* Run filter i with a wind from reading `from` on. */
static void begin(RN(align) * a, int i, const RN(align_wind) * wind, int from)
{
    real total;
    a->score[i] = run_from(a, &a->filter[i], wind, from, &total);
    a->fit[i] = R(2.0);
    a->on[i] = 1;
}

/* Level, and run all filters over the whole record. */
static void restart(RN(align) * a)
{
    const int level = steps(a, LEVEL_TIME);
    RN(align_core) *origin = &a->origin;
    RN(align_level)(a->record[0], level, origin->gyro_bias, origin->q);
    if (a->recentred == 0) RN(align_forget_odd_fields)(a->record[0], level, &a->setup, origin->q);
    for (int axis = 0; axis < 2; axis++) origin->v[axis] = RN(align_median)(a, 0, level < 5 ? level : 5, axis);
    for (int i = 0; i < END; i++) {
        const RN(align_wind) wind = a->filter[i].wind;
        if (a->on[i]) begin(a, i, &wind, 0);
    }
}

/* While the bias of coarse gyros is learned, attitude and its turns move with every reading, and what moves seems to tell
 * tilt from the accelerometer's bias.  So, few times: start over, linear about the gyro bias found. */
static void recentre(RN(align) * a)
{
    const RN(align_setup) *s = &a->setup;
    RN(align_answer) said;
    if (!(s->gyro_bias_sd > COARSE || s->gyro_bias_sd * s->accel_bias_sd > COARSE_BOTH * s->gravity)) return;
    if (a->recentred == RECENTRES || a->count != steps(a, RECENTRE_TIME[a->recentred])) return;
    RN(align_read)(a, &said);
    memcpy(a->origin.gyro_bias, said.gyro_bias, sizeof said.gyro_bias);
    a->recentred++;
    restart(a);
}

/* Look for lines in [start, now) and let filters with them compete. */
static void propose(RN(align) * a, int start)
{
    const int now = a->count;
    const real age = (real)(now - start) * a->setup.period;
    RN(align_wind) wind[RN_ALIGN_LINED];
    real total, past = R(0.0);
    RN(align_fill_window)(a, start == 0 ? &a->origin : &snapshot_at(a, start)->estimate, start, now);
    const int found = RN(align_identify)(&a->window, wind);
    if (found == 0) return;
    const real score = run_from(a, &a->trial, &wind[0], start, &total);
    for (int k = start; k < now; k++) past += a->history[k % RN_ALIGN_RECORD];
    const int early = start == a->lines_from && age < REFIT_UNTIL + R(0.5) * a->setup.period;
    if (!early && total < past + R(5.0) + LINE_PRIOR * (real)wind[0].lines) return;
    for (int i = 1; i < RN_ALIGN_LINED; i++) {
        a->on[LINES + i] = 0;
        if (i < found) begin(a, LINES + i, &wind[i], start);
    }
    a->filter[LINES] = a->trial;
    a->score[LINES] = score;
    a->fit[LINES] = R(2.0);
    a->on[LINES] = 1;
    a->lines_from = start;
    for (int k = start; k < now && total > past; k++) a->history[k % RN_ALIGN_RECORD] = total / (real)(now - start);
}

/* How fast a wind changes besides its lines [m^2/s^3]. */
static real speed(const RN(align_wind) * wind) { return R(2.0) * wind->markov_sd * wind->markov_sd / wind->markov_time; }

static int healthy(const RN(align) * a) { return a->fit[leading(a, 0, END)] < HEALTHY; }

/* Have filters ready for the winds that may come next: they start from what the best knew ten seconds ago, before any
 * change that does not show yet. */
static void prepare(RN(align) * a)
{
    const int from = a->count - steps(a, SNAPSHOT_TIME), old = a->count - a->next_from >= steps(a, CHANGE_FROM);
    const int best = leading(a, 0, END);
    RN(align_wind) wind;
    if (a->count < steps(a, CHANGE_FROM) || !(healthy(a) || old)) return;
    for (int i = 0; i < RN_ALIGN_NEXT; i++) {
        RN(align_wide_wind)(i, &wind);
        a->on[NEXT + i] = 0;
        if (speed(&wind) > FASTER * speed(&a->filter[best].wind)) begin(a, NEXT + i, &wind, from);
    }
    a->next_from = from;
}

/* The wind has changed: the bank starts anew from what was known before. */
static void follow(RN(align) * a)
{
    RN(align_wind) wind;
    for (int i = 0; i < RN_ALIGN_BANK; i++) {
        RN(align_bank_wind)(i, &wind);
        begin(a, i, &wind, a->next_from);
    }
    for (int i = NEXT; i < END; i++) a->on[i] = 0;
    a->changed = a->count;
}

/* Stop filters that are far worse than the best; those of the bank than the best of the bank, in case lines deceive. */
static void prune(RN(align) * a)
{
    const real best = a->score[leading(a, 0, END)], of_bank = a->score[leading(a, 0, LINES)];
    for (int i = 0; i < NEXT; i++) {
        if (a->score[i] < (i < LINES ? of_bank : best) - NEGLIGIBLE) a->on[i] = 0;
    }
}

static void keep_snapshot(RN(align) * a)
{
    const RN(align_filter) *f = &a->filter[leading(a, 0, END)];
    RN(align_snapshot) *s = &a->snapshot[a->count / steps(a, SNAPSHOT_TIME) % RN_ALIGN_SNAPSHOTS];
    s->core = f->core;
    s->anchored = f->anchored;
    memcpy(s->off, f->off, sizeof s->off);
    RN(align_filter_estimate)(f, &s->estimate);
    for (int i = 0; i < f->common; i++) memcpy(s->P + i * f->common, f->P + i * f->n, (size_t)f->common * sizeof(real));
}

static void check(RN(align) * a)
{
    const real time = (real)a->count * a->setup.period;
    if (time < EARLY_TIME + R(0.05)) {
        propose(a, 0);
    } else {
        const int held = leading(a, 0, END) >= LINES && healthy(a);
        const int young = (real)(a->count - a->lines_from) * a->setup.period < EARLY_TIME + R(0.05);
        if (held && young) propose(a, a->lines_from); /* its window still grows */
        if (!held || young) propose(a, a->count - steps(a, SHORT_WINDOW));
        if (!held) propose(a, a->count - steps(a, EARLY_TIME));
    }
    prune(a);
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
        RN(align_bank_wind)(i, &a->filter[i].wind);
        a->on[i] = 1;
    }
    return 0;
}

/* Take the newest reading with all filters that run. */
static void run_filters(RN(align) * a, const real *reading)
{
    const real keep = rn_exp(-a->setup.period / MEMORY), blend = a->setup.period / R(5.0);
    const int there = !RN(align_missing)(reading), now = (a->count - 1) % RN_ALIGN_RECORD;
    for (int i = 0; i < END; i++) {
        RN(align_filter) *f = &a->filter[i];
        if (!a->on[i]) continue;
        RN(align_filter_predict)(f, &a->setup, reading);
        if (there) {
            RN(align_filter_update)(f, &a->setup, reading + REFERENCE);
            a->score[i] = keep * a->score[i] + f->log_likelihood;
            a->fit[i] += blend * (f->misfit - a->fit[i]);
        }
        RN(align_filter_bearing)(f, &a->setup, reading + RN_ALIGN_FIELD_AT);
    }
    const int best = leading(a, 0, END);
    a->history[now] = there ? a->filter[best].log_likelihood : R(0.0);
    a->best[now] = a->score[best];
    for (int i = NEXT; i < END; i++) {
        if (a->score[i] < a->best[now] - CHANGE_COST) a->score[i] = a->best[now] - CHANGE_COST;
    }
}

void RN(align_step)(RN(align) * a, const real *reading)
{
    const int level = steps(a, LEVEL_TIME);
    memcpy(a->record[a->count % RN_ALIGN_RECORD], reading, sizeof a->record[0]);
    a->count++;
    if (a->count < level) return;
    if (a->count == level) {
        restart(a);
        return;
    }
    run_filters(a, reading);
    if (leading(a, 0, END) >= NEXT) follow(a);
    if (a->count % steps(a, SNAPSHOT_TIME) == 0) {
        if (a->count % steps(a, PREPARE_TIME) == 0) prepare(a);
        keep_snapshot(a);
    }
    recentre(a);
    if (a->count >= a->next) check(a);
}

/* The weights of the filters, from their scores. */
static void weigh(const RN(align) * a, real *weight)
{
    const real top = a->score[leading(a, 0, END)];
    real sum = R(0.0);
    for (int i = 0; i < END; i++) {
        weight[i] = says(a, i) && a->score[i] > top - CHANGE_COST ? rn_exp(a->score[i] - top) : R(0.0);
        sum += weight[i];
    }
    for (int i = 0; i < END; i++) weight[i] /= sum;
}

int RN(align_read)(const RN(align) * a, RN(align_answer) * out)
{
    real weight[END];
    RN(align_answer) each[END];
    if (a->count < steps(a, LEVEL_TIME)) return 0;
    weigh(a, weight);
    for (int i = 0; i < END; i++) {
        if (weight[i] > R(0.0)) RN(align_filter_answer)(&a->filter[i], &a->setup, &each[i]);
    }
    RN(align_mix)(each, weight, END, out);
    return 1;
}
