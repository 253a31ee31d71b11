"""D'Alembert's system as it is printed, in LaTeX or in plain text: which equations, in which words, and how short."""

from __future__ import annotations

from collections.abc import Callable

from symdyn.algebra.compact import Compactor
from symdyn.algebra.form import Form, form_of
from symdyn.algebra.sums_of_angles import total_angles
from symdyn.algebra.trigonometric import TrigonometricRing
from symdyn.dynamics import Workspace
from symdyn.dynamics.closed_forms.parallel import angle_groups
from symdyn.dynamics.loops.loop_words import in_words
from symdyn.dynamics.reactions.dalembert import Equilibrium, Unknown, equilibrium
from symdyn.errors import DerivationError, EmitError
from symdyn.graph import Expr, evaluate
from symdyn.scene import Scene

MOST = 60
"""Unknowns beyond which nobody reads the system."""

Forms = Callable[[Expr], Form]


def printed_system(scene: Scene) -> Equilibrium:
    """Return the system (5.18) of a scene, three equations a body where it moves in a plane of coordinates.

    Raises:
        EmitError: the mechanism is too large to be read.
    """
    workspace = Workspace(scene)
    try:
        system = equilibrium(workspace.hanging, planar=True)
    except DerivationError:
        system = equilibrium(workspace.hanging)
    if len(system.unknowns) > MOST:
        raise EmitError(
            f"{scene.name}: {len(system.unknowns)} unknowns are more than anyone reads (the limit is {MOST}); "
            "the outputs reactions and reactions:joint compute them"
        )
    return system


def direction(system: Equilibrium, unknown: Unknown) -> str:
    """Return what an unknown is where it has a fixed direction in its joint frame, such as "force along x"; else ""."""
    samples = system.hanging.samples
    force, moment = unknown.acts[0][1]
    first, second = (samples.at([*force, *moment], seed) for seed in (2, 3))
    return in_words(first[:3], first[3:]) if abs(first - second).max() < 1e-12 else ""


def forms_of(system: Equilibrium) -> Forms:
    """Return what writes an entry: as short as the ring of sines can, as it stands where there is no such ring."""
    state, graph = system.hanging.state, system.hanging.graph
    entries = [x for known in system.bodies for part in (*known.action, *known.inertia) for x in part]
    entries += [x for block in system.blocks.values() for part in block for x in part]
    needed = list(dict.fromkeys(entries))
    try:
        parallel = angle_groups(system.hanging.scene, graph)
        ring = TrigonometricRing(needed, (*state.q, *state.qd, *state.qdd), total_angles(parallel))
        values = dict(zip(needed, evaluate(needed, ring, ring.values(needed)), strict=True))
    except DerivationError:
        return form_of
    compact = Compactor(ring, parallel)
    return lambda node: compact(values[node])
