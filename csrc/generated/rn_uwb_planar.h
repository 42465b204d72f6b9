/* Generated from the model 'uwb_planar'; do not edit: make generate. */
/* clang-format off */
#ifndef RN_GENERATED_UWB_PLANAR_H
#define RN_GENERATED_UWB_PLANAR_H
#include "rn_model.h"
#include "rn_update.h"

/* state, error (quaternions: small rotation, rad), input, parameters:
 *   x[0..1], e[0..1]  p_n [m]
 *   x[2..3], e[2..3]  v_n [m/s]
 *   x[4..4], e[4..4]  yaw [rad]
 *   x[5..5], e[5..5]  yaw_rate [rad/s]
 *   p[0]  body_down
 *   p[1]  time_offset
 *   reading range: z[0..0] [m]
 *     z[1..3]  p_anchor [m]
 *     z[4..6]  range_lever_b [m]
 *     z[7..10]  range_pattern [m]
 *   q[0]  intensity of acceleration [(m/s^2/sqrt(Hz))^2]
 *   q[1]  intensity of yaw_acceleration [(rad/s^2/sqrt(Hz))^2] */

RN_INLINE void rn_uwb_planar_propagate(real *x, const real *u, const real *p, real dt)
{
    RN_UNUSED(u);
    RN_UNUSED(p);
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real s_yaw_0 = x[4];
    const real s_yaw_rate_0 = x[5];
    const real t_0 = dt * s_v_n_0;
    const real t_1 = dt * s_v_n_1;
    const real t_2 = dt * s_yaw_rate_0;
    x[0] = s_p_n_0 + t_0;
    x[1] = s_p_n_1 + t_1;
    x[2] = s_v_n_0;
    x[3] = s_v_n_1;
    x[4] = s_yaw_0 + t_2;
    x[5] = s_yaw_rate_0;
}

RN_INLINE void rn_uwb_planar_predict(real *x, real *P, const real *u, const real *q, const real *p, real dt)
{
    RN_UNUSED(u);
    RN_UNUSED(p);
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real s_yaw_0 = x[4];
    const real s_yaw_rate_0 = x[5];
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
    const real t_0 = dt * s_v_n_0;
    const real t_1 = dt * s_v_n_1;
    const real t_2 = dt * s_yaw_rate_0;
    const real t_3 = R(0.3333333333333333) * (dt * dt * dt);
    const real Q_0_0 = q_0 * t_3;
    const real T_0_0 = P_0_0 + P_0_2 * dt;
    const real T_0_2 = P_0_2 + P_2_2 * dt;
    const real T_0_1 = P_0_1 + P_1_2 * dt;
    const real t_4 = P_2_3 * dt;
    const real T_0_3 = P_0_3 + t_4;
    const real t_5 = R(0.5) * (dt * dt);
    const real Q_0_2 = q_0 * t_5;
    const real T_0_4 = P_0_4 + P_2_4 * dt;
    const real t_6 = P_2_5 * dt;
    const real T_0_5 = P_0_5 + t_6;
    const real T_1_1 = P_1_1 + P_1_3 * dt;
    const real T_1_3 = P_1_3 + P_3_3 * dt;
    const real T_1_2 = P_1_2 + t_4;
    const real T_1_4 = P_1_4 + P_3_4 * dt;
    const real t_7 = P_3_5 * dt;
    const real T_1_5 = P_1_5 + t_7;
    const real Q_2_2 = dt * q_0;
    const real T_4_2 = P_2_4 + t_6;
    const real T_4_3 = P_3_4 + t_7;
    const real Q_4_4 = q_1 * t_3;
    const real T_4_4 = P_4_4 + P_4_5 * dt;
    const real T_4_5 = P_4_5 + P_5_5 * dt;
    const real Q_4_5 = q_1 * t_5;
    const real Q_5_5 = dt * q_1;
    x[0] = s_p_n_0 + t_0;
    x[1] = s_p_n_1 + t_1;
    x[2] = s_v_n_0;
    x[3] = s_v_n_1;
    x[4] = s_yaw_0 + t_2;
    x[5] = s_yaw_rate_0;
    P[0] = Q_0_0 + T_0_0 + T_0_2 * dt;
    P[1] = T_0_1 + T_0_3 * dt;
    P[2] = Q_0_2 + T_0_2;
    P[3] = T_0_3;
    P[4] = T_0_4 + T_0_5 * dt;
    P[5] = T_0_5;
    P[6] = Q_0_0 + T_1_1 + T_1_3 * dt;
    P[7] = T_1_2;
    P[8] = Q_0_2 + T_1_3;
    P[9] = T_1_4 + T_1_5 * dt;
    P[10] = T_1_5;
    P[11] = P_2_2 + Q_2_2;
    P[12] = P_2_3;
    P[13] = T_4_2;
    P[14] = P_2_5;
    P[15] = P_3_3 + Q_2_2;
    P[16] = T_4_3;
    P[17] = P_3_5;
    P[18] = Q_4_4 + T_4_4 + T_4_5 * dt;
    P[19] = Q_4_5 + T_4_5;
    P[20] = P_5_5 + Q_5_5;
}

