/* Minima of the Student-t cost of a window.  The readable form is robustnav.snapshot.window. */
#include "rn_snapshot_window.h"

#include <string.h>

#include "rn_snapshot_core.h"

#define NU R(4.0)
#define MOST_STEPS 40
#define LONGEST_STEP R(10.0) /* m */
#define SMALL R(1e-6)        /* m, of a step */
#define APART R(3.0)         /* standard deviations between two minima that count as two */
#define LEAST_INFO R(1e-12)

/* The anchors of a window, in lexical order, and which of them a reading is from. */
typedef struct {
    int k;
    int first[RN_WINDOW_READINGS], second[RN_WINDOW_READINGS];
    real place[RN_FIX_ANCHORS][3];
} places_t;

static int compare(const real *a, const real *b)
{
    for (int l = 0; l < 3; l++) {
        if (a[l] != b[l]) return a[l] < b[l] ? -1 : 1;
    }
    return 0;
}

static int place_of(const places_t *all, const real *p)
{
    for (int i = 0; i < all->k; i++) {
        if (compare(all->place[i], p) == 0) return i;
    }
    return -1;
}

static int add_place(places_t *all, const real *p)
{
    if (place_of(all, p) >= 0) return 1;
    if (all->k == RN_FIX_ANCHORS) return 0;
    int i = all->k++;
    for (; i > 0 && compare(p, all->place[i - 1]) < 0; i--) memcpy(all->place[i], all->place[i - 1], sizeof all->place[i]);
    memcpy(all->place[i], p, sizeof all->place[i]);
    return 1;
}

static int gather(const RN(window) * w, places_t *all)
{
    all->k = 0;
    for (int i = 0; i < w->m; i++) {
        if (!add_place(all, w->first[i]) || (w->pair[i] && !add_place(all, w->second[i]))) return 0;
    }
    for (int i = 0; i < w->m; i++) {
        all->first[i] = place_of(all, w->first[i]);
        all->second[i] = w->pair[i] ? place_of(all, w->second[i]) : 0;
        if (all->first[i] < 0 || all->second[i] < 0) return 0; /* not a number is at no place */
    }
    return 1;
}

static real median(real *v, int n)
{
    for (int i = 1; i < n; i++) {
        const real one = v[i];
        int j = i;
        for (; j > 0 && one < v[j - 1]; j--) v[j] = v[j - 1];
        v[j] = one;
    }
    return n % 2 ? v[n / 2] : R(0.5) * (v[n / 2 - 1] + v[n / 2]);
}

/* Arrivals up to a common offset, from all pairs at once: the least-squares solution of least norm, by conjugate
 * gradients from zero (Hestenes and Stiefel 1952), which takes at most as many steps as there are places. */
static void arrivals(const RN(window) * w, const places_t *all, real *x)
{
    real r[RN_FIX_ANCHORS] = {R(0.0)}, s[RN_FIX_ANCHORS], As[RN_FIX_ANCHORS], size = R(0.0);
    for (int i = 0; i < w->m; i++) {
        if (!w->pair[i]) continue;
        r[all->second[i]] += w->value[i];
        r[all->first[i]] -= w->value[i];
    }
    for (int i = 0; i < all->k; i++) x[i] = R(0.0), s[i] = r[i], size += r[i] * r[i];
    const real enough = R(1e4) * RN_FIX_EPS * RN_FIX_EPS * size; /* beyond it, rounding would walk off along the offset */
    for (int step = 0; step < 2 * all->k && size > enough; step++) {
        real bend = R(0.0), length = R(0.0), next = R(0.0);
        memset(As, 0, sizeof As);
        for (int i = 0; i < w->m; i++) {
            if (!w->pair[i]) continue;
            const real across = s[all->second[i]] - s[all->first[i]];
            As[all->second[i]] += across;
            As[all->first[i]] -= across;
        }
        for (int i = 0; i < all->k; i++) bend += s[i] * As[i], length += s[i] * s[i];
        if (!(bend > R(100.0) * RN_FIX_EPS * length)) return;
        for (int i = 0; i < all->k; i++) {
            x[i] += size / bend * s[i];
            r[i] -= size / bend * As[i];
            next += r[i] * r[i];
        }
        for (int i = 0; i < all->k; i++) s[i] = r[i] + next / size * s[i];
        size = next;
    }
}

