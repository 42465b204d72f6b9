/* Which anchor does not fit, what a test cannot see, and the whole solution.  The readable form is
 * robustnav.snapshot.faults and solve. */
#include "rn_snapshot.h"

#include <string.h>

#include "rn_snapshot_core.h"

#define HUBER R(1.345) /* 95 % and about 93 % efficient on clean readings */
#define STUDENT R(4.0)
#define ROUNDS 30

/* A choice of anchors left out. */
typedef struct {
    int left[RN_FIX_FAULTS];
    real p[3], P[6], cost;
} fit_t;

/* The best choices, by cost. */
typedef struct {
    int count, size;
    fit_t fit[RN_FIX_OTHERS + 1];
} fits_t;

static real table(const RN(fix_options) * o, int dof) { return o->quantile[dof < 1 ? 1 : dof]; }

static void without(const RN(fix_problem) * q, const int *left, int size, RN(fix_problem) * out)
{
    *out = *q;
    out->k = 0;
    for (int i = 0; i < q->k; i++) {
        int gone = 0;
        for (int j = 0; j < size; j++) gone |= left[j] == i;
        if (gone) continue;
        for (int l = 0; l < 3; l++) out->a[l][out->k] = q->a[l][i];
        out->r[out->k] = q->r[i];
        out->w[out->k++] = q->w[i];
    }
    RN(fix_arrange)(out);
}

/* The next choice of `size` out of k in lexical order; 0 after the last. */
static int next_choice(int *left, int size, int k)
{
    int i = size - 1;
    while (i >= 0 && left[i] == k - size + i) i--;
    if (i < 0) return 0;
    left[i]++;
    for (int j = i + 1; j < size; j++) left[j] = left[j - 1] + 1;
    return 1;
}

static void insert(fits_t *fits, const int *left, const RN(fix_point) * at, int d)
{
    real values[3], vectors[3][3];
    int i = fits->count;
    if (i > RN_FIX_OTHERS) {
        if (!(at->cost < fits->fit[RN_FIX_OTHERS].cost)) return;
        i = RN_FIX_OTHERS;
    } else {
        fits->count++;
    }
    for (; i > 0 && at->cost < fits->fit[i - 1].cost; i--) fits->fit[i] = fits->fit[i - 1];
    fit_t *fit = &fits->fit[i];
    for (int j = 0; j < fits->size; j++) fit->left[j] = left[j];
    memcpy(fit->p, at->p, sizeof fit->p);
    fit->cost = at->cost;
    RN(fix_eigen)(at->H, d, values, vectors);
    RN(fix_covariance)(values, (const real(*)[3])vectors, d, fit->P);
}

/* The smallest set of anchors whose removal makes the rest fit, and its rivals; at least one degree of freedom must be
 * left, or nothing tests the rest. */
static int consensus(const RN(fix_problem) * q, const RN(fix_options) * o, fits_t *fits)
{
    const int spare = RN(fix_dof)(q) - 1;
    fits->count = 0;
    for (int size = 1; size <= o->max_faults && size <= spare && size <= RN_FIX_FAULTS && !fits->count; size++) {
        int left[RN_FIX_FAULTS];
        fits->size = size;
        for (int j = 0; j < size; j++) left[j] = j;
        do {
            RN(fix_problem) rest;
            RN(fix_survey) seen;
            without(q, left, size, &rest);
            RN(fix_look)(&rest, o, &seen);
            if (seen.end[0].at.cost <= table(o, RN(fix_dof)(&rest))) insert(fits, left, &seen.end[0].at, q->d);
        } while (next_choice(left, size, q->k));
    }
    int rivals = fits->count > 0;
    while (rivals < fits->count && fits->fit[rivals].cost <= fits->fit[0].cost + o->quantile[1]) rivals++;
    fits->count = rivals;
    return rivals;
}

