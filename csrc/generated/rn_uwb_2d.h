/* Generated from the model 'uwb_2d'; do not edit: make generate. */
/* clang-format off */
#ifndef RN_GENERATED_UWB_2D_H
#define RN_GENERATED_UWB_2D_H
#include "rn_model.h"
#include "rn_update.h"

/* state, error (quaternions: small rotation, rad), input, parameters:
 *   x[0..1], e[0..1]  p_n [m]
 *   x[2..3], e[2..3]  v_n [m/s]
 *   p[0]  time_offset
 *   p[1]  velocity_damping
 *   p[2]  tag_down
 *   reading range: z[0..0] [m]
 *     z[1..3]  p_anchor [m]
 *   reading tdoa: z[0..0] [m]
 *     z[1..3]  p_first [m]
 *     z[4..6]  p_second [m]
 *   reading position: z[0..1] [m]
 *   q[0]  intensity of acceleration [(m/s^2/sqrt(Hz))^2] */

RN_INLINE void rn_uwb_2d_propagate(real *x, const real *u, const real *p, real dt)
{
    RN_UNUSED(u);
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real p_velocity_damping = p[1];
    const real r0_v_n_0 = -(p_velocity_damping * s_v_n_0);
    const real t_0 = R(0.5) * dt;
    const real m_2 = s_v_n_0 + r0_v_n_0 * t_0;
    const real r0_v_n_1 = -(p_velocity_damping * s_v_n_1);
    const real m_3 = s_v_n_1 + r0_v_n_1 * t_0;
    const real r_v_n_0 = -(m_2 * p_velocity_damping);
    const real r_v_n_1 = -(m_3 * p_velocity_damping);
    x[0] = dt * m_2 + s_p_n_0;
    x[1] = dt * m_3 + s_p_n_1;
    x[2] = dt * r_v_n_0 + s_v_n_0;
    x[3] = dt * r_v_n_1 + s_v_n_1;
}

RN_INLINE void rn_uwb_2d_predict(real *x, real *P, const real *u, const real *q, const real *p, real dt)
{
    RN_UNUSED(u);
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real p_velocity_damping = p[1];
    const real q_0 = q[0];
    const real P_0_0 = P[0];
    const real P_0_1 = P[1];
    const real P_0_2 = P[2];
    const real P_0_3 = P[3];
    const real P_1_1 = P[4];
    const real P_1_2 = P[5];
    const real P_1_3 = P[6];
    const real P_2_2 = P[7];
    const real P_2_3 = P[8];
    const real P_3_3 = P[9];
    const real r0_v_n_0 = -(p_velocity_damping * s_v_n_0);
    const real t_0 = R(0.5) * dt;
    const real m_2 = s_v_n_0 + r0_v_n_0 * t_0;
    const real r0_v_n_1 = -(p_velocity_damping * s_v_n_1);
    const real m_3 = s_v_n_1 + r0_v_n_1 * t_0;
    const real r_v_n_0 = -(m_2 * p_velocity_damping);
    const real r_v_n_1 = -(m_3 * p_velocity_damping);
    const real t_1 = R(1.0) - p_velocity_damping * t_0;
    const real F_0_2 = dt * t_1;
    const real t_2 = (dt * dt * dt) * q_0;
    const real Q_0_0 = R(0.3333333333333333) * t_2;
    const real T_0_0 = F_0_2 * P_0_2 + P_0_0;
    const real T_0_2 = F_0_2 * P_2_2 + P_0_2;
    const real T_0_1 = F_0_2 * P_1_2 + P_0_1;
    const real t_3 = F_0_2 * P_2_3;
    const real T_0_3 = P_0_3 + t_3;
    const real F_2_2 = R(1.0) - p_velocity_damping * F_0_2;
    const real t_4 = R(0.08333333333333333) * t_2;
    const real Q_0_2 = R(0.5) * (dt * dt) * q_0 * t_1 - p_velocity_damping * t_4;
    const real T_1_1 = F_0_2 * P_1_3 + P_1_1;
    const real T_1_3 = F_0_2 * P_3_3 + P_1_3;
    const real T_1_2 = P_1_2 + t_3;
    const real Q_2_2 = dt * q_0 * (t_1 * t_1) + (p_velocity_damping * p_velocity_damping) * t_4;
    const real T_2_2 = F_2_2 * P_2_2;
    const real T_2_3 = F_2_2 * P_2_3;
    const real T_3_3 = F_2_2 * P_3_3;
    x[0] = dt * m_2 + s_p_n_0;
    x[1] = dt * m_3 + s_p_n_1;
    x[2] = dt * r_v_n_0 + s_v_n_0;
    x[3] = dt * r_v_n_1 + s_v_n_1;
    P[0] = F_0_2 * T_0_2 + Q_0_0 + T_0_0;
    P[1] = F_0_2 * T_0_3 + T_0_1;
    P[2] = F_2_2 * T_0_2 + Q_0_2;
    P[3] = F_2_2 * T_0_3;
    P[4] = F_0_2 * T_1_3 + Q_0_0 + T_1_1;
    P[5] = F_2_2 * T_1_2;
    P[6] = F_2_2 * T_1_3 + Q_0_2;
    P[7] = F_2_2 * T_2_2 + Q_2_2;
    P[8] = F_2_2 * T_2_3;
    P[9] = F_2_2 * T_3_3 + Q_2_2;
}

