/* Is the minimum the only one, and does its ellipsoid tell the truth?  The readable form is robustnav.snapshot.honest.
 *
 * Two shortcuts, both of them only where they cannot change the answer: a proof that there is one minimum spares the
 * other starts (`alone`), and Newton's method finds the points of least cost across an axis (`quick_across`). */
#include <string.h>

#include "rn_snapshot_core.h"

#define SAME R(0.01) /* squared distance in units of the covariance below which two end points are one minimum */
#define LONG 40      /* more steps for slow descents that decide a verdict */
#define LADDER 27    /* steps along a weak direction, from 2^-6 to 2^7 of its presumed reach */

/* The cost along a basis. */
typedef struct {
    real cost, g[2], H[3];
} slice_t;

/* Whether no other position within quantile(1) of this minimum of ranges can be a minimum.
 *
 * Let p be such a position, D = p - p0, C the cost allowed, d0 and d the distances, e0 and e the residuals at p0 and p,
 * v = d - d0.  The slope of the cost at p along D is twice
 *     sum w v^2 - sum w (|D|^2 - v^2) (e0 / (2 d0) + e / (2 d)).
 * Squared ranges are linear in p: sum w v^2 (2 + v / d0)^2 >= 4 D' A D with A = sum w / d0^2 (a - mean)(a - mean)'.
 * Both costs bound every v.  If the first sum is larger for all D, p is no minimum, wherever it is. */
static int alone(const RN(fix_problem) * q, const RN(fix_point) * at, const RN(fix_rays) * rays, real margin)
{
    const real most = rn_sqrt(at->cost + margin), both = most + rn_sqrt(at->cost);
    real mean[3] = {R(0.0)}, sum = R(0.0), A[6] = {R(0.0)}, shift = R(0.0), own = R(0.0), other = R(0.0);
    for (int i = 0; i < q->k; i++) {
        const real inverse = R(1.0) / rays->d[i], weight = q->w[i] * inverse * inverse;
        const real v = both / rn_sqrt(q->w[i]) * inverse;
        if (!(v < R(0.5))) return 0;
        const real far = inverse / (R(1.0) - v);
        shift = rn_larger(shift, v);
        own += q->w[i] * rn_larger(rays->e[i], R(0.0)) * inverse;
        other += q->w[i] * far * far;
        sum += weight;
        for (int j = 0; j < 3; j++) mean[j] += weight * q->a[j][i];
    }
    for (int j = 0; j < 3; j++) mean[j] /= sum;
    for (int i = 0; i < q->k; i++) {
        const real weight = q->w[i] / (rays->d[i] * rays->d[i]);
        const real x = q->a[0][i] - mean[0], y = q->a[1][i] - mean[1], z = q->a[2][i] - mean[2];
        A[0] += weight * x * x, A[1] += weight * x * y, A[2] += weight * x * z;
        A[3] += weight * y * y, A[4] += weight * y * z, A[5] += weight * z * z;
    }
    const real share = R(3.96) / ((R(2.0) + shift) * (R(2.0) + shift)); /* 1 % for rounding */
    const real bend = R(0.5) * (own + most * rn_sqrt(other));
    const real none[3] = {R(0.0), R(0.0), R(0.0)};
    real M[3][3], b[3];
    for (int j = 0; j < 6; j++) A[j] *= share;
    A[0] -= bend, A[3] -= bend, A[5] += q->z_info - bend;
    RN(fix_project)(A, none, NULL, q->d, M, b);
    return RN(fix_factor)(M, b, q->d);
}

static real least_cost(const RN(fix_end) * end, int count)
{
    real least = end[0].at.cost;
    for (int i = 1; i < count; i++) least = rn_smaller(least, end[i].at.cost);
    return least;
}

static int before(const RN(fix_end) * a, const RN(fix_end) * b)
{
    return a->settled != b->settled ? a->settled > b->settled : a->at.cost < b->at.cost;
}

