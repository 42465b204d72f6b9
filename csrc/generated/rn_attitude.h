/* Generated from the model 'attitude'; do not edit: make generate. */
/* clang-format off */
#ifndef RN_GENERATED_ATTITUDE_H
#define RN_GENERATED_ATTITUDE_H
#include "rn_model.h"
#include "rn_update.h"

/* state, error (quaternions: small rotation, rad), input, parameters:
 *   x[0..3], e[0..2]  q_nb [1], error in n
 *   x[4..6], e[3..5]  gyro_bias [rad/s]
 *   u[0..2]  gyro [rad/s]
 *   p[0]  gravity
 *   p[1]  mag_north
 *   p[2]  mag_down
 *   reading accel: z[0..2] [m/s^2]
 *   reading mag: z[0..2] [T]
 *   q[0]  intensity of gyro_noise [(rad/s/sqrt(Hz))^2]
 *   q[1]  intensity of gyro_bias_noise [(rad/s^2/sqrt(Hz))^2]
 *   q[2]  intensity of gyro_scale_noise [(1/sqrt(Hz))^2] */

RN_INLINE void rn_attitude_propagate(real *x, const real *u, const real *p, real dt)
{
    RN_UNUSED(p);
    const real s_q_nb_0 = x[0];
    const real s_q_nb_1 = x[1];
    const real s_q_nb_2 = x[2];
    const real s_q_nb_3 = x[3];
    const real s_gyro_bias_0 = x[4];
    const real s_gyro_bias_1 = x[5];
    const real s_gyro_bias_2 = x[6];
    const real u_gyro_0 = u[0];
    const real u_gyro_1 = u[1];
    const real u_gyro_2 = u[2];
    const real r0_q_nb_0 = u_gyro_0 - s_gyro_bias_0;
    const real phi_0 = dt * r0_q_nb_0;
    const real r0_q_nb_1 = u_gyro_1 - s_gyro_bias_1;
    const real phi_1 = dt * r0_q_nb_1;
    const real r0_q_nb_2 = u_gyro_2 - s_gyro_bias_2;
    const real phi_2 = dt * r0_q_nb_2;
    const real phi_square = (phi_0 * phi_0) + (phi_1 * phi_1) + (phi_2 * phi_2);
    const real half_sinc = R(0.5) - R(0.020833333333333332) * phi_square;
    const real t_0 = half_sinc * phi_1;
    const real t_1 = half_sinc * phi_2;
    const real t_2 = half_sinc * phi_0;
    const real t_3 = R(0.0026041666666666665) * (phi_square * phi_square) + R(1.0) - R(0.125) * phi_square;
    const real n_0 = s_q_nb_0 * t_3 - s_q_nb_3 * t_1 - s_q_nb_1 * t_2 - s_q_nb_2 * t_0;
    const real n_1 = s_q_nb_2 * t_1 + s_q_nb_0 * t_2 + s_q_nb_1 * t_3 - s_q_nb_3 * t_0;
    const real n_2 = s_q_nb_3 * t_2 + s_q_nb_2 * t_3 + s_q_nb_0 * t_0 - s_q_nb_1 * t_1;
    const real n_3 = s_q_nb_0 * t_1 + s_q_nb_3 * t_3 + s_q_nb_1 * t_0 - s_q_nb_2 * t_2;
    const real newton = R(1.5) - R(0.5) * ((n_0 * n_0) + (n_1 * n_1) + (n_2 * n_2) + (n_3 * n_3));
    x[0] = n_0 * newton;
    x[1] = n_1 * newton;
    x[2] = n_2 * newton;
    x[3] = n_3 * newton;
    x[4] = s_gyro_bias_0;
    x[5] = s_gyro_bias_1;
    x[6] = s_gyro_bias_2;
}

