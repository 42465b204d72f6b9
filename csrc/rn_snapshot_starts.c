/* Closed-form starts of the descent.  The readable form is robustnav.snapshot.starts.
 *
 * Coordinates y are along the principal directions of the anchors, strongest first, where the columns of the linearised
 * problem are nearly orthogonal: dropping the weakest is dropping the last. */
#include <string.h>

#include "rn_snapshot_core.h"

#define CIRCLE 8          /* starts around a line */
#define FARTHEST R(30.0)  /* in units of the layout's scale */
#define COLUMNS 4         /* of a linear problem: the coordinates and the distance to the reference */

typedef struct {
    const RN(fix_problem) * q;
    int f, count; /* free coordinates; starts so far */
    real scale, noise; /* noise: its size in a squared distance across a plane or line [m^2] */
    real (*start)[3];
} list_t;

/* The weighted linear problem N y = n that squared ranges make, about the weighted centre. */
typedef struct {
    real centre[3], N[3][3], n[3], level;
} linear_t;

static int free_count(const RN(fix_problem) * q) { return q->d - (q->z_info > R(0.0)); }

static void along(const RN(fix_problem) * q, const real *from, int i, int f, real *y)
{
    const real off[3] = {q->a[0][i] - from[0], q->a[1][i] - from[1], q->a[2][i] - from[2]};
    for (int j = 0; j < f; j++) y[j] = rn_dot3(q->axes[j], off);
}

void RN(fix_arrange)(RN(fix_problem) * q)
{
    const int f = free_count(q);
    real spread[6] = {R(0.0)}, values[3], vectors[3][3], reach2 = R(0.0);
    for (int j = 0; j < 3; j++) {
        real sum = R(0.0);
        for (int i = 0; i < q->k; i++) sum += q->a[j][i];
        q->centre[j] = q->k ? sum / (real)q->k : R(0.0);
    }
    for (int i = 0; i < q->k; i++) {
        const real off[3] = {q->a[0][i] - q->centre[0], q->a[1][i] - q->centre[1], q->a[2][i] - q->centre[2]};
        int n = 0;
        for (int j = 0; j < 3; j++) {
            for (int l = j; l < 3; l++) spread[n++] += off[j] * off[l];
        }
        reach2 = rn_larger(reach2, rn_dot3(off, off));
    }
    q->reach = rn_sqrt(reach2);
    RN(fix_eigen)(spread, f, values, vectors);
    memset(q->axes, 0, sizeof q->axes);
    for (int j = 0; j < f; j++) memcpy(q->axes[j], vectors[f - 1 - j], sizeof vectors[0]);
}

/* A start at coordinates y from `from`, drawn in along its direction where the closed form blew up. */
static void add(list_t *list, const real *from, const real *y)
{
    const RN(fix_problem) *q = list->q;
    real off[3];
    for (int l = 0; l < 3; l++) {
        off[l] = from[l] - q->centre[l];
        for (int j = 0; j < list->f; j++) off[l] += y[j] * q->axes[j][l];
    }
    if (list->f < 3) off[2] = R(0.0);
    const real far = FARTHEST * list->scale, length2 = rn_dot3(off, off);
    const real share = length2 > far * far ? far / rn_sqrt(length2) : R(1.0);
    real *start = list->start[list->count++];
    for (int l = 0; l < 3; l++) start[l] = q->centre[l] + share * off[l];
    if (list->f < 3) start[2] = q->z_info > R(0.0) ? q->z : R(0.0);
}

/* Points (coordinates, up to CIRCLE) at the squared distance `left` from y across the directions from `kept` on. */
static int across(const list_t *list, const real *y, int kept, real left, real noise, real (*points)[3])
{
    const int weak = list->f - kept, count = weak == 0 ? 1 : weak == 1 ? 2 : CIRCLE;
    /* its own noise keeps the two sides apart when the tag is in the plane */
    const real h = rn_sqrt(rn_larger(left, R(0.25) * noise)), r = h * R(0.7071067811865476);
    const real turn[CIRCLE][2] = {{h, R(0.0)},  {r, r},   {R(0.0), h},  {-r, r},
                                  {-h, R(0.0)}, {-r, -r}, {R(0.0), -h}, {r, -r}};
    for (int i = 0; i < count; i++) {
        for (int j = 0; j < 3; j++) points[i][j] = j < kept ? y[j] : R(0.0);
        if (weak == 1) points[i][kept] = i ? -h : h;
        if (weak == 2) points[i][kept] = turn[i][0], points[i][kept + 1] = turn[i][1];
    }
    return count;
}

