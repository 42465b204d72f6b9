"""The verdict in a sentence."""

from __future__ import annotations

import numpy as np

from robustnav.records import Array
from robustnav.snapshot.record import POOR_GDOP, Candidate, Dop, Plane, Suspect, Weak

NAMED = 3  # other positions written out
CAUSES = {
    "singular": "the geometry leaves a direction open",
    "unsettled": "the search did not settle",
    "on anchor": "the tag is on an anchor, whose range gives no direction there",
    "merged": "several minima run into one long region",
    "bent": "the region of good fit is longer than its ellipsoid",
    "gdop": "the dilution of precision is too large",
}


def vector(v: Array) -> str:
    """Return a position or direction as text."""
    return "(" + ", ".join(f"{x:.2f}" for x in v) + ")"


def unique(best: Candidate, quality: Dop, dof: int) -> str:
    """Say how good a single solution is and whether anything tested it."""
    sd = np.sqrt(np.trace(best.covariance))
    tested = f"residuals fit with {dof} to spare" if dof > 0 else "no reading to spare: a wrong one would not show"
    geometry = " (poor)" if quality.gdop > POOR_GDOP else ""
    return f"One solution, sd {sd:.3g} m in all directions together, GDOP {quality.gdop:.1f}{geometry}; {tested}."


def ambiguous(best: Candidate, others: tuple[Candidate, ...], plane: Plane | None) -> str:
    """Say which positions fit alike and what mirrors them."""
    places = " and ".join(vector(c.position) for c in (best, *others))
    if plane is None:
        return f"{1 + len(others)} positions fit alike: {places} m."
    kind = "plane" if plane.normal.size == 3 else "line"
    return (
        f"Two mirror images fit alike: {places} m; the anchors lie within {plane.distance:.3f} m rms of the {kind} "
        f"through {vector(plane.point)} with normal {vector(plane.normal)}."
    )


def degenerate(cause: str, weak: Weak, others: tuple[Candidate, ...]) -> str:
    """Say which direction is not observable, and which other positions fit."""
    size = f"sd {weak.sd:.3g} m" if np.isfinite(weak.sd) else "nothing bounds it"
    places = "; as good: " + ", ".join(vector(c.position) for c in others[:NAMED]) + " m" if others else ""
    places += f" and {len(others) - NAMED} more" if len(others) > NAMED else ""
    return f"Not observable along {vector(weak.direction)}, {size}: {CAUSES[cause]}{places}."


def inconsistent(cost: float, limit: float, dof: int, suspects: tuple[Suspect, ...], isolated: bool) -> str:
    """Say that the residuals are too large and whose they are."""
    test = f"The readings contradict each other: squared residuals {cost:.1f}, limit {limit:.1f} with {dof} to spare."
    if not suspects:
        return f"{test} No anchor left out makes the others agree in a way that can be tested."
    named = ", ".join(f"anchor {s.anchor} by {s.error:+.2f} m ({s.sds:.1f} sd)" for s in suspects)
    return f"{test} {'Wrong' if isolated else 'One of several explanations'}: {named}."


def too_few(readings: int, unknowns: int) -> str:
    """Say how many readings are missing."""
    return f"{readings} independent readings for {unknowns} unknown coordinates."