RN_INLINE void rn_uwb_planar_transition(const real *x, const real *u, const real *q, const real *p, real dt, real *F, real *Q)
{
    RN_UNUSED(x);
    RN_UNUSED(u);
    RN_UNUSED(p);
    const real q_0 = q[0];
    const real q_1 = q[1];
    const real t_0 = R(0.3333333333333333) * (dt * dt * dt);
    const real Q_0_0 = q_0 * t_0;
    const real t_1 = R(0.5) * (dt * dt);
    const real Q_0_2 = q_0 * t_1;
    const real Q_2_2 = dt * q_0;
    const real Q_4_4 = q_1 * t_0;
    const real Q_4_5 = q_1 * t_1;
    const real Q_5_5 = dt * q_1;
    F[0] = R(1.0);
    F[1] = R(0.0);
    F[2] = dt;
    F[3] = R(0.0);
    F[4] = R(0.0);
    F[5] = R(0.0);
    F[6] = R(0.0);
    F[7] = R(1.0);
    F[8] = R(0.0);
    F[9] = dt;
    F[10] = R(0.0);
    F[11] = R(0.0);
    F[12] = R(0.0);
    F[13] = R(0.0);
    F[14] = R(1.0);
    F[15] = R(0.0);
    F[16] = R(0.0);
    F[17] = R(0.0);
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
    F[29] = dt;
    F[30] = R(0.0);
    F[31] = R(0.0);
    F[32] = R(0.0);
    F[33] = R(0.0);
    F[34] = R(0.0);
    F[35] = R(1.0);
    Q[0] = Q_0_0;
    Q[1] = R(0.0);
    Q[2] = Q_0_2;
    Q[3] = R(0.0);
    Q[4] = R(0.0);
    Q[5] = R(0.0);
    Q[6] = R(0.0);
    Q[7] = Q_0_0;
    Q[8] = R(0.0);
    Q[9] = Q_0_2;
    Q[10] = R(0.0);
    Q[11] = R(0.0);
    Q[12] = Q_0_2;
    Q[13] = R(0.0);
    Q[14] = Q_2_2;
    Q[15] = R(0.0);
    Q[16] = R(0.0);
    Q[17] = R(0.0);
    Q[18] = R(0.0);
    Q[19] = Q_0_2;
    Q[20] = R(0.0);
    Q[21] = Q_2_2;
    Q[22] = R(0.0);
    Q[23] = R(0.0);
    Q[24] = R(0.0);
    Q[25] = R(0.0);
    Q[26] = R(0.0);
    Q[27] = R(0.0);
    Q[28] = Q_4_4;
    Q[29] = Q_4_5;
    Q[30] = R(0.0);
    Q[31] = R(0.0);
    Q[32] = R(0.0);
    Q[33] = R(0.0);
    Q[34] = Q_4_5;
    Q[35] = Q_5_5;
}

