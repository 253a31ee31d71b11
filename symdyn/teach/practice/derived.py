"""What a student derives in SymPy against symdyn's own: energies, momenta, slopes, equations of one scene.

Who sees no derivation is given joints and masses with all coordinates zero, in axes of the ground. What a student
writes in SymPy becomes a node of a graph.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

from symdyn.algebra import NAMES, Form
from symdyn.dynamics import Energies
from symdyn.dynamics.mechanism import State, body_placements, vector
from symdyn.emit.print import text_of
from symdyn.errors import TeachError, choice
from symdyn.graph import Expr, Graph, Op, substitute, tangents
from symdyn.scene import Scene
from symdyn.spatial import Mat
from symdyn.table import Table
from symdyn.teach.derivations.short_sines import shortest
from symdyn.teach.document import Document, Step, Words
from symdyn.teach.languages import fill, language_of
from symdyn.teach.lesson import AXES, Mass, masses
from symdyn.unlocked import cached_property
from symdyn.verdict import Verdict
from symdyn.verify import Claim, prove


def sympy_to_graph(expression: Any, graph: Graph, coordinates: Sequence[str]) -> Expr:
    """Return a SymPy expression as a node: symbols by name, q(t) as q, its derivatives as q_dot and q_ddot.

    Args:
        expression: of SymPy, or a number.
        graph: where the node shall live.
        coordinates: the functions of t that it may hold.

    Raises:
        TeachError: something in it has no meaning on a graph; the message says what.
    """
    import sympy

    functions = {getattr(sympy, name): op for op, name in NAMES.items() if op is not Op.SQRT}
    made: dict[Any, Expr] = {}

    def power(base: Expr, exponent: Any) -> Expr:
        if not (exponent.is_Rational and exponent.q in (1, 2)):
            raise TeachError(f"a power of {exponent} has no place here; exponents are whole numbers and halves")
        found = (base if exponent.q == 1 else graph.sqrt(base)) ** abs(int(exponent.p))
        return found if exponent.p > 0 else graph.one / found

    def node(x: Any) -> Expr:
        if x.is_Symbol:
            return graph.symbol(x.name)
        if x.is_Rational or x.is_Float:
            return graph.constant(Fraction(str(x)))
        if x is sympy.pi:
            return graph.pi
        moving = x.expr if x.is_Derivative else x
        if isinstance(moving, sympy.core.function.AppliedUndef) and moving.func.__name__ in coordinates:
            order = x.derivative_count if x.is_Derivative else 0
            if order <= 2:
                return graph.symbol(f"{moving.func.__name__}{('', '_dot', '_ddot')[order]}")
        args = [made[arg] for arg in x.args] if not x.is_Derivative and all(arg in made for arg in x.args) else []
        if x.is_Add:
            return graph.total(args)
        if x.is_Mul:
            product = graph.one
            for arg in args:
                product = product * arg
            return product
        if x.is_Pow:
            return power(args[0], x.exp)
        if x.func is sympy.tan:
            return graph.sin(args[0]) / graph.cos(args[0])
        if x.func in functions and args:
            return graph.function(functions[x.func], *args)
        raise TeachError(f"{x} has no meaning here; write it in the symbols of the scene")

    def visit(x: Any) -> None:
        if x in made:
            return
        if not x.is_Derivative and not isinstance(x, sympy.core.function.AppliedUndef):
            for arg in x.args:
                visit(arg)
        made[x] = node(x)

    whole = sympy.sympify(expression)
    visit(whole)
    return made[whole]


LONGEST = 600  # characters of a difference that is told


class Derived:
    """The quantities of a scene by name, to compare SymPy expressions with.

    Names are x1, y1, z1 of each mass, K, P, L, dL/dq1_dot, d/dt dL/dq1_dot, dL/dq1, equation 1, k_z 1,2. Symbols of an
    expression go by their names; coordinates are functions of t, q1(t), velocities and accelerations their derivatives.
    """

    def __init__(self, scene: Scene, language: str = "en") -> None:
        """Put the scene on a graph."""
        self.scene, self.words = scene, language_of(language).lesson
        self.graph = Graph()
        for parameter in scene.parameters:  # first, which is the order that forms print
            self.graph.symbol(parameter.name)
        self.energies = Energies.of(scene, self.graph)
        self.state = self.energies.state

    @cached_property
    def values(self) -> Mapping[str, Expr]:
        """What every name is worth."""
        state, found = self.state, dict[str, Expr]()
        for mass in masses(self.scene, self.graph, body_placements(self.scene, self.graph)):
            found |= {f"{axis}{mass.tag}": node for axis, node in zip(AXES, mass.place, strict=True)}
        found |= {"K": self.energies.K, "P": self.energies.P, "L": self.energies.K - self.energies.P}
        p, slopes = self.energies.momenta(), self.energies.directions.slopes(found["L"])
        rates, drives = tangents(p, state.acceleration), self.energies.driving_forces()
        for i, (q, u) in enumerate(zip(self.scene.coordinates, self.scene.velocities, strict=True)):
            found |= {f"dL/d{u}": p[i], f"d/dt dL/d{u}": rates[i], f"dL/d{q}": slopes[i]}
            found[f"equation {i + 1}"] = drives[i]
        for i, row in enumerate(self.energies.mass_matrix(), 1):
            found |= {f"k_z {i},{j}": x for j, x in enumerate(row, 1)}
        return found

    def compare(self, name: str, expression: Any) -> None:
        """Print whether an expression is what symdyn has under a name, else what is too much in it.

        Raises:
            TeachError: there is no such name, or something in the expression has no meaning here.
        """
        if name not in self.values:
            raise TeachError(f"there is no {name!r}; {choice(name, self.values)}")
        mine, right = sympy_to_graph(expression, self.graph, self.scene.coordinates), self.values[name]
        finding = prove([Claim(name, "yours", "symdyn's", (mine,), (right,))])[1][0]
        keys: dict[str, str] = {Verdict.PROVED: "derived.proved", Verdict.NUMERICAL: "derived.numerical"}
        key = keys.get(finding.verdict, "derived.different")
        print(self.words[key].format(name=name))
        if key == "derived.different" and (more := shortest(mine - right, self.scene, self.state)) is not None:
            text = text_of(more)
            print(self.words["derived.more"].format(difference=text if len(text) <= LONGEST else f"{text[:LONGEST]} …"))


ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Of an inertia: xx, yy, zz, xy, xz, yz."""


