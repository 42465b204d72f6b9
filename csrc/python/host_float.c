/* The kernel in float. */
#define RN_FLOAT
#define RN_UNROLL
#define RN_HOST_NAME rn_host_float
#include "../rn_filter.c"
#include "../rn_ukf.c"
#include "rn_call.c"
#include "rn_host.c"
