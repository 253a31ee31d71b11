"""A mechanism with loops, rolling or other conditions while its lesson is being written.

    f_k, c_k     what a loop keeps zero; the slip of a contact, which belongs to no f
    A_ki u_i     ḟ_k, or c_k: what a condition says of the velocities
    J_ki         in print, A_ki here
    λ_k          multiplier: the force or moment that keeps condition k, on the child, along its direction

A joint that only keeps two points together is written in the axes of the ground, as one does by hand; other conditions
are the scene's own rows. They are printed in sines, and a root of coordinates, as the sine of a wheel's lean, has a
letter of its own.
"""

from __future__ import annotations

import random
from collections.abc import Sequence

import numpy as np
from scipy.linalg import null_space

from symdyn.algebra import Compactor, Floats, Form, Function, Polynomial, Ratios, Symbol, TrigonometricRing
from symdyn.arguments import argument
from symdyn.dynamics import angle_groups
from symdyn.dynamics.loops import Cut, Partition, differentiated
from symdyn.dynamics.mechanism import quaternions
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Op, evaluate, gradient, reachable, substitute, tangents
from symdyn.scene import Scene
from symdyn.spatial import Vec, sub
from symdyn.teach.derivations.velocities import length
from symdyn.teach.document import Block, Letter
from symdyn.teach.lesson import AXES, Lesson, is_tied, refuse_quaternions
from symdyn.unlocked import cached_property


@dataclass(frozen=True)
class Condition:
    """One condition.

    Attributes:
        number: "1", its index in print.
        owner: name of the loop or of the scene's row.
        loop: whether a loop has it; else a contact or a formula of the scene.
        words: key of the sentence about its multiplier.
        axis: x, y or z in that sentence, or "".
        parent, child: bodies on both sides; "" where there are none.
        residual: what it keeps zero; None where it holds velocities alone.
        slopes: A_ki, shape (nv,).
        bias: Ȧ_ki u_i.
        shown: slopes, bias and residual where they are written in letters of the lesson, else ().
    """

    number: str
    owner: str
    loop: bool
    words: str
    axis: str
    parent: str
    child: str
    residual: Expr | None
    slopes: tuple[Expr, ...]
    bias: Expr
    shown: tuple[Expr, ...] = ()

    @property
    def nodes(self) -> tuple[Expr, ...]:
        """Slopes, bias and residual as they are written."""
        return self.shown or (*self.slopes, self.bias, *(() if self.residual is None else (self.residual,)))

    @property
    def key(self) -> str:
        """Key of its name: f where it holds a position, s where velocities alone."""
        return f"s:{self.number}" if self.residual is None else f"f:{self.number}"

    @property
    def rate(self) -> str:
        """Key of what it says of the velocities."""
        return self.key if self.residual is None else f"df:{self.number}"

    @property
    def acceleration(self) -> str:
        """Key of what it says of the accelerations."""
        return f"d{self.rate}"


