/* The snapshot solver on sound and on hostile numbers, in double and in float.
 *
 * Built with the address and undefined-behaviour sanitizers: every array lies in a block of its own, of exactly the
 * size the interface promises. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rn_snapshot_host.h"

static int failures;

static void check(int holds, const char *what)
{
    if (holds) return;
    failures++;
    fprintf(stderr, "snapshot: %s\n", what);
}

static uint64_t state = 88172645463325252u;

static uint64_t bits(void)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return state;
}

static double uniform(void) { return (double)(bits() >> 11) / 9007199254740992.0; }

static double hostile(void)
{
    static const double nasty[] = {0.0,   -0.0,   1.0,    -1.0,   (double)NAN, (double)INFINITY, -(double)INFINITY,
                                   1e300, -1e300, 1e-300, 5e-324, 1e38,        -3.5e38,          1e-45};
    return bits() % 3 ? 20.0 * uniform() - 10.0 : nasty[bits() % (sizeof nasty / sizeof nasty[0])];
}

static double *room(size_t n)
{
    double *out = malloc(n ? n * sizeof(double) : 1);
    if (!out) abort();
    for (size_t i = 0; i < n; i++) out[i] = -1.0;
    return out;
}

static double *drawn(size_t n, double (*draw)(void))
{
    double *out = room(n);
    for (size_t i = 0; i < n; i++) out[i] = draw();
    return out;
}

static double one(void) { return 1.0; }
static double anchor(void) { return 10.0 * uniform() - 5.0; }
static double small(void) { return 0.02 + 0.02 * uniform(); }

/* Chi-square quantiles at 0.999, to a percent: Wilson and Hilferty, Proc. National Academy of Sciences 17 (1931). */
static double *quantiles(void)
{
    double *out = room(RN_FIX_QUANTILES);
    for (int dof = 1; dof < RN_FIX_QUANTILES; dof++) {
        const double share = 2.0 / (9.0 * dof), root = 1.0 - share + 3.0902 * sqrt(share);
        out[dof] = dof * root * root * root;
    }
    out[0] = out[1];
    return out;
}

typedef void (*run_t)(const rn_fix_batch *, size_t, size_t);

/* One batch of n epochs; returns how many are unique. */
static size_t solve(run_t run, int k, int d, int differences, size_t n, double (*draw)(void), const double *tag)
{
    const size_t anchors = (size_t)k, readings = n * (size_t)(k - differences);
    double *a = drawn(anchors * (size_t)d, tag ? anchor : draw), *z = drawn(readings, draw);
    double *sd = drawn(anchors, tag ? small : draw), *levels = tag ? quantiles() : drawn(RN_FIX_QUANTILES, draw);
    double *row = room(n * RN_FIX_ROW), *weights = room(n * anchors);
    double *others = room(n * RN_FIX_HOST_OTHERS * RN_FIX_OTHER_ROW);
    double *suspects = room(n * RN_FIX_HOST_ANCHORS * RN_FIX_SUSPECT_ROW);
    for (size_t i = 0; tag && i < readings; i++) {
        const size_t at = i % (size_t)(k - differences) + (size_t)differences;
        double far = 0.0, reference = 0.0;
        for (int l = 0; l < d; l++) {
            far += pow(a[at * (size_t)d + (size_t)l] - tag[l], 2);
            reference += pow(a[l] - tag[l], 2);
        }
        z[i] = sqrt(far) - (differences ? sqrt(reference) : 0.0) + 0.02 * (uniform() - 0.5);
        if (bits() % 40 == 0) z[i] = (double)NAN;
        if (bits() % 60 == 0) z[i] += 3.0;
    }
    rn_fix_batch b = {.n = n, .k = k, .d = d, .differences = differences, .anchors = a, .readings = z, .sd = sd,
                      .quantile = levels, .max_gdop = 50.0, .repair = (int)(bits() % 3), .max_faults = (int)(bits() % 3),
                      .judge = tag || bits() % 8, .row = row, .weights = weights, .others = others, .suspects = suspects};
    if (d == 3 && bits() % 3 == 0) {
        b.z = tag ? tag[2] : hostile();
        b.z_sd = tag ? 0.1 : fabs(hostile());
    }
    run(&b, 0, n);
    size_t unique = 0;
    for (size_t i = 0; i < n; i++) {
        const double *r = row + i * RN_FIX_ROW;
        check(r[0] >= 0 && r[0] <= 4 && r[1] >= 0 && r[1] <= 4, "a verdict that there is not");
        check(r[6] >= 0 && r[6] + r[7] <= RN_FIX_HOST_OTHERS && r[8] >= 0 && r[8] <= k, "counts past their arrays");
        if (r[0] != 0.0) continue;
        unique++;
        if (!tag) continue;
        double off = 0.0, spread = 0.0;
        for (int l = 0; l < d; l++) off += pow(r[10 + l] - tag[l], 2);
        spread = r[13] + r[16] + (d == 3 ? r[18] : 0.0);
        check(off < 30.0 * spread, "a unique position far from the tag");
    }
    free(a), free(z), free(sd), free(levels), free(row), free(weights), free(others), free(suspects);
    return unique;
}