/* One range a place: the closed forms start from the problem of one instant that they make. */
static void instant(const RN(window) * w, const places_t *all, RN(fix_problem) * q)
{
    real room[RN_WINDOW_READINGS];
    int differences = 0;
    for (int i = 0; i < w->m; i++) {
        differences |= w->pair[i] != 0;
        room[i] = w->sd[i];
    }
    const real sd = median(room, w->m);
    memset(q, 0, sizeof *q);
    q->k = all->k;
    q->d = 3;
    q->differences = differences;
    q->z = w->down_known ? w->down : R(0.0);
    if (w->down_known) q->z_info = w->down_known == RN_WINDOW_PLANE ? R(1e6) : R(1.0) / (w->down_sd * w->down_sd);
    for (int i = 0; i < all->k; i++) {
        int n = 0;
        for (int l = 0; l < 3; l++) q->a[l][i] = all->place[i][l];
        for (int j = 0; j < w->m && !differences; j++) {
            if (all->first[j] == i) room[n++] = w->value[j];
        }
        q->r[i] = n ? median(room, n) : R(0.0);
        q->w[i] = R(1.0) / (sd * sd);
    }
    if (differences) arrivals(w, all, q->r);
    RN(fix_arrange)(q);
}

/* Predicted value of one reading and its row. */
static real predict(const RN(window) * w, int i, const real *p, real *row)
{
    real off[3], predicted;
    for (int l = 0; l < 3; l++) off[l] = p[l] - w->first[i][l];
    predicted = rn_sqrt(rn_dot3(off, off));
    for (int l = 0; l < 3; l++) row[l] = off[l] / rn_larger(predicted, R(1e-12));
    if (!w->pair[i]) return predicted;
    for (int l = 0; l < 3; l++) off[l] = p[l] - w->second[i][l];
    const real other = rn_sqrt(rn_dot3(off, off));
    for (int l = 0; l < 3; l++) row[l] = off[l] / rn_larger(other, R(1e-12)) - row[l];
    return other - predicted;
}

static real own_cost(const RN(window) * w, int i, real e)
{
    const real share = e / w->sd[i];
    return R(0.5) * (NU + R(1.0)) * rn_log(R(1.0) + share * share / NU);
}

static real height_cost(const RN(window) * w, real z)
{
    const real off = w->down_known == RN_WINDOW_HEIGHT ? (z - w->down) / w->down_sd : R(0.0);
    return R(0.5) * off * off;
}

real RN(window_cost)(const RN(window) * w, const real (*place)[3])
{
    real row[3], cost = w->m ? height_cost(w, place[0][2]) : R(0.0);
    for (int i = 0; i < w->m; i++) cost += own_cost(w, i, w->value[i] - predict(w, i, place[i], row));
    return cost;
}

/* Cost, half the downhill slope as -g and the weighted information at one place. */
static void expand(const RN(window) * w, RN(fix_point) * at)
{
    real row[3];
    at->cost = height_cost(w, at->p[2]);
    memset(at->g, 0, sizeof at->g);
    memset(at->H, 0, sizeof at->H);
    if (w->down_known == RN_WINDOW_HEIGHT) {
        at->H[5] = R(1.0) / (w->down_sd * w->down_sd);
        at->g[2] = (at->p[2] - w->down) * at->H[5];
    }
    for (int i = 0; i < w->m; i++) {
        const real e = w->value[i] - predict(w, i, at->p, row);
        const real weight = (NU + R(1.0)) / (NU * w->sd[i] * w->sd[i] + e * e);
        at->cost += own_cost(w, i, e);
        for (int l = 0, n = 0; l < 3; l++) {
            at->g[l] -= weight * e * row[l];
            for (int o = l; o < 3; o++) at->H[n++] += weight * row[l] * row[o];
        }
    }
}

static void descend(const RN(window) * w, real reach, RN(fix_point) * at)
{
    const int free = w->down_known == RN_WINDOW_PLANE ? 2 : 3;
    const real small = SMALL + R(8.0) * RN_FIX_EPS * reach;
    real damping = R(1e-3);
    if (free == 2) at->p[2] = w->down;
    expand(w, at);
    for (int i = 0; i < MOST_STEPS; i++) {
        RN(fix_point) trial = *at;
        real M[3][3], step[3], largest = R(0.0), length2 = R(0.0);
        RN(fix_project)(at->H, at->g, NULL, free, M, step);
        for (int l = 0; l < free; l++) largest = rn_larger(largest, M[l][l]);
        for (int l = 0; l < free; l++) M[l][l] += damping * M[l][l] + (RN_FIX_RIDGE * largest + RN_FIX_TINY);
        RN(fix_factor)(M, step, free);
        for (int l = 0; l < free; l++) length2 += step[l] * step[l];
        const real length = rn_sqrt(length2), share = rn_smaller(R(1.0), LONGEST_STEP / rn_larger(length, RN_FIX_TINY));
        for (int l = 0; l < free; l++) trial.p[l] += share * step[l];
        expand(w, &trial);
        const int better = trial.cost <= at->cost;
        if (better) *at = trial;
        damping *= better ? R(0.1) : R(10.0);
        if ((better && length < small) || damping > R(1e12)) return;
    }
}

