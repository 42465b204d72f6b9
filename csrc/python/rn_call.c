/* One function of a model at a time, seen through doubles.  Included by host_double.c and host_float.c. */
#include "rn_filter.h"
#include "rn_host.h"

static void to_real(real *out, const double *in, int n)
{
    for (int i = 0; i < n; i++) out[i] = (real)in[i];
}

static void to_double(double *out, const real *in, int n)
{
    for (int i = 0; i < n; i++) out[i] = (double)in[i];
}

static int call(const void *opaque, int what, int sensor, const double *const in[], double dt, double *const out[])
{
    const RN(model) *m = opaque;
    enum { MOST_ROWS = RN_HOST_SENSORS * RN_MAX_ROWS }; /* more than RN_MAX_STATE */
    real x[RN_MAX_STATE], a[MOST_ROWS], b[RN_MAX_STATE], p[RN_MAX_PARAMETERS];
    real F[RN_MAX_STATE * MOST_ROWS], Q[RN_MAX_STATE * RN_MAX_STATE];
    const RN(sensor) *one = sensor >= 0 && sensor < m->nsensors ? &m->sensors[sensor] : NULL;
    int rows_total = 0;
    for (int j = 0; j < m->nsensors; j++) rows_total += m->sensors[j].rows;
    if ((what == RN_CALL_MEASURE || what == RN_CALL_RESIDUAL || what == RN_CALL_JACOBIAN) && !one) return 1;
    if (what != RN_CALL_GAIN) to_real(x, in[0], m->nx);
    switch (what) {
    case RN_CALL_PROPAGATE:
        to_real(a, in[1], m->nu);
        to_real(p, in[2], m->np);
        m->propagate(x, a, p, (real)dt);
        to_double(out[0], x, m->nx);
        return 0;
    case RN_CALL_TRANSITION:
        to_real(a, in[1], m->nu);
        to_real(b, in[2], m->nq);
        to_real(p, in[3], m->np);
        m->transition(x, a, b, p, (real)dt, F, Q);
        to_double(out[0], F, m->ne * m->ne);
        to_double(out[1], Q, m->ne * m->ne);
        return 0;
    case RN_CALL_INJECT:
    case RN_CALL_INJECT_TURNED:
        to_real(a, in[1], m->ne);
        (what == RN_CALL_INJECT ? m->inject : m->inject_turned)(x, a);
        to_double(out[0], x, m->nx);
        return 0;
    case RN_CALL_DIFFERENCE:
        to_real(a, in[1], m->nx);
        m->difference(x, a, b);
        to_double(out[0], b, m->ne);
        return 0;
    case RN_CALL_MEASURE:
        to_real(a, in[1], one->width);
        to_real(p, in[2], m->np);
        one->measure(x, a, p, b);
        to_double(out[0], b, one->size);
        return 0;
    case RN_CALL_RESIDUAL:
        to_real(a, in[1], one->width);
        to_real(p, in[2], m->np);
        one->residual(x, a, p, b);
        to_double(out[0], b, one->rows);
        return 0;
    case RN_CALL_JACOBIAN:
        to_real(a, in[1], one->width);
        to_real(p, in[2], m->np);
        one->jacobian(x, a, p, F);
        to_double(out[0], F, one->rows * m->ne);
        return 0;
    case RN_CALL_GAIN:
        to_real(F, in[0], m->ne * rows_total);
        to_real(a, in[1], rows_total);
        m->gain(F, a, b);
        to_double(out[0], b, m->ne);
        return 0;
    default: return 1;
    }
}
