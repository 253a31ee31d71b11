"""D'Alembert's system as it is printed, in LaTeX or in plain text: which equations, in which words, and how short.

Equations (5.18) stand body by body, one a component, numbers as they are. Bodies count from 1; frame j has the axes of
body j and its origin in the joint that carries it. Forces first, then moments; where the mechanism moves in a plane of
coordinates, three equations a body.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from symdyn.algebra import Compactor, Form, Function, Symbol, TrigonometricRing
from symdyn.dynamics import Workspace, angle_groups
from symdyn.dynamics.mechanism import TIME
from symdyn.dynamics.reactions import Equilibrium, Unknown
from symdyn.emit.print.breaking import refuse_too_long
from symdyn.emit.print.formula_text import broken_text, rounded
from symdyn.emit.print.printable import Lengths, NamedLength, called
from symdyn.emit.print.text_page import equation_lines, length_lines
from symdyn.errors import DerivationError, EmitError
from symdyn.graph import Expr, Op, evaluate, reachable, substitute, tangents
from symdyn.rounding import requested_digits
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


DIGITS = 15
"""Most digits of a number: what every double holds."""

AXES = ("force along x", "force along y", "force along z", "moment about x", "moment about y", "moment about z")


def dalembert_lines(scene: Scene) -> str:
    """Return D'Alembert's system of a scene in plain text; `symdyn.scene.parse` reads both sides of each equation.

    Raises:
        EmitError: the mechanism is too large to be read.
    """
    system = printed_system(scene)
    written = forms_of(system)
    names = _names(scene, system, written)
    kept = f"{len(system.kept)} a body"
    head = f"# {system.equations} equations, {kept}; {system.reactions} reactions and {system.drives} drives"
    lines = [head, "", *_unknowns(scene, system, names)]
    for j in range(len(system.bodies)):
        lines += ["", *_body(scene, system, written, names, j)]
    lines += length_lines(written.lengths, {name for one in written.lengths.named for name, _ in one.defined})
    return "\n".join(lines)


def _names(scene: Scene, system: Equilibrium, written: Written) -> list[str]:
    """Return a name for each unknown: the scene's own of a drive, else F_joint_x, M_joint_z or R_joint_1."""
    taken = {one.name for one in scene.parameters} | {*scene.coordinates, *scene.velocities}
    taken |= {drive for drive in scene.drives if drive}
    taken |= {name for one in written.lengths.named for name, _ in one.defined}
    drives = {joint.name: joint.drives for joint in scene.joints}
    found: list[str] = []
    for one in system.unknowns:
        own = drives.get(one.joint, ())[one.number : one.number + 1] if one.is_drive else ()
        if own and own[0]:
            found.append(own[0])
            continue
        words = system.direction(one)
        letter, index = "tau" if one.is_drive else "R", str(one.number + 1)
        if not one.is_drive and words[-2:] in (" x", " y", " z"):
            letter, index = "F" if words.startswith("force") else "M", words[-1]
        name = f"{letter}_{one.joint}_{index}"
        while name in taken:
            name += "_"
        taken.add(name)
        found.append(name)
    return found


def _unknowns(scene: Scene, system: Equilibrium, names: list[str]) -> Iterator[str]:
    for name, one in zip(names, system.unknowns, strict=True):
        yield f"# {name}: {_told(scene, system, one)}"


def _told(scene: Scene, system: Equilibrium, one: Unknown) -> str:
    """Return what an unknown is, in words."""
    if one.is_drive:
        return f"drive of joint {one.joint}" + (", which has none: zero" if one in system.passive else "")
    words = system.direction(one) or f"component {one.number + 1}"
    unit = scene.shown_unit("N m" if words.startswith("moment") else "N")
    return ", ".join(filter(None, (f"{words} of the {one.kind} in joint {one.joint}", "joint axes", unit)))


def _body(scene: Scene, system: Equilibrium, forms: Written, names: list[str], j: int) -> Iterator[str]:
    """Yield the equations of one body: what acts on it, its inertia and the unknowns add up to zero."""
    known = system.bodies[j]
    yield f"# body {j + 1}, {scene.bodies[j].name}: origin in joint {system.hanging.joints[j].joint.name}"
    for k in system.kept:
        terms = [forms([*part[0], *part[1]][k]) for part in (known.action, known.inertia)]
        for u, name in enumerate(names):
            if (block := system.blocks.get((j, u))) is not None:
                terms.append(Form.product((forms([*block[0], *block[1]][k]), Symbol(name))))
        yield f"# {AXES[k]}"
        yield equation_lines(broken_text(rounded(Form.sum(terms), requested_digits() or DIGITS)), "0")
