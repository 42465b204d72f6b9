/* Every built-in model as one translation unit, to be compiled under warnings in double and in float. */
#include "rn_models.h"

const RN(model) *const *RN(probe)(void);

const RN(model) *const *RN(probe)(void) { return rn_built_in; }