static void suspect(const RN(fix_problem) * q, int anchor, const fit_t *fit, real full_cost, RN(fix_result) * out)
{
    RN(fix_rays) rays;
    real sum = R(0.0);
    int i = out->suspects;
    for (int j = 0; j < i; j++) {
        if (out->suspect[j].anchor == anchor) return;
    }
    RN(fix_cast)(q, fit->p, &rays);
    for (int j = 0; j < q->k; j++) sum += q->w[j];
    const real free = q->differences ? R(1.0) - q->w[anchor] / sum : R(1.0);
    const real sds = rn_sqrt(rn_larger(full_cost - fit->cost, R(0.0)));
    for (; i > 0 && sds > out->suspect[i - 1].sds; i--) out->suspect[i] = out->suspect[i - 1];
    out->suspect[i].anchor = anchor;
    out->suspect[i].error = rays.e[anchor] / free;
    out->suspect[i].sds = sds;
    out->suspects++;
}

/* Weights of all anchors from their residuals: Student-t (nu + 1) / (nu + e^2), at most 1, or Huber's. */
static void reweight(const RN(fix_problem) * q, const RN(fix_problem) * fitted, const real *p, int huber, real *weights)
{
    RN(fix_rays) rays;
    real sum = R(0.0), fitted_sum = R(0.0), mean = R(0.0), whole = R(0.0);
    RN(fix_cast)(q, p, &rays);
    for (int i = 0; i < q->k; i++) sum += q->w[i], fitted_sum += fitted->w[i];
    for (int i = 0; i < q->k && q->differences; i++) {
        const real own = rn_fix_own(fitted, fitted_sum, i);
        mean += own * rays.e[i];
        whole += own;
    }
    if (q->differences) mean /= whole;
    for (int i = 0; i < q->k; i++) {
        const real e = rn_abs(rays.e[i] - mean) * rn_sqrt(rn_fix_own(q, sum, i));
        const real raw = huber ? HUBER / rn_larger(e, HUBER) : (STUDENT + R(1.0)) / (STUDENT + e * e);
        /* half the mean keeps a round from chasing its own weights in a circle */
        weights[i] = rn_sqrt(weights[i] * rn_smaller(raw, R(1.0)));
    }
}

/* Each anchor's variance is raised to sd^2 / weight: Holland and Welsch, Communications in Statistics A6 (1977). */
static void reweighted(const RN(fix_problem) * q, int huber, RN(fix_problem) * fitted, RN(fix_survey) * seen, real *weights)
{
    RN(fix_end) *end = &seen->end[0];
    real sum = R(0.0), most = R(0.0);
    int steps = 0;
    *fitted = *q;
    for (int i = 0; i < q->k; i++) sum += q->w[i], weights[i] = R(1.0);
    for (int i = 0; i < q->k; i++) most = rn_larger(most, rn_fix_own(q, sum, i));
    for (int round = 0; round < ROUNDS; round++) {
        real before[3], moved = R(0.0);
        memcpy(before, end->at.p, sizeof before);
        reweight(q, fitted, before, huber, weights);
        for (int i = 0; i < q->k; i++) {
            const real extra = (R(1.0) / weights[i] - R(1.0)) / rn_fix_own(q, sum, i);
            fitted->w[i] = R(1.0) / (R(1.0) / q->w[i] + extra);
        }
        RN(fix_descend)(fitted, NULL, RN_FIX_STEPS, end);
        steps += end->steps;
        for (int l = 0; l < 3; l++) moved = rn_larger(moved, rn_abs(end->at.p[l] - before[l]));
        if (moved < R(1e-6) / rn_sqrt(most)) break;
    }
    seen->count = seen->settled = 1;
    seen->steps = steps;
}

/* The solution of the anchors that agree, or of all reweighted, and the names of those that do not fit. */
static void inconsistent(const RN(fix_problem) * q, const RN(fix_options) * o, RN(fix_survey) * seen, RN(fix_result) * out)
{
    const real full_cost = seen->end[0].at.cost;
    RN(fix_problem) rest = *q;
    fits_t fits;
    const int found = consensus(q, o, &fits);
    if (found) {
        without(q, fits.fit[0].left, fits.size, &rest);
        RN(fix_look)(&rest, o, seen);
        for (int i = 0; i < fits.size; i++) out->weights[fits.fit[0].left[i]] = R(0.0);
    }
    if (o->repair != RN_FIX_EXCLUDE) {
        reweighted(q, o->repair == RN_FIX_HUBER, &rest, seen, out->weights);
    }
    RN(fix_judge)(&rest, o, seen, out);
    if (o->repair != RN_FIX_EXCLUDE) out->best.cost = full_cost;
    out->verdict = RN_FIX_INCONSISTENT;
    out->isolated = found == 1;
    out->steps = seen->steps;
    for (int i = 0; i < found; i++) {
        for (int j = 0; j < fits.size; j++) suspect(q, fits.fit[i].left[j], &fits.fit[i], full_cost, out);
        if (i == 0 || out->others + out->rivals >= RN_FIX_OTHERS) continue;
        RN(fix_candidate) *rival = &out->other[out->others + out->rivals++];
        memcpy(rival->p, fits.fit[i].p, sizeof rival->p);
        memcpy(rival->P, fits.fit[i].P, sizeof rival->P);
        rival->cost = fits.fit[i].cost;
    }
}

