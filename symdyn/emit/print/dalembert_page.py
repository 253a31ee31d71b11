"""D'Alembert's system (5.18) in print, in LaTeX or as plain text: which equations, in which words, and how short.

LaTeX has the bivectors of every body and the count of unknowns, too. Equations stand body by body, one a component,
numbers as they are: forces first, then moments; three a body where the mechanism moves in a plane of coordinates.
Bodies count from 1, the ground is 0 (in the textbook 1); frame j has the axes of body j and its origin in the joint
that carries it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from symdyn.algebra import Form, Function, Symbol
from symdyn.arguments import argument
from symdyn.dynamics import Workspace, angle_groups
from symdyn.dynamics.mechanism import TIME
from symdyn.dynamics.reactions import Equilibrium, Unknown
from symdyn.emit.print.breaking import BREAK, DIGITS, LINE, BMatrix, Line, align, definitions, refuse_too_long
from symdyn.emit.print.formula_text import Forms, Latex, broken_text, in_sines, rounded
from symdyn.emit.print.printable import Lengths, NamedLength, called
from symdyn.emit.print.printed_names import Letters, latex_symbols
from symdyn.emit.print.written_page import (
    equation_lines,
    length_lines,
    rate_lines,
    rate_sections,
    symbol_row,
    symbol_table,
)
from symdyn.emit.render import in_latex
from symdyn.errors import EmitError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Op, reachable, substitute, tangents
from symdyn.rounding import digits_or, requested_digits
from symdyn.scene import Scene
from symdyn.scene.values import Strut, velocity_name

MOST = 60
"""Unknowns beyond which nobody reads the system."""

INSTEAD = (
    "symdyn walkthrough --formulation dalembert writes it with names for what is long, and the outputs reactions and "
    "reactions:joint compute it"
)
"""What to ask for where the system is too long."""


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
    write = in_sines(needed, state, angle_groups(scene, graph))
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
    apart = [one for one in scene.struts if one.ends and not one.is_rope]
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


TEXT_DIGITS = 15
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
    many = "s" * (system.drives != 1)
    head = f"# {system.equations} equations, {kept}; {system.reactions} reactions and {system.drives} drive{many}"
    lines = [
        head,
        "",
        *(f"# {name}: {_told(scene, system, one)}" for name, one in zip(names, system.unknowns, strict=True)),
    ]
    for j in range(len(system.bodies)):
        lines += ["", *_body(scene, system, written, names, j)]
    lines += length_lines(written.lengths, {name for one in written.lengths.named for name, _ in one.defined})
    return "\n".join(lines + rate_lines(scene))


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
        yield equation_lines(broken_text(rounded(Form.sum(terms), requested_digits() or TEXT_DIGITS)), "0")


def dalembert_equations(scene: Scene, format: str = "latex", document: bool = False) -> str:
    """Return the system in LaTeX, a whole document of it where that is asked for, or as plain text.

    Raises:
        EmitError: another format, a document of text, or more than anybody reads.
    """
    if format == "text" and not document:
        return dalembert_lines(scene)
    if format != "latex":
        told = f"without {argument('document')}"
        raise EmitError(f"D'Alembert's system is written in LaTeX and, {told}, as text, not as {format}")
    return dalembert_text(scene, document)


def dalembert_text(scene: Scene, document: bool = False) -> str:
    """Return D'Alembert's system of a scene in LaTeX: displays, or a whole document.

    Raises:
        EmitError: the mechanism is too large to be read.
    """
    system = printed_system(scene)
    page = _Page(scene, system)
    sections = [
        {"title": "Equations and unknowns", "text": page.count(), "body": "\n".join(page.unknown_vector())},
        *page.bodies(),
        {
            "title": "The system",
            "text": r"(5.18): $\bar F^A_{jj} + \bar F^D_{jj} + \bar F^R_{jj} + \sum_e \bar F^{*R}_{je} = 0$. "
            r"With the unknowns $x$ in front this is $A\,x + b = 0$, in blocks by body and joint:",
            "body": "\n".join(page.system_blocks()),
        },
        *rate_sections(scene, page.write),
    ]
    if any(re.search(r"\d\.\d", section["body"]) for section in sections):
        sections[0]["text"] += f" Decimal numbers are rounded to {digits_or(DIGITS)} digits."
    if not document:
        return "\n\n".join(f"\\paragraph{{{s['title']}.}} {s['text']}\n{s['body']}" for s in sections)
    from symdyn.emit.render import render

    symbols = [*page.symbol_rows(), *symbol_table(scene, page.write, page.timed)]
    title, values = in_latex(scene.name), any(row["value"] for row in symbols)
    inside = {"title": title, "comment": scene.name, "sections": sections, "symbols": symbols, "values": values}
    return render("latex/equations.tex.jinja", inside)


BRACKETS = 60.0  # of the three matrices of the system, with what stands between them


class _Page:
    """The pieces of the page."""

    def __init__(self, scene: Scene, system: Equilibrium) -> None:
        self.scene, self.system = scene, system
        self.forms = forms_of(system)
        lengths = [one.name for one in self.forms.lengths.named]
        self.write = Latex(latex_symbols(scene, (), lengths) | {TIME: TIME}, digits_or(DIGITS))
        nodes = reachable([*system.right(), *(x for block in system.blocks.values() for part in block for x in part)])
        self.timed = any(node.value == TIME for node in nodes)
        self.names = [self._name(unknown) for unknown in system.unknowns]
        self.axes = [("F", "xyz"[k]) if k < 3 else ("M", "xyz"[k - 3]) for k in system.kept]

    # Unknowns

    def _name(self, unknown: Unknown) -> str:
        joint = _upright(unknown.joint)
        if unknown.is_drive:
            one = next(joint for joint in self.scene.joints if joint.name == unknown.joint)
            drive = one.drives[unknown.number] if unknown.number < len(one.drives) else None
            return self.write.symbols.get(drive or "", "") or rf"\tau_{{{joint},{unknown.number + 1}}}"
        if unknown.is_reaction:
            words = self.system.direction(unknown)
            if words[-2:] in (" x", " y", " z"):
                return f"{'F' if words.startswith('force') else 'M'}_{{{joint},{words[-1]}}}"
        return rf"R_{{{joint},{unknown.number + 1}}}"

    def symbol_rows(self) -> Iterator[dict[str, str]]:
        """Yield the rows of the unknowns for the table of symbols; drives have their own."""
        for name, unknown in zip(self.names, self.system.unknowns, strict=True):
            if not unknown.is_drive:
                words = self.system.direction(unknown) or f"component {unknown.number + 1}"
                yield symbol_row(
                    name,
                    f"{words} of the {unknown.kind} in joint {unknown.joint}, joint axes",
                    self.scene.shown_unit("N m" if words.startswith("moment") else "N"),
                )

        for one in self.forms.lengths.named:
            yield symbol_row(self.write.symbols[one.name], one.text, self.scene.shown_unit("m"))

    def count(self) -> str:
        system, scene = self.system, self.scene
        a_body = len(system.kept)
        counts = [one.joint for one in system.unknowns if not one.is_drive]
        joints = ", ".join(
            f"{in_latex(joint.name)} ({joint.type.replace('_', ' ')}, $t = {counts.count(joint.name)}$)"
            for joint in (*scene.joints, *scene.loops)
        )
        flat = "The mechanism moves in a plane: three equations a body, and $t$ counts what lies in the plane. "
        plane = flat if a_body == 3 else ""
        return (
            f"{plane}The ground is body 0 (body 1 in the textbook). Joints: {joints}. "
            rf"(5.18) gives ${a_body}(u-1) = {a_body} \cdot {len(system.bodies)} = {system.equations}$ equations; "
            rf"(5.19) counts $m_R = \sum t\,s_t = {system.reactions}$ reactions, and there are $n = {system.drives}$ "
            rf"unknown drives{self._passive()}: "
            rf"${system.equations} {'=' if system.equations == len(system.unknowns) else chr(92) + 'ne'} "
            rf"{system.drives} + {system.reactions}$ (5.20)."
        )

    def _passive(self) -> str:
        """Return which unknown drives the scene does not have, "" for none."""
        names = [one.joint for one in self.system.passive]
        if not names:
            return ""
        where = ", ".join(map(in_latex, dict.fromkeys(names)))
        closed = self.scene.is_constrained
        what = "degrees of freedom that nothing drives, such as an idle spin" if closed else "joints without a drive"
        return f", {len(names)} of them of {what} ({where}), where zero comes out for the motion that is free there"

    def unknown_vector(self) -> list[str]:
        if len(self.names) <= 9:
            return list(align([["& " + rf"x = \begin{{bmatrix}} {' & '.join(self.names)} \end{{bmatrix}}^T"]]))
        return list(align([[f"& {', '.join(self.names[k : k + 9])}"] for k in range(0, len(self.names), 9)]))

    # Bodies

    def bodies(self) -> Iterator[dict[str, str]]:
        """Yield a section a body: its bivectors, which add up to zero."""
        for j, (body, known) in enumerate(zip(self.scene.bodies, self.system.bodies, strict=True)):
            here = self.index(j)
            displays = self.bivector("A", here, [self.forms(x) for x in self.system.written(known.action)])
            displays += self.bivector("D", here, [self.forms(x) for x in self.system.written(known.inertia)])
            for h, other in enumerate(self.system.hanging.hinges):
                forces = self.unknowns_on(j, h)
                if forces is not None:
                    displays += self.bivector(
                        *(("R", here) if h == j else ("*R", self.index(j, other.joint.name))), forces
                    )
            joint = in_latex(self.system.hanging.joints[j].joint.name)
            number = Letters.body_number(j)
            yield {
                "title": f"Body {number}: {in_latex(body.name)}",
                "text": f"Frame {number} has the axes of the body and its origin in its reference joint {joint}.",
                "body": "\n".join(displays),
            }

    def index(self, j: int, joint: str = "") -> str:
        """Return the index of a bivector of body j: jj, or j and the joint."""
        number = str(Letters.body_number(j))
        return f"{number},{_upright(joint)}" if joint else number + ("," if len(number) > 1 else "") + number

    def unknowns_on(self, j: int, h: int) -> list[Form] | None:
        """Return what the unknowns in joint h exert on body j; None for nothing."""
        present = [
            u for u, one in enumerate(self.system.unknowns) if (j, u) in self.system.blocks and one.acts[0][0] == h
        ]
        columns = [self.system.written(self.system.blocks[j, u]) for u in present]
        rows = zip(*columns, strict=True)
        sizes = [Symbol(self.names[u]) for u in present]
        return [
            Form.sum(Form.product((self.forms(x), size)) for x, size in zip(row, sizes, strict=True)) for row in rows
        ] or None

    def bivector(self, kind: str, index: str, entries: Sequence[Form]) -> list[str]:
        """Return one bivector as a column, or component by component where it is too wide."""
        write = Latex({**self.write.symbols, **{name: name for name in self.names}}, digits_or(DIGITS))
        column = BMatrix([[write.unbroken(entry)] for entry in entries])
        if column.width + 60 < LINE:
            return list(align([[rf"& \bar F^{{{kind}}}_{{{index}}} = {column}"]]))
        named = zip(self.axes, entries, strict=True)
        return definitions(
            [(f"{letter}^{{{kind}}}_{{{index},{axis}}}", write(entry)) for (letter, axis), entry in named]
        )

    # The system

    def system_blocks(self) -> list[str]:
        """Return the pattern of blocks, then every block, then b."""
        joints = [hinge.joint.name for hinge in self.system.hanging.hinges]
        columns: list[list[int]] = [[] for _ in joints]
        for u, unknown in enumerate(self.system.unknowns):
            columns[unknown.acts[0][0]].append(u)
        present = [h for h, us in enumerate(columns) if us]
        names = {
            (j, h): f"A_{{{self.index(j, joints[h])}}}"
            for j in range(len(self.system.bodies))
            for h in present
            if any((j, u) in self.system.blocks for u in columns[h])
        }
        bodies = range(len(self.system.bodies))
        pattern = BMatrix([[names.get((j, h), "0") for h in present] for j in bodies])
        x = BMatrix([[f"x_{{{_upright(joints[h])}}}"] for h in present])
        b = BMatrix([[rf"b_{{{Letters.body_number(j)}}}"] for j in bodies])
        lines = [[f"& {pattern} {x} + {b} = 0"]]
        if pattern.width + x.width + b.width + BRACKETS > LINE:
            products = [
                [f"{names[j, h]} {x.rows[k][0]}" for k, h in enumerate(present) if (j, h) in names] for j in bodies
            ]
            lines = [Line().broken("", f" {BREAK}+ ".join([*products[j], b.rows[j][0]]), "= 0") for j in bodies]
        displays = list(align(lines))
        for (j, h), name in names.items():
            zero = self.system.hanging.graph.zero
            entries = [
                self.system.written(self.system.blocks.get((j, u), ((zero,) * 3, (zero,) * 3))) for u in columns[h]
            ]
            matrix = BMatrix([[self.write.unbroken(self.forms(x)) for x in row] for row in zip(*entries, strict=True)])
            if matrix.width + 60 < LINE:
                displays += align([[f"& {name} = {matrix}"]])
            else:
                index = self.index(j, joints[h])
                places = [(r, c, x) for r, row in enumerate(zip(*entries, strict=True)) for c, x in enumerate(row)]
                written = [
                    (f"A_{{{index};{r + 1},{c + 1}}}", self.write(self.forms(x))) for r, c, x in places if not x.is_zero
                ]
                displays += definitions(written)
        displays += align([[r"& b_j = \bar F^A_{jj} + \bar F^D_{jj}"]])
        defined = [pair for one in self.forms.lengths.named for pair in one.defined]
        where = definitions([(self.write.symbols[name], self.write(form)) for name, form in defined])
        return [*displays, *(["where", *where] if defined else [])]


def _upright(name: str) -> str:
    return rf"\mathrm{{{in_latex(name)}}}"
