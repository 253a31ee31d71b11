"""Both methods side by side, term by term: Lagrange's coefficients, and what each body gives for them.

Along the motion of coordinate i alone, joints transmit no power but the drive's, so (5.18) of all bodies, each times
its velocity for q̇_i = 1, leaves

    M_i = -Σ_j (F^D_j · ∂v_j/∂q̇_i + M^D_j · ∂ω_j/∂q̇_i + m_j g · ∂v_Tj/∂q̇_i)      v_j of O_j; frame j

which is sorted by accelerations and products of rates. Lagrange's column comes from the closed forms of (5.21), which
know neither bivectors nor joints. Springs, friction, loads and rotors of drives are in neither.

Formulas are printed in the order of a book:

    m h cos q q̈        numbers, parameters as the scene declares them, sines, then rates and accelerations
    sin(φ - χ)          in every angle the scene's first coordinate is positive: not -sin(χ - φ) beside cos(φ - χ)
    r cos φ - x         a sum that would begin with a minus has its other terms first
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations

from symdyn.algebra import Compactor, Form, Function, Number, Power, Product, Sum, Symbol, with_squares
from symdyn.dynamics import Workspace, angle_groups, closed_form
from symdyn.dynamics.mechanism import vector
from symdyn.emit.print import text_of
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass, field
from symdyn.graph import Expr, Op, gradient, substitute, tangents
from symdyn.scene import Quantity, Scene
from symdyn.scene.values import acceleration_name
from symdyn.spatial import dot, scale, sub
from symdyn.teach.derivations.limits import in_a_row
from symdyn.teach.document import Block, Step, Words
from symdyn.teach.lesson import Prose

CIRCULAR = (Op.SIN, Op.COS)


@dataclass(frozen=True)
class Order:
    """Places of a scene's symbols in a product and in an angle; what was put in order is remembered."""

    place: dict[str, int]
    moving: frozenset[str]
    _known: dict[Form, Form] = field(default_factory=dict, compare=False, repr=False)
    _ranks: dict[Form, tuple[int, int]] = field(default_factory=dict, compare=False, repr=False)

    def __call__(self, form: Form) -> Form:
        """Return the same formula in this order."""
        if form not in self._known:
            self._known[form] = self._ordered(form)
        return self._known[form]

    def _ordered(self, form: Form) -> Form:
        if isinstance(form, Function):
            return self._angle(form.with_parts(map(self, form.parts)))
        parts = [self(part) for part in form.parts]
        if isinstance(form, Power):
            sign, base = parts[0].split_sign()
            turned = base.power(form.exponent)
            return Form.product((Number.MINUS_ONE, turned)) if sign < 0 and form.exponent % 2 else turned
        if isinstance(form, Product):
            return self._product(Form.product(parts))
        if isinstance(form, Sum):
            return _signed(list(Form.sum(parts).terms))
        return form.with_parts(parts)

    def _product(self, form: Form) -> Form:
        if not isinstance(form, Product):
            return form
        return Form.product(sorted(form.factors, key=self._of_factor))

    def _of_factor(self, factor: Form) -> tuple[int, int]:
        if factor not in self._ranks:
            self._ranks[factor] = self._rank(factor)
        return self._ranks[factor]

    def _rank(self, factor: Form) -> tuple[int, int]:
        used = factor.symbols
        kind = 3 if self.moving.intersection(used) else 2 if _has_function(factor) else 0 if used else -1
        last = len(self.place)
        return kind, self.place.get(used[0], last) if kind == 0 else 0

    def _angle(self, form: Form) -> Form:
        """Return a sine or cosine with the terms of its angle in order."""
        if not isinstance(form, Function) or form.op not in CIRCULAR:
            return form
        last = len(self.place)
        terms = sorted(
            form.args[0].terms,
            key=lambda term: min((self.place.get(x, last) for x in term.symbols), default=-1),
        )
        leading = next((term for term in terms if term.symbols), None)
        if leading is None or leading.split_sign()[0] > 0:
            return Function(form.op, (Form.sum(terms),)) if terms else form
        turned = Function(form.op, (Form.sum(Form.product((Number.MINUS_ONE, term)) for term in terms),))
        return turned if form.op is Op.COS else Form.product((Number.MINUS_ONE, turned))


def order_of(scene: Scene) -> Callable[[Form], Form]:
    """Return what puts formulas of a scene in order."""
    rates = [*scene.velocities, *map(acceleration_name, scene.velocities)]
    names: Sequence[str] = [*(one.name for one in scene.parameters), *scene.coordinates, *rates]
    return Order({name: k for k, name in enumerate(names)}, frozenset(rates))


def _has_function(form: Form) -> bool:
    return isinstance(form, Function) or any(map(_has_function, form.parts))


def _signed(terms: list[Form]) -> Form:
    """Return a sum that begins without a minus where it can: then those with one stand behind the others."""
    if terms[0].split_sign()[0] > 0:
        return Form.sum(terms)
    return Form.sum(sorted(terms, key=lambda term: term.split_sign()[0] < 0))


WIDEST = 240
"""Characters of a row beyond which it is no row of a table."""


@dataclass(frozen=True)
class Term:
    """One term of one equation."""

    velocity: int  # number of the equation
    rates: Form  # what the coefficient multiplies; ONE for weights
    coefficient: Form  # by Lagrange
    shares: tuple[Form, ...]  # by D'Alembert, one a body


