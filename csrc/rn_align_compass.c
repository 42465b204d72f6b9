/* A compass in one filter: the azimuth of the magnetic field says where the Earth rate points. */
#include "rn_align.h"

#include <string.h>

static const real LENGTH_SD = R(0.3);   /* of the Earth rate's length along a first bearing, by which it is told from its opposite */
static const real LEVEL_SHARE = R(0.1); /* of the field: nearer the vertical it says nothing of north */
static const real WIDEST = R(0.85);     /* sine of the farthest that north may be expected from where it was first seen */
static const real DISTURBED = R(0.05);  /* share of readings whose bearing may be any */
static const real STEEPNESS_TIME = R(5.0); /* s, over which the field's dip is averaged */
static const real ODD = R(0.3);         /* rad from the middle of the first bearings */

/* Azimuth of magnetic north and the tangent of the field's dip; 0 if the field is missing or upright. */
int RN(align_bearing)(const real *q, const real *field, real *azimuth, real *steepness)
{
    const real w = q[0], x = q[1], y = q[2], z = q[3], two = R(2.0);
    const real t[3] = {two * (y * field[2] - z * field[1]), two * (z * field[0] - x * field[2]), two * (x * field[1] - y * field[0])};
    const real m[3] = {field[0] + w * t[0] + y * t[2] - z * t[1], field[1] + w * t[1] + z * t[0] - x * t[2],
                       field[2] + w * t[2] + x * t[1] - y * t[0]};
    const real level = m[0] * m[0] + m[1] * m[1];
    if (!(level > LEVEL_SHARE * LEVEL_SHARE * (level + m[2] * m[2]))) return 0;
    *azimuth = rn_atan2(m[1], m[0]);
    *steepness = m[2] / rn_sqrt(level);
    return 1;
}

/* One number, with nothing of it in the wind: row H over the common states, the innovation and its noise's variance. */
static void scalar(RN(align_filter) * f, const real *H, real innovation, real noise)
{
    const int n = f->n;
    real PH[RN_ALIGN_STATES], S = noise, *P = f->P;
    for (int j = 0; j < n; j++) PH[j] = R(0.0);
    for (int k = 0; k < RN_ALIGN_COMMON; k++) {
        if (H[k] == R(0.0)) continue;
        for (int j = 0; j < n; j++) PH[j] += H[k] * P[k * n + j];
    }
    for (int k = 0; k < RN_ALIGN_COMMON; k++) S += H[k] * PH[k];
    const real root = rn_sqrt(S);
    for (int j = 0; j < n; j++) PH[j] /= root;
    for (int i = 0; i < n; i++) {
        for (int j = i; j < n; j++) P[j * n + i] = P[i * n + j] -= PH[i] * PH[j];
    }
    for (int j = 0; j < n; j++) PH[j] *= innovation / root;
    RN(align_filter_inject)(f, PH);
}

/* A bearing laid across north, linear about the rate that is expected, about the first bearing while none is.  It may be
 * disturbed: its noise is divided by the probability that it is not. */
static void across(RN(align_filter) * f, const RN(align_setup) * s, real azimuth, real steepness, int first)
{
    RN(align_core) now, *x = &now;
    RN(align_filter_estimate)(f, x);
    const real length = RN_ALIGN_EARTH_RATE * rn_cos(s->latitude), *P = f->P;
    const real side[2] = {-rn_sin(x->north) / length, rn_cos(x->north) / length};
    const real share = side[0] * x->rate[0] + side[1] * x->rate[1];
    const real turn = first ? R(0.0) : rn_asin(share > WIDEST ? WIDEST : share < -WIDEST ? -WIDEST : share), ahead = rn_cos(turn);
    const real expected = x->north + turn + s->declination + x->compass_bias;
    /* What a tilt does to a bearing in second order. */
    const real bend = (R(0.5) + x->steepness * x->steepness) * (P[0] + P[f->n + 1]);
    const real noise = s->compass_sd * s->compass_sd + bend * bend;
    real H[RN_ALIGN_COMMON] = {R(0.0)}, S = noise;
    /* A tilt is about the axes of the anchor. */
    H[RN_ALIGN_TURN] = x->steepness * rn_cos(expected - f->off[RN_ALIGN_TURN + 2]);
    H[RN_ALIGN_TURN + 1] = x->steepness * rn_sin(expected - f->off[RN_ALIGN_TURN + 2]);
    H[RN_ALIGN_TURN + 2] = R(-1.0);
    H[RN_ALIGN_RATE] = side[0] / ahead;
    H[RN_ALIGN_RATE + 1] = side[1] / ahead;
    H[RN_ALIGN_COMPASS] = R(1.0);
    for (int i = 0; i < RN_ALIGN_COMMON; i++) {
        for (int j = 0; j < RN_ALIGN_COMMON; j++) S += H[i] * H[j] * P[i * f->n + j];
    }
    const real off = rn_wrap(azimuth - expected) - (share - rn_sin(turn)) / ahead;
    const real fair = (R(1.0) - DISTURBED) * rn_exp(R(-0.5) * off * off / S) * rn_sqrt(R(6.283185307179586) / S);
    const real share_fair = fair / (fair + DISTURBED), weight = share_fair > R(1e-6) ? share_fair : R(1e-6);
    f->core.steepness += weight * s->period / STEEPNESS_TIME * (steepness - x->steepness);
    scalar(f, H, off, noise / weight);
}

