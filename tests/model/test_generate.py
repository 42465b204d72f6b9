"""The committed C is the models' C, the same text in every run, and computes what NumPy computes."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from robustnav.engine import CompiledModel, compile_model
from robustnav.errors import InputError
from robustnav.model import Equations, Model, Sensor, Vector
from robustnav.model.codegen import model_header, packed
from robustnav.model.derive import Derivation
from robustnav.model.pattern import gain_pattern

GENERATED = Path(__file__).parents[2] / "csrc" / "generated"


@pytest.mark.parametrize("seed", ["1", "77"])
def test_committed_files_are_what_the_models_give(seed):
    """Two hash seeds: a set or a dictionary of hashes in the way would change the order of the text."""
    command = [sys.executable, "-m", "robustnav.model.generate", "--check"]
    done = subprocess.run(
        command, env={**os.environ, "PYTHONHASHSEED": seed}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_no_file_is_left_over():
    from robustnav.model.generate import generated_files

    assert {p.name for p in GENERATED.glob("*")} == set(generated_files())


def test_generated_text_depends_on_the_model_alone(models):
    first = model_header(models["inertial_n"])
    model_header(models["attitude"])
    assert model_header(models["inertial_n"]) == first


def test_packed_numbers_the_upper_triangle_by_rows():
    rows, columns = np.triu_indices(5)
    assert [packed(i, j, 5) for i, j in zip(rows, columns, strict=True)] == list(range(15))
    assert packed(3, 1, 5) == packed(1, 3, 5)


def agree(model, numeric, compiled, states, tolerance):
    rng = np.random.default_rng(5)
    for x, u in states(model, 8):
        e, y = 0.3 * rng.normal(size=model.error_size), states(model, 1)[-1][0]
        pairs = [
            (
                f"{what}({', '.join(str(np.shape(a)) for a in arguments)})",
                getattr(compiled, what)(*arguments),
                getattr(numeric, what)(*arguments),
            )
            for what, arguments in [
                ("propagate", (x, u, 0.03)),
                ("inject", (x, e)),
                ("inject_turned", (x, e)),
                ("difference", (y, x)),
                *[("measure", (j, x)) for j in range(len(model.sensors))],
                *[("jacobian", (j, x)) for j in range(len(model.sensors))],
                *[("residual", (j, x, rng.normal(size=s.size))) for j, s in enumerate(model.sensors)],
            ]
        ]
        pairs += zip("FQ", compiled.transition(x, u, 0.03), numeric.transition(x, u, 0.03), strict=True)
        for name, one, other in pairs:
            scale = max(1.0, np.abs(other).max(initial=0.0)) if name != "Q" else np.abs(other).max()
            np.testing.assert_allclose(one, other, rtol=0, atol=tolerance * scale, err_msg=name)


def test_c_is_numpy(model, numeric, states):
    agree(model, numeric, compile_model(model), states, 2e-14 if "inertial" in model.name else 5e-14)


@pytest.mark.parametrize("name", ["attitude", "attitude_euler"])
def test_c_in_float_is_numpy(models, numerics, states, name):
    agree(models[name], numerics[name], CompiledModel(models[name], real="float"), states, 2e-5)


@pytest.mark.parametrize("what", ["inject", "propagate"])
def test_in_place_is_out_of_place(models, what):
    """The kernel moves x in place; a copy kept beside it must give the same bits."""
    compiled = compile_model(models["attitude"])
    x, u = np.array([0.5, 0.5, -0.5, 0.5, 0.01, 0.02, 0.03]), np.array([0.3, -0.2, 0.9])
    arguments = (x, np.r_[u, u]) if what == "inject" else (x, u, 0.01)
    expected = getattr(compiled, what)(*arguments)
    out = x.copy()
    inputs = (out, np.r_[u, u]) if what == "inject" else (out, u, compiled.parameters)
    compiled.handle.call(2 if what == "inject" else 0, -1, inputs, 0.01, (out,))
    np.testing.assert_array_equal(out, expected)


def test_the_gain_of_attitude_has_fourteen_entries(models):
    """Roll and pitch errors from the accelerometer and the field, heading from the field's east part."""
    derivation = Derivation(models["attitude"])
    H = [
        [row for i, row in enumerate(_rows(derivation, s.name)) if i in derivation.rows(s.name)]
        for s in derivation.model.sensors
    ]
    pattern = gain_pattern(derivation, H)
    assert pattern.shape == (6, 5) and pattern.sum() == 14
    compiled = compile_model(models["attitude"])
    K, r = np.random.default_rng(0).normal(size=(6, 5)), np.arange(1.0, 6.0)
    np.testing.assert_allclose(compiled.gain(K, r), np.where(pattern, K, 0) @ r, rtol=1e-14)


def _rows(derivation, sensor):
    from robustnav.model.derive import skew

    return [[*row, 0, 0, 0] for row in skew(derivation.directions[sensor])]


def test_a_model_without_inputs_parameters_or_noise():
    model = Model(
        name="coasting",
        state=(Vector("x", "m", 1), Vector("v", "m/s", 1)),
        inputs=(),
        noises=(),
        sensors=(Sensor("seen", "m", 1.0, 2),),
        equations=lambda s: Equations({"x": s.v, "v": (0,)}, {"seen": (s.x[0], 3)}),
    )
    compiled = compile_model(model)
    np.testing.assert_allclose(compiled.propagate(np.array([1.0, 2.0]), np.zeros(0), 0.5), [2.0, 2.0])
    assert compiled.rows == (1,)  # the second number says nothing of the state


@pytest.mark.parametrize("changes", [{"inputs": 33}, {"sensors": 9}, {"rows": 9}])
def test_a_model_beyond_the_kernel_is_refused_by_name(changes):
    numbers = {"inputs": 1, "sensors": 1, "rows": 1, **changes}
    sensors = tuple(Sensor(f"y{j}", "1", 1.0, numbers["rows"]) for j in range(numbers["sensors"]))
    model = Model(
        name="wide",
        state=(Vector("x", "1", 1),),
        inputs=(Vector("u", "1", numbers["inputs"]),),
        noises=(),
        sensors=sensors,
        equations=lambda s: Equations({"x": 0 * s.x}, {one.name: [s.x[0]] * one.size for one in sensors}),
    )
    with pytest.raises(InputError, match=r"'wide'(.|\n)*sizes beyond(.|\n)*numpy"):
        compile_model(model)