RN_INLINE void rn_uwb_2d_transition(const real *x, const real *u, const real *q, const real *p, real dt, real *F, real *Q)
{
    RN_UNUSED(x);
    RN_UNUSED(u);
    const real p_velocity_damping = p[1];
    const real q_0 = q[0];
    const real t_0 = R(0.5) * dt;
    const real t_1 = R(1.0) - p_velocity_damping * t_0;
    const real F_0_2 = dt * t_1;
    const real F_2_2 = R(1.0) - p_velocity_damping * F_0_2;
    const real t_2 = (dt * dt * dt) * q_0;
    const real Q_0_0 = R(0.3333333333333333) * t_2;
    const real t_3 = R(0.08333333333333333) * t_2;
    const real Q_0_2 = R(0.5) * (dt * dt) * q_0 * t_1 - p_velocity_damping * t_3;
    const real Q_2_2 = dt * q_0 * (t_1 * t_1) + (p_velocity_damping * p_velocity_damping) * t_3;
    F[0] = R(1.0);
    F[1] = R(0.0);
    F[2] = F_0_2;
    F[3] = R(0.0);
    F[4] = R(0.0);
    F[5] = R(1.0);
    F[6] = R(0.0);
    F[7] = F_0_2;
    F[8] = R(0.0);
    F[9] = R(0.0);
    F[10] = F_2_2;
    F[11] = R(0.0);
    F[12] = R(0.0);
    F[13] = R(0.0);
    F[14] = R(0.0);
    F[15] = F_2_2;
    Q[0] = Q_0_0;
    Q[1] = R(0.0);
    Q[2] = Q_0_2;
    Q[3] = R(0.0);
    Q[4] = R(0.0);
    Q[5] = Q_0_0;
    Q[6] = R(0.0);
    Q[7] = Q_0_2;
    Q[8] = Q_0_2;
    Q[9] = R(0.0);
    Q[10] = Q_2_2;
    Q[11] = R(0.0);
    Q[12] = R(0.0);
    Q[13] = Q_0_2;
    Q[14] = R(0.0);
    Q[15] = Q_2_2;
}