def terms_of_both(scene: Scene) -> list[Term]:
    """Return every term that does not vanish, of an open mechanism.

    Raises:
        DerivationError: there are no closed forms, or drives have rotors, which are no bodies.
    """
    closed = closed_form(scene)
    w = Workspace(scene)
    graph, state, n = w.graph, w.state, w.state.n
    if any(joint.armature != Quantity.ZERO for joint in scene.joints):
        raise DerivationError(f"{scene.name}: rotors turn with their joints and are no bodies")
    powers = _powers(w)
    found: list[tuple[int, Form, Form, list[Expr]]] = []
    q, u, a = state.q, state.qd, state.qdd
    names = [Symbol(name) for name in scene.velocities]
    pushed = [Symbol(acceleration_name(name)) for name in scene.velocities]
    pairs = list(combinations(range(n), 2))
    assert len(q) == n, "a quaternion has no closed forms"
    for i in range(n):
        inertia, weights = powers[i]
        for k in range(n):
            found.append((i, pushed[k], closed.form("k_z", i, k), [gradient(x, (a[k],))[0] for x in inertia]))
        resting = substitute(inertia, dict.fromkeys(a, graph.zero))
        slopes = [gradient(x, u) for x in resting]
        for place, (j, k) in enumerate(pairs):
            second = [gradient(slope[j], (u[k],))[0] for slope in slopes]
            found.append((i, Form.product((names[j], names[k])), closed.form("k_C", i, place), second))
        for k in range(n):
            half = [gradient(slope[k], (u[k],))[0] / 2 for slope in slopes]
            found.append((i, names[k].power(2), closed.form("k_D", i, k), half))
        found.append((i, Number.ONE, closed.form("k_G", i), weights))
    write = _writer(scene, w, [x for *_, shares in found for x in shares])
    order = order_of(scene)
    written = [Term(i, rates, order(form), tuple(map(write, shares))) for i, rates, form, shares in found]
    return [
        one for one in written if one.coefficient != Number.ZERO or any(share != Number.ZERO for share in one.shares)
    ]


def _powers(w: Workspace) -> list[tuple[list[Expr], list[Expr]]]:
    """Return for every velocity at unit size minus the power of inertia forces, and of weights, one a body."""
    hanging, state, graph = w.hanging, w.state, w.graph
    bodies = hanging.bivectors([[graph.zero] * len(hinge.S) for hinge in hanging.joints])
    g = vector(w.scene.gravity, graph)
    inertia: list[list[Expr]] = []
    weights: list[list[Expr]] = []
    for known, T, hinge, body in zip(bodies, hanging.frames, hanging.joints, w.scene.bodies, strict=True):
        x, y, z = tangents(T.p, state.velocity)
        v, omega = T.R.T @ (x, y, z), known.motion.w
        rates = [[gradient(c, (u,))[0] for c in (*v, *omega)] for u in state.qd]
        force, moment = known.inertia
        inertia.append([-graph.dot((*force, *moment), row) for row in rates])
        if known.body.m.is_zero:
            weights.append([graph.zero] * state.n)
            continue
        centre = T.point(sub(w.centre_of_mass(body.name), hinge.place_on_child))
        fall = tangents([dot(scale(known.body.m, g), centre)], state.velocity)[0]
        weights.append([-gradient(fall, (u,))[0] for u in state.qd])
    return [([one[i] for one in inertia], [one[i] for one in weights]) for i in range(state.n)]


def _writer(scene: Scene, w: Workspace, nodes: Sequence[Expr]) -> Callable[[Expr], Form]:
    state, parallel, order = w.state, angle_groups(scene, w.graph), order_of(scene)
    write = Compactor.of(nodes, (*state.q, *state.qd, *state.qdd), parallel)
    return lambda node: order(with_squares(write(node)))


def side_by_side(lesson: Prose) -> Step | None:
    """Return the table of both methods; None where there are no closed forms, or rows wider than a page."""
    scene = lesson.scene
    try:
        terms = [] if scene.is_constrained else terms_of_both(scene)
    except DerivationError:
        return None
    if not terms or max(map(_width, terms)) > WIDEST:
        return None
    blocks: list[Block] = []
    for i, drive in enumerate(scene.drives):
        rows = [_row(lesson, one) for one in terms if one.velocity == i]
        name = Symbol(drive) if drive else Symbol(scene.coordinates[i])
        blocks += [
            lesson.say("side.drive" if drive else "side.passive", name=name),
            lesson.table(("side.rates", "lagrange", "dalembert"), rows),
        ]
    return Step("side", lesson.say("side"), tuple(blocks), lesson.say("side.reason"), "(5.18), (5.21)")


def _row(lesson: Prose, term: Term) -> tuple[Form | Words | str, ...]:
    shares = zip(lesson.scene.bodies, term.shares, strict=True)
    said = [lesson.say("side.share", body=body.name, share=form) for body, form in shares if form != Number.ZERO]
    rates: Form | str = lesson.text("side.weights") if term.rates == Number.ONE else term.rates
    return rates, term.coefficient, in_a_row(said)


def _width(term: Term) -> int:
    return sum(len(text_of(form)) for form in (term.coefficient, *term.shares))