static void linearise(const RN(fix_problem) * q, int f, linear_t *out)
{
    real squared[RN_FIX_ANCHORS], weight[RN_FIX_ANCHORS], sum = R(0.0), left = R(0.0);
    memset(out, 0, sizeof *out);
    for (int i = 0; i < q->k; i++) {
        const real rise = f < q->d ? q->z - q->a[2][i] : R(0.0);
        squared[i] = q->r[i] * q->r[i] - rise * rise;
        weight[i] = q->w[i] / (rn_larger(squared[i], R(0.0)) + R(1.0) / q->w[i]);
        sum += weight[i];
    }
    for (int i = 0; i < q->k; i++) {
        weight[i] /= sum;
        for (int l = 0; l < 3; l++) out->centre[l] += weight[i] * q->a[l][i];
    }
    for (int i = 0; i < q->k; i++) {
        real B[3], size = R(0.0);
        along(q, out->centre, i, f, B);
        for (int j = 0; j < f; j++) size += B[j] * B[j];
        const real half = R(0.5) * (size - squared[i]);
        left -= weight[i] * half;
        for (int j = 0; j < f; j++) {
            const real share = weight[i] * B[j];
            out->n[j] += share * half;
            for (int l = j; l < f; l++) out->N[j][l] += share * B[l];
        }
    }
    out->level = R(2.0) * left;
}

/* The first `kept` coordinates of the linear problem, zero where the anchors do not tell. */
static void solve_linear(const linear_t *linear, int kept, int anchors, real *y)
{
    real N[3][3], b[3], largest = R(0.0);
    memcpy(N, linear->N, sizeof N);
    memcpy(b, linear->n, sizeof b);
    for (int i = 0; i < kept; i++) largest = rn_larger(largest, N[i][i]);
    const real least = RN_FIX_EPS * (real)anchors * RN_FIX_EPS * (real)anchors * largest;
    for (int i = 0; i < kept; i++) {
        const real inverse = N[i][i] > least ? R(1.0) / N[i][i] : R(0.0);
        y[i] = inverse;
        for (int j = i + 1; j < kept; j++) {
            const real ratio = N[i][j] * inverse;
            for (int l = j; l < kept; l++) N[j][l] -= ratio * N[i][l];
            b[j] -= ratio * b[i];
        }
    }
    for (int i = kept - 1; i >= 0; i--) {
        for (int j = i + 1; j < kept; j++) b[i] -= N[i][j] * y[j];
        y[i] *= b[i];
    }
}

/* Weighted squared-range least squares: Beck, Stoica, Li, IEEE Trans. Signal Processing 56 (2008), unconstrained. */
static void from_ranges(list_t *list, int only_first)
{
    const RN(fix_problem) *q = list->q;
    linear_t linear;
    linearise(q, list->f, &linear);
    for (int kept = list->f; kept > 0; kept--) {
        real y[3], points[CIRCLE][3], left = linear.level;
        solve_linear(&linear, kept, q->k, y);
        for (int j = 0; j < kept; j++) left -= y[j] * y[j];
        const int count = across(list, y, kept, left, list->noise, points);
        for (int i = 0; i < count; i++) add(list, linear.centre, points[i]);
        if (only_first) return;
    }
}

/* Least squares of least norm by one-sided Jacobi (Hestenes 1958): columns of A (n of them, rows numbers each). */
static void least_squares(const real *const *A, int n, int rows, const real *b, real *x)
{
    real U[COLUMNS][RN_FIX_ANCHORS], V[COLUMNS][COLUMNS] = {{R(0.0)}}, size[COLUMNS], largest = R(0.0);
    for (int j = 0; j < n; j++) {
        memcpy(U[j], A[j], (size_t)rows * sizeof(real));
        V[j][j] = R(1.0);
        x[j] = R(0.0);
    }
    for (int sweep = 0, turned = 1; sweep < 20 && turned; sweep++) {
        turned = 0;
        for (int i = 0; i < n; i++) {
            for (int j = i + 1; j < n; j++) {
                real ii = R(0.0), ij = R(0.0), jj = R(0.0);
                for (int l = 0; l < rows; l++) ii += U[i][l] * U[i][l], ij += U[i][l] * U[j][l], jj += U[j][l] * U[j][l];
                if (!(ij * ij > RN_FIX_EPS * RN_FIX_EPS * ii * jj) || !(rn_abs(ij) > RN_FIX_TINY)) continue;
                turned = 1;
                const real theta = (jj - ii) / (R(2.0) * ij);
                const real t = (theta < 0 ? R(-1.0) : R(1.0)) / (rn_abs(theta) + rn_sqrt(theta * theta + R(1.0)));
                const real c = R(1.0) / rn_sqrt(t * t + R(1.0)), s = t * c;
                for (int l = 0; l < rows; l++) {
                    const real one = U[i][l], other = U[j][l];
                    U[i][l] = c * one - s * other;
                    U[j][l] = s * one + c * other;
                }
                for (int l = 0; l < n; l++) {
                    const real one = V[i][l], other = V[j][l];
                    V[i][l] = c * one - s * other;
                    V[j][l] = s * one + c * other;
                }
            }
        }
    }
    for (int j = 0; j < n; j++) {
        size[j] = R(0.0);
        for (int l = 0; l < rows; l++) size[j] += U[j][l] * U[j][l];
        largest = rn_larger(largest, size[j]);
    }
    const real cut = RN_FIX_EPS * (real)(rows > n ? rows : n);
    for (int j = 0; j < n; j++) {
        if (!(size[j] > cut * cut * largest)) continue;
        real share = R(0.0);
        for (int l = 0; l < rows; l++) share += U[j][l] * b[l];
        for (int l = 0; l < n; l++) x[l] += V[j][l] * share / size[j];
    }
}

