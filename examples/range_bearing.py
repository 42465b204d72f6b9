"""A target that circles a station measuring range and bearing; the bearing wraps at +-180 degrees."""

import numpy as np
import sympy as sp

import robustnav as rn


def equations(s):
    return rn.Equations(
        rates={"position": s.velocity, "velocity": s.manoeuvre},
        sensors={"range": sp.sqrt(s.position.dot(s.position)), "bearing": sp.atan2(s.position[1], s.position[0])},
    )


model = rn.Model(
    name="range_bearing",
    state=(rn.Vector("position", "m", 2), rn.Vector("velocity", "m/s", 2)),
    inputs=(),
    noises=(rn.Noise("manoeuvre", "m/s^2/sqrt(Hz)", 1.0, 2),),
    sensors=(rn.Sensor("range", "m", 1.0, 1), rn.Sensor("bearing", "rad", 0.01, 1, wraps=True)),
    equations=equations,
    start_sd={"position": 5.0, "velocity": 2.0},
    nominal={"position": (100.0, 0.0), "velocity": (0.0, 5.0)},
)


def main(backend="auto"):
    rng, t, start = np.random.default_rng(2), np.arange(0, 250, 0.2), rn.Start.at(model)
    path = 100 * np.exp(1j * 0.05 * t)  # two turns at 5 m/s, as north + i east
    true = zip(model.sensors, (np.abs(path), np.angle(path)), strict=True)
    z = {s.name: rn.Stream(s.name, t, (v + s.sd * rng.standard_normal(t.size))[:, None], s.unit) for s, v in true}
    for run in (rn.run(kind(model), rn.Log(z, "simulated"), start, backend=backend) for kind in (rn.EKF, rn.UKF)):
        error = run.state["position"] - np.stack([path.real, path.imag], axis=1)
        rms = [np.sqrt(np.mean(values[50:] ** 2, axis=0)).round(3) for values in (error, run.sd["position"])]
        print(f"{run.estimator} in {run.settings['backend']}: rms error {rms[0]} m, predicted {rms[1]} m")


if __name__ == "__main__":
    main()