RN_INLINE void rn_uwb_2d_noise(const real *x, const real *u, const real *q, const real *p, real dt, real *Q)
{
    RN_UNUSED(x);
    RN_UNUSED(u);
    const real p_velocity_damping = p[1];
    const real q_0 = q[0];
    const real t_0 = (dt * dt * dt) * q_0;
    const real Q_0_0 = R(0.3333333333333333) * t_0;
    const real t_1 = R(0.5) * dt;
    const real t_2 = R(1.0) - p_velocity_damping * t_1;
    const real t_3 = R(0.08333333333333333) * t_0;
    const real Q_0_2 = R(0.5) * (dt * dt) * q_0 * t_2 - p_velocity_damping * t_3;
    const real Q_2_2 = dt * q_0 * (t_2 * t_2) + (p_velocity_damping * p_velocity_damping) * t_3;
    Q[0] = Q_0_0;
    Q[1] = R(0.0);
    Q[2] = Q_0_2;
    Q[3] = R(0.0);
    Q[4] = Q_0_0;
    Q[5] = R(0.0);
    Q[6] = Q_0_2;
    Q[7] = Q_2_2;
    Q[8] = R(0.0);
    Q[9] = Q_2_2;
}

RN_INLINE void rn_uwb_2d_inject(real *x, const real *e)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real e_0 = e[0];
    const real e_1 = e[1];
    const real e_2 = e[2];
    const real e_3 = e[3];
    x[0] = e_0 + s_p_n_0;
    x[1] = e_1 + s_p_n_1;
    x[2] = e_2 + s_v_n_0;
    x[3] = e_3 + s_v_n_1;
}

RN_INLINE void rn_uwb_2d_inject_turned(real *x, const real *e)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real e_0 = e[0];
    const real e_1 = e[1];
    const real e_2 = e[2];
    const real e_3 = e[3];
    x[0] = e_0 + s_p_n_0;
    x[1] = e_1 + s_p_n_1;
    x[2] = e_2 + s_v_n_0;
    x[3] = e_3 + s_v_n_1;
}

RN_INLINE void rn_uwb_2d_difference(const real *a, const real *b, real *e)
{
    const real a_0 = a[0];
    const real a_1 = a[1];
    const real a_2 = a[2];
    const real a_3 = a[3];
    const real b_0 = b[0];
    const real b_1 = b[1];
    const real b_2 = b[2];
    const real b_3 = b[3];
    e[0] = a_0 - b_0;
    e[1] = a_1 - b_1;
    e[2] = a_2 - b_2;
    e[3] = a_3 - b_3;
}

RN_VECTORISED static void rn_uwb_2d_carry(const real *a, const real *b, const real *u, const real *p, real dt, real *e)
{
    RN_UNUSED(u);
    const real p_velocity_damping = p[1];
    const real a_0 = a[0];
    const real a_1 = a[1];
    const real a_2 = a[2];
    const real a_3 = a[3];
    const real b_0 = b[0];
    const real b_1 = b[1];
    const real b_2 = b[2];
    const real b_3 = b[3];
    for (int k = 0; k < 8; k++) {
        const real e_0 = e[0 + k];
        const real e_1 = e[8 + k];
        const real e_2 = e[16 + k];
        const real e_3 = e[24 + k];
        const real s_v_n_0 = a_2 + e_2;
        const real r0_v_n_0 = -(p_velocity_damping * s_v_n_0);
        const real t_0 = R(0.5) * dt;
        const real m_2 = s_v_n_0 + r0_v_n_0 * t_0;
        const real s_p_n_0 = a_0 + e_0;
        const real s_v_n_1 = a_3 + e_3;
        const real r0_v_n_1 = -(p_velocity_damping * s_v_n_1);
        const real m_3 = s_v_n_1 + r0_v_n_1 * t_0;
        const real s_p_n_1 = a_1 + e_1;
        const real r_v_n_0 = -(m_2 * p_velocity_damping);
        const real r_v_n_1 = -(m_3 * p_velocity_damping);
        e[0 + k] = dt * m_2 + s_p_n_0 - b_0;
        e[8 + k] = dt * m_3 + s_p_n_1 - b_1;
        e[16 + k] = dt * r_v_n_0 + s_v_n_0 - b_2;
        e[24 + k] = dt * r_v_n_1 + s_v_n_1 - b_3;
    }
}

