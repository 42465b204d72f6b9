"""Held-out errors against what leaving out means in closed form."""

from dataclasses import dataclass

import numpy as np
import pytest

from robustnav.calibrate import Pairs, fit_line, held_out
from robustnav.errors import InputError


@dataclass(frozen=True)
class Shift:
    bias: float

    def distance(self, measured):
        return np.asarray(measured) - self.bias

    def distance_variance(self, measured):
        return np.zeros_like(measured)


def shift(pairs):
    return Shift(float(np.mean(pairs.measured - pairs.distance_true)))


def test_leaving_one_of_n_out_stretches_its_error_by_n_over_n_minus_one():
    rng = np.random.default_rng(1)
    d = rng.uniform(1, 50, 25)
    bias = rng.standard_normal(25)
    result = held_out(Pairs(d, d + bias, file=np.arange(25)[::-1] * 3), shift)
    np.testing.assert_allclose(result.error, (bias - bias.mean()) * 25 / 24, atol=1e-12)
    np.testing.assert_array_equal(result.files, np.arange(25) * 3)
    np.testing.assert_allclose(result.file_rms[::-1], np.abs(result.error), atol=1e-12)
    np.testing.assert_allclose(result.rms, np.sqrt(np.mean(result.error**2)))


def test_no_fold_sees_the_files_it_is_judged_on():
    rng = np.random.default_rng(2)
    file = np.repeat(np.arange(12), 5)
    pairs = Pairs(rng.uniform(1, 50, 60), rng.uniform(1, 50, 60), file=file)
    seen = []
    held_out(pairs, lambda part: seen.append(set(part.file.tolist())) or shift(part), folds=4)
    assert [len(one) for one in seen] == [9] * 4
    assert all(any(f not in one for one in seen) for f in range(12))


@pytest.mark.parametrize("file", [None, np.zeros(9, int)])
def test_one_file_cannot_be_left_out(file):
    d = np.arange(1.0, 10.0)
    with pytest.raises(InputError, match="held-out"):
        held_out(Pairs(d, d, file=file), fit_line)


def test_one_fold_leaves_nothing_to_fit():
    d = np.arange(1.0, 10.0)
    with pytest.raises(InputError, match="1 folds"):
        held_out(Pairs(d, d, file=np.arange(9)), fit_line, folds=1)