RN_INLINE void rn_attitude_predict(real *x, real *P, const real *u, const real *q, const real *p, real dt)
{
    RN_UNUSED(p);
    const real s_q_nb_0 = x[0];
    const real s_q_nb_1 = x[1];
    const real s_q_nb_2 = x[2];
    const real s_q_nb_3 = x[3];
    const real s_gyro_bias_0 = x[4];
    const real s_gyro_bias_1 = x[5];
    const real s_gyro_bias_2 = x[6];
    const real u_gyro_0 = u[0];
    const real u_gyro_1 = u[1];
    const real u_gyro_2 = u[2];
    const real q_0 = q[0];
    const real q_1 = q[1];
    const real q_2 = q[2];
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
    const real r0_q_nb_0 = u_gyro_0 - s_gyro_bias_0;
    const real phi_0 = dt * r0_q_nb_0;
    const real r0_q_nb_1 = u_gyro_1 - s_gyro_bias_1;
    const real phi_1 = dt * r0_q_nb_1;
    const real r0_q_nb_2 = u_gyro_2 - s_gyro_bias_2;
    const real phi_2 = dt * r0_q_nb_2;
    const real phi_square = (phi_0 * phi_0) + (phi_1 * phi_1) + (phi_2 * phi_2);
    const real half_sinc = R(0.5) - R(0.020833333333333332) * phi_square;
    const real t_0 = half_sinc * phi_1;
    const real t_1 = half_sinc * phi_2;
    const real t_2 = half_sinc * phi_0;
    const real t_3 = R(0.0026041666666666665) * (phi_square * phi_square) + R(1.0) - R(0.125) * phi_square;
    const real n_0 = s_q_nb_0 * t_3 - s_q_nb_2 * t_0 - s_q_nb_3 * t_1 - s_q_nb_1 * t_2;
    const real n_1 = s_q_nb_2 * t_1 + s_q_nb_0 * t_2 + s_q_nb_1 * t_3 - s_q_nb_3 * t_0;
    const real n_2 = s_q_nb_0 * t_0 + s_q_nb_3 * t_2 + s_q_nb_2 * t_3 - s_q_nb_1 * t_1;
    const real n_3 = s_q_nb_1 * t_0 + s_q_nb_0 * t_1 + s_q_nb_3 * t_3 - s_q_nb_2 * t_2;
    const real newton = R(1.5) - R(0.5) * ((n_0 * n_0) + (n_1 * n_1) + (n_2 * n_2) + (n_3 * n_3));
    const real half_phi_0 = R(0.5) * phi_0;
    const real half_phi_1 = R(0.5) * phi_1;
    const real half_phi_2 = R(0.5) * phi_2;
    const real half_phi_square = (half_phi_0 * half_phi_0) + (half_phi_1 * half_phi_1) + (half_phi_2 * half_phi_2);
    const real half_half_sinc = R(0.5) - R(0.020833333333333332) * half_phi_square;
    const real t_4 = half_half_sinc * s_q_nb_2;
    const real t_5 = half_half_sinc * s_q_nb_1;
    const real t_6 = R(0.0026041666666666665) * (half_phi_square * half_phi_square) + R(1.0) - R(0.125) * half_phi_square;
    const real t_7 = half_half_sinc * s_q_nb_0;
    const real m_3 = half_phi_2 * t_7 + half_phi_1 * t_5 + s_q_nb_3 * t_6 - half_phi_0 * t_4;
    const real t_8 = m_3 * m_3;
    const real t_9 = half_half_sinc * s_q_nb_3;
    const real m_2 = half_phi_1 * t_7 + half_phi_0 * t_9 + s_q_nb_2 * t_6 - half_phi_2 * t_5;
    const real t_10 = m_2 * m_2;
    const real A_0_3 = -(R(1.0) - R(2.0) * (t_8 + t_10));
    const real F_0_3 = A_0_3 * dt;
    const real m_0 = s_q_nb_0 * t_6 - half_phi_2 * t_9 - half_phi_1 * t_4 - half_phi_0 * t_5;
    const real t_11 = m_0 * m_3;
    const real m_1 = half_phi_0 * t_7 + half_phi_2 * t_4 + s_q_nb_1 * t_6 - half_phi_1 * t_9;
    const real t_12 = m_1 * m_2;
    const real A_0_4 = -(R(2.0) * (t_12 - t_11));
    const real F_0_4 = A_0_4 * dt;
    const real t_13 = m_0 * m_2;
    const real t_14 = m_1 * m_3;
    const real A_0_5 = -(R(2.0) * (t_13 + t_14));
    const real F_0_5 = A_0_5 * dt;
    const real Q_0_0 = dt * (q_0 + q_2 * ((r0_q_nb_0 * r0_q_nb_0) + (r0_q_nb_1 * r0_q_nb_1) + (r0_q_nb_2 * r0_q_nb_2)));
    const real T_0_0 = F_0_3 * P_0_3 + F_0_4 * P_0_4 + F_0_5 * P_0_5 + P_0_0;
    const real T_0_3 = F_0_3 * P_3_3 + F_0_4 * P_3_4 + F_0_5 * P_3_5 + P_0_3;
    const real T_0_4 = F_0_3 * P_3_4 + F_0_4 * P_4_4 + F_0_5 * P_4_5 + P_0_4;
    const real T_0_5 = F_0_3 * P_3_5 + F_0_4 * P_4_5 + F_0_5 * P_5_5 + P_0_5;
    const real A_1_3 = -(R(2.0) * (t_11 + t_12));
    const real F_1_3 = A_1_3 * dt;
    const real t_15 = m_1 * m_1;
    const real A_1_4 = -(R(1.0) - R(2.0) * (t_8 + t_15));
    const real F_1_4 = A_1_4 * dt;
    const real t_16 = m_0 * m_1;
    const real t_17 = m_2 * m_3;
    const real A_1_5 = -(R(2.0) * (t_17 - t_16));
    const real F_1_5 = A_1_5 * dt;
    const real T_0_1 = F_0_3 * P_1_3 + F_0_4 * P_1_4 + F_0_5 * P_1_5 + P_0_1;
    const real A_2_3 = -(R(2.0) * (t_14 - t_13));
    const real F_2_3 = A_2_3 * dt;
    const real A_2_4 = -(R(2.0) * (t_16 + t_17));
    const real F_2_4 = A_2_4 * dt;
    const real A_2_5 = -(R(1.0) - R(2.0) * (t_10 + t_15));
    const real F_2_5 = A_2_5 * dt;
    const real T_0_2 = F_0_3 * P_2_3 + F_0_4 * P_2_4 + F_0_5 * P_2_5 + P_0_2;
    const real T_1_1 = F_1_3 * P_1_3 + F_1_4 * P_1_4 + F_1_5 * P_1_5 + P_1_1;
    const real T_1_3 = F_1_3 * P_3_3 + F_1_4 * P_3_4 + F_1_5 * P_3_5 + P_1_3;
    const real T_1_4 = F_1_3 * P_3_4 + F_1_4 * P_4_4 + F_1_5 * P_4_5 + P_1_4;
    const real T_1_5 = F_1_3 * P_3_5 + F_1_4 * P_4_5 + F_1_5 * P_5_5 + P_1_5;
    const real T_1_2 = F_1_3 * P_2_3 + F_1_4 * P_2_4 + F_1_5 * P_2_5 + P_1_2;
    const real T_2_2 = F_2_3 * P_2_3 + F_2_4 * P_2_4 + F_2_5 * P_2_5 + P_2_2;
    const real T_2_3 = F_2_3 * P_3_3 + F_2_4 * P_3_4 + F_2_5 * P_3_5 + P_2_3;
    const real T_2_4 = F_2_3 * P_3_4 + F_2_4 * P_4_4 + F_2_5 * P_4_5 + P_2_4;
    const real T_2_5 = F_2_3 * P_3_5 + F_2_4 * P_4_5 + F_2_5 * P_5_5 + P_2_5;
    const real Q_3_3 = dt * q_1;
    x[0] = n_0 * newton;
    x[1] = n_1 * newton;
    x[2] = n_2 * newton;
    x[3] = n_3 * newton;
    x[4] = s_gyro_bias_0;
    x[5] = s_gyro_bias_1;
    x[6] = s_gyro_bias_2;
    P[0] = F_0_3 * T_0_3 + F_0_4 * T_0_4 + F_0_5 * T_0_5 + Q_0_0 + T_0_0;
    P[1] = F_1_3 * T_0_3 + F_1_4 * T_0_4 + F_1_5 * T_0_5 + T_0_1;
    P[2] = F_2_3 * T_0_3 + F_2_4 * T_0_4 + F_2_5 * T_0_5 + T_0_2;
    P[3] = T_0_3;
    P[4] = T_0_4;
    P[5] = T_0_5;
    P[6] = F_1_3 * T_1_3 + F_1_4 * T_1_4 + F_1_5 * T_1_5 + Q_0_0 + T_1_1;
    P[7] = F_2_3 * T_1_3 + F_2_4 * T_1_4 + F_2_5 * T_1_5 + T_1_2;
    P[8] = T_1_3;
    P[9] = T_1_4;
    P[10] = T_1_5;
    P[11] = F_2_3 * T_2_3 + F_2_4 * T_2_4 + F_2_5 * T_2_5 + Q_0_0 + T_2_2;
    P[12] = T_2_3;
    P[13] = T_2_4;
    P[14] = T_2_5;
    P[15] = P_3_3 + Q_3_3;
    P[16] = P_3_4;
    P[17] = P_3_5;
    P[18] = P_4_4 + Q_3_3;
    P[19] = P_4_5;
    P[20] = P_5_5 + Q_3_3;
}