static int same(const RN(fix_point) * a, const RN(fix_point) * b)
{
    const real off[3] = {a->p[0] - b->p[0], a->p[1] - b->p[1], a->p[2] - b->p[2]};
    return rn_larger(rn_form(a->H, off), rn_form(b->H, off)) < SAME;
}

/* Keep of the end points those within `margin` of the best, settled ones first, then by cost, each minimum once. */
static void keep_distinct(RN(fix_survey) * seen, real margin)
{
    RN(fix_end) near[RN_FIX_STARTS];
    const real limit = least_cost(seen->end, seen->count) + margin;
    int count = 0;
    for (int i = 0; i < seen->count; i++) {
        if (seen->end[i].at.cost > limit) continue;
        int j = count++;
        for (; j > 0 && before(&seen->end[i], &near[j - 1]); j--) near[j] = near[j - 1];
        near[j] = seen->end[i];
    }
    if (!count) near[count++] = seen->end[0]; /* a margin below zero */
    seen->count = 0;
    seen->settled = 1;
    for (int i = 0; i < count; i++) {
        int known = 0;
        for (int j = 0; j < i && !known; j++) known = same(&near[i].at, &near[j].at);
        if (known) continue;
        seen->settled &= near[i].settled;
        seen->end[seen->count++] = near[i];
    }
    seen->steps = near[0].steps;
}

void RN(fix_look)(const RN(fix_problem) * q, const RN(fix_options) * o, RN(fix_survey) * seen)
{
    const real margin = o->quantile[1];
    RN(fix_end) *end = seen->end;
    real start[RN_FIX_STARTS][3];
    RN(fix_rays) rays;
    if (RN(fix_first)(q, end->at.p)) {
        RN(fix_descend)(q, NULL, RN_FIX_STEPS, end);
        RN(fix_cast)(q, end->at.p, &rays);
        if (!o->judge || (end->settled && alone(q, &end->at, &rays, margin))) {
            seen->count = 1;
            seen->settled = end->settled;
            seen->steps = end->steps;
            return;
        }
    }
    seen->count = RN(fix_starts)(q, start);
    for (int i = q->differences ? 0 : 1; i < seen->count; i++) {
        memcpy(end[i].at.p, start[i], sizeof start[i]);
        RN(fix_descend)(q, NULL, RN_FIX_STEPS, &end[i]);
    }
    /* what still crawls along a valley must not pass for another minimum, or for readings that contradict each other */
    const real limit = least_cost(end, seen->count) + margin;
    for (int i = 0; i < seen->count; i++) {
        if (!end[i].settled && end[i].at.cost <= limit) RN(fix_descend)(q, NULL, LONG, &end[i]);
    }
    keep_distinct(seen, margin);
}

/* The directions across a unit direction: the other rows of the Householder reflection that maps it to an axis. */
static void basis_across(const real *direction, int d, RN(fix_basis) * basis)
{
    const real beta = direction[0] < R(0.0) ? R(1.0) : R(-1.0), head = direction[0] - beta, tau = -head / beta;
    const real v[3] = {R(1.0), direction[1] / head, d > 2 ? direction[2] / head : R(0.0)};
    basis->f = d - 1;
    for (int l = 0; l < 3; l++) basis->b[1][l] = R(0.0);
    for (int i = 1; i < d; i++) {
        for (int l = 0; l < 3; l++) basis->b[i - 1][l] = (l == i ? R(1.0) : R(0.0)) - tau * v[i] * v[l];
    }
}

/* The point of least cost in the plane at `length` along a unit direction from p. */
void RN(fix_across)(const RN(fix_problem) * q, const real *p, const real *direction, real length, RN(fix_end) * end)
{
    RN(fix_basis) basis;
    basis_across(direction, q->d, &basis);
    for (int l = 0; l < 3; l++) end->at.p[l] = p[l] + length * direction[l];
    RN(fix_descend)(q, &basis, 8, end);
}

/* Cost, half its gradient and half its exact second derivative (packed) along the basis at p.  An anchor at distance d
 * with the residual e bends the cost by w ((1 + e / d) u u' - e / d I). */
