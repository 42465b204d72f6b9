/* Generated from the model 'uwb_3d_driven'; do not edit: make generate. */
/* clang-format off */
#ifndef RN_GENERATED_UWB_3D_DRIVEN_H
#define RN_GENERATED_UWB_3D_DRIVEN_H
#include "rn_model.h"
#include "rn_update.h"

/* state, error (quaternions: small rotation, rad), input, parameters:
 *   x[0..2], e[0..2]  p_n [m]
 *   x[3..5], e[3..5]  v_n [m/s]
 *   u[0..2]  accel_n [m/s^2]
 *   p[0]  time_offset
 *   reading range: z[0..0] [m]
 *     z[1..3]  p_anchor [m]
 *   reading tdoa: z[0..0] [m]
 *     z[1..3]  p_first [m]
 *     z[4..6]  p_second [m]
 *   reading position: z[0..2] [m]
 *   reading height: z[0..0] [m]
 *   q[0]  intensity of acceleration [(m/s^2/sqrt(Hz))^2]
 *   q[1]  intensity of vertical_acceleration [(m/s^2/sqrt(Hz))^2] */

RN_INLINE void rn_uwb_3d_driven_propagate(real *x, const real *u, const real *p, real dt)
{
    RN_UNUSED(p);
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_p_n_2 = x[2];
    const real s_v_n_0 = x[3];
    const real s_v_n_1 = x[4];
    const real s_v_n_2 = x[5];
    const real u_accel_n_0 = u[0];
    const real u_accel_n_1 = u[1];
    const real u_accel_n_2 = u[2];
    const real t_0 = dt * u_accel_n_0;
    const real m_3 = R(0.5) * t_0 + s_v_n_0;
    const real t_1 = dt * u_accel_n_1;
    const real m_4 = R(0.5) * t_1 + s_v_n_1;
    const real t_2 = dt * u_accel_n_2;
    const real m_5 = R(0.5) * t_2 + s_v_n_2;
    x[0] = dt * m_3 + s_p_n_0;
    x[1] = dt * m_4 + s_p_n_1;
    x[2] = dt * m_5 + s_p_n_2;
    x[3] = s_v_n_0 + t_0;
    x[4] = s_v_n_1 + t_1;
    x[5] = s_v_n_2 + t_2;
}

RN_INLINE void rn_uwb_3d_driven_predict(real *x, real *P, const real *u, const real *q, const real *p, real dt)
{
    RN_UNUSED(p);
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_p_n_2 = x[2];
    const real s_v_n_0 = x[3];
    const real s_v_n_1 = x[4];
    const real s_v_n_2 = x[5];
    const real u_accel_n_0 = u[0];
    const real u_accel_n_1 = u[1];
    const real u_accel_n_2 = u[2];
    const real q_0 = q[0];
    const real q_1 = q[1];
    const real P_0_0 = P[0];
    const real P_0_1 = P[1];
    const real P_0_2 = P[2];
    const real P_0_3 = P[3];
    const real P_0_4 = P[4];
    const real P_0_5 = P[5];
    const real P_1_1 = P[6];
    const real P_1_2 = P[7];
    const real P_1_3 = P[8];
    const real P_1_4 = P[9];
    const real P_1_5 = P[10];
    const real P_2_2 = P[11];
    const real P_2_3 = P[12];
    const real P_2_4 = P[13];
    const real P_2_5 = P[14];
    const real P_3_3 = P[15];
    const real P_3_4 = P[16];
    const real P_3_5 = P[17];
    const real P_4_4 = P[18];
    const real P_4_5 = P[19];
    const real P_5_5 = P[20];
    const real t_0 = dt * u_accel_n_0;
    const real m_3 = R(0.5) * t_0 + s_v_n_0;
    const real t_1 = dt * u_accel_n_1;
    const real m_4 = R(0.5) * t_1 + s_v_n_1;
    const real t_2 = dt * u_accel_n_2;
    const real m_5 = R(0.5) * t_2 + s_v_n_2;
    const real t_3 = R(0.3333333333333333) * (dt * dt * dt);
    const real Q_0_0 = q_0 * t_3;
    const real T_0_0 = P_0_0 + P_0_3 * dt;
    const real T_0_3 = P_0_3 + P_3_3 * dt;
    const real T_0_1 = P_0_1 + P_1_3 * dt;
    const real t_4 = P_3_4 * dt;
    const real T_0_4 = P_0_4 + t_4;
    const real T_0_2 = P_0_2 + P_2_3 * dt;
    const real t_5 = P_3_5 * dt;
    const real T_0_5 = P_0_5 + t_5;
    const real t_6 = R(0.5) * (dt * dt);
    const real Q_0_3 = q_0 * t_6;
    const real T_1_1 = P_1_1 + P_1_4 * dt;
    const real T_1_4 = P_1_4 + P_4_4 * dt;
    const real T_1_2 = P_1_2 + P_2_4 * dt;
    const real t_7 = P_4_5 * dt;
    const real T_1_5 = P_1_5 + t_7;
    const real T_1_3 = P_1_3 + t_4;
    const real Q_2_2 = q_1 * t_3;
    const real T_2_2 = P_2_2 + P_2_5 * dt;
    const real T_2_5 = P_2_5 + P_5_5 * dt;
    const real T_2_3 = P_2_3 + t_5;
    const real T_2_4 = P_2_4 + t_7;
    const real Q_2_5 = q_1 * t_6;
    const real Q_3_3 = dt * q_0;
    const real Q_5_5 = dt * q_1;
    x[0] = dt * m_3 + s_p_n_0;
    x[1] = dt * m_4 + s_p_n_1;
    x[2] = dt * m_5 + s_p_n_2;
    x[3] = s_v_n_0 + t_0;
    x[4] = s_v_n_1 + t_1;
    x[5] = s_v_n_2 + t_2;
    P[0] = Q_0_0 + T_0_0 + T_0_3 * dt;
    P[1] = T_0_1 + T_0_4 * dt;
    P[2] = T_0_2 + T_0_5 * dt;
    P[3] = Q_0_3 + T_0_3;
    P[4] = T_0_4;
    P[5] = T_0_5;
    P[6] = Q_0_0 + T_1_1 + T_1_4 * dt;
    P[7] = T_1_2 + T_1_5 * dt;
    P[8] = T_1_3;
    P[9] = Q_0_3 + T_1_4;
    P[10] = T_1_5;
    P[11] = Q_2_2 + T_2_2 + T_2_5 * dt;
    P[12] = T_2_3;
    P[13] = T_2_4;
    P[14] = Q_2_5 + T_2_5;
    P[15] = P_3_3 + Q_3_3;
    P[16] = P_3_4;
    P[17] = P_3_5;
    P[18] = P_4_4 + Q_3_3;
    P[19] = P_4_5;
    P[20] = P_5_5 + Q_5_5;
}