RN_INLINE void rn_attitude_transition(const real *x, const real *u, const real *q, const real *p, real dt, real *F, real *Q)
{
    RN_UNUSED(p);
    const real s_q_nb_0 = x[0];
    const real s_q_nb_1 = x[1];
    const real s_q_nb_2 = x[2];
    const real s_q_nb_3 = x[3];
    const real s_gyro_bias_0 = x[4];
    const real s_gyro_bias_1 = x[5];
    const real s_gyro_bias_2 = x[6];
    const real u_gyro_0 = u[0];
    const real u_gyro_1 = u[1];
    const real u_gyro_2 = u[2];
    const real q_0 = q[0];
    const real q_1 = q[1];
    const real q_2 = q[2];
    const real r0_q_nb_0 = u_gyro_0 - s_gyro_bias_0;
    const real phi_0 = dt * r0_q_nb_0;
    const real half_phi_0 = R(0.5) * phi_0;
    const real r0_q_nb_1 = u_gyro_1 - s_gyro_bias_1;
    const real phi_1 = dt * r0_q_nb_1;
    const real half_phi_1 = R(0.5) * phi_1;
    const real r0_q_nb_2 = u_gyro_2 - s_gyro_bias_2;
    const real phi_2 = dt * r0_q_nb_2;
    const real half_phi_2 = R(0.5) * phi_2;
    const real half_phi_square = (half_phi_0 * half_phi_0) + (half_phi_1 * half_phi_1) + (half_phi_2 * half_phi_2);
    const real half_half_sinc = R(0.5) - R(0.020833333333333332) * half_phi_square;
    const real t_0 = half_half_sinc * s_q_nb_2;
    const real t_1 = half_half_sinc * s_q_nb_1;
    const real t_2 = R(0.0026041666666666665) * (half_phi_square * half_phi_square) + R(1.0) - R(0.125) * half_phi_square;
    const real t_3 = half_half_sinc * s_q_nb_0;
    const real m_3 = half_phi_2 * t_3 + half_phi_1 * t_1 + s_q_nb_3 * t_2 - half_phi_0 * t_0;
    const real t_4 = m_3 * m_3;
    const real t_5 = half_half_sinc * s_q_nb_3;
    const real m_2 = half_phi_1 * t_3 + half_phi_0 * t_5 + s_q_nb_2 * t_2 - half_phi_2 * t_1;
    const real t_6 = m_2 * m_2;
    const real A_0_3 = -(R(1.0) - R(2.0) * (t_4 + t_6));
    const real F_0_3 = A_0_3 * dt;
    const real m_0 = s_q_nb_0 * t_2 - half_phi_2 * t_5 - half_phi_1 * t_0 - half_phi_0 * t_1;
    const real t_7 = m_0 * m_3;
    const real m_1 = half_phi_0 * t_3 + half_phi_2 * t_0 + s_q_nb_1 * t_2 - half_phi_1 * t_5;
    const real t_8 = m_1 * m_2;
    const real A_0_4 = -(R(2.0) * (t_8 - t_7));
    const real F_0_4 = A_0_4 * dt;
    const real t_9 = m_0 * m_2;
    const real t_10 = m_1 * m_3;
    const real A_0_5 = -(R(2.0) * (t_9 + t_10));
    const real F_0_5 = A_0_5 * dt;
    const real A_1_3 = -(R(2.0) * (t_7 + t_8));
    const real F_1_3 = A_1_3 * dt;
    const real t_11 = m_1 * m_1;
    const real A_1_4 = -(R(1.0) - R(2.0) * (t_4 + t_11));
    const real F_1_4 = A_1_4 * dt;
    const real t_12 = m_0 * m_1;
    const real t_13 = m_2 * m_3;
    const real A_1_5 = -(R(2.0) * (t_13 - t_12));
    const real F_1_5 = A_1_5 * dt;
    const real A_2_3 = -(R(2.0) * (t_10 - t_9));
    const real F_2_3 = A_2_3 * dt;
    const real A_2_4 = -(R(2.0) * (t_12 + t_13));
    const real F_2_4 = A_2_4 * dt;
    const real A_2_5 = -(R(1.0) - R(2.0) * (t_6 + t_11));
    const real F_2_5 = A_2_5 * dt;
    const real Q_0_0 = dt * (q_0 + q_2 * ((r0_q_nb_0 * r0_q_nb_0) + (r0_q_nb_1 * r0_q_nb_1) + (r0_q_nb_2 * r0_q_nb_2)));
    const real Q_3_3 = dt * q_1;
    F[0] = R(1.0);
    F[1] = R(0.0);
    F[2] = R(0.0);
    F[3] = F_0_3;
    F[4] = F_0_4;
    F[5] = F_0_5;
    F[6] = R(0.0);
    F[7] = R(1.0);
    F[8] = R(0.0);
    F[9] = F_1_3;
    F[10] = F_1_4;
    F[11] = F_1_5;
    F[12] = R(0.0);
    F[13] = R(0.0);
    F[14] = R(1.0);
    F[15] = F_2_3;
    F[16] = F_2_4;
    F[17] = F_2_5;
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
    Q[3] = R(0.0);
    Q[4] = R(0.0);
    Q[5] = R(0.0);
    Q[6] = R(0.0);
    Q[7] = Q_0_0;
    Q[8] = R(0.0);
    Q[9] = R(0.0);
    Q[10] = R(0.0);
    Q[11] = R(0.0);
    Q[12] = R(0.0);
    Q[13] = R(0.0);
    Q[14] = Q_0_0;
    Q[15] = R(0.0);
    Q[16] = R(0.0);
    Q[17] = R(0.0);
    Q[18] = R(0.0);
    Q[19] = R(0.0);
    Q[20] = R(0.0);
    Q[21] = Q_3_3;
    Q[22] = R(0.0);
    Q[23] = R(0.0);
    Q[24] = R(0.0);
    Q[25] = R(0.0);
    Q[26] = R(0.0);
    Q[27] = R(0.0);
    Q[28] = Q_3_3;
    Q[29] = R(0.0);
    Q[30] = R(0.0);
    Q[31] = R(0.0);
    Q[32] = R(0.0);
    Q[33] = R(0.0);
    Q[34] = R(0.0);
    Q[35] = Q_3_3;
}

