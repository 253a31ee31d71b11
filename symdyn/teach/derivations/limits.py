"""Limits: cases in which a result must be what everybody knows, as one parameter after the other vanishes.

Nothing to carry, no gravity, a point mass, no friction, no force in time. What is said of bodies is derived a second
time, from a scene that has the limit beforehand.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from symdyn.algebra import Form, Symbol, with_squares
from symdyn.dynamics import Energies
from symdyn.dynamics.mechanism import TIME, generalized_forces, prescribed
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Op, gradient, reachable, substitute
from symdyn.scene import Quantity, Scene
from symdyn.scene.forces import FORCES
from symdyn.teach.derivations.reduced import led_by, zero
from symdyn.teach.derivations.velocities import kinetic_form, length
from symdyn.teach.document import Step, Words
from symdyn.teach.lesson import Lesson, Mass, named, together

LONGEST = 26
"""Terms and factors of an energy that fits into a table."""


@dataclass(frozen=True)
class Limit:
    """What is left without some parameters: a mass goes with the letters of inertia that its body alone has.

    Attributes:
        without: the parameters that vanish.
        K, P, Q: energies, and the forces beside weights and springs.
        of_energies: whether K or P changes.
    """

    without: tuple[Expr, ...]
    K: Expr
    P: Expr
    Q: tuple[Expr, ...]
    of_energies: bool

    @property
    def letters(self) -> Words:
        """The parameters, with commas between."""
        return together([named(symbol) for symbol in self.without])

    def of(self, nodes: Sequence[Expr]) -> list[Expr]:
        """Return what is left of nodes."""
        return substitute(nodes, dict.fromkeys(self.without, self.K.graph.zero))


def vanishing(lesson: Lesson) -> Iterator[Limit]:
    """Yield the limit of each parameter that may go to zero and of which energies or forces know."""
    graph, energy = lesson.graph, lesson.energy
    known = [energy.K, energy.P, *generalized_forces(lesson.scene, graph)]
    for parameter in lesson.scene.parameters:
        symbol = graph.symbol(parameter.name)
        try:
            without = (symbol, *_own_letters(lesson, symbol))
            K, P, *Q = substitute(known, dict.fromkeys(without, graph.zero))
        except ZeroDivisionError:
            continue
        changed = [x is not y and not zero(lesson, x - y) for x, y in zip((K, P, *Q), known, strict=True)]
        limit = Limit(without, K, P, tuple(Q), any(changed[:2]))
        left = [(mass.m, *limit.of(_entries(mass))) for mass in lesson.masses]
        empty = any(m.is_zero and not (whole.is_zero or _nothing(inertia)) for whole, m, *inertia in left)
        if any(changed) and not empty:  # nor is an inertia left without its mass
            yield limit


def _entries(mass: Mass) -> list[Expr]:
    return [mass.m, *(x for row in mass.inertia for x in row)]


def _nothing(nodes: Sequence[Expr]) -> bool:
    return all(x.is_zero for x in nodes)


def _own_letters(lesson: Lesson, symbol: Expr) -> list[Expr]:
    """Return the letters of an inertia that would be left without a mass, where nothing else knows them."""
    for mass in lesson.masses:
        m, *inertia = substitute(_entries(mass), {symbol: lesson.graph.zero})
        if m.is_zero and not mass.m.is_zero:
            others = [x for one in lesson.masses if one is not mass for x in (*_entries(one), *one.place)]
            shared = set(reachable([*others, *mass.place]))
            return [x for x in reachable(inertia) if x.op is Op.SYMBOL and x not in shared]
    return []


def limits_step(lesson: Lesson) -> Step | None:
    """Return what is left as one parameter after the other vanishes; None where nothing is known of it."""
    alike: dict[tuple[Form | Words, ...], list[Words]] = {}  # what is left, and without what
    derived, same = False, lesson.say("limits.same")
    for one in vanishing(lesson):
        try:
            shown = _shown(lesson, one.K, one.P) if one.of_energies else (same, same)
        except (DerivationError, KeyError):
            continue
        bodies = dict(lightened(lesson, one))
        told = [lesson.say(f"limits.{key}", body=body) for body, key in bodies.items()]
        said = [*_moves(lesson, one), *told, *_acts(lesson, one)]
        if shown and said:
            derived = derived or bool({"smaller", "point", "unsprung"} & {*bodies.values()})
            alike.setdefault((*shown, in_a_row(said)), []).append(one.letters)
    for letters, *left in _stopped(lesson):
        alike.setdefault(tuple(left), []).append(letters)
    if not alike:
        return None
    rows = [(in_a_row([Words((*x.parts, "\u00a0→\u00a00")) for x in some]), *left) for left, some in alike.items()]
    table = lesson.table(("limits.limit", Symbol("K:"), Symbol("P:"), "limits.left"), rows)
    checks = (lesson.say("limits.derived"),) if derived else ()
    return Step("limits", lesson.say("limits"), (table, *checks), show=("energies", "ghost"))


def in_a_row(said: Sequence[Words]) -> Words:
    """Return sentences with semicolons between."""
    return Words(tuple(part for words in said for part in ("; ", *words.parts))[1:])


def _shown(lesson: Lesson, K: Expr, P: Expr) -> tuple[Form, Form] | None:
    """Return energies as a table has them; None for long ones."""
    shown = (kinetic_form(lesson, K), with_squares(lesson.short(P)))
    return shown if max(map(length, shown)) <= LONGEST else None


def _stopped(lesson: Lesson) -> Iterator[tuple[Words, Form | Words, Form | Words, Words]]:
    """Yield the row of each parameter without which prescribed motions stand still."""
    led, graph = prescribed(lesson.scene, lesson.graph), lesson.graph
    (K,) = substitute([lesson.energy.K], {lesson.state.qd[k]: graph.zero for k in led.place})
    names = together([named(lesson.state.q[k]) for k in led.place])
    for symbol in [graph.symbol(one.name) for one in lesson.scene.parameters] if led.place else ():
        left = substitute(led.velocity, {symbol: graph.zero})
        stands = symbol in reachable(led.velocity) and all(zero(lesson, x) for x in left)
        if stands and (shown := _shown(lesson, K, lesson.energy.P)):
            yield Words((named(symbol),)), *shown, lesson.say("limits.still", names=names)


def forgotten(lesson: Lesson, one: Limit) -> tuple[list[Form], list[Form]]:
    """Return coordinates whose rates move nothing, and those on which L no longer depends, in a limit."""
    state, slopes = lesson.state, gradient(one.K - one.P, lesson.state.q)
    idle = [k for k, u in enumerate(state.qd) if zero(lesson, gradient(one.K, [u])[0])]
    free = [k for k in range(state.n) if k not in (*idle, *led_by(lesson))]
    cyclic = [k for k in free if zero(lesson, slopes[k]) and not zero(lesson, lesson.slopes[k])]
    return [named(state.q[k]) for k in idle], [named(state.q[k]) for k in cyclic]


def _moves(lesson: Lesson, one: Limit) -> Iterator[Words]:
    """Yield what is said of energies: coordinates without mass, or that L does not know, and that it rests."""
    idle, cyclic = forgotten(lesson, one)
    if idle:
        yield lesson.say("limits.idle", names=together(idle))
    if cyclic:
        yield lesson.say("limits.cyclic", names=together(cyclic))
    before = generalized_forces(lesson.scene, lesson.graph)
    if not idle and _level(lesson, one.P, one.Q) and not _level(lesson, lesson.energy.P, before):
        yield lesson.say("limits.level")


def _at_rest(lesson: Lesson, forces: Sequence[Expr]) -> list[Expr]:
    return substitute(forces, dict.fromkeys(lesson.state.qd, lesson.graph.zero))


def _level(lesson: Lesson, P: Expr, forces: Sequence[Expr]) -> bool:
    """Whether it rests wherever it is."""
    try:
        pulls = [*_at_rest(lesson, forces), *gradient(P, lesson.state.q)]
    except ZeroDivisionError:  # a force divides by a rate
        return False
    return not led_by(lesson) and all(zero(lesson, x) for x in pulls)


def _acts(lesson: Lesson, one: Limit) -> Iterator[Words]:
    """Yield what is said of forces: whether time still acts, what is conserved, along what nothing is left to act."""
    state, graph = lesson.state, lesson.graph
    before, clock = generalized_forces(lesson.scene, graph), {graph.symbol(TIME), *state.clock}
    timed = [not clock.isdisjoint(reachable(forces)) for forces in (before, one.Q)]
    if timed == [True, False] and _nothing(_at_rest(lesson, one.Q)):
        yield lesson.say("limits.free" if lesson.energy.E.is_zero else "limits.vibrates")
    braked = [not set(state.qd).isdisjoint(reachable(forces)) for forces in (before, one.Q)]
    if timed == [True, True] and braked == [True, False] and not lesson.energy.E.is_zero:
        yield lesson.say("limits.resonance")
    free = [k for k in range(state.n) if not before[k].is_zero and one.Q[k].is_zero]
    if not free or led_by(lesson) or not clock.isdisjoint(reachable([lesson.L])):
        return
    slopes = gradient(one.K - one.P, state.q)
    kept: list[Form] = [named(state.q[k]) for k in free if zero(lesson, slopes[k])]
    released = [name for name in (named(state.q[k]) for k in free) if name not in kept]
    if _nothing(one.Q):
        yield lesson.say("limits.conserved", total=Form.sum((Symbol("K:"), Symbol("P:"))))
    elif released:
        yield lesson.say("limits.released", names=together(released))
    if kept:
        yield lesson.say("limits.kept", names=together(kept))


def lightened(lesson: Lesson, one: Limit) -> Iterator[tuple[str, str]]:
    """Yield what is left out, proved by a scene without it, new point masses, likewise, and bodies without inertia."""
    for mass in lesson.masses:
        m, *inertia = one.of(_entries(mass))
        if mass.spins and _nothing(inertia) and mass.m.is_zero:
            yield mass.body.name, "light"
        elif mass.spins and _nothing(inertia) and mass.h is None and not m.is_zero:
            point = replace(mass.body, inertia=(Quantity.ZERO,) * 6)
            bodies = tuple(point if other is mass.body else other for other in lesson.scene.bodies)
            _assert_same(lesson, one, replace(lesson.scene, bodies=bodies))
            yield point.name, "point"
    if body := smaller_by(lesson, one):
        yield body, "smaller"
    x, pulls = lesson.graph.symbol("x:"), [(one, FORCES[one.kind].pull.energy) for one in lesson.scene.struts]
    laws = {one.name: energy(one, x) for one, energy in pulls if energy is not None}
    gone = [name for name, law in laws.items() if not law.is_zero and _nothing(one.of([law]))]
    if gone:
        others = tuple(x for x in lesson.scene.elements if x.name not in gone)
        _assert_same(lesson, one, replace(lesson.scene, elements=others))
        yield ", ".join(gone), "unsprung"


def _assert_same(lesson: Lesson, one: Limit, scene: Scene) -> None:
    """Compare energies of a limit with those of a scene that has it beforehand; parameters may stand there, too."""
    other = Energies.of(scene, lesson.graph)
    K, P = one.of([other.K, other.P])
    same = zero(lesson, one.K - K) and zero(lesson, one.P - P)
    assert same, f"without {one.without} the energies are others: one of the two derivations is wrong"


def smaller_by(lesson: Lesson, one: Limit) -> str:
    """Return the body without which the mechanism has the same energies, since it weighs nothing; "" for none."""
    for body in lesson.scene.bodies:
        smaller = without(lesson.scene, body.name)
        weighs = [x for mass in lesson.masses if mass.body.name == body.name for x in _entries(mass)]
        if smaller is None or not weighs or not _nothing(one.of(weighs)):
            continue
        others = [mass.m for mass in lesson.masses if mass.body.name != body.name and not mass.m.is_zero]
        if any(x.is_zero for x in one.of(others)):
            continue  # the same letter weighs another body, which would stay
        _assert_same(lesson, one, smaller)
        return body.name
    return ""


def without(scene: Scene, body: str) -> Scene | None:
    """Return an open scene without one of its last bodies; None where something else is fixed to it."""
    (joint,) = [joint for joint in scene.joints if joint.child == body]
    if len(scene.bodies) < 2 or scene.is_constrained or scene.elements or joint.armature != Quantity.ZERO:
        return None
    if joint.coupling or scene.followed.intersection(joint.coordinates) or body in (one.parent for one in scene.joints):
        return None
    return replace(
        scene,
        bodies=tuple(one for one in scene.bodies if one.name != body),
        joints=tuple(one for one in scene.joints if one is not joint),
        points=tuple(one for one in scene.points if one.body != body),
        outputs=(),
    )
