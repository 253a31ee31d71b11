"""A mechanism whose bodies turn by quaternions while its lesson is being written, and its steps.

    e            unit quaternion (e0, e1, e2, e3) of a joint        R      its rotation: columns are the turned axes
    u            velocities: of a ball ω, of free flight v and ω, both in the moved frame; else rates of coordinates
    X_i          derivative along velocity i alone                  p_i    momentum ∂K/∂u_i
    γ^l_ji       [X_j, X_i] = Σ γ^l_ji X_l                          k_G,i  X_i of the potential of gravity

    τ_i = ṗ_i - Σ γ^l_ji u_j p_l - X_i K + k_G,i + k_E,i            what drives and all other forces supply

Steps are energies in turning axes, momenta, why their rates turn too, and the equations of motion. Wheels that roll on
the ground are written in the axes of the body that rolls, where nothing is long:

    n        the plane's normal, in the body's axes: letters n1, n2, n3, whose squares add up to 1; ṅ = n × ω
    a, r, P  axis, radius and centre of the wheel                   w      |a × n|, the sine of its lean
    d        from P to the lowest point: -(r/w) (n - (n·a) a)       c      velocity of that point: v_P + ω × d
    t        along the track: (a × n) / w                           n × t  across it
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import combinations

from symdyn.algebra import Compactor, Form, Number, Power, Symbol, TrigonometricRing
from symdyn.arguments import argument
from symdyn.dynamics import angle_groups
from symdyn.dynamics.mechanism import generalized_forces, vector
from symdyn.emit.print import text_of
from symdyn.errors import DerivationError
from symdyn.graph import Expr, gradient, substitute, tangents
from symdyn.scene import Scene
from symdyn.scene.joints import unit
from symdyn.scene.values import Contact, Joint
from symdyn.spatial import Vec, add, cross, dot, scale, sub
from symdyn.teach.derivations.constrained import Condition, Constrained
from symdyn.teach.derivations.equation_steps import node_of, supplied
from symdyn.teach.derivations.multiplier_steps import valued
from symdyn.teach.derivations.rotations import angular_velocity
from symdyn.teach.derivations.velocities import HALF, MOST_TERMS, folded, kinetic_form, length
from symdyn.teach.document import Block, Brace, Braced, Formula, Letter, Name, Rate, Step, Words
from symdyn.teach.lesson import AXES, Mass, named, together
from symdyn.unlocked import cached_property

WAYS = {"tie.force along the track": 0, "tie.force across the track": 1, "tie.normal force": 2}


def rolls(row: Contact) -> bool:
    """Tell whether a contact is a wheel on the ground."""
    return row.plane.body == Scene.GROUND and row.axis is not None and row.radius is not None


def name_normal(lesson: Constrained, row: Contact) -> None:
    """Name the plane's normal in the axes of the body that rolls."""
    number = str([one.name for one in lesson.scene.contacts].index(row.name) + 1)
    several = len(lesson.scene.contacts) > 1
    entries = lesson.placed[row.place.body].R.T @ unit(row.plane.normal, lesson.graph)
    for k, node in enumerate(entries, 1):
        lesson.letter(f"n:{row.name},{k}", Letter("n", (number, str(k)) if several else (str(k),)), node)


def normal(lesson: Constrained, row: Contact) -> Vec:
    """Return the letters of the plane's normal."""
    x, y, z = (lesson.graph.symbol(f"n:{row.name},{k}") for k in (1, 2, 3))
    return x, y, z


def in_letters(lesson: Constrained, row: Contact, tie: Condition, twist: tuple[Vec, Vec]) -> Condition:
    """Return a condition of a wheel with what is shown of it in letters; the body's `twist` is (v, ω), in its axes."""
    graph, u = lesson.graph, lesson.state.qd
    assert row.axis is not None, "a wheel has an axis"
    assert row.radius is not None, "a wheel has a radius"
    n, (v, omega) = normal(lesson, row), twist
    a, r, P = unit(row.axis, graph), row.radius.express(graph), vector(row.place.at, graph)
    lean = cross(a, n)
    w = graph.sqrt(dot(lean, lean))
    d = scale(-r / w, sub(n, scale(dot(n, a), a)))
    c = add(add(v, cross(omega, P)), cross(omega, d))
    t = scale(1 / w, lean)
    power = dot((t, cross(n, t), n)[WAYS[tie.words]], c)
    slopes = gradient(power, u)
    rates = dict(zip(n, cross(n, omega), strict=True)) | lesson.state.velocity
    (bias,) = tangents([power], rates)
    shown: list[Expr] = [*slopes, bias]
    if tie.residual is not None:
        height = dot(unit(row.plane.normal, graph), sub(lesson.placed[row.place.body].p, vector(row.plane.at, graph)))
        shown.append(height + dot(n, P) - r * w)
    return replace(tie, shown=tuple(shown))


