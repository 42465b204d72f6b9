/* Which winds are tried, and which a window of the record speaks for. */
#include "rn_align.h"

#include <string.h>

enum { LEVELS = 7, TIMES = 4 };

/* The bank: a wind's correlation time [s], and how fast it changes: 2 sd^2 / time = SLOWEST 2^k, k from SLOW to FAST.
 * Readings show the rate of change well and the time badly, and tilt is told from slow wind alone. */
static const real SLOWEST = R(0.00125); /* m^2/s^3 */
static const real TIME[TIMES] = {R(1.0), R(3.0), R(9.0), R(27.0)};
static const int SLOW[TIMES] = {2, 1, 0, 0}, FAST[TIMES] = {11, 11, 9, 7};

static const real AROUND_TIME = R(4.0); /* s */
static const real AROUND[LEVELS] = {R(0.0), R(0.035), R(0.07), R(0.14), R(0.28), R(0.56), R(1.5)}; /* m/s, tried about lines */
static const real WIDE[RN_ALIGN_NEXT] = {R(0.5), R(1.5)}; /* m/s */
static const real POSSIBLE = R(4.0);    /* nats less than the best noise about lines */
static const real HOPELESS = R(1e9);    /* nats */
static const real RESOLVED = R(12.0);   /* s, a window in which lines are just told apart */

static void plain(RN(align_wind) * wind, real markov_sd, real markov_time)
{
    memset(wind, 0, sizeof *wind);
    wind->markov_sd = markov_sd;
    wind->markov_time = markov_time;
}

/* Wind i of the bank; the first is none. */
void RN(align_bank_wind)(int i, RN(align_wind) * wind)
{
    int j = i - 1;
    plain(wind, R(0.0), AROUND_TIME);
    if (i == 0) return;
    for (int t = 0; t < TIMES; t++) {
        const int size = FAST[t] - SLOW[t] + 1;
        if (j < size) {
            const real speed = SLOWEST * (real)(1 << (SLOW[t] + j));
            plain(wind, rn_sqrt(R(0.5) * speed * TIME[t]), TIME[t]);
            return;
        }
        j -= size;
    }
}

void RN(align_wide_wind)(int i, RN(align_wind) * wind) { plain(wind, WIDE[i], AROUND_TIME); }

/* The lines with the most evidence: start at the likeliest noise without lines, then try less of it. */
static void find_lines(RN(align_window) * w, RN(align_spectrum) * kept)
{
    int level = 0;
    real best = R(0.0);
    RN(align_spectrum) found;
    for (int i = 0; i < LEVELS; i++) {
        const real value = RN(align_whiten)(w, AROUND[i], AROUND_TIME);
        if (i == 0 || value > best) {
            best = value;
            level = i;
        }
    }
    memset(kept, 0, sizeof *kept);
    RN(align_search)(w, AROUND[level], AROUND_TIME, best, kept);
    for (int i = level - 1; i >= 0; i--) {
        found = *kept;
        RN(align_search)(w, AROUND[i], AROUND_TIME, kept->evidence, &found);
        if (!(found.evidence > kept->evidence)) break;
        *kept = found;
    }
}

/* A line not yet told from its neighbour leaves a remainder that shrinks as the window grows. */
static void leave_remainder(const RN(align_window) * w, RN(align_wind) * out)
{
    const real ratio = RESOLVED / ((real)w->n * w->period);
    plain(out, R(0.05) * (ratio < R(1.0) ? ratio * ratio * ratio : R(1.0)), R(2.0));
}

static void add_lines(const RN(align_spectrum) * from, RN(align_wind) * out)
{
    out->lines = from->lines;
    for (int l = 0; l < RN_ALIGN_LINES; l++) {
        const real sd = R(3.0) * from->omega_sd[l], most = R(0.4) * from->omega[l];
        out->omega[l] = from->omega[l];
        out->omega_sd[l] = sd < most ? sd : most;
    }
}

/* The lines found, in the noises about them that may be, the likeliest first. */
int RN(align_identify)(RN(align_window) * w, RN(align_wind) * out)
{
    real evidence[RN_ALIGN_BANK], top = R(0.0), time = R(0.0);
    RN(align_spectrum) lines;
    RN(align_wind) noise;
    int used = 0;
    find_lines(w, &lines);
    if (lines.lines == 0) return 0;
    for (int i = 0, falls = 0; i < RN_ALIGN_BANK; i++) {
        RN(align_bank_wind)(i, &noise);
        falls = falls && noise.markov_time <= time; /* of one correlation time, winds grow and pass their best */
        time = noise.markov_time;
        evidence[i] = falls ? -HOPELESS : RN(align_given)(w, noise.markov_sd, time, &lines);
        if (i == 0 || evidence[i] > top) top = evidence[i];
        falls = evidence[i] < top - R(2.0) * POSSIBLE && i > 0 && evidence[i] < evidence[i - 1];
    }
    for (; used < RN_ALIGN_LINED; used++) {
        int best = 0;
        for (int i = 1; i < RN_ALIGN_BANK; i++) best = evidence[i] > evidence[best] ? i : best;
        if (evidence[best] < top - POSSIBLE) break;
        RN(align_bank_wind)(best, &out[used]);
        if (best == 0) leave_remainder(w, &out[used]);
        add_lines(&lines, &out[used]);
        evidence[best] = -HOPELESS;
    }
    return used;
}
