"""A document as a Jupyter notebook, one file: prose, pictures, and cells that read the scene and check its formulas.

Cells may derive a scene's equations in SymPy, for a student to change: places, energies, Lagrange's equations. Names of
bodies and joints stand in no cell; letters of the scene do, which are identifiers, with an underscore behind what
Python, SymPy or a cell calls something else.
"""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

from symdyn.algebra import NAMES
from symdyn.dynamics import rotor_energy
from symdyn.dynamics.mechanism import State, elastic_energy, generalized_forces, joint_placement, vector
from symdyn.emit import in_code, in_markdown
from symdyn.emit.code import SYMPY, page_stem
from symdyn.emit.print import text_of
from symdyn.graph import Expr, Graph, Op, reachable
from symdyn.scene import Scene, write_text
from symdyn.scene.values import Body
from symdyn.spatial import Mat, Transform
from symdyn.teach.document import Blank, Block, Document, Formula, Picture, Questions, Step
from symdyn.teach.languages import language_of
from symdyn.teach.lesson import AXES, masses
from symdyn.teach.practice.exercises import answer_of
from symdyn.teach.practice.questions import solutions_last
from symdyn.teach.render.markdown import Page
from symdyn.unlocked import cached_property

MOST = 4
"""Velocities up to which SymPy is quick."""

FEW = 2
"""Velocities up to which SymPy simplifies a matrix in seconds."""

TAKEN = (
    "Derived", "Function", "Matrix", "Rational", "check", "check_derivation", "derived", "hessian", "in_words",
    "lesson", "pi", "read_text", "scene", "simplify", "symbols", "t",
)  # fmt: skip
"""What cells call something; K, P, L and names such as R1, m1 of places and energies come on top."""


def derivable(scene: Scene) -> bool:
    """Whether cells derive a scene: its velocities are rates of coordinates, and there are few."""
    return len(scene.velocities) <= MOST and not any(joint.velocities for joint in scene.joints)