RN_INLINE void rn_attitude_noise(const real *x, const real *u, const real *q, const real *p, real dt, real *Q)
{
    RN_UNUSED(p);
    const real s_gyro_bias_0 = x[4];
    const real s_gyro_bias_1 = x[5];
    const real s_gyro_bias_2 = x[6];
    const real u_gyro_0 = u[0];
    const real u_gyro_1 = u[1];
    const real u_gyro_2 = u[2];
    const real q_0 = q[0];
    const real q_1 = q[1];
    const real q_2 = q[2];
    const real r0_q_nb_0 = u_gyro_0 - s_gyro_bias_0;
    const real r0_q_nb_1 = u_gyro_1 - s_gyro_bias_1;
    const real r0_q_nb_2 = u_gyro_2 - s_gyro_bias_2;
    const real Q_0_0 = dt * (q_0 + q_2 * ((r0_q_nb_0 * r0_q_nb_0) + (r0_q_nb_1 * r0_q_nb_1) + (r0_q_nb_2 * r0_q_nb_2)));
    const real Q_3_3 = dt * q_1;
    Q[0] = Q_0_0;
    Q[1] = R(0.0);
    Q[2] = R(0.0);
    Q[3] = R(0.0);
    Q[4] = R(0.0);
    Q[5] = R(0.0);
    Q[6] = Q_0_0;
    Q[7] = R(0.0);
    Q[8] = R(0.0);
    Q[9] = R(0.0);
    Q[10] = R(0.0);
    Q[11] = Q_0_0;
    Q[12] = R(0.0);
    Q[13] = R(0.0);
    Q[14] = R(0.0);
    Q[15] = Q_3_3;
    Q[16] = R(0.0);
    Q[17] = R(0.0);
    Q[18] = Q_3_3;
    Q[19] = R(0.0);
    Q[20] = Q_3_3;
}

RN_INLINE void rn_attitude_inject(real *x, const real *e)
{
    const real s_q_nb_0 = x[0];
    const real s_q_nb_1 = x[1];
    const real s_q_nb_2 = x[2];
    const real s_q_nb_3 = x[3];
    const real s_gyro_bias_0 = x[4];
    const real s_gyro_bias_1 = x[5];
    const real s_gyro_bias_2 = x[6];
    const real e_0 = e[0];
    const real e_1 = e[1];
    const real e_2 = e[2];
    const real e_3 = e[3];
    const real e_4 = e[4];
    const real e_5 = e[5];
    const real t_0 = R(0.5) * e_2;
    const real t_1 = R(0.5) * e_1;
    const real t_2 = R(0.5) * e_0;
    const real turned_0 = s_q_nb_0 - s_q_nb_3 * t_0 - s_q_nb_2 * t_1 - s_q_nb_1 * t_2;
    const real turned_1 = s_q_nb_1 + s_q_nb_3 * t_1 + s_q_nb_0 * t_2 - s_q_nb_2 * t_0;
    const real turned_2 = s_q_nb_2 + s_q_nb_1 * t_0 + s_q_nb_0 * t_1 - s_q_nb_3 * t_2;
    const real turned_3 = s_q_nb_3 + s_q_nb_0 * t_0 + s_q_nb_2 * t_2 - s_q_nb_1 * t_1;
    const real scale = R(1.0) / rn_sqrt(((turned_0 * turned_0) + (turned_1 * turned_1) + (turned_2 * turned_2) + (turned_3 * turned_3)));
    x[0] = scale * turned_0;
    x[1] = scale * turned_1;
    x[2] = scale * turned_2;
    x[3] = scale * turned_3;
    x[4] = e_3 + s_gyro_bias_0;
    x[5] = e_4 + s_gyro_bias_1;
    x[6] = e_5 + s_gyro_bias_2;
}

RN_INLINE void rn_attitude_inject_turned(real *x, const real *e)
{
    const real s_q_nb_0 = x[0];
    const real s_q_nb_1 = x[1];
    const real s_q_nb_2 = x[2];
    const real s_q_nb_3 = x[3];
    const real s_gyro_bias_0 = x[4];
    const real s_gyro_bias_1 = x[5];
    const real s_gyro_bias_2 = x[6];
    const real e_0 = e[0];
    const real e_1 = e[1];
    const real e_2 = e[2];
    const real e_3 = e[3];
    const real e_4 = e[4];
    const real e_5 = e[5];
    const real t_0 = R(0.5) * e_2;
    const real t_1 = R(0.5) * e_1;
    const real t_2 = R(0.5) * e_0;
    const real turned_0 = s_q_nb_0 - s_q_nb_3 * t_0 - s_q_nb_2 * t_1 - s_q_nb_1 * t_2;
    const real turned_1 = s_q_nb_1 + s_q_nb_3 * t_1 + s_q_nb_0 * t_2 - s_q_nb_2 * t_0;
    const real turned_2 = s_q_nb_2 + s_q_nb_1 * t_0 + s_q_nb_0 * t_1 - s_q_nb_3 * t_2;
    const real turned_3 = s_q_nb_3 + s_q_nb_0 * t_0 + s_q_nb_2 * t_2 - s_q_nb_1 * t_1;
    const real scale = R(1.0) / rn_sqrt(((turned_0 * turned_0) + (turned_1 * turned_1) + (turned_2 * turned_2) + (turned_3 * turned_3)));
    const real t_3 = s_q_nb_0 * s_q_nb_2;
    const real t_4 = s_q_nb_1 * s_q_nb_3;
    const real t_5 = R(2.0) * e_5;
    const real t_6 = s_q_nb_0 * s_q_nb_3;
    const real t_7 = s_q_nb_1 * s_q_nb_2;
    const real t_8 = R(2.0) * e_4;
    const real t_9 = s_q_nb_3 * s_q_nb_3;
    const real t_10 = s_q_nb_2 * s_q_nb_2;
    const real t_11 = s_q_nb_0 * s_q_nb_1;
    const real t_12 = s_q_nb_2 * s_q_nb_3;
    const real t_13 = s_q_nb_1 * s_q_nb_1;
    const real t_14 = R(2.0) * e_3;
    x[0] = scale * turned_0;
    x[1] = scale * turned_1;
    x[2] = scale * turned_2;
    x[3] = scale * turned_3;
    x[4] = (t_4 - t_3) * t_5 + (t_6 + t_7) * t_8 + (R(1.0) - R(2.0) * (t_10 + t_9)) * e_3 + s_gyro_bias_0;
    x[5] = (t_7 - t_6) * t_14 + (t_11 + t_12) * t_5 + (R(1.0) - R(2.0) * (t_13 + t_9)) * e_4 + s_gyro_bias_1;
    x[6] = (t_12 - t_11) * t_8 + (R(1.0) - R(2.0) * (t_10 + t_13)) * e_5 + t_14 * (t_3 + t_4) + s_gyro_bias_2;
}

RN_INLINE void rn_attitude_difference(const real *a, const real *b, real *e)
{
    const real a_0 = a[0];
    const real a_1 = a[1];
    const real a_2 = a[2];
    const real a_3 = a[3];
    const real a_4 = a[4];
    const real a_5 = a[5];
    const real a_6 = a[6];
    const real b_0 = b[0];
    const real b_1 = b[1];
    const real b_2 = b[2];
    const real b_3 = b[3];
    const real b_4 = b[4];
    const real b_5 = b[5];
    const real b_6 = b[6];
    const real half_w = R(0.5) * (a_0 * b_0 + a_1 * b_1 + a_2 * b_2 + a_3 * b_3);
    const real t_0 = R(1.0) / half_w;
    e[0] = (a_1 * b_0 + a_3 * b_2 - a_0 * b_1 - a_2 * b_3) * t_0;
    e[1] = (a_1 * b_3 + a_2 * b_0 - a_0 * b_2 - a_3 * b_1) * t_0;
    e[2] = (a_2 * b_1 + a_3 * b_0 - a_0 * b_3 - a_1 * b_2) * t_0;
    e[3] = a_4 - b_4;
    e[4] = a_5 - b_5;
    e[5] = a_6 - b_6;
}

