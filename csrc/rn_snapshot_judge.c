/* The verdict on readings that fit: one place, two, or a direction left open.  The readable form is
 * robustnav.snapshot.judge and geometry. */
#include <string.h>

#include "rn_snapshot_core.h"

#define RISE R(0.25) /* share of the promised rise of the cost below which an ellipsoid is given up */

/* Dilution of precision of the coordinates that are measured; infinite where one is not observable. */
static void dilution(const RN(fix_problem) * q, const real *p, RN(fix_result) * out)
{
    const int f = q->d - (q->z_info > R(0.0));
    RN(fix_rays) rays;
    real mean[3] = {R(0.0)}, G[6] = {R(0.0)}, values[3], vectors[3][3], P[6];
    RN(fix_cast)(q, p, &rays);
    for (int i = 0; i < q->k && q->differences; i++) {
        for (int j = 0; j < 3; j++) mean[j] += rays.u[j][i] / (real)q->k;
    }
    for (int i = 0; i < q->k; i++) {
        const real x = rays.u[0][i] - mean[0], y = rays.u[1][i] - mean[1], z = rays.u[2][i] - mean[2];
        G[0] += x * x, G[1] += x * y, G[2] += x * z, G[3] += y * y, G[4] += y * z, G[5] += z * z;
    }
    RN(fix_eigen)(G, f, values, vectors);
    const int good = RN(fix_covariance)(values, (const real(*)[3])vectors, f, P);
    const real level = P[0] + P[3], rest = f == 3 ? P[5] : R(0.0);
    out->gdop = good ? rn_sqrt(level + rest) : (real)INFINITY;
    out->hdop = good ? rn_sqrt(level) : (real)INFINITY;
    out->vdop = f < 3 ? (real)NAN : good ? rn_sqrt(rest) : (real)INFINITY;
}

static int near_anchor(const RN(fix_problem) * q, const real *p)
{
    RN(fix_rays) rays;
    real sum = R(0.0);
    RN(fix_cast)(q, p, &rays);
    for (int i = 0; i < q->k; i++) sum += q->w[i];
    for (int i = 0; i < q->k; i++) {
        if (rays.d[i] < R(3.0) / rn_sqrt(rn_fix_own(q, sum, i))) return 1;
    }
    return 0;
}

/* Why no ellipsoid can be given. */
static int open_cause(const RN(fix_problem) * q, const RN(fix_options) * o, const RN(fix_survey) * seen,
                      const RN(fix_result) * out)
{
    const real *p = seen->end[0].at.p;
    if (!(out->best.P[0] == out->best.P[0])) return RN_FIX_SINGULAR;
    if (!seen->settled) return near_anchor(q, p) ? RN_FIX_ON_ANCHOR : RN_FIX_UNSETTLED;
    if (!(out->gdop <= o->max_gdop)) return RN_FIX_GDOP;
    for (int i = 1; i < seen->count; i++) {
        if (!RN(fix_parted)(q, p, seen->end[i].at.p, o->quantile[1])) return RN_FIX_MERGED;
    }
    return RN_FIX_NONE;
}