RN_INLINE void rn_uwb_planar_noise(const real *x, const real *u, const real *q, const real *p, real dt, real *Q)
{
    RN_UNUSED(x);
    RN_UNUSED(u);
    RN_UNUSED(p);
    const real q_0 = q[0];
    const real q_1 = q[1];
    const real t_0 = R(0.3333333333333333) * (dt * dt * dt);
    const real Q_0_0 = q_0 * t_0;
    const real t_1 = R(0.5) * (dt * dt);
    const real Q_0_2 = q_0 * t_1;
    const real Q_2_2 = dt * q_0;
    const real Q_4_4 = q_1 * t_0;
    const real Q_4_5 = q_1 * t_1;
    const real Q_5_5 = dt * q_1;
    Q[0] = Q_0_0;
    Q[1] = R(0.0);
    Q[2] = Q_0_2;
    Q[3] = R(0.0);
    Q[4] = R(0.0);
    Q[5] = R(0.0);
    Q[6] = Q_0_0;
    Q[7] = R(0.0);
    Q[8] = Q_0_2;
    Q[9] = R(0.0);
    Q[10] = R(0.0);
    Q[11] = Q_2_2;
    Q[12] = R(0.0);
    Q[13] = R(0.0);
    Q[14] = R(0.0);
    Q[15] = Q_2_2;
    Q[16] = R(0.0);
    Q[17] = R(0.0);
    Q[18] = Q_4_4;
    Q[19] = Q_4_5;
    Q[20] = Q_5_5;
}

RN_INLINE void rn_uwb_planar_inject(real *x, const real *e)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real s_yaw_0 = x[4];
    const real s_yaw_rate_0 = x[5];
    const real e_0 = e[0];
    const real e_1 = e[1];
    const real e_2 = e[2];
    const real e_3 = e[3];
    const real e_4 = e[4];
    const real e_5 = e[5];
    x[0] = e_0 + s_p_n_0;
    x[1] = e_1 + s_p_n_1;
    x[2] = e_2 + s_v_n_0;
    x[3] = e_3 + s_v_n_1;
    x[4] = e_4 + s_yaw_0;
    x[5] = e_5 + s_yaw_rate_0;
}

RN_INLINE void rn_uwb_planar_inject_turned(real *x, const real *e)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real s_yaw_0 = x[4];
    const real s_yaw_rate_0 = x[5];
    const real e_0 = e[0];
    const real e_1 = e[1];
    const real e_2 = e[2];
    const real e_3 = e[3];
    const real e_4 = e[4];
    const real e_5 = e[5];
    x[0] = e_0 + s_p_n_0;
    x[1] = e_1 + s_p_n_1;
    x[2] = e_2 + s_v_n_0;
    x[3] = e_3 + s_v_n_1;
    x[4] = e_4 + s_yaw_0;
    x[5] = e_5 + s_yaw_rate_0;
}

RN_INLINE void rn_uwb_planar_difference(const real *a, const real *b, real *e)
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

RN_VECTORISED static void rn_uwb_planar_carry(const real *a, const real *b, const real *u, const real *p, real dt, real *e)
{
    RN_UNUSED(u);
    RN_UNUSED(p);
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
    for (int k = 0; k < 12; k++) {
        const real e_0 = e[0 + k];
        const real e_1 = e[12 + k];
        const real e_2 = e[24 + k];
        const real e_3 = e[36 + k];
        const real e_4 = e[48 + k];
        const real e_5 = e[60 + k];
        const real s_p_n_0 = a_0 + e_0;
        const real s_v_n_0 = a_2 + e_2;
        const real t_0 = dt * s_v_n_0;
        const real s_p_n_1 = a_1 + e_1;
        const real s_v_n_1 = a_3 + e_3;
        const real t_1 = dt * s_v_n_1;
        const real s_yaw_0 = a_4 + e_4;
        const real s_yaw_rate_0 = a_5 + e_5;
        const real t_2 = dt * s_yaw_rate_0;
        e[0 + k] = s_p_n_0 + t_0 - b_0;
        e[12 + k] = s_p_n_1 + t_1 - b_1;
        e[24 + k] = s_v_n_0 - b_2;
        e[36 + k] = s_v_n_1 - b_3;
        e[48 + k] = s_yaw_0 + t_2 - b_4;
    }
}

