import os
from pathlib import Path

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.evaluate import evaluate, group_means, trial_group, trial_metric
from robustnav.frames import quat_from_rotvec, quat_multiply, quat_ned_frd_from_enu_flu, quat_normalize
from robustnav.records import Run, Truth
from robustnav.units import DEG

DATA = os.environ.get("ROBUSTNAV_DATA")


def run_of(t, q_nb):
    return Run("vqf", "ahrs", t, {"q_nb": q_nb}, {}, {})


def test_only_motion_with_a_reference_counts_and_nothing_is_aligned():
    t = np.arange(6.0)
    q_ref = np.tile([1.0, 0.0, 0.0, 0.0], (6, 1))
    q_ref[5] = np.nan
    q_est = quat_from_rotvec(np.outer([90.0, 90.0, 5.0, 5.0, 5.0, 90.0], [0, 0, DEG]))
    metric = trial_metric(run_of(t, q_est), Truth(t, q_ref, moving=t >= 2))
    assert metric["samples"] == 3
    assert metric["total_deg"] == pytest.approx(5.0)
    assert metric["heading_deg"] == pytest.approx(5.0)
    assert metric["inclination_deg"] == pytest.approx(0.0, abs=1e-9)


def test_a_nan_estimate_in_motion_fails_the_trial():
    t = np.arange(6.0)
    q = np.tile([1.0, 0.0, 0.0, 0.0], (6, 1))
    q_est = q.copy()
    q_est[4] = np.nan
    metric = trial_metric(run_of(t, q_est), Truth(t, q, moving=t >= 2))
    assert np.isnan(metric["total_deg"]) and metric["nan_estimates"] == 1
    assert np.isnan(group_means({"07_x": metric})["all"]["total_deg"])
    still = trial_metric(run_of(t, q_est), Truth(t, q, moving=t <= 2))
    assert still["total_deg"] == 0 and still["nan_estimates"] == 0


@pytest.mark.parametrize("moving", [None, np.zeros(3, bool)])
def test_a_truth_without_motion_is_refused(moving):
    q = np.tile([1.0, 0.0, 0.0, 0.0], (3, 1))
    with pytest.raises(InputError, match="no sample in motion"):
        trial_metric(run_of(np.arange(3.0), q), Truth(np.arange(3.0), q, moving=moving))


def test_group_mean_is_the_mean_of_the_trials_not_of_the_samples():
    def metric(value, samples):
        return {"total_deg": value, "heading_deg": value / 2, "inclination_deg": value / 4, "samples": samples}

    trials = {
        "01_undisturbed_slow_rotation_A": metric(1.0, 10),
        "23_undisturbed": metric(3.0, 1000),
        "24_disturbed_tapping_A.mat": metric(8.0, 10),
    }
    means = group_means(trials)
    assert means["undisturbed"] == {"total_deg": 2.0, "heading_deg": 1.0, "inclination_deg": 0.5, "trials": 2}
    assert means["disturbed"]["total_deg"] == 8.0
    assert means["all"] == {"total_deg": 4.0, "heading_deg": 2.0, "inclination_deg": 1.0, "trials": 3}
    assert np.isnan(group_means({})["all"]["total_deg"])


@pytest.mark.parametrize("name", ["", "00_x", "40_x", "1_x", "undisturbed", "123_x"])
def test_names_without_a_trial_number_are_refused(name):
    with pytest.raises(InputError, match="trial name"):
        trial_group(name)


def test_interpolated_reference_gives_the_same_metric():
    t = np.arange(0.0, 10.0, 0.01)
    q = quat_from_rotvec(np.outer(np.sin(t), [0.3, -0.5, 0.7]))
    truth = Truth(t, q, moving=(t > 2) & (t < 8))
    q_est = quat_multiply(quat_from_rotvec([0.01, 0.02, -0.03]), q)
    shifted = trial_metric(run_of(t[:-1] + 0.004, quat_multiply(quat_from_rotvec([0.01, 0.02, -0.03]),
                           quat_from_rotvec(np.outer(np.sin(t[:-1] + 0.004), [0.3, -0.5, 0.7])))), truth)  # fmt: skip
    assert shifted["total_deg"] == pytest.approx(trial_metric(run_of(t, q_est), truth)["total_deg"], rel=1e-3)


def trial(path):
    """Streams in the file's own axes, truth in NED and FRD."""
    from scipy.io import loadmat

    data = loadmat(path)
    q_nb = quat_normalize(quat_ned_frd_from_enu_flu(data["opt_quat"]))
    t = np.arange(len(q_nb)) / data["sampling_rate"].item()
    return data, Truth(t, q_nb, kind="optical", moving=data["movement"][:, 0] > 0)


@pytest.mark.skipif(not DATA, reason="needs the BROAD recordings: set ROBUSTNAV_DATA")
def test_file_names_say_the_group_their_number_gives():
    names = [path.name for path in sorted((Path(DATA) / "broad").glob("*.mat"))]
    assert len(names) == 10
    for name in names:
        assert trial_group(name) == name.split("_")[1]


@pytest.mark.skipif(not DATA, reason="needs the BROAD recordings: set ROBUSTNAV_DATA")
def test_a_peer_library_scores_its_known_figure():
    """VQF with defaults: mean total of 2.04 degrees over the ten trials, found with another implementation."""
    vqf = pytest.importorskip("vqf", reason="needs the peer library vqf")
    trials = {}
    for path in sorted((Path(DATA) / "broad").glob("*.mat")):
        data, truth = trial(path)
        sensors = [np.ascontiguousarray(data[name]) for name in ("imu_gyr", "imu_acc", "imu_mag")]
        q_enu = vqf.VQF(1 / data["sampling_rate"].item()).updateBatch(*sensors)["quat9D"]
        run = run_of(truth.t, quat_ned_frd_from_enu_flu(q_enu))
        trials[path.stem] = trial_metric(run, truth)
    means = group_means(trials)
    assert means["all"]["total_deg"] == pytest.approx(2.04, abs=0.005)
    assert (means["undisturbed"]["trials"], means["disturbed"]["trials"]) == (6, 4)
    assert evaluate(run, truth).values["moving_total_deg"] == trials[path.stem]["total_deg"]