/* The plane half-way between two positions if the anchors lie in it, to a tenth of the layout. */
static void mirror(const RN(fix_problem) * q, const real *a, const real *b, RN(fix_result) * out)
{
    const real off[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, length = rn_sqrt(rn_dot3(off, off));
    real sum = R(0.0);
    for (int l = 0; l < 3; l++) {
        out->plane_point[l] = R(0.5) * (a[l] + b[l]);
        out->plane_normal[l] = off[l] / length;
    }
    for (int i = 0; i < q->k; i++) {
        real height = R(0.0);
        for (int l = 0; l < 3; l++) height += (q->a[l][i] - out->plane_point[l]) * out->plane_normal[l];
        sum += height * height;
    }
    const real distance = rn_sqrt(sum / (real)q->k);
    out->plane_distance = distance < R(0.1) * RN(fix_scale)(q) ? distance : (real)NAN;
}

/* A direction's sd is the larger of its first-order sd and the stretch that the cost really allows; the covariance of
 * the best is drawn out to it. */
static void weaken(const RN(fix_problem) * q, const RN(fix_survey) * seen, real info, real rise, RN(fix_result) * out)
{
    const real scale = RN(fix_scale)(q), sd = R(1.0) / rn_sqrt(rn_larger(info, RN_FIX_TINY));
    const real *v = out->weak;
    const real reach = RN(fix_stretch)(q, &seen->end[0].at, v, rn_smaller(sd * rn_sqrt(rise), scale), rise);
    /* far beyond the layout the first order means nothing, and the stretch alone counts */
    out->weak_sd = sd > scale ? reach : rn_larger(reach, sd);
    const real missing = rn_larger(out->weak_sd * out->weak_sd - rn_form(out->best.P, v), R(0.0));
    for (int i = 0, n = 0; i < 3; i++) {
        for (int j = i; j < 3; j++, n++) {
            out->best.P[n] = out->weak_sd < (real)INFINITY ? out->best.P[n] + missing * v[i] * v[j] : (real)NAN;
        }
    }
}

static void candidate(RN(fix_end) * end, int d, RN(fix_candidate) * out)
{
    RN(fix_eigen)(end->at.H, d, end->values, end->vectors);
    RN(fix_covariance)(end->values, (const real(*)[3])end->vectors, d, out->P);
    memcpy(out->p, end->at.p, sizeof end->at.p);
    out->cost = end->at.cost;
}

/* The candidate's ellipsoid with its axes drawn out to where the cost reaches what they promise. */
static void stretched(const RN(fix_end) * end, int d, const real *shares, RN(fix_candidate) * out)
{
    for (int i = 0; i < 6; i++) out->P[i] = R(0.0);
    for (int l = 0; l < d; l++) {
        const real *v = end->vectors[l], variance = R(1.0) / (end->values[l] * shares[l]);
        for (int i = 0, n = 0; i < 3; i++) {
            for (int j = i; j < 3; j++, n++) out->P[n] += v[i] * v[j] * variance;
        }
    }
}

/* The verdict on minima whose residuals fit, into `judged`, `cause`, `best`, `other`, weak, dop and plane.
 *
 * Degenerate if anything is wrong with the best minimum or the ellipsoid of any; else ambiguous if there are several. */
void RN(fix_judge)(const RN(fix_problem) * q, const RN(fix_options) * o, RN(fix_survey) * seen, RN(fix_result) * out)
{
    const int d = q->d, count = seen->count;
    RN(fix_end) *best = &seen->end[0];
    real shares[RN_FIX_STARTS][3];
    int axis = 0;
    candidate(best, d, &out->best);
    for (int i = 1; i < count; i++) candidate(&seen->end[i], d, &out->other[i - 1]);
    out->others = count - 1;
    out->plane_distance = (real)NAN;
    dilution(q, best->at.p, out);
    if (count == 2) mirror(q, best->at.p, seen->end[1].at.p, out);
    out->cause = open_cause(q, o, seen, out);
    if (!out->cause) {
        real least = R(2.0);
        for (int i = 0; i < count; i++) RN(fix_shares)(q, &seen->end[i], rn_sqrt(o->quantile[d]), shares[i]);
        for (int j = 0; j < d; j++) {
            for (int i = 0; i < count; i++) {
                if (!(shares[i][j] < least)) continue;
                least = shares[i][j];
                axis = j;
            }
        }
        out->cause = least < RISE ? RN_FIX_BENT : RN_FIX_NONE;
    }
    if (out->cause) {
        memcpy(out->weak, best->vectors[axis], sizeof out->weak);
        weaken(q, seen, best->values[axis], o->quantile[1], out);
        out->judged = RN_FIX_DEGENERATE;
        if (out->cause == RN_FIX_SINGULAR) { /* along an open direction the other end points are arbitrary */
            out->others = 0;
            out->plane_distance = (real)NAN;
        }
        return;
    }
    stretched(best, d, shares[0], &out->best);
    for (int i = 1; i < count; i++) stretched(&seen->end[i], d, shares[i], &out->other[i - 1]);
    memcpy(out->weak, best->vectors[0], sizeof out->weak);
    out->weak_sd = rn_sqrt(rn_form(out->best.P, out->weak));
    out->judged = out->others ? RN_FIX_AMBIGUOUS : RN_FIX_UNIQUE;
}
