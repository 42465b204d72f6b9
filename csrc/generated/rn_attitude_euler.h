/* Generated from the model 'attitude_euler'; do not edit: make generate. */
/* clang-format off */
#ifndef RN_GENERATED_ATTITUDE_EULER_H
#define RN_GENERATED_ATTITUDE_EULER_H
#include "rn_model.h"
#include "rn_update.h"

/* state, error (quaternions: small rotation, rad), input, parameters:
 *   x[0..2], e[0..2]  euler [rad]
 *   x[3..5], e[3..5]  gyro_bias [rad/s]
 *   u[0..2]  gyro [rad/s]
 *   p[0]  gravity
 *   p[1]  mag_north
 *   p[2]  mag_down
 *   reading accel: z[0..2] [m/s^2]
 *   reading mag: z[0..2] [T]
 *   q[0]  intensity of gyro_noise [(rad/s/sqrt(Hz))^2]
 *   q[1]  intensity of gyro_bias_noise [(rad/s^2/sqrt(Hz))^2] */

RN_INLINE void rn_attitude_euler_propagate(real *x, const real *u, const real *p, real dt)
{
    RN_UNUSED(p);
    const real s_euler_0 = x[0];
    const real s_euler_1 = x[1];
    const real s_euler_2 = x[2];
    const real s_gyro_bias_0 = x[3];
    const real s_gyro_bias_1 = x[4];
    const real s_gyro_bias_2 = x[5];
    const real u_gyro_0 = u[0];
    const real u_gyro_1 = u[1];
    const real u_gyro_2 = u[2];
    const real t_0 = u_gyro_1 - s_gyro_bias_1;
    const real t_1 = rn_sin(s_euler_0);
    const real t_2 = u_gyro_2 - s_gyro_bias_2;
    const real t_3 = rn_cos(s_euler_0);
    const real r0_euler_1 = t_0 * t_3 - t_1 * t_2;
    const real t_4 = R(0.5) * dt;
    const real m_1 = s_euler_1 + r0_euler_1 * t_4;
    const real r0_euler_2 = (t_0 * t_1 + t_2 * t_3) / rn_cos(s_euler_1);
    const real t_5 = u_gyro_0 - s_gyro_bias_0;
    const real r0_euler_0 = rn_sin(s_euler_1) * r0_euler_2 + t_5;
    const real m_0 = s_euler_0 + r0_euler_0 * t_4;
    const real t_6 = rn_sin(m_0);
    const real t_7 = rn_cos(m_0);
    const real r_euler_2 = (t_0 * t_6 + t_2 * t_7) / rn_cos(m_1);
    const real r_euler_0 = t_5 + rn_sin(m_1) * r_euler_2;
    const real r_euler_1 = t_0 * t_7 - t_2 * t_6;
    x[0] = dt * r_euler_0 + s_euler_0;
    x[1] = dt * r_euler_1 + s_euler_1;
    x[2] = dt * r_euler_2 + s_euler_2;
    x[3] = s_gyro_bias_0;
    x[4] = s_gyro_bias_1;
    x[5] = s_gyro_bias_2;
}