RN_INLINE void rn_uwb_3d_driven_transition(const real *x, const real *u, const real *q, const real *p, real dt, real *F, real *Q)
{
    RN_UNUSED(x);
    RN_UNUSED(u);
    RN_UNUSED(p);
    const real q_0 = q[0];
    const real q_1 = q[1];
    const real t_0 = R(0.3333333333333333) * (dt * dt * dt);
    const real Q_0_0 = q_0 * t_0;
    const real t_1 = R(0.5) * (dt * dt);
    const real Q_0_3 = q_0 * t_1;
    const real Q_2_2 = q_1 * t_0;
    const real Q_2_5 = q_1 * t_1;
    const real Q_3_3 = dt * q_0;
    const real Q_5_5 = dt * q_1;
    F[0] = R(1.0);
    F[1] = R(0.0);
    F[2] = R(0.0);
    F[3] = dt;
    F[4] = R(0.0);
    F[5] = R(0.0);
    F[6] = R(0.0);
    F[7] = R(1.0);
    F[8] = R(0.0);
    F[9] = R(0.0);
    F[10] = dt;
    F[11] = R(0.0);
    F[12] = R(0.0);
    F[13] = R(0.0);
    F[14] = R(1.0);
    F[15] = R(0.0);
    F[16] = R(0.0);
    F[17] = dt;
    F[18] = R(0.0);
    F[19] = R(0.0);
    F[20] = R(0.0);
    F[21] = R(1.0);
    F[22] = R(0.0);
    F[23] = R(0.0);
    F[24] = R(0.0);
    F[25] = R(0.0);
    F[26] = R(0.0);
    F[27] = R(0.0);
    F[28] = R(1.0);
    F[29] = R(0.0);
    F[30] = R(0.0);
    F[31] = R(0.0);
    F[32] = R(0.0);
    F[33] = R(0.0);
    F[34] = R(0.0);
    F[35] = R(1.0);
    Q[0] = Q_0_0;
    Q[1] = R(0.0);
    Q[2] = R(0.0);
    Q[3] = Q_0_3;
    Q[4] = R(0.0);
    Q[5] = R(0.0);
    Q[6] = R(0.0);
    Q[7] = Q_0_0;
    Q[8] = R(0.0);
    Q[9] = R(0.0);
    Q[10] = Q_0_3;
    Q[11] = R(0.0);
    Q[12] = R(0.0);
    Q[13] = R(0.0);
    Q[14] = Q_2_2;
    Q[15] = R(0.0);
    Q[16] = R(0.0);
    Q[17] = Q_2_5;
    Q[18] = Q_0_3;
    Q[19] = R(0.0);
    Q[20] = R(0.0);
    Q[21] = Q_3_3;
    Q[22] = R(0.0);
    Q[23] = R(0.0);
    Q[24] = R(0.0);
    Q[25] = Q_0_3;
    Q[26] = R(0.0);
    Q[27] = R(0.0);
    Q[28] = Q_3_3;
    Q[29] = R(0.0);
    Q[30] = R(0.0);
    Q[31] = R(0.0);
    Q[32] = Q_2_5;
    Q[33] = R(0.0);
    Q[34] = R(0.0);
    Q[35] = Q_5_5;
}

RN_INLINE void rn_uwb_3d_driven_noise(const real *x, const real *u, const real *q, const real *p, real dt, real *Q)
{
    RN_UNUSED(x);
    RN_UNUSED(u);
    RN_UNUSED(p);
    const real q_0 = q[0];
    const real q_1 = q[1];
    const real t_0 = R(0.3333333333333333) * (dt * dt * dt);
    const real Q_0_0 = q_0 * t_0;
    const real t_1 = R(0.5) * (dt * dt);
    const real Q_0_3 = q_0 * t_1;
    const real Q_2_2 = q_1 * t_0;
    const real Q_2_5 = q_1 * t_1;
    const real Q_3_3 = dt * q_0;
    const real Q_5_5 = dt * q_1;
    Q[0] = Q_0_0;
    Q[1] = R(0.0);
    Q[2] = R(0.0);
    Q[3] = Q_0_3;
    Q[4] = R(0.0);
    Q[5] = R(0.0);
    Q[6] = Q_0_0;
    Q[7] = R(0.0);
    Q[8] = R(0.0);
    Q[9] = Q_0_3;
    Q[10] = R(0.0);
    Q[11] = Q_2_2;
    Q[12] = R(0.0);
    Q[13] = R(0.0);
    Q[14] = Q_2_5;
    Q[15] = Q_3_3;
    Q[16] = R(0.0);
    Q[17] = R(0.0);
    Q[18] = Q_3_3;
    Q[19] = R(0.0);
    Q[20] = Q_5_5;
}

