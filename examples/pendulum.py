"""A driven pendulum with unknown damping, seen by an angle encoder: a model of one's own in two filters."""

import numpy as np
import sympy as sp

import robustnav as rn


def equations(s):
    pull = s.torque[0] - s.gravity / s.length * sp.sin(s.swing[0]) - s.damping[0] * s.swing[1]
    return rn.Equations({"swing": (s.swing[1], pull + s.gust[0]), "damping": s.drift}, {"encoder": s.swing[0]})


model = rn.Model(
    name="pendulum",
    state=(rn.Vector("swing", "rad, rad/s", 2), rn.Vector("damping", "1/s", 1)),
    inputs=(rn.Vector("torque", "rad/s^2", 1),),
    noises=(rn.Noise("gust", "rad/s^2/sqrt(Hz)", 0.05, 1), rn.Noise("drift", "1/s^2/sqrt(Hz)", 0.01, 1)),
    sensors=(rn.Sensor("encoder", "rad", 0.02, 1),),
    parameters={"gravity": 9.81, "length": 1.0},
    equations=equations,
    start_sd={"swing": (0.2, 0.5), "damping": 0.3},
)


def main(backend="auto"):
    rng, t, start = np.random.default_rng(1), np.arange(0, 30, 0.01), rn.Start.at(model)
    f, torque, x = rn.model.NumericModel(model), 3 * np.sin(2 * t)[:, None], [rng.multivariate_normal(start.x, start.P)]
    for u in torque[1:]:
        x.append(rng.multivariate_normal(f.propagate(x[-1], u, 0.01), f.transition(x[-1], u, 0.01)[1]))
    z = {"torque": torque, "encoder": np.array(x)[:, :1] + 0.02 * rng.standard_normal(torque.shape)}
    log = rn.Log({name: rn.Stream(name, t, values, "") for name, values in z.items()}, "simulated")
    for run in (rn.run(kind(model), log, start, backend=backend) for kind in (rn.EKF, rn.UKF)):
        parts = np.hstack([*run.state.values()]) - x, np.hstack([*run.sd.values()])
        rms = [np.sqrt(np.mean(part[500:] ** 2, axis=0)).round(4) for part in parts]
        print(f"{run.estimator} in {run.settings['backend']}: rms error {rms[0]}, predicted {rms[1]}")


if __name__ == "__main__":
    main()
