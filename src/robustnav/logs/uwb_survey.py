"""Surveyed anchors, and where tags sit on the body, in TOML; every convention is written down, none is guessed.

::

    z = "up"                            # up, down: where the third number counts
    [[anchor]]
    id = "A1"
    x_m = 2.5775
    y_m = 0.87
    z_m = 1.97
    sd_m = 0.01                         # optional, of each coordinate
    [[tag]]                             # optional: with none there is one tag, named "tag"
    id = "T0"
    x_m = 0.1                           # forward, right, down from the IMU; all three or none
    y_m = 0.0
    z_m = -0.02

x and y are level and right-handed with z: up, the usual axes; down, x forward, y to the right.  Frame a is z down:
``z = "up"`` is turned to it by (x, -y, -z).  Tags are in body FRD whatever ``z`` says.
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from robustnav.errors import InputError
from robustnav.frames import frd_from_flu
from robustnav.logs.files import checked_path, read_text, unusable
from robustnav.records import Anchors, Array

EXPECTED = 'a survey: z = "up" or "down", and one [[anchor]] with id, x_m, y_m, z_m at least'
Metres = Annotated[float, Field(ge=-1e7, le=1e7, allow_inf_nan=False)]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class _Anchor(_Table):
    id: str
    x_m: Metres
    y_m: Metres
    z_m: Metres
    sd_m: Annotated[float, Field(gt=0, le=1e3, allow_inf_nan=False)] | None = None


class _Tag(_Table):
    id: str
    x_m: Metres | None = None
    y_m: Metres | None = None
    z_m: Metres | None = None

    @model_validator(mode="after")
    def _all_or_none(self) -> _Tag:
        if len({value is None for value in (self.x_m, self.y_m, self.z_m)}) > 1:
            raise ValueError("give x_m, y_m and z_m, or none of them")
        return self


class _Survey(_Table):
    z: Literal["up", "down"]
    anchor: Annotated[tuple[_Anchor, ...], Field(min_length=1)]
    tag: tuple[_Tag, ...] = ()

    @model_validator(mode="after")
    def _same_figures(self) -> _Survey:
        if len({a.sd_m is None for a in self.anchor}) > 1:
            raise ValueError("sd_m: give it for every anchor, or for none")
        if len({t.x_m is None for t in self.tag}) > 1:
            raise ValueError("tag: give a place for every tag, or for none")
        return self


def read_survey(path: Path) -> tuple[Anchors, tuple[str, ...], Array | None]:
    """Return the anchors in frame a, the names of the tags, and their places (tags, 3) [m] in body FRD or None.

    Raises
    ------
    InputError : no TOML, keys that are missing or unknown, or a name that stands twice; all mistakes at once.
    """
    text = read_text(checked_path(path, EXPECTED), EXPECTED)
    try:
        survey = _Survey.model_validate(tomllib.loads(text))
    except (tomllib.TOMLDecodeError, RecursionError) as why:
        raise unusable(path, str(why), EXPECTED, do="correct the TOML") from why
    except ValidationError as why:
        wrong = [f"{'.'.join(map(str, e['loc'])) or 'survey'}: {e['msg']}" for e in why.errors(include_url=False)]
        raise unusable(path, "; ".join(wrong), EXPECTED, do="correct these entries") from why
    places = np.array([[a.x_m, a.y_m, a.z_m] for a in survey.anchor])
    sds = [a.sd_m for a in survey.anchor if a.sd_m is not None]
    try:
        anchors = Anchors(
            tuple(a.id for a in survey.anchor),
            frd_from_flu(places) if survey.z == "up" else places,
            np.repeat(np.array(sds)[:, None], 3, axis=1) if sds else None,
        )
    except InputError as why:
        raise unusable(path, why.got, why.expected, place=why.thing) from why
    levers = [[t.x_m, t.y_m, t.z_m] for t in survey.tag if t.x_m is not None]
    return anchors, tuple(t.id for t in survey.tag) or ("tag",), np.array(levers, float) if levers else None
