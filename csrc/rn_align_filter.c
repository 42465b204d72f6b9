/* One filter of the alignment: attitude on SO(3) with covariance transport, and one wind model. */
#include "rn_align.h"
#include "rn_align_turn.h"

#include <string.h>

static const real LEVEL_SD = R(0.15);         /* rad, of the coarse start */
static const real VELOCITY_SD = R(3.0);       /* m/s, base and mean wind */
static const real RATE_SD = R(2e-4);          /* rad/s, well above the Earth's: flat on its circle */
static const real AMPLITUDE_SD = R(0.35);          /* m/s, amplitude of a line */
static const real AMPLITUDE_WALK = R(3e-4);        /* m/s/sqrt(s) */
static const real OMEGA_WALK = R(1e-4);       /* rad/s/sqrt(s) */

static void mirror(real *P, int n, int rows)
{
    for (int i = 0; i < rows; i++) {
        for (int j = i + 1; j < n; j++) P[j * n + i] = P[i * n + j];
    }
}

/* P <- G P G' with a G that acts on the three states from `at` on. */
static void carry(RN(align_filter) * f, int at, const real *G)
{
    const int n = f->n;
    real *P = f->P;
    for (int j = 0; j < n; j++) {
        const real column[3] = {P[at * n + j], P[(at + 1) * n + j], P[(at + 2) * n + j]};
        for (int i = 0; i < 3; i++) P[(at + i) * n + j] = G[3 * i] * column[0] + G[3 * i + 1] * column[1] + G[3 * i + 2] * column[2];
    }
    for (int i = 0; i < 3; i++) {
        const real *from = P + (at + i) * n + at, row[3] = {from[0], from[1], from[2]};
        times_vector(G, row, P + (at + i) * n + at);
    }
    for (int i = at; i < at + 3; i++) {
        for (int j = 0; j < n; j++) {
            if (j < at || j > i) P[j * n + i] = P[i * n + j];
        }
    }
}

static void start_wind(RN(align_filter) * f, const RN(align_setup) * s, const RN(align_wind) * w)
{
    f->wind = *w;
    f->common = s->compass_bias_sd > R(0.0) ? RN_ALIGN_COMMON : RN_ALIGN_CORE;
    f->n = f->common + 5 * w->lines + 2;
    memset(f->P, 0, sizeof f->P);
    memset(f->d, 0, sizeof f->d);
    for (int l = 0; l < w->lines; l++) {
        const int at = f->common + 5 * l;
        for (int j = at; j < at + 4; j++) f->P[j * f->n + j] = AMPLITUDE_SD * AMPLITUDE_SD;
        f->P[(at + 4) * f->n + at + 4] = w->omega_sd[l] * w->omega_sd[l];
        f->d[5 * l + 4] = w->omega[l];
    }
    for (int j = f->n - 2; j < f->n; j++) f->P[j * f->n + j] = w->markov_sd * w->markov_sd;
    memset(f->off, 0, sizeof f->off);
    f->log_likelihood = R(0.0);
    f->misfit = R(2.0);
}

void RN(align_filter_start)(RN(align_filter) * f, const RN(align_setup) * s, const RN(align_wind) * w, const RN(align_core) * at)
{
    start_wind(f, s, w);
    f->core = *at;
    f->anchored = 0;
    /* The azimuth of the wander frame is a choice: at the start it has no error. */
    const real sd[RN_ALIGN_COMMON] = {LEVEL_SD,        LEVEL_SD,         R(0.0),           VELOCITY_SD,      VELOCITY_SD,
                           s->gyro_bias_sd, s->gyro_bias_sd,  s->gyro_bias_sd,  s->accel_bias_sd, s->accel_bias_sd,
                           s->accel_bias_sd, RATE_SD,         RATE_SD,          s->compass_bias_sd};
    for (int i = 0; i < f->common; i++) f->P[i * f->n + i] = sd[i] * sd[i];
}

void RN(align_filter_graft)(RN(align_filter) * f, const RN(align_setup) * s, const RN(align_wind) * w, const RN(align_snapshot) * from)
{
    start_wind(f, s, w);
    const int common = f->common;
    f->core = from->core;
    f->anchored = from->anchored;
    memcpy(f->off, from->off, sizeof f->off);
    for (int i = 0; i < common; i++) memcpy(f->P + i * f->n, from->P + i * common, (size_t)common * sizeof(real));
    for (int i = RN_ALIGN_VELOCITY; i < RN_ALIGN_GYRO; i++) f->P[i * f->n + i] += VELOCITY_SD * VELOCITY_SD; /* another mean wind */
}