/* The largest shift [m] by one anchor's error that leaves the noise-free residual cost at `limit`.
 * Parkinson and Axelrad, Navigation 35 (1988): slope of position against test statistic. */
static real unseen_shift(const RN(fix_problem) * q, const RN(fix_end) * end, real limit)
{
    RN(fix_rays) rays;
    real P[6], mean[3] = {R(0.0)}, sum = R(0.0), steepest = R(0.0);
    const int whole = RN(fix_covariance)(end->values, (const real(*)[3])end->vectors, q->d, P);
    if (RN(fix_dof)(q) < 1 || !whole) return (real)INFINITY;
    RN(fix_cast)(q, end->at.p, &rays);
    for (int i = 0; i < q->k; i++) sum += q->w[i];
    for (int i = 0; i < q->k && q->differences; i++) {
        for (int l = 0; l < 3; l++) mean[l] += q->w[i] * rays.u[l][i] / sum;
    }
    for (int i = 0; i < q->k; i++) {
        const real own = rn_fix_own(q, sum, i), w2 = q->w[i] * q->w[i];
        const real u[3] = {rays.u[0][i] - mean[0], rays.u[1][i] - mean[1], rays.u[2][i] - mean[2]};
        const real gain[3] = {P[0] * u[0] + P[1] * u[1] + P[2] * u[2], P[1] * u[0] + P[3] * u[1] + P[4] * u[2],
                              P[2] * u[0] + P[4] * u[1] + P[5] * u[2]};
        const real left = own - w2 * rn_dot3(u, gain);
        if (left < RN_FIX_BLIND * own) return (real)INFINITY;
        steepest = rn_larger(steepest, w2 * rn_dot3(gain, gain) / left);
    }
    return rn_sqrt(steepest * limit);
}

void RN(fix_solve)(const RN(fix_problem) * q, const RN(fix_options) * o, RN(fix_result) * out)
{
    const int dof = RN(fix_dof)(q);
    const real limit = table(o, dof), nan = (real)NAN;
    RN(fix_survey) seen;
    memset(out, 0, sizeof *out);
    out->dof = dof;
    out->unseen_shift = (real)INFINITY;
    out->plane_distance = out->weak_sd = out->gdop = out->hdop = out->vdop = out->cost = nan;
    if (dof < 0 || q->k < 1) {
        out->verdict = out->judged = RN_FIX_TOO_FEW;
        for (int i = 0; i < 3; i++) out->best.p[i] = out->weak[i] = nan;
        for (int i = 0; i < 6; i++) out->best.P[i] = nan;
        return;
    }
    for (int i = 0; i < q->k; i++) out->weights[i] = R(1.0);
    RN(fix_look)(q, o, &seen);
    if (o->judge && seen.end[0].at.cost > limit) {
        const real full_cost = seen.end[0].at.cost;
        inconsistent(q, o, &seen, out);
        out->cost = full_cost;
        return;
    }
    if (o->judge) {
        RN(fix_judge)(q, o, &seen, out);
        out->unseen_shift = unseen_shift(q, &seen.end[0], limit);
    } else {
        real values[3], vectors[3][3];
        RN(fix_eigen)(seen.end[0].at.H, q->d, values, vectors);
        RN(fix_covariance)(values, (const real(*)[3])vectors, q->d, out->best.P);
        memcpy(out->best.p, seen.end[0].at.p, sizeof out->best.p);
        out->judged = seen.settled ? RN_FIX_UNIQUE : RN_FIX_DEGENERATE;
    }
    out->verdict = out->judged;
    out->cost = out->best.cost = seen.end[0].at.cost;
    out->steps = seen.steps;
}