static void candidate_of(const RN(window) * w, const RN(fix_point) * at, RN(fix_candidate) * out, real *largest)
{
    const int free = w->down_known == RN_WINDOW_PLANE ? 2 : 3;
    real values[3], vectors[3][3];
    RN(fix_eigen)(at->H, free, values, vectors);
    memcpy(out->p, at->p, sizeof out->p);
    out->cost = at->cost;
    memset(out->P, 0, sizeof out->P);
    for (int i = 0; i < free; i++) {
        const real *v = vectors[i], variance = R(1.0) / rn_larger(values[i], LEAST_INFO);
        for (int l = 0, n = 0; l < 3; l++) {
            for (int o = l; o < 3; o++, n++) out->P[n] += v[l] * v[o] * variance;
        }
    }
    *largest = R(1.0) / rn_larger(values[0], LEAST_INFO);
}

/* Keep an end point in the order of costs. */
static void insert_point(RN(fix_point) * end, int *count, const RN(fix_point) * at)
{
    if (!(at->p[0] * R(0.0) == R(0.0) && at->p[1] * R(0.0) == R(0.0) && at->p[2] * R(0.0) == R(0.0))) return;
    int i = (*count)++;
    for (; i > 0 && at->cost < end[i - 1].cost; i--) end[i] = end[i - 1];
    end[i] = *at;
}

/* The image of p across the plane the anchors come nearest to. */
static void mirrored(const RN(fix_problem) * q, const real *p, real *image)
{
    real spread[6] = {R(0.0)}, values[3], vectors[3][3], height = R(0.0);
    for (int i = 0; i < q->k; i++) {
        for (int l = 0, n = 0; l < 3; l++) {
            for (int o = l; o < 3; o++) spread[n++] += (q->a[l][i] - q->centre[l]) * (q->a[o][i] - q->centre[o]);
        }
    }
    RN(fix_eigen)(spread, 3, values, vectors);
    for (int l = 0; l < 3; l++) height += vectors[0][l] * (p[l] - q->centre[l]);
    for (int l = 0; l < 3; l++) image[l] = p[l] - R(2.0) * height * vectors[0][l];
}

int RN(window_minima)(const RN(window) * w, const real (*guess)[3], int guesses, RN(fix_candidate) * out)
{
    RN(fix_problem) q;
    RN(fix_point) end[RN_WINDOW_MINIMA + 1], at;
    real start[RN_FIX_STARTS][3], largest[RN_WINDOW_MINIMA + 1];
    places_t all;
    int count = 0, kept = 0;
    if (w->m < 3) return 0;
    if (!gather(w, &all)) return -1;
    instant(w, &all, &q);
    const int closed = RN(fix_starts)(&q, start);
    for (int i = 0; i < closed + guesses && i < RN_WINDOW_MINIMA - 1; i++) {
        memcpy(at.p, i < closed ? start[i] : guess[i - closed], sizeof at.p);
        descend(w, RN(fix_scale)(&q), &at);
        insert_point(end, &count, &at);
    }
    if (count && w->down_known != RN_WINDOW_PLANE) {
        mirrored(&q, end[0].p, at.p);
        descend(w, RN(fix_scale)(&q), &at);
        insert_point(end, &count, &at);
    }
    for (int i = 0; i < count; i++) {
        int new = 1;
        for (int j = 0; j < kept && new; j++) {
            const real off[3] = {end[i].p[0] - out[j].p[0], end[i].p[1] - out[j].p[1], end[i].p[2] - out[j].p[2]};
            new = rn_sqrt(rn_dot3(off, off)) > APART * rn_sqrt(largest[j]) + R(1e-3);
        }
        if (!new) continue;
        candidate_of(w, &end[i], &out[kept], &largest[kept]);
        kept++;
    }
    return kept;
}