RN_VECTORISED static void rn_attitude_carry(const real *a, const real *b, const real *u, const real *p, real dt, real *e)
{
    RN_UNUSED(p);
    const real u_gyro_0 = u[0];
    const real u_gyro_1 = u[1];
    const real u_gyro_2 = u[2];
    const real a_0 = a[0];
    const real a_1 = a[1];
    const real a_2 = a[2];
    const real a_3 = a[3];
    const real a_4 = a[4];
    const real a_5 = a[5];
    const real a_6 = a[6];
    const real b_0 = b[0];
    const real b_1 = b[1];
    const real b_2 = b[2];
    const real b_3 = b[3];
    for (int k = 0; k < 12; k++) {
        const real e_0 = e[0 + k];
        const real e_1 = e[12 + k];
        const real e_2 = e[24 + k];
        const real e_3 = e[36 + k];
        const real e_4 = e[48 + k];
        const real e_5 = e[60 + k];
        const real t_0 = R(0.5) * a_3;
        const real t_1 = R(0.5) * a_2;
        const real t_2 = R(0.5) * e_0;
        const real turned_0 = a_0 - e_2 * t_0 - e_1 * t_1 - a_1 * t_2;
        const real turned_1 = a_1 + e_1 * t_0 + a_0 * t_2 - e_2 * t_1;
        const real t_3 = R(0.5) * a_1;
        const real t_4 = R(0.5) * a_0;
        const real turned_2 = a_2 + e_2 * t_3 + e_1 * t_4 - a_3 * t_2;
        const real turned_3 = a_3 + a_2 * t_2 + e_2 * t_4 - e_1 * t_3;
        const real scale = R(1.0) / rn_sqrt(((turned_0 * turned_0) + (turned_1 * turned_1) + (turned_2 * turned_2) + (turned_3 * turned_3)));
        const real s_q_nb_0 = scale * turned_0;
        const real s_q_nb_1 = scale * turned_1;
        const real s_q_nb_2 = scale * turned_2;
        const real s_q_nb_3 = scale * turned_3;
        const real s_gyro_bias_0 = a_4 + e_3;
        const real r0_q_nb_0 = u_gyro_0 - s_gyro_bias_0;
        const real phi_0 = dt * r0_q_nb_0;
        const real s_gyro_bias_1 = a_5 + e_4;
        const real r0_q_nb_1 = u_gyro_1 - s_gyro_bias_1;
        const real phi_1 = dt * r0_q_nb_1;
        const real s_gyro_bias_2 = a_6 + e_5;
        const real r0_q_nb_2 = u_gyro_2 - s_gyro_bias_2;
        const real phi_2 = dt * r0_q_nb_2;
        const real phi_square = (phi_0 * phi_0) + (phi_1 * phi_1) + (phi_2 * phi_2);
        const real half_sinc = R(0.5) - R(0.020833333333333332) * phi_square;
        const real t_5 = half_sinc * phi_1;
        const real t_6 = half_sinc * phi_2;
        const real t_7 = half_sinc * phi_0;
        const real t_8 = R(0.0026041666666666665) * (phi_square * phi_square) + R(1.0) - R(0.125) * phi_square;
        const real n_0 = s_q_nb_0 * t_8 - s_q_nb_2 * t_5 - s_q_nb_3 * t_6 - s_q_nb_1 * t_7;
        const real n_2 = s_q_nb_0 * t_5 + s_q_nb_3 * t_7 + s_q_nb_2 * t_8 - s_q_nb_1 * t_6;
        const real n_3 = s_q_nb_1 * t_5 + s_q_nb_0 * t_6 + s_q_nb_3 * t_8 - s_q_nb_2 * t_7;
        const real n_1 = s_q_nb_2 * t_6 + s_q_nb_0 * t_7 + s_q_nb_1 * t_8 - s_q_nb_3 * t_5;
        const real newton = R(1.5) - R(0.5) * ((n_0 * n_0) + (n_1 * n_1) + (n_2 * n_2) + (n_3 * n_3));
        const real t_9 = b_3 * newton;
        const real t_10 = b_2 * newton;
        const real t_11 = n_1 * newton;
        const real t_12 = b_1 * newton;
        const real t_13 = b_0 * newton;
        const real half_w = R(0.5) * (n_3 * t_9 + n_2 * t_10 + b_1 * t_11 + n_0 * t_13);
        const real t_14 = R(1.0) / half_w;
        e[0 + k] = (n_3 * t_10 + b_0 * t_11 - n_2 * t_9 - n_0 * t_12) * t_14;
        e[12 + k] = (b_3 * t_11 + n_2 * t_13 - n_0 * t_10 - n_3 * t_12) * t_14;
        e[24 + k] = (n_3 * t_13 + n_2 * t_12 - n_0 * t_9 - b_2 * t_11) * t_14;
    }
}

RN_INLINE void rn_attitude_measure_accel(const real *x, const real *z, const real *p, real *h)
{
    RN_UNUSED(z);
    const real s_q_nb_0 = x[0];
    const real s_q_nb_1 = x[1];
    const real s_q_nb_2 = x[2];
    const real s_q_nb_3 = x[3];
    const real p_gravity = p[0];
    const real t_0 = R(2.0) * p_gravity;
    h[0] = -((s_q_nb_1 * s_q_nb_3 - s_q_nb_0 * s_q_nb_2) * t_0);
    h[1] = -((s_q_nb_0 * s_q_nb_1 + s_q_nb_2 * s_q_nb_3) * t_0);
    h[2] = -((R(1.0) - R(2.0) * ((s_q_nb_1 * s_q_nb_1) + (s_q_nb_2 * s_q_nb_2))) * p_gravity);
}

RN_INLINE void rn_attitude_residual_accel(const real *x, const real *z, const real *p, real *r)
{
    RN_UNUSED(p);
    const real s_q_nb_0 = x[0];
    const real s_q_nb_1 = x[1];
    const real s_q_nb_2 = x[2];
    const real s_q_nb_3 = x[3];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real t_0 = s_q_nb_3 * s_q_nb_3;
    const real t_1 = R(2.0) * z_2;
    const real t_2 = s_q_nb_1 * s_q_nb_2;
    const real t_3 = s_q_nb_0 * s_q_nb_3;
    r[0] = (s_q_nb_0 * s_q_nb_2 + s_q_nb_1 * s_q_nb_3) * t_1 + R(2.0) * (t_2 - t_3) * z_1 + (R(1.0) - R(2.0) * ((s_q_nb_2 * s_q_nb_2) + t_0)) * z_0;
    r[1] = (s_q_nb_2 * s_q_nb_3 - s_q_nb_0 * s_q_nb_1) * t_1 + R(2.0) * (t_2 + t_3) * z_0 + (R(1.0) - R(2.0) * ((s_q_nb_1 * s_q_nb_1) + t_0)) * z_1;
}

