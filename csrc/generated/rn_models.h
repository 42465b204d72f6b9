/* Generated: the list of built-in models; do not edit: make generate. */
#ifndef RN_MODELS_H
#define RN_MODELS_H
#include "rn_attitude.h"
#include "rn_attitude_euler.h"

static const RN(model) *const rn_built_in[] = {
    &rn_attitude_model,
    &rn_attitude_euler_model,
    0};

#endif
