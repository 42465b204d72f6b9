"""BROAD trials: conversion of frames, and every shape that is not one."""

import os
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from robustnav.errors import InputError
from robustnav.frames import frd_from_flu, ned_from_enu, rotate
from robustnav.logs import read
from robustnav.logs.matlab5 import load_matlab5

DATA = os.environ.get("ROBUSTNAV_DATA")


def write(folder, fields):
    path = folder / "trial.mat"
    savemat(path, fields)
    return path


def test_vectors_attitude_and_position_are_the_same_in_our_frames(tmp_path, trial):
    log = read(write(tmp_path, trial))
    np.testing.assert_allclose(log.streams["gyro"].values, frd_from_flu(trial["imu_gyr"]))
    np.testing.assert_allclose(log.streams["mag"].values, frd_from_flu(trial["imu_mag"]) * 1e-6)
    np.testing.assert_allclose(log.truth.p_n[0], [2, 1, -3])
    # Turning a sensor vector into the world, then the world into NED, must not depend on which side converts.
    world = ned_from_enu(rotate(trial["opt_quat"], trial["imu_acc"]))
    np.testing.assert_allclose(rotate(log.truth.q_nb, log.streams["accel"].values), world, atol=1e-12)
    assert np.isnan(log.truth.q_nb[3]).all()
    assert log.truth.moving.dtype == bool
    assert log.truth.moving.sum() == 29
    np.testing.assert_allclose(log.streams["gyro"].t, np.arange(40) * 0.0035)
    assert (log.truth.kind, log.truth.north) == ("optical", "magnetic")


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("imu_gyr", np.zeros((40, 2)), "imu_gyr(.|\n)*shape"),
        ("imu_acc", np.zeros((39, 3)), "imu_acc(.|\n)*shape"),
        ("imu_acc", np.zeros((40, 3, 1)), "imu_acc"),
        ("imu_acc", {"a": 1.0}, "imu_acc"),
        ("imu_gyr", np.zeros((40, 3)) * 1j, "imu_gyr"),
        ("imu_acc", np.full((40, 3), "x", dtype=object), "imu_acc"),
        ("imu_mag", "text", "imu_mag"),
        ("sampling_rate", np.array([[np.nan]]), "sampling_rate"),
        ("sampling_rate", np.array([[0.0]]), "sampling_rate"),
        ("movement", np.full((40, 1), 3, np.uint8), "movement"),
        ("opt_quat", np.full((40, 4), 0.9), "opt_quat row 0"),
        ("imu_gyr", np.full((40, 3), np.inf), "row 0"),
    ],
)
def test_what_is_no_trial_is_refused(tmp_path, trial, name, value, words):
    with pytest.raises(InputError, match=words):
        read(write(tmp_path, trial | {name: value}))


def test_missing_fields_are_all_named(tmp_path, trial):
    del trial["imu_mag"], trial["movement"]
    with pytest.raises(InputError, match="imu_mag, movement"):
        read(write(tmp_path, trial))


@pytest.mark.skipif(not DATA, reason="set ROBUSTNAV_DATA to the folder with broad/")
def test_a_real_trial():
    log = read(Path(DATA or ".") / "broad" / "10_undisturbed_slow_translation_A.mat")
    assert len(log.streams["gyro"]) == 55409
    assert int(np.isnan(log.truth.q_nb).any(axis=1).sum()) == 42
    assert 0.6 < log.truth.moving.mean() < 0.65


@pytest.mark.parametrize("compressed", [False, True])
@pytest.mark.parametrize("kind", ["f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8"])
def test_arrays_are_what_the_other_reader_says(tmp_path, kind, compressed):
    rng = np.random.default_rng(4)
    want = {"a": (100 * rng.random((7, 3))).astype(kind), "bb": np.ones((1, 1), kind), "empty": np.zeros((0, 3), kind)}
    savemat(tmp_path / "x.mat", want | {"text": "not a number"}, do_compression=compressed)
    got = load_matlab5(tmp_path / "x.mat")
    for name, values in want.items():
        np.testing.assert_array_equal(got[name].values, values)
        assert got[name].values.shape == values.shape
    assert got["text"].values is None


def test_compressed_data_may_not_grow_without_end(tmp_path, monkeypatch):
    savemat(tmp_path / "x.mat", {"a": np.zeros((10_000, 3))}, do_compression=True)
    monkeypatch.setattr("robustnav.logs.matlab5.LARGEST", 100_000)
    with pytest.raises(InputError, match="beyond"):
        load_matlab5(tmp_path / "x.mat")