RN_INLINE void rn_attitude_jacobian_accel(const real *x, const real *z, const real *p, real *H)
{
    RN_UNUSED(x);
    RN_UNUSED(z);
    const real p_gravity = p[0];
    H[0] = R(0.0);
    H[1] = p_gravity;
    H[2] = R(0.0);
    H[3] = R(0.0);
    H[4] = R(0.0);
    H[5] = R(0.0);
    H[6] = -p_gravity;
    H[7] = R(0.0);
    H[8] = R(0.0);
    H[9] = R(0.0);
    H[10] = R(0.0);
    H[11] = R(0.0);
}

RN_INLINE void rn_attitude_innovation_accel(const real *x, const real *z, const real *p, real *r)
{
    const real s_q_nb_0 = x[0];
    const real s_q_nb_1 = x[1];
    const real s_q_nb_2 = x[2];
    const real s_q_nb_3 = x[3];
    const real p_gravity = p[0];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real t_0 = R(2.0) * p_gravity;
    r[0] = (s_q_nb_1 * s_q_nb_3 - s_q_nb_0 * s_q_nb_2) * t_0 + z_0;
    r[1] = (s_q_nb_0 * s_q_nb_1 + s_q_nb_2 * s_q_nb_3) * t_0 + z_1;
    r[2] = (R(1.0) - R(2.0) * ((s_q_nb_1 * s_q_nb_1) + (s_q_nb_2 * s_q_nb_2))) * p_gravity + z_2;
}

RN_INLINE real rn_attitude_update_accel(real *x, real *P, const real *z, real variance, RN(rule) rule, const real *p, real *nu, real *s, real *nis)
{
    const real s_q_nb_0 = x[0];
    const real s_q_nb_1 = x[1];
    const real s_q_nb_2 = x[2];
    const real s_q_nb_3 = x[3];
    const real p_gravity = p[0];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real t_0 = s_q_nb_3 * s_q_nb_3;
    const real t_1 = R(2.0) * z_2;
    const real t_2 = s_q_nb_1 * s_q_nb_2;
    const real t_3 = s_q_nb_0 * s_q_nb_3;
    const real r_0 = (s_q_nb_0 * s_q_nb_2 + s_q_nb_1 * s_q_nb_3) * t_1 + R(2.0) * (t_2 - t_3) * z_1 + (R(1.0) - R(2.0) * ((s_q_nb_2 * s_q_nb_2) + t_0)) * z_0;
    const real r_1 = (s_q_nb_2 * s_q_nb_3 - s_q_nb_0 * s_q_nb_1) * t_1 + R(2.0) * (t_2 + t_3) * z_0 + (R(1.0) - R(2.0) * ((s_q_nb_1 * s_q_nb_1) + t_0)) * z_1;
    const real H_0_1 = p_gravity;
    const real H_1_0 = -p_gravity;
    real L[21], dx[6];
    int refused = 0;
    memcpy(L, P, sizeof L);
    for (int i = 0; i < 6; i++) dx[i] = R(0.0);
    *nis = R(0.0);
    {
        const real PH[6] = {H_0_1 * L[1], H_0_1 * L[6], H_0_1 * L[7], H_0_1 * L[8], H_0_1 * L[9], H_0_1 * L[10]};
        s[0] = variance + H_0_1 * PH[1];
        nu[0] = r_0 - (H_0_1 * dx[1]);
        refused += rn_scalar_update(L, dx, PH, 6, s[0], variance, nu[0], nis);
    }
    {
        const real PH[6] = {H_1_0 * L[0], H_1_0 * L[1], H_1_0 * L[2], H_1_0 * L[3], H_1_0 * L[4], H_1_0 * L[5]};
        s[1] = variance + H_1_0 * PH[0];
        nu[1] = r_1 - (H_1_0 * dx[0]);
        refused += rn_scalar_update(L, dx, PH, 6, s[1], variance, nu[1], nis);
    }
    const real weight = refused ? R(0.0) : rn_weight(rule, *nis, R(2.0));
    if (!(weight > R(0.0))) return R(0.0);
    if (weight < R(1.0)) rn_soften(L, P, 21, dx, 6, weight);
    memcpy(P, L, sizeof L);
    rn_attitude_inject(x, dx);
    return weight;
}

RN_INLINE void rn_attitude_measure_mag(const real *x, const real *z, const real *p, real *h)
{
    RN_UNUSED(z);
    const real s_q_nb_0 = x[0];
    const real s_q_nb_1 = x[1];
    const real s_q_nb_2 = x[2];
    const real s_q_nb_3 = x[3];
    const real p_mag_north = p[1];
    const real p_mag_down = p[2];
    const real t_0 = s_q_nb_2 * s_q_nb_2;
    const real t_1 = s_q_nb_1 * s_q_nb_3;
    const real t_2 = s_q_nb_0 * s_q_nb_2;
    const real t_3 = R(2.0) * p_mag_down;
    const real t_4 = R(2.0) * p_mag_north;
    h[0] = (R(1.0) - R(2.0) * ((s_q_nb_3 * s_q_nb_3) + t_0)) * p_mag_north + (t_1 - t_2) * t_3;
    h[1] = (s_q_nb_1 * s_q_nb_2 - s_q_nb_0 * s_q_nb_3) * t_4 + (s_q_nb_0 * s_q_nb_1 + s_q_nb_2 * s_q_nb_3) * t_3;
    h[2] = (t_1 + t_2) * t_4 + (R(1.0) - R(2.0) * ((s_q_nb_1 * s_q_nb_1) + t_0)) * p_mag_down;
}

RN_INLINE void rn_attitude_residual_mag(const real *x, const real *z, const real *p, real *r)
{
    const real s_q_nb_0 = x[0];
    const real s_q_nb_1 = x[1];
    const real s_q_nb_2 = x[2];
    const real s_q_nb_3 = x[3];
    const real p_mag_north = p[1];
    const real p_mag_down = p[2];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real t_0 = s_q_nb_2 * s_q_nb_2;
    const real t_1 = s_q_nb_3 * s_q_nb_3;
    const real t_2 = s_q_nb_1 * s_q_nb_3;
    const real t_3 = s_q_nb_0 * s_q_nb_2;
    const real t_4 = R(2.0) * z_2;
    const real t_5 = s_q_nb_1 * s_q_nb_2;
    const real t_6 = s_q_nb_0 * s_q_nb_3;
    const real t_7 = R(2.0) * z_1;
    const real t_8 = R(2.0) * z_0;
    const real t_9 = s_q_nb_1 * s_q_nb_1;
    const real t_10 = s_q_nb_2 * s_q_nb_3;
    const real t_11 = s_q_nb_0 * s_q_nb_1;
    r[0] = (R(1.0) - R(2.0) * (t_0 + t_1)) * z_0 + (t_2 + t_3) * t_4 + (t_5 - t_6) * t_7 - p_mag_north;
    r[1] = (R(1.0) - R(2.0) * (t_1 + t_9)) * z_1 + (t_10 - t_11) * t_4 + (t_5 + t_6) * t_8;
    r[2] = (R(1.0) - R(2.0) * (t_0 + t_9)) * z_2 + (t_10 + t_11) * t_7 + (t_2 - t_3) * t_8 - p_mag_down;
}