static void slice(const RN(fix_problem) * q, const real *p, const RN(fix_basis) * basis, slice_t *out)
{
    const int k = q->k;
    const real *x = basis->b[0], *y = basis->b[1];
    real e[RN_FIX_ANCHORS], bend[RN_FIX_ANCHORS], s[RN_FIX_ANCHORS], t[RN_FIX_ANCHORS];
    real w_sum = R(0.0), e_mean = R(0.0), s_mean = R(0.0), t_mean = R(0.0);
    for (int i = 0; i < k; i++) {
        const real off[3] = {p[0] - q->a[0][i], p[1] - q->a[1][i], p[2] - q->a[2][i]};
        const real d = rn_sqrt(rn_dot3(off, off)), inverse = R(1.0) / (d > RN_FIX_TINY ? d : RN_FIX_TINY);
        e[i] = q->r[i] - d;
        bend[i] = q->w[i] * inverse;
        s[i] = rn_dot3(off, x) * inverse;
        t[i] = rn_dot3(off, y) * inverse;
    }
    if (q->differences) {
        for (int i = 0; i < k; i++) {
            w_sum += q->w[i], e_mean += q->w[i] * e[i], s_mean += q->w[i] * s[i], t_mean += q->w[i] * t[i];
        }
        e_mean /= w_sum, s_mean /= w_sum, t_mean /= w_sum;
    }
    const real off = p[2] - q->z, pull = q->z_info * off;
    real c = pull * off, gs = pull * x[2], gt = pull * y[2], level = R(0.0);
    real ss = q->z_info * x[2] * x[2], st = q->z_info * x[2] * y[2], tt = q->z_info * y[2] * y[2];
    for (int i = 0; i < k; i++) {
        const real own = e[i] - e_mean, we = q->w[i] * own, b = bend[i] * own, both = q->w[i] + b;
        c += we * own;
        gs -= we * s[i];
        gt -= we * t[i];
        ss += both * s[i] * s[i];
        st += both * s[i] * t[i];
        tt += both * t[i] * t[i];
        level += b;
    }
    out->cost = c;
    out->g[0] = gs, out->g[1] = gt;
    out->H[0] = ss - level - w_sum * s_mean * s_mean;
    out->H[1] = st - w_sum * s_mean * t_mean;
    out->H[2] = tt - level - w_sum * t_mean * t_mean;
}

/* The point of least cost from end->at.p along the basis where Newton's method is seen to converge, cost to about 1e-8.
 * Returns 0 elsewhere. */
static int quick_across(const RN(fix_problem) * q, const RN(fix_basis) * basis, RN(fix_end) * end)
{
    real last = R(10.0);
    for (int i = 0; i < 4; i++) {
        slice_t at;
        slice(q, end->at.p, basis, &at);
        if (basis->f == 1) at.H[1] = R(0.0), at.H[2] = R(1.0), at.g[1] = R(0.0);
        const real det = at.H[0] * at.H[2] - at.H[1] * at.H[1];
        if (!(at.H[0] > R(0.0) && det > R(0.0))) return 0;
        const real inverse = R(1.0) / det;
        const real s = (at.g[1] * at.H[1] - at.g[0] * at.H[2]) * inverse;
        const real t = (at.g[0] * at.H[1] - at.g[1] * at.H[0]) * inverse;
        const real decrement = -(at.g[0] * s + at.g[1] * t);
        for (int l = 0; l < 3; l++) end->at.p[l] += s * basis->b[0][l] + t * basis->b[1][l];
        if (!(decrement < R(0.1) * last)) return 0;
        last = decrement;
        end->at.cost = at.cost - decrement;
        if (decrement < R(1e-4)) return 1;
    }
    return 0;
}

