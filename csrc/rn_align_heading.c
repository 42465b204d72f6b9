/* From a filter's states to an answer: the horizontal Earth rate lies on a circle of known radius, and where on it is the
 * heading.  Given the heading everything else is Gaussian, so the posterior is a one-dimensional sum over the circle. */
#include "rn_align.h"

#include <string.h>

enum { NODES = 64 };

static const real PI = R(3.141592653589793);

/* Density of the rate on the circle: azimuth p of the wander frame's x axis has rate radius (cos p, -sin p). */
typedef struct {
    real radius, mean[2], info[3]; /* xx, xy, yy of the inverse covariance */
} circle_t;

static real exponent(const circle_t *c, real p, real *offset)
{
    offset[0] = c->radius * rn_cos(p) - c->mean[0];
    offset[1] = -c->radius * rn_sin(p) - c->mean[1];
    const real *x = offset, *I = c->info;
    return R(-0.5) * (I[0] * x[0] * x[0] + R(2.0) * I[1] * x[0] * x[1] + I[2] * x[1] * x[1]);
}

/* Climb to the top near p; returns it, and the information there. */
static real climb(const circle_t *c, real p, real *info)
{
    real x[2];
    for (int i = 0; i < 20; i++) {
        exponent(c, p, x);
        const real dx = -c->radius * rn_sin(p), dy = -c->radius * rn_cos(p), *I = c->info;
        const real slope = -(I[0] * x[0] * dx + I[1] * (x[0] * dy + x[1] * dx) + I[2] * x[1] * dy);
        *info = I[0] * dx * dx + R(2.0) * I[1] * dx * dy + I[2] * dy * dy;
        const real step = slope / *info, most = R(0.05);
        p += step > most ? most : step < -most ? -most : step;
    }
    return p;
}

/* Arcs worth summing over.  The exponent is a trigonometric polynomial of degree two: it has two tops at most. */
typedef struct {
    real centre, half;
} arc_t;

static int arcs_of(const circle_t *c, arc_t *arc)
{
    real value[NODES], x[2], info = R(0.0), top[2] = {R(0.0)};
    int count = 0;
    for (int i = 0; i < NODES; i++) value[i] = exponent(c, R(2.0) * PI * (real)i / (real)NODES, x);
    for (int i = 0; i < NODES; i++) {
        if (!(value[i] >= value[(i + NODES - 1) % NODES] && value[i] > value[(i + 1) % NODES]) || count == 2) continue;
        const real p = climb(c, R(2.0) * PI * (real)i / (real)NODES, &info), wide = R(6.0) / rn_sqrt(info);
        top[count] = exponent(c, p, x);
        arc[count].centre = p;
        arc[count++].half = wide < PI ? wide : PI;
    }
    if (count == 0) { /* flat to rounding */
        arc[0].centre = R(0.0);
        arc[0].half = PI;
        return 1;
    }
    if (count == 2 && top[1] > top[0]) {
        const arc_t first = arc[0];
        arc[0] = arc[1];
        arc[1] = first;
    }
    const real apart = count == 2 ? rn_abs(rn_wrap(arc[1].centre - arc[0].centre)) : R(0.0);
    if (count == 2 && apart < arc[0].half + arc[1].half) {
        const real whole = arc[0].half + apart;
        arc[0].half = whole < PI ? whole : PI;
        return 1;
    }
    return count;
}

/* Means over the arcs: the offset, its second moments, the heading beyond the first arc's centre and its square. */
typedef struct {
    real x[2], xx[3], heading, heading_square, cosine, sine;
} moments_t;

