/* Cost of a position, its derivatives, and damped Gauss-Newton.  The readable form is robustnav.snapshot.core. */
#include "rn_snapshot_core.h"

#define SETTLED R(1e-10) /* squared distance to the minimum in units of the estimate's own covariance */

real RN(fix_scale)(const RN(fix_problem) * q)
{
    real scale = rn_larger(q->reach, R(1e-9));
    for (int i = 0; i < q->k; i++) scale = rn_larger(scale, rn_abs(q->r[i]));
    return scale;
}

static real sum_of(const real *w, int k)
{
    real sum = R(0.0);
    for (int i = 0; i < k; i++) sum += w[i];
    return sum;
}

/* Separate loops over plain arrays, which a compiler may take several anchors at a time. */
void RN(fix_cast)(const RN(fix_problem) * q, const real *p, RN(fix_rays) * rays)
{
    const int k = q->k;
    const real x = p[0], y = p[1], z = p[2];
    for (int i = 0; i < k; i++) {
        const real dx = x - q->a[0][i], dy = y - q->a[1][i], dz = z - q->a[2][i];
        const real d = rn_sqrt(dx * dx + dy * dy + dz * dz), inverse = R(1.0) / (d > RN_FIX_TINY ? d : RN_FIX_TINY);
        rays->d[i] = d;
        rays->u[0][i] = dx * inverse;
        rays->u[1][i] = dy * inverse;
        rays->u[2][i] = dz * inverse;
        rays->e[i] = q->r[i] - d;
    }
    if (!q->differences) return;
    real sum = R(0.0);
    for (int i = 0; i < k; i++) sum += q->w[i] * rays->e[i];
    const real mean = sum / sum_of(q->w, k);
    for (int i = 0; i < k; i++) rays->e[i] -= mean;
}

real RN(fix_cost)(const RN(fix_problem) * q, const real *p)
{
    RN(fix_rays) rays;
    RN(fix_cast)(q, p, &rays);
    const real off = p[2] - q->z;
    real cost = q->z_info * off * off;
    for (int i = 0; i < q->k; i++) cost += q->w[i] * rays.e[i] * rays.e[i];
    return cost;
}

void RN(fix_expand)(const RN(fix_problem) * q, RN(fix_point) * at, RN(fix_rays) * rays)
{
    const int k = q->k;
    RN(fix_cast)(q, at->p, rays);
    const real *u = rays->u[0], *v = rays->u[1], *s = rays->u[2], *e = rays->e;
    real mean[3] = {R(0.0), R(0.0), R(0.0)};
    if (q->differences) {
        const real inverse = R(1.0) / sum_of(q->w, k);
        for (int i = 0; i < k; i++) {
            for (int j = 0; j < 3; j++) mean[j] += q->w[i] * rays->u[j][i] * inverse;
        }
    }
    const real off = at->p[2] - q->z;
    real c = q->z_info * off * off, gx = R(0.0), gy = R(0.0), gz = q->z_info * off;
    real xx = R(0.0), xy = R(0.0), xz = R(0.0), yy = R(0.0), yz = R(0.0), zz = q->z_info;
    for (int i = 0; i < k; i++) {
        const real we = q->w[i] * e[i], ux = u[i] - mean[0], uy = v[i] - mean[1], uz = s[i] - mean[2];
        const real wx = q->w[i] * ux, wy = q->w[i] * uy, wz = q->w[i] * uz;
        c += we * e[i];
        gx -= we * ux;
        gy -= we * uy;
        gz -= we * uz;
        xx += wx * ux;
        xy += wx * uy;
        xz += wx * uz;
        yy += wy * uy;
        yz += wy * uz;
        zz += wz * uz;
    }
    at->cost = c;
    at->g[0] = gx, at->g[1] = gy, at->g[2] = gz;
    at->H[0] = xx, at->H[1] = xy, at->H[2] = xz, at->H[3] = yy, at->H[4] = yz, at->H[5] = zz;
}

