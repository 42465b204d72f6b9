import numpy as np
import pytest

from robustnav.benchmark.nine_axes import nine_axes
from robustnav.errors import InputError
from robustnav.records import Log, Stream


def log_of(**streams):
    units = {"gyro": "rad/s", "accel": "m/s^2", "mag": "T"}
    made = {name: Stream(name, np.array(t, float), np.outer(v, [1.0, 2.0, 3.0]), units[name])
            for name, (t, v) in streams.items()}  # fmt: skip
    return Log(made, "made up")


def test_every_sample_gets_the_latest_reading_that_was_there():
    axes = nine_axes(
        log_of(
            gyro=([0, 1, 2, 3, 4], [1, 2, 3, 4, 5]), accel=([0, 1, 2, 3, 4], range(5)), mag=([0.5, 2, 3.9], [7, 8, 9])
        )
    )
    assert axes.mag[:, 0].tolist() == [7, 7, 8, 8, 9]  # the first holds backwards, nothing comes from the future
    assert axes.accel[:, 1].tolist() == [0, 2, 4, 6, 8]
    assert axes.rate_hz == 1.0
    assert all(a.flags.c_contiguous and a.shape == (5, 3) for a in (axes.gyro, axes.accel, axes.mag))


def test_a_missing_reading_holds_the_one_before_it():
    axes = nine_axes(
        log_of(gyro=([0, 1, 2], [1, np.nan, 3]), accel=([0, 1, 2], [np.nan, 5, np.nan]), mag=([0, 1, 2], [1, 1, 1]))
    )
    assert axes.gyro[:, 0].tolist() == [1, 1, 3]
    assert axes.accel[:, 0].tolist() == [5, 5, 5]


@pytest.mark.parametrize(
    ("streams", "words"),
    [
        ({"accel": ([0], [1]), "mag": ([0], [1])}, "no stream 'gyro'"),
        ({"gyro": ([0, 1], [1, 1]), "accel": ([0], [1])}, "no stream 'mag'"),
        ({"gyro": ([0], [1]), "accel": ([0], [1]), "mag": ([0], [1])}, "no gyro rate"),
        ({"gyro": ([0, 1], [1, 1]), "accel": ([0], [np.nan]), "mag": ([0], [1])}, "stream 'accel'"),
        ({"gyro": ([0, 1], [1, 1]), "accel": ([], []), "mag": ([0], [1])}, "stream 'accel'"),
    ],
)
def test_unusable_logs_are_refused_by_name(streams, words):
    with pytest.raises(InputError, match=words):
        nine_axes(log_of(**streams))


def test_a_stream_of_another_width_is_refused():
    log = log_of(gyro=([0, 1], [1, 1]), accel=([0], [1]), mag=([0], [1]))
    wide = Stream("mag", np.zeros(1), np.zeros((1, 2)), "T")
    with pytest.raises(InputError, match="stream 'mag'"):
        nine_axes(Log({**log.streams, "mag": wide}, "made up"))
