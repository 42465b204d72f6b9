import json
import math
from pathlib import PurePosixPath

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robustnav.errors import InputError
from robustnav.evaluate.tables import heading, json_rows, plain, score_rows, text_table
from robustnav.records import Score

ROWS = [
    {"estimator": "H2", "total_deg": 1.8125, "heading_deg": np.float64(0.7), "samples": 48305},
    {"estimator": "MEKF, online", "total_deg": 12.0, "heading_deg": float("nan"), "samples": 5},
    {"estimator": "PCRB", "total_deg": None, "heading_deg": None, "samples": None},
]


def test_numbers_stand_under_each_other():
    assert text_table(ROWS).splitlines() == [
        "Estimator     Total, deg  Heading, deg  Samples",
        "------------  ----------  ------------  -------",
        "H2                  1.81         0.700    48305",
        "MEKF, online       12.00           NaN        5",
        "PCRB                   –             –        –",
    ]
    assert text_table([]) == ""


def test_small_and_large_columns_keep_their_digits():
    assert "2.91e-05" in text_table([{"residual": 2.912e-5}, {"residual": 1e-9}])
    assert "0.0348" in text_table([{"rms": 0.03481}, {"rms": 12.3}])
    assert "inf" in text_table([{"a": math.inf}, {"a": 1.0}])
    assert "yes" in text_table([{"used": True}])


def test_headings_name_the_unit_once():
    assert heading("gyro_bias_dps") == "Gyro bias, deg/s"
    assert heading("samples") == "Samples" and heading("s") == "S" and heading("mean_nis") == "Mean NIS"


def test_json_has_null_for_nan_and_is_strict():
    rows = json_rows([*ROWS, {"a": np.array([1.0, np.nan]), "b": np.bool_(True), "c": -math.inf, "d": np.int64(3)}])
    json.dumps(rows, allow_nan=False)
    assert rows[1]["heading_deg"] is None
    assert rows[3] == {"a": [1.0, None], "b": True, "c": "-inf", "d": 3}
    assert plain({"file": PurePosixPath("a/b"), 1: (1, None)}) == {"file": "a/b", "1": [1, None]}
    with pytest.raises(InputError, match=r"got +object"):
        plain([object()])


leaf = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5)


@given(st.lists(st.dictionaries(st.text(max_size=6), leaf | st.lists(leaf, max_size=3), max_size=4), max_size=4))
def test_any_rows_make_a_table_and_strict_json(rows):
    json.dumps(json_rows(rows), allow_nan=False)
    assert isinstance(text_table(rows), str)


def test_score_rows_take_the_asked_values():
    scores = [Score("H2", "optical", {"total_deg": 1.0}, 7), Score("EKF", "optical", {}, 3)]
    assert score_rows(scores, ["total_deg"]) == [
        {"estimator": "H2", "total_deg": 1.0, "samples": 7},
        {"estimator": "EKF", "total_deg": None, "samples": 3},
    ]