/* Whether every range is linear within `reach` [m] of p to a tenth of its noise. */
static int straight(const RN(fix_problem) * q, const real *p, real reach)
{
    RN(fix_rays) rays;
    real sum = R(0.0);
    RN(fix_cast)(q, p, &rays);
    for (int i = 0; i < q->k; i++) sum += q->w[i];
    for (int i = 0; i < q->k; i++) {
        const real bent = R(0.5) * reach * reach / (rays.d[i] - reach) * rn_sqrt(rn_fix_own(q, sum, i));
        if (!(rays.d[i] > R(2.0) * reach && bent < R(0.1))) return 0;
    }
    return 1;
}

/* For each principal direction, weakest first, the share of the promised rise that the cost shows.
 *
 * At points along both halves of each axis of the ellipsoid of `radius` sd the cost is minimised across the axis; the
 * near ones see a region that closes on itself further out. */
void RN(fix_shares)(const RN(fix_problem) * q, const RN(fix_end) * centre, real radius, real *shares)
{
    const real *p = centre->at.p;
    /* information without a direction promises nothing that could be shown: a rival in the far field */
    const int flat = !(centre->values[0] > RN_FIX_FLAT * centre->values[q->d - 1]);
    for (int i = 0; i < q->d; i++) shares[i] = flat ? R(0.0) : R(1.0);
    if (flat) return;
    if (straight(q, p, radius / rn_sqrt(centre->values[0]))) return;
    for (int i = 0; i < q->d; i++) {
        const real *axis = centre->vectors[i], whole = radius / rn_sqrt(centre->values[i]);
        RN(fix_basis) basis;
        basis_across(axis, q->d, &basis);
        for (int side = -1; side < 2; side += 2) {
            real bent[3] = {R(0.0), R(0.0), R(0.0)}; /* across the axis; a quarter of it at half the length */
            for (int j = 0; j < 3; j++) {
                const real length = whole * (real)side * (j == 0 ? R(1.0) : j == 1 ? R(0.5) : R(0.25));
                RN(fix_end) end;
                for (int l = 0; l < 3; l++) end.at.p[l] = p[l] + length * axis[l] + bent[l];
                if (!quick_across(q, &basis, &end)) RN(fix_across)(q, p, axis, length, &end);
                const real off[3] = {end.at.p[0] - p[0], end.at.p[1] - p[1], end.at.p[2] - p[2]};
                const real risen = (end.at.cost - centre->at.cost) / rn_form(centre->at.H, off);
                shares[i] = rn_smaller(shares[i], rn_larger(risen, R(0.0)));
                for (int l = 0; l < 3; l++) bent[l] = R(0.25) * (off[l] - length * axis[l]);
            }
        }
    }
}

/* The sd along a direction [m]: how far the cost stays within `rise` of that at the minimum, over sqrt(rise). */
real RN(fix_stretch)(const RN(fix_problem) * q, const RN(fix_point) * at, const real *direction, real start, real rise)
{
    real reach = start * R(0.015625), farthest = R(0.0);
    for (int i = 0; i < LADDER; i++) {
        for (int side = 0; side < 2; side++) {
            RN(fix_end) end;
            RN(fix_across)(q, at->p, direction, side ? -reach : reach, &end);
            if (end.at.cost - at->cost < rise) farthest = reach;
        }
        if (i < LADDER - 1) reach *= R(1.4142135623730951);
    }
    if (farthest >= reach) return (real)INFINITY;
    return (farthest > R(0.0) ? farthest : start * R(0.015625)) / rn_sqrt(rise);
}

/* Whether the cost between two minima stands by `rise` above both: two places, not one long region. */
int RN(fix_parted)(const RN(fix_problem) * q, const real *a, const real *b, real rise)
{
    real top = R(0.0);
    for (int i = 1; i < 8; i++) {
        real p[3];
        for (int l = 0; l < 3; l++) p[l] = a[l] + (real)i * R(0.125) * (b[l] - a[l]);
        top = rn_larger(top, RN(fix_cost)(q, p));
    }
    return top - rn_larger(RN(fix_cost)(q, a), RN(fix_cost)(q, b)) > rise;
}
