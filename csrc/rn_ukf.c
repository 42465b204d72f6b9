/* Unscented steps on the error state: points are x [+] e in pairs +-e, so quaternions stay unit and means need no
 * iteration.
 *
 * The offsets e are a triangle: pair i leaves the errors before i alone.  So a sensor's points end with the last error that it
 * sees, the others predict what the centre does; and errors that a step leaves alone keep their covariance.  A pair counts
 * as half the difference of what its points became (odd) and half the sum (even): 1 / spread is the weight of either. */
#include "rn_filter.h"

#include <string.h>

enum { BLOCK = 4 }; /* sums made side by side, from numbers side by side: reading goes up to BLOCK - 1 past a row */

int RN(ukf_scratch)(const RN(model) * m)
{
    const int n = m->ne, predict = RN_PACKED(n) + 4 * n * n, update = n * n + 5 * n * RN_MAX_ROWS;
    return (predict > update ? predict : update) + BLOCK;
}

/* sum[b] = sum over k < count of weight[k step] v[k n + b]. */
RN_INLINE void combine(const real *weight, int step, const real *v, int n, int count, real *sum)
{
    real s0 = R(0.0), s1 = R(0.0), s2 = R(0.0), s3 = R(0.0);
    for (int k = 0; k < count; k++) {
        const real one = *weight;
        s0 += one * v[0];
        s1 += one * v[1];
        s2 += one * v[2];
        s3 += one * v[3];
        weight += step;
        v += n;
    }
    sum[0] = s0;
    sum[1] = s1;
    sum[2] = s2;
    sum[3] = s3;
}

/* The first `pairs` rows of sqrt(spread) U, where P = U'U and U is upper, by full rows of n.  Returns 1 if P is not positive
 * definite as far as these rows tell.  Divides before it takes roots, which then do not wait for each other. */
static int offsets_of(const real *P, real spread, int pairs, int n, real *offsets)
{
    real inverse[RN_MAX_STATE], share[RN_MAX_STATE], sum[BLOCK];
    for (int i = 0; i < pairs; i++) {
        real *row = offsets + i * n;
        for (int k = 0; k < i; k++) share[k] = offsets[k * n + i] * inverse[k];
        for (int j = i; j < n; j += BLOCK) {
            combine(share, 1, offsets + j, n, i, sum);
            for (int b = 0; b < BLOCK && j + b < n; b++) row[j + b] = *P++ - sum[b];
        }
        inverse[i] = R(1.0) / row[i];
        if (!(inverse[i] > R(0.0) && inverse[i] < (real)INFINITY)) return 1;
    }
    for (int i = 0; i < pairs; i++) {
        real *row = offsets + i * n;
        const real scale = rn_sqrt(spread * inverse[i]);
        for (int j = 0; j < i; j++) row[j] = R(0.0);
        for (int j = i; j < n; j++) row[j] *= scale;
    }
    return 0;
}

/* The first `rows` rows of packed P += scale V'V, of their columns those before `to`; V: count rows of n numbers. */
static void add_products(real *P, int n, int rows, int to, real scale, const real *v, int count)
{
    real sum[BLOCK];
    for (int i = 0; i < rows; i++) {
        for (int j = i; j < to; j += BLOCK) {
            combine(v + i, n, v + j, n, count, sum);
            for (int b = 0; b < BLOCK && j + b < to; b++) P[j + b - i] += scale * sum[b];
        }
        P += n - i;
    }
}

/* From `rows` rows of pairs, n of + and then n of -: halves of differences (odd) and, less their mean, of sums (even), by
 * columns, `width` numbers from one pair to the next. */
static void split(const real *e, int rows, int n, real pair, real *odd, real *even, int width, real *mean)
{
    for (int j = 0; j < rows; j++, e += 2 * n) {
        real sum = R(0.0);
        for (int i = 0; i < n; i++) sum += e[i] + e[n + i];
        mean[j] = R(0.5) * pair * sum;
        for (int i = 0; i < n; i++) {
            odd[i * width + j] = R(0.5) * (e[i] - e[n + i]);
            even[i * width + j] = R(0.5) * (e[i] + e[n + i]) - mean[j];
        }
    }
}

int RN(ukf_predict)(const RN(model) * m, const RN(unscented) * w, real *x, real *P, const real *u, const real *q,
                    const real *p, real dt, real *scratch)
{
    const int n = m->ne, nx = m->nx, moving = m->moving, moved = RN_PACKED(n) - RN_PACKED(n - moving);
    const real pair = R(1.0) / w->spread;
    real *Q = scratch, *e = Q + RN_PACKED(n), *even = e + 2 * n * n, *offsets = even + n * n;
    real centre[RN_MAX_STATE + 1], mean[RN_MAX_STATE + BLOCK] = {R(0.0)};
    if (offsets_of(P, w->spread, n, n, offsets)) return 1;
    for (int j = 0; j < n; j++) {
        for (int i = 0; i < n; i++) {
            e[j * 2 * n + i] = offsets[i * n + j];
            e[j * 2 * n + n + i] = -offsets[i * n + j];
        }
    }
    m->noise(x, u, q, p, dt, Q);
    memcpy(centre, x, (size_t)nx * sizeof(real));
    m->propagate(centre, u, p, dt);
    m->carry(x, centre, u, p, dt, e);
    split(e, moving, n, pair, offsets, even, n, mean); /* of what stays, the odd part is the offset */
    memcpy(P, Q, (size_t)moved * sizeof(real));
    for (int k = moved; k < RN_PACKED(n); k++) P[k] += Q[k];
    add_products(P, n, moving, n, pair, offsets, n);
    add_products(P, n, moving, moving, pair, even, n);
    add_products(P, n, moving, moving, w->cov_centre, mean, 1);
    memcpy(x, centre, (size_t)nx * sizeof(real));
    m->inject(x, mean);
    return 0;
}