RN_INLINE void rn_uwb_2d_measure_range(const real *x, const real *z, const real *p, real *h)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real p_time_offset = p[0];
    const real p_tag_down = p[2];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real z_3 = z[3];
    h[0] = rn_sqrt((((p_tag_down - z_3) * (p_tag_down - z_3)) + ((s_p_n_0 - p_time_offset * s_v_n_0 - z_1) * (s_p_n_0 - p_time_offset * s_v_n_0 - z_1)) + ((s_p_n_1 - p_time_offset * s_v_n_1 - z_2) * (s_p_n_1 - p_time_offset * s_v_n_1 - z_2))));
}

RN_INLINE void rn_uwb_2d_residual_range(const real *x, const real *z, const real *p, real *r)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real p_time_offset = p[0];
    const real p_tag_down = p[2];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real z_3 = z[3];
    r[0] = z_0 - rn_sqrt((((p_tag_down - z_3) * (p_tag_down - z_3)) + ((s_p_n_0 - p_time_offset * s_v_n_0 - z_1) * (s_p_n_0 - p_time_offset * s_v_n_0 - z_1)) + ((s_p_n_1 - p_time_offset * s_v_n_1 - z_2) * (s_p_n_1 - p_time_offset * s_v_n_1 - z_2))));
}

RN_INLINE void rn_uwb_2d_jacobian_range(const real *x, const real *z, const real *p, real *H)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real p_time_offset = p[0];
    const real p_tag_down = p[2];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real z_3 = z[3];
    const real t_0 = s_p_n_0 - p_time_offset * s_v_n_0 - z_1;
    const real t_1 = s_p_n_1 - p_time_offset * s_v_n_1 - z_2;
    const real t_2 = R(1.0) / rn_sqrt((((p_tag_down - z_3) * (p_tag_down - z_3)) + (t_0 * t_0) + (t_1 * t_1)));
    const real t_3 = t_0 * t_2;
    const real t_4 = t_1 * t_2;
    H[0] = t_3;
    H[1] = t_4;
    H[2] = -(p_time_offset * t_3);
    H[3] = -(p_time_offset * t_4);
}

RN_INLINE void rn_uwb_2d_innovation_range(const real *x, const real *z, const real *p, real *r)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real p_time_offset = p[0];
    const real p_tag_down = p[2];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real z_3 = z[3];
    r[0] = z_0 - rn_sqrt((((p_tag_down - z_3) * (p_tag_down - z_3)) + ((s_p_n_0 - p_time_offset * s_v_n_0 - z_1) * (s_p_n_0 - p_time_offset * s_v_n_0 - z_1)) + ((s_p_n_1 - p_time_offset * s_v_n_1 - z_2) * (s_p_n_1 - p_time_offset * s_v_n_1 - z_2))));
}

