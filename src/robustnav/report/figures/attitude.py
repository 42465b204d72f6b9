"""Roll, pitch and yaw against the reference."""

from __future__ import annotations

from robustnav.evaluate.attitude import NOT_AN_ERROR, attitude_of
from robustnav.frames import euler_from_quat
from robustnav.records import Run, Truth
from robustnav.report.drawing import Plot, caption, trace
from robustnav.report.style import ESTIMATE, REFERENCE, add_legend, label_time, label_value, new_figure
from robustnav.units import DEG


def attitude(run: Run, truth: Truth | None = None) -> Plot:
    """Draw roll, pitch and yaw of a run in degrees, with the reference below it where there is one."""
    figure, rows = new_figure(3)
    estimated = euler_from_quat(attitude_of(run)) / DEG
    compared = truth is not None and truth.q_nb is not None
    fewer = False
    for k, (axes, name) in enumerate(zip(rows, ("Roll", "Pitch", "Yaw"), strict=True)):
        if truth is not None and truth.q_nb is not None:
            reference = euler_from_quat(truth.q_nb)[:, k] / DEG
            style = {"color": REFERENCE, "linewidth": 2.4, "alpha": 0.45, "label": f"Reference ({truth.kind})"}
            fewer |= trace(axes, truth.t, reference, turn=360.0, **style)
        fewer |= trace(axes, run.t, estimated[:, k], turn=360.0, color=ESTIMATE, linewidth=1.0, label=run.estimator)
        label_value(axes, f"{name}, deg")
    label_time(rows[-1])
    figure.align_ylabels(rows)
    add_legend(figure, rows[0])
    words = f"Attitude estimated by {run.estimator}" + (" against the reference." if compared else ".")
    other = truth is not None and truth.kind == "estimate"
    return Plot(figure, caption([words, f"What is drawn as reference: {NOT_AN_ERROR}." if other else ""], fewer))
