"""Prove a wheel: its content, and what it does where it is installed and the checkout is not.

check_wheel.py content FILE.whl | built-in | own-model
"""

import subprocess
import sys
import zipfile
from pathlib import Path


def content(wheel: str) -> None:
    """Every file of the package and of the C kernel that is in git must be in the wheel, and nothing of Python's."""
    listed = subprocess.run(["git", "ls-files", "src", "csrc"], capture_output=True, text=True, check=True).stdout
    wanted = set()
    for name in listed.split():
        if name.startswith("src/"):
            wanted.add(name.removeprefix("src/"))
        elif not name.startswith("csrc/python/"):
            wanted.add(name.replace("csrc/", "robustnav/engine/csrc/", 1))
    names = zipfile.ZipFile(wheel).namelist()
    missing = sorted(wanted - set(names))
    extra = [n for n in names if n not in wanted and ".dist-info/" not in n and not n.endswith(".abi3.so")]
    if missing or extra:
        sys.exit(f"{wheel}: missing {missing}, not in git {extra}")
    sys.stdout.write(f"wheel: {len(wanted)} files\n")


def steady(model, filters):
    """Run an EKF over ten seconds at rest on a model with a gyro and an accelerometer."""
    import numpy as np

    from robustnav.engine.filters import FilterSetup, SensorData
    from robustnav.filter.weighting import Gate

    n = 1000
    t = 0.01 * np.arange(n)
    setup = FilterSetup("ekf", model.nominal_state(), model.start_covariance(), (Gate(),) * len(model.sensors))
    data = [SensorData(t, np.tile([0.0, 0.0, -9.80665], (n, 1)))] + [None] * (len(model.sensors) - 1)
    out = filters(model, setup).run(t, np.zeros((n, 3)), data)
    if not (np.isfinite(out.x).all() and np.abs(out.x[-1] - model.nominal_state()).max() < 1e-6):
        sys.exit(f"{model.name}: a level unit at rest ends at {out.x[-1]}")
    sys.stdout.write(f"{model.name}: runs\n")


def kernel_filter(model, setup):
    """Return the compiled filter, whatever the default backend is."""
    from robustnav.engine.backends import running_filter

    return running_filter(model, setup, "c")


def built_in() -> None:
    """Run a built-in model where neither SymPy nor the checkout is there."""
    import importlib.util

    import robustnav
    from robustnav.models import AttitudeNoise, attitude

    if Path(sys.prefix) not in Path(robustnav.__file__).parents:
        sys.exit(f"robustnav came from {robustnav.__file__}, not from the wheel")
    if importlib.util.find_spec("sympy"):
        sys.exit("SymPy is installed: this cannot show that it is not needed")
    steady(attitude(AttitudeNoise(1e-3, 1e-5, 0.1, 1e-6), field=48e-6, dip_deg=63.0), kernel_filter)


def own_model() -> None:
    """Write a model, compile it against the headers in the wheel, and run it."""
    from robustnav.model import Equations, Model, Noise, Rotation, Sensor, Vector

    model = Model(
        name="level",
        state=(Rotation("q_nb"),),
        inputs=(Vector("gyro", "rad/s"),),
        noises=(Noise("gyro_noise", "rad/s/sqrt(Hz)", 1e-3),),
        sensors=(Sensor("accel", "m/s^2", 0.1),),
        parameters={"gravity": 9.80665},
        equations=lambda s: Equations(rates={"q_nb": s.gyro - s.gyro_noise}, directions={"accel": (0, 0, -s.gravity)}),
        start_sd={"q_nb": 0.1},
    )
    steady(model, kernel_filter)


if __name__ == "__main__":
    {"content": content, "built-in": built_in, "own-model": own_model}[sys.argv[1]](*sys.argv[2:])