RN_INLINE void rn_uwb_planar_measure_range(const real *x, const real *z, const real *p, real *h)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real s_yaw_0 = x[4];
    const real s_yaw_rate_0 = x[5];
    const real p_body_down = p[0];
    const real p_time_offset = p[1];
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
    const real t_0 = p_time_offset * s_yaw_rate_0 - s_yaw_0;
    const real t_1 = rn_sin(t_0);
    const real t_2 = rn_cos(t_0);
    const real t_3 = p_time_offset * s_v_n_0 + z_1 - s_p_n_0 - t_1 * z_5 - t_2 * z_4;
    const real t_4 = p_time_offset * s_v_n_1 + t_1 * z_4 + z_2 - s_p_n_1 - t_2 * z_5;
    const real t_5 = (t_3 * t_3) + (t_4 * t_4);
    const real t_6 = R(1.0) / t_5;
    const real t_7 = t_1 * t_3 + t_2 * t_4;
    const real t_8 = t_2 * t_3 - t_1 * t_4;
    const real t_9 = R(1.0) / rn_sqrt(t_5);
    h[0] = (t_6 * (t_8 * t_8) - t_6 * (t_7 * t_7)) * z_9 + R(2.0) * t_6 * t_7 * t_8 * z_10 + rn_sqrt((((p_body_down + z_6 - z_3) * (p_body_down + z_6 - z_3)) + t_5)) + t_7 * t_9 * z_8 + t_8 * t_9 * z_7;
}

RN_INLINE void rn_uwb_planar_residual_range(const real *x, const real *z, const real *p, real *r)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real s_yaw_0 = x[4];
    const real s_yaw_rate_0 = x[5];
    const real p_body_down = p[0];
    const real p_time_offset = p[1];
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
    const real t_0 = p_time_offset * s_yaw_rate_0 - s_yaw_0;
    const real t_1 = rn_sin(t_0);
    const real t_2 = rn_cos(t_0);
    const real t_3 = p_time_offset * s_v_n_0 + z_1 - s_p_n_0 - t_1 * z_5 - t_2 * z_4;
    const real t_4 = p_time_offset * s_v_n_1 + t_1 * z_4 + z_2 - s_p_n_1 - t_2 * z_5;
    const real t_5 = (t_3 * t_3) + (t_4 * t_4);
    const real t_6 = R(1.0) / t_5;
    const real t_7 = t_1 * t_3 + t_2 * t_4;
    const real t_8 = t_2 * t_3 - t_1 * t_4;
    const real t_9 = R(1.0) / rn_sqrt(t_5);
    r[0] = z_0 - (((t_6 * (t_8 * t_8) - t_6 * (t_7 * t_7)) * z_9 + R(2.0) * t_6 * t_7 * t_8 * z_10 + rn_sqrt((((p_body_down + z_6 - z_3) * (p_body_down + z_6 - z_3)) + t_5)) + t_7 * t_9 * z_8 + t_8 * t_9 * z_7));
}

