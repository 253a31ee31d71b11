"""What students get when they forget a rule: typical wrong results, each with the rule, from the scene's own equations.

Three tables make them: energies of a course in which one part of one mass (or of all) is treated wrongly, steps from
energies to equations of which one is left out, and terms of the right formula that are lost, turned or misread. Both
checkers look a wrong answer up among them: the shell exactly, the page by values. Equations may also be divided but for
one term.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from itertools import islice, permutations

from symdyn.algebra import Floats
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Op, evaluate, reachable
from symdyn.scene import SceneUnits
from symdyn.teach.student.course import Course
from symdyn.teach.student.wrong_energies import Wrong, used, wrong_energies, wrong_terms


def _number(key: str) -> int:
    return int(key.partition(":")[2]) - 1


def _energies(course: Course) -> tuple[Expr, Expr]:
    e, graph = course.right, course.graph
    return graph.total(e.K.values()), graph.total(e.P.values())


def _of_equations(course: Course, key: str) -> Iterator[Wrong]:
    i, (K, P) = _number(key), _energies(course)
    state, zero, Q = course.state, course.graph.zero, course.right.Q[_number(key)]
    inertial, product, kinetic, potential = course.steps(i, K, P)
    static = potential - Q
    right = inertial + product - kinetic + static
    rates, slopes = _by_rates(course, product), _by_rates(course, kinetic)
    yield from (("product", right - x) for x in (product, *rates))
    yield "chain", right - 2 * product
    yield from (("slope", right + times * x) for x in (kinetic, *slopes) for times in (1, 2))
    yield from (("slope", right + x) for x in (rates if _adds(course, right, kinetic) else ()))
    yield "velocities", inertial + static
    elastic = course.slope(course.right.P["E"], state.q[i])
    stored = (("spring", elastic), ("gravity", potential - elastic), ("energies", potential))
    yield from ((rule, right - 2 * x) for rule, x in stored if not x.is_zero)
    for rule, of in course.beside.items():
        yield from ((rule, right + times * of[i]) for times in (1, 2))
    for rule, x in (("velocities", product - kinetic), ("product", product), ("slope", -kinetic)):
        if _adds(course, right, x):  # else the load alone is lost
            yield from ((rule, right - x + times * course.loads[i]) for times in (1, 2))
    alone, still = _alone(course, i)
    yield from (("coupling", course.put(right, values)) for values in (alone, still))
    momenta = (course.slope(course.right.K[part.tag], state.qd[i]) for part in course.parts)
    own = [course.slope(p, state.qd[i]) * state.qdd[i] for p in momenta]  # of each mass alone, M_ii q̈_i
    simple = (course.put(inertial, alone), *own)
    yield from (("coupling", x + P + rest) for rest in (-Q, zero) for x in simple for P in (potential, zero))


def _of_rates(course: Course, key: str) -> Iterator[Wrong]:
    K, P = _energies(course)
    i = [str(u.value) for u in course.state.qd].index(key.partition(":/d")[2])
    inertial, product, kinetic, potential = course.steps(i, K, P)
    right = inertial + product
    yield from (("product", right - x) for x in (product, *_by_rates(course, product)))
    p = course.slope(K, course.state.qd[i])
    without_rates = course.graph.total(course.slope(p, q) for q in course.state.q)
    yield from (("chain", inertial - product), ("chain", inertial + without_rates))
    yield from (("slope", right - kinetic), ("slope", right - kinetic + potential))
    yield "undifferentiated", p


def _of_slopes(course: Course, key: str) -> Iterator[Wrong]:
    K, P = _energies(course)
    state, name = course.state, key.partition(":/d")[2]
    rates = [str(u.value) for u in state.qd]
    symbols = state.qd if name in rates else state.q
    i = [str(x.value) for x in symbols].index(name)
    _, _, kinetic, potential = course.steps(i, K, P)
    momentum = course.slope(K, state.qd[i])
    if name in rates:
        yield from (("variable", kinetic - potential), ("variable", kinetic))
        yield from (("factor", momentum / 2), ("factor", momentum * 2))
    else:
        yield from (("slope", -potential), ("slope", -kinetic - potential), ("weightless", kinetic))
        yield from (("gravity", x) for x in (kinetic + potential, potential, -kinetic + potential))
        yield from (("variable", x) for x in (momentum, course.slope(momentum, state.qd[i]) * state.qd[i]))
        stored = (node for node in course.right.P.values() if not node.is_zero)
        yield from (("undifferentiated", kinetic - potential + course.slope(x, state.q[i]) - x) for x in stored)
        slopes = (course.slope(node, q) for node in (*course.right.P.values(), P) for q in state.q)
        yield from (("direction", kinetic - potential - x) for x in slopes)
        yield from (("direction", kinetic - potential - x) for force in _forces(course) for x in (force, -force))
    yield from (("index", course.slope(K - P, x)) for j, x in enumerate(symbols) if j != i)


def _of_coefficients(course: Course, key: str) -> Iterator[Wrong]:
    kind, _, of = key.partition(":")
    K, P = _energies(course)
    at, n = [int(x) - 1 for x in of.split(",")], course.state.n

    def worth(indices: Sequence[int], energy: Expr = K) -> Expr:
        return course.coefficient(kind, indices, energy, course.right.P)

    right = worth(at)
    if kind in ("k_C", "k_D"):
        yield "convention", -right
        _, product, kinetic, _ = course.steps(at[0], K, P)
        a, b = (course.state.qd[k] for k in (at[1:3] if kind == "k_C" else (at[1], at[1])))
        for rule, form in (("slope", product), ("product", -kinetic), ("slope", product + kinetic),
                           ("chain", -product - kinetic), ("slope", kinetic)):  # fmt: skip
            second = course.slope(course.slope(form, a), b)
            yield rule, second / 2 if kind == "k_D" else second
    if kind in ("k_G", "k_E"):
        yield "gravity" if kind == "k_G" else "spring", -right
        yield from (("undifferentiated", node) for node in course.right.P.values() if not node.is_zero)
    else:
        yield from (("factor", right / 2), ("factor", right * 2))
    yield from (("index", worth(other)) for other in permutations(range(n), len(at)) if len(at) < 3)
    for j in range(n) if kind == "k_z" else ():
        yield "index", worth((j, j))
        yield from (("index", worth((j, j), course.kinetic(part))) for part in course.parts)
        if list(at) == [j, j] or at[0] == at[1]:
            yield from (("steiner", worth((j, j), course.kinetic(part, cross=0))) for part in course.parts)


STEPS: tuple[tuple[str, Callable[[Course, str], Iterator[Wrong]]], ...] = (
    ("tau:", _of_equations),
    ("d/dt dL:/d", _of_rates),
    ("dL:/d", _of_slopes),
    ("k_", _of_coefficients),
)
"""What a key begins with, and the steps to such a quantity that go wrong."""


def _of_physics(course: Course, key: str, right: Expr) -> Iterator[Wrong]:
    """Yield what the answer to a question of physics is taken for: ω² or a period, a part of a force, a quotient."""
    graph, turn = course.graph, 2 * course.graph.pi
    if key == "physics:frequency":
        yield from (("root", right**2), ("period", turn / right), ("hertz", right / turn))
    elif key == "physics:reaction":
        still = course.put(right, dict.fromkeys(course.state.qd, graph.zero))
        yield from (("centripetal", one) for one in (still, right - still, 2 * still - right))
        yield from (("arm", one) for one in (2 * right - still, (right + still) / 2))
    if key.startswith("physics:"):
        yield "overturned", 1 / right


def _alone(course: Course, i: int) -> tuple[dict[Expr, Expr], dict[Expr, Expr]]:
    """Return the accelerations of all joints but one as zero, and with them their rates."""
    qd, qdd = (
        {x[k]: course.graph.zero for k in range(course.state.n) if k != i} for x in (course.state.qd, course.state.qdd)
    )
    return qdd, qdd | qd


def _uncoupled(course: Course, i: int) -> Iterator[Wrong]:
    """Yield equations of one joint alone, with a mass taken for another one: a simple pendulum."""
    for rule, _, other in wrong_energies(course):
        if rule in ("arm", "inertia", "steiner"):
            node = _known(course.value(f"tau:{i + 1}", other))
            yield from (("coupling", course.put(node, values)) for values in _alone(course, i))


def _undivided(course: Course, i: int) -> Iterator[Wrong]:
    """Yield equations that were divided, by a coefficient or a parameter, but for one of their terms."""
    state, graph = course.state, course.graph
    total = _known(course.value(f"tau:{i + 1}", course.right))
    own = {a: M for a in state.qdd if _adds(course, total, M := course.slope(total, a))}
    units = SceneUnits(course.scene).inferred  # a ratio is left out or forgotten, nothing is divided by it
    names = [graph.symbol(p.name) for p in course.scene.parameters if units[p.name] != "1"]
    powers = [x for name in used(graph.total(own.values()), names) for x in (name, name * name)]
    drive = course.scene.drives[i]
    pieces = [-graph.symbol(drive)] if drive else []
    try:
        pieces += [one.express(graph) for one in course.terms(total)]
    except DerivationError:
        return
    shares = [x for x in pieces if any(_adds(course, x, course.slope(x, a)) and x != M * a for a, M in own.items())]
    pieces = [x for x in pieces if x not in shares]  # one of two masses is not divided apart from the other
    yield from (("undivided", total + (by - graph.one) * piece) for by in (*own.values(), *powers) for piece in pieces)
    yield from (("undivided", total + (graph.one - M) * a) for a, M in own.items())


def _adds(course: Course, node: Expr, x: Expr) -> bool:
    """Whether something is not zero, by its value beside something else."""
    return not x.is_zero and _mark(course, node + x, free=False) != _mark(course, node, free=False)


def _by_rates(course: Course, node: Expr) -> list[Expr]:
    """Return the parts of a quadratic form that hold one rate each."""
    return [node - course.put(node, {u: course.graph.zero}) for u in used(node, course.state.qd)]


def _forces(course: Course) -> Iterator[Expr]:
    """Yield weights times the sine or cosine of a coordinate."""
    g = next((x for x in course.gravity if not x.is_zero), None)
    if g is None:
        return
    units = SceneUnits(course.scene).coordinates
    masses = [part.m for part in course.parts]
    tails = [course.graph.total(masses[k:]) for k in range(len(masses))]
    angles = [q for unit, q in zip(units, course.state.q, strict=True) if unit == "rad"]
    for m in (course.graph.total(masses), *masses, *tails):
        yield from (m * g * of(q) for q in angles for of in (course.graph.sin, course.graph.cos))
        yield m * g


def _known(node: Expr | None) -> Expr:
    assert node is not None, "an equation has a value"
    return node


VAGUE = ("term", "termgravity", "termsign", "termfactor", "turned")
"""Rules that say less than another one of the same result."""

STATES: Mapping[str, tuple[str, str, str]] = {
    "gravity": ("termgravity", "gravity", "termfactor"),
    "weight": ("weightless", "gravity", "termfactor"),
    "spring": ("spring", "spring", "termfactor"),
    "springs": ("term", "spring", "termfactor"),  # all of it; "spring" is what a free length makes
    "friction": ("friction", "friction", "termfactor"),
    "law": ("term", "friction", "termfactor"),  # a part of one, as of dry friction that falls with speed
    "force": ("force", "force", "termfactor"),
    "flow": ("term", "termsign", "termfactor"),
    "rates": ("velocities", "termsign", "termfactor"),
    "slope": ("slope", "slope", ""),
    "cancelling": ("slope extra", "slope", ""),  # a term is left that the slope would take away
    "product": ("product", "", ""),
    "static": ("", "energies", ""),
    "spin": ("inertia", "", "inertia termfactor"),
    "turner": ("body", "", "inertia termfactor"),  # a body that turns and no more
    "steiner": ("steiner", "", ""),
    "body": ("body", "", ""),
    "carried": ("carried", "", ""),
    "hung": ("carried", "gravity", "termfactor"),
    "coupling": ("coupling", "termsign", "termfactor"),
    "cross": ("cross", "cross", "termfactor"),
    "inertia": ("term", "termsign", "termfactor"),
    "drive": ("drive", "termsign", "termfactor"),
    "row": ("untied", "termsign", "termfactor"),
    "prescribed": ("prescribed", "", ""),
    "steady": ("steady", "", ""),
    "relative": ("relative", "", ""),
    "along": ("carried relative", "", ""),  # a moment of inertia by the relative acceleration alone
    "absolute": ("absolute", "", ""),
}
"""Rules that a column of a kind tells where it is lost, turned, or has another factor; "" for none."""
PLAIN = ("term", "termsign", "termfactor")
"""What a term tells whose kind has no rule for it."""
SUITS: Mapping[str, tuple[str, ...]] = {
    "gravity": ("height", "direction", "weightless"),
    "rates": ("product", "slope", "chain", "cross", "relative"),
    **dict.fromkeys(("inertia", "body", "carried", "cross"), ("half", "carried", "relative", "cross", "arm")),
    "coupling": ("carried", "relative", "cross"),
    "drive": ("body", "half"),  # with a factor: all the rest has one
}
"""Rules found otherwise that explain what differs in a term of a kind."""
ALL_OF_IT = ("turned", "factor", "half", "ratio")
"""Rules found otherwise that say more than terms do."""
OF_RATES = ("slope", "velocities", "product")
"""Rules found otherwise by which rates are lost that a relative rate may explain as well."""
LEAVES_OUT = (*OF_RATES, "weightless", "body", "carried", "coupling", "spring", "force", "friction")
"""Rules that tell why a result is zero: what is not there has no wrong symbol, distance or angle."""
SWAPPED = (("trig",), ("power",), ("power", "dimension"))
"""What terms tell that is told with another symbol, or entry, that makes the same."""
KEPT = ("extra", "chain", "absolute", *OF_RATES)
"""Rules that say why a term is too much."""

FREE = ("P:", "L:")
"""What keys of quantities begin with that hold a constant which is free."""

MOST = 600
"""Wrong results of one quantity."""


@dataclass(frozen=True)
class Mistake:
    """A wrong result and the rule that was forgotten on the way."""

    rule: str  # which
    node: Expr  # its value
    of: str = ""  # the mass that it was forgotten for, "" for no single one
    other: str = ""  # another rule that gives the same when it is forgotten, "" for none
    more: tuple[str, ...] = ()  # rules of other terms that are wrong as well


def mistakes(course: Course, key: str, right: Expr | None = None, most: int = MOST) -> list[Mistake]:
    """Return the typical wrong results of a quantity, no two of the same value, none of the right one.

    Args:
        course: of the scene.
        key: of the quantity, as documents have it.
        right: its value, on the graph of the course; None asks the course.
        most: how many, the likely ones first.
    """
    right = course.value(key, course.right) if right is None else right
    if right is None:
        return []
    marked = cache(lambda node: _mark(course, node, key.startswith(FREE)))
    own = marked(right)
    found: dict[tuple[float, ...], Mistake] = {}
    for mistake in islice(_all(course, key, right), 2 * most):  # many of them give the same
        mark = marked(mistake.node)
        if mark is None or mark == own or (not any(mark) and mistake.rule not in LEAVES_OUT):
            continue
        first = found.get(mark)
        if first is None:
            found[mark] = mistake
            if len(found) == most:
                break
        elif not first.other and mistake.rule not in (first.rule, *VAGUE) and (any(mark) or mistake.rule in OF_RATES):
            found[mark] = replace(first, other=mistake.rule)
    return list(found.values())


def _mark(course: Course, node: Expr, free: bool) -> tuple[float, ...] | None:
    """Return values at two points, of what is free by a constant its changes; None where there is none."""
    values = []
    for k in range(4 if free else 2):
        known: dict[Expr, float] = course.graph.found.setdefault(f"mistakes {k}", {})  # they have nodes in common
        order = reachable([node], known)
        for x in order:
            if x.op is Op.SYMBOL and x not in known:
                fixed = any(x.value == p.name for p in course.scene.parameters)
                seed = f"{k % 2 if fixed else k}:{x.value}:mistakes"
                known[x] = random.Random(seed).uniform(0.25, 2.0)
        try:
            values.append(evaluate([node], Floats(), known, order, known)[0])
        except (ArithmeticError, ValueError):
            return None
    marks = [values[k + 2] - values[k] for k in range(2)] if free else values
    return tuple(float(f"{value:.9g}") if abs(value) > 1e-12 else 0.0 for value in marks)  # 0 in doubles


def _moved_by_others(course: Course, i: int) -> bool:
    """Tell whether the equation of a joint has something of another one's motion."""
    node, state = course.value(f"tau:{i + 1}", course.right), course.state
    others = {x for motion in (state.q, state.qd, state.qdd) for j, x in enumerate(motion) if j != i}
    return node is not None and not others.isdisjoint(reachable([node]))


