/* The snapshot solver in double. */
#define RN_FIX_RUN rn_fix_run_double
#define RN_WINDOW_RUN rn_window_run_double
#include "rn_snapshot_host.h"
#include "../rn_snapshot_core.c"
#include "../rn_snapshot_starts.c"
#include "../rn_snapshot_honest.c"
#include "../rn_snapshot_judge.c"
#include "../rn_snapshot.c"
#include "../rn_snapshot_window.c"
#include "rn_snapshot_host.c"
