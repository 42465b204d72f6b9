import numpy as np
import pytest

from robustnav.benchmark.timing import time_rounds
from robustnav.benchmark.works import alignment_step
from robustnav.benchmark.works.alignment_peer import AlignmentEquations, AlignmentUkf
from robustnav.benchmark.works.alignment_step import PERIOD, aligned, published
from robustnav.engine.backends import functions_of
from robustnav.errors import EstimatorError
from robustnav.run import stream
from robustnav.studies.alignment_setting import SPREAD


@pytest.fixture(scope="module")
def one():
    return aligned(60)


def test_the_hand_written_equations_are_those_of_the_compiled_model(one):
    estimator, start = published("ukf", one.data)
    ours, theirs = functions_of(estimator.model), AlignmentEquations(estimator.model, PERIOD)
    random = np.random.default_rng(6)
    for u in one.u[:10]:
        x = start.x + random.normal(size=13) * np.repeat([3.0, 0.3, 0.1, 0.1], [3, 4, 3, 3])  # no unit quaternion
        np.testing.assert_allclose(theirs.propagate(x, u), ours.propagate(x, u, PERIOD), rtol=1e-13, atol=1e-15)
        np.testing.assert_allclose(theirs.noise(x), ours.transition(x, u, PERIOD)[1], rtol=1e-12, atol=1e-24)


def test_filterpy_estimates_what_our_filter_does(one):
    kalman = pytest.importorskip("filterpy.kalman", reason="needs the peer library filterpy")
    estimator, start = published("ukf", one.data)
    theirs = AlignmentUkf(kalman, AlignmentEquations(estimator.model, PERIOD), SPREAD)
    theirs.restart(start.x, start.P)
    mine = stream(estimator, start)
    for u, z in zip(one.u, one.z, strict=True):
        theirs.step(u, z)
        mine.update(u, z, PERIOD)
        np.testing.assert_allclose(theirs.filter.x, mine.state, rtol=0, atol=1e-11)
    np.testing.assert_allclose(theirs.filter.P, mine.covariance, rtol=0, atol=1e-11)


def test_whole_arrays_are_steps_from_the_first_increment_on(one):
    """The filter's time is set to the start's, or its first increment would only tell it the time."""
    estimator, start = published("ukf", one.data)
    mine = stream(estimator, start)
    for u, z in zip(one.u, one.z, strict=True):
        mine.update(u, z, PERIOD)
    contender = alignment_step.STEP.entries["ukf"].make(60)
    np.testing.assert_allclose(contender.work().x[-1], mine.state, rtol=0, atol=1e-11)


def test_a_peer_that_estimates_something_else_is_not_timed(monkeypatch):
    pytest.importorskip("filterpy.kalman", reason="needs the peer library filterpy")
    exact = AlignmentEquations.noise
    monkeypatch.setattr(AlignmentEquations, "noise", lambda self, x: 100 * exact(self, x))
    with pytest.raises(EstimatorError, match="'filterpy-ukf' does not estimate"):
        time_rounds({"filterpy-ukf": alignment_step.STEP.entries["filterpy-ukf"].make(4000)}, 0.001, 1, lambda: None)


@pytest.mark.parametrize("work", [alignment_step.STEP, alignment_step.ALIGN], ids=lambda work: work.name)
def test_every_row_of_ours_has_levelled_the_unit_after_a_minute(work):
    for name in work.entries.keys() - {"filterpy-ukf"}:
        contender = work.entries[name].make(600)
        assert contender.steps == 600 and contender.fault(contender.work()) < 1.0, name


def test_the_start_is_not_right():
    one = aligned(600)
    assert one.fault(one.data.q_nb_start) > 5.0