/* r = z - h(x [+] side e), for what a sensor sees of x */
static void innovation(const RN(model) * m, const RN(sensor) * one, const real *x, const real *offset, real side,
                       const real *z, const real *p, real *r)
{
    real e[RN_MAX_STATE], point[RN_MAX_STATE + 1];
    for (int j = 0; j < m->ne; j++) e[j] = side * offset[j];
    memcpy(point, x, (size_t)m->nx * sizeof(real));
    m->inject(point, e);
    one->innovation(point, z, p, r);
}

/* What the points say of a reading: nu, S (rows x rows, upper used) added to, and C = cov(h, e), rows x n.
 *
 * All in the sensor's own axes, as distances below the centre's prediction: angles do not wrap there, and what the sensor
 * happened to read says nothing of how the prediction varies. */
static void spread_of_prediction(const RN(model) * m, const RN(unscented) * w, int sensor, const real *x, const real *z,
                                 const real *p, const real *offsets, real *below, real *nu, real *S, real *C)
{
    const RN(sensor) *one = &m->sensors[sensor];
    const int n = m->ne, pairs = one->sees, rows = one->size;
    const real pair = R(1.0) / w->spread;
    real centre[RN_MAX_READING], r[RN_MAX_ROWS], mean[RN_MAX_ROWS];
    one->measure(x, z, p, centre);
    for (int a = rows; a < one->width; a++) centre[a] = z[a];
    for (int i = 0; i < 2 * pairs; i++) {
        innovation(m, one, x, offsets + i % pairs * n, i < pairs ? R(1.0) : R(-1.0), centre, p, r);
        for (int a = 0; a < rows; a++) below[a * 2 * pairs + i] = r[a];
    }
    real *odd = below + 2 * pairs * rows, *even = odd + pairs * rows;
    split(below, rows, pairs, pair, odd, even, rows, mean);
    one->innovation(x, z, p, nu);
    /* the pairs left out predict what the centre does */
    const real centre_weight = w->cov_centre + pair * (real)(n - pairs);
    for (int a = 0; a < rows; a++) {
        nu[a] += mean[a];
        for (int b = a; b < rows; b++) {
            real sum = R(0.0);
            for (int i = 0; i < pairs * rows; i += rows) sum += odd[i + a] * odd[i + b] + even[i + a] * even[i + b];
            S[a * RN_MAX_ROWS + b] += pair * sum + centre_weight * mean[a] * mean[b];
        }
        for (int j = 0; j < n; j += BLOCK) {
            real sum[BLOCK];
            combine(odd + a, rows, offsets + j, n, pairs, sum);
            for (int b = 0; b < BLOCK && j + b < n; b++) C[a * n + j + b] = -pair * sum[b];
        }
    }
}

/* S = L L' in place (lower), then C <- L^-1 C and y = L^-1 nu; returns 1 if S is not positive definite. */
static int whiten(real *S, real *C, const real *nu, real *y, int rows, int n)
{
    for (int a = 0; a < rows; a++) {
        real *low = S + a * RN_MAX_ROWS, *own = C + a * n, pivot = low[a];
        y[a] = nu[a];
        for (int b = 0; b < a; b++) {
            const real *other = S + b * RN_MAX_ROWS;
            real sum = other[a];
            for (int k = 0; k < b; k++) sum -= low[k] * other[k];
            low[b] = sum * other[b];
            pivot -= low[b] * low[b];
            y[a] -= low[b] * y[b];
            for (int j = 0; j < n; j++) own[j] -= low[b] * C[b * n + j];
        }
        if (!(pivot > R(0.0))) return 1;
        low[a] = R(1.0) / rn_sqrt(pivot); /* the diagonal is kept inverted */
        y[a] *= low[a];
        for (int j = 0; j < n; j++) own[j] *= low[a];
    }
    return 0;
}

void RN(ukf_update)(const RN(model) * m, const RN(unscented) * w, int sensor, real *x, real *P, const real *z,
                    real variance, RN(rule) rule, const real *p, RN(seen) * seen, real *scratch)
{
    const int n = m->ne, pairs = m->sensors[sensor].sees, rows = m->sensors[sensor].size;
    real *offsets = scratch, *below = offsets + pairs * n, *C = below + 4 * pairs * rows;
    real S[RN_MAX_ROWS * RN_MAX_ROWS] = {R(0.0)}, y[RN_MAX_ROWS], dx[RN_MAX_STATE];
    seen->weight = R(0.0);
    seen->nis = (real)NAN;
    for (int a = 0; a < rows; a++) seen->nu[a] = seen->s[a] = (real)NAN;
    if (offsets_of(P, w->spread, pairs, n, offsets)) return;
    for (int a = 0; a < rows; a++) S[a * RN_MAX_ROWS + a] = variance;
    spread_of_prediction(m, w, sensor, x, z, p, offsets, below, seen->nu, S, C);
    for (int a = 0; a < rows; a++) seen->s[a] = S[a * RN_MAX_ROWS + a];
    if (whiten(S, C, seen->nu, y, rows, n)) return;
    seen->nis = R(0.0);
    for (int a = 0; a < rows; a++) seen->nis += y[a] * y[a];
    const real weight = rn_weight(rule, seen->nis, (real)rows);
    if (!(weight > R(0.0))) return;
    seen->weight = weight;
    for (int j = 0; j < n; j++) dx[j] = R(0.0);
    for (int a = 0; a < rows; a++) {
        for (int j = 0; j < n; j++) dx[j] += weight * y[a] * C[a * n + j];
    }
    add_products(P, n, n, n, -weight, C, rows);
    m->inject(x, dx);
}
