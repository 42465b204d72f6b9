"""The verdict on a survey in words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robustnav.records import Array, IntArray
from robustnav.survey.record import Suspect, Weak

NAMED = 5  # ranges written out


def _vector(v: Array) -> str:
    return "(" + ", ".join(f"{x:.2f}" for x in v) + ")"


def unique(sd: float, dof: int) -> str:
    """Say how good a single layout is and whether anything tested it."""
    tested = f"residuals fit with {dof} to spare" if dof > 0 else "no range to spare: a wrong one would not show"
    return f"One layout, sd {sd:.3g} m in its weakest direction; {tested}."


def ambiguous(best: Array, others: Sequence[Array], ids: Sequence[str], mirror: bool) -> str:
    """Say which layouts fit alike, or that the whole may be mirrored."""
    if mirror:
        do = "say on which side of the first three another anchor stands"
        return f"The layout and its mirror image in the plane of the first three anchors fit alike: {do}."
    off = np.linalg.norm(others[0][: len(ids)] - best[: len(ids)], axis=1)
    moved = [k for k in range(len(ids)) if off[k] > 0.1 * off.max()]
    where = ", ".join(f"{ids[k]} at {_vector(best[k])} or {_vector(others[0][k])} m" for k in moved[:NAMED])
    more = f" and {len(moved) - NAMED} more" if len(moved) > NAMED else ""
    return f"{1 + len(others)} layouts fit alike: {where}{more}."


def degenerate(weak: Weak, cause: str) -> str:
    """Say which anchor is not bound, and in which direction."""
    size = f"sd {weak.sd:.3g} m" if np.isfinite(weak.sd) else "no bound"
    along = f" with {', '.join(n for n in weak.moving if n != weak.anchor)}" if len(weak.moving) > 1 else ""
    return f"Anchor {weak.anchor}{along} is not bound along {_vector(weak.direction)}, {size}: {cause}."


def inconsistent(test: tuple[float, float, int], suspects: Sequence[Suspect], isolated: bool, scale: float) -> str:
    """Say that residuals are too large and whose they are."""
    cost, limit, dof = test
    out = f"The ranges contradict each other: squared residuals {cost:.1f}, limit {limit:.1f} with {dof} to spare."
    if suspects:
        named = ", ".join(f"{s.ends} by {s.error:+.2f} m ({s.sds:.1f} sd)" for s in suspects[:NAMED])
        more = f" and {len(suspects) - NAMED} more" if len(suspects) > NAMED else ""
        out += f" {'Wrong' if isolated else 'One of these explains it'}: {named}{more}."
    if scale > 1:
        out += f" What is left scatters {scale:.1f} times as much as the sds say; the covariance allows for it."
    return out


def apart(ids: Sequence[str], groups: IntArray) -> str:
    """Say which anchors no chain of ranges ties to the others."""
    main = np.bincount(groups).argmax()
    lost = [name for name, group in zip(ids, groups, strict=True) if group != main]
    return f"No chain of ranges ties {', '.join(lost)} to the other anchors: no layout."