RN_INLINE void rn_uwb_3d_driven_inject(real *x, const real *e)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_p_n_2 = x[2];
    const real s_v_n_0 = x[3];
    const real s_v_n_1 = x[4];
    const real s_v_n_2 = x[5];
    const real e_0 = e[0];
    const real e_1 = e[1];
    const real e_2 = e[2];
    const real e_3 = e[3];
    const real e_4 = e[4];
    const real e_5 = e[5];
    x[0] = e_0 + s_p_n_0;
    x[1] = e_1 + s_p_n_1;
    x[2] = e_2 + s_p_n_2;
    x[3] = e_3 + s_v_n_0;
    x[4] = e_4 + s_v_n_1;
    x[5] = e_5 + s_v_n_2;
}

RN_INLINE void rn_uwb_3d_driven_inject_turned(real *x, const real *e)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_p_n_2 = x[2];
    const real s_v_n_0 = x[3];
    const real s_v_n_1 = x[4];
    const real s_v_n_2 = x[5];
    const real e_0 = e[0];
    const real e_1 = e[1];
    const real e_2 = e[2];
    const real e_3 = e[3];
    const real e_4 = e[4];
    const real e_5 = e[5];
    x[0] = e_0 + s_p_n_0;
    x[1] = e_1 + s_p_n_1;
    x[2] = e_2 + s_p_n_2;
    x[3] = e_3 + s_v_n_0;
    x[4] = e_4 + s_v_n_1;
    x[5] = e_5 + s_v_n_2;
}

RN_INLINE void rn_uwb_3d_driven_difference(const real *a, const real *b, real *e)
{
    const real a_0 = a[0];
    const real a_1 = a[1];
    const real a_2 = a[2];
    const real a_3 = a[3];
    const real a_4 = a[4];
    const real a_5 = a[5];
    const real b_0 = b[0];
    const real b_1 = b[1];
    const real b_2 = b[2];
    const real b_3 = b[3];
    const real b_4 = b[4];
    const real b_5 = b[5];
    e[0] = a_0 - b_0;
    e[1] = a_1 - b_1;
    e[2] = a_2 - b_2;
    e[3] = a_3 - b_3;
    e[4] = a_4 - b_4;
    e[5] = a_5 - b_5;
}

RN_VECTORISED static void rn_uwb_3d_driven_carry(const real *a, const real *b, const real *u, const real *p, real dt, real *e)
{
    RN_UNUSED(p);
    const real u_accel_n_0 = u[0];
    const real u_accel_n_1 = u[1];
    const real u_accel_n_2 = u[2];
    const real a_0 = a[0];
    const real a_1 = a[1];
    const real a_2 = a[2];
    const real a_3 = a[3];
    const real a_4 = a[4];
    const real a_5 = a[5];
    const real b_0 = b[0];
    const real b_1 = b[1];
    const real b_2 = b[2];
    const real b_3 = b[3];
    const real b_4 = b[4];
    const real b_5 = b[5];
    for (int k = 0; k < 12; k++) {
        const real e_0 = e[0 + k];
        const real e_1 = e[12 + k];
        const real e_2 = e[24 + k];
        const real e_3 = e[36 + k];
        const real e_4 = e[48 + k];
        const real e_5 = e[60 + k];
        const real s_v_n_0 = a_3 + e_3;
        const real t_0 = dt * u_accel_n_0;
        const real m_3 = R(0.5) * t_0 + s_v_n_0;
        const real s_p_n_0 = a_0 + e_0;
        const real s_v_n_1 = a_4 + e_4;
        const real t_1 = dt * u_accel_n_1;
        const real m_4 = R(0.5) * t_1 + s_v_n_1;
        const real s_p_n_1 = a_1 + e_1;
        const real s_v_n_2 = a_5 + e_5;
        const real t_2 = dt * u_accel_n_2;
        const real m_5 = R(0.5) * t_2 + s_v_n_2;
        const real s_p_n_2 = a_2 + e_2;
        e[0 + k] = dt * m_3 + s_p_n_0 - b_0;
        e[12 + k] = dt * m_4 + s_p_n_1 - b_1;
        e[24 + k] = dt * m_5 + s_p_n_2 - b_2;
        e[36 + k] = s_v_n_0 + t_0 - b_3;
        e[48 + k] = s_v_n_1 + t_1 - b_4;
        e[60 + k] = s_v_n_2 + t_2 - b_5;
    }
}

RN_INLINE void rn_uwb_3d_driven_measure_range(const real *x, const real *z, const real *p, real *h)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_p_n_2 = x[2];
    const real s_v_n_0 = x[3];
    const real s_v_n_1 = x[4];
    const real s_v_n_2 = x[5];
    const real p_time_offset = p[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real z_3 = z[3];
    h[0] = rn_sqrt((((s_p_n_0 - p_time_offset * s_v_n_0 - z_1) * (s_p_n_0 - p_time_offset * s_v_n_0 - z_1)) + ((s_p_n_1 - p_time_offset * s_v_n_1 - z_2) * (s_p_n_1 - p_time_offset * s_v_n_1 - z_2)) + ((s_p_n_2 - p_time_offset * s_v_n_2 - z_3) * (s_p_n_2 - p_time_offset * s_v_n_2 - z_3))));
}

RN_INLINE void rn_uwb_3d_driven_residual_range(const real *x, const real *z, const real *p, real *r)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_p_n_2 = x[2];
    const real s_v_n_0 = x[3];
    const real s_v_n_1 = x[4];
    const real s_v_n_2 = x[5];
    const real p_time_offset = p[0];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real z_3 = z[3];
    r[0] = z_0 - rn_sqrt((((s_p_n_0 - p_time_offset * s_v_n_0 - z_1) * (s_p_n_0 - p_time_offset * s_v_n_0 - z_1)) + ((s_p_n_1 - p_time_offset * s_v_n_1 - z_2) * (s_p_n_1 - p_time_offset * s_v_n_1 - z_2)) + ((s_p_n_2 - p_time_offset * s_v_n_2 - z_3) * (s_p_n_2 - p_time_offset * s_v_n_2 - z_3))));
}

