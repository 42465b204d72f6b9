/* The snapshot solver in float. */
#define RN_FLOAT
#define RN_FIX_RUN rn_fix_run_float
#define RN_WINDOW_RUN rn_window_run_float
#include "rn_snapshot_host.h"
#include "../rn_snapshot_core.c"
#include "../rn_snapshot_starts.c"
#include "../rn_snapshot_honest.c"
#include "../rn_snapshot_judge.c"
#include "../rn_snapshot.c"
#include "../rn_snapshot_window.c"
#include "rn_snapshot_host.c"
