"""Systems over values of one name: a parameter of the scene, or a letter that positions, rates or forces name.

Equations are derived once, with parameters free; only a value that changes their form, as zero does, derives again.
Where a value moves the place of rest, or of a steady motion, it is followed from the last one. That A is the same at
two times of a steady motion is looked at for the first value; at the others, that velocities stay and that the same
positions are cyclic. Where axes do not spin with a body it is looked at for every value, as their spin is another.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import LinearizeError
from symdyn.linear.linearization import Linearization
from symdyn.linear.locus import Locus, read_values, root_locus
from symdyn.linear.modes import untouched
from symdyn.linear.prepared import Prepared, prepared
from symdyn.linear.search import nearest
from symdyn.linear.spinning import STILL
from symdyn.linear.steady import BALANCED, settled, steady_next_to
from symdyn.scene import Scene, bind
from symdyn.scene.values import Parameter
from symdyn.simulation import Problem, opened


def systems(
    problem: Problem, name: str, independent: str | Sequence[str] = (), anywhere: bool = False
) -> Callable[[float], Linearization]:
    """Return the system at a value of a name; forces are texts or formulas by name, else as of `linearize`.

    Raises:
        LinearizeError: the name is no parameter, and no formula has it.
    """
    scene, forces = problem.scene, problem.forces
    parts = (*problem.by_name, forces if isinstance(forces, Mapping) else {"forces": forces})
    formulas = [str(one) for part in parts for one in part.values()]
    taken = {
        *scene.coordinates,
        *scene.velocities,
        *filter(None, scene.drives),
        *(one.name for one in scene.inputs),
        "t",
    }
    if name in taken:
        raise LinearizeError(f"--over: {name} moves; a range is of a parameter, or of a letter that formulas name")
    if name not in [one.name for one in scene.parameters]:
        if not any(re.search(rf"\b{re.escape(name)}\b", text) for text in formulas):
            there = ", ".join(one.name for one in scene.parameters) or "none"
            raise LinearizeError(
                f"--over: {name} is no parameter (they are: {there}) and in no formula; say what it does, as in "
                f'--speed "{scene.velocities[0]}={name}"'
            )
        scene = replace(scene, parameters=(*scene.parameters, Parameter(name)))
    derived: dict[Scene, Prepared] = {}
    known: dict[tuple[Scene, bool], tuple[Linearization, Linearization]] = {}
    last: list[Array] = []

    def system(value: float) -> Linearization:
        bound = bind(scene, {name: value})
        form = opened(bound).scene
        here = replace(problem, scene=bound)
        if form not in derived:
            derived[form] = prepared(here, (), independent)
        asked = replace(derived[form], scene=bound, forces=here.driving)
        start = here.initial
        still = bool(np.abs(start.u).max() <= STILL)
        like, slim = known.get((form, still), (None, None))
        found = asked.at(start.q, start.u, 0.0, start.notes, like=like)
        if not (anywhere or stays(found)):
            found = _followed(asked, found, start.q, still, last) or found
        if like is not None and slim is not None and not slim.spin.any() and stays(found):
            dropped = [found.states.names.index(one) for one in slim.dropped]
            if len(untouched(found.A, dropped)) == len(dropped):
                last[:] = [found.point.q]
                return replace(found.without(dropped), kind=slim.kind)
        known[form, still] = found, settled(asked, found, anywhere)
        last[:] = [found.point.q]
        return known[form, still][1]

    return system


def _followed(
    requested: Prepared, system: Linearization, start: Array, still: bool, last: Sequence[Array]
) -> Linearization | None:
    """Return the system at the place of rest, or the steady motion, next to the last one; None where none is near."""
    if still:
        place = nearest(requested, last[-1] if last else start)
        return None if place is None else requested.at(place, np.zeros(len(system.point.u)), like=system)
    return steady_next_to(requested, system, last[-1] if last else None)


def stays(system: Linearization) -> bool:
    """Whether the independent velocities stay at the point of a system."""
    velocities = [system.scene.velocities.index(name) for name in system.states.names[system.positions :]]
    size = max(1.0, float(np.abs(system.A[system.positions :]).max(initial=0.0)))
    return bool(np.all(np.abs(system.point.udot[velocities]) <= BALANCED * size))


def locus_over(problem: Problem, specified: str, independent: Sequence[str] = (), anywhere: bool = False) -> Locus:
    """Return the root locus over what `read_values` reads; other arguments and errors as of `systems`, `root_locus`."""
    name, values = read_values(specified, scene=problem.scene)
    return root_locus(name, values, systems(problem, name, independent, anywhere))