def with_given(document: Document) -> Document:
    """Return the document with a step at the end of its first section that says where everything is at zero.

    A scene with quaternions, which are never all zero, is returned as it is.
    """
    if any(joint.velocities for joint in document.scene.joints):
        return document
    first, *others = document.sections
    shown = replace(first, steps=(*first.steps, _given(document.scene, document.language)))
    return replace(document, sections=(shown, *others))


def _given(scene: Scene, language: str) -> Step:
    texts, graph = language_of(language).lesson, Graph()
    for parameter in scene.parameters:  # first, which is the order that forms print
        graph.symbol(parameter.name)
    state = State.of(scene, graph)
    zero = dict.fromkeys(state.q, graph.zero)
    placed = body_placements(scene, graph)

    def row(nodes: Sequence[Expr]) -> Words:
        """Return numbers at zero in brackets."""
        forms: list[Form] = [shortest(x, scene, state) or Form.of(x) for x in substitute(list(nodes), zero)]
        parts = [part for form in forms for part in (", ", form)]
        return Words(("(", *parts[1:], ")"))

    joints = []
    for joint in (*scene.joints, *scene.loops):
        T = placed[joint.parent] @ joint.origin.transform(graph)
        axis = row(T.R @ vector(joint.axis, graph)) if "axis" in dict(joint.shape) else Words(())
        joints.append((Words((joint.name,)), row(T.p), axis))
    bodies = []
    for mass in masses(scene, graph, placed):
        at = row(mass.place)
        if mass.h is not None:
            at = Words(fill(texts["given.moment"], {"place": at, "moment": row(mass.h)}))
        m = Words((Form.of(mass.m),))
        inertia = row(_turned(mass, placed[mass.body.name].R, graph)) if mass.spins else Words(("0",))
        bodies.append((Words((f"{mass.tag} {mass.body.name}",)), m, at, inertia))
    heads = [[Words((texts[key],)) for key in keys] for keys in (
        ("table.joint", "given.through", "turning.axis"), ("given.body", "given.mass", "given.at", "given.inertia"),
    )]  # fmt: skip
    tables = (Table(tuple(heads[0]), tuple(joints)), Table(tuple(heads[1]), tuple(bodies)))
    reason = texts["given.closed" if scene.loops else "given.reason"]
    return Step("given", Words((texts["given"],)), tables, Words((reason,)))


def _turned(mass: Mass, R: Mat, graph: Graph) -> list[Expr]:
    """Return the entries of an inertia along the axes of the ground, R I Rᵀ."""
    columns = [R @ (mass.inertia @ (R.T @ e)) for e in Mat.identity(graph)]
    return [columns[j][i] for i, j in ENTRIES]