RN_INLINE void rn_uwb_3d_driven_jacobian_range(const real *x, const real *z, const real *p, real *H)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_p_n_2 = x[2];
    const real s_v_n_0 = x[3];
    const real s_v_n_1 = x[4];
    const real s_v_n_2 = x[5];
    const real p_time_offset = p[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real z_3 = z[3];
    const real t_0 = s_p_n_0 - p_time_offset * s_v_n_0 - z_1;
    const real t_1 = s_p_n_1 - p_time_offset * s_v_n_1 - z_2;
    const real t_2 = s_p_n_2 - p_time_offset * s_v_n_2 - z_3;
    const real t_3 = R(1.0) / rn_sqrt(((t_0 * t_0) + (t_1 * t_1) + (t_2 * t_2)));
    const real t_4 = t_0 * t_3;
    const real t_5 = t_1 * t_3;
    const real t_6 = t_2 * t_3;
    H[0] = t_4;
    H[1] = t_5;
    H[2] = t_6;
    H[3] = -(p_time_offset * t_4);
    H[4] = -(p_time_offset * t_5);
    H[5] = -(p_time_offset * t_6);
}

RN_INLINE void rn_uwb_3d_driven_innovation_range(const real *x, const real *z, const real *p, real *r)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_p_n_2 = x[2];
    const real s_v_n_0 = x[3];
    const real s_v_n_1 = x[4];
    const real s_v_n_2 = x[5];
    const real p_time_offset = p[0];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real z_3 = z[3];
    r[0] = z_0 - rn_sqrt((((s_p_n_0 - p_time_offset * s_v_n_0 - z_1) * (s_p_n_0 - p_time_offset * s_v_n_0 - z_1)) + ((s_p_n_1 - p_time_offset * s_v_n_1 - z_2) * (s_p_n_1 - p_time_offset * s_v_n_1 - z_2)) + ((s_p_n_2 - p_time_offset * s_v_n_2 - z_3) * (s_p_n_2 - p_time_offset * s_v_n_2 - z_3))));
}

RN_INLINE real rn_uwb_3d_driven_update_range(real *x, real *P, const real *z, real variance, RN(rule) rule, const real *p, real *nu, real *s, real *nis)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_p_n_2 = x[2];
    const real s_v_n_0 = x[3];
    const real s_v_n_1 = x[4];
    const real s_v_n_2 = x[5];
    const real p_time_offset = p[0];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real z_3 = z[3];
    const real t_0 = s_p_n_0 - p_time_offset * s_v_n_0 - z_1;
    const real t_1 = s_p_n_1 - p_time_offset * s_v_n_1 - z_2;
    const real t_2 = s_p_n_2 - p_time_offset * s_v_n_2 - z_3;
    const real t_3 = rn_sqrt(((t_0 * t_0) + (t_1 * t_1) + (t_2 * t_2)));
    const real t_4 = R(1.0) / t_3;
    const real t_5 = t_0 * t_4;
    const real t_6 = t_1 * t_4;
    const real t_7 = t_2 * t_4;
    const real r_0 = z_0 - t_3;
    const real H_0_0 = t_5;
    const real H_0_1 = t_6;
    const real H_0_2 = t_7;
    const real H_0_3 = -(p_time_offset * t_5);
    const real H_0_4 = -(p_time_offset * t_6);
    const real H_0_5 = -(p_time_offset * t_7);
    real L[21], dx[6];
    int refused = 0;
    memcpy(L, P, sizeof L);
    for (int i = 0; i < 6; i++) dx[i] = R(0.0);
    *nis = R(0.0);
    {
        const real PH[6] = {H_0_0 * L[0] + H_0_1 * L[1] + H_0_2 * L[2] + H_0_3 * L[3] + H_0_4 * L[4] + H_0_5 * L[5], H_0_0 * L[1] + H_0_1 * L[6] + H_0_2 * L[7] + H_0_3 * L[8] + H_0_4 * L[9] + H_0_5 * L[10], H_0_0 * L[2] + H_0_1 * L[7] + H_0_2 * L[11] + H_0_3 * L[12] + H_0_4 * L[13] + H_0_5 * L[14], H_0_0 * L[3] + H_0_1 * L[8] + H_0_2 * L[12] + H_0_3 * L[15] + H_0_4 * L[16] + H_0_5 * L[17], H_0_0 * L[4] + H_0_1 * L[9] + H_0_2 * L[13] + H_0_3 * L[16] + H_0_4 * L[18] + H_0_5 * L[19], H_0_0 * L[5] + H_0_1 * L[10] + H_0_2 * L[14] + H_0_3 * L[17] + H_0_4 * L[19] + H_0_5 * L[20]};
        s[0] = variance + H_0_0 * PH[0] + H_0_1 * PH[1] + H_0_2 * PH[2] + H_0_3 * PH[3] + H_0_4 * PH[4] + H_0_5 * PH[5];
        nu[0] = r_0 - (H_0_0 * dx[0] + H_0_1 * dx[1] + H_0_2 * dx[2] + H_0_3 * dx[3] + H_0_4 * dx[4] + H_0_5 * dx[5]);
        refused += rn_scalar_update(L, dx, PH, 6, s[0], variance, nu[0], nis);
    }
    const real weight = refused ? R(0.0) : rn_weight(rule, *nis, R(1.0));
    if (!(weight > R(0.0))) return R(0.0);
    if (weight < R(1.0)) rn_soften(L, P, 21, dx, 6, weight);
    memcpy(P, L, sizeof L);
    rn_uwb_3d_driven_inject(x, dx);
    return weight;
}