RN_INLINE void rn_attitude_jacobian_mag(const real *x, const real *z, const real *p, real *H)
{
    RN_UNUSED(x);
    RN_UNUSED(z);
    const real p_mag_north = p[1];
    const real p_mag_down = p[2];
    H[0] = R(0.0);
    H[1] = -p_mag_down;
    H[2] = R(0.0);
    H[3] = R(0.0);
    H[4] = R(0.0);
    H[5] = R(0.0);
    H[6] = p_mag_down;
    H[7] = R(0.0);
    H[8] = -p_mag_north;
    H[9] = R(0.0);
    H[10] = R(0.0);
    H[11] = R(0.0);
    H[12] = R(0.0);
    H[13] = p_mag_north;
    H[14] = R(0.0);
    H[15] = R(0.0);
    H[16] = R(0.0);
    H[17] = R(0.0);
}

RN_INLINE void rn_attitude_innovation_mag(const real *x, const real *z, const real *p, real *r)
{
    const real s_q_nb_0 = x[0];
    const real s_q_nb_1 = x[1];
    const real s_q_nb_2 = x[2];
    const real s_q_nb_3 = x[3];
    const real p_mag_north = p[1];
    const real p_mag_down = p[2];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real t_0 = s_q_nb_2 * s_q_nb_2;
    const real t_1 = s_q_nb_1 * s_q_nb_3;
    const real t_2 = s_q_nb_0 * s_q_nb_2;
    const real t_3 = R(2.0) * p_mag_down;
    const real t_4 = R(2.0) * p_mag_north;
    r[0] = z_0 - (((R(1.0) - R(2.0) * ((s_q_nb_3 * s_q_nb_3) + t_0)) * p_mag_north + (t_1 - t_2) * t_3));
    r[1] = z_1 - (((s_q_nb_1 * s_q_nb_2 - s_q_nb_0 * s_q_nb_3) * t_4 + (s_q_nb_0 * s_q_nb_1 + s_q_nb_2 * s_q_nb_3) * t_3));
    r[2] = z_2 - (((t_1 + t_2) * t_4 + (R(1.0) - R(2.0) * ((s_q_nb_1 * s_q_nb_1) + t_0)) * p_mag_down));
}

RN_INLINE real rn_attitude_update_mag(real *x, real *P, const real *z, real variance, RN(rule) rule, const real *p, real *nu, real *s, real *nis)
{
    const real s_q_nb_0 = x[0];
    const real s_q_nb_1 = x[1];
    const real s_q_nb_2 = x[2];
    const real s_q_nb_3 = x[3];
    const real p_mag_north = p[1];
    const real p_mag_down = p[2];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real t_0 = s_q_nb_2 * s_q_nb_2;
    const real t_1 = s_q_nb_3 * s_q_nb_3;
    const real t_2 = s_q_nb_1 * s_q_nb_3;
    const real t_3 = s_q_nb_0 * s_q_nb_2;
    const real t_4 = R(2.0) * z_2;
    const real t_5 = s_q_nb_1 * s_q_nb_2;
    const real t_6 = s_q_nb_0 * s_q_nb_3;
    const real t_7 = R(2.0) * z_1;
    const real t_8 = -p_mag_north;
    const real t_9 = R(2.0) * z_0;
    const real t_10 = s_q_nb_1 * s_q_nb_1;
    const real t_11 = s_q_nb_2 * s_q_nb_3;
    const real t_12 = s_q_nb_0 * s_q_nb_1;
    const real t_13 = -p_mag_down;
    const real r_0 = (R(1.0) - R(2.0) * (t_0 + t_1)) * z_0 + (t_2 + t_3) * t_4 + (t_5 - t_6) * t_7 + t_8;
    const real r_1 = (t_11 - t_12) * t_4 + (t_5 + t_6) * t_9 + (R(1.0) - R(2.0) * (t_1 + t_10)) * z_1;
    const real r_2 = (t_11 + t_12) * t_7 + (t_2 - t_3) * t_9 + t_13 + (R(1.0) - R(2.0) * (t_0 + t_10)) * z_2;
    const real H_0_1 = t_13;
    const real H_1_0 = p_mag_down;
    const real H_1_2 = t_8;
    const real H_2_1 = p_mag_north;
    real L[21], dx[6];
    int refused = 0;
    memcpy(L, P, sizeof L);
    for (int i = 0; i < 6; i++) dx[i] = R(0.0);
    *nis = R(0.0);
    {
        const real PH[6] = {H_0_1 * L[1], H_0_1 * L[6], H_0_1 * L[7], H_0_1 * L[8], H_0_1 * L[9], H_0_1 * L[10]};
        s[0] = variance + H_0_1 * PH[1];
        nu[0] = r_0 - (H_0_1 * dx[1]);
        refused += rn_scalar_update(L, dx, PH, 6, s[0], variance, nu[0], nis);
    }
    {
        const real PH[6] = {H_1_0 * L[0] + H_1_2 * L[2], H_1_0 * L[1] + H_1_2 * L[7], H_1_0 * L[2] + H_1_2 * L[11], H_1_0 * L[3] + H_1_2 * L[12], H_1_0 * L[4] + H_1_2 * L[13], H_1_0 * L[5] + H_1_2 * L[14]};
        s[1] = variance + H_1_0 * PH[0] + H_1_2 * PH[2];
        nu[1] = r_1 - (H_1_0 * dx[0] + H_1_2 * dx[2]);
        refused += rn_scalar_update(L, dx, PH, 6, s[1], variance, nu[1], nis);
    }
    {
        const real PH[6] = {H_2_1 * L[1], H_2_1 * L[6], H_2_1 * L[7], H_2_1 * L[8], H_2_1 * L[9], H_2_1 * L[10]};
        s[2] = variance + H_2_1 * PH[1];
        nu[2] = r_2 - (H_2_1 * dx[1]);
        refused += rn_scalar_update(L, dx, PH, 6, s[2], variance, nu[2], nis);
    }
    const real weight = refused ? R(0.0) : rn_weight(rule, *nis, R(3.0));
    if (!(weight > R(0.0))) return R(0.0);
    if (weight < R(1.0)) rn_soften(L, P, 21, dx, 6, weight);
    memcpy(P, L, sizeof L);
    rn_attitude_inject(x, dx);
    return weight;
}

