/* The alignment in double. */
#define RN_ALIGN_BYTES rn_align_bytes_double
#define RN_ALIGN_BEGIN rn_align_begin_double
#define RN_ALIGN_RUN rn_align_run_double
#define RN_ALIGN_ONE rn_align_one_double
#define RN_ALIGN_LINES_IN rn_align_lines_double
#include "../rn_align_filter.c"
#include "../rn_align_compass.c"
#include "../rn_align_heading.c"
#include "../rn_align_lines.c"
#include "../rn_align_level.c"
#include "../rn_align_record.c"
#include "../rn_align_wind.c"
#include "../rn_align.c"
#include "rn_align_host.c"