RN_INLINE void rn_uwb_planar_jacobian_range(const real *x, const real *z, const real *p, real *H)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real s_yaw_0 = x[4];
    const real s_yaw_rate_0 = x[5];
    const real p_body_down = p[0];
    const real p_time_offset = p[1];
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
    const real t_0 = p_time_offset * s_yaw_rate_0 - s_yaw_0;
    const real t_1 = rn_sin(t_0);
    const real t_2 = rn_cos(t_0);
    const real t_3 = t_1 * z_5;
    const real t_4 = t_2 * z_4;
    const real t_5 = -t_3 - t_4;
    const real t_6 = p_time_offset * s_v_n_0 + t_5 + z_1 - s_p_n_0;
    const real t_7 = t_2 * t_6;
    const real t_8 = t_1 * z_4;
    const real t_9 = t_2 * z_5;
    const real t_10 = p_time_offset * s_v_n_1 + t_8 + z_2 - s_p_n_1 - t_9;
    const real t_11 = t_1 * t_10;
    const real t_12 = t_7 - t_11;
    const real t_13 = (t_10 * t_10) + (t_6 * t_6);
    const real t_14 = R(2.0) / t_13;
    const real t_15 = t_12 * t_14;
    const real t_16 = t_1 * t_15;
    const real t_17 = R(1.0) / rn_sqrt((((p_body_down + z_6 - z_3) * (p_body_down + z_6 - z_3)) + t_13));
    const real t_18 = t_17 * t_6;
    const real t_19 = R(1.0) / rn_sqrt(t_13);
    const real t_20 = t_19 * z_8;
    const real t_21 = t_1 * t_20;
    const real t_22 = t_1 * t_6;
    const real t_23 = t_10 * t_2;
    const real t_24 = t_22 + t_23;
    const real t_25 = t_14 * t_24;
    const real t_26 = t_25 * t_2;
    const real t_27 = t_19 * z_7;
    const real t_28 = t_27 * t_2;
    const real t_29 = R(1.0) / (t_13 * t_13);
    const real t_30 = t_12 * t_24 * z_10;
    const real t_31 = R(4.0) * t_29 * t_30;
    const real t_32 = t_31 * t_6;
    const real t_33 = R(1.0) / (t_13 * rn_sqrt(t_13));
    const real t_34 = t_33 * t_6;
    const real t_35 = t_24 * z_8;
    const real t_36 = t_34 * t_35;
    const real t_37 = t_12 * z_7;
    const real t_38 = t_34 * t_37;
    const real t_39 = t_24 * t_24;
    const real t_40 = R(2.0) * t_6;
    const real t_41 = t_29 * t_40;
    const real t_42 = t_39 * t_41;
    const real t_43 = t_1 * t_25;
    const real t_44 = t_12 * t_12;
    const real t_45 = t_41 * t_44;
    const real t_46 = t_15 * t_2;
    const real t_47 = t_10 * t_33;
    const real t_48 = t_35 * t_47;
    const real t_49 = t_20 * t_2;
    const real t_50 = t_37 * t_47;
    const real t_51 = t_1 * t_27;
    const real t_52 = t_10 * t_31;
    const real t_53 = R(2.0) * t_10;
    const real t_54 = t_29 * t_53;
    const real t_55 = t_39 * t_54;
    const real t_56 = t_44 * t_54;
    const real t_57 = t_10 * t_17;
    const real t_58 = p_time_offset * t_16;
    const real t_59 = p_time_offset * t_26;
    const real t_60 = p_time_offset * t_43;
    const real t_61 = p_time_offset * t_46;
    const real t_62 = t_9 - t_8;
    const real t_63 = t_5 * t_53 + t_40 * t_62;
    const real t_64 = R(0.5) * t_33;
    const real t_65 = t_63 * t_64;
    const real t_66 = R(0.5) * t_17;
    const real t_67 = t_1 * t_62 + t_11 + t_2 * t_5 - t_7;
    const real t_68 = t_15 * z_10;
    const real t_69 = t_24 + t_2 * t_62 - t_1 * t_5;
    const real t_70 = t_25 * z_10;
    const real t_71 = t_29 * t_63;
    const real t_72 = R(2.0) * t_30;
    const real t_73 = p_time_offset * t_3 + p_time_offset * t_4;
    const real t_74 = p_time_offset * t_8 - p_time_offset * t_9;
    const real t_75 = t_53 * t_73 + t_40 * t_74;
    const real t_76 = t_64 * t_75;
    const real t_77 = t_1 * t_74 + t_2 * t_73 + p_time_offset * t_7 - p_time_offset * t_11;
    const real t_78 = t_29 * t_75;
    const real t_79 = t_2 * t_74 - t_1 * t_73 - p_time_offset * t_22 - p_time_offset * t_23;
    H[0] = (t_43 + t_45 - t_42 - t_46) * z_9 + t_32 + t_36 + t_38 - t_16 * z_10 - t_18 - t_21 - t_26 * z_10 - t_28;
    H[1] = (t_16 + t_26 + t_56 - t_55) * z_9 + t_43 * z_10 + t_48 + t_50 + t_51 + t_52 - t_46 * z_10 - t_49 - t_57;
    H[2] = (p_time_offset * t_42 + t_61 - p_time_offset * t_45 - t_60) * z_9 + p_time_offset * t_18 + p_time_offset * t_21 + p_time_offset * t_28 + t_58 * z_10 + t_59 * z_10 - p_time_offset * t_32 - p_time_offset * t_36 - p_time_offset * t_38;
    H[3] = (p_time_offset * t_55 - p_time_offset * t_56 - t_58 - t_59) * z_9 + p_time_offset * t_49 + p_time_offset * t_57 + t_61 * z_10 - p_time_offset * t_48 - p_time_offset * t_50 - p_time_offset * t_51 - p_time_offset * t_52 - t_60 * z_10;
    H[4] = (t_15 * t_69 + t_39 * t_71 - t_25 * t_67 - t_44 * t_71) * z_9 + t_63 * t_66 + t_20 * t_67 + t_67 * t_68 + t_27 * t_69 + t_69 * t_70 - t_35 * t_65 - t_37 * t_65 - t_71 * t_72;
    H[5] = (t_39 * t_78 + t_15 * t_79 - t_25 * t_77 - t_44 * t_78) * z_9 + t_70 * t_79 + t_66 * t_75 + t_20 * t_77 + t_68 * t_77 + t_27 * t_79 - t_72 * t_78 - t_35 * t_76 - t_37 * t_76;
}