MOST_VELOCITIES = 9
"""Of a scene with quaternions that has a lesson: beyond, its formulas fill books."""


class Turning(Constrained):
    """One mechanism with quaternions, tied by conditions or not."""

    def refuse(self) -> None:
        """Say what this formulation does not take.

        Raises:
            DerivationError: no joint turns by a quaternion, or there are more velocities than anyone reads.
        """
        n = len(self.scene.velocities)
        if n > MOST_VELOCITIES:
            raise DerivationError(
                f"{self.scene.name}: a lesson would be longer than anyone reads: there are {n} velocities, and "
                f"{MOST_VELOCITIES} is the limit; {argument('format', 'sliders')} is a page that moves it, and symdyn "
                "generate writes the code"
            )
        if not self.spheres:
            other = argument("formulation", "multipliers" if self.scene.is_constrained else "lagrange")
            raise DerivationError(
                f"{self.scene.name}: no joint turns by a quaternion, so there are none to explain; {other} shows the "
                "equations of this mechanism"
            )

    @cached_property
    def balls(self) -> list[Joint]:
        """Joints that turn by a quaternion."""
        return [joint for joint in self.scene.moving if joint.velocities]

    def first(self, joint: Joint) -> int:
        """Return the number of a joint's first velocity."""
        return self.scene.velocities.index(joint.rates[0])

    # Conditions

    def tied(self) -> tuple[Condition, ...]:
        """Return the conditions, those of wheels on the ground in letters for its normal."""
        rows = {row.name: row for row in self.wheels}
        found = []
        for tie in super().tied():
            row = rows.get(tie.owner) if not tie.loop and tie.words in WAYS else None
            found.append(tie if row is None else in_letters(self, row, tie, self.twist(row.place.body)))
        return tuple(found)

    @cached_property
    def wheels(self) -> list[Contact]:
        """Wheels on the ground, the normal named for each."""
        found = [row for row in self.scene.contacts if rolls(row)]
        for row in found:
            name_normal(self, row)
        return found

    def introduced(self, owner: str) -> list[Block]:
        """Return what the normal is in the axes of a wheel's body, and its rate."""
        row = next((row for row in self.wheels if row.name == owner), None)
        if row is None:
            return []
        keys = [f"n:{row.name},{k}" for k in (1, 2, 3)]
        blocks: list[Block] = [self.say("wheel.normal", parent=self.body(row.plane.body), child=row.place.body)]
        blocks += [Formula(key, self.shape(node_of(self, key))) for key in keys]
        letters = together([Symbol(key) for key in keys])
        return [*blocks, self.say("wheel.turns", normal=letters, child=row.place.body)]

    @property
    def directions(self) -> list[list[Expr]]:
        """The normal of the ground in the axes of every wheel's body."""
        return [list(normal(self, row)) for row in self.wheels]

    def twist(self, name: str) -> tuple[Vec, Vec]:
        """Return velocity of the origin and angular velocity of a body, in its own axes, as short as can be."""
        T, body = self.placed[name], next(body for body in self.scene.bodies if body.name == name)
        x, y, z = tangents(T.p, self.state.velocity)
        v, omega = T.R.T @ (x, y, z), angular_velocity(self, body)
        return self._cleaned(v), self._cleaned(omega)

    def _cleaned(self, v: Vec) -> Vec:
        x, y, z = (self.shape(one).express(self.graph) for one in v)
        return x, y, z

    # Derived once

    @cached_property
    def p(self) -> list[Expr]:
        """Momenta ∂K/∂u_i."""
        return gradient(self.energy.K, self.state.qd)

    @cached_property
    def p_rates(self) -> list[Expr]:
        """Rates of the momenta."""
        return tangents(self.p, self.state.acceleration)

    @cached_property
    def along_K(self) -> list[Expr]:
        """X_i K."""
        return self.energy.directions.slopes(self.energy.K)

    @cached_property
    def weights(self) -> list[Expr]:
        """k_G: X_i of the potential of gravity."""
        return self.energy.gravity_forces()

    @cached_property
    def springs(self) -> list[Expr]:
        """k_E: X_i of the potential of springs."""
        return self.energy.elastic_forces()

    @cached_property
    def acting(self) -> list[Expr]:
        """Q_i: loads, friction and forces in joints."""
        return generalized_forces(self.scene, self.graph)

    @cached_property
    def needed(self) -> list[Expr]:
        """τ_i: the whole of drives, other forces and conditions."""
        return [a + b for a, b in zip(self.drives, self.acting, strict=True)]

    # Forms

    def without_inertia(self, i: int, j: int) -> bool:
        """Tell whether entry ij of the mass matrix vanishes."""
        return f"k_z:{i + 1},{j + 1}" not in self.names

    @cached_property
    def ring(self) -> TrigonometricRing:
        """The ring in which everything is written, where e0² + e1² + e2² + e3² = 1."""
        graph, state = self.graph, (*self.state.q, *self.state.qd, *self.state.qdd)
        needed = [graph.symbol(parameter.name) for parameter in self.scene.parameters]
        needed += [*state, *self.state.rates, *vector(self.scene.gravity, graph), self.energy.K, self.energy.G]
        needed += [x for one in self.masses for x in (one.m, *one.place, *(one.h or ()))]
        needed += [x for one in self.masses for row in one.inertia for x in row]
        needed += [x for T in self.placed.values() for row in (*T.R, T.p) for x in row]
        return TrigonometricRing(needed, state, angle_groups(self.scene, graph), self.spheres)

    @cached_property
    def _compact(self) -> Compactor:
        return Compactor(self.ring, angle_groups(self.scene, self.graph))

    def shape(self, node: Expr) -> Form:
        """Return a node as short as can be, as it stands where it is no polynomial."""
        try:
            return self.short(node)
        except (DerivationError, KeyError):
            return Form.of(node)