/* One reading of the magnetic field; without a compass, or NaN, nothing changes. */
void RN(align_filter_bearing)(RN(align_filter) * f, const RN(align_setup) * s, const real *field)
{
    RN(align_core) now, *x = &now;
    RN(align_filter_estimate)(f, x);
    const real length = RN_ALIGN_EARTH_RATE * rn_cos(s->latitude), *P = f->P;
    const int n = f->n, at = RN_ALIGN_RATE, first = !x->has_north;
    real azimuth, steepness, H[RN_ALIGN_COMMON] = {R(0.0)};
    if (f->common == RN_ALIGN_CORE || !RN(align_bearing)(x->q, field, &azimuth, &steepness)) return;
    const int known = !first || P[at * (n + 1)] + P[(at + 1) * (n + 1)] < length * length;
    if (first) {
        f->core.north = known ? rn_atan2(x->rate[1], x->rate[0]) : azimuth - s->declination;
        f->core.steepness = steepness;
        f->core.has_north = 1;
    }
    across(f, s, azimuth, steepness, first);
    if (known) return;
    RN(align_filter_estimate)(f, x);
    H[at] = rn_cos(x->north);
    H[at + 1] = rn_sin(x->north);
    scalar(f, H, length - H[at] * x->rate[0] - H[at + 1] * x->rate[1], LENGTH_SD * length * LENGTH_SD * length);
}

/* Fields of the start that are far from the middle one are put to zero, which is no bearing: no filter has a north yet
 * to judge them by. */
void RN(align_forget_odd_fields)(real *readings, int count, const RN(align_setup) * s, const real *q0)
{
    enum { MOST = 20 }; /* two seconds at the shortest period */
    real q[4] = {q0[0], q0[1], q0[2], q0[3]}, azimuth[MOST], steepness, least = R(0.0), middle = R(0.0);
    int there[MOST], any = 0;
    if (count > MOST) count = MOST;
    for (int k = 0; k < count; k++) {
        const real *d = readings + k * RN_ALIGN_READING, w = q[0], x = q[1], y = q[2], z = q[3];
        q[0] = w * d[0] - x * d[1] - y * d[2] - z * d[3];
        q[1] = w * d[1] + x * d[0] + y * d[3] - z * d[2];
        q[2] = w * d[2] - x * d[3] + y * d[0] + z * d[1];
        q[3] = w * d[3] + x * d[2] - y * d[1] + z * d[0];
        there[k] = RN(align_bearing)(q, d + RN_ALIGN_FIELD_AT, &azimuth[k], &steepness);
    }
    for (int k = 0; k < count; k++) {
        real apart = R(0.0);
        for (int j = 0; j < count; j++) apart += there[k] && there[j] ? rn_abs(rn_wrap(azimuth[j] - azimuth[k])) : R(0.0);
        if (!there[k] || (any && !(apart < least))) continue;
        any = 1;
        least = apart;
        middle = azimuth[k];
    }
    const real limit = R(4.0) * s->compass_sd > ODD ? R(4.0) * s->compass_sd : ODD;
    for (int k = 0; k < count; k++) {
        if (there[k] && rn_abs(rn_wrap(azimuth[k] - middle)) < limit) continue;
        memset(readings + k * RN_ALIGN_READING + RN_ALIGN_FIELD_AT, 0, 3 * sizeof(real));
    }
}