/* P <- F P F' and d <- F d for the lines and the Markov part. */
static void predict_wind(RN(align_filter) * f, real period)
{
    const int n = f->n, common = f->common;
    real *P = f->P;
    for (int l = 0; l < f->wind.lines; l++) {
        const real omega = f->d[5 * l + 4], c = rn_cos(omega * period), s = rn_sin(omega * period);
        for (int axis = 0; axis < 2; axis++) {
            real *d = f->d + 5 * l + 2 * axis;
            const real d0 = c * d[0] + s * d[1], d1 = c * d[1] - s * d[0];
            const int k = common + 5 * l + 2 * axis, o = common + 5 * l + 4;
            d[0] = d0;
            d[1] = d1;
            for (int j = 0; j < n; j++) {
                const real a = P[k * n + j], b = P[(k + 1) * n + j], e = period * P[o * n + j];
                P[k * n + j] = c * a + s * b + d1 * e;
                P[(k + 1) * n + j] = c * b - s * a - d0 * e;
            }
            for (int j = 0; j < n; j++) {
                real *row = P + j * n;
                const real a = row[k], b = row[k + 1], e = period * row[o];
                row[k] = c * a + s * b + d1 * e;
                row[k + 1] = c * b - s * a - d0 * e;
            }
            for (int j = k; j < k + 2; j++) P[j * n + j] += AMPLITUDE_WALK * AMPLITUDE_WALK * period;
        }
        P[(common + 5 * l + 4) * (n + 1)] += OMEGA_WALK * OMEGA_WALK * period;
    }
    const real decay = rn_exp(-period / f->wind.markov_time), sd = f->wind.markov_sd;
    for (int k = n - 2; k < n; k++) {
        f->d[k - common] *= decay;
        for (int j = 0; j < n; j++) P[k * n + j] *= decay;
        for (int j = 0; j < n; j++) P[j * n + k] *= decay;
        P[k * n + k] += sd * sd * (R(1.0) - decay * decay);
    }
}

/* The five rows of F that are not of the identity, and the state moved along. */
static void transition(RN(align_filter) * f, const RN(align_setup) * s, const real *reading, real F[5][RN_ALIGN_CORE])
{
    RN(align_core) *x = &f->core;
    const real *DQ = reading, *J = reading + 7, *H = reading + 16, T = s->period;
    real C[9], CJ[9], CH[9], A[9], E[9], alpha[3], a[3], t[3], u[3], e[4];
    matrix(x->q, C);
    times_matrix(C, J, CJ);
    times_matrix(C, H, CH);
    times_vector(J, x->accel_bias, t);
    times_vector(H, x->gyro_bias, u);
    for (int i = 0; i < 3; i++) alpha[i] = reading[4 + i] - t[i] - u[i];
    times_vector(C, alpha, a);
    skew(a, A);
    /* Of gravity alone: less the bias found so far, it would let the filter claim to tell tilt and bias apart. */
    const real fall = s->gravity * T;
    const real w[3] = {x->rate[0], x->rate[1], -RN_ALIGN_EARTH_RATE * rn_sin(s->latitude)};
    const real turn[3] = {-w[0] * T, -w[1] * T, -w[2] * T};
    exponential(turn, e);
    matrix(e, E);
    x->v[0] += a[0] - R(0.5) * T * (w[1] * a[2] - w[2] * a[1]);
    x->v[1] += a[1] - R(0.5) * T * (w[2] * a[0] - w[0] * a[2]);
    times_vector(J, x->gyro_bias, t);
    for (int i = 0; i < 3; i++) t[i] = -t[i];
    product(e, x->q, x->q);
    exponential(t, e);
    product(x->q, e, x->q);
    product(x->q, DQ, x->q);
    memset(F, 0, 5 * RN_ALIGN_CORE * sizeof(real));
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            F[i][RN_ALIGN_TURN + k] = E[3 * i + k];
            F[i][RN_ALIGN_GYRO + k] = -CJ[3 * i + k];
        }
    }
    for (int i = 0; i < 2; i++) {
        F[i][RN_ALIGN_RATE + i] = -T;
        F[RN_ALIGN_VELOCITY + i][RN_ALIGN_VELOCITY + i] = R(1.0);
        F[RN_ALIGN_VELOCITY + i][RN_ALIGN_TURN + 1 - i] = i == 0 ? -fall : fall;
        for (int k = 0; k < 3; k++) {
            F[RN_ALIGN_VELOCITY + i][RN_ALIGN_GYRO + k] = -CH[3 * i + k];
            F[RN_ALIGN_VELOCITY + i][RN_ALIGN_ACCEL + k] = -CJ[3 * i + k];
        }
        for (int k = 0; k < 2; k++) F[RN_ALIGN_VELOCITY + i][RN_ALIGN_RATE + k] = R(0.5) * T * A[3 * i + k];
    }
}