RN_INLINE void rn_uwb_planar_innovation_range(const real *x, const real *z, const real *p, real *r)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real s_yaw_0 = x[4];
    const real s_yaw_rate_0 = x[5];
    const real p_body_down = p[0];
    const real p_time_offset = p[1];
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
    const real t_0 = p_time_offset * s_yaw_rate_0 - s_yaw_0;
    const real t_1 = rn_sin(t_0);
    const real t_2 = rn_cos(t_0);
    const real t_3 = p_time_offset * s_v_n_0 + z_1 - s_p_n_0 - t_1 * z_5 - t_2 * z_4;
    const real t_4 = p_time_offset * s_v_n_1 + t_1 * z_4 + z_2 - s_p_n_1 - t_2 * z_5;
    const real t_5 = (t_3 * t_3) + (t_4 * t_4);
    const real t_6 = R(1.0) / t_5;
    const real t_7 = t_1 * t_3 + t_2 * t_4;
    const real t_8 = t_2 * t_3 - t_1 * t_4;
    const real t_9 = R(1.0) / rn_sqrt(t_5);
    r[0] = z_0 - (((t_6 * (t_8 * t_8) - t_6 * (t_7 * t_7)) * z_9 + R(2.0) * t_6 * t_7 * t_8 * z_10 + rn_sqrt((((p_body_down + z_6 - z_3) * (p_body_down + z_6 - z_3)) + t_5)) + t_7 * t_9 * z_8 + t_8 * t_9 * z_7));
}