WIDEST = 110
"""Characters of a coefficient that stands over a brace."""


# Energies


def energy_steps(lesson: Turning) -> list[Step]:
    """Return K and P: of every mass, and of all."""
    for key, node in (("K:", lesson.energy.K), ("P:", lesson.energy.P)):
        lesson.name(key, key[0], node=node)
    steps, parts = list[Step](), list[Form]()
    for mass in lesson.masses:
        blocks = _kinetic(lesson, mass)
        if blocks:
            parts.append(Symbol(f"K:{mass.tag}"))
            claim = lesson.say("kinetic", mass=lesson.of(mass, whole=True))
            reason = lesson.say("body.kinetic.reason") if len(parts) == 1 else Words(())
            steps.append(Step(f"kinetic:{mass.tag}", claim, blocks, reason))
    whole = valued(lesson, Form.sum(parts))
    blocks = (Formula("K:", Form.sum(parts)),) if lesson.vanishes(whole - lesson.energy.K) else ()  # rotors turn too
    blocks += (folded(lesson, Formula("K:", kinetic_form(lesson, lesson.energy.K))),)
    blocks += (folded(lesson, Formula("P:", lesson.shape(lesson.energy.P))),)
    reason = lesson.say("body.potential.reason")
    return [*steps, Step("energies", lesson.say("energies"), blocks, reason, show=("energies",))]


def _kinetic(lesson: Turning, mass: Mass) -> tuple[Block, ...]:
    """Return K of one mass: ½ m v², ½ ω·I ω, and the mixed term of a first moment."""
    tag, terms, blocks = mass.tag, list[Form](), list[Block]()
    v, w = ([Symbol(f"{letter}:{tag}{axis}") for axis in AXES] for letter in ("v", "omega"))
    squares = Form.sum(one.power(2) for one in v if lesson.shape(node_of(lesson, one.name)).terms)
    if not mass.m.is_zero and squares.terms:
        terms.append(Form.product((HALF, lesson.short(mass.m), squares)))
    for a in range(3):
        for b in range(a, 3):
            if not mass.inertia[a][b].is_zero:
                pair: list[Form] = [HALF, w[a].power(2)] if a == b else [w[a], w[b]]
                terms.append(Form.product((lesson.short(mass.inertia[a][b]), *pair)))
    if mass.h is not None:
        x, y, z = (node_of(lesson, one.name) for one in v)
        a1, a2, a3 = lesson.twist(mass.body.name)[1]
        mixed = dot((x, y, z), cross((a1, a2, a3), lesson.placed[mass.body.name].R.T @ mass.h))
        if not lesson.vanishes(mixed):
            terms.append(lesson.name(f"Kh:{tag}", "K", tag, "h", node=mixed))
            blocks.append(folded(lesson, Formula(f"Kh:{tag}", kinetic_form(lesson, mixed))))
    if not terms:
        return ()
    form = Form.sum(terms)
    lesson.name(f"K:{tag}", "K", tag, node=valued(lesson, form))
    return (*blocks, Formula(f"K:{tag}", form))


