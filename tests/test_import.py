"""Importing the package brings in what every program needs; what only some need comes when they name it."""

import pkgutil
import subprocess
import sys

import pytest

import robustnav as rn

HEAVY = {
    "casadi", "clarabel", "cvxpy", "matplotlib", "pandas", "plotly", "pydantic", "pygeomag", "pyulog", "scipy",
    "symengine", "sympy",
}  # fmt: skip
HEAVY_PARTS = (HEAVY - {"scipy"}) | {"scipy.optimize", "scipy.signal", "scipy.stats"}
# An estimator run on data in memory and its errors; gains, recordings, pages and studies are for those who want them.
ROOMS = {"engine", "errors", "evaluate", "export", "filter", "frames", "model", "models", "ranging", "records"}
ROOMS |= {"report", "run", "streams", "units"}
MODULES = 70  # each takes a millisecond or two; 120 were a quarter of a second on a slow machine


EVERYTHING = ", ".join(f"robustnav.{m.name}" for m in pkgutil.iter_modules(rn.__path__) if m.name != "__main__")


def loaded_by(code: str) -> set[str]:
    out = subprocess.run(
        [sys.executable, "-c", f"import sys; {code}; print(*sys.modules)"], capture_output=True, text=True, check=True
    )
    return set(out.stdout.split())


def test_import_loads_only_what_every_program_needs():
    loaded = loaded_by("import robustnav")
    own = {name for name in loaded if name.startswith("robustnav.")}
    assert {name.split(".")[1] for name in own} <= ROOMS
    assert len(own) <= MODULES
    assert not loaded & HEAVY


def test_no_part_loads_a_heavy_library():
    assert EVERYTHING.count(",") > 10
    assert not loaded_by(f"import {EVERYTHING}") & HEAVY_PARTS


@pytest.mark.parametrize("name", rn.__all__)
def test_every_public_name_is_found_and_listed(name):
    assert name in dir(rn)
    assert getattr(rn, name) is getattr(rn, name)


def test_a_function_named_like_its_subpackage_stays_a_function_when_all_is_loaded():
    check = "; ".join(f"assert callable(robustnav.{name})" for name in ("evaluate", "export", "report", "run"))
    loaded_by(f"import {EVERYTHING}; {check}")


def test_an_unknown_name_is_refused_by_name():
    with pytest.raises(AttributeError, match="'robustnav' has no attribute 'kalman'"):
        rn.kalman  # noqa: B018
