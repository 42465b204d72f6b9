"""Follow a tag through its ranges: started without a prior, restarted when it is lost, smoothed if wanted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robustnav.engine.filters import SensorSeen
from robustnav.errors import InputError
from robustnav.filter.steps import unpack
from robustnav.filter.weighting import Rule
from robustnav.model.blocks import Model
from robustnav.records import Log, Run
from robustnav.run.acquisition import BETTER, REFUSED_NIS, Acquisition, lost_at, places, rivals, track_cost
from robustnav.run.estimators import EKF, UKF
from robustnav.run.feed import broken, deviations, events_of, innovations_of, settings_of
from robustnav.run.hypotheses import Leg, hear, smoothed
from robustnav.run.loop import Start
from robustnav.run.tracking_task import RANGING, Readings, Source, TrackingTask
from robustnav.snapshot.window import Minimum

_MOST_SIDES = 4  # of doubts about the side that are listed
_PARTS = 10.0  # of a time constant in the longest step of a prediction; a fifth is fine enough for velocities


def ranging_ekf(model: Model, rule: Rule) -> EKF:
    """Return the EKF on a model of ``models.uwb`` with one rule for ranges and differences that are far off.

    On a model with biases a pause is predicted in parts much shorter than their time constant.
    """
    slowest = model.parameters.get("bias_time", np.inf), 2 / max(model.parameters.get("velocity_damping", 0.0), 1e-9)
    longest_step = min(slowest) / _PARTS
    return EKF(model, dict.fromkeys(RANGING, rule), longest_step=longest_step)


def track(
    estimator: EKF | UKF,
    readings: Readings | Sequence[Readings],
    *,
    log: Log | None = None,
    height: float | None = None,
    acquisition: Acquisition | None = None,
    smooth: bool = False,
    backend: str = "auto",
    max_gap: float = 1.0,
) -> Run:
    """Return where a tag was, from its ranges or range differences, without a prior.

    A short window of readings gives the first position (``snapshot.window``).  Where a mirror image explains them as
    well, both are followed until the readings decide; the likelier one is reported meanwhile, with standard deviations
    that reach to the other.  The same happens where a tag passes the plane of anchors that hardly leave one.  When most
    readings of a window are far off, the window is asked again; a place that explains it much better restarts the
    filter.  All of this is in the events.  Nothing looks ahead, unless ``smooth`` is asked for.

    Parameters
    ----------
    estimator : on a model of ``models.uwb``.
    readings : ranges, differences, or both, of one tag, in the axes of their anchors, z down.
    log : other streams the model knows: ``accel_n`` of a driven model, ``position``, ``height``.
    height : a known height of the tag [m], up; asserted ten times a second with the sd of the model's sensor.
    acquisition : how to start and restart; None: the defaults.
    smooth : smooth over the whole recording (Rauch-Tung-Striebel); a restart cuts it.
    backend : ``auto``, ``c``, ``float`` or ``numpy``.
    max_gap : longer silence [s] is named in the events.

    Returns
    -------
    Run : from the first position on; innovations of all readings, with NaN before.

    Raises
    ------
    InputError : a model that follows no tag, readings of several tags, or a height in a plane.
    EstimatorError : no window of readings tells a position.
    """
    model = estimator.model
    if not {"p_n", "v_n"} <= set(model.state_slices) or model.rotation is not None:
        raise InputError(f"model {model.name!r}", expected="a model of models.uwb", do="use run for other models")
    source = Source(readings, log, height)
    task = TrackingTask.of(estimator, source, acquisition or Acquisition(), backend)
    course = _Course(task, [], [], task.nothing_said())
    row, found = task.first_place()
    course.events.append(f"started at {task.feed.t[row]:.2f} s, sd {_size(found[0]):.2f} m")
    course.set_out(row, found)
    while course.go_on():
        pass
    return _run(course, smooth=smooth, max_gap=max_gap)


@dataclass
class _Course:
    """What has been followed so far: legs, events in words, and what each sensor's readings said."""

    task: TrackingTask
    legs: list[Leg]
    events: list[str]
    seen: list[SensorSeen | None]

    def set_out(self, row: int, found: list[Minimum]) -> None:
        """Begin a leg at the likeliest place, and beside it at its rival if there is one."""
        events, t = self.task.events, self.task.feed.t[row]
        others = rivals(events, events.between(t - self.task.tau, t), found)[:1]
        starts = [self.task.start(m) for m in (found[0], *others)]
        self._add(Leg.begin(self.task, row, starts, others[0].cost if others else 0.0))

    def go_on(self) -> bool:
        """Begin the next leg where the last one is lost or passes the anchors' plane; return whether there is one."""
        leg = self.legs[-1]
        passed, found = self._passes(leg), None
        lost = self._lost(leg, passed)
        if lost is not None:
            row, found = lost
            moved = np.linalg.norm(found[0].p - self.task.place(leg.at(row)[0]))
            where = f"{moved:.1f} m away, sd {_size(found[0]):.2f} m"
            self.events.append(f"lost at {self.task.feed.t[row]:.2f} s and found again {where}")
            self.set_out(row, found)
        elif passed is not None:
            x, P = (a[0] for a in leg.shown(slice(passed - leg.row, passed - leg.row + 1)))
            starts = [Start(x, unpack(P)), self.task.mirrored(x, P)]
            following = Leg.begin(self.task, passed, starts, 0.0, continues=True)
            following.second_look = not self.task.sides(x[None], unpack(P)[None])[0][0]
            self._add(following)
        return lost is not None or passed is not None

    def _add(self, leg: Leg) -> None:
        t = self.task.feed.t
        if self.legs:
            self.legs[-1].stop = leg.row
        self.legs.append(leg)
        times = [None if d is None else d.t for d in self.task.feed.sensors]
        hear(self.seen, leg.said(t, times), times, t[leg.row])

    def _lost(self, leg: Leg, before: int | None) -> tuple[int, list[Minimum]] | None:
        """Return the next row, up to one, at which the filter is lost and readings tell a better place, or None."""
        task = self.task
        if not task.settings.restart:
            return None
        events, t, last = task.events, task.feed.t, -np.inf
        stop = len(t) if before is None else before
        nis = np.concatenate([one.nis for one in self._ranging()])[task.order]
        off = np.nan_to_num(nis, nan=0.0) > REFUSED_NIS
        for k in lost_at(events, off, t[leg.row], task.tau):
            row = int(np.searchsorted(t, events.t[k]))
            if events.t[k] - last < task.tau / 2 or row >= stop:
                continue
            last = events.t[k]
            rows = events.between(max(last - task.tau, t[leg.row]), t[row])
            held = [(task.place(x), task.velocity(x)) for x in leg.at(row)]
            found = places(events, rows, task.settings, held[0][0], compiled=task.backend != "numpy")
            if found and found[0].cost < min(track_cost(events, rows, *one) for one in held) - BETTER:
                return row, found
        return None

    def _passes(self, leg: Leg) -> int | None:
        """Return the next row at which a tag may be on the other side of the anchors' plane unnoticed, or None.

        Beside the plane it may, also where two ways come back to it; and where two ways came together, once.
        """
        t, last = self.task.feed.t, len(self.task.feed.t) - 1
        x, P = leg.shown(slice(None))
        rows, clearly = self.task.sides(x, unpack(P))
        if len(leg.ways) == 2:
            settled = np.arange(leg.row, len(t)) > leg.end
            later = t[leg.row :] >= t[min(leg.end, last)] + self.task.tau
            again = np.logical_or.accumulate(~rows) & rows
            rows = again | (later & rows)
            if leg.merged and not leg.second_look:
                rows |= settled & clearly
        rows[0] &= len(leg.ways) == 1
        rows[-1] = False
        return leg.row + int(np.argmax(rows)) if rows.any() else None

    def _ranging(self) -> list[SensorSeen]:
        names = [s.name for s in self.task.estimator.model.sensors]
        return [one for name in RANGING if (one := self.seen[names.index(name)]) is not None]

    def words(self) -> list[str]:
        """Return the events, and the doubt of every leg that had two ways."""
        t, out = self.task.feed.t, list(self.events)
        for leg in (leg for leg in self.legs if len(leg.ways) == 2):
            other = ", ".join(f"{v:.2f}" for v in self.task.place(leg.ways[1].x[0]))
            end = f"settled at {t[leg.end]:.2f} s" if leg.settled else f"not settled by {t[leg.stop - 1]:.2f} s"
            what = "either side of the anchors' plane fits" if leg.continues else "two places fit"
            out.append(f"{what} from {t[leg.row]:.2f} s, the other ({other}) m: {end}")
        sides = [k for k, text in enumerate(out) if text.startswith("either side")]
        if len(sides) > _MOST_SIDES:  # a tag that moves along the plane is asked about over and over
            kept = [text for k, text in enumerate(out) if k not in sides[_MOST_SIDES - 1 : -1]]
            return [*kept, f"{len(sides) - _MOST_SIDES} more doubts about the side between these"]
        return out


