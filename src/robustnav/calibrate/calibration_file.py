"""Calibrations in TOML: written whole or not at all, every number back bit for bit.

::

    calibration = "ranges"
    by = "anchor"                       # all: key = []; anchor; link: anchor, then tag
    source = "hall, June"
    [[correction]]
    key = ["A1"]
    slope = 1.004                       # a line; a curve has knots_m and bias_m
    offset_m = 0.075
    range_variance_m2 = 0.0044
    [correction.fitted]                 # absent where the numbers were stated, not fitted
    covariance = [[1e-09, -2e-08], [-2e-08, 1e-06]]
    dof = 10568
    ...
"""

from __future__ import annotations

import json
import os
import tomllib
from collections.abc import Iterator
from pathlib import Path

from robustnav.calibrate.bias_curve import BiasCurve
from robustnav.calibrate.range_line import Fitted, RangeLine
from robustnav.calibrate.ranges import RangeCalibration
from robustnav.errors import InputError
from robustnav.files import write_whole

EXPECTED = 'a calibration: calibration = "ranges", by, and one [[correction]] at least'


def write_calibration(calibration: RangeCalibration, path: str | os.PathLike[str]) -> None:
    """Write a calibration as TOML; an existing file is replaced only by a complete one.

    Raises
    ------
    InputError : a name that is not printable, or a path that cannot be written.
    """
    file = Path(path)
    wrong = [
        t for t in (calibration.source, *(n for key in calibration.corrections for n in key)) if not t.isprintable()
    ]
    if wrong:
        raise InputError("calibration", place=file.name, got=repr(wrong[0])[:60], expected="printable names and source")
    write_whole(file, "\n".join(_lines(calibration)) + "\n")


def read_calibration(path: str | os.PathLike[str]) -> RangeCalibration:
    """Return the calibration in a TOML file.

    Raises
    ------
    InputError : no such file, no TOML, or not a calibration; all mistakes are listed at once.
    """
    from pydantic import ValidationError

    from robustnav.calibrate.calibration_schema import CalibrationTable

    file = Path(path)
    try:
        return CalibrationTable.model_validate(tomllib.loads(file.read_text(encoding="utf-8"))).record()
    except ValidationError as why:
        got = "; ".join(f"{'.'.join(map(str, e['loc']))}: {e['msg']}" for e in why.errors(include_url=False))
    except InputError as why:
        got = f"{why.thing}: {why.got}, expected {why.expected}"
    except (OSError, ValueError, RecursionError) as why:  # ValueError: no UTF-8, no TOML, a path with a zero byte
        got = str(why)
    raise InputError("cannot use this calibration", place=file.name, got=got, expected=EXPECTED)


def _lines(calibration: RangeCalibration) -> Iterator[str]:
    yield 'calibration = "ranges"'
    yield f"by = {_text(calibration.by)}"
    yield f"source = {_text(calibration.source)}"
    for key, correction in calibration.corrections.items():
        yield "\n[[correction]]"
        yield f"key = [{', '.join(map(_text, key))}]"
        yield from _correction(correction)
        if correction.fitted is not None:
            yield "[correction.fitted]"
            yield from _fitted(correction.fitted)


def _correction(correction: RangeLine | BiasCurve) -> Iterator[str]:
    if isinstance(correction, RangeLine):
        yield f"slope = {float(correction.slope)!r}"
        yield f"offset_m = {float(correction.offset)!r}"
    else:
        yield f"knots_m = {[float(x) for x in correction.knots]!r}"
        yield f"bias_m = {[float(x) for x in correction.bias]!r}"
    yield f"range_variance_m2 = {float(correction.range_variance)!r}"


def _fitted(fitted: Fitted) -> Iterator[str]:
    yield f"covariance = {[[float(x) for x in row] for row in fitted.covariance]!r}"
    for name in ("dof", "variance_dof", "samples", "files", "outliers"):
        yield f"{name} = {getattr(fitted, name)!r}"
    yield f"distance_min_m = {fitted.distance_min!r}"
    yield f"distance_max_m = {fitted.distance_max!r}"
    yield f"loss = {_text(fitted.loss.kind)}"
    yield f"loss_constant = {float(fitted.loss.constant)!r}"


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)  # of printable text, a TOML string too