def absent(course: Course) -> set[str]:
    """Return the rules whose object does not occur in a scene: no rotation, no Steiner's term."""
    e, graph = course.right, course.graph
    alone = not any(course.ancestors(joint) for joint in course.scene.moving)
    slopes = {graph.symbol(p.name) for p in course.scene.parameters if p.unit == "rad"}
    nothing: dict[tuple[str, ...], bool] = {
        ("steiner", "inertia"): not any(part.rigid for part in course.parts),
        ("gravity", "weightless", "height"): all(x.is_zero for x in course.gravity),
        ("energies",): graph.total(e.P.values()).is_zero,
        ("spring",): e.P["E"].is_zero,
        **{(rule,): all(x.is_zero for x in of) for rule, of in course.beside.items()},
        ("coupling",): not any(_moved_by_others(course, i) for i in range(course.state.n)),
        ("body",): len(course.parts) < 2,
        ("relative",): alone,
        ("absolute",): alone and slopes.isdisjoint(reachable(e.P.values())),
    }
    return {rule for rules, missing in nothing.items() if missing for rule in rules}


def _all(course: Course, key: str, right: Expr) -> Iterator[Mistake]:
    left_out = absent(course)
    if course.value(key, course.right) is not None:
        steps = (wrong for begin, steps in STEPS if key.startswith(begin) for wrong in steps(course, key))
        yield from (Mistake(rule, node) for rule, node in steps if rule not in left_out)
        for rule, of, energies in wrong_energies(course):
            if rule not in left_out and (value := course.value(key, energies)) is not None:
                yield Mistake(rule, value, of)
        for treated in (_uncoupled, _undivided) if key.startswith("tau:") else ():
            yield from (Mistake(rule, node) for rule, node in treated(course, _number(key)) if rule not in left_out)
    wrong = (*_of_physics(course, key, right), *wrong_terms(course, right))
    yield from (Mistake(rule, node) for rule, node in wrong if rule not in left_out)
