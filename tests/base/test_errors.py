"""Errors say thing, place, got, expected and what to do, and leave out what they were not told."""

import pytest

from robustnav.errors import EstimatorError, InputError, MissingExtra, RobustnavError


def test_a_full_message_has_a_line_for_each_part():
    error = InputError("stream 'gyro'", place="row 3", got="inf", expected="finite numbers", do="cut the recording")
    assert str(error).splitlines() == [
        "stream 'gyro', row 3",
        "  got       inf",
        "  expected  finite numbers",
        "  do        cut the recording",
    ]


@pytest.mark.parametrize("part", ["got", "expected", "do"])
def test_parts_that_were_not_given_leave_no_line(part):
    error = InputError("thing", **{part: "said"})
    assert str(error).splitlines() == ["thing", f"  {part:<9} said"]
    assert getattr(error, part) == "said"
    assert error.place == ""


def test_a_missing_extra_says_how_to_install_it():
    error = MissingExtra("matplotlib", "report")
    assert "matplotlib" in str(error)
    assert 'pip install "robustnav[report]"' in error.do


@pytest.mark.parametrize(("kind", "code"), [(InputError, 2), (EstimatorError, 3)])
def test_exit_codes_tell_bad_input_from_a_failing_estimator(kind, code):
    assert kind("x").exit_code == code
    assert issubclass(kind, RobustnavError)
    assert issubclass(kind, ValueError)


def test_a_missing_extra_is_bad_input():
    assert MissingExtra("a", "b").exit_code == 2
