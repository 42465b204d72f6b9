/* The start: which way is down. */
#include "rn_align.h"
#include "rn_align_turn.h"

/* The attitude that makes the mean specific force point up, with the least turn. */
void RN(align_level)(const real *readings, int count, const real *gyro_bias, real *q0)
{
    real q[4] = {R(1.0), R(0.0), R(0.0), R(0.0)}, sum[3] = {R(0.0)}, slope[3] = {R(0.0)}, C[9], t[3], u[3], e[4];
    for (int k = 0; k < count; k++) {
        const real *DQ = readings + k * RN_ALIGN_READING, *velocity = DQ + 4, *J = DQ + 7, *H = DQ + 16;
        times_vector(H, gyro_bias, t);
        for (int i = 0; i < 3; i++) t[i] = velocity[i] - t[i];
        matrix(q, C);
        times_vector(C, t, u);
        /* Least-squares slope of the sums at the ends of the periods, the start included. */
        const real lever = (real)(k + 1) - R(0.5) * (real)count;
        for (int i = 0; i < 3; i++) {
            sum[i] += u[i];
            slope[i] += lever * sum[i];
        }
        times_vector(J, gyro_bias, t);
        for (int i = 0; i < 3; i++) t[i] = -t[i];
        exponential(t, e);
        product(q, e, q);
        product(q, DQ, q);
    }
    const real norm = rn_sqrt(slope[0] * slope[0] + slope[1] * slope[1] + slope[2] * slope[2]);
    const real down[3] = {-slope[0] / norm, -slope[1] / norm, -slope[2] / norm};
    const real w = R(1.0) + down[2], length = rn_sqrt(w * w + down[0] * down[0] + down[1] * down[1]);
    const int over = length < R(1e-3); /* upside down: any level axis will do */
    q0[0] = over ? R(0.0) : w / length;
    q0[1] = over ? R(1.0) : down[1] / length;
    q0[2] = over ? R(0.0) : -down[0] / length;
    q0[3] = R(0.0);
}
