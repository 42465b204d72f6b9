/* Lines in a window of the record: the set of frequencies with the most evidence, by a search that adds one line at a time.
 *
 * What remains of the reference velocity is a slow drift (tilt, biases: polynomials), lines of Gaussian amplitude, and
 * Markov plus white noise, which a scalar filter whitens in data and columns alike.  The evidence is exact. */
#include "rn_align.h"

#include <string.h>

enum { POLY = 5, COLUMNS = POLY + 2 * RN_ALIGN_LINES };

static const real LOWEST = R(0.2), HIGHEST = R(4.0); /* rad/s searched */
static const real LINE_SD = R(0.3);                  /* m/s, amplitude */
static const real LINE_COST = R(4.0);                /* what one more frequency must gain, nats */

/* Pass one column through the whitening filter, in place. */
static void whiten_column(const RN(align_window) * w, real *x)
{
    real mean = R(0.0);
    for (int k = 0; k < w->n; k++) {
        const real past = w->decay * mean, innovation = x[k] - past;
        mean = past + w->gain[k] * innovation;
        x[k] = innovation * w->scale[k];
    }
}

/* Entries of the columns first and first + 1 (the same for one column) with the columns 0 .. used - 1 and with the data. */
static void project(RN(align_window) * w, int first, int second, int used)
{
    const real *x = w->A[first], *y = w->A[second];
    for (int i = 0; i < used + 2; i++) {
        const real *z = i < used ? w->A[i] : w->white[i - used];
        real xe = R(0.0), ye = R(0.0), xo = R(0.0), yo = R(0.0); /* even and odd rows: four sums that do not wait */
        for (int k = 0; k + 1 < w->n; k += 2) {
            xe += x[k] * z[k];
            ye += y[k] * z[k];
            xo += x[k + 1] * z[k + 1];
            yo += y[k + 1] * z[k + 1];
        }
        if (w->n % 2) {
            xe += x[w->n - 1] * z[w->n - 1];
            ye += y[w->n - 1] * z[w->n - 1];
        }
        if (i < used) {
            w->G[i][first] = w->G[first][i] = xe + xo;
            w->G[i][second] = w->G[second][i] = ye + yo;
        } else {
            w->b[first][i - used] = xe + xo;
            w->b[second][i - used] = ye + yo;
        }
    }
}

/* Log evidence of the first `used` columns, less that of no column. */
static real evidence(const RN(align_window) * w, int used)
{
    real L[COLUMNS][COLUMNS], y[COLUMNS][2], square = R(0.0), det = R(0.0);
    for (int i = 0; i < used; i++) {
        for (int j = 0; j <= i; j++) {
            real sum = w->G[i][j] + (i == j ? w->precision[i] : R(0.0));
            for (int k = 0; k < j; k++) sum -= L[i][k] * L[j][k];
            L[i][j] = i == j ? rn_sqrt(sum) : sum / L[j][j];
        }
        det += rn_log(L[i][i] * L[i][i] / w->precision[i]);
        for (int axis = 0; axis < 2; axis++) {
            real sum = w->b[i][axis];
            for (int k = 0; k < i; k++) sum -= L[i][k] * y[k][axis];
            y[i][axis] = sum / L[i][i];
            square += y[i][axis] * y[i][axis];
        }
    }
    return R(0.5) * square - det;
}

/* Put line l at omega and return the evidence of the first `lines` lines. */
static real try_line(RN(align_window) * w, int l, real omega, int lines)
{
    const int j = POLY + 2 * l, used = POLY + 2 * lines;
    const real c = rn_cos(omega * w->period), s = rn_sin(omega * w->period);
    real x = R(1.0), y = R(0.0);
    for (int k = 0; k < w->n; k++) {
        const real turned = c * x - s * y;
        w->A[j][k] = x;
        w->A[j + 1][k] = y;
        y = s * x + c * y;
        x = turned;
    }
    for (int i = j; i < j + 2; i++) {
        whiten_column(w, w->A[i]);
        w->precision[i] = R(1.0) / (LINE_SD * LINE_SD);
    }
    project(w, j, j + 1, used);
    return evidence(w, used);
}

/* Climb from *omega by parabolas through three points, ever closer. */
static real refine(RN(align_window) * w, int l, int lines, real step, real *omega)
{
    for (int i = 0; i < 3; i++) {
        const real here = try_line(w, l, *omega, lines), below = try_line(w, l, *omega - step, lines);
        const real above = try_line(w, l, *omega + step, lines), bend = R(2.0) * here - below - above;
        const real uphill = above > below ? step : -step;
        real move = bend > R(0.0) ? R(0.5) * step * (above - below) / bend : uphill;
        if (rn_abs(move) > step) move = uphill;
        if (*omega + move > LOWEST && *omega + move < HIGHEST) *omega += move;
        step *= R(0.4);
    }
    return try_line(w, l, *omega, lines);
}

/* The best place for line l on a grid finer than the window resolves, refined. */
static real scan(RN(align_window) * w, int l, int lines, real *omega)
{
    const real step = R(1.5) / ((real)w->n * w->period);
    real best = R(0.0);
    int first = 1;
    for (real there = LOWEST; there < HIGHEST; there += step) {
        const real value = try_line(w, l, there, lines);
        if (first || value > best) {
            best = value;
            *omega = there;
            first = 0;
        }
    }
    return refine(w, l, lines, R(0.6) * step, omega);
}

