"""The attitude study on few seeds: what it must show, and the shape of what it writes."""

import json

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.frames import euler_from_quat, matrix_from_quat, quat_from_rotvec, quat_multiply
from robustnav.studies.attitude import HELD, attitude_study, steps_of
from robustnav.studies.attitude_report import write_study
from robustnav.studies.attitude_runs import bound_sd
from robustnav.studies.attitude_setting import CASES, PROTOCOLS, euler_from_rotation, lineup, quaternion_model, start_at
from robustnav.studies.attitude_setting import noise as study_noise

SEEDS = 24


@pytest.fixture(scope="module")
def counted():
    calls = []
    return attitude_study(SEEDS, seed=3, progress=lambda: calls.append(1)), len(calls)


@pytest.fixture(scope="module")
def study(counted):
    return counted[0]


def test_progress_is_called_as_often_as_announced(counted):
    assert counted[1] == steps_of(SEEDS)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("name", ["h2", "mekf"])
def test_with_a_common_start_the_quaternion_filters_reach_the_bound(study, case, name):
    """24 runs leave about 15 % of scatter on yaw, whose error lives longer than the run."""
    result = study.cases[case]["warm"]
    assert (result.scores[name].rms_deg < 1.25 * result.bound_deg).all()
    assert (result.scores[name].rms_deg > 0.75 * result.bound_deg).all()


@pytest.mark.parametrize("case", CASES)
def test_the_constant_gain_is_as_good_as_the_mekf_once_started(study, case):
    scores = study.cases[case]["warm"].scores
    np.testing.assert_allclose(scores["h2"].rms_deg, scores["mekf"].rms_deg, rtol=0.02)


def test_the_start_up_schedule_converges_where_the_bare_gain_does_not(study):
    for case, most in (("I", 1.08), ("II", 1.4)):
        scores = study.cases[case]["cold"].scores
        assert (scores["h2"].rms_deg < most * scores["mekf"].rms_deg).all()
        assert (scores["h2-euler"].rms_deg > 5 * scores["mekf"].rms_deg).all()


@pytest.mark.parametrize("case", CASES)
def test_the_published_order_appears_only_when_the_ekf_alone_doubts_its_start(study, case):
    published, warm = study.cases[case]["published"].scores, study.cases[case]["warm"].scores
    assert published["ekf-euler"].rms_deg[2] > 1.5 * published["h2-euler"].rms_deg[2]
    assert warm["ekf-euler"].rms_deg[2] < 1.05 * warm["h2-euler"].rms_deg[2]


def test_manoeuvres_separate_the_forms(study):
    for row in study.turns.values():
        assert row["h2"] < 0.5
        assert row["mekf"] < 0.5
    assert study.turns[HELD]["h2-euler"] > 20


def test_the_mekf_is_consistent(study):
    for tests in study.consistency.values():
        for test, values in tests.values():
            assert values.shape[0] == SEEDS
            assert test.low < test.mean < test.high


def test_results_have_the_documented_shape(study, tmp_path):
    page = write_study(study, tmp_path / "out", "robustnav demo attitude")
    found = json.loads((tmp_path / "out" / "results.json").read_text())
    assert found["study"] == "attitude"
    assert found["seeds"] == SEEDS
    for case in ("I", "II"):
        assert found["cases"][case]["published"]["EKF"]["rms_deg"]
        for protocol in PROTOCOLS:
            rows = found["cases"][case]["protocols"][protocol]
            for name in ("h2-euler", "ekf-euler", "h2", "mekf"):
                assert len(rows[name]["rms_deg"]) == len(rows[name]["min_deg"]) == len(rows[name]["max_deg"]) == 3
                assert rows[name]["ns_per_step"] > 0
            assert ("bound" in rows) == (protocol != "published")
    html = page.read_text()
    assert "src=" not in html
    assert "<script" not in html
    assert html.count("<figure>") >= 10


def test_too_few_seeds_and_a_file_as_folder_are_refused(study, tmp_path):
    with pytest.raises(InputError, match="seeds"):
        attitude_study(3)
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="folder"):
        write_study(study, tmp_path / "file", "")


def test_euler_jacobian_agrees_with_differences():
    rng, step = np.random.default_rng(0), 1e-6
    for euler in rng.uniform(-1.2, 1.2, (5, 3)):
        from robustnav.frames import quat_from_euler

        q = quat_from_euler(euler)
        moved = [euler_from_quat(quat_multiply(quat_from_rotvec(step * e), q)) - euler for e in np.eye(3)]
        np.testing.assert_allclose(euler_from_rotation(euler), np.array(moved).T / step, atol=1e-5)


def test_a_start_is_off_by_exactly_the_error_asked_for():
    model, rng = quaternion_model(study_noise(100.0)), np.random.default_rng(1)
    q, bias, error = quat_from_rotvec(rng.normal(size=3)), rng.normal(size=3), 0.1 * rng.normal(size=6)
    start = start_at(model, q, bias, np.eye(6), error)
    np.testing.assert_allclose(quat_multiply(quat_from_rotvec(error[:3]), start.x[:4]), q, atol=1e-12)
    np.testing.assert_allclose(matrix_from_quat(q) @ (bias - start.x[4:]), error[3:], atol=1e-12)


def test_the_bound_starts_below_and_ends_near_the_steady_state():
    line = lineup("warm", 100.0)
    sd = bound_sd(CASES["I"], line.drawn)
    steady = np.sqrt(np.diag(line.drawn)[:3])
    np.testing.assert_allclose(sd[0], steady, rtol=0.02)
    np.testing.assert_allclose(sd[-1], steady, rtol=0.1)