RN_INLINE void rn_attitude_euler_predict(real *x, real *P, const real *u, const real *q, const real *p, real dt)
{
    RN_UNUSED(p);
    const real s_euler_0 = x[0];
    const real s_euler_1 = x[1];
    const real s_euler_2 = x[2];
    const real s_gyro_bias_0 = x[3];
    const real s_gyro_bias_1 = x[4];
    const real s_gyro_bias_2 = x[5];
    const real u_gyro_0 = u[0];
    const real u_gyro_1 = u[1];
    const real u_gyro_2 = u[2];
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
    const real A0_1_5 = rn_sin(s_euler_0);
    const real t_0 = u_gyro_1 - s_gyro_bias_1;
    const real t_1 = t_0 * A0_1_5;
    const real t_2 = u_gyro_2 - s_gyro_bias_2;
    const real t_3 = rn_cos(s_euler_0);
    const real t_4 = t_2 * t_3;
    const real t_5 = t_1 + t_4;
    const real t_6 = rn_cos(s_euler_1);
    const real t_7 = R(1.0) / t_6;
    const real r0_euler_2 = t_5 * t_7;
    const real t_8 = rn_sin(s_euler_1);
    const real t_9 = u_gyro_0 - s_gyro_bias_0;
    const real r0_euler_0 = t_8 * r0_euler_2 + t_9;
    const real t_10 = R(0.5) * dt;
    const real m_0 = s_euler_0 + r0_euler_0 * t_10;
    const real A_1_5 = rn_sin(m_0);
    const real t_11 = t_0 * A_1_5;
    const real t_12 = rn_cos(m_0);
    const real t_13 = t_12 * t_2;
    const real t_14 = t_11 + t_13;
    const real r0_euler_1 = t_0 * t_3 - A0_1_5 * t_2;
    const real m_1 = s_euler_1 + r0_euler_1 * t_10;
    const real t_15 = rn_cos(m_1);
    const real t_16 = R(1.0) / t_15;
    const real r_euler_2 = t_14 * t_16;
    const real t_17 = rn_sin(m_1);
    const real r_euler_0 = t_9 + t_17 * r_euler_2;
    const real r_euler_1 = t_0 * t_12 - A_1_5 * t_2;
    const real A0_1_0 = -t_1 - t_4;
    const real A_2_0 = t_16 * r_euler_1;
    const real A_0_0 = t_17 * A_2_0;
    const real t_18 = t_17 * t_17;
    const real t_19 = R(1.0) / (t_15 * t_15);
    const real t_20 = t_14 * t_19;
    const real A_0_1 = t_14 + t_18 * t_20;
    const real t_21 = A_0_1 * t_10;
    const real A0_2_0 = r0_euler_1 * t_7;
    const real A0_0_0 = t_8 * A0_2_0;
    const real t_22 = R(1.0) + A0_0_0 * t_10;
    const real F_0_0 = R(1.0) + dt * (A0_1_0 * t_21 + A_0_0 * t_22);
    const real t_23 = t_5 / (t_6 * t_6);
    const real A0_0_1 = (t_8 * t_8) * t_23 + t_5;
    const real t_24 = A_0_0 * t_10;
    const real F_0_1 = (A_0_1 + A0_0_1 * t_24) * dt;
    const real F_0_3 = (-R(1.0) - t_24) * dt;
    const real t_25 = A0_1_5 * t_7;
    const real A0_0_4 = -(t_8 * t_25);
    const real A0_1_4 = -t_3;
    const real t_26 = A_1_5 * t_16;
    const real A_0_4 = -(t_17 * t_26);
    const real F_0_4 = (A_0_4 + A0_1_4 * t_21 + A0_0_4 * t_24) * dt;
    const real t_27 = t_3 * t_7;
    const real A0_0_5 = -(t_8 * t_27);
    const real t_28 = t_12 * t_16;
    const real A_0_5 = -(t_17 * t_28);
    const real F_0_5 = (A_0_5 + A0_1_5 * t_21 + A0_0_5 * t_24) * dt;
    const real t_29 = q_0 * (t_12 * t_12);
    const real t_30 = t_19 * t_29;
    const real t_31 = q_0 * (A_1_5 * A_1_5);
    const real t_32 = t_19 * t_31;
    const real Q_0_0 = dt * (q_0 + t_18 * t_30 + t_18 * t_32);
    const real T_0_0 = F_0_0 * P_0_0 + F_0_1 * P_0_1 + F_0_3 * P_0_3 + F_0_4 * P_0_4 + F_0_5 * P_0_5;
    const real T_0_1 = F_0_0 * P_0_1 + F_0_1 * P_1_1 + F_0_3 * P_1_3 + F_0_4 * P_1_4 + F_0_5 * P_1_5;
    const real T_0_3 = F_0_0 * P_0_3 + F_0_1 * P_1_3 + F_0_3 * P_3_3 + F_0_4 * P_3_4 + F_0_5 * P_3_5;
    const real T_0_4 = F_0_0 * P_0_4 + F_0_1 * P_1_4 + F_0_3 * P_3_4 + F_0_4 * P_4_4 + F_0_5 * P_4_5;
    const real T_0_5 = F_0_0 * P_0_5 + F_0_1 * P_1_5 + F_0_3 * P_3_5 + F_0_4 * P_4_5 + F_0_5 * P_5_5;
    const real A_1_0 = -t_11 - t_13;
    const real t_33 = A_1_0 * dt;
    const real F_1_0 = t_22 * t_33;
    const real t_34 = R(0.5) * (dt * dt);
    const real t_35 = A_1_0 * t_34;
    const real F_1_1 = R(1.0) + A0_0_1 * t_35;
    const real F_1_3 = -t_35;
    const real A_1_4 = -t_12;
    const real t_36 = R(0.5) * t_33;
    const real F_1_4 = (A_1_4 + A0_0_4 * t_36) * dt;
    const real F_1_5 = (A_1_5 + A0_0_5 * t_36) * dt;
    const real A_2_1 = t_17 * t_20;
    const real t_37 = A_2_1 * t_10;
    const real F_2_0 = dt * (A_2_0 * t_22 + A0_1_0 * t_37);
    const real t_38 = A_2_0 * t_10;
    const real F_2_1 = (A_2_1 + A0_0_1 * t_38) * dt;
    const real F_2_3 = -(A_2_0 * t_34);
    const real A_2_4 = -t_26;
    const real F_2_4 = (A_2_4 + A0_1_4 * t_37 + A0_0_4 * t_38) * dt;
    const real A_2_5 = -t_28;
    const real F_2_5 = (A_2_5 + A0_1_5 * t_37 + A0_0_5 * t_38) * dt;
    const real Q_0_2 = dt * (t_17 * t_30 + t_17 * t_32);
    const real T_0_2 = F_0_0 * P_0_2 + F_0_1 * P_1_2 + F_0_3 * P_2_3 + F_0_4 * P_2_4 + F_0_5 * P_2_5;
    const real Q_1_1 = dt * (t_29 + t_31);
    const real T_1_0 = F_1_0 * P_0_0 + F_1_1 * P_0_1 + F_1_3 * P_0_3 + F_1_4 * P_0_4 + F_1_5 * P_0_5;
    const real T_1_1 = F_1_0 * P_0_1 + F_1_1 * P_1_1 + F_1_3 * P_1_3 + F_1_4 * P_1_4 + F_1_5 * P_1_5;
    const real T_1_3 = F_1_0 * P_0_3 + F_1_1 * P_1_3 + F_1_3 * P_3_3 + F_1_4 * P_3_4 + F_1_5 * P_3_5;
    const real T_1_4 = F_1_0 * P_0_4 + F_1_1 * P_1_4 + F_1_3 * P_3_4 + F_1_4 * P_4_4 + F_1_5 * P_4_5;
    const real T_1_5 = F_1_0 * P_0_5 + F_1_1 * P_1_5 + F_1_3 * P_3_5 + F_1_4 * P_4_5 + F_1_5 * P_5_5;
    const real T_1_2 = F_1_0 * P_0_2 + F_1_1 * P_1_2 + F_1_3 * P_2_3 + F_1_4 * P_2_4 + F_1_5 * P_2_5;
    const real Q_2_2 = dt * (t_30 + t_32);
    const real T_2_0 = F_2_0 * P_0_0 + F_2_1 * P_0_1 + F_2_3 * P_0_3 + F_2_4 * P_0_4 + F_2_5 * P_0_5 + P_0_2;
    const real T_2_1 = F_2_0 * P_0_1 + F_2_1 * P_1_1 + F_2_3 * P_1_3 + F_2_4 * P_1_4 + F_2_5 * P_1_5 + P_1_2;
    const real T_2_2 = F_2_0 * P_0_2 + F_2_1 * P_1_2 + F_2_3 * P_2_3 + F_2_4 * P_2_4 + F_2_5 * P_2_5 + P_2_2;
    const real T_2_3 = F_2_0 * P_0_3 + F_2_1 * P_1_3 + F_2_3 * P_3_3 + F_2_4 * P_3_4 + F_2_5 * P_3_5 + P_2_3;
    const real T_2_4 = F_2_0 * P_0_4 + F_2_1 * P_1_4 + F_2_3 * P_3_4 + F_2_4 * P_4_4 + F_2_5 * P_4_5 + P_2_4;
    const real T_2_5 = F_2_0 * P_0_5 + F_2_1 * P_1_5 + F_2_3 * P_3_5 + F_2_4 * P_4_5 + F_2_5 * P_5_5 + P_2_5;
    const real Q_3_3 = dt * q_1;
    x[0] = dt * r_euler_0 + s_euler_0;
    x[1] = dt * r_euler_1 + s_euler_1;
    x[2] = dt * r_euler_2 + s_euler_2;
    x[3] = s_gyro_bias_0;
    x[4] = s_gyro_bias_1;
    x[5] = s_gyro_bias_2;
    P[0] = F_0_0 * T_0_0 + F_0_1 * T_0_1 + F_0_3 * T_0_3 + F_0_4 * T_0_4 + F_0_5 * T_0_5 + Q_0_0;
    P[1] = F_1_0 * T_0_0 + F_1_1 * T_0_1 + F_1_3 * T_0_3 + F_1_4 * T_0_4 + F_1_5 * T_0_5;
    P[2] = F_2_0 * T_0_0 + F_2_1 * T_0_1 + F_2_3 * T_0_3 + F_2_4 * T_0_4 + F_2_5 * T_0_5 + Q_0_2 + T_0_2;
    P[3] = T_0_3;
    P[4] = T_0_4;
    P[5] = T_0_5;
    P[6] = F_1_0 * T_1_0 + F_1_1 * T_1_1 + F_1_3 * T_1_3 + F_1_4 * T_1_4 + F_1_5 * T_1_5 + Q_1_1;
    P[7] = F_2_0 * T_1_0 + F_2_1 * T_1_1 + F_2_3 * T_1_3 + F_2_4 * T_1_4 + F_2_5 * T_1_5 + T_1_2;
    P[8] = T_1_3;
    P[9] = T_1_4;
    P[10] = T_1_5;
    P[11] = F_2_0 * T_2_0 + F_2_1 * T_2_1 + F_2_3 * T_2_3 + F_2_4 * T_2_4 + F_2_5 * T_2_5 + Q_2_2 + T_2_2;
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

RN_INLINE void rn_attitude_euler_transition(const real *x, const real *u, const real *q, const real *p, real dt, real *F, real *Q)
{
    RN_UNUSED(p);
    const real s_euler_0 = x[0];
    const real s_euler_1 = x[1];
    const real s_gyro_bias_0 = x[3];
    const real s_gyro_bias_1 = x[4];
    const real s_gyro_bias_2 = x[5];
    const real u_gyro_0 = u[0];
    const real u_gyro_1 = u[1];
    const real u_gyro_2 = u[2];
    const real q_0 = q[0];
    const real q_1 = q[1];
    const real A0_1_5 = rn_sin(s_euler_0);
    const real t_0 = u_gyro_1 - s_gyro_bias_1;
    const real t_1 = t_0 * A0_1_5;
    const real t_2 = u_gyro_2 - s_gyro_bias_2;
    const real t_3 = rn_cos(s_euler_0);
    const real t_4 = t_2 * t_3;
    const real A0_1_0 = -t_1 - t_4;
    const real t_5 = t_1 + t_4;
    const real t_6 = rn_cos(s_euler_1);
    const real t_7 = R(1.0) / t_6;
    const real r0_euler_2 = t_5 * t_7;
    const real t_8 = rn_sin(s_euler_1);
    const real t_9 = u_gyro_0 - s_gyro_bias_0;
    const real r0_euler_0 = t_8 * r0_euler_2 + t_9;
    const real t_10 = R(0.5) * dt;
    const real m_0 = s_euler_0 + r0_euler_0 * t_10;
    const real A_1_5 = rn_sin(m_0);
    const real t_11 = rn_cos(m_0);
    const real r_euler_1 = t_0 * t_11 - A_1_5 * t_2;
    const real r0_euler_1 = t_0 * t_3 - A0_1_5 * t_2;
    const real m_1 = s_euler_1 + r0_euler_1 * t_10;
    const real t_12 = rn_cos(m_1);
    const real t_13 = R(1.0) / t_12;
    const real A_2_0 = t_13 * r_euler_1;
    const real t_14 = rn_sin(m_1);
    const real A_0_0 = t_14 * A_2_0;
    const real t_15 = t_0 * A_1_5;
    const real t_16 = t_11 * t_2;
    const real t_17 = t_15 + t_16;
    const real t_18 = t_14 * t_14;
    const real t_19 = R(1.0) / (t_12 * t_12);
    const real t_20 = t_17 * t_19;
    const real A_0_1 = t_17 + t_18 * t_20;
    const real t_21 = A_0_1 * t_10;
    const real A0_2_0 = r0_euler_1 * t_7;
    const real A0_0_0 = t_8 * A0_2_0;
    const real t_22 = R(1.0) + A0_0_0 * t_10;
    const real F_0_0 = R(1.0) + dt * (A0_1_0 * t_21 + A_0_0 * t_22);
    const real t_23 = t_5 / (t_6 * t_6);
    const real A0_0_1 = (t_8 * t_8) * t_23 + t_5;
    const real t_24 = A_0_0 * t_10;
    const real F_0_1 = (A_0_1 + A0_0_1 * t_24) * dt;
    const real F_0_3 = (-R(1.0) - t_24) * dt;
    const real t_25 = A0_1_5 * t_7;
    const real A0_0_4 = -(t_8 * t_25);
    const real A0_1_4 = -t_3;
    const real t_26 = A_1_5 * t_13;
    const real A_0_4 = -(t_14 * t_26);
    const real F_0_4 = (A_0_4 + A0_1_4 * t_21 + A0_0_4 * t_24) * dt;
    const real t_27 = t_3 * t_7;
    const real A0_0_5 = -(t_8 * t_27);
    const real t_28 = t_11 * t_13;
    const real A_0_5 = -(t_14 * t_28);
    const real F_0_5 = (A_0_5 + A0_1_5 * t_21 + A0_0_5 * t_24) * dt;
    const real A_1_0 = -t_15 - t_16;
    const real F_1_0 = A_1_0 * dt * t_22;
    const real t_29 = R(0.5) * (dt * dt);
    const real t_30 = A_1_0 * t_29;
    const real F_1_1 = R(1.0) + A0_0_1 * t_30;
    const real F_1_3 = -t_30;
    const real A_1_4 = -t_11;
    const real t_31 = A_1_0 * t_10;
    const real F_1_4 = (A_1_4 + A0_0_4 * t_31) * dt;
    const real F_1_5 = (A_1_5 + A0_0_5 * t_31) * dt;
    const real A_2_1 = t_14 * t_20;
    const real t_32 = A_2_1 * t_10;
    const real F_2_0 = dt * (A_2_0 * t_22 + A0_1_0 * t_32);
    const real t_33 = A_2_0 * t_10;
    const real F_2_1 = (A_2_1 + A0_0_1 * t_33) * dt;
    const real F_2_3 = -(A_2_0 * t_29);
    const real A_2_4 = -t_26;
    const real F_2_4 = (A_2_4 + A0_1_4 * t_32 + A0_0_4 * t_33) * dt;
    const real A_2_5 = -t_28;
    const real F_2_5 = (A_2_5 + A0_1_5 * t_32 + A0_0_5 * t_33) * dt;
    const real t_34 = q_0 * (t_11 * t_11);
    const real t_35 = t_19 * t_34;
    const real t_36 = q_0 * (A_1_5 * A_1_5);
    const real t_37 = t_19 * t_36;
    const real Q_0_0 = dt * (q_0 + t_18 * t_35 + t_18 * t_37);
    const real Q_0_2 = dt * (t_14 * t_35 + t_14 * t_37);
    const real Q_1_1 = dt * (t_34 + t_36);
    const real Q_2_2 = dt * (t_35 + t_37);
    const real Q_3_3 = dt * q_1;
    F[0] = F_0_0;
    F[1] = F_0_1;
    F[2] = R(0.0);
    F[3] = F_0_3;
    F[4] = F_0_4;
    F[5] = F_0_5;
    F[6] = F_1_0;
    F[7] = F_1_1;
    F[8] = R(0.0);
    F[9] = F_1_3;
    F[10] = F_1_4;
    F[11] = F_1_5;
    F[12] = F_2_0;
    F[13] = F_2_1;
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
    Q[2] = Q_0_2;
    Q[3] = R(0.0);
    Q[4] = R(0.0);
    Q[5] = R(0.0);
    Q[6] = R(0.0);
    Q[7] = Q_1_1;
    Q[8] = R(0.0);
    Q[9] = R(0.0);
    Q[10] = R(0.0);
    Q[11] = R(0.0);
    Q[12] = Q_0_2;
    Q[13] = R(0.0);
    Q[14] = Q_2_2;
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

RN_INLINE void rn_attitude_euler_noise(const real *x, const real *u, const real *q, const real *p, real dt, real *Q)
{
    RN_UNUSED(p);
    const real s_euler_0 = x[0];
    const real s_euler_1 = x[1];
    const real s_gyro_bias_0 = x[3];
    const real s_gyro_bias_1 = x[4];
    const real s_gyro_bias_2 = x[5];
    const real u_gyro_0 = u[0];
    const real u_gyro_1 = u[1];
    const real u_gyro_2 = u[2];
    const real q_0 = q[0];
    const real q_1 = q[1];
    const real A0_1_5 = rn_sin(s_euler_0);
    const real t_0 = u_gyro_1 - s_gyro_bias_1;
    const real t_1 = u_gyro_2 - s_gyro_bias_2;
    const real t_2 = rn_cos(s_euler_0);
    const real r0_euler_1 = t_0 * t_2 - A0_1_5 * t_1;
    const real t_3 = R(0.5) * dt;
    const real m_1 = s_euler_1 + r0_euler_1 * t_3;
    const real t_4 = rn_sin(m_1);
    const real t_5 = t_4 * t_4;
    const real t_6 = rn_cos(m_1);
    const real t_7 = R(1.0) / (t_6 * t_6);
    const real t_8 = t_0 * A0_1_5;
    const real t_9 = t_1 * t_2;
    const real t_10 = t_8 + t_9;
    const real t_11 = rn_cos(s_euler_1);
    const real t_12 = R(1.0) / t_11;
    const real r0_euler_2 = t_10 * t_12;
    const real t_13 = rn_sin(s_euler_1);
    const real t_14 = u_gyro_0 - s_gyro_bias_0;
    const real r0_euler_0 = t_13 * r0_euler_2 + t_14;
    const real m_0 = s_euler_0 + r0_euler_0 * t_3;
    const real t_15 = rn_cos(m_0);
    const real t_16 = q_0 * (t_15 * t_15);
    const real t_17 = t_7 * t_16;
    const real A_1_5 = rn_sin(m_0);
    const real t_18 = q_0 * (A_1_5 * A_1_5);
    const real t_19 = t_7 * t_18;
    const real Q_0_0 = dt * (q_0 + t_5 * t_17 + t_5 * t_19);
    const real Q_0_2 = dt * (t_4 * t_17 + t_4 * t_19);
    const real Q_1_1 = dt * (t_16 + t_18);
    const real Q_2_2 = dt * (t_17 + t_19);
    const real Q_3_3 = dt * q_1;
    Q[0] = Q_0_0;
    Q[1] = R(0.0);
    Q[2] = Q_0_2;
    Q[3] = R(0.0);
    Q[4] = R(0.0);
    Q[5] = R(0.0);
    Q[6] = Q_1_1;
    Q[7] = R(0.0);
    Q[8] = R(0.0);
    Q[9] = R(0.0);
    Q[10] = R(0.0);
    Q[11] = Q_2_2;
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

RN_INLINE void rn_attitude_euler_inject(real *x, const real *e)
{
    const real s_euler_0 = x[0];
    const real s_euler_1 = x[1];
    const real s_euler_2 = x[2];
    const real s_gyro_bias_0 = x[3];
    const real s_gyro_bias_1 = x[4];
    const real s_gyro_bias_2 = x[5];
    const real e_0 = e[0];
    const real e_1 = e[1];
    const real e_2 = e[2];
    const real e_3 = e[3];
    const real e_4 = e[4];
    const real e_5 = e[5];
    x[0] = e_0 + s_euler_0;
    x[1] = e_1 + s_euler_1;
    x[2] = e_2 + s_euler_2;
    x[3] = e_3 + s_gyro_bias_0;
    x[4] = e_4 + s_gyro_bias_1;
    x[5] = e_5 + s_gyro_bias_2;
}

RN_INLINE void rn_attitude_euler_inject_turned(real *x, const real *e)
{
    const real s_euler_0 = x[0];
    const real s_euler_1 = x[1];
    const real s_euler_2 = x[2];
    const real s_gyro_bias_0 = x[3];
    const real s_gyro_bias_1 = x[4];
    const real s_gyro_bias_2 = x[5];
    const real e_0 = e[0];
    const real e_1 = e[1];
    const real e_2 = e[2];
    const real e_3 = e[3];
    const real e_4 = e[4];
    const real e_5 = e[5];
    x[0] = e_0 + s_euler_0;
    x[1] = e_1 + s_euler_1;
    x[2] = e_2 + s_euler_2;
    x[3] = e_3 + s_gyro_bias_0;
    x[4] = e_4 + s_gyro_bias_1;
    x[5] = e_5 + s_gyro_bias_2;
}

RN_INLINE void rn_attitude_euler_difference(const real *a, const real *b, real *e)
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

RN_VECTORISED static void rn_attitude_euler_carry(const real *a, const real *b, const real *u, const real *p, real dt, real *e)
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
    const real b_0 = b[0];
    const real b_1 = b[1];
    const real b_2 = b[2];
    for (int k = 0; k < 12; k++) {
        const real e_0 = e[0 + k];
        const real e_1 = e[12 + k];
        const real e_2 = e[24 + k];
        const real e_3 = e[36 + k];
        const real e_4 = e[48 + k];
        const real e_5 = e[60 + k];
        const real s_gyro_bias_1 = a_4 + e_4;
        const real t_0 = u_gyro_1 - s_gyro_bias_1;
        const real s_euler_0 = a_0 + e_0;
        const real t_1 = rn_sin(s_euler_0);
        const real s_gyro_bias_2 = a_5 + e_5;
        const real t_2 = u_gyro_2 - s_gyro_bias_2;
        const real t_3 = rn_cos(s_euler_0);
        const real r0_euler_1 = t_0 * t_3 - t_1 * t_2;
        const real s_euler_1 = a_1 + e_1;
        const real t_4 = R(0.5) * dt;
        const real m_1 = s_euler_1 + r0_euler_1 * t_4;
        const real r0_euler_2 = (t_0 * t_1 + t_2 * t_3) / rn_cos(s_euler_1);
        const real s_gyro_bias_0 = a_3 + e_3;
        const real t_5 = u_gyro_0 - s_gyro_bias_0;
        const real r0_euler_0 = rn_sin(s_euler_1) * r0_euler_2 + t_5;
        const real m_0 = s_euler_0 + r0_euler_0 * t_4;
        const real t_6 = rn_sin(m_0);
        const real t_7 = rn_cos(m_0);
        const real r_euler_2 = (t_0 * t_6 + t_2 * t_7) / rn_cos(m_1);
        const real r_euler_0 = t_5 + rn_sin(m_1) * r_euler_2;
        const real r_euler_1 = t_0 * t_7 - t_2 * t_6;
        const real s_euler_2 = a_2 + e_2;
        e[0 + k] = dt * r_euler_0 + s_euler_0 - b_0;
        e[12 + k] = dt * r_euler_1 + s_euler_1 - b_1;
        e[24 + k] = dt * r_euler_2 + s_euler_2 - b_2;
    }
}

RN_INLINE void rn_attitude_euler_measure_accel(const real *x, const real *z, const real *p, real *h)
{
    RN_UNUSED(z);
    const real s_euler_0 = x[0];
    const real s_euler_1 = x[1];
    const real p_gravity = p[0];
    const real t_0 = rn_cos(s_euler_1) * p_gravity;
    h[0] = p_gravity * rn_sin(s_euler_1);
    h[1] = -(rn_sin(s_euler_0) * t_0);
    h[2] = -(rn_cos(s_euler_0) * t_0);
}

RN_INLINE void rn_attitude_euler_residual_accel(const real *x, const real *z, const real *p, real *r)
{
    const real s_euler_0 = x[0];
    const real s_euler_1 = x[1];
    const real p_gravity = p[0];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real t_0 = rn_cos(s_euler_1) * p_gravity;
    r[0] = z_0 - p_gravity * rn_sin(s_euler_1);
    r[1] = rn_sin(s_euler_0) * t_0 + z_1;
    r[2] = rn_cos(s_euler_0) * t_0 + z_2;
}

RN_INLINE void rn_attitude_euler_jacobian_accel(const real *x, const real *z, const real *p, real *H)
{
    RN_UNUSED(z);
    const real s_euler_0 = x[0];
    const real s_euler_1 = x[1];
    const real p_gravity = p[0];
    const real t_0 = rn_cos(s_euler_1) * p_gravity;
    const real t_1 = rn_cos(s_euler_0);
    const real t_2 = rn_sin(s_euler_0);
    const real t_3 = p_gravity * rn_sin(s_euler_1);
    H[0] = R(0.0);
    H[1] = t_0;
    H[2] = R(0.0);
    H[3] = R(0.0);
    H[4] = R(0.0);
    H[5] = R(0.0);
    H[6] = -(t_0 * t_1);
    H[7] = t_2 * t_3;
    H[8] = R(0.0);
    H[9] = R(0.0);
    H[10] = R(0.0);
    H[11] = R(0.0);
    H[12] = t_0 * t_2;
    H[13] = t_1 * t_3;
    H[14] = R(0.0);
    H[15] = R(0.0);
    H[16] = R(0.0);
    H[17] = R(0.0);
}

RN_INLINE void rn_attitude_euler_innovation_accel(const real *x, const real *z, const real *p, real *r)
{
    const real s_euler_0 = x[0];
    const real s_euler_1 = x[1];
    const real p_gravity = p[0];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real t_0 = rn_cos(s_euler_1) * p_gravity;
    r[0] = z_0 - p_gravity * rn_sin(s_euler_1);
    r[1] = rn_sin(s_euler_0) * t_0 + z_1;
    r[2] = rn_cos(s_euler_0) * t_0 + z_2;
}

RN_INLINE real rn_attitude_euler_update_accel(real *x, real *P, const real *z, real variance, RN(rule) rule, const real *p, real *nu, real *s, real *nis)
{
    const real s_euler_0 = x[0];
    const real s_euler_1 = x[1];
    const real p_gravity = p[0];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real t_0 = p_gravity * rn_sin(s_euler_1);
    const real t_1 = rn_sin(s_euler_0);
    const real t_2 = rn_cos(s_euler_1) * p_gravity;
    const real t_3 = t_1 * t_2;
    const real t_4 = rn_cos(s_euler_0);
    const real t_5 = t_2 * t_4;
    const real r_0 = z_0 - t_0;
    const real r_1 = t_3 + z_1;
    const real r_2 = t_5 + z_2;
    const real H_0_1 = t_2;
    const real H_1_0 = -t_5;
    const real H_1_1 = t_0 * t_1;
    const real H_2_0 = t_3;
    const real H_2_1 = t_0 * t_4;
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
        const real PH[6] = {H_1_0 * L[0] + H_1_1 * L[1], H_1_0 * L[1] + H_1_1 * L[6], H_1_0 * L[2] + H_1_1 * L[7], H_1_0 * L[3] + H_1_1 * L[8], H_1_0 * L[4] + H_1_1 * L[9], H_1_0 * L[5] + H_1_1 * L[10]};
        s[1] = variance + H_1_0 * PH[0] + H_1_1 * PH[1];
        nu[1] = r_1 - (H_1_0 * dx[0] + H_1_1 * dx[1]);
        refused += rn_scalar_update(L, dx, PH, 6, s[1], variance, nu[1], nis);
    }
    {
        const real PH[6] = {H_2_0 * L[0] + H_2_1 * L[1], H_2_0 * L[1] + H_2_1 * L[6], H_2_0 * L[2] + H_2_1 * L[7], H_2_0 * L[3] + H_2_1 * L[8], H_2_0 * L[4] + H_2_1 * L[9], H_2_0 * L[5] + H_2_1 * L[10]};
        s[2] = variance + H_2_0 * PH[0] + H_2_1 * PH[1];
        nu[2] = r_2 - (H_2_0 * dx[0] + H_2_1 * dx[1]);
        refused += rn_scalar_update(L, dx, PH, 6, s[2], variance, nu[2], nis);
    }
    const real weight = refused ? R(0.0) : rn_weight(rule, *nis, R(3.0));
    if (!(weight > R(0.0))) return R(0.0);
    if (weight < R(1.0)) rn_soften(L, P, 21, dx, 6, weight);
    memcpy(P, L, sizeof L);
    rn_attitude_euler_inject(x, dx);
    return weight;
}

RN_INLINE void rn_attitude_euler_measure_mag(const real *x, const real *z, const real *p, real *h)
{
    RN_UNUSED(z);
    const real s_euler_0 = x[0];
    const real s_euler_1 = x[1];
    const real s_euler_2 = x[2];
    const real p_mag_north = p[1];
    const real p_mag_down = p[2];
    const real t_0 = rn_sin(s_euler_1);
    const real t_1 = rn_cos(s_euler_2);
    const real t_2 = rn_cos(s_euler_1);
    const real t_3 = rn_sin(s_euler_2);
    const real t_4 = rn_cos(s_euler_0);
    const real t_5 = rn_sin(s_euler_0);
    const real t_6 = t_0 * t_1;
    const real t_7 = p_mag_down * t_2;
    h[0] = p_mag_north * t_1 * t_2 - p_mag_down * t_0;
    h[1] = (t_5 * t_6 - t_3 * t_4) * p_mag_north + t_5 * t_7;
    h[2] = p_mag_north * (t_3 * t_5 + t_4 * t_6) + t_4 * t_7;
}

RN_INLINE void rn_attitude_euler_residual_mag(const real *x, const real *z, const real *p, real *r)
{
    const real s_euler_0 = x[0];
    const real s_euler_1 = x[1];
    const real s_euler_2 = x[2];
    const real p_mag_north = p[1];
    const real p_mag_down = p[2];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real t_0 = rn_sin(s_euler_1);
    const real t_1 = rn_cos(s_euler_2);
    const real t_2 = rn_cos(s_euler_1);
    const real t_3 = rn_sin(s_euler_2);
    const real t_4 = rn_cos(s_euler_0);
    const real t_5 = rn_sin(s_euler_0);
    const real t_6 = t_0 * t_1;
    const real t_7 = p_mag_down * t_2;
    r[0] = z_0 - ((p_mag_north * t_1 * t_2 - p_mag_down * t_0));
    r[1] = z_1 - (((t_5 * t_6 - t_3 * t_4) * p_mag_north + t_5 * t_7));
    r[2] = z_2 - ((p_mag_north * (t_3 * t_5 + t_4 * t_6) + t_4 * t_7));
}

RN_INLINE void rn_attitude_euler_jacobian_mag(const real *x, const real *z, const real *p, real *H)
{
    RN_UNUSED(z);
    const real s_euler_0 = x[0];
    const real s_euler_1 = x[1];
    const real s_euler_2 = x[2];
    const real p_mag_north = p[1];
    const real p_mag_down = p[2];
    const real t_0 = rn_sin(s_euler_1);
    const real t_1 = rn_cos(s_euler_2);
    const real t_2 = rn_cos(s_euler_1);
    const real t_3 = p_mag_down * t_2;
    const real t_4 = rn_sin(s_euler_2);
    const real t_5 = p_mag_north * t_2;
    const real t_6 = rn_cos(s_euler_0);
    const real t_7 = t_1 * t_6;
    const real t_8 = rn_sin(s_euler_0);
    const real t_9 = t_4 * t_8;
    const real t_10 = p_mag_down * t_0;
    const real t_11 = t_1 * t_8;
    const real t_12 = t_4 * t_6;
    H[0] = R(0.0);
    H[1] = -p_mag_north * t_0 * t_1 - t_3;
    H[2] = -(t_4 * t_5);
    H[3] = R(0.0);
    H[4] = R(0.0);
    H[5] = R(0.0);
    H[6] = p_mag_north * (t_0 * t_7 + t_9) + t_3 * t_6;
    H[7] = t_11 * t_5 - t_10 * t_8;
    H[8] = (-t_0 * t_9 - t_7) * p_mag_north;
    H[9] = R(0.0);
    H[10] = R(0.0);
    H[11] = R(0.0);
    H[12] = p_mag_north * (t_12 - t_0 * t_11) - t_3 * t_8;
    H[13] = t_5 * t_7 - t_10 * t_6;
    H[14] = p_mag_north * (t_11 - t_0 * t_12);
    H[15] = R(0.0);
    H[16] = R(0.0);
    H[17] = R(0.0);
}

RN_INLINE void rn_attitude_euler_innovation_mag(const real *x, const real *z, const real *p, real *r)
{
    const real s_euler_0 = x[0];
    const real s_euler_1 = x[1];
    const real s_euler_2 = x[2];
    const real p_mag_north = p[1];
    const real p_mag_down = p[2];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real t_0 = rn_sin(s_euler_1);
    const real t_1 = rn_cos(s_euler_2);
    const real t_2 = rn_cos(s_euler_1);
    const real t_3 = rn_sin(s_euler_2);
    const real t_4 = rn_cos(s_euler_0);
    const real t_5 = rn_sin(s_euler_0);
    const real t_6 = t_0 * t_1;
    const real t_7 = p_mag_down * t_2;
    r[0] = z_0 - ((p_mag_north * t_1 * t_2 - p_mag_down * t_0));
    r[1] = z_1 - (((t_5 * t_6 - t_3 * t_4) * p_mag_north + t_5 * t_7));
    r[2] = z_2 - ((p_mag_north * (t_3 * t_5 + t_4 * t_6) + t_4 * t_7));
}

RN_INLINE real rn_attitude_euler_update_mag(real *x, real *P, const real *z, real variance, RN(rule) rule, const real *p, real *nu, real *s, real *nis)
{
    const real s_euler_0 = x[0];
    const real s_euler_1 = x[1];
    const real s_euler_2 = x[2];
    const real p_mag_north = p[1];
    const real p_mag_down = p[2];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real t_0 = rn_sin(s_euler_1);
    const real t_1 = p_mag_down * t_0;
    const real t_2 = rn_cos(s_euler_1);
    const real t_3 = rn_cos(s_euler_2);
    const real t_4 = p_mag_north * t_3;
    const real t_5 = rn_sin(s_euler_2);
    const real t_6 = rn_cos(s_euler_0);
    const real t_7 = t_5 * t_6;
    const real t_8 = rn_sin(s_euler_0);
    const real t_9 = t_3 * t_8;
    const real t_10 = t_0 * t_9;
    const real t_11 = p_mag_down * t_2;
    const real t_12 = t_11 * t_8;
    const real t_13 = t_5 * t_8;
    const real t_14 = t_3 * t_6;
    const real t_15 = p_mag_north * (t_0 * t_14 + t_13) + t_11 * t_6;
    const real t_16 = p_mag_north * t_2;
    const real r_0 = z_0 - ((t_2 * t_4 - t_1));
    const real r_1 = z_1 - ((p_mag_north * (t_10 - t_7) + t_12));
    const real r_2 = z_2 - t_15;
    const real H_0_1 = -t_0 * t_4 - t_11;
    const real H_0_2 = -(t_16 * t_5);
    const real H_1_0 = t_15;
    const real H_1_1 = t_16 * t_9 - t_1 * t_8;
    const real H_1_2 = (-t_0 * t_13 - t_14) * p_mag_north;
    const real H_2_0 = (t_7 - t_10) * p_mag_north - t_12;
    const real H_2_1 = t_14 * t_16 - t_1 * t_6;
    const real H_2_2 = p_mag_north * (t_9 - t_0 * t_7);
    real L[21], dx[6];
    int refused = 0;
    memcpy(L, P, sizeof L);
    for (int i = 0; i < 6; i++) dx[i] = R(0.0);
    *nis = R(0.0);
    {
        const real PH[6] = {H_0_1 * L[1] + H_0_2 * L[2], H_0_1 * L[6] + H_0_2 * L[7], H_0_1 * L[7] + H_0_2 * L[11], H_0_1 * L[8] + H_0_2 * L[12], H_0_1 * L[9] + H_0_2 * L[13], H_0_1 * L[10] + H_0_2 * L[14]};
        s[0] = variance + H_0_1 * PH[1] + H_0_2 * PH[2];
        nu[0] = r_0 - (H_0_1 * dx[1] + H_0_2 * dx[2]);
        refused += rn_scalar_update(L, dx, PH, 6, s[0], variance, nu[0], nis);
    }
    {
        const real PH[6] = {H_1_0 * L[0] + H_1_1 * L[1] + H_1_2 * L[2], H_1_0 * L[1] + H_1_1 * L[6] + H_1_2 * L[7], H_1_0 * L[2] + H_1_1 * L[7] + H_1_2 * L[11], H_1_0 * L[3] + H_1_1 * L[8] + H_1_2 * L[12], H_1_0 * L[4] + H_1_1 * L[9] + H_1_2 * L[13], H_1_0 * L[5] + H_1_1 * L[10] + H_1_2 * L[14]};
        s[1] = variance + H_1_0 * PH[0] + H_1_1 * PH[1] + H_1_2 * PH[2];
        nu[1] = r_1 - (H_1_0 * dx[0] + H_1_1 * dx[1] + H_1_2 * dx[2]);
        refused += rn_scalar_update(L, dx, PH, 6, s[1], variance, nu[1], nis);
    }
    {
        const real PH[6] = {H_2_0 * L[0] + H_2_1 * L[1] + H_2_2 * L[2], H_2_0 * L[1] + H_2_1 * L[6] + H_2_2 * L[7], H_2_0 * L[2] + H_2_1 * L[7] + H_2_2 * L[11], H_2_0 * L[3] + H_2_1 * L[8] + H_2_2 * L[12], H_2_0 * L[4] + H_2_1 * L[9] + H_2_2 * L[13], H_2_0 * L[5] + H_2_1 * L[10] + H_2_2 * L[14]};
        s[2] = variance + H_2_0 * PH[0] + H_2_1 * PH[1] + H_2_2 * PH[2];
        nu[2] = r_2 - (H_2_0 * dx[0] + H_2_1 * dx[1] + H_2_2 * dx[2]);
        refused += rn_scalar_update(L, dx, PH, 6, s[2], variance, nu[2], nis);
    }
    const real weight = refused ? R(0.0) : rn_weight(rule, *nis, R(3.0));
    if (!(weight > R(0.0))) return R(0.0);
    if (weight < R(1.0)) rn_soften(L, P, 21, dx, 6, weight);
    memcpy(P, L, sizeof L);
    rn_attitude_euler_inject(x, dx);
    return weight;
}

RN_INLINE void rn_attitude_euler_gain(const real *K, const real *r, real *e)
{
    e[0] = K[0] * r[0] + K[1] * r[1] + K[2] * r[2] + K[3] * r[3] + K[4] * r[4] + K[5] * r[5];
    e[1] = K[6] * r[0] + K[7] * r[1] + K[8] * r[2] + K[9] * r[3] + K[10] * r[4] + K[11] * r[5];
    e[2] = K[12] * r[0] + K[13] * r[1] + K[14] * r[2] + K[15] * r[3] + K[16] * r[4] + K[17] * r[5];
    e[3] = K[18] * r[0] + K[19] * r[1] + K[20] * r[2] + K[21] * r[3] + K[22] * r[4] + K[23] * r[5];
    e[4] = K[24] * r[0] + K[25] * r[1] + K[26] * r[2] + K[27] * r[3] + K[28] * r[4] + K[29] * r[5];
    e[5] = K[30] * r[0] + K[31] * r[1] + K[32] * r[2] + K[33] * r[3] + K[34] * r[4] + K[35] * r[5];
}

RN_INLINE void rn_attitude_euler_correct(real *x, const real *z, const real *K, const real *p, real *r)
{
    const real s_euler_0 = x[0];
    const real s_euler_1 = x[1];
    const real s_euler_2 = x[2];
    const real s_gyro_bias_0 = x[3];
    const real s_gyro_bias_1 = x[4];
    const real s_gyro_bias_2 = x[5];
    const real p_gravity = p[0];
    const real p_mag_north = p[1];
    const real p_mag_down = p[2];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real z_3 = z[3];
    const real z_4 = z[4];
    const real z_5 = z[5];
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
    const real t_0 = rn_sin(s_euler_1);
    const real r_0 = z_0 - p_gravity * t_0;
    const real t_1 = rn_sin(s_euler_0);
    const real t_2 = rn_cos(s_euler_1);
    const real t_3 = p_gravity * t_2;
    const real r_1 = t_1 * t_3 + z_1;
    const real t_4 = rn_cos(s_euler_0);
    const real r_2 = t_3 * t_4 + z_2;
    const real t_5 = rn_cos(s_euler_2);
    const real r_3 = z_3 - ((p_mag_north * t_2 * t_5 - p_mag_down * t_0));
    const real t_6 = rn_sin(s_euler_2);
    const real t_7 = t_0 * t_5;
    const real t_8 = p_mag_down * t_2;
    const real r_4 = z_4 - ((p_mag_north * (t_1 * t_7 - t_4 * t_6) + t_1 * t_8));
    const real r_5 = z_5 - ((p_mag_north * (t_1 * t_6 + t_4 * t_7) + t_4 * t_8));
    const real de_0 = K_0 * r_0 + K_1 * r_1 + K_2 * r_2 + K_3 * r_3 + K_4 * r_4 + K_5 * r_5;
    const real de_1 = K_6 * r_0 + K_7 * r_1 + K_8 * r_2 + K_9 * r_3 + K_10 * r_4 + K_11 * r_5;
    const real de_2 = K_12 * r_0 + K_13 * r_1 + K_14 * r_2 + K_15 * r_3 + K_16 * r_4 + K_17 * r_5;
    const real de_3 = K_18 * r_0 + K_19 * r_1 + K_20 * r_2 + K_21 * r_3 + K_22 * r_4 + K_23 * r_5;
    const real de_4 = K_24 * r_0 + K_25 * r_1 + K_26 * r_2 + K_27 * r_3 + K_28 * r_4 + K_29 * r_5;
    const real de_5 = K_30 * r_0 + K_31 * r_1 + K_32 * r_2 + K_33 * r_3 + K_34 * r_4 + K_35 * r_5;
    x[0] = de_0 + s_euler_0;
    x[1] = de_1 + s_euler_1;
    x[2] = de_2 + s_euler_2;
    x[3] = de_3 + s_gyro_bias_0;
    x[4] = de_4 + s_gyro_bias_1;
    x[5] = de_5 + s_gyro_bias_2;
    r[0] = r_0;
    r[1] = r_1;
    r[2] = r_2;
    r[3] = r_3;
    r[4] = r_4;
    r[5] = r_5;
}

static const RN(sensor) rn_attitude_euler_sensors[] = {
    {"accel", 3, 3, 3, 2, rn_attitude_euler_measure_accel, rn_attitude_euler_residual_accel, rn_attitude_euler_jacobian_accel, rn_attitude_euler_innovation_accel, rn_attitude_euler_update_accel},
    {"mag", 3, 3, 3, 3, rn_attitude_euler_measure_mag, rn_attitude_euler_residual_mag, rn_attitude_euler_jacobian_mag, rn_attitude_euler_innovation_mag, rn_attitude_euler_update_mag}};
static const RN(model) rn_attitude_euler_model = {
    RN_ABI, (int)sizeof(real), "attitude_euler", 6, 6, 3, 2, 3, 2, 3, rn_attitude_euler_sensors,
    rn_attitude_euler_propagate, rn_attitude_euler_predict, rn_attitude_euler_transition, rn_attitude_euler_noise, rn_attitude_euler_inject, rn_attitude_euler_inject_turned, rn_attitude_euler_difference, rn_attitude_euler_carry, rn_attitude_euler_gain, rn_attitude_euler_correct};

#endif
