/* The smoother's loop over rows.  Included by host_double.c and host_float.c, behind rn_call.c. */
#include "rn_smooth_host.h"

#include <string.h>

#include "rn_smooth.h"

size_t RN_SMOOTH_BYTES(const void *model) { return (size_t)RN(smooth_scratch)(model) * sizeof(real); }

void RN_SMOOTH_ROWS(rn_smooth_batch *b, size_t from, size_t to, void *scratch)
{
    const RN(model) *m = b->model;
    const int packed = RN_PACKED(m->ne);
    const size_t nx = (size_t)m->nx, nu = (size_t)m->nu, numbers = (size_t)packed;
    real q[RN_MAX_NOISES], p[RN_MAX_PARAMETERS], u[RN_MAX_INPUT], x[RN_MAX_STATE + 1], next[RN_MAX_STATE + 1];
    real P[RN_PACKED(RN_MAX_STATE)], P_next[RN_PACKED(RN_MAX_STATE)];
    to_real(q, b->q, m->nq);
    to_real(p, b->p, m->np);
    for (size_t k = to; k-- > from;) {
        const double dt = b->dt[k + 1];
        double *x_out = b->x + k * nx, *P_out = b->P + k * numbers;
        if (!(dt >= 0.0)) continue;
        if ((real)dt <= R(0.0)) {
            memcpy(x_out, x_out + nx, nx * sizeof(double));
            memcpy(P_out, P_out + numbers, numbers * sizeof(double));
            continue;
        }
        to_real(x, x_out, m->nx);
        to_real(P, P_out, packed);
        to_real(next, x_out + nx, m->nx);
        to_real(P_next, P_out + numbers, packed);
        to_real(u, b->u + (k + 1) * nu, m->nu);
        RN(smooth_step)(m, x, P, next, P_next, u, q, p, (real)dt, scratch);
        to_double(x_out, x, m->nx);
        to_double(P_out, P, packed);
    }
}
