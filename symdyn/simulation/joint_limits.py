"""What is said of joints at their limits: where a run starts, where one stops it, and which ones a motion passes.

A joint that reaches a limit of its position rests on its stop, which the equations do not know: what they go on to
tell is another mechanism's motion. Limits of velocity and effort say what a drive can do; the equations hold beyond.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symdyn.algebra import Array
from symdyn.graph import Graph
from symdyn.scene import Scene
from symdyn.simulation.equations.crossings import SLACK, STOPS, Limit
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.integrate.method import Hit

DATA = "the limit is data for controllers, nothing in the equations keeps it"


def stopping(system: StateEquations, ignored: bool) -> tuple[bool, ...]:
    """Return of every limit whether it ends a run where a joint passes it."""
    return tuple(limit.kind in STOPS and not ignored for limit in system.limits)


def nothing_ignored(system: StateEquations, ignored: bool) -> tuple[str, ...]:
    """Return what is said where limits are to be ignored that there are not."""
    if not ignored or any(limit.kind in STOPS for limit in system.limits):
        return ()
    return (f"ignoring limits has no effect: no joint of {system.scene.name} has a limit of its position",)


def named(limit: Limit, scene: Scene) -> str:
    """Return a limit by its joint, such as "joint elbow: upper limit 1.57 rad"."""
    return f"joint {limit.joint.name}: {limit.words(scene)}"


def reached(limit: Limit, scene: Scene, t: float) -> str:
    """Return what is said of a limit that ended a run."""
    return (
        f"joint {limit.joint.name} reaches its {limit.words(scene)} at t = {t:.9g} s, a stop that the equations do not "
        "know; --ignore-limits, in Python ignore_limits=True, goes on"
    )


def at_start(system: StateEquations, x: Array, stops: Sequence[bool]) -> list[str]:
    """Return what is said of a start x, shape (nx,), beyond limits, of which some stop a run."""
    goes_on = "the run goes on until the joint has come back and passes it again"
    outside = beyond(system, np.zeros(1), x[None])[0]
    found = [(limit, stop) for limit, out, stop in zip(system.limits, outside, stops, strict=True) if out]
    found += [(limit, False) for limit in _by_constant_forces(system, x)]
    return [
        f"{named(limit, system.scene)} is passed at the start; {goes_on if stop else DATA}" for limit, stop in found
    ]


def _by_constant_forces(system: StateEquations, x: Array) -> list[Limit]:
    """Return the limits of effort that a force passes which no state changes, so that nothing crosses zero."""
    scene, graph = system.scene, Graph()
    watched = {limit.joint.name for limit in system.limits if limit.kind == "effort"}
    forces = np.broadcast_to(system.evaluate("drives", 0.0, x), (system.nv,))
    found = []
    for joint in scene.moving:
        limit, first = Limit(joint, "effort", graph.zero), scene.velocities.index(joint.rates[0])
        told = joint.name not in watched and joint.limits.effort is not None and len(joint.rates) == 1
        found += [limit] if told and abs(forces[first]) > limit.size(scene) else []
    return found


def on_the_way(system: StateEquations, t: Array, x: Array, hits: Sequence[Hit], stops: Sequence[bool]) -> list[str]:
    """Return what is said of limits that a run passed after its start, at samples or, by its hits, between them."""
    outside, first, found = beyond(system, t, x), len(system.events) + len(system.ends), []
    for k, (limit, stop) in enumerate(zip(system.limits, stops, strict=True)):
        times = [] if stop else [hit.t for hit in hits if hit.event == first + k]
        rows = slice(len(t) - stop)  # where a limit stops a run, its last row is beyond it
        found += passed(limit, system.scene, times or passages(t[rows], outside[rows, k])[int(outside[0, k]) :])
    return found


def beyond(system: StateEquations, t: Array, x: Array) -> Array:
    """Return whether states (N, nx) at times (N,) are beyond each limit, shape (N, limits)."""
    if not system.limits:
        return np.zeros((len(t), 0), dtype=bool)
    values = system.evaluate("events", t, x)
    return np.asarray(values[:, values.shape[1] - len(system.limits) :] > SLACK)


def passages(t: Array, outside: Array) -> list[float]:
    """Return at which times, shape (N,), a limit has been passed that was kept a sample before; the first counts."""
    before = np.concatenate([[False], outside[:-1]])
    return [float(one) for one in t[outside & ~before]]


def passed(limit: Limit, scene: Scene, times: Sequence[float]) -> list[str]:
    """Return what is said of a limit that was passed at some times, nothing where there are none."""
    again = len(times) - 1
    more = f" and {again} time{'s' * (again > 1)} more" if again > 0 else ""
    return [f"{named(limit, scene)} is passed at t = {times[0]:.6g} s{more}; {DATA}"] if times else []
