/* The kernel in double. */
#define RN_UNROLL
#define RN_HOST_NAME rn_host_double
#include "../rn_filter.c"
#include "../rn_ukf.c"
#include "rn_call.c"
#include "rn_host.c"
