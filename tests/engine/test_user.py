"""A user's own model: compiled once, cached, never loaded from strangers, and in NumPy without a compiler."""

import os
import stat
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from robustnav.engine import CompiledModel, NoCompiler, compile_model
from robustnav.engine.backends import functions_of
from robustnav.engine.user import find_compiler
from robustnav.errors import InputError
from robustnav.model import Equations, Model, Noise, NumericModel, Sensor, Vector


def decay(rate=2.0, name="decay"):
    return Model(
        name=name,
        state=(Vector("x", "1", 1),),
        inputs=(Vector("u", "1", 1),),
        noises=(Noise("w", "1", 0.1, 1),),
        sensors=(Sensor("y", "1", 0.1, 1),),
        parameters={"gain": 3.0},
        equations=lambda s: Equations({"x": s.u[0] * s.gain - rate * s.x[0] + s.w[0]}, {"y": s.x[0] ** 2}),
        start_sd={"x": 1.0},
    )


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.delenv("CC", raising=False)
    return tmp_path / "cache" / "robustnav" / "models"


@pytest.fixture
def compiler(tmp_path, monkeypatch, cache):
    """A compiler that writes down what it is asked."""
    log, script = tmp_path / "calls", tmp_path / "mycc"
    script.write_text(f'#!/bin/sh\necho "$@" >> {log}\nexec {find_compiler()[0]} "$@"\n')
    script.chmod(0o755)
    monkeypatch.setenv("CC", f"{script} -g0")
    return lambda: log.read_text().splitlines() if log.exists() else []


def libraries(cache):
    return sorted(cache.glob("*.so"))


def test_a_model_is_compiled_once(cache, compiler):
    one = compile_model(decay())
    asked = compiler()
    assert [line.split()[-1] for line in asked] == ["--version", "-lm"] and all("-g0" in line for line in asked)
    two = compile_model(decay())
    assert compiler()[2:] == ["-g0 --version"]
    assert len(libraries(cache)) == 1 and sorted(cache.iterdir()) == libraries(cache)
    x = np.array([0.7])
    assert one.measure(0, x) == two.measure(0, x) == pytest.approx([0.49])


def test_other_equations_are_another_library_and_other_numbers_are_not(cache, compiler):
    x, u = np.array([1.0]), np.array([0.5])
    one, other = compile_model(decay()), compile_model(decay(rate=5.0))
    assert len(libraries(cache)) == 2
    third = compile_model(decay().with_numbers({"w": 0.7}, {"y": 2.0}, {"gain": 4.0}))
    assert len(libraries(cache)) == 2
    steps = [m.propagate(x, u, 0.01)[0] for m in (one, other, third)]
    expected = [NumericModel(m.model).propagate(x, u, 0.01)[0] for m in (one, other, third)]
    assert steps == pytest.approx(expected, rel=1e-14) and len(set(steps)) == 3


def test_the_cache_is_the_users_alone(cache, compiler):
    compile_model(decay())
    assert stat.S_IMODE(cache.stat().st_mode) == 0o700
    assert stat.S_IMODE(libraries(cache)[0].stat().st_mode) == 0o700


def test_a_library_that_others_can_write_is_not_loaded(cache, compiler):
    compile_model(decay())
    libraries(cache)[0].chmod(0o720)
    with pytest.raises(InputError, match=r"decay-\w+\.so(.|\n)*remove it"):
        compile_model(decay())


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="no user numbers on this system")
def test_a_folder_of_somebody_else_is_not_used(cache, compiler, monkeypatch):
    own = os.getuid()
    monkeypatch.setattr(os, "getuid", lambda: own + 1)
    with pytest.raises(InputError, match="other users"):
        compile_model(decay())


def test_any_umask_will_do(cache, compiler):
    before = os.umask(0o002)
    try:
        compile_model(decay())
        compile_model(decay())
    finally:
        os.umask(before)


def test_a_half_written_library_is_never_seen(cache, compiler, tmp_path, monkeypatch):
    """The library appears by a rename; a compiler that dies leaves nothing behind."""
    script = tmp_path / "dies"
    script.write_text('#!/bin/sh\n[ "$1" = --version ] && exit 0\nfor last; do :; done\necho part > model.so\nexit 3\n')
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="exit code 3"):
        compile_model(decay())
    assert list(cache.iterdir()) == []


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("false", ["refused model 'decay'", "/false", "exit code 1", 'backend="numpy"']),
        ("/no/such/compiler", ["C compiler", "CC", "/no/such/compiler"]),
        ("nosuchcc -O1", ["C compiler", "CC", "nosuchcc"]),
    ],
)
def test_a_compiler_that_fails_is_named(cache, monkeypatch, command, words):
    monkeypatch.setenv("CC", command)
    with pytest.raises(InputError) as caught:
        compile_model(decay())
    assert not isinstance(caught.value, NoCompiler)
    assert all(word in str(caught.value) for word in words), str(caught.value)
    with pytest.raises(InputError):
        functions_of(decay(), "auto")  # no silent NumPy: a compiler was asked for


def test_a_compiler_that_is_no_program_is_named(cache, monkeypatch, tmp_path):
    script = tmp_path / "text"
    script.write_bytes(b"\x00\x01 not a program")
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    with pytest.raises(InputError, match="text"):
        compile_model(decay())


def test_blank_cc_is_no_cc(cache, monkeypatch):
    monkeypatch.setenv("CC", "  ")
    assert Path(find_compiler()[0]).exists()


@pytest.fixture
def bare(cache, monkeypatch, tmp_path):
    """A machine without any compiler."""
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setitem(sys.modules, "ziglang", None)


def test_without_a_compiler_numpy_runs(bare):
    assert isinstance(functions_of(decay(), "auto"), NumericModel)
    for call in (lambda: compile_model(decay()), lambda: functions_of(decay(), "c")):
        with pytest.raises(NoCompiler, match=r"pip install ziglang(.|\n)*numpy"):
            call()


def test_built_in_models_need_no_compiler(bare, plain):
    assert isinstance(functions_of(plain().model), CompiledModel)


def test_the_ziglang_package_stands_in(bare, monkeypatch):
    monkeypatch.setitem(sys.modules, "ziglang", type(sys)("ziglang"))
    assert find_compiler() == [sys.executable, "-m", "ziglang", "cc"]


def test_backends_are_named(cache, plain):
    assert [functions_of(plain().model, b).real for b in ("auto", "c", "float")] == ["double", "double", "float"]
    with pytest.raises(InputError, match="auto, c, float, numpy"):
        functions_of(decay(), "cuda")
    with pytest.raises(InputError, match="'decay' is not built in"):
        functions_of(decay(), "float")


def test_a_users_model_is_never_taken_for_a_built_in_one(plain):
    """The same name and sizes, other equations."""
    with pytest.raises(InputError, match="'attitude' is not built in"):
        CompiledModel(replace(plain().model, shipped=None))


def test_a_built_in_model_must_have_its_sizes(plain):
    model = plain().model
    with pytest.raises(InputError, match="sizes"):
        CompiledModel(replace(model, sensors=model.sensors[:1]))
    with pytest.raises(InputError, match="not built in"):
        CompiledModel(replace(model, name="unknown"))