void RN(align_filter_motion)(RN(align_filter) * f, const RN(align_setup) * s, const real *reading)
{
    real F[5][RN_ALIGN_CORE];
    transition(f, s, reading, F);
}

void RN(align_filter_predict)(RN(align_filter) * f, const RN(align_setup) * s, const real *reading)
{
    const int n = f->n;
    real F[5][RN_ALIGN_CORE], top[5][RN_ALIGN_STATES], *P = f->P;
    predict_wind(f, s->period);
    transition(f, s, reading, F);
    if (f->anchored) {
        real off[5] = {R(0.0)};
        for (int i = 0; i < 5; i++) {
            for (int k = 0; k < RN_ALIGN_CORE; k++) off[i] += F[i][k] * f->off[k];
        }
        memcpy(f->off, off, sizeof off);
    }
    for (int i = 0; i < 5; i++) {
        for (int j = 0; j < n; j++) top[i][j] = R(0.0);
        for (int k = 0; k < RN_ALIGN_CORE; k++) {
            const real g = F[i][k], *row = P + k * n;
            if (g == R(0.0)) continue;
            for (int j = 0; j < n; j++) top[i][j] += g * row[j];
        }
    }
    for (int i = 0; i < 5; i++) {
        for (int j = i; j < 5; j++) {
            real sum = R(0.0);
            for (int k = 0; k < RN_ALIGN_CORE; k++) sum += top[i][k] * F[j][k];
            P[i * n + j] = sum;
        }
        for (int j = 5; j < n; j++) P[i * n + j] = top[i][j];
    }
    mirror(P, n, 5);
    const real density[4] = {s->gyro_density, s->accel_density, s->gyro_bias_walk, s->accel_bias_walk};
    const int first[5] = {RN_ALIGN_TURN, RN_ALIGN_VELOCITY, RN_ALIGN_GYRO, RN_ALIGN_ACCEL, RN_ALIGN_RATE};
    for (int block = 0; block < 4; block++) {
        for (int i = first[block]; i < first[block + 1]; i++) P[i * (n + 1)] += density[block] * density[block] * s->period;
    }
}

static void move(RN(align_core) * x, const real *dx, int common)
{
    real e[4];
    exponential(dx, e);
    product(e, x->q, x->q);
    for (int i = 0; i < 2; i++) x->v[i] += dx[RN_ALIGN_VELOCITY + i];
    for (int i = 0; i < 3; i++) x->gyro_bias[i] += dx[RN_ALIGN_GYRO + i];
    for (int i = 0; i < 3; i++) x->accel_bias[i] += dx[RN_ALIGN_ACCEL + i];
    for (int i = 0; i < 2; i++) x->rate[i] += dx[RN_ALIGN_RATE + i];
    if (common > RN_ALIGN_COMPASS) x->compass_bias += dx[RN_ALIGN_COMPASS];
}

/* x <- x [+] dx, then P <- G P G' with the left Jacobian of the turn: the error is measured from the new attitude.  An
 * anchored filter only notes how far it is from its anchor. */
void RN(align_filter_inject)(RN(align_filter) * f, const real *dx)
{
    for (int i = f->common; i < f->n; i++) f->d[i - f->common] += dx[i];
    if (f->anchored) {
        for (int i = 0; i < f->common; i++) f->off[i] += dx[i];
        return;
    }
    real S[9], SS[9], G[9];
    move(&f->core, dx, f->common);
    const real square = dx[0] * dx[0] + dx[1] * dx[1] + dx[2] * dx[2], angle = rn_sqrt(square);
    const int small = square < R(1e-4);
    const real first = small ? R(0.5) - square / R(24.0) : (R(1.0) - rn_cos(angle)) / square;
    const real second = small ? R(1.0) / R(6.0) - square / R(120.0) : (angle - rn_sin(angle)) / (square * angle);
    skew(dx, S);
    times_matrix(S, S, SS);
    for (int i = 0; i < 9; i++) G[i] = (i % 4 == 0 ? R(1.0) : R(0.0)) + first * S[i] + second * SS[i];
    carry(f, RN_ALIGN_TURN, G);
}

