/* Unscented steps on the error state: points are x [+] e, so quaternions stay unit and means need no iteration. */
#include "rn_filter.h"

#include <string.h>

static int points_of(const RN(model) * m) { return 2 * m->ne + 1; }

int RN(ukf_scratch)(const RN(model) * m)
{
    const int n = m->ne, points = points_of(m);
    return points * (m->nx + n + RN_MAX_ROWS) + RN_PACKED(n) + 2 * n * n + n * RN_MAX_ROWS;
}

/* P = U'U, U upper by packed rows; returns 1 if P is not positive definite. */
static int factor(const real *P, real *U, int n)
{
    memcpy(U, P, (size_t)RN_PACKED(n) * sizeof(real));
    real *row = U;
    for (int i = 0; i < n; i++) {
        if (!(row[0] > R(0.0))) return 1;
        const real pivot = rn_sqrt(row[0]), inverse = R(1.0) / pivot;
        row[0] = pivot;
        for (int j = 1; j < n - i; j++) row[j] *= inverse;
        real *below = row + (n - i);
        for (int j = 1; j < n - i; j++) {
            for (int k = j; k < n - i; k++) *below++ -= row[j] * row[k];
        }
        row += n - i;
    }
    return 0;
}

/* Fill the points x [+] +-sqrt(spread) U_i, the centre first. */
static int place(const RN(model) * m, real spread, const real *x, const real *P, real *points, real *U)
{
    const int n = m->ne, nx = m->nx;
    if (factor(P, U, n)) return 1;
    const real reach = rn_sqrt(spread);
    real e[RN_MAX_STATE];
    const real *row = U;
    memcpy(points, x, (size_t)nx * sizeof(real));
    for (int i = 0; i < n; i++) {
        for (int side = 0; side < 2; side++) {
            real *point = points + (1 + 2 * i + side) * nx;
            for (int j = 0; j < n; j++) e[j] = j < i ? R(0.0) : (side ? -reach : reach) * row[j - i];
            memcpy(point, x, (size_t)nx * sizeof(real));
            m->inject(point, e);
        }
        row += n - i;
    }
    return 0;
}

int RN(ukf_predict)(const RN(model) * m, const RN(unscented) * w, real *x, real *P, const real *u, const real *q,
                    const real *p, real dt, real *scratch)
{
    const int n = m->ne, nx = m->nx, count = points_of(m);
    real *points = scratch, *errors = points + count * nx, *U = errors + count * n, *F = U + RN_PACKED(n),
         *Q = F + n * n;
    if (place(m, w->spread, x, P, points, U)) return 1;
    m->transition(x, u, q, p, dt, F, Q);
    const real weight = R(0.5) / w->spread;
    real mean[RN_MAX_STATE];
    for (int i = 0; i < n; i++) mean[i] = R(0.0);
    for (int k = 0; k < count; k++) {
        real *e = errors + k * n;
        m->propagate(points + k * nx, u, p, dt);
        m->difference(points + k * nx, points, e);
        for (int i = 0; i < n; i++) mean[i] += (k ? weight : w->mean_centre) * e[i];
    }
    for (int i = 0, k = 0; i < n; i++) {
        for (int j = i; j < n; j++) P[k++] = Q[i * n + j];
    }
    for (int k = 0; k < count; k++) {
        const real *e = errors + k * n;
        const real scale = k ? weight : w->cov_centre;
        for (int i = 0, at = 0; i < n; i++) {
            const real d = scale * (e[i] - mean[i]);
            for (int j = i; j < n; j++) P[at++] += d * (e[j] - mean[j]);
        }
    }
    memcpy(x, points, (size_t)nx * sizeof(real));
    m->inject(x, mean);
    return 0;
}

/* Means and spreads of the prediction over the points: nu, S (rows x rows, upper used) and C = cov(e, h).
 *
 * All in the sensor's own axes, as distances below the centre's prediction: angles do not wrap there, and what the sensor
 * happened to read says nothing of how the prediction varies. */