RN_INLINE void rn_attitude_gain(const real *K, const real *r, real *e)
{
    e[0] = K[1] * r[1] + K[3] * r[3];
    e[1] = K[5] * r[0] + K[7] * r[2] + K[9] * r[4];
    e[2] = K[11] * r[1] + K[13] * r[3];
    e[3] = K[16] * r[1] + K[18] * r[3];
    e[4] = K[20] * r[0] + K[22] * r[2] + K[24] * r[4];
    e[5] = K[26] * r[1] + K[28] * r[3];
}

RN_INLINE void rn_attitude_correct(real *x, const real *z, const real *K, const real *p, real *r)
{
    const real s_q_nb_0 = x[0];
    const real s_q_nb_1 = x[1];
    const real s_q_nb_2 = x[2];
    const real s_q_nb_3 = x[3];
    const real s_gyro_bias_0 = x[4];
    const real s_gyro_bias_1 = x[5];
    const real s_gyro_bias_2 = x[6];
    const real p_mag_north = p[1];
    const real p_mag_down = p[2];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real z_3 = z[3];
    const real z_4 = z[4];
    const real z_5 = z[5];
    const real K_1 = K[1];
    const real K_3 = K[3];
    const real K_5 = K[5];
    const real K_7 = K[7];
    const real K_9 = K[9];
    const real K_11 = K[11];
    const real K_13 = K[13];
    const real K_16 = K[16];
    const real K_18 = K[18];
    const real K_20 = K[20];
    const real K_22 = K[22];
    const real K_24 = K[24];
    const real K_26 = K[26];
    const real K_28 = K[28];
    const real t_0 = s_q_nb_1 * s_q_nb_2;
    const real t_1 = s_q_nb_0 * s_q_nb_3;
    const real t_2 = t_0 + t_1;
    const real t_3 = R(2.0) * t_2;
    const real t_4 = s_q_nb_3 * s_q_nb_3;
    const real t_5 = s_q_nb_1 * s_q_nb_1;
    const real t_6 = R(1.0) - R(2.0) * (t_4 + t_5);
    const real t_7 = s_q_nb_2 * s_q_nb_3;
    const real t_8 = s_q_nb_0 * s_q_nb_1;
    const real t_9 = R(2.0) * (t_7 - t_8);
    const real r_1 = t_3 * z_0 + t_6 * z_1 + t_9 * z_2;
    const real t_10 = R(2.0) * z_3;
    const real r_3 = t_2 * t_10 + t_6 * z_4 + t_9 * z_5;
    const real de_2 = K_11 * r_1 + K_13 * r_3;
    const real t_11 = R(0.5) * de_2;
    const real t_12 = s_q_nb_2 * s_q_nb_2;
    const real t_13 = R(1.0) - R(2.0) * (t_12 + t_4);
    const real t_14 = s_q_nb_1 * s_q_nb_3;
    const real t_15 = s_q_nb_0 * s_q_nb_2;
    const real t_16 = R(2.0) * (t_14 + t_15);
    const real t_17 = t_0 - t_1;
    const real t_18 = R(2.0) * t_17;
    const real r_0 = t_13 * z_0 + t_16 * z_2 + t_18 * z_1;
    const real t_19 = R(2.0) * z_4;
    const real r_2 = t_13 * z_3 + t_16 * z_5 + t_19 * t_17 - p_mag_north;
    const real t_20 = t_14 - t_15;
    const real t_21 = t_7 + t_8;
    const real t_22 = R(1.0) - R(2.0) * (t_12 + t_5);
    const real r_4 = t_10 * t_20 + t_19 * t_21 + t_22 * z_5 - p_mag_down;
    const real de_1 = K_5 * r_0 + K_7 * r_2 + K_9 * r_4;
    const real t_23 = R(0.5) * de_1;
    const real de_0 = K_1 * r_1 + K_3 * r_3;
    const real t_24 = R(0.5) * de_0;
    const real turned_0 = s_q_nb_0 - s_q_nb_3 * t_11 - s_q_nb_2 * t_23 - s_q_nb_1 * t_24;
    const real turned_1 = s_q_nb_1 + s_q_nb_3 * t_23 + s_q_nb_0 * t_24 - s_q_nb_2 * t_11;
    const real turned_2 = s_q_nb_2 + s_q_nb_1 * t_11 + s_q_nb_0 * t_23 - s_q_nb_3 * t_24;
    const real turned_3 = s_q_nb_3 + s_q_nb_0 * t_11 + s_q_nb_2 * t_24 - s_q_nb_1 * t_23;
    const real scale = R(1.0) / rn_sqrt(((turned_0 * turned_0) + (turned_1 * turned_1) + (turned_2 * turned_2) + (turned_3 * turned_3)));
    const real de_3 = K_16 * r_1 + K_18 * r_3;
    const real de_4 = K_20 * r_0 + K_22 * r_2 + K_24 * r_4;
    const real de_5 = K_26 * r_1 + K_28 * r_3;
    const real t_25 = R(2.0) * de_5;
    x[0] = scale * turned_0;
    x[1] = scale * turned_1;
    x[2] = scale * turned_2;
    x[3] = scale * turned_3;
    x[4] = s_gyro_bias_0 + de_4 * t_3 + de_3 * t_13 + t_20 * t_25;
    x[5] = s_gyro_bias_1 + de_4 * t_6 + t_21 * t_25 + de_3 * t_18;
    x[6] = s_gyro_bias_2 + de_4 * t_9 + de_5 * t_22 + de_3 * t_16;
    r[0] = r_0;
    r[1] = r_1;
    r[2] = r_2;
    r[3] = r_3;
    r[4] = r_4;
}

static const RN(sensor) rn_attitude_sensors[] = {
    {"accel", 3, 3, 2, 2, rn_attitude_measure_accel, rn_attitude_residual_accel, rn_attitude_jacobian_accel, rn_attitude_innovation_accel, rn_attitude_update_accel},
    {"mag", 3, 3, 3, 3, rn_attitude_measure_mag, rn_attitude_residual_mag, rn_attitude_jacobian_mag, rn_attitude_innovation_mag, rn_attitude_update_mag}};
static const RN(model) rn_attitude_model = {
    RN_ABI, (int)sizeof(real), "attitude", 7, 6, 3, 3, 3, 2, 3, rn_attitude_sensors,
    rn_attitude_propagate, rn_attitude_predict, rn_attitude_transition, rn_attitude_noise, rn_attitude_inject, rn_attitude_inject_turned, rn_attitude_difference, rn_attitude_carry, rn_attitude_gain, rn_attitude_correct};

#endif
