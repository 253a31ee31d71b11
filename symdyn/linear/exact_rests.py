"""Positions of rest that are so for every value of the parameters: angles in quarter turns, slides where springs hold.

At a quarter turn sines and cosines are 0, 1 or -1; what is left of the forces is linear in slides where springs are, so
they follow from a linear system over quotients of parameters. A candidate is one if its forces are zero as formulas.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import product

from symdyn.algebra import Form, Number, Ratios
from symdyn.dynamics import formulas
from symdyn.errors import DerivationError
from symdyn.graph import Expr, evaluate, gradient, reachable, substitute
from symdyn.linear.prepared import Prepared
from symdyn.scene import SceneUnits

MOST = 256
"""Candidates that are decided."""

Place = Mapping[Expr, Expr]


def exact_rests(prepared: Prepared, idle: Sequence[bool]) -> list[dict[str, Form]]:
    """Return the positions, each as formulas of the parameters by coordinate, `idle` ones left out; of a tree alone.

    Slides are where linear springs hold them, at zero where nothing linear does.
    """
    v, scene = prepared.functions, prepared.scene
    state, graph = v.w.state, v.w.graph
    bound = any(p.value is not None for p in v.w.scene.parameters)  # one decides the form of the equations
    if bound or v.multipliers or v.inputs or prepared.forces.tables or len(state.q) != state.n:
        return []
    forces = substitute(v.statics.parts["f"][1], dict.fromkeys(state.tau, graph.zero))
    moving = [
        (q, unit) for q, unit, still in zip(state.q, SceneUnits(scene).coordinates, idle, strict=True) if not still
    ]
    for choice in ((0, 2, 1, -1), (0, 2)):
        candidates = list(product(*(choice if unit == "rad" else (0,) for _, unit in moving)))
        if len(candidates) <= MOST:
            break
    else:
        return []
    found = []
    for one in candidates:
        turned = {q: graph.pi * Fraction(k, 2) for (q, unit), k in zip(moving, one, strict=True) if unit == "rad"}
        slides = [q for q, unit in moving if unit != "rad"]
        try:
            at = {**turned, **_held([forces[state.q.index(q)] for q in slides], slides, turned)}
            left = substitute(forces, at)
        except ZeroDivisionError:  # a spring of no length pulls nowhere
            continue
        if all(_vanishes(force, state.q) for force in left):
            found.append({str(q.value): Ratios.form_of(at[q]) for q, _ in moving})
    return found


def _vanishes(force: Expr, q: Sequence[Expr]) -> bool:
    """Tell whether a force is zero for every value of the parameters, wherever the mechanism is."""
    if force.is_zero or set(reachable([force])).intersection(q):
        return force.is_zero
    try:
        return formulas([force], 1) == [Number.ZERO]
    except DerivationError:
        return False


def _held(forces: Sequence[Expr], slides: Sequence[Expr], turned: Place) -> Place:
    """Return where linear forces hold the slides, angles being given; zeros where they are not linear."""
    if not slides:
        return {}
    graph = slides[0].graph
    free = dict.fromkeys(slides, graph.zero)
    forces = substitute(forces, turned)
    slopes = [x for force in forces for x in gradient(force, slides)]
    if set(reachable(slopes)).intersection(slides):
        return free
    still = substitute(forces, free)
    field = Ratios([*slopes, *still])
    known, n = evaluate([*slopes, *still], field, field.values()), len(slides)
    stiffness = [known[k : k + n] for k in range(0, n * n, n)]
    try:
        shifts = field.solved(stiffness, [[field.neg(x)] for x in known[n * n :]])
    except (ZeroDivisionError, OverflowError):
        return free
    return {q: field.form(x).express(graph) for q, (x,) in zip(slides, shifts, strict=True)}