/* Both real roots of a x^2 + 2 b x + c that are above 0; the vertex when noise made them complex. */
static int quadratic(real a, real b, real c, real *roots)
{
    const real inside = rn_sqrt(rn_larger(b * b - a * c, R(0.0))), q = -(b + (b < 0 ? -inside : inside));
    int count = 0;
    if (a != R(0.0) && q / a > R(0.0)) roots[count++] = q / a;
    if (q != R(0.0) && c / q > R(0.0)) roots[count++] = c / q;
    return count;
}

/* Chan and Ho, IEEE Trans. Signal Processing 42 (1994), section III; roots as Bancroft, IEEE Trans. Aerospace and
 * Electronic Systems 21 (1985). */
static void from_differences(list_t *list)
{
    const RN(fix_problem) *q = list->q;
    const int f = list->f, rows = q->k - 1;
    const real origin[3] = {q->a[0][0], q->a[1][0], q->a[2][0]};
    const real rise = f < q->d ? q->z - origin[2] : R(0.0);
    real A[3][RN_FIX_ANCHORS], delta[RN_FIX_ANCHORS], away[RN_FIX_ANCHORS], right[RN_FIX_ANCHORS];
    real x[COLUMNS], points[CIRCLE][3];
    const real *column[COLUMNS] = {A[0], A[1], A[2], delta};
    for (int i = 0; i < rows; i++) {
        real y[3];
        along(q, origin, i + 1, f, y);
        for (int j = 0; j < f; j++) A[j][i] = y[j];
        const real off[3] = {q->a[0][i + 1] - origin[0], q->a[1][i + 1] - origin[1], q->a[2][i + 1] - origin[2]};
        delta[i] = q->r[i + 1] - q->r[0];
        away[i] = -delta[i];
        right[i] = R(0.5) * (rn_dot3(off, off) - delta[i] * delta[i]) - (f < q->d ? off[2] * rise : R(0.0));
    }
    for (int kept = f; kept > 0; kept--) {
        real left = -rise * rise;
        column[kept] = delta;
        least_squares(column, kept + 1, rows, right, x);
        left += x[kept] * x[kept];
        for (int j = 0; j < kept; j++) left -= x[j] * x[j];
        int count = across(list, x, kept, left, list->noise, points);
        for (int i = 0; i < count; i++) add(list, origin, points[i]);
        /* from far away the differences only tell the direction */
        least_squares(column, kept, rows, away, x);
        left = R(1.0);
        for (int j = 0; j < kept; j++) left -= x[j] * x[j];
        count = across(list, x, kept, left, R(0.01), points);
        for (int i = 0; i < count; i++) {
            const real length = rn_sqrt(rn_dot3(points[i], points[i]));
            for (int j = 0; j < 3; j++) points[i][j] *= FARTHEST * list->scale / rn_larger(length, RN_FIX_TINY);
            add(list, origin, points[i]);
        }
    }
    const real *const all[3] = {A[0], A[1], A[2]};
    real g[COLUMNS] = {R(0.0)}, w[COLUMNS] = {R(0.0)}, roots[2], y[3] = {R(0.0)};
    least_squares(all, f, rows, right, g);
    least_squares(all, f, rows, away, w);
    const int count = quadratic(rn_dot3(w, w) - R(1.0), rn_dot3(g, w), rn_dot3(g, g) + rise * rise, roots);
    for (int i = 0; i < count; i++) {
        for (int j = 0; j < f; j++) y[j] = g[j] + w[j] * roots[i];
        add(list, origin, y);
    }
}

static list_t list_of(const RN(fix_problem) * q, real (*start)[3])
{
    list_t list = {q, free_count(q), 0, RN(fix_scale)(q), R(0.0), start};
    real sum = R(0.0), most = R(0.0);
    for (int i = 0; i < q->k; i++) sum += q->w[i];
    for (int i = 0; i < q->k; i++) most = rn_larger(most, rn_fix_own(q, sum, i));
    list.noise = list.scale / rn_sqrt(most);
    return list;
}

/* The first start alone, for ranges; returns 0 for differences. */
int RN(fix_first)(const RN(fix_problem) * q, real *start)
{
    real room[1][3];
    list_t list = list_of(q, room);
    if (q->differences) return 0;
    from_ranges(&list, 1);
    memcpy(start, room[0], sizeof room[0]);
    return 1;
}

/* All starts; returns how many. */
int RN(fix_starts)(const RN(fix_problem) * q, real (*start)[3])
{
    list_t list = list_of(q, start);
    if (q->differences)
        from_differences(&list);
    else
        from_ranges(&list, 0);
    real y[3] = {R(0.0), R(0.0), R(0.0)};
    for (int j = 0; j < list.f; j++) y[j] = R(0.01) * list.scale;
    add(&list, q->centre, y);
    return list.count;
}