RN_INLINE void rn_uwb_3d_driven_measure_tdoa(const real *x, const real *z, const real *p, real *h)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_p_n_2 = x[2];
    const real s_v_n_0 = x[3];
    const real s_v_n_1 = x[4];
    const real s_v_n_2 = x[5];
    const real p_time_offset = p[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real z_3 = z[3];
    const real z_4 = z[4];
    const real z_5 = z[5];
    const real z_6 = z[6];
    const real t_0 = s_p_n_0 - p_time_offset * s_v_n_0;
    const real t_1 = s_p_n_1 - p_time_offset * s_v_n_1;
    const real t_2 = s_p_n_2 - p_time_offset * s_v_n_2;
    h[0] = rn_sqrt((((t_0 - z_4) * (t_0 - z_4)) + ((t_1 - z_5) * (t_1 - z_5)) + ((t_2 - z_6) * (t_2 - z_6)))) - rn_sqrt((((t_0 - z_1) * (t_0 - z_1)) + ((t_1 - z_2) * (t_1 - z_2)) + ((t_2 - z_3) * (t_2 - z_3))));
}

RN_INLINE void rn_uwb_3d_driven_residual_tdoa(const real *x, const real *z, const real *p, real *r)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_p_n_2 = x[2];
    const real s_v_n_0 = x[3];
    const real s_v_n_1 = x[4];
    const real s_v_n_2 = x[5];
    const real p_time_offset = p[0];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real z_3 = z[3];
    const real z_4 = z[4];
    const real z_5 = z[5];
    const real z_6 = z[6];
    const real t_0 = s_p_n_0 - p_time_offset * s_v_n_0;
    const real t_1 = s_p_n_1 - p_time_offset * s_v_n_1;
    const real t_2 = s_p_n_2 - p_time_offset * s_v_n_2;
    r[0] = z_0 - ((rn_sqrt((((t_0 - z_4) * (t_0 - z_4)) + ((t_1 - z_5) * (t_1 - z_5)) + ((t_2 - z_6) * (t_2 - z_6)))) - rn_sqrt((((t_0 - z_1) * (t_0 - z_1)) + ((t_1 - z_2) * (t_1 - z_2)) + ((t_2 - z_3) * (t_2 - z_3))))));
}

RN_INLINE void rn_uwb_3d_driven_jacobian_tdoa(const real *x, const real *z, const real *p, real *H)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_p_n_2 = x[2];
    const real s_v_n_0 = x[3];
    const real s_v_n_1 = x[4];
    const real s_v_n_2 = x[5];
    const real p_time_offset = p[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real z_3 = z[3];
    const real z_4 = z[4];
    const real z_5 = z[5];
    const real z_6 = z[6];
    const real t_0 = s_p_n_0 - p_time_offset * s_v_n_0;
    const real t_1 = t_0 - z_1;
    const real t_2 = s_p_n_1 - p_time_offset * s_v_n_1;
    const real t_3 = t_2 - z_2;
    const real t_4 = s_p_n_2 - p_time_offset * s_v_n_2;
    const real t_5 = t_4 - z_3;
    const real t_6 = R(1.0) / rn_sqrt(((t_1 * t_1) + (t_3 * t_3) + (t_5 * t_5)));
    const real t_7 = t_1 * t_6;
    const real t_8 = t_0 - z_4;
    const real t_9 = t_2 - z_5;
    const real t_10 = t_4 - z_6;
    const real t_11 = R(1.0) / rn_sqrt(((t_10 * t_10) + (t_8 * t_8) + (t_9 * t_9)));
    const real t_12 = t_11 * t_8;
    const real t_13 = t_3 * t_6;
    const real t_14 = t_11 * t_9;
    const real t_15 = t_5 * t_6;
    const real t_16 = t_10 * t_11;
    H[0] = t_12 - t_7;
    H[1] = t_14 - t_13;
    H[2] = t_16 - t_15;
    H[3] = p_time_offset * t_7 - p_time_offset * t_12;
    H[4] = p_time_offset * t_13 - p_time_offset * t_14;
    H[5] = p_time_offset * t_15 - p_time_offset * t_16;
}

RN_INLINE void rn_uwb_3d_driven_innovation_tdoa(const real *x, const real *z, const real *p, real *r)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_p_n_2 = x[2];
    const real s_v_n_0 = x[3];
    const real s_v_n_1 = x[4];
    const real s_v_n_2 = x[5];
    const real p_time_offset = p[0];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real z_3 = z[3];
    const real z_4 = z[4];
    const real z_5 = z[5];
    const real z_6 = z[6];
    const real t_0 = s_p_n_0 - p_time_offset * s_v_n_0;
    const real t_1 = s_p_n_1 - p_time_offset * s_v_n_1;
    const real t_2 = s_p_n_2 - p_time_offset * s_v_n_2;
    r[0] = z_0 - ((rn_sqrt((((t_0 - z_4) * (t_0 - z_4)) + ((t_1 - z_5) * (t_1 - z_5)) + ((t_2 - z_6) * (t_2 - z_6)))) - rn_sqrt((((t_0 - z_1) * (t_0 - z_1)) + ((t_1 - z_2) * (t_1 - z_2)) + ((t_2 - z_3) * (t_2 - z_3))))));
}

