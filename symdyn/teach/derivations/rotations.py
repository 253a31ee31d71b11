"""Steps: matrices of direction cosines of neighbouring bodies in space, and angular velocities read from them.

C_pb holds the axes of body b as columns, in axes of its neighbour p towards the ground; vectors of b go to p by it.
From C_0b = C_0p C_pb and the skew matrix ω̃ = Cᵀ Ċ follows ω_b = C_pbᵀ ω_p + what joint b adds, all in body axes.

Formulas are differentiated as a student does it on paper: the chain rule term by term, brackets multiplied out. The
graph has its own derivatives; tests compare both by value.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction

from symdyn.algebra import Form, Function, Number, Power, Product, Sum, Symbol
from symdyn.dynamics.mechanism import joint_placement
from symdyn.emit.print import Letters
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Op, tangents
from symdyn.scene import Scene
from symdyn.scene.values import Body, Joint
from symdyn.spatial import Vec
from symdyn.teach.document import Block, Fold, Letter, Matrix, Step
from symdyn.teach.lesson import AXES, Lesson, Mass

WIDEST = 3
"""Terms of an entry up to which a matrix stands open."""


def rotation_steps(lesson: Lesson, result: list[Mass]) -> list[Step]:
    """Return one step a body on the way to a body with inertia; none where all turn about one direction."""
    bodies = {mass.body.name: mass.body for mass in result if mass.spins}
    turning = [angular_velocity(lesson, body) for body in bodies.values()]
    axes = {tuple(lesson.vanishes(x) for x in w) for w in turning} - {(True,) * 3}
    if not any(sum(still) < 2 for still in axes) and len(axes) < 2:
        return []
    carrier = {joint.child: joint for joint in lesson.scene.joints}
    wanted: set[str] = set()
    for name in bodies:
        below = name
        while below != Scene.GROUND and below not in wanted:
            wanted.add(below)
            below = carrier[below].parent
    return [_rotation(lesson, joint) for joint in lesson.scene.joints if joint.child in wanted]


def number_of(scene: Scene, body: str) -> str:
    """Return the number of a body in print, "0" for the ground."""
    return "0" if body == Scene.GROUND else str(Letters.body_number([one.name for one in scene.bodies].index(body)))


def _rotation(lesson: Lesson, joint: Joint) -> Step:
    """Return C of one joint, and the product that leads to the ground."""
    here, there = number_of(lesson.scene, joint.parent), number_of(lesson.scene, joint.child)
    R = joint_placement(joint, lesson.graph).R
    left, names, entries = cosines(here, there), [], []
    lesson.called(left, Letter(Letters.COSINES, (here + there,)))
    for a in range(3):
        for b in range(3):
            names.append(f"{left}:{AXES[a]}{AXES[b]}")
            lesson.called(names[-1], Letter(Letters.COSINES, (here + there, AXES[a] + AXES[b])), R[a][b])
            entries.append(lesson.short(R[a][b]))
    matrix: Block = Matrix(left, tuple(entries), tuple(names), width=3)
    if max(len(entry.terms) for entry in entries) > WIDEST:
        matrix = Fold(lesson.say("rotation.fold", name=Symbol(left)), (matrix,))
    blocks = [matrix]
    if joint.parent != Scene.GROUND:
        first, whole = cosines("0", here), cosines("0", there)
        for key, of in ((first, here), (whole, there)):
            lesson.called(key, Letter(Letters.COSINES, ("0" + of,)))
        product = Form.product((Symbol(first), Symbol(left)))
        blocks.append(lesson.say("rotation.product", body=joint.child, whole=Symbol(whole), product=product))
    claim = lesson.say("rotation", body=joint.child, parent=_called(lesson, joint.parent))
    return Step(f"rotation:{joint.child}", claim, tuple(blocks), lesson.once("rotation.reason"))


def cosines(here: str, there: str) -> str:
    """Return the key of C of two bodies by their numbers."""
    return f"C:{here},{there}"


def _called(lesson: Lesson, body: str) -> str:
    return lesson.text("rotation.ground") if body == Scene.GROUND else body


# Angular velocities


def angular_velocity(lesson: Lesson, body: Body) -> Vec:
    """Return ω in body axes from ω̃ = Cᵀ Ċ, C from the body to the ground."""
    R = lesson.placed[body.name].R
    dR = [tangents(row, lesson.state.velocity) for row in R]
    pairs = ((2, 1), (0, 2), (1, 0))
    x, y, z = (lesson.graph.total(R[k][a] * dR[k][b] for k in range(3)) for a, b in pairs)
    return x, y, z


def read_from(lesson: Lesson, body: Body, result: list[Mass]) -> list[Form] | None:
    """Return the three components of ω as they are read from C; None where no matrix is shown.

    From a neighbour p each is the sum over the column of C_pb times ω_p, and what the joint adds; of a joint with
    several turns on the ground it is an entry of Cᵀ Ċ.
    """
    joint = next(one for one in lesson.scene.joints if one.child == body.name)
    key = cosines(number_of(lesson.scene, joint.parent), number_of(lesson.scene, body.name))
    if key not in lesson.names:
        return None
    if joint.parent == Scene.GROUND:
        return _skew(lesson, key) if len(joint.coordinates) > 1 else None
    parent = next(one for one in lesson.scene.bodies if one.name == joint.parent)
    above, R = angular_velocity(lesson, parent), joint_placement(joint, lesson.graph).R
    tags = [mass.tag for mass in result if mass.body is parent and mass.spins]
    handed = R.T @ above
    components = []
    for a, own in enumerate(angular_velocity(lesson, body)):
        terms: list[Form] = []
        for k in range(3):
            if not lesson.vanishes(above[k]) and not lesson.vanishes(R[k][a]):
                rate: Form = Symbol(f"omega:{tags[0]}{AXES[k]}") if tags else lesson.short(above[k])
                terms.append(Form.product((lesson.short(R[k][a]), rate)))
        terms += lesson.short(own - handed[a]).terms
        components.append(Form.sum(terms))
    return components


def _skew(lesson: Lesson, key: str) -> list[Form]:
    """Return entries zy, xz, yx of Cᵀ Ċ, in names of the entries of C and their rates."""

    def entry(name: str) -> Expr:
        node = lesson.names[name].node
        assert node is not None, "an entry of C has a value"
        return node

    components = []
    for a, b in (("z", "y"), ("x", "z"), ("y", "x")):
        terms = []
        for k in AXES:
            (rate,) = tangents([entry(f"{key}:{k}{b}")], lesson.state.velocity)
            if lesson.vanishes(rate) or lesson.vanishes(entry(f"{key}:{k}{a}")):
                continue
            look = lesson.names[f"{key}:{k}{b}"].look
            assert isinstance(look, Letter), "an entry of C is called by a letter"
            moving = lesson.called(f"d{key}:{k}{b}", Letter(Letters.COSINES, look.index, dots=1), rate)
            terms.append(Form.product((Symbol(f"{key}:{k}{a}"), moving)))
        components.append(Form.sum(terms))
    return components


Monomial = tuple[tuple[Form, int], ...]  # (atom, exponent), in order of appearance


def rate_of(form: Form, rates: Mapping[str, Form]) -> Form:
    """Return d/dt of a polynomial in sines by the product and chain rules; symbols without a rate are constant.

    sin(q1 + q2) gives cos(q1 + q2) (q̇1 + q̇2), the angle's rate last.
    """
    if isinstance(form, Symbol):
        return rates.get(form.name, Number.ZERO)
    if isinstance(form, Sum):
        return Form.sum(rate_of(term, rates) for term in form.terms)
    if isinstance(form, Power):
        inner = rate_of(form.base, rates)
        if inner == Number.ZERO:
            return Number.ZERO
        outer = Form.product((Number(Fraction(form.exponent)), form.base.power(form.exponent - 1)))
        return _spread(outer, inner)
    if isinstance(form, Product):
        terms = []
        for k, factor in enumerate(form.factors):
            inner = rate_of(factor, rates)
            if inner != Number.ZERO:
                others = Form.product((*form.factors[:k], *form.factors[k + 1 :]))
                terms.append(_spread(others, inner))
        return Form.sum(terms)
    if isinstance(form, Function) and form.op in (Op.SIN, Op.COS):
        inner = rate_of(form.args[0], rates)
        if inner == Number.ZERO:
            return Number.ZERO
        sign, op = (Number.ONE, Op.COS) if form.op is Op.SIN else (Number.MINUS_ONE, Op.SIN)
        return Form.product((sign, Function(op, form.args), inner))
    return Number.ZERO


def _spread(outer: Form, inner: Form) -> Form:
    """Return outer · inner, term by term where inner has sines to differentiate by more than one coordinate."""
    if isinstance(inner, Sum) and not all(isinstance(term, Symbol) for term in inner.terms):
        return Form.sum(Form.product((outer, term)) for term in inner.terms)
    return Form.product((outer, inner))


def has_sine(form: Form) -> bool:
    """Tell whether a sine or cosine stands in a form."""
    return any(isinstance(one, Function) and one.op in (Op.SIN, Op.COS) for one in form.walk())


MOST_PRODUCTS = 20_000
"""Products of two terms up to which squares are multiplied out."""


@dataclass(frozen=True)
class Group:
    """Terms of a square that have everything in common but sines: outer · (Σ sines)."""

    outer: Form  # number, parameters and rates
    sines: tuple[Form, ...]  # what remains, one term each; (ONE,) where there are no sines

    @property
    def form(self) -> Form:
        """The product."""
        return Form.product((self.outer, Form.sum(self.sines)))


def expanded_squares(forms: Iterable[Form]) -> list[Group] | None:
    """Return Σ form², multiplied out; what differs in sines only stands in one bracket; None where it fills pages."""
    total: dict[Monomial, Fraction] = {}
    every = [list(_expand(form).items()) for form in forms]
    if sum(len(terms) ** 2 for terms in every) > MOST_PRODUCTS:
        return None
    for terms in every:
        for k, (a, x) in enumerate(terms):
            for m, (b, y) in enumerate(terms[k:]):
                key = _times(a, b)
                total[key] = total.get(key, Fraction(0)) + x * y * (2 if m else 1)
    groups: dict[Monomial, list[tuple[Fraction, Monomial]]] = {}
    for monomial, number in total.items():
        if number:
            outer = tuple(item for item in monomial if not has_sine(item[0]))
            groups.setdefault(outer, []).append((number, tuple(item for item in monomial if has_sine(item[0]))))
    result = []
    for outer, members in groups.items():
        shared = members[0][0] if all(abs(a) == abs(members[0][0]) for a, _ in members) else Fraction(1)
        sines = tuple(Form.product((Number(a / shared), _product(m))) for a, m in members)
        result.append(Group(Form.product((Number(shared), _product(outer))), sines))
    return result


def _expand(form: Form) -> dict[Monomial, Fraction]:
    """Return a form as Σ number · monomial; sums without sines are atoms."""
    total: dict[Monomial, Fraction] = {}
    for term in form.terms:
        for monomial, number in _expand_term(term).items():
            total[monomial] = total.get(monomial, Fraction(0)) + number
    return total


def _expand_term(term: Form) -> dict[Monomial, Fraction]:
    product: dict[Monomial, Fraction] = {(): Fraction(1)}
    for factor in term.factors:
        if isinstance(factor, Number):
            parts: dict[Monomial, Fraction] = {(): factor.value}
        elif isinstance(factor, Sum) and has_sine(factor):
            parts = _expand(factor)
        else:
            base, exponent = (factor.base, factor.exponent) if isinstance(factor, Power) else (factor, 1)
            if isinstance(base, Sum) and has_sine(base):
                parts = {(): Fraction(1)}
                for _ in range(exponent):
                    parts = _multiplied(parts, _expand(base))
            else:
                parts = {((base, exponent),): Fraction(1)}
        product = _multiplied(product, parts)
    return product


def _multiplied(a: Mapping[Monomial, Fraction], b: Mapping[Monomial, Fraction]) -> dict[Monomial, Fraction]:
    total: dict[Monomial, Fraction] = {}
    for x, p in a.items():
        for y, q in b.items():
            key = _times(x, y)
            total[key] = total.get(key, Fraction(0)) + p * q
    return total


def _times(a: Monomial, b: Monomial) -> Monomial:
    exponents = dict(a)
    for atom, exponent in b:
        exponents[atom] = exponents.get(atom, 0) + exponent
    return tuple(sorted(((x, e) for x, e in exponents.items() if e), key=_place))


def _place(item: tuple[Form, int]) -> tuple[int, str]:
    """Sort key: parameters, sines, rates and their sums, each by its text."""
    kind = 1 if has_sine(item[0]) else 2 if is_rate(item[0]) else 0
    return kind, repr(item[0])


def is_rate(form: Form) -> bool:
    """Tell whether a form is a velocity, or a power, a product or a sum of such."""
    if isinstance(form, (Sum, Power)):
        return all(map(is_rate, form.parts))
    if isinstance(form, Product):
        return any(map(is_rate, form.factors))
    return isinstance(form, Symbol) and form.name.endswith("_dot")


def _product(monomial: Monomial) -> Form:
    return Form.product(atom.power(exponent) for atom, exponent in monomial)
