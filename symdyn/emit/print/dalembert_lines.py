"""D'Alembert's system in plain text: the equations (5.18) body by body, one a component, numbers as they are.

Bodies count from 1; frame j has the axes of body j and its origin in the joint that carries it. Forces first, then
moments; where the mechanism moves in a plane of coordinates, three equations a body.
"""

from __future__ import annotations

from collections.abc import Iterator

from symdyn.algebra import Form, Symbol
from symdyn.dynamics.reactions import Equilibrium, Unknown
from symdyn.emit.print.dalembert_system import Written, forms_of, printed_system
from symdyn.emit.print.formula_text import broken_text, rounded
from symdyn.emit.print.text_page import equation_lines, length_lines
from symdyn.rounding import requested_digits
from symdyn.scene import Scene

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