RN_INLINE real rn_uwb_2d_update_range(real *x, real *P, const real *z, real variance, RN(rule) rule, const real *p, real *nu, real *s, real *nis)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real p_time_offset = p[0];
    const real p_tag_down = p[2];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real z_3 = z[3];
    const real t_0 = s_p_n_0 - p_time_offset * s_v_n_0 - z_1;
    const real t_1 = s_p_n_1 - p_time_offset * s_v_n_1 - z_2;
    const real t_2 = rn_sqrt((((p_tag_down - z_3) * (p_tag_down - z_3)) + (t_0 * t_0) + (t_1 * t_1)));
    const real t_3 = R(1.0) / t_2;
    const real t_4 = t_0 * t_3;
    const real t_5 = t_1 * t_3;
    const real r_0 = z_0 - t_2;
    const real H_0_0 = t_4;
    const real H_0_1 = t_5;
    const real H_0_2 = -(p_time_offset * t_4);
    const real H_0_3 = -(p_time_offset * t_5);
    real L[10], dx[4];
    int refused = 0;
    memcpy(L, P, sizeof L);
    for (int i = 0; i < 4; i++) dx[i] = R(0.0);
    *nis = R(0.0);
    {
        const real PH[4] = {H_0_0 * L[0] + H_0_1 * L[1] + H_0_2 * L[2] + H_0_3 * L[3], H_0_0 * L[1] + H_0_1 * L[4] + H_0_2 * L[5] + H_0_3 * L[6], H_0_0 * L[2] + H_0_1 * L[5] + H_0_2 * L[7] + H_0_3 * L[8], H_0_0 * L[3] + H_0_1 * L[6] + H_0_2 * L[8] + H_0_3 * L[9]};
        s[0] = variance + H_0_0 * PH[0] + H_0_1 * PH[1] + H_0_2 * PH[2] + H_0_3 * PH[3];
        nu[0] = r_0 - (H_0_0 * dx[0] + H_0_1 * dx[1] + H_0_2 * dx[2] + H_0_3 * dx[3]);
        refused += rn_scalar_update(L, dx, PH, 4, s[0], variance, nu[0], nis);
    }
    const real weight = refused ? R(0.0) : rn_weight(rule, *nis, R(1.0));
    if (!(weight > R(0.0))) return R(0.0);
    if (weight < R(1.0)) rn_soften(L, P, 10, dx, 4, weight);
    memcpy(P, L, sizeof L);
    rn_uwb_2d_inject(x, dx);
    return weight;
}

RN_INLINE void rn_uwb_2d_measure_tdoa(const real *x, const real *z, const real *p, real *h)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real p_time_offset = p[0];
    const real p_tag_down = p[2];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real z_3 = z[3];
    const real z_4 = z[4];
    const real z_5 = z[5];
    const real z_6 = z[6];
    const real t_0 = s_p_n_0 - p_time_offset * s_v_n_0;
    const real t_1 = s_p_n_1 - p_time_offset * s_v_n_1;
    h[0] = rn_sqrt((((p_tag_down - z_6) * (p_tag_down - z_6)) + ((t_0 - z_4) * (t_0 - z_4)) + ((t_1 - z_5) * (t_1 - z_5)))) - rn_sqrt((((p_tag_down - z_3) * (p_tag_down - z_3)) + ((t_0 - z_1) * (t_0 - z_1)) + ((t_1 - z_2) * (t_1 - z_2))));
}

RN_INLINE void rn_uwb_2d_residual_tdoa(const real *x, const real *z, const real *p, real *r)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real p_time_offset = p[0];
    const real p_tag_down = p[2];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real z_3 = z[3];
    const real z_4 = z[4];
    const real z_5 = z[5];
    const real z_6 = z[6];
    const real t_0 = s_p_n_0 - p_time_offset * s_v_n_0;
    const real t_1 = s_p_n_1 - p_time_offset * s_v_n_1;
    r[0] = z_0 - ((rn_sqrt((((p_tag_down - z_6) * (p_tag_down - z_6)) + ((t_0 - z_4) * (t_0 - z_4)) + ((t_1 - z_5) * (t_1 - z_5)))) - rn_sqrt((((p_tag_down - z_3) * (p_tag_down - z_3)) + ((t_0 - z_1) * (t_0 - z_1)) + ((t_1 - z_2) * (t_1 - z_2))))));
}