class Cells:
    """The cells of one scene, by the section of the lesson that they belong to."""

    def __init__(self, scene: Scene) -> None:
        """Find names for its letters."""
        self.scene, self.graph = scene, Graph()
        self.state = State.of(scene, self.graph)
        self.letters = [one.name for one in scene.parameters]

    @cached_property
    def own(self) -> set[str]:
        """The names that cells define."""
        numbers = range(1, len(self.scene.bodies) + 1)
        found = {*TAKEN, *NAMES.values(), "K", "P", "L", "M"}
        found |= {f"{letter}{k}" for k in numbers for letter in ("R", "o", "W", "omega")}
        found |= {f"{letter}{tag}" for tag in self.tags.values() for letter in ("r", "v", "K", "P")}
        n = range(1, len(self.scene.velocities) + 1)
        return found | {f"{word}{i}" for i in n for word in ("momentum", "slope", "equation", "Q")}

    @cached_property
    def tags(self) -> Mapping[tuple[str, int], str]:
        """The part of a name that stands for a mass, by body and the number of the mass in it."""
        placed = {body.name: Transform.unit(self.graph) for body in self.scene.bodies}
        found: dict[tuple[str, int], str] = {}
        for mass in masses(self.scene, self.graph, placed):
            count = sum(name == mass.body.name for name, _ in found)
            found[mass.body.name, count] = mass.tag
        return found

    @cached_property
    def variables(self) -> Mapping[str, str]:
        """What every symbol of the scene is called in cells."""
        found, taken = dict[str, str](), set(self.own)
        for name in (*self.letters, *self.scene.coordinates):
            called = name
            while called in taken:
                called += "_"
            taken.add(called)
            found[name] = called
        for q, u, a in zip(self.scene.coordinates, self.state.qd, self.state.qdd, strict=True):
            found |= {str(u.value): f"{found[q]}.diff(t)", str(a.value): f"{found[q]}.diff(t, 2)"}
        return found | {"t": "t"}

    def text(self, node: Expr) -> str:
        """Return a node as Python."""
        nodes = reachable([node])
        names = {x: self.variables[str(x.value)] for x in nodes if x.op is Op.SYMBOL}
        constants = {x: Fraction(str(x.value)) for x in nodes if x.op is Op.CONSTANT}
        return SYMPY.code(node, names, constants)

    def matrix(self, rows: Sequence[Sequence[Expr]]) -> str:
        """Return a matrix as Python; a column as a list."""
        if all(len(row) == 1 for row in rows):
            return f"Matrix([{', '.join(self.text(row[0]) for row in rows)}])"
        return f"Matrix([{', '.join('[' + ', '.join(map(self.text, row)) + ']' for row in rows)}])"

    # The cells

    def symbols(self) -> str:
        """Return what defines the letters."""
        v = self.variables
        lines = ["from sympy import *", "", 't = symbols("t")']
        if self.letters:
            lines.append(f'{", ".join(v[x] for x in self.letters)} = symbols("{" ".join(self.letters)}")')
        lines += [f'{v[q]} = Function("{q}")(t)' for q in self.scene.coordinates]
        return "\n".join(lines)

    def places(self) -> str:
        """Return where bodies and masses are."""
        lines, graph = [], self.graph
        number = {body.name: k for k, body in enumerate(self.scene.bodies, 1)}
        for joint in self.scene.joints:
            k, p = number[joint.child], number.get(joint.parent)
            T = joint_placement(joint, graph)
            R, o = self.matrix(T.R), self.matrix([[x] for x in T.p])
            if joint.parent == Scene.GROUND:
                lines += [f"R{k} = {R}", f"o{k} = {o}"]
            else:
                lines += [f"R{k} = R{p} * {R}", f"o{k} = o{p} + R{p} * {o}"]
            lines += self._masses(self.scene.bodies[k - 1], k)
        lines += [f'derived.compare("{axis}{tag}", r{self._plain(tag)}[{j}])'
                  for tag in self.tags.values() for j, axis in enumerate(AXES)]  # fmt: skip
        return "\n".join(lines)

    def _masses(self, body: Body, k: int) -> list[str]:
        lines = []
        for count, at in enumerate(self._places(body)):
            tag = self._plain(self.tags[body.name, count])
            lines.append(f"r{tag} = o{k}" if at is None else f"r{tag} = o{k} + R{k} * {self.matrix([[x] for x in at])}")
        return lines

    def _extended(self, body: Body) -> bool:
        own = sum(name == body.name for name, _ in self.tags)
        return own > len(body.particles)

    def _places(self, body: Body) -> list[Sequence[Expr] | None]:
        """Return the places of masses in the body; None for its origin."""
        found: list[Sequence[Expr] | None] = []
        if self._extended(body):
            found.append(vector(body.com, self.graph) if body.com is not None and self._central(body) else None)
        return [*found, *(vector(one.at, self.graph) for one in body.particles)]

    @staticmethod
    def _central(body: Body) -> bool:
        """Whether the place of its extended mass is the centre of mass; else it is the frame's origin."""
        return body.about == "com" and body.com is not None

    def energies(self) -> str:
        """Return K and P, mass by mass."""
        graph, scene = self.graph, self.scene
        gravity = self.matrix([[x] for x in vector(scene.gravity, graph)])
        lines, kinetic, potential = list[str](), list[str](), list[str]()
        for k, body in enumerate(scene.bodies, 1):
            for count, _ in enumerate(self._places(body)):
                tag = self._plain(self.tags[body.name, count])
                first = self._extended(body) and count == 0
                mass = body.mass if first else body.particles[count - self._extended(body)].mass
                m = self._factor(mass.express(graph))
                lines.append(f"v{tag} = r{tag}.diff(t)")
                turned = [f"W{k} = R{k}.T * R{k}.diff(t)", f"omega{k} = Matrix([W{k}[2, 1], W{k}[0, 2], W{k}[1, 0]])"]
                terms, down = [f"{m} * v{tag}.dot(v{tag}) / 2"], f"{m} * r{tag}"
                inertia = Mat.symmetric(*(x.express(graph) for x in body.inertia))
                if first and not all(x.is_zero for row in inertia for x in row):
                    lines += turned
                    terms.append(f"omega{k}.dot({self.matrix(inertia)} * omega{k}) / 2")
                if first and not self._central(body):
                    h = f"R{k} * {self.matrix([[x] for x in body.mass_moment(graph)])}"
                    lines += [line for line in turned if line not in lines]
                    terms.append(f"v{tag}.dot(R{k} * W{k} * R{k}.T * {h})")
                    down += f" + {h}"
                lines += [f"K{tag} = {' + '.join(terms)}", f"P{tag} = -{gravity}.dot({down})"]
                kinetic.append(f"K{tag}")
                potential.append(f"P{tag}")
        for joint in scene.joints:
            if joint.moves and not joint.armature.express(graph).is_zero:
                kinetic.append(self.text(rotor_energy(joint, self.state.velocity, graph)))
        springs = elastic_energy(scene, graph)
        potential += [] if springs.is_zero else [self.text(springs)]
        lines += ["", f"K = {' + '.join(kinetic) or '0'}", f"P = {' + '.join(potential) or '0'}"]
        return "\n".join([*lines, 'derived.compare("K", K)', 'derived.compare("P", P)'])

    def lagrangian(self) -> str:
        """Return L."""
        return 'L = K - P\nderived.compare("L", L)'

    def equation(self, i: int) -> str:
        """Return Lagrange's equation of coordinate i, from 0."""
        q, u, n = self.scene.coordinates[i], self.scene.velocities[i], i + 1
        name, force = self.variables[q], generalized_forces(self.scene, self.graph)[i]
        less = "" if force.is_zero else f" - Q{n}"
        lines = [f"momentum{n} = L.diff({name}.diff(t))", f"slope{n} = L.diff({name})"]
        lines += [] if force.is_zero else [f"Q{n} = {self.text(force)}"]
        lines += [
            f"equation{n} = momentum{n}.diff(t) - slope{n}{less}",
            f'derived.compare("dL/d{u}", momentum{n})',
            f'derived.compare("d/dt dL/d{u}", momentum{n}.diff(t))',
            f'derived.compare("dL/d{q}", slope{n})',
            f'derived.compare("equation {n}", equation{n})',
        ]
        return "\n".join(lines)

    def coefficients(self) -> str:
        """Return what multiplies the accelerations."""
        n = range(1, len(self.scene.velocities) + 1)
        rates = ", ".join(self.variables[u] for u in self.scene.velocities)
        lines = [f"M = hessian(K, [{rates}])"]
        lines += [f'derived.compare("k_z {i},{j}", M[{i - 1}, {j - 1}])' for i in n for j in n if j >= i]
        return "\n".join([*lines, *["M.applyfunc(simplify)"][: len(n) <= FEW]])

    def _factor(self, node: Expr) -> str:
        text = self.text(node)
        return text if text.isidentifier() or text.isdigit() else f"({text})"

    @staticmethod
    def _plain(tag: str) -> str:
        return tag.replace(",", "_")