def _run(course: _Course, *, smooth: bool, max_gap: float) -> Run:
    task, legs = course.task, course.legs
    model, feed, first = task.estimator.model, task.feed, legs[0].row
    if smooth:
        x, P = smoothed(task, legs)
    else:
        parts = [leg.reported() for leg in legs]
        x, P = np.vstack([x for x, _ in parts]), np.vstack([P for _, P in parts])
    gaps = np.flatnonzero(np.diff(task.events.t) > max_gap)[:20]
    silence = [f"no ranges from {task.events.t[k]:.2f} to {task.events.t[k + 1]:.2f} s" for k in gaps]
    followed = replace(feed, t=feed.t[first + 1 :], u=feed.u[first + 1 :])
    words = (*course.words(), *silence, *events_of(model, task.with_silent(), feed, np.inf))
    words += broken(model, followed, course.seen)
    return Run(
        estimator=task.estimator.name + ("-rts" if smooth else ""),
        model=model.name,
        t=feed.t[first:],
        state={name: x[:, part] for name, part in model.state_slices.items()},
        sd=deviations(model, unpack(P)),
        innovations=innovations_of(model, feed, course.seen),
        events=words,
        settings=settings_of(model, task.backend) | {"acquisition window [s]": task.tau},
    )


def _size(found: Minimum) -> float:
    return float(np.sqrt(np.trace(found.P)))
