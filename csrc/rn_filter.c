/* The constant-gain step; the extended Kalman one is generated with each model, the unscented one is in rn_ukf.c. */
#include "rn_filter.h"

void RN(fixed_correct)(const RN(model) * m, real *x, const real *K, const real *z, int mask, const real *p, real *r)
{
    real e[RN_MAX_STATE], *own = r;
    for (int j = 0; j < m->nsensors; j++) {
        const RN(sensor) *one = &m->sensors[j];
        if (mask >> j & 1) {
            one->residual(x, z, p, own);
            z += one->width;
        } else {
            for (int a = 0; a < one->rows; a++) own[a] = R(0.0);
        }
        own += one->rows;
    }
    m->gain(K, r, e);
    m->inject_turned(x, e);
}
