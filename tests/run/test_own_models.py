"""The examples of models of one's own: the same figures compiled and in NumPy, and honest deviations."""

import importlib.util
import re
from pathlib import Path

import numpy as np
import pytest

from robustnav.model import check_model

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="module", params=["pendulum", "range_bearing"])
def example(request):
    spec = importlib.util.spec_from_file_location(request.param, EXAMPLES / f"{request.param}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def figures(text):
    return [[float(n) for n in re.findall(r"\d+\.\d*", part)] for part in re.findall(r"\[(.*?)\]", text)]


def test_compiled_and_numpy_print_the_same_figures(example, capsys):
    texts = {}
    for backend in ("c", "numpy"):
        example.main(backend)
        texts[backend] = capsys.readouterr().out
        assert texts[backend].count(f" in {backend}: ") == 2
    assert texts["c"].replace(" in c: ", " in numpy: ") == texts["numpy"]
    ekf_error, ekf_sd, ukf_error, ukf_sd = (np.array(f) for f in figures(texts["c"]))
    assert (ekf_error < 2 * ekf_sd).all() and (ekf_error > ekf_sd / 4).all()
    np.testing.assert_allclose(ekf_error, ukf_error, rtol=0.05)
    np.testing.assert_allclose(ekf_sd, ukf_sd, rtol=0.05)


def test_the_examples_pass_their_check(example):
    found = check_model(example.model, samples=3)
    damping = ("no sensor sees damping at the nominal point",)  # a pendulum at rest does not show it
    assert found.findings == (damping if example.model.name == "pendulum" else ())


def test_the_model_in_the_documentation_is_whole():
    text = (EXAMPLES.parent / "docs" / "models.md").read_text()
    (code,) = re.findall(r"```python\n(.*?)```", text, re.S)
    names = {}
    exec(compile(code, "docs/models.md", "exec"), names)
    assert check_model(names["model"], samples=2).passed