# Momenta


def momentum_steps(lesson: Turning) -> list[Step]:
    """Return the momenta, and why the rate of a vector in turning axes has a second part."""
    steps: list[Step] = []
    for joint in lesson.scene.moving:
        blocks: list[Block] = []
        for i in _velocities(lesson, joint):
            lesson.name(f"p:{i + 1}", "p", str(i + 1), node=lesson.p[i])
            blocks.append(folded(lesson, Formula(f"p:{i + 1}", _linear(lesson, lesson.p[i]))))
        claim = lesson.say("momenta", joint=joint.name)
        reason = lesson.say("momenta.reason") if not steps else Words(())
        steps.append(Step(f"momenta:{joint.name}", claim, tuple(blocks), reason, show=("momenta",)))
    for i in range(lesson.state.n):
        lesson.names[f"d/dt p:{i + 1}"] = Name(Rate(f"p:{i + 1}"), lesson.p_rates[i])
    shown = lesson.balls[0]
    first = lesson.first(shown)
    free = len(shown.rates) == 6
    p = [Symbol(f"p:{first + k + 1}") for k in range(len(shown.rates))]
    w = [Symbol(name) for name in shown.rates[-3:]]
    turned = _cross(w, p[-3:])
    blocks = [lesson.say("turned.angular", joint=shown.name), *(Words((one,)) for one in turned)]
    if free:
        blocks += [lesson.say("turned.linear"), *(Words((one,)) for one in _cross(w, p[:3]))]
    said = lesson.say("turned", joint=shown.name)
    return [*steps, Step("turned", said, tuple(blocks), lesson.say("turned.reason"))]


def _cross(a: Sequence[Symbol], b: Sequence[Symbol]) -> list[Form]:
    pairs = ((1, 2), (2, 0), (0, 1))
    return [Form.sum((Form.product((a[i], b[j])), Form.product((Number.MINUS_ONE, a[j], b[i])))) for i, j in pairs]


def _velocities(lesson: Turning, joint: Joint) -> range:
    first = lesson.first(joint)
    return range(first, first + len(joint.rates))


def _linear(lesson: Turning, node: Expr) -> Form:
    """Return Σ coefficient · u_j."""
    slopes = zip(gradient(node, lesson.state.qd), lesson.state.qd, strict=True)
    return Form.sum(lesson.shape(slope).signed_product(named(u)) for slope, u in slopes if not slope.is_zero)


# Equations


def name_forces_at_rest(lesson: Turning) -> None:
    """Name τ_i, k_G,i, k_E,i and X_i K, each with its value."""
    for i in range(lesson.state.n):
        number = str(i + 1)
        acting = "tau" if lesson.acting[i].is_zero and not lesson.ties else "S"
        lesson.name(f"tau:{number}", acting, number, node=lesson.needed[i])
        lesson.name(f"k_G:{number}", "k", "G", number, node=lesson.weights[i])
        lesson.name(f"k_E:{number}", "k", "E", number, node=lesson.springs[i])
        lesson.called(f"XK:{number}", Letter(rf"\partial_{{{number}}} {lesson.letters['K']}"), lesson.along_K[i])


def weight_step(lesson: Turning) -> Step | None:
    """Return what gravity and springs contribute; None where they do nothing."""
    blocks: list[Block] = []
    zero: list[Form] = []
    for kind, nodes in (("k_G", lesson.weights), ("k_E", lesson.springs)):
        for i, node in enumerate(nodes, 1):
            key, form = f"{kind}:{i}", lesson.shape(node)
            if form.terms:
                blocks.append(folded(lesson, Formula(key, form)))
            elif kind == "k_G":
                zero.append(Symbol(key))
    if not blocks:
        return None
    if zero:
        blocks.append(lesson.say("coefficients.zero", names=together(zero)))
    return Step("along", lesson.say("along"), tuple(blocks), lesson.say("along.reason"), show=("weights",))