RN_INLINE void rn_uwb_2d_jacobian_tdoa(const real *x, const real *z, const real *p, real *H)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real p_time_offset = p[0];
    const real p_tag_down = p[2];
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
    const real t_4 = R(1.0) / rn_sqrt((((p_tag_down - z_3) * (p_tag_down - z_3)) + (t_1 * t_1) + (t_3 * t_3)));
    const real t_5 = t_1 * t_4;
    const real t_6 = t_0 - z_4;
    const real t_7 = t_2 - z_5;
    const real t_8 = R(1.0) / rn_sqrt((((p_tag_down - z_6) * (p_tag_down - z_6)) + (t_6 * t_6) + (t_7 * t_7)));
    const real t_9 = t_6 * t_8;
    const real t_10 = t_3 * t_4;
    const real t_11 = t_7 * t_8;
    H[0] = t_9 - t_5;
    H[1] = t_11 - t_10;
    H[2] = p_time_offset * t_5 - p_time_offset * t_9;
    H[3] = p_time_offset * t_10 - p_time_offset * t_11;
}

RN_INLINE void rn_uwb_2d_innovation_tdoa(const real *x, const real *z, const real *p, real *r)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real p_time_offset = p[0];
    const real p_tag_down = p[2];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real z_2 = z[2];
    const real z_3 = z[3];
    const real z_4 = z[4];
    const real z_5 = z[5];
    const real z_6 = z[6];
    const real t_0 = s_p_n_0 - p_time_offset * s_v_n_0;
    const real t_1 = s_p_n_1 - p_time_offset * s_v_n_1;
    r[0] = z_0 - ((rn_sqrt((((p_tag_down - z_6) * (p_tag_down - z_6)) + ((t_0 - z_4) * (t_0 - z_4)) + ((t_1 - z_5) * (t_1 - z_5)))) - rn_sqrt((((p_tag_down - z_3) * (p_tag_down - z_3)) + ((t_0 - z_1) * (t_0 - z_1)) + ((t_1 - z_2) * (t_1 - z_2))))));
}

RN_INLINE real rn_uwb_2d_update_tdoa(real *x, real *P, const real *z, real variance, RN(rule) rule, const real *p, real *nu, real *s, real *nis)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real p_time_offset = p[0];
    const real p_tag_down = p[2];
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
    const real t_4 = rn_sqrt((((p_tag_down - z_6) * (p_tag_down - z_6)) + (t_1 * t_1) + (t_3 * t_3)));
    const real t_5 = t_0 - z_1;
    const real t_6 = t_2 - z_2;
    const real t_7 = rn_sqrt((((p_tag_down - z_3) * (p_tag_down - z_3)) + (t_5 * t_5) + (t_6 * t_6)));
    const real t_8 = R(1.0) / t_7;
    const real t_9 = t_5 * t_8;
    const real t_10 = R(1.0) / t_4;
    const real t_11 = t_1 * t_10;
    const real t_12 = t_6 * t_8;
    const real t_13 = t_10 * t_3;
    const real r_0 = z_0 - ((t_4 - t_7));
    const real H_0_0 = t_11 - t_9;
    const real H_0_1 = t_13 - t_12;
    const real H_0_2 = p_time_offset * t_9 - p_time_offset * t_11;
    const real H_0_3 = p_time_offset * t_12 - p_time_offset * t_13;
    real L[10], dx[4];
    int refused = 0;
    memcpy(L, P, sizeof L);
    for (int i = 0; i < 4; i++) dx[i] = R(0.0);
    *nis = R(0.0);
    {
        const real PH[4] = {H_0_0 * L[0] + H_0_1 * L[1] + H_0_2 * L[2] + H_0_3 * L[3], H_0_0 * L[1] + H_0_1 * L[4] + H_0_2 * L[5] + H_0_3 * L[6], H_0_0 * L[2] + H_0_1 * L[5] + H_0_2 * L[7] + H_0_3 * L[8], H_0_0 * L[3] + H_0_1 * L[6] + H_0_2 * L[8] + H_0_3 * L[9]};
        s[0] = variance + H_0_0 * PH[0] + H_0_1 * PH[1] + H_0_2 * PH[2] + H_0_3 * PH[3];
        nu[0] = r_0 - (H_0_0 * dx[0] + H_0_1 * dx[1] + H_0_2 * dx[2] + H_0_3 * dx[3]);
        refused += rn_scalar_update(L, dx, PH, 4, s[0], variance, nu[0], nis);
    }
    const real weight = refused ? R(0.0) : rn_weight(rule, *nis, R(1.0));
    if (!(weight > R(0.0))) return R(0.0);
    if (weight < R(1.0)) rn_soften(L, P, 10, dx, 4, weight);
    memcpy(P, L, sizeof L);
    rn_uwb_2d_inject(x, dx);
    return weight;
}