/* One window; returns whether its best place is near the tag. */
static int search(int (*run)(rn_window_call *), int m, int places, double (*draw)(void), const double *tag)
{
    const size_t n = (size_t)m;
    double *where = drawn(3 * (size_t)places, tag ? anchor : draw), *value = drawn(n, draw), *sd = drawn(n, tag ? small : draw);
    double *first = room(3 * n), *second = room(3 * n), *guess = drawn(6, tag ? anchor : draw), *track = drawn(3 * n, draw);
    double *minima = room(RN_WINDOW_HOST_MINIMA * RN_FIX_OTHER_ROW);
    unsigned char *pair = malloc(n);
    if (!pair) abort();
    for (size_t i = 0; i < n; i++) {
        const size_t from = bits() % (size_t)places, to = (from + 1) % (size_t)places;
        double one_far = 0.0, other_far = 0.0;
        pair[i] = bits() % 2 != 0;
        for (size_t l = 0; l < 3; l++) {
            first[3 * i + l] = where[3 * from + l];
            second[3 * i + l] = where[3 * to + l];
            one_far += tag ? pow(first[3 * i + l] - tag[l], 2) : 0.0;
            other_far += tag ? pow(second[3 * i + l] - tag[l], 2) : 0.0;
        }
        if (tag) value[i] = (pair[i] ? sqrt(other_far) - sqrt(one_far) : sqrt(one_far)) + (bits() % 7 ? 0.0 : 2.0);
    }
    rn_window_call c = {.m = m, .guesses = 2, .value = value, .sd = sd, .first = first, .second = second, .pair = pair,
                        .down_known = (int)(bits() % 3), .down = tag ? tag[2] : hostile(), .down_sd = 0.1, .guess = guess,
                        .track = bits() % 2 ? track : NULL, .minima = minima};
    const int count = run(&c);
    check(count >= -1 && count <= RN_WINDOW_HOST_MINIMA, "minima past their array");
    double off = 0.0;
    for (int l = 0; l < 3 && tag && count > 0; l++) off += pow(minima[l] - tag[l], 2);
    free(where), free(value), free(sd), free(first), free(second), free(guess), free(track), free(minima), free(pair);
    return tag && count > 0 && off < 0.01;
}

int main(void)
{
    int (*const searches[2])(rn_window_call *) = {rn_window_run_double, rn_window_run_float};
    const run_t runs[2] = {rn_fix_run_double, rn_fix_run_float};
    const double tag[3] = {1.0, -2.0, 0.7};
    for (int type = 0; type < 2; type++) {
        size_t unique = 0;
        for (int round = 0; round < 60; round++) {
            const int d = 2 + round % 2, differences = round / 2 % 2;
            unique += solve(runs[type], 8, d, differences, 20, one, tag);
            for (int k = 1; k <= 32; k += 1 + (int)(bits() % 9)) {
                solve(runs[type], k, d, differences, (size_t)(1 + k % 3), hostile, NULL);
            }
        }
        solve(runs[type], 32, 3, 0, 2, one, tag);
        int near = 0;
        for (int round = 0; round < 60; round++) {
            near += search(searches[type], 60, 8, one, tag);
            search(searches[type], 1 + (int)(bits() % 100), 1 + (int)(bits() % 40), hostile, NULL);
        }
        search(searches[type], RN_WINDOW_READINGS, 32, one, tag);
        check(near > 50, "hardly any sound window gives the tag");
        check(unique > 600, "hardly any sound reading gives a unique position");
    }
    printf("snapshot driver: %s\n", failures ? "FAILED" : "fine");
    return failures != 0;
}
