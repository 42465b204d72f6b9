/* Extended Kalman and constant-gain steps; the unscented ones are in rn_ukf.c. */
#include "rn_filter.h"

#include <string.h>

void RN(ekf_update)(const RN(model) * m, int sensor, real *x, real *P, const real *z, real variance, real gate,
                    const real *p, RN(seen) * seen)
{
    const RN(sensor) *one = &m->sensors[sensor];
    const size_t bytes = (size_t)RN_PACKED(m->ne) * sizeof(real);
    real before[RN_PACKED(RN_MAX_STATE)], dx[RN_MAX_STATE];
    memcpy(before, P, bytes);
    const int refused = one->update(x, P, z, variance, p, dx, seen->nu, seen->s, &seen->nis);
    seen->used = refused == 0 && seen->nis <= gate && seen->nis < (real)INFINITY;
    if (seen->used)
        m->inject(x, dx);
    else
        memcpy(P, before, bytes);
}

void RN(fixed_correct)(const RN(model) * m, real *x, const real *K, const real *z, int mask, const real *p, real *r)
{
    real e[RN_MAX_STATE], *own = r;
    for (int j = 0; j < m->nsensors; j++) {
        const RN(sensor) *one = &m->sensors[j];
        if (mask >> j & 1) {
            one->residual(x, z, p, own);
            z += one->size;
        } else {
            for (int a = 0; a < one->rows; a++) own[a] = R(0.0);
        }
        own += one->rows;
    }
    m->gain(K, r, e);
    m->inject_turned(x, e);
}
