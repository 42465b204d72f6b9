"""Importing the package is quick, and brings in no library that only some users need."""

import pkgutil
import subprocess
import sys

import robustnav

HEAVY = {
    "casadi", "clarabel", "cvxpy", "matplotlib", "pandas", "plotly", "pydantic", "pygeomag", "pyulog",
    "scipy.optimize", "scipy.signal", "scipy.stats", "symengine", "sympy",
}  # fmt: skip
SECONDS = 0.25  # processor time beyond what NumPy takes
TIMED = "import time; start = time.process_time(); import {}; print(time.process_time() - start)"


def python(code: str) -> str:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout


def seconds(module: str) -> float:
    """Least processor time of five fresh imports: a busy machine cannot make it longer."""
    return min(float(python(TIMED.format(module))) for _ in range(5))


def test_import_is_quick():
    alone, whole = seconds("numpy"), seconds("robustnav")
    sys.stdout.write(f"import: NumPy {alone:.3f} s, robustnav {whole - alone:.3f} s more\n")
    assert whole - alone < SECONDS


def test_import_is_light():
    names = [f"robustnav.{m.name}" for m in pkgutil.iter_modules(robustnav.__path__) if m.name != "__main__"]
    assert len(names) > 10
    loaded = set(python(f"import sys, {', '.join(names)}; print(*sys.modules)").split())
    assert not loaded & HEAVY