RN_INLINE real rn_uwb_planar_update_range(real *x, real *P, const real *z, real variance, RN(rule) rule, const real *p, real *nu, real *s, real *nis)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real s_yaw_0 = x[4];
    const real s_yaw_rate_0 = x[5];
    const real p_body_down = p[0];
    const real p_time_offset = p[1];
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
    const real t_0 = p_time_offset * s_yaw_rate_0 - s_yaw_0;
    const real t_1 = rn_sin(t_0);
    const real t_2 = t_1 * z_5;
    const real t_3 = rn_cos(t_0);
    const real t_4 = t_3 * z_4;
    const real t_5 = -t_2 - t_4;
    const real t_6 = p_time_offset * s_v_n_0 + t_5 + z_1 - s_p_n_0;
    const real t_7 = t_1 * z_4;
    const real t_8 = t_3 * z_5;
    const real t_9 = p_time_offset * s_v_n_1 + t_7 + z_2 - s_p_n_1 - t_8;
    const real t_10 = (t_6 * t_6) + (t_9 * t_9);
    const real t_11 = rn_sqrt((((p_body_down + z_6 - z_3) * (p_body_down + z_6 - z_3)) + t_10));
    const real t_12 = t_3 * t_6;
    const real t_13 = t_1 * t_9;
    const real t_14 = t_12 - t_13;
    const real t_15 = t_1 * t_6;
    const real t_16 = t_3 * t_9;
    const real t_17 = t_15 + t_16;
    const real t_18 = R(1.0) / t_10;
    const real t_19 = R(2.0) * t_18;
    const real t_20 = t_17 * t_19;
    const real t_21 = t_20 * z_10;
    const real t_22 = t_14 * t_14;
    const real t_23 = t_17 * t_17;
    const real t_24 = R(1.0) / rn_sqrt(t_10);
    const real t_25 = t_24 * z_7;
    const real t_26 = t_24 * z_8;
    const real t_27 = t_14 * t_19;
    const real t_28 = t_1 * t_27;
    const real t_29 = R(1.0) / t_11;
    const real t_30 = t_29 * t_6;
    const real t_31 = t_1 * t_26;
    const real t_32 = t_20 * t_3;
    const real t_33 = t_25 * t_3;
    const real t_34 = R(1.0) / (t_10 * t_10);
    const real t_35 = t_14 * t_17 * z_10;
    const real t_36 = R(4.0) * t_34 * t_35;
    const real t_37 = t_36 * t_6;
    const real t_38 = R(1.0) / (t_10 * rn_sqrt(t_10));
    const real t_39 = t_38 * t_6;
    const real t_40 = t_17 * z_8;
    const real t_41 = t_39 * t_40;
    const real t_42 = t_14 * z_7;
    const real t_43 = t_39 * t_42;
    const real t_44 = R(2.0) * t_6;
    const real t_45 = t_23 * t_34;
    const real t_46 = t_44 * t_45;
    const real t_47 = t_1 * t_20;
    const real t_48 = t_22 * t_34;
    const real t_49 = t_44 * t_48;
    const real t_50 = t_27 * t_3;
    const real t_51 = t_38 * t_9;
    const real t_52 = t_40 * t_51;
    const real t_53 = t_26 * t_3;
    const real t_54 = t_42 * t_51;
    const real t_55 = t_1 * t_25;
    const real t_56 = t_36 * t_9;
    const real t_57 = R(2.0) * t_9;
    const real t_58 = t_45 * t_57;
    const real t_59 = t_48 * t_57;
    const real t_60 = t_29 * t_9;
    const real t_61 = p_time_offset * t_28;
    const real t_62 = p_time_offset * t_32;
    const real t_63 = p_time_offset * t_47;
    const real t_64 = p_time_offset * t_50;
    const real t_65 = t_8 - t_7;
    const real t_66 = t_5 * t_57 + t_44 * t_65;
    const real t_67 = R(0.5) * t_38;
    const real t_68 = t_66 * t_67;
    const real t_69 = R(0.5) * t_29;
    const real t_70 = t_1 * t_65 + t_13 + t_3 * t_5 - t_12;
    const real t_71 = t_27 * z_10;
    const real t_72 = t_17 + t_3 * t_65 - t_1 * t_5;
    const real t_73 = t_34 * t_66;
    const real t_74 = R(2.0) * t_35;
    const real t_75 = p_time_offset * t_2 + p_time_offset * t_4;
    const real t_76 = p_time_offset * t_7 - p_time_offset * t_8;
    const real t_77 = t_57 * t_75 + t_44 * t_76;
    const real t_78 = t_67 * t_77;
    const real t_79 = t_1 * t_76 + p_time_offset * t_12 + t_3 * t_75 - p_time_offset * t_13;
    const real t_80 = t_34 * t_77;
    const real t_81 = t_3 * t_76 - t_1 * t_75 - p_time_offset * t_15 - p_time_offset * t_16;
    const real r_0 = z_0 - (((t_18 * t_22 - t_18 * t_23) * z_9 + t_11 + t_14 * t_21 + t_14 * t_25 + t_17 * t_26));
    const real H_0_0 = (t_47 + t_49 - t_46 - t_50) * z_9 + t_37 + t_41 + t_43 - t_28 * z_10 - t_30 - t_31 - t_32 * z_10 - t_33;
    const real H_0_1 = (t_28 + t_32 + t_59 - t_58) * z_9 + t_47 * z_10 + t_52 + t_54 + t_55 + t_56 - t_50 * z_10 - t_53 - t_60;
    const real H_0_2 = (p_time_offset * t_46 + t_64 - p_time_offset * t_49 - t_63) * z_9 + p_time_offset * t_30 + p_time_offset * t_31 + p_time_offset * t_33 + t_61 * z_10 + t_62 * z_10 - p_time_offset * t_37 - p_time_offset * t_41 - p_time_offset * t_43;
    const real H_0_3 = (p_time_offset * t_58 - p_time_offset * t_59 - t_61 - t_62) * z_9 + p_time_offset * t_53 + p_time_offset * t_60 + t_64 * z_10 - p_time_offset * t_52 - p_time_offset * t_54 - p_time_offset * t_55 - p_time_offset * t_56 - t_63 * z_10;
    const real H_0_4 = (t_27 * t_72 + t_23 * t_73 - t_20 * t_70 - t_22 * t_73) * z_9 + t_66 * t_69 + t_26 * t_70 + t_70 * t_71 + t_21 * t_72 + t_25 * t_72 - t_40 * t_68 - t_42 * t_68 - t_73 * t_74;
    const real H_0_5 = (t_23 * t_80 + t_27 * t_81 - t_20 * t_79 - t_22 * t_80) * z_9 + t_71 * t_79 + t_69 * t_77 + t_26 * t_79 + t_21 * t_81 + t_25 * t_81 - t_40 * t_78 - t_42 * t_78 - t_74 * t_80;
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
    rn_uwb_planar_inject(x, dx);
    return weight;
}