static void sum_over(const circle_t *c, const arc_t *arc, int count, const real *down_gain, moments_t *m)
{
    real total = R(0.0), x[2];
    const real top = exponent(c, arc[0].centre, x);
    memset(m, 0, sizeof *m);
    for (int i = 0; i < NODES * count; i++) {
        const arc_t *on = &arc[i / NODES];
        const real p = on->centre + on->half * ((R(2.0) * (real)(i % NODES) + R(1.0)) / (real)NODES - R(1.0));
        const real w = on->half * rn_exp(exponent(c, p, x) - top);
        const real turn = rn_wrap(on->centre - arc[0].centre) + (p - on->centre);
        const real h = turn + down_gain[0] * x[0] + down_gain[1] * x[1];
        total += w;
        for (int j = 0; j < 2; j++) m->x[j] += w * x[j];
        m->xx[0] += w * x[0] * x[0];
        m->xx[1] += w * x[0] * x[1];
        m->xx[2] += w * x[1] * x[1];
        m->heading += w * h;
        m->heading_square += w * h * h;
        m->cosine += w * rn_cos(h);
        m->sine += w * rn_sin(h);
    }
    for (int j = 0; j < 2; j++) m->x[j] /= total;
    for (int j = 0; j < 3; j++) m->xx[j] /= total;
    m->heading /= total;
    m->heading_square /= total;
    m->cosine /= total;
    m->sine /= total;
    m->xx[0] -= m->x[0] * m->x[0];
    m->xx[1] -= m->x[0] * m->x[1];
    m->xx[2] -= m->x[1] * m->x[1];
}

/* Constant error of the compass, given the length of the Earth rate. */
static void compass(const RN(align_filter) * f, const circle_t *c, const real *mean, const real *excess, RN(align_answer) * out)
{
    out->compass_bias = out->compass_bias_var = (real)NAN;
    if (f->common == RN_ALIGN_CORE) return;
    const real *row = f->P + RN_ALIGN_COMPASS * f->n, a = row[RN_ALIGN_RATE], b = row[RN_ALIGN_RATE + 1];
    const real k0 = a * c->info[0] + b * c->info[1], k1 = a * c->info[1] + b * c->info[2];
    out->compass_bias = f->core.compass_bias + f->off[RN_ALIGN_COMPASS] + k0 * mean[0] + k1 * mean[1];
    out->compass_bias_var = row[RN_ALIGN_COMPASS] + k0 * (excess[0] * k0 + excess[1] * k1) + k1 * (excess[1] * k0 + excess[2] * k1);
}

void RN(align_filter_answer)(const RN(align_filter) * f, const RN(align_setup) * s, RN(align_answer) * out)
{
    const int n = f->n;
    RN(align_core) x;
    RN(align_filter_level)(f, &x);
    const real *P = f->P, *q = x.q;
    const real xx = P[RN_ALIGN_RATE * (n + 1)], xy = P[RN_ALIGN_RATE * n + RN_ALIGN_RATE + 1], yy = P[(RN_ALIGN_RATE + 1) * (n + 1)], det = xx * yy - xy * xy;
    const circle_t c = {RN_ALIGN_EARTH_RATE * rn_cos(s->latitude), {x.rate[0], x.rate[1]}, {yy / det, -xy / det, xx / det}};
    real K[RN_ALIGN_RATE][2];
    arc_t arc[2];
    for (int i = 0; i < RN_ALIGN_RATE; i++) {
        const real a = P[i * n + RN_ALIGN_RATE], b = P[i * n + RN_ALIGN_RATE + 1];
        K[i][0] = a * c.info[0] + b * c.info[1];
        K[i][1] = a * c.info[1] + b * c.info[2];
    }
    const int arcs = arcs_of(&c, arc);
    moments_t m;
    sum_over(&c, arc, arcs, K[RN_ALIGN_TURN + 2], &m);
    memcpy(out->q, q, sizeof out->q);
    for (int i = 0; i < 2; i++) out->tilt[i] = K[i][0] * m.x[0] + K[i][1] * m.x[1];
    for (int i = 0; i < 3; i++) {
        out->gyro_bias[i] = x.gyro_bias[i] + K[RN_ALIGN_GYRO + i][0] * m.x[0] + K[RN_ALIGN_GYRO + i][1] * m.x[1];
        out->accel_bias[i] = x.accel_bias[i] + K[RN_ALIGN_ACCEL + i][0] * m.x[0] + K[RN_ALIGN_ACCEL + i][1] * m.x[1];
    }
    /* Covariance given the heading, and what the spread of the heading adds. */
    const real excess[3] = {m.xx[0] - xx, m.xx[1] - xy, m.xx[2] - yy};
    for (int k = 0; k < 3; k++) {
        const int i = k == 2, j = k > 0;
        out->tilt_cov[k] = P[i * n + j] + K[i][0] * (excess[0] * K[j][0] + excess[1] * K[j][1]) +
                           K[i][1] * (excess[1] * K[j][0] + excess[2] * K[j][1]);
    }
    const real *down_gain = K[RN_ALIGN_TURN + 2];
    const real down = P[2 * n + 2] - (down_gain[0] * down_gain[0] * xx + R(2.0) * down_gain[0] * down_gain[1] * xy + down_gain[1] * down_gain[1] * yy);
    const real forward = rn_atan2(R(2.0) * (q[1] * q[2] + q[0] * q[3]), R(1.0) - R(2.0) * (q[2] * q[2] + q[3] * q[3]));
    out->heading = rn_wrap(forward + f->off[RN_ALIGN_TURN + 2] + arc[0].centre + m.heading);
    out->heading_var = m.heading_square - m.heading * m.heading + down;
    out->concentration = rn_exp(R(-0.5) * down) * rn_sqrt(m.cosine * m.cosine + m.sine * m.sine);
    for (int i = 0; i < 2; i++) {
        out->wind[i] = x.v[i] + f->d[n - 2 - f->common + i];
        for (int l = 0; l < f->wind.lines; l++) out->wind[i] += f->d[5 * l + 2 * i];
    }
    compass(f, &c, m.x, excess, out);
}

