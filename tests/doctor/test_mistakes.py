"""Every usual mistake, made on purpose on a good recording, must be named; the good recording must pass."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from robustnav.doctor import examine
from robustnav.frames import (
    frd_from_flu,
    ned_from_enu,
    quat_conjugate,
    quat_from_euler,
    quat_multiply,
    quat_ned_frd_from_enu_flu,
    rotate,
    rotvec_from_quat,
)
from robustnav.records import Log, Stream, Truth

DATA = os.environ.get("ROBUSTNAV_DATA")


def synthetic() -> Log:
    """Twelve seconds of turning about all axes between two rests: IMU 250 Hz, field 80 Hz, attitude 100 Hz."""
    rng = np.random.default_rng(3)
    swing = np.array([0.4, 0.3, 0.7])

    def q_nb(t):
        active = np.clip(t - 3, 0, None) * (t < 15) + 12 * (t >= 15)
        phase = np.outer(active, 2 * np.pi * np.array([3, 4, 2]) / 12)
        return quat_from_euler(swing * np.sin(phase))

    def rate_b(t, h=1e-4):
        return rotvec_from_quat(quat_multiply(quat_conjugate(q_nb(t - h)), q_nb(t + h))) / (2 * h)

    def body(t, v_n, sd):
        return rotate(quat_conjugate(q_nb(t)), v_n) + sd * rng.standard_normal((len(t), 3))

    t, tm, ta = np.arange(0, 18, 0.004), np.arange(0.001, 18, 0.0125), np.arange(0, 18, 0.01)
    gyro = rate_b(t) + np.array([0.002, -0.001, 0.003]) + 0.002 * rng.standard_normal((len(t), 3))
    streams = {
        "gyro": Stream("gyro", t, gyro, "rad/s"),
        "accel": Stream("accel", t, body(t, [0, 0, -9.80], 0.05), "m/s^2"),
        "mag": Stream("mag", tm, body(tm, [21.5e-6, 0, 43e-6], 3e-7), "T"),
    }
    return Log(streams, "synthetic", estimate=Truth(ta, q_nb(ta - 0.004), "estimate", "magnetic"))


def changed(log, **sensors):
    streams = {n: replace(s, values=sensors[n](s.values)) if n in sensors else s for n, s in log.streams.items()}
    estimate = log.estimate
    if "q" in sensors:
        estimate = replace(estimate, q_nb=sensors["q"](estimate.q_nb))
    return replace(log, streams=streams, estimate=estimate)


def late(log, seconds):
    return replace(log, estimate=replace(log.estimate, t=log.estimate.t + seconds))


FLU = {"gyro": frd_from_flu, "accel": frd_from_flu, "mag": frd_from_flu}
SWAP, NEGATE_Z = [1, 0, 2], np.array([1.0, 1.0, -1.0])
# mistake -> how it is made, the check that names it, and words that must be in thing or remedy
MISTAKES = {
    "accelerometer negated": (lambda g: changed(g, accel=np.negative), "G", "accelerometer negated"),
    "magnetometer negated": (lambda g: changed(g, mag=np.negative), "D", "magnetometer negated"),
    "sensors FLU": (lambda g: changed(g, **FLU), "A", "FLU"),
    "all FLU and ENU": (lambda g: changed(g, **FLU, q=quat_ned_frd_from_enu_flu), "G", "ENU"),
    "gyro in deg/s": (lambda g: changed(g, gyro=np.rad2deg), "S", "deg/s"),
    "accelerometer in g": (lambda g: changed(g, accel=lambda v: v / 9.80665), "F", "unit: g"),
    "accelerometer in milli-g": (lambda g: changed(g, accel=lambda v: v / 9.80665e-3), "F", "milli-g"),
    "magnetometer in microtesla": (lambda g: changed(g, mag=lambda v: v * 1e6), "B", "microtesla"),
    "magnetometer in gauss": (lambda g: changed(g, mag=lambda v: v * 1e4), "B", "unit: gauss"),
    "quaternion conjugated": (lambda g: changed(g, q=quat_conjugate), "A", "conjugated"),
    "quaternion x y z w": (lambda g: changed(g, q=lambda q: np.roll(q, -1, axis=1)), "A", "order of numbers"),
    "gyro x and y swapped": (lambda g: changed(g, gyro=lambda v: v[:, SWAP]), "A", "+y+x+z"),
    "gyro z negated": (lambda g: changed(g, gyro=lambda v: v * NEGATE_Z), "A", "+x+y-z"),
    "attitude 50 ms late": (lambda g: late(g, 0.05), "L", "late"),
}


@pytest.fixture(scope="module")
def good_synthetic():
    return synthetic()


@pytest.fixture(scope="module")
def good_recording():
    if not DATA:
        pytest.skip("set ROBUSTNAV_DATA to the folder with px4/sample.ulg")
    from robustnav.logs import read

    return read(Path(DATA) / "px4" / "sample.ulg")


def check_named(log, mistake):
    make, check, words = MISTAKES[mistake]
    found = examine(make(log))
    level = "warning" if check == "L" else "error"
    named = [f for f in found.of(check) if f.level == level and words in f"{f.thing} {f.do}"]
    assert named, [f for f in found.findings if f.level not in ("ok", "info")]
    return found


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistake_on_synthetic_data_is_named(good_synthetic, mistake):
    check_named(good_synthetic, mistake)


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistake_on_a_recording_is_named(good_recording, mistake):
    check_named(good_recording, mistake)


def test_good_synthetic_data_passes(good_synthetic):
    found = examine(good_synthetic)
    assert not found.at("error")
    assert {f.check for f in found.at("warning")} == {"N", "R"}


def test_same_mistakes_without_attitude(good_synthetic):
    blind = replace(good_synthetic, estimate=None)
    assert not examine(blind).at("error")
    swapped = examine(changed(blind, gyro=lambda v: v[:, SWAP]))
    assert [f.level for f in swapped.of("V")] == ["error"]
    assert "+y+x+z" in swapped.of("V")[0].do
    degrees = examine(changed(blind, gyro=np.rad2deg))
    assert "deg/s" in degrees.of("S")[0].thing
    negated = examine(changed(blind, accel=np.negative))
    assert [f.level for f in negated.of("D")] == ["warning"]


def test_axes_are_not_judged_without_rotation(good_synthetic):
    for wrong in (lambda g: g, MISTAKES["gyro z negated"][0], MISTAKES["quaternion conjugated"][0]):
        found = examine(wrong(good_synthetic).between(0, 2.5))
        assert [f.thing for f in found.of("E")] == ["not enough rotation"]
        assert not [f for check in "AVSL" for f in found.of(check)]


def test_a_slow_drift_is_no_rotation(good_synthetic):
    """A bias that wanders sweeps any angle in time; the search for axes must not start on it."""
    gyro = good_synthetic.streams["gyro"]
    t = np.arange(0, 600, 0.1)
    drift = 1e-3 * np.sin(2 * np.pi * t / 600)[:, None] * np.ones(3)
    log = Log({"gyro": replace(gyro, t=t, values=drift)}, "drift")
    found = examine(log)
    assert max(found.facts["motion"]["swept_deg"]) > 10
    assert [f.thing for f in found.of("E")] == ["not enough rotation"]


def test_consistent_enu_frames_are_what_the_mistake_makes_them(good_synthetic):
    """The converted log must be the same motion seen in ENU, or the test above proves nothing."""
    log = MISTAKES["all FLU and ENU"][0](good_synthetic)
    f_ned = rotate(good_synthetic.estimate.q_nb[:5], [1.0, 2.0, 3.0])
    f_enu = rotate(log.estimate.q_nb[:5], frd_from_flu([1.0, 2.0, 3.0]))
    np.testing.assert_allclose(ned_from_enu(f_enu), f_ned, atol=1e-12)