RN_INLINE void rn_uwb_2d_measure_position(const real *x, const real *z, const real *p, real *h)
{
    RN_UNUSED(z);
    RN_UNUSED(p);
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    h[0] = s_p_n_0;
    h[1] = s_p_n_1;
}

RN_INLINE void rn_uwb_2d_residual_position(const real *x, const real *z, const real *p, real *r)
{
    RN_UNUSED(p);
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real z_0 = z[0];
    const real z_1 = z[1];
    r[0] = z_0 - s_p_n_0;
    r[1] = z_1 - s_p_n_1;
}

RN_INLINE void rn_uwb_2d_jacobian_position(const real *x, const real *z, const real *p, real *H)
{
    RN_UNUSED(x);
    RN_UNUSED(z);
    RN_UNUSED(p);
    H[0] = R(1.0);
    H[1] = R(0.0);
    H[2] = R(0.0);
    H[3] = R(0.0);
    H[4] = R(0.0);
    H[5] = R(1.0);
    H[6] = R(0.0);
    H[7] = R(0.0);
}

RN_INLINE void rn_uwb_2d_innovation_position(const real *x, const real *z, const real *p, real *r)
{
    RN_UNUSED(p);
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real z_0 = z[0];
    const real z_1 = z[1];
    r[0] = z_0 - s_p_n_0;
    r[1] = z_1 - s_p_n_1;
}

RN_INLINE real rn_uwb_2d_update_position(real *x, real *P, const real *z, real variance, RN(rule) rule, const real *p, real *nu, real *s, real *nis)
{
    RN_UNUSED(p);
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real z_0 = z[0];
    const real z_1 = z[1];
    const real r_0 = z_0 - s_p_n_0;
    const real r_1 = z_1 - s_p_n_1;
    const real H_0_0 = R(1.0);
    const real H_1_1 = R(1.0);
    real L[10], dx[4];
    int refused = 0;
    memcpy(L, P, sizeof L);
    for (int i = 0; i < 4; i++) dx[i] = R(0.0);
    *nis = R(0.0);
    {
        const real PH[4] = {H_0_0 * L[0], H_0_0 * L[1], H_0_0 * L[2], H_0_0 * L[3]};
        s[0] = variance + H_0_0 * PH[0];
        nu[0] = r_0 - (H_0_0 * dx[0]);
        refused += rn_scalar_update(L, dx, PH, 4, s[0], variance, nu[0], nis);
    }
    {
        const real PH[4] = {H_1_1 * L[1], H_1_1 * L[4], H_1_1 * L[5], H_1_1 * L[6]};
        s[1] = variance + H_1_1 * PH[1];
        nu[1] = r_1 - (H_1_1 * dx[1]);
        refused += rn_scalar_update(L, dx, PH, 4, s[1], variance, nu[1], nis);
    }
    const real weight = refused ? R(0.0) : rn_weight(rule, *nis, R(2.0));
    if (!(weight > R(0.0))) return R(0.0);
    if (weight < R(1.0)) rn_soften(L, P, 10, dx, 4, weight);
    memcpy(P, L, sizeof L);
    rn_uwb_2d_inject(x, dx);
    return weight;
}