Cell = dict[str, Any]

SETUP = '''from symdyn.scene import read_text
from symdyn.teach import check_derivation, in_words

scene = read_text({scene})


def check(text):
    """Compare formulas, plain text or LaTeX, with those of the scene."""
    for answer in check_derivation(text, scene):
        print("\\n".join(in_words(answer, {language!r})))'''

DERIVED = """from symdyn.teach.practice.derived import Derived

derived = Derived(scene, {language!r})
"""

EXERCISES = """

from symdyn.teach import walkthrough
from symdyn.teach.practice.exercises import judge, with_exercises

lesson = with_exercises(walkthrough(scene, {language!r}, formulation={formulation!r}))"""


def notebook(document: Document) -> dict[str, str]:
    """Return the one file by name."""
    cells = list(_cells(document))
    names = [re.sub(r"[^A-Za-z0-9_-]+", "-", cell["id"])[:60] for cell in cells]
    for k, (cell, name) in enumerate(zip(cells, names, strict=True)):
        cell["id"] = name if names.count(name) == 1 else f"{name[:55]}-{k}"
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    book = {
        "cells": cells,
        "metadata": {"kernelspec": kernel, "language_info": {"name": "python"}, "title": document.title},
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    return {f"{page_stem(document.scene.name)}.ipynb": json.dumps(book, ensure_ascii=False, indent=1) + "\n"}


def _cells(document: Document) -> Iterator[Cell]:
    document = solutions_last(document)
    page = _Page(document)
    yield _text("title", f"# {in_markdown(document.title)}")
    asked = any(isinstance(block, Questions) for _, block in document.blocks())
    setup = (SETUP + EXERCISES if asked else SETUP).format(
        scene=in_code(write_text(document.scene.in_si(), "toml").text),
        language=document.language,
        formulation=document.formulation,
    )
    yield _code("setup", setup)
    keys = {section.key for section in document.sections}
    derived = {} if asked or "questions" in keys else _derivation(document)
    inside = "positions" in keys
    for section in document.sections:
        yield _text(f"section-{section.key}", f"## {in_markdown(section.title)}")
        for step, made_of in document.in_folds(section):
            yield _told(page, step)
            yield from (cell for one in made_of for cell in _run(page, one))
        yield from derived.get(section.key, []) if inside else []
    if derived and not inside:
        yield _text("section-derive", f"## {in_markdown(language_of(document.language).lesson['section.derive'])}")
        yield from (cell for cells in derived.values() for cell in cells)


def _derivation(document: Document) -> dict[str, list[Cell]]:
    """Return the cells that derive the equations in SymPy, by the section that they follow; none of a large scene."""
    if not derivable(document.scene):
        return {}
    texts, cells = language_of(document.language).lesson, Cells(document.scene)
    bodies = ", ".join(f"{k} {body.name}" for k, body in enumerate(document.scene.bodies, 1))
    places = in_markdown(texts["derive.places"].format(bodies=bodies))
    found = {
        "positions": [
            _text("derive-letters", in_markdown(texts["derive.letters"])),
            _code("derive-symbols", f"{DERIVED.format(language=document.language)}\n{cells.symbols()}"),
            _text("derive-where", places),
            _code("derive-places", cells.places()),
        ],
        "energies": [
            _text("derive-energy", in_markdown(texts["derive.energies"])),
            _code("derive-energies", cells.energies()),
        ],
        "lagrangian": [_code("derive-lagrangian", cells.lagrangian())],
        "equations": [
            _text("derive-equation", in_markdown(texts["derive.equations"])),
            *(_code(f"derive-equation-{i + 1}", cells.equation(i)) for i in range(len(document.scene.velocities))),
        ],
    }
    return found | {"coefficients": [_code("derive-coefficients", cells.coefficients())]}


def _told(page: _Page, step: Step) -> Cell:
    """Return the text of a step."""
    reference = f" {in_markdown(step.reference)}" if step.reference else ""
    reason = [page.words(step.reason)] if step.reason.parts else []
    claim = [f"{page.claim(step)}{reference}"] if step.claim.parts or reference else []
    parts = [*claim, *page.blocks(step.blocks), *reason]
    pictures = {f"{block.key}.svg": block.svg for block in step.opened() if isinstance(block, Picture)}
    return _text(f"step-{step.key}", "\n\n".join(parts), pictures)


def _run(page: _Page, step: Step) -> Iterator[Cell]:
    """Yield the cells of a step that can be run."""
    if step.key.startswith("coefficients"):
        results = [block for block in step.blocks if isinstance(block, Formula)]
        found = [answer for block in results if (answer := answer_of(page.document, block)) is not None]
        if found:
            lines = [f"{page.spell.symbols[left]} = {text_of(form)}" for left, form in found]
            yield _code(f"check-{step.key}", f"check({in_code(chr(10).join(lines))})")
    for block in step.blocks:
        if isinstance(block, Questions):
            example = "exercise.example" if isinstance(block, Blank) else "exercise.letters"
            hint = language_of(page.document.language).lesson[example]
            yield _code(f"answer-{block.key}", f'answer = ""  # {hint}\njudge(lesson, {in_code(block.key)}, answer)')


class _Page(Page):
    """Markdown whose pictures are attached to their cells."""

    def block(self, block: Block) -> Iterator[str]:
        if isinstance(block, Picture):
            yield f"![{in_markdown(block.alt)}](attachment:{block.key}.svg)"
            yield f"*{self.words(block.caption)}*"
        else:
            yield from super().block(block)


def _text(key: str, text: str, pictures: dict[str, str] | None = None) -> Cell:
    cell: Cell = {"cell_type": "markdown", "id": key, "metadata": {}, "source": text}
    if pictures:
        cell["attachments"] = {
            name: {"image/svg+xml": base64.b64encode(svg.encode()).decode()} for name, svg in pictures.items()
        }
    return cell


def _code(key: str, text: str) -> Cell:
    return {"cell_type": "code", "execution_count": None, "id": key, "metadata": {}, "outputs": [], "source": text}