RN_INLINE real rn_uwb_3d_driven_update_tdoa(real *x, real *P, const real *z, real variance, RN(rule) rule, const real *p, real *nu, real *s, real *nis)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_p_n_2 = x[2];
    const real s_v_n_0 = x[3];
    const real s_v_n_1 = x[4];
    const real s_v_n_2 = x[5];
    const real p_time_offset = p[0];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real z_3 = z[3];
    const real z_4 = z[4];
    const real z_5 = z[5];
    const real z_6 = z[6];
    const real t_0 = s_p_n_0 - p_time_offset * s_v_n_0;
    const real t_1 = t_0 - z_4;
    const real t_2 = s_p_n_1 - p_time_offset * s_v_n_1;
    const real t_3 = t_2 - z_5;
    const real t_4 = s_p_n_2 - p_time_offset * s_v_n_2;
    const real t_5 = t_4 - z_6;
    const real t_6 = rn_sqrt(((t_1 * t_1) + (t_3 * t_3) + (t_5 * t_5)));
    const real t_7 = t_0 - z_1;
    const real t_8 = t_2 - z_2;
    const real t_9 = t_4 - z_3;
    const real t_10 = rn_sqrt(((t_7 * t_7) + (t_8 * t_8) + (t_9 * t_9)));
    const real t_11 = R(1.0) / t_10;
    const real t_12 = t_11 * t_7;
    const real t_13 = R(1.0) / t_6;
    const real t_14 = t_1 * t_13;
    const real t_15 = t_11 * t_8;
    const real t_16 = t_13 * t_3;
    const real t_17 = t_11 * t_9;
    const real t_18 = t_13 * t_5;
    const real r_0 = z_0 - ((t_6 - t_10));
    const real H_0_0 = t_14 - t_12;
    const real H_0_1 = t_16 - t_15;
    const real H_0_2 = t_18 - t_17;
    const real H_0_3 = p_time_offset * t_12 - p_time_offset * t_14;
    const real H_0_4 = p_time_offset * t_15 - p_time_offset * t_16;
    const real H_0_5 = p_time_offset * t_17 - p_time_offset * t_18;
    real L[21], dx[6];
    int refused = 0;
    memcpy(L, P, sizeof L);
    for (int i = 0; i < 6; i++) dx[i] = R(0.0);
    *nis = R(0.0);
    {
        const real PH[6] = {H_0_0 * L[0] + H_0_1 * L[1] + H_0_2 * L[2] + H_0_3 * L[3] + H_0_4 * L[4] + H_0_5 * L[5], H_0_0 * L[1] + H_0_1 * L[6] + H_0_2 * L[7] + H_0_3 * L[8] + H_0_4 * L[9] + H_0_5 * L[10], H_0_0 * L[2] + H_0_1 * L[7] + H_0_2 * L[11] + H_0_3 * L[12] + H_0_4 * L[13] + H_0_5 * L[14], H_0_0 * L[3] + H_0_1 * L[8] + H_0_2 * L[12] + H_0_3 * L[15] + H_0_4 * L[16] + H_0_5 * L[17], H_0_0 * L[4] + H_0_1 * L[9] + H_0_2 * L[13] + H_0_3 * L[16] + H_0_4 * L[18] + H_0_5 * L[19], H_0_0 * L[5] + H_0_1 * L[10] + H_0_2 * L[14] + H_0_3 * L[17] + H_0_4 * L[19] + H_0_5 * L[20]};
        s[0] = variance + H_0_0 * PH[0] + H_0_1 * PH[1] + H_0_2 * PH[2] + H_0_3 * PH[3] + H_0_4 * PH[4] + H_0_5 * PH[5];
        nu[0] = r_0 - (H_0_0 * dx[0] + H_0_1 * dx[1] + H_0_2 * dx[2] + H_0_3 * dx[3] + H_0_4 * dx[4] + H_0_5 * dx[5]);
        refused += rn_scalar_update(L, dx, PH, 6, s[0], variance, nu[0], nis);
    }
    const real weight = refused ? R(0.0) : rn_weight(rule, *nis, R(1.0));
    if (!(weight > R(0.0))) return R(0.0);
    if (weight < R(1.0)) rn_soften(L, P, 21, dx, 6, weight);
    memcpy(P, L, sizeof L);
    rn_uwb_3d_driven_inject(x, dx);
    return weight;
}

RN_INLINE void rn_uwb_3d_driven_measure_position(const real *x, const real *z, const real *p, real *h)
{
    RN_UNUSED(z);
    RN_UNUSED(p);
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_p_n_2 = x[2];
    h[0] = s_p_n_0;
    h[1] = s_p_n_1;
    h[2] = s_p_n_2;
}

RN_INLINE void rn_uwb_3d_driven_residual_position(const real *x, const real *z, const real *p, real *r)
{
    RN_UNUSED(p);
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_p_n_2 = x[2];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    r[0] = z_0 - s_p_n_0;
    r[1] = z_1 - s_p_n_1;
    r[2] = z_2 - s_p_n_2;
}

RN_INLINE void rn_uwb_3d_driven_jacobian_position(const real *x, const real *z, const real *p, real *H)
{
    RN_UNUSED(x);
    RN_UNUSED(z);
    RN_UNUSED(p);
    H[0] = R(1.0);
    H[1] = R(0.0);
    H[2] = R(0.0);
    H[3] = R(0.0);
    H[4] = R(0.0);
    H[5] = R(0.0);
    H[6] = R(0.0);
    H[7] = R(1.0);
    H[8] = R(0.0);
    H[9] = R(0.0);
    H[10] = R(0.0);
    H[11] = R(0.0);
    H[12] = R(0.0);
    H[13] = R(0.0);
    H[14] = R(1.0);
    H[15] = R(0.0);
    H[16] = R(0.0);
    H[17] = R(0.0);
}

RN_INLINE void rn_uwb_3d_driven_innovation_position(const real *x, const real *z, const real *p, real *r)
{
    RN_UNUSED(p);
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_p_n_2 = x[2];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    r[0] = z_0 - s_p_n_0;
    r[1] = z_1 - s_p_n_1;
    r[2] = z_2 - s_p_n_2;
}