/* Solve M x = b for symmetric M (upper part, lost) of size n <= 3 into b; returns whether M is positive definite. */
int RN(fix_factor)(real (*M)[3], real *b, int n)
{
    int positive = 1;
    for (int i = 0; i < n; i++) {
        positive &= M[i][i] > R(0.0);
        const real inverse = R(1.0) / M[i][i];
        for (int j = i + 1; j < n; j++) {
            const real ratio = M[i][j] * inverse;
            for (int l = j; l < n; l++) M[j][l] -= ratio * M[i][l];
            b[j] -= ratio * b[i];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++) b[i] -= M[i][j] * b[j];
        b[i] /= M[i][i];
    }
    return positive;
}

/* The information and the downhill gradient in a basis; in the first d coordinates without one. */
void RN(fix_project)(const real *H, const real *g, const RN(fix_basis) * basis, int d, real (*M)[3], real *b)
{
    if (!basis) {
        M[0][0] = H[0], M[0][1] = H[1], M[0][2] = H[2], M[1][1] = H[3], M[1][2] = H[4], M[2][2] = H[5];
        for (int j = 0; j < d; j++) b[j] = -g[j];
        return;
    }
    for (int i = 0; i < basis->f; i++) {
        const real *v = basis->b[i];
        const real Hv[3] = {H[0] * v[0] + H[1] * v[1] + H[2] * v[2], H[1] * v[0] + H[3] * v[1] + H[4] * v[2],
                            H[2] * v[0] + H[4] * v[1] + H[5] * v[2]};
        b[i] = -rn_dot3(g, v);
        for (int j = i; j < basis->f; j++) M[i][j] = rn_dot3(Hv, basis->b[j]);
    }
}

/* A damped step; returns its squared length in units of the covariance it stands on. */
static real step_from(const RN(fix_point) * at, real damping, const RN(fix_basis) * basis, int d, real *step)
{
    const int n = basis ? basis->f : d;
    real M[3][3], b[3], g[3], trace = R(0.0), decrement = R(0.0);
    RN(fix_project)(at->H, at->g, basis, d, M, b);
    for (int j = 0; j < n; j++) trace += M[j][j];
    for (int j = 0; j < n; j++) {
        M[j][j] += M[j][j] * damping + (RN_FIX_RIDGE * trace + RN_FIX_TINY);
        g[j] = b[j];
    }
    RN(fix_factor)(M, b, n);
    step[0] = step[1] = step[2] = R(0.0);
    for (int j = 0; j < n; j++) {
        decrement += g[j] * b[j];
        if (basis) {
            for (int l = 0; l < 3; l++) step[l] += b[j] * basis->b[j][l];
        } else {
            step[j] = b[j];
        }
    }
    return decrement;
}

/* What is left to gain when rounding of the residuals hides it: by far the larger term in float, the smaller in double. */
static real settled_at(const RN(fix_problem) * q, real cost, real scale)
{
    const real grain = RN_FIX_EPS * scale, sum = sum_of(q->w, q->k);
    return SETTLED + grain * grain * sum + R(0.25) * grain * rn_sqrt(sum * cost);
}

/* Go downhill from end->at.p; a start settles once the next step would be below 1e-5 of the estimate's own sd, or below
 * what the number type resolves. */
void RN(fix_descend)(const RN(fix_problem) * q, const RN(fix_basis) * basis, int max_steps, RN(fix_end) * end)
{
    const real scale = RN(fix_scale)(q);
    RN(fix_point) *at = &end->at, trial;
    RN(fix_rays) rays;
    real damping = R(1e-3), step[3];
    end->settled = end->steps = 0;
    RN(fix_expand)(q, at, &rays);
    while (end->steps < max_steps && !end->settled) {
        const real decrement = step_from(at, damping, basis, q->d, step);
        const real off[3] = {at->p[0] - q->a[0][0], at->p[1] - q->a[1][0], at->p[2] - q->a[2][0]};
        const real length2 = rn_dot3(step, step), limit2 = rn_larger(R(4.0) * scale * scale, rn_dot3(off, off));
        const real share = length2 > limit2 ? rn_sqrt(limit2 / length2) : R(1.0);
        for (int j = 0; j < 3; j++) trial.p[j] = at->p[j] + share * step[j];
        RN(fix_expand)(q, &trial, &rays);
        end->steps++;
        /* no step however small goes down any more: rounding ends the descent as well */
        end->settled = (decrement < settled_at(q, at->cost, scale) && damping <= R(1e-2)) || damping > R(1e12);
        const int better = trial.cost <= at->cost;
        if (better) *at = trial;
        damping = rn_larger(damping * (better ? R(0.1) : R(10.0)), R(1e-9));
    }
}

