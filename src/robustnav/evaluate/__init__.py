"""Numbers from what an estimator said and what was true: errors, consistency, benchmark metrics, tables."""

from robustnav.evaluate.attitude import AttitudeErrors, attitude_errors, attitude_of, evaluate
from robustnav.evaluate.broad import group_means, trial_group, trial_metric
from robustnav.evaluate.consistency import Consistency, chi_square_band, consistency, nees, nis
from robustnav.evaluate.monte_carlo import MonteCarlo, monte_carlo, settle_time
from robustnav.evaluate.reference import Reference, reference_at
from robustnav.evaluate.tables import json_rows, score_rows, text_table

__all__ = [
    "AttitudeErrors",
    "Consistency",
    "MonteCarlo",
    "Reference",
    "attitude_errors",
    "attitude_of",
    "chi_square_band",
    "consistency",
    "evaluate",
    "group_means",
    "json_rows",
    "monte_carlo",
    "nees",
    "nis",
    "reference_at",
    "score_rows",
    "settle_time",
    "text_table",
    "trial_group",
    "trial_metric",
]