RN_INLINE real rn_uwb_3d_driven_update_position(real *x, real *P, const real *z, real variance, RN(rule) rule, const real *p, real *nu, real *s, real *nis)
{
    RN_UNUSED(p);
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_p_n_2 = x[2];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real r_0 = z_0 - s_p_n_0;
    const real r_1 = z_1 - s_p_n_1;
    const real r_2 = z_2 - s_p_n_2;
    const real H_0_0 = R(1.0);
    const real H_1_1 = R(1.0);
    const real H_2_2 = R(1.0);
    real L[21], dx[6];
    int refused = 0;
    memcpy(L, P, sizeof L);
    for (int i = 0; i < 6; i++) dx[i] = R(0.0);
    *nis = R(0.0);
    {
        const real PH[6] = {H_0_0 * L[0], H_0_0 * L[1], H_0_0 * L[2], H_0_0 * L[3], H_0_0 * L[4], H_0_0 * L[5]};
        s[0] = variance + H_0_0 * PH[0];
        nu[0] = r_0 - (H_0_0 * dx[0]);
        refused += rn_scalar_update(L, dx, PH, 6, s[0], variance, nu[0], nis);
    }
    {
        const real PH[6] = {H_1_1 * L[1], H_1_1 * L[6], H_1_1 * L[7], H_1_1 * L[8], H_1_1 * L[9], H_1_1 * L[10]};
        s[1] = variance + H_1_1 * PH[1];
        nu[1] = r_1 - (H_1_1 * dx[1]);
        refused += rn_scalar_update(L, dx, PH, 6, s[1], variance, nu[1], nis);
    }
    {
        const real PH[6] = {H_2_2 * L[2], H_2_2 * L[7], H_2_2 * L[11], H_2_2 * L[12], H_2_2 * L[13], H_2_2 * L[14]};
        s[2] = variance + H_2_2 * PH[2];
        nu[2] = r_2 - (H_2_2 * dx[2]);
        refused += rn_scalar_update(L, dx, PH, 6, s[2], variance, nu[2], nis);
    }
    const real weight = refused ? R(0.0) : rn_weight(rule, *nis, R(3.0));
    if (!(weight > R(0.0))) return R(0.0);
    if (weight < R(1.0)) rn_soften(L, P, 21, dx, 6, weight);
    memcpy(P, L, sizeof L);
    rn_uwb_3d_driven_inject(x, dx);
    return weight;
}

RN_INLINE void rn_uwb_3d_driven_measure_height(const real *x, const real *z, const real *p, real *h)
{
    RN_UNUSED(z);
    RN_UNUSED(p);
    const real s_p_n_2 = x[2];
    h[0] = -s_p_n_2;
}

RN_INLINE void rn_uwb_3d_driven_residual_height(const real *x, const real *z, const real *p, real *r)
{
    RN_UNUSED(p);
    const real s_p_n_2 = x[2];
    const real z_0 = z[0];
    r[0] = s_p_n_2 + z_0;
}

RN_INLINE void rn_uwb_3d_driven_jacobian_height(const real *x, const real *z, const real *p, real *H)
{
    RN_UNUSED(x);
    RN_UNUSED(z);
    RN_UNUSED(p);
    H[0] = R(0.0);
    H[1] = R(0.0);
    H[2] = R(-1.0);
    H[3] = R(0.0);
    H[4] = R(0.0);
    H[5] = R(0.0);
}

RN_INLINE void rn_uwb_3d_driven_innovation_height(const real *x, const real *z, const real *p, real *r)
{
    RN_UNUSED(p);
    const real s_p_n_2 = x[2];
    const real z_0 = z[0];
    r[0] = s_p_n_2 + z_0;
}

RN_INLINE real rn_uwb_3d_driven_update_height(real *x, real *P, const real *z, real variance, RN(rule) rule, const real *p, real *nu, real *s, real *nis)
{
    RN_UNUSED(p);
    const real s_p_n_2 = x[2];
    const real z_0 = z[0];
    const real r_0 = s_p_n_2 + z_0;
    const real H_0_2 = R(-1.0);
    real L[21], dx[6];
    int refused = 0;
    memcpy(L, P, sizeof L);
    for (int i = 0; i < 6; i++) dx[i] = R(0.0);
    *nis = R(0.0);
    {
        const real PH[6] = {H_0_2 * L[2], H_0_2 * L[7], H_0_2 * L[11], H_0_2 * L[12], H_0_2 * L[13], H_0_2 * L[14]};
        s[0] = variance + H_0_2 * PH[2];
        nu[0] = r_0 - (H_0_2 * dx[2]);
        refused += rn_scalar_update(L, dx, PH, 6, s[0], variance, nu[0], nis);
    }
    const real weight = refused ? R(0.0) : rn_weight(rule, *nis, R(1.0));
    if (!(weight > R(0.0))) return R(0.0);
    if (weight < R(1.0)) rn_soften(L, P, 21, dx, 6, weight);
    memcpy(P, L, sizeof L);
    rn_uwb_3d_driven_inject(x, dx);
    return weight;
}

RN_INLINE void rn_uwb_3d_driven_gain(const real *K, const real *r, real *e)
{
    e[0] = K[0] * r[0] + K[1] * r[1] + K[2] * r[2] + K[3] * r[3] + K[4] * r[4] + K[5] * r[5];
    e[1] = K[6] * r[0] + K[7] * r[1] + K[8] * r[2] + K[9] * r[3] + K[10] * r[4] + K[11] * r[5];
    e[2] = K[12] * r[0] + K[13] * r[1] + K[14] * r[2] + K[15] * r[3] + K[16] * r[4] + K[17] * r[5];
    e[3] = K[18] * r[0] + K[19] * r[1] + K[20] * r[2] + K[21] * r[3] + K[22] * r[4] + K[23] * r[5];
    e[4] = K[24] * r[0] + K[25] * r[1] + K[26] * r[2] + K[27] * r[3] + K[28] * r[4] + K[29] * r[5];
    e[5] = K[30] * r[0] + K[31] * r[1] + K[32] * r[2] + K[33] * r[3] + K[34] * r[4] + K[35] * r[5];
}