class Writer:
    """What writes nodes of conditions: as polynomials in sines, as they stand where they are none."""

    def __init__(self, lesson: Constrained, nodes: Sequence[Expr]) -> None:
        """Make a ring wide enough for the nodes."""
        self.rooted = {x: lesson.graph.symbol(symbol.name) for x, symbol in lesson.roots.items()}
        parallel, state = angle_groups(lesson.scene, lesson.graph, across=True), (*lesson.state.q, *lesson.state.qd)
        state = tuple(dict.fromkeys((*state, *(x for some in lesson.directions for x in some))))
        self.radicands: dict[Expr, Form] = {}
        units = [*lesson.spheres, *lesson.directions]
        self.ring: TrigonometricRing | None = None
        self.squares: list[tuple[int, Polynomial]] = []
        try:
            ring = TrigonometricRing(self._plain([*nodes, *state]), state, parallel, units)
            self.ring, self.compact = ring, Compactor(ring, parallel)
            self.squares = [(ring.symbol(self.rooted[root]), self.polynomial(p)) for root, p in lesson.squares.items()]
            self.radicands = {root: self.short(self.polynomial(root.args[0])) for root in self.rooted}
            for root, symbol in self.rooted.items():
                if root not in lesson.squares:
                    ring.relate_square(ring.symbol(symbol), self.polynomial(root.args[0]))
            for node in nodes:
                self.polynomial(node)
        except DerivationError:
            self.ring = None

    def polynomial(self, node: Expr) -> Polynomial:
        """Return a node as an element of the ring."""
        assert self.ring is not None, "there is a ring"
        (plain,) = self._plain([node])
        return self.reduced(evaluate([plain], self.ring, self.ring.values([plain]))[0])

    def reduced(self, polynomial: Polynomial) -> Polynomial:
        """Return an element with ±p for √p², and nothing that is divided by what it is multiplied by."""
        assert self.ring is not None, "there is a ring"
        for w, p in self.squares:
            polynomial = self.ring.replaced(polynomial, w, p)
        return polynomial

    def __call__(self, node: Expr) -> Form:
        """Return the form of a node."""
        return _quotient(node) if self.ring is None else self.short(self.polynomial(node))

    def short(self, polynomial: Polynomial) -> Form:
        """Return the form of an element of the ring."""
        return self.compact(polynomial)

    def _plain(self, nodes: Sequence[Expr]) -> list[Expr]:
        return substitute(nodes, self.rooted)


def _quotient(node: Expr) -> Form:
    """Return a node as a quotient in lowest terms where that is shorter: slopes of a rope around a wheel."""
    try:
        return min(Form.of(node), Ratios.form_of(node), key=length)
    except (OverflowError, ZeroDivisionError):
        return Form.of(node)


NEAR = 0.3
"""rad or m: how far from the assembled position conditions are looked at."""