/* The turn that takes attitude b to a, about x and y of the wander frame; the two differ by little. */
static void tilt_between(const real *a, const real *b, real *tilt)
{
    const real w = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3], sign = w < R(0.0) ? R(-2.0) : R(2.0);
    tilt[0] = sign * (a[1] * b[0] - a[0] * b[1] + a[3] * b[2] - a[2] * b[3]);
    tilt[1] = sign * (a[2] * b[0] - a[0] * b[2] + a[1] * b[3] - a[3] * b[1]);
}

/* One answer with the mean and covariance of several, weighted; referred to the attitude of the heaviest. */
void RN(align_mix)(const RN(align_answer) * in, const real *weight, int count, RN(align_answer) * out)
{
    int best = 0;
    for (int i = 1; i < count; i++) {
        if (weight[i] > weight[best]) best = i;
    }
    const RN(align_answer) *ref = &in[best];
    real mean[4] = {R(0.0)}, second[5] = {R(0.0)};
    *out = *ref;
    for (int j = 0; j < 3; j++) out->gyro_bias[j] = out->accel_bias[j] = R(0.0);
    out->wind[0] = out->wind[1] = out->concentration = R(0.0);
    for (int i = 0; i < count; i++) {
        const real w = weight[i];
        if (!(w > R(0.0))) continue;
        const RN(align_answer) *a = &in[i];
        real t[2];
        tilt_between(a->q, ref->q, t);
        t[0] += a->tilt[0];
        t[1] += a->tilt[1];
        const real h = rn_wrap(a->heading - ref->heading);
        mean[0] += w * t[0];
        mean[1] += w * t[1];
        mean[2] += w * h;
        second[0] += w * (a->tilt_cov[0] + t[0] * t[0]);
        second[1] += w * (a->tilt_cov[1] + t[0] * t[1]);
        second[2] += w * (a->tilt_cov[2] + t[1] * t[1]);
        second[3] += w * (a->heading_var + h * h);
        const real c = a->compass_bias - ref->compass_bias;
        mean[3] += w * c;
        second[4] += w * (a->compass_bias_var + c * c);
        out->concentration += w * a->concentration;
        for (int j = 0; j < 3; j++) {
            out->gyro_bias[j] += w * a->gyro_bias[j];
            out->accel_bias[j] += w * a->accel_bias[j];
        }
        for (int j = 0; j < 2; j++) out->wind[j] += w * a->wind[j];
    }
    out->tilt[0] = mean[0];
    out->tilt[1] = mean[1];
    out->tilt_cov[0] = second[0] - mean[0] * mean[0];
    out->tilt_cov[1] = second[1] - mean[0] * mean[1];
    out->tilt_cov[2] = second[2] - mean[1] * mean[1];
    out->heading = rn_wrap(ref->heading + mean[2]);
    out->heading_var = second[3] - mean[2] * mean[2];
    out->compass_bias = ref->compass_bias + mean[3];
    out->compass_bias_var = second[4] - mean[3] * mean[3];
}
