/* Strapdown integration in double. */
#define RN_STRAPDOWN_HOST rn_strapdown_double
#include "rn_strapdown_host.c"
