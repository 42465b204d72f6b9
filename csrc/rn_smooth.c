/* The Rauch-Tung-Striebel step on the error state; robustnav/filter/smoother.py is the same in NumPy. */
#include "rn_smooth.h"

#include <float.h>
#include <string.h>

#ifdef RN_FLOAT
#define ROUNDING FLT_EPSILON
#else
#define ROUNDING DBL_EPSILON
#endif

int RN(smooth_scratch)(const RN(model) * m) { return 8 * m->ne * m->ne; }

static void unpack_whole(const real *packed, real *M, int n)
{
    for (int i = 0; i < n; i++) {
        for (int j = i; j < n; j++) M[i * n + j] = M[j * n + i] = *packed++;
    }
}

/* out += A B, or A' B, n x n by rows.  A transition is mostly zeros, and they are skipped. */
static void add_product(real *out, const real *A, const real *B, int n, int transposed)
{
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < n; k++) {
            const real a = transposed ? A[k * n + i] : A[i * n + k];
            if (a == R(0.0)) continue;
            for (int j = 0; j < n; j++) out[i * n + j] += a * B[k * n + j];
        }
    }
}

/* P += A' B, the packed upper triangle alone. */
static void add_symmetric(real *P, const real *A, const real *B, int n)
{
    for (int i = 0; i < n; i++, P += n - i + 1) {
        for (int k = 0; k < n; k++) {
            const real a = A[k * n + i];
            for (int j = i; j < n; j++) P[j - i] += a * B[k * n + j];
        }
    }
}

/* M = U'U in place (upper), B <- M^-1 B.  A direction without variance, beyond rounding, is known: it takes no part. */
static void solve_semidefinite(real *M, real *B, real *inverse, int n)
{
    const real least = R(8.0) * (real)n * ROUNDING;
    for (int i = 0; i < n; i++) inverse[i] = least * M[i * n + i];
    for (int i = 0; i < n; i++) {
        real *row = M + i * n;
        const real pivot = row[i] > inverse[i] ? rn_sqrt(row[i]) : R(0.0);
        inverse[i] = pivot > R(0.0) ? R(1.0) / pivot : R(0.0);
        for (int j = i; j < n; j++) row[j] *= inverse[i];
        for (int k = i + 1; k < n; k++) {
            for (int j = k; j < n; j++) M[k * n + j] -= row[k] * row[j];
        }
        for (int k = 0; k < i; k++) {
            const real u = M[k * n + i];
            for (int j = 0; j < n; j++) B[i * n + j] -= u * B[k * n + j];
        }
        for (int j = 0; j < n; j++) B[i * n + j] *= inverse[i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++) {
            const real u = M[i * n + k];
            for (int j = 0; j < n; j++) B[i * n + j] -= u * B[k * n + j];
        }
        for (int j = 0; j < n; j++) B[i * n + j] *= inverse[i];
    }
}

void RN(smooth_step)(const RN(model) * m, real *x, real *P, const real *next, const real *P_next, const real *u,
                     const real *q, const real *p, real dt, real *scratch)
{
    const int n = m->ne, square = n * n;
    const size_t bytes = (size_t)square * sizeof(real);
    real *F = scratch, *Q = F + square, *whole = Q + square, *G = whole + square, *M = G + square, *left = M + square,
         *work = left + square, *after = work + square;
    real pred[RN_MAX_STATE + 1], e[RN_MAX_STATE], dx[RN_MAX_STATE];
    m->transition(x, u, q, p, dt, F, Q);
    unpack_whole(P, whole, n);
    unpack_whole(P_next, after, n);

    memset(G, 0, bytes); /* G' = P_pred^-1 F P */
    add_product(G, F, whole, n, 0);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) work[i * n + j] = G[j * n + i];
    }
    memcpy(M, Q, bytes);
    add_product(M, F, work, n, 0);
    solve_semidefinite(M, G, work, n);

    memcpy(pred, x, (size_t)m->nx * sizeof(real));
    m->propagate(pred, u, p, dt);
    m->difference(next, pred, e);
    for (int i = 0; i < n; i++) {
        dx[i] = R(0.0);
        for (int k = 0; k < n; k++) dx[i] += G[k * n + i] * e[k];
    }
    m->inject(x, dx);

    /* P_s = (I - G F) P (I - G F)' + G (Q + P_next) G': no difference of covariances, so it stays one */
    memset(work, 0, bytes);
    add_product(work, F, G, n, 1);
    for (int i = 0; i < square; i++) {
        left[i] = (i % (n + 1) == 0 ? R(1.0) : R(0.0)) - work[i];
        after[i] += Q[i];
    }
    memset(P, 0, (size_t)RN_PACKED(n) * sizeof(real));
    memset(work, 0, bytes);
    add_product(work, whole, left, n, 0);
    add_symmetric(P, left, work, n);
    memset(work, 0, bytes);
    add_product(work, after, G, n, 0);
    add_symmetric(P, G, work, n);
}
