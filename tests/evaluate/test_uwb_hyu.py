"""The HYU metric: printed digits, an independent reckoning in the source's own axes, the ends of the window."""

import os
from pathlib import Path

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.evaluate.position import position_figures
from robustnav.evaluate.uwb_hyu import hyu_errors, hyu_window, in_reference, in_window
from robustnav.frames import frd_from_flu
from robustnav.logs import RangeRecording, read_uwb_hyu
from robustnav.records import Anchors, Log, Ranges, Stream

DATA = os.environ.get("ROBUSTNAV_DATA")
DYNAMIC = Path(DATA or ".") / "uwb" / "hyu" / "dynamic" / "LOS"
needs_data = pytest.mark.skipif(not DATA, reason="set ROBUSTNAV_DATA to the folder with uwb/")
GOLDEN = {  # 3D and 2D, as printed
    ("A", "Trajectory_A/Case_1", "LS"): (1.5735105269013496, 1.0383547322536963, 1.46, 0.98),
    ("A", "Trajectory_A/Case_1", "ESKF"): (1.3352360382795463, 1.1158143587482254, 2.19, 2.09),
    ("B", "Trajectory_B/Case_3", "LS"): (0.7938039481861119, 0.5217163332998607, 1.00, 0.62),
    ("B", "Trajectory_B/Case_3", "ESKF"): (0.7942606204304918, 0.6003375167436632, 1.43, 1.33),
}
ORIGIN = 1734501485_315057992


def recording(t, xyz):
    """A recording with a reference at ``xyz`` in the source's axes, z up."""
    anchors = Anchors(("1",), np.zeros((1, 3)))
    ranges = Ranges(np.zeros(1), np.zeros(1, int), np.zeros(1, int), np.ones(1), anchors)
    position = Stream("position", t, frd_from_flu(xyz), "m", "a")
    return RangeRecording(ranges, Log({}, "made", origin_ns=ORIGIN), {"position": position})


def loop_a(n=400):
    """A path on trajectory A: out to x = 55 at y = -4.2, back at y = 5; the height passes 0.5 m for a while."""
    t = np.arange(n) / 8
    share = np.linspace(0, 2, n)
    x = np.where(share < 1, -2 + 57 * share, 55 - 57 * (share - 1))
    y = np.where(share < 1, -4.2, 5.0)
    z = 0.2 + 0.5 * (np.abs(share - 1.5) < 0.1)
    return t, np.column_stack([x, y, z])


def published_metric(t_ns, xyz, at_ns, estimate):
    """The authors' rules for trajectory A, row by row, in their own axes."""
    start = next(k for k in range(len(xyz)) if xyz[k, 0] > 49.3 and xyz[k, 1] > -5)
    end = next(k for k in range(start, len(xyz)) if xyz[k, 0] <= 12 and xyz[k, 1] > 3.4)
    kept = [k for k in range(start, end + 1) if abs(xyz[k, 2]) < 0.5]
    base = t_ns[start]
    errors = []
    for now, p in zip(at_ns, estimate, strict=True):
        if not t_ns[start] <= now <= t_ns[end]:
            continue
        earlier = [k for k in kept if t_ns[k] - base <= now - base]
        later = [k for k in kept if t_ns[k] - base > now - base]
        if earlier and later:
            a, b = earlier[-1], later[0]
            ratio = ((now - base) - (t_ns[a] - base)) / (t_ns[b] - t_ns[a])
            truth = xyz[a] + ratio * (xyz[b] - xyz[a])
        else:
            truth = xyz[earlier[-1]] if earlier else xyz[later[0]]
        errors.append(p - truth - [0, 0, 1.0])
    return np.array(errors)


def test_the_metric_is_the_published_one_in_other_axes():
    t, xyz = loop_a()
    rng = np.random.default_rng(4)
    at = np.sort(rng.uniform(-1, t[-1] + 1, 500))
    estimate = rng.standard_normal((500, 3)) * 3
    made = recording(t, xyz)
    window = hyu_window(made, "A")
    inside = in_window(made, at, window)
    found = hyu_errors(made, at[inside], frd_from_flu(estimate[inside]), window)
    whole = [np.asarray(ORIGIN + np.round(x * 1e9).astype(np.int64), float) for x in (t, at)]
    expected = published_metric(whole[0], xyz, whole[1], estimate)
    assert len(found) == len(expected) > 100
    np.testing.assert_allclose(frd_from_flu(found), expected, atol=1e-11)


def test_full_errors_take_the_whole_reference_as_it_is():
    t, xyz = loop_a()
    made = recording(t, xyz)
    at = np.array([-1.0, t[0], 20.0, t[-1], t[-1] + 0.1])
    np.testing.assert_array_equal(in_reference(made, at), [False, True, True, True, False])
    above = np.column_stack([np.interp(at, t, column) for column in xyz.T]) + np.array([0, 0, 1.0])
    assert np.abs(hyu_errors(made, at, frd_from_flu(above))).max() < 1e-5  # stamps are 256 ns apart


def test_the_window_of_b_begins_in_the_west_and_ends_where_x_grows():
    x = np.array([9.0, 8.5, 8.5, 3.0, -5.0, 8.0, 8.7, 9.0])
    y = np.array([-8.0, -6.9, -7.1, -8.0, -9.0, -7.5, -6.0, -7.5])
    made = recording(np.arange(8.0), np.column_stack([x, y, 0 * x]))
    assert hyu_window(made, "B") == (2, 7)
    with pytest.raises(InputError, match="never enters the window of A"):
        hyu_window(made, "A")
    with pytest.raises(InputError, match="never leaves the window of B"):
        hyu_window(recording(np.arange(6.0), np.column_stack([x, y, 0 * x])[:6]), "B")
    with pytest.raises(InputError, match="A or B"):
        hyu_window(made, "C")


@needs_data
@pytest.mark.parametrize("case", GOLDEN, ids=lambda case: " ".join(case[::2]))
def test_published_figures_to_the_last_digit(case):
    letter, folder, name = case
    found = read_uwb_hyu(DYNAMIC / folder)
    window, estimate = hyu_window(found, letter), found.estimates[name]
    inside, there = in_window(found, estimate.t, window), in_reference(found, estimate.t)
    figures = position_figures(hyu_errors(found, estimate.t[inside], estimate.values[inside], window))
    full = position_figures(hyu_errors(found, estimate.t[there], estimate.values[there]))
    np.testing.assert_allclose([figures["rmse_3d"], figures["rmse_2d"]], GOLDEN[case][:2], rtol=0, atol=1e-12)
    np.testing.assert_allclose([full["rmse_3d"], full["rmse_2d"]], GOLDEN[case][2:], atol=0.006)
    if name == "ESKF":
        assert figures["samples"] == {"A": 1398, "B": 928}[letter]


@needs_data
def test_the_axes_of_the_reader_keep_distances_and_handedness():
    folder = DYNAMIC / "Trajectory_A" / "Case_1"
    found = read_uwb_hyu(folder)
    rows = np.loadtxt(folder / "trajectory.csv", delimiter=",", skiprows=1, usecols=(1, 2, 3))
    C = np.linalg.lstsq(rows, found.reference["position"].values, rcond=None)[0].T
    np.testing.assert_allclose(C, np.diag([1.0, -1.0, -1.0]), atol=1e-9)
    assert np.linalg.det(C) == pytest.approx(1.0)