/* Whiten data and polynomials for this noise; return the log density of the data with polynomials only. */
real RN(align_whiten)(RN(align_window) * w, real markov_sd, real markov_time)
{
    real P = markov_sd * markov_sd, det = R(0.0), square = R(0.0);
    w->decay = rn_exp(-w->period / markov_time);
    for (int k = 0; k < w->n; k++) {
        const int there = w->weight[k] > R(0.0);
        const real S = there ? P + w->noise_sd * w->noise_sd / w->weight[k] : R(1.0);
        w->gain[k] = there ? P / S : R(0.0);
        w->scale[k] = there ? R(1.0) / rn_sqrt(S) : R(0.0);
        det += rn_log(S);
        P = w->decay * w->decay * (R(1.0) - w->gain[k]) * P + markov_sd * markov_sd * (R(1.0) - w->decay * w->decay);
    }
    for (int axis = 0; axis < 2; axis++) {
        memcpy(w->white[axis], w->r[axis], sizeof w->white[axis]);
        whiten_column(w, w->white[axis]);
        for (int k = 0; k < w->n; k++) square += w->white[axis][k] * w->white[axis][k];
    }
    for (int j = 0; j < POLY; j++) {
        for (int k = 0; k < w->n; k++) {
            const real x = (R(2.0) * (real)k + R(1.0)) / (real)w->n - R(1.0), xx = x * x;
            const real legendre[POLY] = {R(1.0), x, R(1.5) * xx - R(0.5), x * (R(2.5) * xx - R(1.5)),
                                         (R(35.0) * xx * xx - R(30.0) * xx + R(3.0)) / R(8.0)};
            w->A[j][k] = legendre[j];
        }
        whiten_column(w, w->A[j]);
        w->precision[j] = R(1.0) / (w->poly_sd[j] * w->poly_sd[j]);
        project(w, j, j, j + 1);
    }
    return evidence(w, POLY) - R(0.5) * square - det;
}

/* Refine all lines in turn until nothing is gained. */
static real settle(RN(align_window) * w, real *omega, int lines, real value)
{
    const real step = R(0.5) / ((real)w->n * w->period);
    for (int sweep = 0; sweep < 5; sweep++) {
        const real before = value;
        for (int l = 0; l < lines; l++) value = refine(w, l, lines, step, &omega[l]);
        if (value - before < R(0.3)) break;
    }
    return value;
}

/* Width of the evidence about each frequency. */
static void widths(RN(align_window) * w, real value, RN(align_spectrum) * out)
{
    const real h = R(0.2) / ((real)w->n * w->period);
    for (int l = 0; l < out->lines; l++) {
        const real below = try_line(w, l, out->omega[l] - h, out->lines), above = try_line(w, l, out->omega[l] + h, out->lines);
        const real bend = (R(2.0) * value - below - above) / (h * h), least = R(0.04) / (h * h);
        try_line(w, l, out->omega[l], out->lines);
        out->omega_sd[l] = R(1.0) / rn_sqrt(bend > least ? bend : least);
    }
}

/* Start from the lines in *found and add more while they pay; give up when `goal` is out of reach. */
void RN(align_search)(RN(align_window) * w, real markov_sd, real markov_time, real goal, RN(align_spectrum) * found)
{
    const real base = RN(align_whiten)(w, markov_sd, markov_time) - evidence(w, POLY);
    real omega[RN_ALIGN_LINES], best = evidence(w, POLY);
    memcpy(omega, found->omega, sizeof omega);
    for (int l = 0; l < found->lines; l++) best = try_line(w, l, omega[l], l + 1);
    if (found->lines) best = settle(w, omega, found->lines, best);
    memcpy(found->omega, omega, sizeof omega);
    while (found->lines < RN_ALIGN_LINES) {
        const int lines = found->lines + 1;
        const real value = settle(w, omega, lines, scan(w, lines - 1, lines, &omega[lines - 1]));
        const real gain = value - best - LINE_COST, left = (real)(RN_ALIGN_LINES - lines);
        if (gain < R(0.0)) break;
        best = value;
        found->lines = lines;
        memcpy(found->omega, omega, sizeof omega);
        /* Each line gains less than the one before. */
        if (base + best - LINE_COST * (real)lines + left * gain < goal) break;
    }
    for (int l = 0; l < found->lines; l++) try_line(w, l, found->omega[l], found->lines);
    widths(w, best, found);
    found->evidence = base + best - LINE_COST * (real)found->lines;
}

/* Log evidence of given lines in another noise. */
real RN(align_given)(RN(align_window) * w, real markov_sd, real markov_time, const RN(align_spectrum) * lines)
{
    const real base = RN(align_whiten)(w, markov_sd, markov_time) - evidence(w, POLY);
    real value = evidence(w, POLY);
    for (int l = 0; l < lines->lines; l++) value = try_line(w, l, lines->omega[l], l + 1);
    return base + value - LINE_COST * (real)lines->lines;
}
