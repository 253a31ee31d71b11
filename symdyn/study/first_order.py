"""`uncertainty`: what is uncertain in parameters and starts, carried to motions and forces to first order.

    motion     x' = f(t, x, p)           variational equations at all samples (symdyn.simulation.variations)
    forces     τ = ID(q, u, u̇, p)        ∂ID/∂p along the motion, which is held (`inverse_dynamics_by_parameters`)

It takes one run and its derivatives where Monte Carlo takes thousands of runs. It is exact for what depends on the
uncertain in proportion, and says nothing of skewness, of means that move, and of what jumps: `sweep` and `ensemble` do.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt

from symdyn.arguments import with_fields
from symdyn.errors import SimulateError
from symdyn.scene import SceneLike
from symdyn.scene.values import Faults
from symdyn.simulation import Problem, Uncertainty
from symdyn.simulation.prescribed import Entries
from symdyn.study.covariances import read_spread


@with_fields(Problem)
def uncertainty(
    scene: SceneLike | Problem,
    over: Mapping[str, Any] | Iterable[str] | str = (),
    *,
    covariance: npt.ArrayLike | None = None,
    until: float | None = None,
    every: float | None = None,
    columns: str | Sequence[str] = (),
    motion: Entries | None = None,
    path: Entries = (),
    times: npt.ArrayLike = (),
    **fields: Unpack[Problem.Fields],
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
        scene: the mechanism, its parameters bound; or a `Problem`.
        over: what is uncertain: texts "NAME=DISTRIBUTION" as `sweep` takes them; or by name such a text, or a number,
            which is a standard deviation about the scene's value. A name is a parameter, or an independent position or
            velocity at the start; nothing for all parameters that have a tolerance. What has a distribution has its
            mean in the run.
        **fields: of `Problem`.
        covariance: of the names in `over`, shape (k, k), where they are correlated.
        until: time of the end of a run, s; None for 10.
        every: seconds between samples of a run; None for 200 of them.
        columns: names of columns or patterns; none for coordinates, velocities, outputs and driving forces.
        motion: laws of coordinates as `inverse` takes them: the motion is held, forces are uncertain, and no run is
            made: `until`, `start_rates` and `every` are refused.
        path: as for `inverse`.
        times: s, of the motion.
        start: coordinates at the start as for `simulate`; they are held where a parameter moves.

    Raises:
        SimulateError: with every fault of the arguments; forces that have no derivative; or a run that fails.
        SceneError: a value that the scene cannot have.
        UnknownNameError: a column that is none.
        DerivationError: there are no such dynamics.
    """
    problem, run = Problem.requested(uncertainty, locals())
    scene, faults = problem.scene, Faults("")
    if motion is None:
        unread = [name for name, given in (("path", path), ("times", times)) if np.asarray(given, dtype=object).size]
        faults.lines += [f"{name}: it belongs to a motion, and none is given; leave it out" for name in unread]
    else:
        given = {"start_rates": problem.start_rates, "until": until, "every": every}
        unread = [name for name, one in given.items() if one is not None]
        faults.lines += [f"{name}: it belongs to a run, and a motion is given; leave it out" for name in unread]
    spread = faults.taken(lambda: read_spread(scene, over, covariance, faults, starts=motion is None), None)
    faults.lines[:] = dict.fromkeys(faults.lines)
    faults.close(SimulateError)
    assert spread is not None, "what is missing is a fault"
    problem = problem.moved(*spread.moved(scene))
    wanted = (columns,) if isinstance(columns, str) else tuple(columns)
    names, C = spread.names, spread.covariance
    if motion is not None:
        return Uncertainty.of_forces(problem, names, C, motion, path, times, wanted)
    return Uncertainty.of_run(problem, run, names, C, wanted)