RN_INLINE void rn_uwb_planar_gain(const real *K, const real *r, real *e)
{
    e[0] = K[0] * r[0];
    e[1] = K[1] * r[0];
    e[2] = K[2] * r[0];
    e[3] = K[3] * r[0];
    e[4] = K[4] * r[0];
    e[5] = K[5] * r[0];
}

RN_INLINE void rn_uwb_planar_correct(real *x, const real *z, const real *K, const real *p, real *r)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real s_yaw_0 = x[4];
    const real s_yaw_rate_0 = x[5];
    const real p_body_down = p[0];
    const real p_time_offset = p[1];
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
    const real K_0 = K[0];
    const real K_1 = K[1];
    const real K_2 = K[2];
    const real K_3 = K[3];
    const real K_4 = K[4];
    const real K_5 = K[5];
    const real t_0 = p_time_offset * s_yaw_rate_0 - s_yaw_0;
    const real t_1 = rn_sin(t_0);
    const real t_2 = rn_cos(t_0);
    const real t_3 = p_time_offset * s_v_n_0 + z_1 - s_p_n_0 - t_1 * z_5 - t_2 * z_4;
    const real t_4 = p_time_offset * s_v_n_1 + t_1 * z_4 + z_2 - s_p_n_1 - t_2 * z_5;
    const real t_5 = (t_3 * t_3) + (t_4 * t_4);
    const real t_6 = R(1.0) / t_5;
    const real t_7 = t_1 * t_3 + t_2 * t_4;
    const real t_8 = t_2 * t_3 - t_1 * t_4;
    const real t_9 = R(1.0) / rn_sqrt(t_5);
    const real r_0 = z_0 - (((t_6 * (t_8 * t_8) - t_6 * (t_7 * t_7)) * z_9 + R(2.0) * t_6 * t_7 * t_8 * z_10 + rn_sqrt((((p_body_down + z_6 - z_3) * (p_body_down + z_6 - z_3)) + t_5)) + t_7 * t_9 * z_8 + t_8 * t_9 * z_7));
    const real de_0 = K_0 * r_0;
    const real de_1 = K_1 * r_0;
    const real de_2 = K_2 * r_0;
    const real de_3 = K_3 * r_0;
    const real de_4 = K_4 * r_0;
    const real de_5 = K_5 * r_0;
    x[0] = de_0 + s_p_n_0;
    x[1] = de_1 + s_p_n_1;
    x[2] = de_2 + s_v_n_0;
    x[3] = de_3 + s_v_n_1;
    x[4] = de_4 + s_yaw_0;
    x[5] = de_5 + s_yaw_rate_0;
    r[0] = r_0;
}

static const RN(sensor) rn_uwb_planar_sensors[] = {
    {"range", 1, 11, 1, 6, rn_uwb_planar_measure_range, rn_uwb_planar_residual_range, rn_uwb_planar_jacobian_range, rn_uwb_planar_innovation_range, rn_uwb_planar_update_range}};
static const RN(model) rn_uwb_planar_model = {
    RN_ABI, (int)sizeof(real), "uwb_planar", 6, 6, 0, 2, 2, 1, 5, rn_uwb_planar_sensors,
    rn_uwb_planar_propagate, rn_uwb_planar_predict, rn_uwb_planar_transition, rn_uwb_planar_noise, rn_uwb_planar_inject, rn_uwb_planar_inject_turned, rn_uwb_planar_difference, rn_uwb_planar_carry, rn_uwb_planar_gain, rn_uwb_planar_correct};

#endif
