/* The kernel in float. */
#define RN_FLOAT
#define RN_UNROLL
#define RN_HOST_NAME rn_host_float
#define RN_SMOOTH_BYTES rn_smooth_bytes_float
#define RN_SMOOTH_ROWS rn_smooth_rows_float
#include "../rn_filter.c"
#include "../rn_ukf.c"
#include "../rn_hinf.c"
#include "../rn_smooth.c"
#include "rn_call.c"
#include "rn_host.c"
#include "rn_smooth_host.c"
