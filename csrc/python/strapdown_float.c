/* Strapdown integration in float. */
#define RN_FLOAT
#define RN_STRAPDOWN_HOST rn_strapdown_float
#include "rn_strapdown_host.c"
