"""`uncertainty`: what is uncertain in parameters and starts, carried to motions and forces to first order.

    motion     x' = f(t, x, p)           variational equations at all samples (symdyn.simulation.variations)
    forces     τ = ID(q, u, u̇, p)        ∂ID/∂p along the motion, which is held (`inverse_dynamics_by_parameters`)

It takes one run and its derivatives where Monte Carlo takes thousands of runs. It is exact for what depends on the
uncertain in proportion, and says nothing of skewness, of means that move, and of what jumps: `sweep` and `ensemble` do.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.arguments import check_arguments, doubles
from symdyn.errors import SimulateError
from symdyn.scene import SceneLike, bind, scene_of
from symdyn.scene.values import Faults
from symdyn.simulation import Forces, Uncertainty, Values
from symdyn.simulation.prescribed import Entries
from symdyn.study.covariances import read_spread


def uncertainty(
    scene: SceneLike,
    over: Mapping[str, Any] | Iterable[str] | str = (),
    forces: Forces | Entries = Forces(),  # noqa: B008  frozen
    until: float = 10.0,
    *,
    covariance: npt.ArrayLike | None = None,
    start: Values | None = None,
    start_rates: Values | None = None,
    every: float | None = None,
    columns: str | Sequence[str] = (),
    motion: Entries | None = None,
    path: Entries = (),
    times: npt.ArrayLike = (),
    values: Mapping[str, object] | None = None,
) -> Uncertainty:
    """Return standard deviations of a run's columns at all its samples, to first order.

    >>> import symdyn
    >>> found = symdyn.uncertainty(symdyn.example("cart_pole"), {"mp": 0.01, "theta": 0.02}, until=1)
    >>> found["x"].shape, float(found["theta"][0])
    ((201,), 0.02)
    >>> along = symdyn.uncertainty(symdyn.example("cart_pole"), "mp=uniform(0.2, 0.3)",
    ...     motion=["x=t**2", "theta=0"], times=[0, 1], columns="F")
    >>> along["F"].round(5).tolist()
    [0.05774, 0.05774]

    Args:
        scene: the mechanism, its parameters bound.
        over: what is uncertain: texts "NAME=DISTRIBUTION" as `sweep` takes them; or by name such a text, or a number,
            which is a standard deviation about the scene's value. A name is a parameter, or an independent position or
            velocity at the start; nothing for all parameters that have a tolerance. What has a distribution has its
            mean in the run.
        forces: driving forces as for `simulate`.
        until: time of the end, s.
        covariance: of the names in `over`, shape (k, k), where they are correlated.
        start: coordinates at the start as for `simulate`; they are held where a parameter moves.
        start_rates: velocities likewise.
        every: seconds between samples; None for 200 samples.
        columns: names of columns or patterns; none for coordinates, velocities, outputs and driving forces.
        motion: laws of coordinates as `inverse` takes them: the motion is held, and forces are uncertain. Of the
            arguments above, `until`, `start_rates` and `every` have no part in it.
        path: as for `inverse`.
        times: s, of the motion.
        values: of parameters, in place of those that the scene gives.

    Raises:
        SimulateError: with every fault of the arguments; forces that have no derivative; or a run that fails.
        SceneError: a value that the scene cannot have.
        UnknownNameError: a column that is none.
        DerivationError: there are no such dynamics.
    """
    check_arguments(uncertainty, locals(), SimulateError)
    until, every = doubles(until, every)
    scene = scene_of(scene)
    scene = scene_of(scene, values)
    faults = Faults("")
    spread = None
    if motion is None:
        unread = [name for name, given in (("path", path), ("times", times)) if np.asarray(given, dtype=object).size]
        faults.lines += [f"{name}: it belongs to a motion, and none is given; leave it out" for name in unread]
    else:
        unread = [name for name, given in (("start_rates", start_rates), ("every", every)) if given is not None]
        faults.lines += [f"{name}: it belongs to a run, and a motion is given; leave it out" for name in unread]
    with faults.noted():
        spread = read_spread(scene, over, covariance, faults, starts=motion is None)
    faults.lines[:] = dict.fromkeys(faults.lines)
    faults.close(SimulateError)
    assert spread is not None, "what is missing is a fault"
    parameters, places, rates = spread.moved(scene)
    scene = bind(scene, parameters) if parameters else scene
    wanted = (columns,) if isinstance(columns, str) else tuple(columns)
    names, C = spread.names, spread.covariance
    if motion is not None:
        return Uncertainty.of_forces(scene, names, C, motion, path, times, start, forces, wanted)
    begin, rates_there = _with(start, places), _with(start_rates, rates)
    return Uncertainty.of_run(scene, names, C, forces, until, begin, rates_there, every, wanted)


def _with(given: Values | None, means: Mapping[str, float]) -> Values | None:
    """Return a start with means in place of what it says."""
    if not means:
        return given
    if isinstance(given, str):
        pairs = (part.partition("=") for part in given.split(",") if part.strip())
        given = {name.strip(): text.strip() for name, _, text in pairs}
    return {**(given or {}), **means}