class Constrained(Lesson):
    """One mechanism with conditions: the lesson of the tree, and the rows that tie its coordinates."""

    def refuse(self) -> None:
        """Say what this formulation does not take.

        Raises:
            DerivationError: the scene has quaternions, or no conditions.
        """
        refuse_quaternions(self.scene)
        if not is_tied(self.scene):
            idle = (
                "these loops and rows forbid nothing that joints do not" if self.scene.is_constrained else "it is open"
            )
            raise DerivationError(
                f"{self.scene.name}: nothing ties the coordinates ({idle}), so there are no multipliers; "
                f"{argument('formulation', 'lagrange')} shows it"
            )

    @cached_property
    def ties(self) -> tuple[Condition, ...]:
        """The conditions, none that says what others say; DerivationError where nobody knows which those are."""
        return self.tied() if self.scene.is_constrained else ()

    def tied(self) -> tuple[Condition, ...]:
        """Return the conditions of a scene that has some."""
        kept = self.workspace.loops.decisions.independent_rows
        rows = differentiated(self.scene, self.graph, self.state)
        owned = {cut.owner: cut for cut in rows.cuts}
        found: list[Condition] = []
        rods = {joint.name for joint in self.scene.loops if "length" in dict(joint.shape)}
        for owner, loop in dict.fromkeys((rows.labels[k].owner, rows.labels[k].loop) for k in kept):
            own = [k for k in kept if (rows.labels[k].owner, rows.labels[k].loop) == (owner, loop)]
            cut = owned.get(owner)
            gaps = self._gaps(cut) if cut is not None and loop else []
            forces = all((w := rows.labels[k].wrench) is not None and all(x.is_zero for x in w[1]) for k in own)
            if cut is not None and len(gaps) == len(own) and forces:
                found += [self._gap(len(found) + n, cut, axis, gap) for n, (axis, gap) in enumerate(gaps, 1)]
                continue
            for k in own:
                label = rows.labels[k]
                words, axis = self._words(label.name, label.wrench)
                if loop and owner in rods:
                    words, axis = "tie.rod", ""
                sides = (cut.parent, cut.child) if cut is not None else ("", "")
                residual = rows.residual[k] if label.holonomic else None
                found.append(
                    Condition(str(len(found) + 1), owner, loop, words, axis, *sides, residual, rows.G[k], rows.bias[k])
                )
        return tuple(found)

    @cached_property
    def squares(self) -> dict[Expr, Expr]:
        """±p for roots √p² in the conditions, such as that of a wheel's lean in angles; the sign as assembled."""
        found: dict[Expr, Expr] = {}
        for root in self.roots:
            state = (*self.state.q, *self.state.qd)
            try:
                ring = TrigonometricRing([root.args[0], *state], state, (), self.spheres)
            except DerivationError:  # no polynomial
                continue
            p = ring.square_root(evaluate([root.args[0]], ring, ring.values([root.args[0]]))[0])
            if p is None:
                continue
            node = Compactor(ring, ())(p).express(self.graph)
            (value,) = evaluate([node], Floats(), self.assembled(0))
            found[root] = node if value > 0 else -node
        return found

    @cached_property
    def partition(self) -> Partition:
        """Independent and dependent velocities, driven ones independent where that can be."""
        if not self.ties:
            return Partition(tuple(range(self.state.n)), (), ())
        decisions = self.workspace.loops.decisions
        driven = decisions.actuated
        return driven if driven is not None and len(driven.dependent) == len(self.ties) else decisions.partition

    def called(self, key: str, look: Letter, node: Expr | None = None) -> Symbol:
        """Name a quantity, with ±p in its value where it has √p²."""
        return super().called(key, look, node if node is None else self.plain(node))

    def letter(self, key: str, look: Letter, node: Expr) -> Symbol:
        """Name what conditions are written in, before there are any."""
        return super().called(key, look, node)

    def plain(self, node: Expr) -> Expr:
        """Return a node with ±p for √p²."""
        return substitute([node], self.squares)[0] if self.squares else node

    def assembled(self, seed: int) -> dict[Expr, float]:
        """Return parameters and coordinates where the mechanism is assembled, or for other seeds near there."""
        loops, rng = self.workspace.loops, random.Random(seed)
        q = [x + (rng.uniform(-NEAR, NEAR) if seed else 0.0) for x in loops.decisions.assembly.q]
        return {self.graph.symbol(str(x.value)): value for x, value in loops.values(q).items()}

    @cached_property
    def integrable(self) -> bool:
        """Whether what holds velocities alone is the derivative of conditions of positions, perhaps times a factor.

        By Frobenius: A_k [X, Y] = 0 for all velocities X, Y that the conditions allow; looked at in some places.
        """
        n, graph = self.state.n, self.graph
        along = [[x for a in tie.slopes for x in self.energy.directions.slopes(a)] for tie in self.ties]
        turned = [[graph.zero] * (n * n) for _ in self.ties]  # A_kl γ^l_ij
        for (i, j), terms in self.energy.directions.brackets.items():
            for m, value in terms:
                for k, tie in enumerate(self.ties):
                    turned[k][n * i + j] = turned[k][n * i + j] + value * tie.slopes[m]
        for seed in range(1, 4):
            values = self.assembled(seed)
            A = np.array(evaluate([x for tie in self.ties for x in tie.slopes], Floats(), values)).reshape(-1, n)
            free = null_space(A, rcond=1e-9)
            for slopes, bracket in zip(along, turned, strict=True):
                D = np.array(evaluate(slopes, Floats(), values)).reshape(n, n)  # [j, i]: X_i A_kj
                B = np.array(evaluate(bracket, Floats(), values)).reshape(n, n)
                if np.abs(free.T @ (D.T - D + B) @ free).max(initial=0.0) > 1e-7 * (1 + np.abs(A).max()):
                    return False
        return True

    def _gaps(self, cut: Cut) -> list[tuple[str, Expr]]:
        """Return the way from the point on the parent to that on the child, by axis of the ground."""
        child, parent = self.placed[cut.child].point(cut.on_child.p), self.placed[cut.parent].point(cut.on_parent.p)
        return [(axis, gap) for axis, gap in zip(AXES, sub(child, parent), strict=True) if not gap.is_zero]

    def _gap(self, number: int, cut: Cut, axis: str, gap: Expr) -> Condition:
        slopes = tuple(self.energy.directions.slopes(gap))
        (bias,) = tangents(tangents([gap], self.state.velocity), self.state.velocity)
        return Condition(str(number), cut.owner, True, "tie.force", axis, cut.parent, cut.child, gap, slopes, bias)

    def _words(self, name: str, wrench: tuple[Vec, Vec] | None) -> tuple[str, str]:
        """Return the key of the sentence about a multiplier, and its axis."""
        if name:
            return f"tie.{name}", ""
        if wrench is None:
            return "tie.formula", ""
        force, moment = wrench
        kind, way = ("force", force) if all(x.is_zero for x in moment) else ("moment", moment)
        if kind == "moment" and not all(x.is_zero for x in force):
            return "tie.both", ""
        along = [axis for axis, x in zip(AXES, way, strict=True) if not x.is_zero]
        constant = not set(self.state.q).intersection(reachable(way))
        return (f"tie.{kind}.joint", along[0]) if constant and len(along) == 1 else (f"tie.{kind}.moving", "")

    @cached_property
    def spheres(self) -> list[list[Expr]]:
        """The coordinates of every unit quaternion."""
        return [[self.graph.symbol(name) for name in names] for names in quaternions(self.scene)]

    def introduced(self, owner: str) -> list[Block]:
        """Return what is said of the letters in which a loop or contact is written."""
        return []

    def without_inertia(self, i: int, j: int) -> bool:
        """Tell whether entry ij of the mass matrix vanishes."""
        return not self.forms.form("k_z", i, j).terms

    @property
    def directions(self) -> list[list[Expr]]:
        """Letters for unit vectors in which conditions are written."""
        return []

    def body(self, name: str) -> str:
        """Return a body's name in prose."""
        return self.text("ground") if name == Scene.GROUND else name

    # Forms

    def tie_form(self, node: Expr) -> Form:
        """Return a part of a condition as short as can be, in sines of sums of angles across loops."""
        return self.writer(node)

    @cached_property
    def turning(self) -> dict[str, list[tuple[int, int, Expr]]]:
        """Coefficients of products of velocities in f̈_k, j <= k, by the tie's number; none that vanishes."""
        found: dict[str, list[tuple[int, int, Expr]]] = {}
        for tie in self.ties:
            slopes = gradient(tie.nodes[self.state.n], self.state.qd)
            found[tie.number] = [
                (j, k, second / 2 if j == k else second)
                for j, first in enumerate(slopes)
                for k, second in enumerate(gradient(first, self.state.qd))
                if j <= k and not second.is_zero
            ]
        return found

    @cached_property
    def roots(self) -> dict[Expr, Symbol]:
        """Letters for roots of coordinates in the conditions, such as the sine of a wheel's lean."""
        found = self._roots([x for tie in self.ties for x in tie.nodes[: self.state.n + 1]])
        index = [(str(k),) if len(found) > 1 else () for k in range(1, len(found) + 1)]
        symbols = [Symbol(f"root:{k}") for k in range(len(found))]
        letters = {x: self.names[str(x.value)].node for some in self.directions for x in some}
        known = {x: node for x, node in letters.items() if node is not None}
        for symbol, node, below in zip(symbols, substitute(found, known), index, strict=True):
            self.letter(symbol.name, Letter("w", below), node)
        return dict(zip(found, symbols, strict=True))

    def roots_of(self, ties: Sequence[Condition]) -> list[Expr]:
        """Return the roots of coordinates in some conditions."""
        return self._roots([x for tie in ties for x in tie.nodes[: self.state.n]])

    def _roots(self, nodes: Sequence[Expr]) -> list[Expr]:
        moving = {*self.state.q, *(x for some in self.directions for x in some)}
        return [x for x in reachable(nodes) if x.op is Op.SQRT and moving.intersection(reachable([x]))]

    def root_form(self, root: Expr) -> Form:
        """Return what a root is of, as short as can be."""
        return Function(Op.SQRT, (self.writer.radicands.get(root, Form.of(root.args[0])),))

    @cached_property
    def writer(self) -> Writer:
        """What writes conditions."""
        nodes = [x for tie in self.ties for x in tie.nodes]
        nodes += [node for some in self.turning.values() for _, _, node in some]
        nodes += [root.args[0] for root in self.roots]
        return Writer(self, [*nodes, *self.squares.values()])
