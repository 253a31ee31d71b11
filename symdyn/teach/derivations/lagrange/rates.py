"""Steps: products and squares of rates, and why each of their coefficients k_C, k_D is there or not."""

from __future__ import annotations

from symdyn.algebra import Form, Number, Symbol
from symdyn.emit.print import Printable, text_of
from symdyn.graph import Expr, gradient, tangents
from symdyn.scene import SceneUnits
from symdyn.spatial import add, cross
from symdyn.teach.derivations.lagrange.equation_steps import WIDEST, coefficient_key, node_of
from symdyn.teach.derivations.lagrange.rotations import angular_velocity
from symdyn.teach.derivations.lagrange.velocities import length
from symdyn.teach.document import Block, Formula, Name, Step, Words
from symdyn.teach.lesson import Lesson, named
from symdyn.teach.masses import Mass

SHORT = 4
"""Terms of a coefficient that stands in a table."""


def rates_step(lesson: Lesson, page: Printable, kind: str, mass: list[Mass]) -> Step:
    """Return a table: each coefficient of a product of velocities, and why it is there or not."""
    rows, slides = [], [unit == "m" for unit in SceneUnits(lesson.scene).velocities]
    for c in page.coefficients:
        if c.kind == kind:
            short = length(c.form) <= SHORT and len(text_of(c.form)) <= WIDEST
            value = c.form if short else lesson.say("long.short", terms=str(length(c.form)))
            why = lesson.say(_why(lesson, c.indices, slides, kind, mass), **_places(lesson, c.indices))
            rows.append((Symbol(coefficient_key(c)), value, why))
    blocks: list[Block] = [lesson.table(("coefficient", "value", "why"), rows)]
    reference = lesson.reference(f"{kind}:1,1") if kind == "k_D" else ""
    if reference:
        node, rate = node_of(lesson, "k_D:1,1"), lesson.state.qd[0]
        lesson.name("k_D torque", "M", "D", "11", node=node * rate * rate)
        product = Form.product((Symbol("k_D:1,1"), named(rate).power(2)))
        blocks.append(Formula("k_D torque", product, lesson.number("k_D:1,1"), Number.ZERO))
    claim, reason = lesson.say(f"meaning.{kind}"), lesson.say(f"meaning.{kind}.reason")
    return Step(f"meaning:{kind}", claim, tuple(blocks), reason, reference)


def _places(lesson: Lesson, indices: tuple[int, ...]) -> dict[str, str | Form | Words]:
    i, j, *rest = indices
    k = rest[0] if rest else j
    qd = list(map(named, lesson.state.qd))
    return {"i": str(i), "j": qd[j - 1], "k": qd[k - 1], "axis": str(j)}


def _why(lesson: Lesson, indices: tuple[int, ...], slides: list[bool], kind: str, result: list[Mass]) -> str:
    """Return the key of the sentence that says why a coefficient is there or not."""
    i, j, k = (indices[0] - 1, indices[1] - 1, indices[-1] - 1)
    along = ".slide" if slides[i] else ""
    if not lesson.vanishes(node_of(lesson, f"{kind}:{','.join(map(str, indices))}")):
        return f"{kind}.acts{along}"
    if slides[j]:
        return f"{kind}.straight"
    if kind == "k_D" and i == j:
        return "k_D.own"
    u = lesson.state.qd
    moved = [mass for mass in result if all(_moves(lesson, mass, u[x]) for x in (i, j, k))]
    if not moved:
        return f"{kind}.apart"
    if not any(_accelerated(lesson, mass, j, k) for mass in moved):
        return f"{kind}.none"
    alone = all((mass.particle or slides[i]) and lesson.vanishes(_share(lesson, mass, i, j, k)) for mass in moved)
    return f"{kind}.{'meets' if alone else 'cancel'}{along}"


def _moves(lesson: Lesson, mass: Mass, rate: Expr) -> bool:
    """Tell whether a rate gives a mass a velocity."""
    kinetic = lesson.names.get(f"K:{mass.tag}")
    return kinetic is not None and not lesson.vanishes(gradient(_node(kinetic), [rate])[0])


def _accelerated(lesson: Lesson, mass: Mass, j: int, k: int) -> bool:
    """Tell whether both rates together accelerate a mass, or change the angular momentum of one that has inertia."""
    state = lesson.state
    felt = tangents(tangents((*mass.place, *(mass.h or ())), state.velocity), state.velocity)  # r̈ where q̈ = 0
    if mass.spins:
        w = angular_velocity(lesson, mass.body)
        x, y, z = tangents(w, state.velocity)
        felt += add(mass.inertia @ (x, y, z), cross(w, mass.inertia @ w))
    return not all(lesson.vanishes(_of_both(lesson, x, j, k)) for x in felt)


def _share(lesson: Lesson, mass: Mass, i: int, j: int, k: int) -> Expr:
    """Return what one mass adds to the coefficient of q̇_j q̇_k in equation i, by its own kinetic energy."""
    state, K = lesson.state, _node(lesson.names[f"K:{mass.tag}"])
    momentum, slope = gradient(K, [state.qd[i]])[0], gradient(K, [state.q[i]])[0]
    force = tangents([momentum], lesson.state.velocity)[0] - slope
    return _of_both(lesson, force, j, k)


def _of_both(lesson: Lesson, node: Expr, j: int, k: int) -> Expr:
    """Return the coefficient of q̇_j q̇_k, of a square twice that."""
    return gradient(gradient(node, [lesson.state.qd[j]])[0], [lesson.state.qd[k]])[0]


def _node(name: Name) -> Expr:
    assert name.node is not None, "an energy has a value"
    return name.node