def right_sides(lesson: Turning) -> tuple[Form, ...]:
    """Return drive + Q of every velocity."""
    found = []
    for drive, force in zip(lesson.scene.drives, lesson.acting, strict=True):
        found.append(Form.sum([*([Symbol(drive)] if drive else []), lesson.shape(force)]))
    return tuple(found)


def equation_steps(lesson: Turning, right: Sequence[Form]) -> list[Step]:
    """Return one step a velocity: the equation in its parts, and written out."""
    steps, u = list[Step](), lesson.state.qd
    for i in range(lesson.state.n):
        number = str(i + 1)
        parts: list[Form] = [Symbol(f"d/dt p:{number}")]
        for (j, k), terms in lesson.energy.directions.brackets.items():
            for m, value in terms if k == i else ():
                if lesson.shape(lesson.p[m]).terms:
                    parts.append(Form.product((Number(Fraction(-value)), named(u[j]), Symbol(f"p:{m + 1}"))))
        if lesson.shape(lesson.along_K[i]).terms:
            parts.append(Form.product((Number.MINUS_ONE, Symbol(f"XK:{number}"))))
        parts += [Symbol(key) for key, node in _along(lesson, i) if lesson.shape(node).terms]
        blocks: list[Block] = [Formula("", right[i], right=Form.sum(parts))]
        braces, long = _terms(lesson, i)
        blocks.append(Braced(right[i], tuple(braces), f"tau:{number}"))
        if long:
            blocks += [lesson.say("equation.named"), *(folded(lesson, Formula(*one)) for one in long.items())]
        reason = supplied(lesson, lesson.scene.drives[i], right[i], named(u[i]))
        steps.append(
            Step(f"equation:{number}", lesson.say("quaternion.equation", u=named(u[i])), tuple(blocks), reason)
        )
    return steps


def _along(lesson: Turning, i: int) -> tuple[tuple[str, Expr], tuple[str, Expr]]:
    """Return k_G,i and k_E,i: keys and values."""
    return (f"k_G:{i + 1}", lesson.weights[i]), (f"k_E:{i + 1}", lesson.springs[i])


def _terms(lesson: Turning, i: int) -> tuple[list[Brace], dict[str, Form]]:
    """Return the terms of one equation, coefficient by coefficient, and what is too long for a brace by its name."""
    state, node, n = lesson.state, lesson.needed[i], lesson.state.n
    found: list[tuple[str, tuple[str, ...], Expr, Form]] = []
    M = lesson.energy.mass_matrix()[i]
    for j in range(n):
        found.append((f"k_z:{i + 1},{j + 1}", ("z", f"{i + 1}{j + 1}"), M[j], named(state.qdd[j])))
    slopes = gradient(node, state.qd)
    pairs = [*combinations(range(n), 2), *((j, j) for j in range(n))]
    still = dict.fromkeys((*state.qd, *state.qdd), lesson.graph.zero)
    for j, k in pairs:
        second = gradient(slopes[j], [state.qd[k]])[0]
        (second,) = substitute([second], still)
        square = j == k
        index: tuple[str, ...] = ("D", f"{i + 1}{j + 1}") if square else ("C", str(i + 1), f"{j + 1}{k + 1}")
        key = f"k_D:{i + 1},{j + 1}" if square else f"k_C:{i + 1},{j + 1},{k + 1}"
        rate: Form = Power(named(state.qd[j]), 2) if square else Form.product((named(state.qd[j]), named(state.qd[k])))
        found.append((key, index, second / 2 if square else second, rate))
    braces: list[Brace] = []
    long: dict[str, Form] = {}
    for key, below, value, rate in found:
        form = lesson.shape(value)
        if not form.terms:
            continue
        lesson.name(key, "k", *below, node=value)
        braces.append(_brace(form, key, rate))
        if not braces[-1].under:
            long[key] = form
    for key, node in _along(lesson, i):  # written out above, where weights and springs are
        if (form := lesson.shape(node)).terms:
            braces.append(_brace(form, key, Number.ONE))
    return braces, long


def _brace(form: Form, key: str, rate: Form) -> Brace:
    short = length(form) <= MOST_TERMS // 3 and len(text_of(form)) <= WIDEST
    return Brace(form, key, rate) if short else Brace(Symbol(key), "", rate)
