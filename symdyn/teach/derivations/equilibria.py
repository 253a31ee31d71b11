"""Steps: places of rest without drives, and motions next to them, to first order.

At rest k_G + k_E = Q. The places are those of `symdyn.linear`: quarter turns are decided exactly; where one angle alone
matters, the others are the sign changes of k_G + k_E - Q in small steps; elsewhere they are what Newton's method finds,
and the lesson says so. A position is stable where the potential of gravity, springs and constant forces has a minimum.

Next to a stable and an unstable place come equations to first order, and frequencies. Formulas are of places that are
known exactly, and hold for all values of the parameters; numbers, also of the mode shapes, are of all places.

Of mechanisms with loops or rolling, rests and the steady motion next to the start are found in numbers. Eigenvalues are
those of `symdyn linearize`, of the motion that loops and rolling leave free.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction

import numpy as np

from symdyn import linear
from symdyn.algebra import Array, Form, Number, Pi, Ratios, Symbol
from symdyn.draw import Stage, swing
from symdyn.dynamics.mechanism import TIME, generalized_forces
from symdyn.errors import DerivationError, DrawError, LinearizeError, SimulateError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, evaluate, gradient, reachable, substitute
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import Joint, Pose
from symdyn.teach.derivations.elsewhere import elsewhere
from symdyn.teach.derivations.reduced import zero
from symdyn.teach.derivations.solved import LONGEST, in_decimals, short_form
from symdyn.teach.derivations.velocities import length
from symdyn.teach.document import Block, Formula, Letter, Matrix, Picture, Section, Step, Words
from symdyn.teach.lesson import Lesson, Prose, named, together
from symdyn.teach.mathematics import eigenvalues
from symdyn.teach.shown_state import Chosen

QUARTERS = (0, 2, 1, -1)
"""Quarter turns in the order in which they are listed."""


@dataclass(frozen=True)
class Rests:
    """All places of rest that were found."""

    lesson: Lesson  # what is told of
    forces: Sequence[Expr]  # k_G + k_E - Q at q̇ = 0, which vanish there
    q: tuple[Expr, ...] = ()  # the coordinates on which they depend
    places: tuple[linear.Equilibrium, ...] = ()  # the exact ones first
    searched: tuple[Words, ...] = ()  # the sentences that say how places were looked for, and what was no such place
    families: tuple[Words, ...] = ()  # the sentences that say that others rest next to some places
    why: str = ""  # the key of the sentence that stands in place of a list; "" where there is one

    def shown(self, place: linear.Equilibrium) -> list[str | Form]:
        """Return a place in print, one entry a coordinate of q."""
        exact, written, state = place.exact, self.lesson.written, self.lesson.state
        if exact is not None:
            return [exact[str(q.value)] for q in self.q]
        return [written(float(place.q[state.q.index(q)])) for q in self.q]

    def where(self, place: linear.Equilibrium) -> list[str | Form]:
        """Return "q1 = 0, q2 ≈ 3.142"."""
        each = zip(self.q, self.shown(place), strict=True)
        return [y for q, x in each for y in (", ", named(q), " ≈ " if isinstance(x, str) else " = ", x)][1:]


def places_of_rest(lesson: Lesson, chosen: Chosen) -> Rests:
    """Return where the mechanism stays at rest without drives."""
    state, graph = lesson.state, lesson.graph
    slopes = gradient(lesson.energy.P, state.q)
    acting = substitute(generalized_forces(lesson.scene, graph), dict.fromkeys(state.qd, graph.zero))
    forces = [a - b for a, b in zip(slopes, acting, strict=True)]
    driven = any(joint.motion is not None for joint in lesson.scene.joints)
    if driven or graph.symbol(TIME) in reachable(forces):
        return Rests(lesson, forces, why="driven")
    if elsewhere(lesson, "rests"):
        return Rests(lesson, forces, tuple(q for q in state.q if q in reachable(forces)), why="elsewhere")
    values = {one.name: chosen.parameters[one.name] for one in lesson.scene.free_parameters}
    found = linear.rests(lesson.scene, values, np.array(chosen.q), chosen.values.get(graph.symbol(TIME), 0.0))
    places, q = (*found.places, *found.locked), tuple(q for q in state.q if str(q.value) not in found.idle)
    if not q:
        return Rests(lesson, forces, why="all" if places else "never")
    listed = Rests(lesson, forces, q, _listed(lesson, q, places), families=families(lesson, found.places, found.more))
    turns = round(found.scanned / math.pi)
    search = lesson.say("equilibria.turn" if turns else "equilibria.newton", starts=str(found.starts))
    if turns > 1:
        least, most = (Form.product((Number(Fraction(k)), Pi())) for k in (-turns, turns))
        search = lesson.say("equilibria.turns", q=named(q[0]), least=least, most=most)
    false = _left_out(listed, _listed(lesson, q, found.false))
    return replace(listed, searched=(search, *false))


def _listed(lesson: Lesson, q: Sequence[Expr], places: Sequence[linear.Equilibrium]) -> tuple[linear.Equilibrium, ...]:
    """Return places in the order in which they are listed: exact ones first, quarter turn by quarter turn."""
    units = SceneUnits(lesson.scene).coordinates
    angles = [k for k, one in enumerate(lesson.state.q) if one in q and units[k] == "rad"]
    exact = [place for place in places if place.exact is not None]
    exact.sort(key=lambda place: [QUARTERS.index(round(2 * place.q[k] / math.pi)) for k in angles])
    return (*exact, *(place for place in places if place.exact is None))


def _left_out(rests: Rests, places: Sequence[linear.Equilibrium]) -> list[Words]:
    """Return the sentence about places where coordinates are singular and the bodies are not at rest, if any are."""
    parts = [part for place in places for part in ("; ", *rests.where(place))][1:]
    return [rests.lesson.say("equilibria.singular", places=Words(tuple(parts)))] if parts else []


def families(lesson: Prose, places: Sequence[linear.Equilibrium], more: int) -> tuple[Words, ...]:
    """Return what is said where others rest next to places, and `more` starts led to further ones."""
    said = [lesson.say("closed.family")] if any(place.family for place in places) else []
    return (*said, *([lesson.say("closed.more", count=str(more))] if more else []))


def equilibrium_step(lesson: Lesson, rests: Rests) -> Step:
    """Return the table of equilibria, or a sentence where every position is one, none is, or time decides."""

    def step(*blocks: Block) -> Step:
        return Step("equilibria", lesson.say("equilibria"), blocks, show=("weights", "forces"))

    if rests.why == "never":
        return Step("equilibria", lesson.say("equilibria.never"), ())
    if rests.why:
        return step(elsewhere(lesson, "rests") or lesson.say(f"equilibria.{rests.why}"))
    if not rests.places:
        return step(lesson.say("equilibria.none"), *rests.searched)
    rows = [
        (
            *rests.shown(place),
            lesson.say(f"equilibria.{place.kind}"),
            lesson.say("equilibria.exact" if place.exact is not None else "equilibria.numeric"),
        )
        for place in rests.places
    ]
    table = lesson.table((*map(named, rests.q), "table.kind", "equilibria.how"), rows)
    idle: list[Form] = [named(q) for q in lesson.state.q if q not in rests.q]
    apart = [lesson.say("equilibria.idle", names=together(idle))] if idle else []
    blocks: list[Block] = [table, *rests.searched, *apart, *rests.families]
    return replace(step(*blocks), reason=lesson.say("equilibria.reason"))


FAULTS = (LinearizeError, SimulateError, DerivationError, DrawError, ArithmeticError, np.linalg.LinAlgError)
"""What says that there is no one linear motion, such as at a parameter without a value."""

MOVES = 1e-9
"""Rates, rad/s or m/s, that are none."""


def closed_sections(
    lesson: Prose, known: Step | None = None, told: Callable[[Array], bool] = lambda q: True
) -> list[Section]:
    """Return where a mechanism with loops or rolling rests, and how it can go on steadily; none where neither is.

    `known` says where it rests without a search; of what a search finds, places that are `told` are listed.
    """
    rest, idle = (known, ()) if known else _rests(lesson, told)
    steps = [step for step in (rest, _steady(lesson, idle)) if step is not None]
    return [lesson.section("after.rests", steps)] if steps else []


def _rests(lesson: Prose, told: Callable[[Array], bool]) -> tuple[Step | None, Sequence[str]]:
    """Return where it rests, None where that is everywhere, and coordinates that do not matter."""
    if left_out := elsewhere(lesson, "rests"):
        return Step("equilibria", left_out, ()), ()
    try:
        found = linear.rests(lesson.scene)
        places, crossings = (tuple(x for x in some if told(x.q)) for some in (found.places, found.crossings))
        found = replace(found, places=places, crossings=crossings)
        systems = found.systems
    except FAULTS:
        return None, ()
    if len(found.idle) == len(lesson.scene.coordinates):
        return None, found.idle
    of = "closed" if lesson.scene.is_constrained else "open"
    searched = lesson.say(f"{of}.search", starts=str(found.starts))
    blocks: list[Block] = [_places(lesson, found.places, found.idle, systems)] if systems else []
    if found.crossings:
        blocks += [lesson.say("closed.crossings"), _places(lesson, found.crossings, found.idle)]
    blocks += [searched] if blocks else [lesson.say("equilibria.none"), searched]
    if found.idle:
        blocks.append(lesson.say("equilibria.idle", names=together([Symbol(name) for name in found.idle])))
    blocks += families(lesson, found.places, found.more)
    reason = lesson.say(f"{of}.reason") if systems else Words(())
    step = Step("equilibria", lesson.say("equilibria"), tuple(blocks), reason, show=("weights", "forces"))
    return step, found.idle


def _places(
    lesson: Prose,
    places: Sequence[linear.Equilibrium],
    idle: Sequence[str],
    systems: Sequence[linear.Linearization] = (),
) -> Block:
    """Return the table of places, without coordinates that do not matter, and what eigenvalues of systems there say."""
    scene, units = lesson.scene, SceneUnits(lesson.scene).coordinates
    told = {one.name: [_attitude(lesson, one, place) for place in places] for one in scene.moving if one.velocities}
    told = {name: words for name, words in told.items() if all(words)}
    bodies = {one.name: one.child for one in scene.moving}
    turned = {q for one in scene.moving if one.name in told for q in one.coordinates[-4:]}
    shown = [k for k, q in enumerate(scene.coordinates) if q not in idle and q not in turned]
    rows: list[list[str | Words]] = [
        [
            *(_with_unit(lesson, float(place.q[k]) + 0.0, units[k]) for k in shown),
            *(lesson.say(words[n], body=bodies[name]) for name, words in told.items()),
        ]
        for n, place in enumerate(places)
    ]
    for row, one in zip(rows, systems, strict=False):  # there may be none
        states = zip(scene.states, one.point.u[len(scene.velocities) :], strict=True)
        row += [_with_unit(lesson, float(x), state.unit or "1") for state, x in states]
        row += [lesson.say(f"closed.{kind_near(one)}"), eigenvalues(_moving(one), lesson.written)]
    heads: list[str | Symbol] = [*(Symbol(scene.coordinates[k]) for k in shown), *["closed.attitude"] * len(told)]
    if systems:
        heads += [*(Symbol(one.name) for one in scene.states), "table.kind", "closed.values"]
    return lesson.table(heads, rows)


def kind_near(one: linear.Linearization) -> str:
    """Return whether motions beside a place, to first order, are "unstable", "undecided", "stable" or "oscillating"."""
    found = one.spectrum
    calm = "stable" if 0 < len(found.modes) == len(found.decaying) else "oscillating"
    return "unstable" if found.growing else "undecided" if "undecided" in one.zero_eigenvalues else calm


def _attitude(lesson: Prose, joint: Joint, place: linear.Equilibrium) -> str:
    """Return the key of how a body hangs on a ball at a place: its centre of mass above or below; "" where neither."""
    scene = lesson.scene
    body = next(one for one in scene.bodies if one.name == joint.child)
    alone = joint.parent == Scene.GROUND and {joint.origin, joint.tip} == {Pose()} and not body.particles
    if not alone or len(joint.coordinates) != 4 or joint.child in {one.parent for one in scene.joints}:
        return ""
    given = {one.name: one.value.at({}) for one in scene.parameters if one.value is not None}
    values = {name: x for name, x in given.items() if x is not None}
    centre, g = ([x.at(values) for x in some] for some in (body.first_moment or body.com or (), scene.gravity))
    if None in centre or None in g:
        return ""
    first = scene.coordinates.index(joint.coordinates[0])
    w, *axis = place.q[first : first + 4]
    c, down = (np.array([float(x or 0) for x in some]) for some in (centre, g))
    turned = c + 2 * np.cross(axis, np.cross(axis, c) + w * c)
    size = float(np.linalg.norm(c) * np.linalg.norm(down))
    along = float(turned @ down)
    return "" if not size or abs(abs(along) - size) > 1e-6 * size else f"closed.{'below' if along > 0 else 'above'}"


def _steady(lesson: Prose, idle: Sequence[str]) -> Step | None:
    """Return the steady motion next to the start, None where it starts at rest or there is none.

    Coordinates that do not matter, `idle`, are not listed.
    """
    if left_out := elsewhere(lesson, "next"):
        return Step("steady", left_out, ())
    scene = lesson.scene
    try:
        found = linear.steady_at_start(scene)
    except FAULTS:
        return None
    if found is None:
        return None
    one, turning = found
    units, rates = SceneUnits(scene).coordinates, SceneUnits(scene).velocities
    moving = np.abs(turning) > MOVES
    free = {*one.dropped, *one.cyclic, *idle}
    q = [k for k, name in enumerate(scene.coordinates) if not (name in free or moving[k] or units[k] == "1")]
    u = [k for k, x in enumerate(one.point.u) if abs(x) > MOVES]
    rows = [(Symbol(scene.coordinates[k]), _with_unit(lesson, float(one.point.q[k]), units[k])) for k in q]
    rows += [(Symbol(scene.velocities[k]), f"{lesson.written(float(one.point.u[k]))} {rates[k]}/s") for k in u]
    verdict = lesson.say(f"closed.{kind_near(one)}")
    how = "led" if scene.prescribed_velocities else "driven" if any(scene.drives) else ""
    key = f"closed.next.{how}".rstrip(".")
    told = lesson.say(key, kind=verdict, values=eigenvalues(_moving(one), lesson.written))
    blocks = (lesson.table(("table.symbol", "table.value"), rows), told)
    claim, reason = lesson.say("closed.steady"), lesson.say("closed.steady.reason")
    return Step("steady", claim, blocks, reason, show=("centrifugal",))


def _with_unit(lesson: Prose, x: float, unit: str) -> str:
    return lesson.written(x) if unit == "1" else lesson.scene.in_shown_unit(lesson.written(x), unit)


def _moving(one: linear.Linearization) -> list[complex]:
    """Return the eigenvalues that are not zero."""
    return [mode.value for mode in one.modes if mode.value]


MOST_FREEDOMS = 3
"""Of formulas and pictures; numbers are told of more."""

ANGLE, PART = 0.35, 0.15
"""The largest displacement in a picture: of an angle, rad, and of a length over the extent of the mechanism."""

TAGS = {"stable": "s", "unstable": "u"}

Modes = Sequence[tuple[float, Array]]
"""ω² and shapes, the number of each in print its place."""


def near_rest_steps(lesson: Lesson, rests: Rests, chosen: Chosen) -> list[Step]:
    """Return, of a stable and of an unstable place, equations to first order, frequencies and shapes."""
    steps: list[Step] = []
    for kind in TAGS:
        place = next((one for one in rests.places if one.kind == kind), None)
        if place is not None and place.near.of(place.near.moved).moves:
            reason = Words(()) if steps else lesson.say("near.reason")
            claim = lesson.say(f"near.{kind}", where=Words(tuple(rests.where(place))))
            blocks = _blocks(lesson, rests, place, chosen)
            steps.append(Step(f"near:{kind}", claim, blocks, reason, show=("angles", "weights", "forces")))
    return steps


def _blocks(lesson: Lesson, rests: Rests, place: linear.Equilibrium, chosen: Chosen) -> tuple[Block, ...]:
    moved, blocks = place.near.moved, list[Block]()
    near, modes = place.near.of(moved), place.near.of(moved).modes
    idle = [k for k in range(lesson.state.n) if k not in moved]
    massless = [k for k in idle if zero(lesson, gradient(lesson.momenta[k], [lesson.state.qd[k]])[0])]
    for key, some in (("massless", massless), ("singular", [k for k in idle if k not in massless])):
        if some:
            blocks.append(lesson.say(f"near.{key}", names=together([named(lesson.state.q[k]) for k in some])))
    if place.exact is not None and len(moved) <= MOST_FREEDOMS:
        blocks += _formulas(lesson, rests, place, modes, chosen)
    if near.symmetric:
        blocks += _modes(lesson, place, modes, chosen)
        if any(square < 0 for square, _ in modes):
            blocks.append(lesson.say("near.negative"))
    if np.abs(near.D).max() > 0 or not near.symmetric:
        values = [*(mode.value for mode in near.spectrum.modes), *([0j] if near.spectrum.zeros else [])]
        told = eigenvalues(sorted(values, key=lambda x: (-x.real, x.imag)), lesson.written)
        blocks.append(lesson.say("near.damped" if near.symmetric else "near.turned", values=told))
    return tuple(blocks)


def _formulas(lesson: Lesson, rests: Rests, place: linear.Equilibrium, modes: Modes, chosen: Chosen) -> list[Block]:
    """Return inertia and stiffness, and the frequencies that have a short formula."""
    state, moved, tag = lesson.state, place.near.moved, TAGS[place.kind]
    n, names = len(moved), [str(k + 1) for k in moved]
    exact = {q: place.exact[str(q.value)].express(lesson.graph) for q in rests.q} if place.exact else {}
    M = [gradient(lesson.momenta[k], [state.qd[j] for j in moved]) for k in moved]
    K = [gradient(rests.forces[k], [state.q[j] for j in moved]) for k in moved]
    matrices = [[substitute(row, exact) for row in rows] for rows in (M, K)]
    shown = [[short_form(lesson, x) for row in matrix for x in row] for matrix in matrices]
    if max(length(x) for forms in shown for x in forms) > LONGEST:
        return []
    blocks: list[Block] = [lesson.say("near.drop")]
    for letter, matrix, forms in zip((lesson.letters.mass_matrix, "K"), matrices, shown, strict=True):
        keys = [f"near:{tag}:{letter}:{i},{j}" for i in names for j in names]
        entries = [x for row in matrix for x in row]
        for key, node in zip(keys, entries, strict=True):
            lesson.name(key, letter, tag, *([] if n == 1 else key.rpartition(":")[2].split(",")), node=node)
        if n == 1:
            blocks.append(Formula(keys[0], forms[0]))
        else:
            whole = lesson.called(f"near:{tag}:{letter}", Letter(letter, (tag,)))
            blocks.append(Matrix(whole.name, tuple(forms), tuple(keys), width=n))
    return [*blocks, *_frequencies(lesson, matrices, modes, tag, chosen)]


def _frequencies(
    lesson: Lesson, matrices: Sequence[Sequence[Sequence[Expr]]], modes: Modes, tag: str, chosen: Chosen
) -> list[Block]:
    """Return ω² by the factors of det(C - ω² A) = 0 that are of first and second degree in ω², numbered as shapes."""
    n, flat = len(matrices[0]), [x for matrix in matrices for row in matrix for x in row]
    try:
        field = Ratios(flat)
        known = evaluate(flat, field, field.values())
        rows = [known[k : k + n] for k in range(0, len(known), n)]
        found = field.factors(field.characteristic(field.solved(rows[:n], rows[n:])))
    except (ZeroDivisionError, OverflowError):
        return []
    shown: dict[int, list[Block]] = {}
    left = dict(enumerate((square for square, _ in modes), 1))
    for monic, times in found:
        forms = [in_decimals(field.form(x)) for x in monic[1:]]
        roots = np.roots([1.0, *chosen.of(*(x.express(lesson.graph) for x in forms))]).real
        count, *_ = sorted(_taken(left, float(root)) for root in np.repeat(roots, times))
        key, index = f"near:{tag}:omega:{count}", (tag, str(count)) if len(found) > 1 else (tag,)
        if monic[-1].is_zero or len(monic) > 3 or max(map(length, forms)) > LONGEST:
            continue
        if len(monic) == 2:
            square = forms[0].negative
            lesson.name(key, "omega", *index, node=square.express(lesson.graph), power=2)
            shown[count] = [Formula(key, square)]
        else:
            sum_, product = forms[0].negative, forms[1]
            omega = lesson.name(key, "omega", *index, node=None)
            b = lesson.name(f"{key}:b", "b", *index, node=sum_.express(lesson.graph))
            d = lesson.name(f"{key}:d", "d", *index, node=product.express(lesson.graph))
            whole = Form.sum((omega.power(4), Form.product((Number.MINUS_ONE, b, omega.power(2))), d))
            shown[count] = [lesson.say("near.two", equation=whole), Formula(b.name, sum_), Formula(d.name, product)]
    blocks = [block for count in sorted(shown) for block in shown[count]]
    if blocks:
        symbol = lesson.name(f"near:{tag}:omega", "omega", tag, node=None)
        M, K = (Symbol(f"near:{tag}:{letter}") for letter in (lesson.letters.mass_matrix, "K"))
        pencil = Form.sum((K, Form.product((Number.MINUS_ONE, symbol.power(2), M))))
        said = lesson.say("near.frequencies", omega=symbol, matrix=pencil)
        blocks.insert(0, lesson.say("near.frequency", omega=symbol, square=symbol.power(2)) if n == 1 else said)
    return blocks


def _taken(left: dict[int, float], square: float) -> int:
    """Return the number of the shape whose ω² is nearest, which is taken from those left."""
    count = min(left, key=lambda k: abs(left[k] - square))
    del left[count]
    return count


# Numbers


def _modes(lesson: Lesson, place: linear.Equilibrium, modes: Modes, chosen: Chosen) -> list[Block]:
    """Return the table of frequencies and shapes, and a picture of every shape that swings; of one freedom a line."""
    rows, moved = list[list[str | Form | Words]](), place.near.moved
    for k, (square, shape) in enumerate(modes, 1):
        root = abs(square) ** 0.5
        kind = "swing" if square > 0 else "leave" if square < 0 else "drift"
        time = f"{lesson.about(2 * np.pi / root if square > 0 else 1 / root)} s" if square else ""
        told = lesson.text(f"near.mode.{kind}", rate=lesson.equals(root), time=time)
        rows.append([str(k), told, *(lesson.written(float(x)) for x in shape)])
    if len(rows) == 1:
        return [lesson.say("near.one", told=str(rows[0][1]))]
    heads: list[str | Symbol] = ["near.mode", "near.mode.kind", *(named(lesson.state.q[k]) for k in moved)]
    blocks: list[Block] = [lesson.say("near.modes"), lesson.table(heads, rows)]
    for k, (square, shape) in enumerate(modes, 1):
        if square > 0 and place.kind == "stable" and len(moved) <= MOST_FREEDOMS:
            whole = np.zeros(len(place.q))
            whole[list(moved)] = shape
            blocks.append(_picture(lesson, chosen, place.q, whole, k))
    return blocks


def _picture(lesson: Lesson, chosen: Chosen, rest: Array, shape: Array, number: int) -> Picture:
    """Return the picture of one shape about a place of rest; q and shape have shape (nq,)."""
    scene, values = lesson.scene, chosen.parameters
    length = Stage(scene, rest[None], values).places.reach
    limits = np.array([ANGLE if unit == "rad" else PART * length for unit in SceneUnits(scene).coordinates])
    away = shape / float((np.abs(shape) / limits).max())
    title = lesson.text("near.shape.alt", number=str(number), scene=scene.name)
    stage = Stage(scene, np.stack([rest + away, rest, rest - away]), values)
    text = swing(stage, title, lesson.text("near.ghosts"), f"mode{number}-", lesson.titles)
    return Picture(text, lesson.say("near.shape", number=str(number)), title, f"mode{number}")
