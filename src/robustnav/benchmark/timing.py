"""Timing side by side: contenders take turns in rounds, so that a slow phase of the machine meets them all."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from time import process_time_ns
from typing import Any

import numpy as np

from robustnav.errors import EstimatorError
from robustnav.frames import Array


@dataclass(frozen=True)
class Contender:
    """What is timed.

    Parameters
    ----------
    work : does ``steps`` steps; everything it needs was made before.
    steps : over which the time is divided.
    fault : of what ``work`` returned, how far it is from the truth, in units of what is still right: a filter that
        does not work is not timed.
    """

    work: Callable[[], object]
    steps: int
    fault: Callable[[Any], float]


@dataclass(frozen=True)
class Entry:
    """A row of a work: how its contender is made for a number of samples, and what it is.

    Parameters
    ----------
    make : from a number of samples of the work's inputs.
    needs : the module that must be installed, or None.
    baseline : True where other rows are compared with this one.
    """

    make: Callable[[int], Contender]
    needs: str | None = None
    baseline: bool = False


@dataclass(frozen=True)
class Work:
    """One kind of work: its name, what a step is, what it is fed, and its rows by name."""

    name: str
    step: str
    inputs: str
    entries: Mapping[str, Entry]


def time_rounds(
    contenders: Mapping[str, Contender], seconds: float, rounds: int, progress: Callable[[], None]
) -> dict[str, Array]:
    """Return by name the time of a step [ns] in every round (rounds,).

    Processor time of the whole process: what other programs take does not count, a library's own threads do.

    Parameters
    ----------
    contenders : by name.
    seconds : about how long each is timed, over all rounds [s].
    rounds : how many; every other one runs in the reverse order.
    progress : called after every round.

    Raises
    ------
    EstimatorError : a contender's result is not right.
    """
    out = {name: np.empty(rounds) for name in contenders}
    loops = {name: _loops(name, one, seconds / rounds) for name, one in contenders.items()}
    order = list(contenders)
    for k in range(rounds):
        with _no_collection():
            for name in order if k % 2 == 0 else reversed(order):
                out[name][k] = _elapsed_ns(contenders[name], loops[name]) / (loops[name] * contenders[name].steps)
        progress()
    return out


def _loops(name: str, contender: Contender, seconds: float) -> int:
    """Warm up, check the result, and return how many passes fill ``seconds``."""
    fault = contender.fault(contender.work())
    if not fault <= 1.0:
        raise EstimatorError(f"benchmark row {name!r} does not estimate", got=f"{fault:.3g} times what is right")
    loops = 1
    while (took := _elapsed_ns(contender, loops)) < seconds * 1e9 / 2:
        loops = max(2 * loops, int(loops * seconds * 1e9 / took) if took else 0)
    return loops


def _elapsed_ns(contender: Contender, loops: int) -> int:
    work = contender.work
    begin = process_time_ns()
    for _ in range(loops):
        work()
    return process_time_ns() - begin


@contextmanager
def _no_collection() -> Iterator[None]:
    was_on = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
