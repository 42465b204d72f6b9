/* One step backwards through a recording, after a filter has gone forwards.  No allocation, no globals. */
#ifndef RN_SMOOTH_H
#define RN_SMOOTH_H

#include "rn_model.h"

/* Numbers of scratch a step needs. */
int RN(smooth_scratch)(const RN(model) * m);

/* What the whole recording says of the start of a step of dt seconds, dt > 0.
 *
 * x, P: the filter's state and packed covariance there, with every reading of that instant; on return the smoothed ones.
 * next, P_next: smoothed at the step's end.  A number that is not finite spreads backwards. */
void RN(smooth_step)(const RN(model) * m, real *x, real *P, const real *next, const real *P_next, const real *u,
                     const real *q, const real *p, real dt, real *scratch);

#endif
