"""The kinds of work that are timed, one file each; a new one joins the list here."""

from robustnav.benchmark.timing import Work
from robustnav.benchmark.works import (
    alignment_step,
    attitude_batch,
    attitude_call,
    ekf_step,
    range_update,
    snapshot,
    strapdown,
    ukf_step,
)

WORKS: tuple[Work, ...] = (
    attitude_batch.WORK,
    attitude_call.WORK,
    ekf_step.WORK,
    ukf_step.WORK,
    range_update.WORK,
    snapshot.WORK,
    strapdown.WORK,
    alignment_step.STEP,
    alignment_step.ALIGN,
)