RN_INLINE void rn_uwb_3d_driven_correct(real *x, const real *z, const real *K, const real *p, real *r)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_p_n_2 = x[2];
    const real s_v_n_0 = x[3];
    const real s_v_n_1 = x[4];
    const real s_v_n_2 = x[5];
    const real p_time_offset = p[0];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real z_3 = z[3];
    const real z_4 = z[4];
    const real z_5 = z[5];
    const real z_6 = z[6];
    const real z_7 = z[7];
    const real z_8 = z[8];
    const real z_9 = z[9];
    const real z_10 = z[10];
    const real z_11 = z[11];
    const real z_12 = z[12];
    const real z_13 = z[13];
    const real z_14 = z[14];
    const real K_0 = K[0];
    const real K_1 = K[1];
    const real K_2 = K[2];
    const real K_3 = K[3];
    const real K_4 = K[4];
    const real K_5 = K[5];
    const real K_6 = K[6];
    const real K_7 = K[7];
    const real K_8 = K[8];
    const real K_9 = K[9];
    const real K_10 = K[10];
    const real K_11 = K[11];
    const real K_12 = K[12];
    const real K_13 = K[13];
    const real K_14 = K[14];
    const real K_15 = K[15];
    const real K_16 = K[16];
    const real K_17 = K[17];
    const real K_18 = K[18];
    const real K_19 = K[19];
    const real K_20 = K[20];
    const real K_21 = K[21];
    const real K_22 = K[22];
    const real K_23 = K[23];
    const real K_24 = K[24];
    const real K_25 = K[25];
    const real K_26 = K[26];
    const real K_27 = K[27];
    const real K_28 = K[28];
    const real K_29 = K[29];
    const real K_30 = K[30];
    const real K_31 = K[31];
    const real K_32 = K[32];
    const real K_33 = K[33];
    const real K_34 = K[34];
    const real K_35 = K[35];
    const real t_0 = s_p_n_0 - p_time_offset * s_v_n_0;
    const real t_1 = s_p_n_1 - p_time_offset * s_v_n_1;
    const real t_2 = s_p_n_2 - p_time_offset * s_v_n_2;
    const real r_0 = z_0 - rn_sqrt((((t_0 - z_1) * (t_0 - z_1)) + ((t_1 - z_2) * (t_1 - z_2)) + ((t_2 - z_3) * (t_2 - z_3))));
    const real r_1 = z_4 - ((rn_sqrt((((t_0 - z_8) * (t_0 - z_8)) + ((t_1 - z_9) * (t_1 - z_9)) + ((t_2 - z_10) * (t_2 - z_10)))) - rn_sqrt((((t_0 - z_5) * (t_0 - z_5)) + ((t_1 - z_6) * (t_1 - z_6)) + ((t_2 - z_7) * (t_2 - z_7))))));
    const real r_2 = z_11 - s_p_n_0;
    const real r_3 = z_12 - s_p_n_1;
    const real r_4 = z_13 - s_p_n_2;
    const real r_5 = s_p_n_2 + z_14;
    const real de_0 = K_0 * r_0 + K_1 * r_1 + K_2 * r_2 + K_3 * r_3 + K_4 * r_4 + K_5 * r_5;
    const real de_1 = K_6 * r_0 + K_7 * r_1 + K_8 * r_2 + K_9 * r_3 + K_10 * r_4 + K_11 * r_5;
    const real de_2 = K_12 * r_0 + K_13 * r_1 + K_14 * r_2 + K_15 * r_3 + K_16 * r_4 + K_17 * r_5;
    const real de_3 = K_18 * r_0 + K_19 * r_1 + K_20 * r_2 + K_21 * r_3 + K_22 * r_4 + K_23 * r_5;
    const real de_4 = K_24 * r_0 + K_25 * r_1 + K_26 * r_2 + K_27 * r_3 + K_28 * r_4 + K_29 * r_5;
    const real de_5 = K_30 * r_0 + K_31 * r_1 + K_32 * r_2 + K_33 * r_3 + K_34 * r_4 + K_35 * r_5;
    x[0] = de_0 + s_p_n_0;
    x[1] = de_1 + s_p_n_1;
    x[2] = de_2 + s_p_n_2;
    x[3] = de_3 + s_v_n_0;
    x[4] = de_4 + s_v_n_1;
    x[5] = de_5 + s_v_n_2;
    r[0] = r_0;
    r[1] = r_1;
    r[2] = r_2;
    r[3] = r_3;
    r[4] = r_4;
    r[5] = r_5;
}

static const RN(sensor) rn_uwb_3d_driven_sensors[] = {
    {"range", 1, 4, 1, 6, rn_uwb_3d_driven_measure_range, rn_uwb_3d_driven_residual_range, rn_uwb_3d_driven_jacobian_range, rn_uwb_3d_driven_innovation_range, rn_uwb_3d_driven_update_range},
    {"tdoa", 1, 7, 1, 6, rn_uwb_3d_driven_measure_tdoa, rn_uwb_3d_driven_residual_tdoa, rn_uwb_3d_driven_jacobian_tdoa, rn_uwb_3d_driven_innovation_tdoa, rn_uwb_3d_driven_update_tdoa},
    {"position", 3, 3, 3, 3, rn_uwb_3d_driven_measure_position, rn_uwb_3d_driven_residual_position, rn_uwb_3d_driven_jacobian_position, rn_uwb_3d_driven_innovation_position, rn_uwb_3d_driven_update_position},
    {"height", 1, 1, 1, 3, rn_uwb_3d_driven_measure_height, rn_uwb_3d_driven_residual_height, rn_uwb_3d_driven_jacobian_height, rn_uwb_3d_driven_innovation_height, rn_uwb_3d_driven_update_height}};
static const RN(model) rn_uwb_3d_driven_model = {
    RN_ABI, (int)sizeof(real), "uwb_3d_driven", 6, 6, 3, 2, 1, 4, 6, rn_uwb_3d_driven_sensors,
    rn_uwb_3d_driven_propagate, rn_uwb_3d_driven_predict, rn_uwb_3d_driven_transition, rn_uwb_3d_driven_noise, rn_uwb_3d_driven_inject, rn_uwb_3d_driven_inject_turned, rn_uwb_3d_driven_difference, rn_uwb_3d_driven_carry, rn_uwb_3d_driven_gain, rn_uwb_3d_driven_correct};

#endif
