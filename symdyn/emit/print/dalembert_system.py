"""D'Alembert's system as it is printed, in LaTeX or in plain text: which equations, in which words, and how short."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from symdyn.algebra import Compactor, Form, Function, TrigonometricRing
from symdyn.dynamics import Workspace, angle_groups
from symdyn.dynamics.mechanism import TIME
from symdyn.dynamics.reactions import Equilibrium
from symdyn.emit.print.lengths import Lengths, NamedLength, called
from symdyn.emit.print.too_long import refuse_too_long
from symdyn.errors import DerivationError, EmitError
from symdyn.graph import Expr, Op, evaluate, reachable, substitute, tangents
from symdyn.scene import Scene
from symdyn.scene.values import Strut, velocity_name

MOST = 60
"""Unknowns beyond which nobody reads the system."""

INSTEAD = (
    "symdyn walkthrough --formulation dalembert writes it with names for what is long, and the outputs reactions and "
    "reactions:joint compute it"
)
"""What to ask for where the system is too long."""

Forms = Callable[[Expr], Form]


def printed_system(scene: Scene) -> Equilibrium:
    """Return the system (5.18) of a scene, three equations a body where it moves in a plane of coordinates.

    Raises:
        EmitError: the mechanism is too large to be read.
    """
    system = Equilibrium.for_readers(Workspace(scene).hanging)
    if len(system.unknowns) > MOST:
        raise EmitError(
            f"{scene.name}: {len(system.unknowns)} unknowns are more than anyone reads (the limit is {MOST}); "
            "the outputs reactions and reactions:joint compute them"
        )
    return system


@dataclass(frozen=True)
class Written:
    """What writes the entries of a system, and the lengths of struts that stand in them by name."""

    forms: Forms
    lengths: Lengths

    def __call__(self, node: Expr) -> Form:
        """Return an entry as it is printed."""
        return self.forms(node)


def forms_of(system: Equilibrium) -> Written:
    """Return what writes an entry: as short as the ring of sines can, as it stands where there is no such ring.

    Raises:
        EmitError: the entries together are too long to be written.
    """
    state, graph, scene = system.hanging.state, system.hanging.graph, system.hanging.scene
    entries = [x for known in system.bodies for part in (*known.action, *known.inertia) for x in part]
    entries += [x for block in system.blocks.values() for part in block for x in part]
    names, called_so = length_symbols(system)
    kept = list(dict.fromkeys(entries))
    short = dict(zip(kept, substitute(kept, names), strict=True))
    used = set(reachable(list(short.values())))
    lengths = [one for one in called_so if used & {graph.symbol(one[2]), graph.symbol(velocity_name(one[2]))}]
    needed = list(dict.fromkeys([*short.values(), *(x for one in lengths for x in one[3:])]))
    parallel = angle_groups(scene, graph)
    write: Forms = Form.of
    try:
        ring = TrigonometricRing(needed, (*state.q, *state.qd, *state.qdd), parallel)
        values = dict(zip(needed, evaluate(needed, ring, ring.values(needed)), strict=True))
        compact = Compactor(ring, parallel)
        write = lambda node: compact(values[node])  # noqa: E731
    except DerivationError:
        pass
    named = tuple(
        NamedLength(struts, index, name, velocity_name(name), Function(Op.SQRT, (write(square),)), write(rate))
        for struts, index, name, square, rate in lengths
    )
    written = Written(lambda node: write(short[node]), Lengths(named))
    blocks = [x for block in system.blocks.values() for part in block for x in part]  # written with and without x
    refuse_too_long(scene.name, "D'Alembert's system", map(written, (*entries, *blocks)), INSTEAD)
    return written


def length_symbols(
    system: Equilibrium,
) -> tuple[dict[Expr, Expr], list[tuple[tuple[Strut, ...], tuple[str, ...], str, Expr, Expr]]]:
    """Return symbols in place of lengths and their rates; and of each length its name, its square and its rate."""
    scene, graph, state = system.hanging.scene, system.hanging.graph, system.hanging.state
    apart = [one for one in scene.struts if one.ends]
    together: dict[Expr, list[Strut]] = {}
    for strut in apart:
        square = system.hanging.squared_length(strut)
        if not square.is_zero:
            together.setdefault(square, []).append(strut)
    taken = {one.name for one in scene.parameters} | {one.name for one in scene.inputs}
    taken |= {*scene.coordinates, *scene.velocities, TIME}
    taken |= {drive for drive in scene.drives if drive}
    names: dict[Expr, Expr] = {}
    found = []
    for square, (struts, index, name) in zip(together, called(scene, together.values(), taken), strict=True):
        s = graph.sqrt(square)
        (rate,) = tangents([s], state.velocity)
        names |= {s: graph.symbol(name), rate: graph.symbol(velocity_name(name))}
        found.append((struts, index, name, square, substitute([rate], {s: graph.symbol(name)})[0]))
    return names, found
