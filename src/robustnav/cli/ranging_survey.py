"""``survey``: where anchors stand, from ranges."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from cyclopts import Parameter

from robustnav.cli.options import Flag
from robustnav.cli.show import note, say, say_json, say_table
from robustnav.errors import InputError

if TYPE_CHECKING:
    from robustnav.survey import AnchorSurvey, Frame, Known, Measured


@Parameter(name="*")
@dataclass(frozen=True)
class Given:
    """What is known before a survey."""

    known: Path | None = None
    """Survey in TOML of anchors that stand where it says; others are found."""
    heights: str | None = None
    """Heights of anchors above one level, metres: one number for all, or A=2.0,B=1.5 for each that is known."""
    tag_height: float | None = None
    """Height of the tag above the same level, metres, if it stays the same to 5 cm."""
    frame: str | None = None
    """Three anchors A,B,C: origin, direction of x, side of y > 0; default: the first three."""
    side: str | None = None
    """An anchor and +z or -z, as in D:+z: on which side of the plane of the three it stands."""


NOTHING = Given()


def survey(
    files: list[Path],
    /,
    *,
    sd: float,
    given: Given = NOTHING,
    knot: float | None = None,
    loss: Literal["student", "huber"] = "student",
    out: Path | None = None,
    json: Flag = False,
) -> int:
    """Find where anchors stand from ranges between them, to a moving tag, or both.  Exits 3 unless one layout is left.

    Parameters
    ----------
    files
        Tables with from, to, distance_m between anchors; one with t_s, anchor, distance_m to a tag; sd_m in either.
    sd
        Standard deviation of a range, metres, where a table has no sd_m.
    given
        What is known before.
    knot
        Track the tag smoothly with knots this many seconds apart; default: a free position for every stamp.
    loss
        How ranges are reweighted to find those that do not fit.
    out
        TOML file for the anchors; written only if one layout is left.
    json
        Print one JSON document.
    """
    from robustnav.cli.ranging_files import read_survey_ranges
    from robustnav.survey import Options, survey_anchors

    if not sd > 0:
        raise InputError("--sd", got=str(sd), expected="metres above zero")
    known_ids: tuple[str, ...] = ()
    if given.known is not None:
        from robustnav.logs.uwb_survey import read_survey

        surveyed = read_survey(given.known)[0]
        known_ids = surveyed.ids
    measured, notes = read_survey_ranges(files, known_ids, sd)
    before = _known(given, measured)
    found = survey_anchors(measured, before, _frame(given), Options(loss=loss, knot_s=knot))
    for line in notes:
        note(line)
    if out is not None and found.geometry == "unique":
        from robustnav.survey import write_anchors

        write_anchors(found.anchors(), out, (f"{found.verdict}: {found.reason}",))
        note(f"anchors: {out}")
    if json:
        say_json(_document(found))
    else:
        _say_survey(found)
    if found.geometry != "unique":
        note("no anchors written: a single layout is needed" if out is not None else "do not rely on these positions")
    return 0 if found.verdict == "unique" else 3


def _frame(given: Given) -> Frame:
    from robustnav.survey import Frame

    first = None
    if given.frame is not None:
        names = [name.strip() for name in given.frame.split(",")]
        if len(names) != 3:
            raise InputError("--frame", got=repr(given.frame), expected="three anchors as in A,B,C")
        first = (names[0], names[1], names[2])
    if given.side is None:
        return Frame(first)
    name, _, side = given.side.rpartition(":")
    if side == "+z":
        return Frame(first, (name, "+z"))
    if side == "-z":
        return Frame(first, (name, "-z"))
    raise InputError("--side", got=repr(given.side), expected="an anchor and +z or -z as in D:+z")


def _known(given: Given, measured: Measured) -> Known | None:
    """Return what the options say of the anchors, turned to z down."""
    import numpy as np

    from robustnav.cli.ranging_files import numbers_by_name
    from robustnav.survey import Known

    if given.known is None and given.heights is None and given.tag_height is None:
        return None
    p = np.full((len(measured.ids), 3), np.nan)
    sd = None
    if given.known is not None:
        from robustnav.logs.uwb_survey import read_survey

        surveyed = read_survey(given.known)[0]
        p[: len(surveyed.ids)] = surveyed.p_a
        if surveyed.sd is not None:
            sd = np.full_like(p, np.nan)
            sd[: len(surveyed.ids)] = surveyed.sd
    if given.heights is not None:
        if sd is not None:
            do = "leave sd_m out of the survey: its positions then count as exact, like the heights"
            raise InputError("--heights", got="a survey with sd_m beside it", expected="one of the two", do=do)
        heights = numbers_by_name(given.heights, "--heights") if "=" in given.heights else {}
        for name in heights:
            if name not in measured.ids:
                raise InputError("--heights", got=name, expected=f"one of {', '.join(measured.ids)[:200]}")
        for k, name in enumerate(measured.ids):
            if heights and name in heights:
                p[k, 2] = -heights[name]
            if not heights:
                p[k, 2] = -_number(given.heights)
    tag_z = None if given.tag_height is None else -given.tag_height
    return Known(p, sd, tag_z)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError("--heights", got=repr(text), expected="a number, or A=2.0,B=1.5") from None


def _say_survey(found: AnchorSurvey) -> None:
    say(f"{found.verdict}: {found.reason}")
    rows = []
    for k, name in enumerate(found.ids):
        row: dict[str, object] = {"anchor": name}
        row |= {f"{axis}_m": float(x) for axis, x in zip("xyz", found.p_a[k], strict=True)}
        row |= {f"sd_{axis}_m": float(x) for axis, x in zip("xyz", found.sd[k], strict=True)}
        for n, other in enumerate(found.alternatives[:3], start=1):
            row |= {f"or_{n}_{axis}_m": float(x) for axis, x in zip("xyz", other.p_a[k], strict=True)}
        rows.append(row)
    say_table("Anchors in frame a, z down", rows)


def _document(found: AnchorSurvey) -> dict[str, object]:
    from math import isfinite

    weak = found.weak
    return {
        "verdict": found.verdict,
        "geometry": found.geometry,
        "reason": found.reason,
        "anchors": [{"id": name, "p_a_m": found.p_a[k], "sd_m": found.sd[k]} for k, name in enumerate(found.ids)],
        "alternatives": [other.p_a for other in found.alternatives],
        "weakest": None
        if weak is None
        else {
            "anchor": weak.anchor,
            "direction": weak.direction,
            "sd_m": weak.sd if isfinite(weak.sd) else None,
            "moving": weak.moving,
        },
        "suspects": [suspect._asdict() for suspect in found.suspects],
        "isolated": found.isolated,
        "squared_residuals": found.cost,
        "degrees_of_freedom": found.dof,
        "scale": found.scale,
    }