/* One rotation of Jacobi's method that makes A[i][j] zero. */
static void rotate(real (*A)[3], real (*V)[3], int n, int i, int j)
{
    if (!(rn_abs(A[i][j]) > RN_FIX_TINY)) return;
    const real theta = (A[j][j] - A[i][i]) / (R(2.0) * A[i][j]);
    const real t = (theta < 0 ? R(-1.0) : R(1.0)) / (rn_abs(theta) + rn_sqrt(theta * theta + R(1.0)));
    const real c = R(1.0) / rn_sqrt(t * t + R(1.0)), s = t * c, shift = t * A[i][j];
    A[i][i] -= shift;
    A[j][j] += shift;
    A[i][j] = A[j][i] = R(0.0);
    for (int l = 0; l < n; l++) {
        const real vi = V[i][l], vj = V[j][l];
        V[i][l] = c * vi - s * vj;
        V[j][l] = s * vi + c * vj;
        if (l == i || l == j) continue;
        const real ai = A[i][l], aj = A[j][l];
        A[i][l] = A[l][i] = c * ai - s * aj;
        A[j][l] = A[l][j] = s * ai + c * aj;
    }
}

/* Eigenvalues, ascending, and unit eigenvectors (rows) of a packed matrix's first n coordinates.
 * Golub and Van Loan, Matrix Computations (2013), section 8.5. */
void RN(fix_eigen)(const real *H, int n, real *values, real (*vectors)[3])
{
    real A[3][3] = {{H[0], H[1], H[2]}, {H[1], H[3], H[4]}, {H[2], H[4], H[5]}};
    real V[3][3] = {{R(1.0), R(0.0), R(0.0)}, {R(0.0), R(1.0), R(0.0)}, {R(0.0), R(0.0), R(1.0)}};
    for (int sweep = 0; sweep < 12; sweep++) {
        real off = R(0.0), on = R(0.0);
        for (int i = 0; i < n; i++) {
            on += A[i][i] * A[i][i];
            for (int j = i + 1; j < n; j++) off += A[i][j] * A[i][j];
        }
        if (!(off > R(0.01) * RN_FIX_EPS * RN_FIX_EPS * on)) break;
        for (int i = 0; i < n; i++) {
            for (int j = i + 1; j < n; j++) rotate(A, V, n, i, j);
        }
    }
    int order[3] = {0, 1, 2};
    for (int i = 1; i < n; i++) {
        for (int j = i; j > 0 && A[order[j]][order[j]] < A[order[j - 1]][order[j - 1]]; j--) {
            const int kept = order[j];
            order[j] = order[j - 1];
            order[j - 1] = kept;
        }
    }
    for (int i = 0; i < n; i++) {
        values[i] = A[order[i]][order[i]];
        for (int l = 0; l < 3; l++) vectors[i][l] = V[order[i]][l];
    }
}

/* The inverse from eigenvalues and vectors; NaN and 0 where one direction is so weak that first order means nothing. */
int RN(fix_covariance)(const real *values, const real (*vectors)[3], int n, real *P)
{
    const int good = values[0] > RN_FIX_FLAT * values[n - 1];
    for (int i = 0; i < 6; i++) P[i] = good ? R(0.0) : (real)NAN;
    for (int i = 0; i < n && good; i++) {
        const real *v = vectors[i], inverse = R(1.0) / values[i];
        P[0] += v[0] * v[0] * inverse;
        P[1] += v[0] * v[1] * inverse;
        P[2] += v[0] * v[2] * inverse;
        P[3] += v[1] * v[1] * inverse;
        P[4] += v[1] * v[2] * inverse;
        P[5] += v[2] * v[2] * inverse;
    }
    return good;
}
