"""What a layout can give before anything is flown."""

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.records import Anchors
from robustnav.snapshot import Sensing, dop_at
from robustnav.survey.layout import Box, Flight, figures_of, plan_layout

BOX = Box(0.0, 10.0, 0.0, 8.0)
ROOM = Anchors(tuple("ABCDEFGH"), np.array([[x, y, z] for x in (0.0, 10.0) for y in (0.0, 8.0) for z in (0.0, -3.0)]))
CEILING = Anchors(tuple("ABCD"), np.array([[0, 0, -3.0], [10, 0, -3], [10, 8, -3], [0, 8, -3]]))


def flight(**changes):
    settings = {"z": -1.0, "box": BOX, "grid": 1.0, "sd": 0.1, "sensing": Sensing()}
    return Flight(**settings | changes)


def test_a_room_of_eight_gives_one_place_everywhere():
    plan = plan_layout(ROOM, flight())
    assert plan.verdicts == {"unique": 1.0}
    assert plan.dop.gdop.shape == (9, 11) == (plan.y.size, plan.x.size)
    here = dop_at(ROOM.p_a, [[plan.x[3], plan.y[5], -1.0]], Sensing())
    assert plan.dop.gdop[5, 3] == pytest.approx(here.gdop[0])
    assert (plan.one_out.gdop >= plan.dop.gdop).all()
    assert plan.extra_gdop[1] < plan.extra_gdop[0]


def test_one_ceiling_mirrors_the_tag_and_says_in_what():
    plan = plan_layout(CEILING, flight())
    assert plan.verdicts["ambiguous"] > 0.9 and plan.flatness < 1e-9
    known = plan_layout(CEILING, flight(sensing=Sensing(height_known=True)))
    assert known.verdicts == {"unique": 1.0} and np.isnan(known.dop.vdop).all()


def test_at_the_ceilings_own_height_nothing_bounds_the_height():
    numbers = figures_of(plan_layout(CEILING, flight(z=-3.0)).dop.gdop)
    assert (numbers.blind, numbers.beyond_50, numbers.worst) == (1.0, 1.0, np.inf)


def test_the_extra_anchor_leaves_the_ceilings_plane():
    plan = plan_layout(CEILING, flight(z=-2.9))
    assert plan.extra[2] == 0.0


def test_differences_are_worse_than_ranges():
    ranges, differences = (plan_layout(ROOM, flight(sensing=Sensing(kind))) for kind in ("ranges", "differences"))
    assert (differences.dop.gdop >= ranges.dop.gdop).all()
    assert differences.verdicts["unique"] > 0.9


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"box": Box(0, 0, 0, 1)}, "x0 < x1"),
        ({"box": Box(0, np.inf, 0, 1)}, "finite"),
        ({"grid": 0.0}, "grid"),
        ({"grid": 1e-3}, "widen the grid"),
        ({"sd": -1.0}, "sd"),
        ({"z": np.nan}, "height"),
    ],
)
def test_bad_flights_are_refused(change, words):
    with pytest.raises(InputError, match=words):
        plan_layout(ROOM, flight(**change))


def test_anchors_in_a_row_need_a_box():
    row = Anchors(tuple("ABC"), np.array([[0, 0, -1.0], [5, 0, -1], [9, 0, -1]]))
    with pytest.raises(InputError, match="give the box"):
        plan_layout(row, flight(box=None))