RN_INLINE void rn_uwb_2d_gain(const real *K, const real *r, real *e)
{
    e[0] = K[0] * r[0] + K[1] * r[1] + K[2] * r[2] + K[3] * r[3];
    e[1] = K[4] * r[0] + K[5] * r[1] + K[6] * r[2] + K[7] * r[3];
    e[2] = K[8] * r[0] + K[9] * r[1] + K[10] * r[2] + K[11] * r[3];
    e[3] = K[12] * r[0] + K[13] * r[1] + K[14] * r[2] + K[15] * r[3];
}

RN_INLINE void rn_uwb_2d_correct(real *x, const real *z, const real *K, const real *p, real *r)
{
    const real s_p_n_0 = x[0];
    const real s_p_n_1 = x[1];
    const real s_v_n_0 = x[2];
    const real s_v_n_1 = x[3];
    const real p_time_offset = p[0];
    const real p_tag_down = p[2];
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
    const real t_0 = s_p_n_0 - p_time_offset * s_v_n_0;
    const real t_1 = s_p_n_1 - p_time_offset * s_v_n_1;
    const real r_0 = z_0 - rn_sqrt((((p_tag_down - z_3) * (p_tag_down - z_3)) + ((t_0 - z_1) * (t_0 - z_1)) + ((t_1 - z_2) * (t_1 - z_2))));
    const real r_1 = z_4 - ((rn_sqrt((((p_tag_down - z_10) * (p_tag_down - z_10)) + ((t_0 - z_8) * (t_0 - z_8)) + ((t_1 - z_9) * (t_1 - z_9)))) - rn_sqrt((((p_tag_down - z_7) * (p_tag_down - z_7)) + ((t_0 - z_5) * (t_0 - z_5)) + ((t_1 - z_6) * (t_1 - z_6))))));
    const real r_2 = z_11 - s_p_n_0;
    const real r_3 = z_12 - s_p_n_1;
    const real de_0 = K_0 * r_0 + K_1 * r_1 + K_2 * r_2 + K_3 * r_3;
    const real de_1 = K_4 * r_0 + K_5 * r_1 + K_6 * r_2 + K_7 * r_3;
    const real de_2 = K_8 * r_0 + K_9 * r_1 + K_10 * r_2 + K_11 * r_3;
    const real de_3 = K_12 * r_0 + K_13 * r_1 + K_14 * r_2 + K_15 * r_3;
    x[0] = de_0 + s_p_n_0;
    x[1] = de_1 + s_p_n_1;
    x[2] = de_2 + s_v_n_0;
    x[3] = de_3 + s_v_n_1;
    r[0] = r_0;
    r[1] = r_1;
    r[2] = r_2;
    r[3] = r_3;
}

static const RN(sensor) rn_uwb_2d_sensors[] = {
    {"range", 1, 4, 1, 4, rn_uwb_2d_measure_range, rn_uwb_2d_residual_range, rn_uwb_2d_jacobian_range, rn_uwb_2d_innovation_range, rn_uwb_2d_update_range},
    {"tdoa", 1, 7, 1, 4, rn_uwb_2d_measure_tdoa, rn_uwb_2d_residual_tdoa, rn_uwb_2d_jacobian_tdoa, rn_uwb_2d_innovation_tdoa, rn_uwb_2d_update_tdoa},
    {"position", 2, 2, 2, 2, rn_uwb_2d_measure_position, rn_uwb_2d_residual_position, rn_uwb_2d_jacobian_position, rn_uwb_2d_innovation_position, rn_uwb_2d_update_position}};
static const RN(model) rn_uwb_2d_model = {
    RN_ABI, (int)sizeof(real), "uwb_2d", 4, 4, 0, 1, 3, 3, 4, rn_uwb_2d_sensors,
    rn_uwb_2d_propagate, rn_uwb_2d_predict, rn_uwb_2d_transition, rn_uwb_2d_noise, rn_uwb_2d_inject, rn_uwb_2d_inject_turned, rn_uwb_2d_difference, rn_uwb_2d_carry, rn_uwb_2d_gain, rn_uwb_2d_correct};

#endif