static void spread_of_prediction(const RN(model) * m, const RN(unscented) * w, int sensor, const real *z, const real *p,
                                 const real *points, const real *U, real *below, real *nu, real *S, real *C)
{
    const RN(sensor) *one = &m->sensors[sensor];
    const int n = m->ne, nx = m->nx, count = points_of(m), rows = one->size;
    const real weight = R(0.5) / w->spread, reach = rn_sqrt(w->spread);
    real centre[RN_MAX_READING], mean[RN_MAX_ROWS];
    one->measure(points, z, p, centre);
    for (int a = rows; a < one->width; a++) centre[a] = z[a];
    for (int a = 0; a < rows; a++) mean[a] = R(0.0);
    for (int k = 0; k < count; k++) {
        real *r = below + k * RN_MAX_ROWS;
        one->innovation(points + k * nx, centre, p, r);
        for (int a = 0; a < rows; a++) mean[a] += (k ? weight : w->mean_centre) * r[a];
    }
    for (int k = 0; k < count; k++) {
        const real *r = below + k * RN_MAX_ROWS;
        const real scale = k ? weight : w->cov_centre;
        for (int a = 0; a < rows; a++) {
            for (int b = a; b < rows; b++) S[a * RN_MAX_ROWS + b] += scale * (r[a] - mean[a]) * (r[b] - mean[b]);
        }
    }
    one->innovation(points, z, p, nu);
    for (int a = 0; a < rows; a++) nu[a] += mean[a];
    /* e of point i is +-reach U_i */
    for (int j = 0; j < n * rows; j++) C[j] = R(0.0);
    const real *row = U;
    for (int i = 0; i < n; i++) {
        const real *plus = below + (1 + 2 * i) * RN_MAX_ROWS, *minus = plus + RN_MAX_ROWS;
        for (int j = i; j < n; j++) {
            for (int a = 0; a < rows; a++) C[j * rows + a] -= weight * reach * row[j - i] * (plus[a] - minus[a]);
        }
        row += n - i;
    }
}

/* S = L L' in place (lower), then C <- C L^-T and y = L^-1 nu; returns 1 if S is not positive definite. */
static int whiten(real *S, real *C, const real *nu, real *y, int rows, int n)
{
    for (int a = 0; a < rows; a++) {
        for (int b = 0; b <= a; b++) {
            real sum = S[b * RN_MAX_ROWS + a];
            for (int k = 0; k < b; k++) sum -= S[a * RN_MAX_ROWS + k] * S[b * RN_MAX_ROWS + k];
            if (a == b) {
                if (!(sum > R(0.0))) return 1;
                S[a * RN_MAX_ROWS + a] = rn_sqrt(sum);
            } else {
                S[a * RN_MAX_ROWS + b] = sum / S[b * RN_MAX_ROWS + b];
            }
        }
    }
    for (int a = 0; a < rows; a++) {
        real sum = nu[a];
        for (int k = 0; k < a; k++) sum -= S[a * RN_MAX_ROWS + k] * y[k];
        y[a] = sum / S[a * RN_MAX_ROWS + a];
        for (int j = 0; j < n; j++) {
            real c = C[j * rows + a];
            for (int k = 0; k < a; k++) c -= S[a * RN_MAX_ROWS + k] * C[j * rows + k];
            C[j * rows + a] = c / S[a * RN_MAX_ROWS + a];
        }
    }
    return 0;
}

void RN(ukf_update)(const RN(model) * m, const RN(unscented) * w, int sensor, real *x, real *P, const real *z,
                    real variance, RN(rule) rule, const real *p, RN(seen) * seen, real *scratch)
{
    const int n = m->ne, count = points_of(m), rows = m->sensors[sensor].size;
    real *points = scratch, *below = points + count * m->nx, *U = below + count * RN_MAX_ROWS,
         *C = U + RN_PACKED(n);
    real S[RN_MAX_ROWS * RN_MAX_ROWS] = {R(0.0)}, y[RN_MAX_ROWS], dx[RN_MAX_STATE];
    seen->weight = R(0.0);
    seen->nis = (real)NAN;
    for (int a = 0; a < rows; a++) seen->nu[a] = seen->s[a] = (real)NAN;
    if (place(m, w->spread, x, P, points, U)) return;
    for (int a = 0; a < rows; a++) S[a * RN_MAX_ROWS + a] = variance;
    spread_of_prediction(m, w, sensor, z, p, points, U, below, seen->nu, S, C);
    for (int a = 0; a < rows; a++) seen->s[a] = S[a * RN_MAX_ROWS + a];
    if (whiten(S, C, seen->nu, y, rows, n)) return;
    seen->nis = R(0.0);
    for (int a = 0; a < rows; a++) seen->nis += y[a] * y[a];
    const real weight = rn_weight(rule, seen->nis, (real)rows);
    if (!(weight > R(0.0))) return;
    seen->weight = weight;
    for (int i = 0, k = 0; i < n; i++) {
        dx[i] = R(0.0);
        for (int a = 0; a < rows; a++) dx[i] += weight * C[i * rows + a] * y[a];
        for (int j = i; j < n; j++, k++) {
            for (int a = 0; a < rows; a++) P[k] -= weight * C[i * rows + a] * C[j * rows + a];
        }
    }
    m->inject(x, dx);
}
