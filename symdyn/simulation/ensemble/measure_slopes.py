"""How measures of a run depend on its start and on parameters.

A fold is taken of the run as it is to first order on both sides of every name: the largest value follows the sample
where it is, and a measure that jumps from one sample to another has no derivative there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import SimulateError
from symdyn.scene import Scene
from symdyn.scene.values import Faults
from symdyn.simulation.ensemble.measures import read_measures
from symdyn.simulation.ensemble.one_by_one import measured
from symdyn.simulation.forward import simulate
from symdyn.simulation.initial import read_start
from symdyn.simulation.prescribed.forces import read_forces
from symdyn.simulation.variations import variations


def measure_slopes(
    scene: Scene,
    measures: Sequence[str],
    names: Sequence[str],
    forces: Any,
    until: float,
    start: Mapping[str, Any],
    start_rates: Mapping[str, Any],
    every: float | None,
) -> Array:
    """Return the derivatives of measures of a run by each of the names, shape (measures, names); NaN where none is.

    Arguments as of `simulate`; names as of `variations`.

    Raises:
        SimulateError: with every fault.
    """
    faults = Faults("")
    read = read_measures(scene, measures, faults)
    faults.close(SimulateError)
    given = read_forces(scene, forces)
    initial = read_start(scene, start, start_rates)
    run = simulate(scene, given, until, initial, every=every, say=lambda _: None)
    found = variations(run, given, initial, names)
    slopes = np.zeros((len(read), len(names)))
    for k in range(len(names)):
        step = found.step(k)
        ahead, behind = (measured(found.beside(k, sign * step), read) for sign in (1, -1))
        slopes[:, k] = (ahead - behind) / (2 * step)
    return slopes
