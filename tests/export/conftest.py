"""Exports written once, and their C loaded into Python."""

import ctypes
import shutil
import subprocess
from types import SimpleNamespace

import numpy as np
import pytest

from robustnav.engine.user import find_compiler
from robustnav.export.build import build
from robustnav.export.tree import cmake, readme, sources, write
from robustnav.filter.weighting import Gate, Huber, StudentT
from robustnav.models import uwb
from robustnav.models.inclination import inclination
from robustnav.run import EKF, H2
from robustnav.run.inclination import LevelH2
from robustnav.studies.attitude_setting import lineup, noise, quaternion_model

FLAGS = """std=c99 pedantic Wall Wextra Wconversion Wsign-conversion Wdouble-promotion Wfloat-equal Wshadow Wcast-qual
Wstrict-prototypes Wmissing-prototypes Wundef Wvla Werror"""
WARNINGS = [f"-{flag}" for flag in FLAGS.split()]
ROBUST = {"range": Gate(9.0), "tdoa": StudentT(4.0), "position": Huber(2.0)}
MAKE = {
    "nine": lambda: H2(quaternion_model(noise(100)), 100.0, start_sd="steady"),
    "nine_staged": lambda: H2(quaternion_model(noise(100)), 100.0),
    "nine_cold": lambda: lineup("cold", 100.0).estimators["h2"],
    "level": lambda: LevelH2(inclination(noise(100)), 100.0, steady=True),
    "level_staged": lambda: LevelH2(inclination(noise(100)), 100.0),
    "mekf": lambda: EKF(quaternion_model(noise(100))),
    "ranges": lambda: EKF(uwb(range_sd=0.1, acceleration_density=1.0, time_offset=0.02)),
    "robust": lambda: EKF(uwb(range_sd=0.1, acceleration_density=1.0), ROBUST),
}
REALS = [(name, real) for name in MAKE for real in ("float", "double")] + [("nine", "int32")]


@pytest.fixture(scope="session", autouse=True)
def private_cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.getbasetemp() / "cache"))
        yield


@pytest.fixture(scope="session")
def compiler():
    return find_compiler()


@pytest.fixture(scope="session")
def exported(tmp_path_factory):
    """Return by name and number type: estimator, unit, folder."""
    made = {}

    def get(name, real):
        if (name, real) not in made:
            estimator = MAKE[name]()
            unit, replay = build(estimator, f"rn_{name}", real, 100.0)
            files = sources(unit, replay) | {"CMakeLists.txt": cmake(unit), "README.md": readme(unit, ())}
            folder = write(tmp_path_factory.mktemp(f"{name}_{real}"), files)
            made[name, real] = SimpleNamespace(estimator=estimator, unit=unit, folder=folder)
        return made[name, real]

    return get


@pytest.fixture(scope="session")
def replayed(exported, compiler):
    """Return what the host's replay program says: worst share of the bound, refused rows, exit code."""

    def get(name, real):
        one = exported(name, real)
        program = one.folder / "replay"
        command = [*compiler, *WARNINGS, "-O2", "-ffp-contract=off", f'-DRN_REPLAY="{one.unit.name}_replay.h"']
        files = ["replay.c", f"{one.unit.name}.c"]
        subprocess.run([*command, *files, "-lm", "-o", str(program)], cwd=one.folder, check=True)
        done = subprocess.run([str(program)], capture_output=True, text=True, check=False)
        words = dict(zip(done.stdout.split()[::2], done.stdout.split()[1::2], strict=True))
        return SimpleNamespace(code=done.returncode, worst=float(words["worst"]), refused=int(words["refused"]))

    return get


class Loaded:
    """An exported nine-axis filter in float, called from Python."""

    def __init__(self, library, name):
        self._c = ctypes.CDLL(str(library))
        self._name = name
        self.state = (ctypes.c_float * 16)()

    def call(self, function, *arguments):
        """Call a function of the filter with numbers and arrays."""
        own = [ctypes.c_float(a) if isinstance(a, float) else _array(a) for a in arguments]
        return getattr(self._c, f"{self._name}_{function}")(self.state, *own)


def _array(values):
    return (ctypes.c_float * len(values))(*np.asarray(values, float))


@pytest.fixture(scope="session")
def loaded(exported, compiler):
    """Return a filter's C as a loaded library."""
    if shutil.which(compiler[0]) is None:
        pytest.skip("no C compiler")

    def get(name):
        one = exported(name, "float")
        library = one.folder / "filter.so"
        if not library.exists():
            command = [*compiler, "-std=c99", "-O2", "-shared", "-fPIC", f"{one.unit.name}.c", "-o", str(library)]
            subprocess.run(command, cwd=one.folder, check=True)
        return Loaded(library, one.unit.name)

    return get
