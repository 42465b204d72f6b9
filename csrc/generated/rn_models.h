/* Generated: the list of built-in models; do not edit: make generate. */
#ifndef RN_MODELS_H
#define RN_MODELS_H
#include "rn_attitude.h"
#include "rn_attitude_euler.h"
#include "rn_uwb_2d.h"
#include "rn_uwb_2d_driven.h"
#include "rn_uwb_2d_biased.h"
#include "rn_uwb_3d.h"
#include "rn_uwb_3d_driven.h"
#include "rn_uwb_3d_biased.h"
#include "rn_inertial.h"
#include "rn_inertial_biased.h"
#include "rn_uwb_planar.h"
#include "rn_alignment.h"
#include "rn_alignment_so3.h"
#include "rn_alignment_so3_3.h"

static const RN(model) *const rn_built_in[] = {
    &rn_attitude_model,
    &rn_attitude_euler_model,
    &rn_uwb_2d_model,
    &rn_uwb_2d_driven_model,
    &rn_uwb_2d_biased_model,
    &rn_uwb_3d_model,
    &rn_uwb_3d_driven_model,
    &rn_uwb_3d_biased_model,
    &rn_inertial_model,
    &rn_inertial_biased_model,
    &rn_uwb_planar_model,
    &rn_alignment_model,
    &rn_alignment_so3_model,
    &rn_alignment_so3_3_model,
    0};

#endif