/* What is estimated, but for the turn about down: tilt is found in the axes of the anchor, however far those have turned. */
void RN(align_filter_level)(const RN(align_filter) * f, RN(align_core) * x)
{
    real off[RN_ALIGN_COMMON];
    *x = f->core;
    if (!f->anchored) return;
    memcpy(off, f->off, sizeof off);
    off[RN_ALIGN_TURN + 2] = R(0.0);
    move(x, off, f->common);
}

void RN(align_filter_estimate)(const RN(align_filter) * f, RN(align_core) * x)
{
    const real turn[3] = {R(0.0), R(0.0), f->off[RN_ALIGN_TURN + 2]};
    real e[4];
    RN(align_filter_level)(f, x);
    if (!f->anchored) return;
    exponential(turn, e);
    product(e, x->q, x->q);
}

/* Make all linear about the state as it is. */
void RN(align_filter_anchor)(RN(align_filter) * f)
{
    memset(f->off, 0, sizeof f->off);
    f->anchored = 1;
}

/* One reading (z north, east).  It may be a gust: its noise is divided by the probability that it is not. */
void RN(align_filter_update)(RN(align_filter) * f, const RN(align_setup) * s, const real *z)
{
    const int n = f->n, common = f->common, markov = n - 2;
    real W[2][RN_ALIGN_STATES], S[3], r[2], dx[RN_ALIGN_STATES], *P = f->P;
    for (int i = 0; i < 2; i++) {
        real h = f->core.v[i] + f->off[RN_ALIGN_VELOCITY + i] + f->d[markov - common + i];
        for (int j = 0; j < n; j++) W[i][j] = P[(RN_ALIGN_VELOCITY + i) * n + j] + P[(markov + i) * n + j];
        for (int l = 0; l < f->wind.lines; l++) {
            const int k = common + 5 * l + 2 * i;
            h += f->d[k - common];
            for (int j = 0; j < n; j++) W[i][j] += P[k * n + j];
        }
        r[i] = z[i] - h;
    }
    for (int k = 0; k < 3; k++) {
        const int i = k == 2, j = k > 0; /* xx, xy, yy */
        S[k] = W[i][RN_ALIGN_VELOCITY + j] + W[i][markov + j];
        for (int l = 0; l < f->wind.lines; l++) S[k] += W[i][common + 5 * l + 2 * j];
    }
    const real noise = s->reference_sd * s->reference_sd, gust = noise + s->gust_sd * s->gust_sd;
    const real calm_det = (S[0] + noise) * (S[2] + noise) - S[1] * S[1], gust_det = (S[0] + gust) * (S[2] + gust) - S[1] * S[1];
    const real cross = R(2.0) * S[1] * r[0] * r[1], xx = r[0] * r[0], yy = r[1] * r[1];
    const real square = ((S[2] + noise) * xx - cross + (S[0] + noise) * yy) / calm_det;
    const real gust_square = ((S[2] + gust) * xx - cross + (S[0] + gust) * yy) / gust_det;
    const real calm = rn_log(R(1.0) - s->gust_share) - R(0.5) * (square + rn_log(calm_det));
    const real blown = rn_log(s->gust_share) - R(0.5) * (gust_square + rn_log(gust_det));
    const real top = calm > blown ? calm : blown, odds = rn_exp(calm - top) + rn_exp(blown - top);
    const real share = rn_exp(calm - top) / odds, weight = share > R(1e-6) ? share : R(1e-6);
    f->log_likelihood = top + rn_log(odds) - R(1.8378770664093453);
    f->misfit = weight * square;
    const real l00 = rn_sqrt(S[0] + noise / weight), l10 = S[1] / l00, l11 = rn_sqrt(S[2] + noise / weight - l10 * l10);
    const real y0 = r[0] / l00, y1 = (r[1] - l10 * y0) / l11;
    for (int j = 0; j < n; j++) {
        W[0][j] /= l00;
        W[1][j] = (W[1][j] - l10 * W[0][j]) / l11;
        dx[j] = W[0][j] * y0 + W[1][j] * y1;
    }
    for (int i = 0; i < n; i++) {
        for (int j = i; j < n; j++) P[i * n + j] -= W[0][i] * W[0][j] + W[1][i] * W[1][j];
    }
    mirror(P, n, n);
    RN(align_filter_inject)(f, dx);
}
