"""What friction does to an impact: energy that Newton's law of impact gains, and Painlevé's places.

    sticks by Newton's law     ΔK = -(D_tt (1 - e²) ġ² - 2 D_nt ġ s + D_nn s²)/(2 det D)
    slips                      g̈ = (D_nn ∓ μ D_nt) λn + ...        where that factor is not above zero, Painlevé's place

ΔK is largest for the slip s = D_nt ġ/D_nn. Of a factor that depends on one angle θ as D = α + β cos 2θ + γ sin 2θ, with
D_nt = γ' sin 2θ, the least μ at which a place exists is μ = √(D_nn(0) D_nn(π/2))/|D_nt(π/4)|.

References: Painlevé, Leçons sur le frottement (1895); Génot and Brogliato, Eur. J. Mech. A 18 (1999) 653; Pfeiffer and
Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 8.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

import numpy as np

from symdyn.algebra import Array, Batches, Floats, Form, Function, Number, Power, Symbol
from symdyn.draw import Text
from symdyn.dynamics import Workspace, derive_one
from symdyn.emit.print import latex_symbols
from symdyn.graph import Expr, Op, evaluate, reachable, substitute
from symdyn.scene import Scene, SceneUnits
from symdyn.teach.derivations.charts import DASHED, DOTTED, SOLID, Curve, Panel, chart
from symdyn.teach.derivations.contacts import ONE, Struck
from symdyn.teach.derivations.precession import NO_FORM, shortened
from symdyn.teach.document import Block, Formula, Picture, Step, Try
from symdyn.teach.lesson import named

# Energy

DRAWN = 4000
"""States that are looked at."""

WIDEST = 3.0
"""Slips that are looked at, in rates of the gap."""

GAINED = 1e-9
"""Of a kinetic energy, what is no rounding."""


def limit_steps(one: Struck, touched: Scene) -> Iterator[Step]:
    """Yield what Newton's law of impact gains, and Painlevé's places, of a contact that slips along one direction."""
    if one.columns is None or len(one.touch.tangents) != 1 or one.touch.normal is None:
        return
    if isinstance(one.D[0][1], Symbol):
        if one.e.terms:
            yield from _gains(one, touched)
        yield from _painleve(one)


def _gains(one: Struck, touched: Scene) -> Iterator[Step]:
    lesson, (v, s), ((a, b), (_, c)) = one.lesson, one.v, one.D
    half = Number(Fraction(-1, 2))
    lost = Number(1 - one.e.value**2) if isinstance(one.e, Number) else Form.sum((ONE, one.e.power(2).negative))
    det = Form.sum((Form.product((a, c)), b.power(2).negative))
    inner = ((lost, c, v.power(2)), (Number(Fraction(-2)), b, v, s), (a, s.power(2)))
    change = Form.product((half, Form.sum(map(Form.product, inner)), det.power(-1)))
    K = one.letter("change", rf"\Delta {lesson.letters.latex('K')}")
    under = Form.sum((Form.product((one.more, a, c)), b.power(2).negative))
    size = Function(Op.ABS, (b,))
    places: dict[str, Form] = {
        "slip": s,
        "worst": Form.product((b, v, a.power(-1))),
        "square": b.power(2),
        "product": Form.product((lost, a, c)),
        "mu": one.mu,
        "least": Form.product((one.e, a, size, under.power(-1))),
    }
    blocks: list[Block] = [Formula(K.name, change), lesson.say("contacts.gains.where", **places)]
    found = {law: _changes(one, touched, law) for law in ("newton", "poisson")}
    worst, rows = int(np.argmax(found["newton"][1])), list[tuple[str, str, str]]()
    for law, (_, part) in found.items():
        told = lesson.written(float(f"{100 * part.max():.3g}")) + " %" if np.any(part > GAINED) else "–"
        rows.append((lesson.text(f"contacts.law.{law}"), str(int(np.sum(part > GAINED))), told))
    if found["newton"][1][worst] > GAINED:
        blocks.append(lesson.say("contacts.gains.drawn", count=str(DRAWN)))
        blocks.append(lesson.table(("contacts.gains.law", "contacts.gains.states", "contacts.gains.most"), rows))
        blocks.append(lesson.say("contacts.gains.worst", **_state(one, found["newton"][0], worst)))
    else:
        blocks.append(lesson.say("contacts.gains.none", count=str(DRAWN)))
    claim = lesson.say("contacts.gains", contact=one.name)
    yield Step(f"contacts:gains:{one.name}", claim, tuple(blocks), lesson.once("contacts.gains.reason"))


def _changes(one: Struck, touched: Scene, law: str) -> tuple[dict[Expr, Array], Array]:
    """Return positions with slips that are drawn, each with ġ = -1, and by a law what K changes by, of what strikes.

    Velocities are those that percussions at the contact make: others neither change nor are changed. At Painlevé's
    places, where an impact is none or several, nothing is gained.
    """
    assert one.columns is not None, "asked for where there are forms"
    lesson, rng = one.lesson, np.random.default_rng(35)
    graph, state = lesson.graph, lesson.state
    units = SceneUnits(lesson.scene).coordinates
    q = dict[Expr, Array]()
    for x, unit, here in zip(state.q, units, one.chosen.of(*state.q), strict=True):
        drawn = rng.uniform(-1.0, 1.0, DRAWN)
        q[x] = math.pi * drawn if unit == "rad" else here + drawn
    slips = rng.uniform(-WIDEST, WIDEST, DRAWN)
    known = {x: np.full(DRAWN, value) for x, value in one.chosen.values.items()} | q
    C = np.array(_many([x.express(graph) for row in one.columns[0] for x in row], known)).reshape(2, state.n, DRAWN)
    W = np.array(_many([x for row in one.rows for x in row], known)).reshape(2, state.n, DRAWN)
    D, v = np.einsum("kin,lin->nkl", W, C), np.stack([np.full(DRAWN, -1.0), slips], axis=1)
    strikes = np.linalg.solve(D, v[..., None])[..., 0]
    u = np.einsum("nk,kin->in", strikes, C)
    elements = tuple(replace(x, law=law) if getattr(x, "name", "") == one.name else x for x in touched.elements)
    w = Workspace(replace(touched, elements=elements))
    entries = derive_one(w, f"impact:{one.name}").entries
    names = {str(x.value): y for x, y in (known | dict(zip(state.qd, u, strict=True))).items()}
    given = {x: names[str(x.value)] for x in reachable(entries) if x.op is Op.SYMBOL}
    impulse = np.stack(_many(list(entries[-2:]), given), axis=1)
    after = v + np.einsum("nkl,nl->nk", D, impulse)
    gained = np.einsum("nk,nk->n", impulse, v + after) / np.einsum("nk,nk->n", strikes, v)
    (mu,) = one.chosen.of(one.mu.express(graph))
    sound = np.isfinite(gained) & (D[:, 0, 0] > mu * np.abs(D[:, 0, 1]))
    return q | {graph.symbol("slip:drawn"): slips}, np.where(sound, gained, 0.0)


def _many(entries: list[Expr], known: dict[Expr, Array]) -> list[Array]:
    with np.errstate(all="ignore"):
        found = evaluate(entries, Batches(), known)
    return [np.broadcast_to(np.asarray(x, dtype=np.float64), (DRAWN,)) for x in found]


def _state(one: Struck, drawn: dict[Expr, Array], k: int) -> dict[str, str]:
    """Return in words the position on which D depends, and the slip, of one state."""
    lesson = one.lesson
    assert one.columns is not None, "asked for where there are forms"
    units = dict(zip(lesson.state.q, SceneUnits(lesson.scene).coordinates, strict=True))
    seen = set(reachable([x.express(lesson.graph) for row in one.columns[1] for x in row]))
    shown = lesson.scene.in_shown_unit
    at = [
        f"{Text.of_name(latex_symbols(lesson.scene)[str(x.value)]).plain} = "
        + shown(lesson.written(float(f"{float(drawn[x][k]):.3g}")), units[x])
        for x in lesson.state.q
        if x in seen
    ]
    slip = float(list(drawn.values())[-1][k])
    return {
        "at": ", ".join(at),
        "rate": shown(lesson.written(-1.0), f"{one.touch.unit}/s"),
        "slip": shown(lesson.written(float(f"{slip:.3g}")), "m/s"),
    }


# Painlevé's places

FINE = 721
"""Angles of a chart."""

TOP = 2.0
"""How far a chart goes, in the least coefficient of friction at which a place exists: as far as its slider."""


def _painleve(one: Struck) -> Iterator[Step]:
    """Yield from which coefficient of friction on slipping has no solution or two, and over which angles."""
    assert one.columns is not None, "asked for where there are forms"
    lesson, graph, D = one.lesson, one.lesson.graph, one.columns[1]
    nn, nt = (D[0][j].express(graph) for j in range(2))
    a, b = one.D[0]
    size = Function(Op.ABS, (b,))
    letter = one.letter("painleve", "mu", "P")
    blocks: list[Block] = [Formula(letter.name, Form.product((a, size.power(-1))))]
    angles = [q for q in lesson.state.q if q in set(reachable([nn, nt]))]
    least, tries = None, tuple[Try, ...]()
    if len(angles) == 1 and (least := _least(one, angles[0], nn, nt)) is not None:
        form, value, picture = least
        blocks += [
            lesson.say("contacts.painleve.least", q=named(angles[0]), least=form, value=lesson.equals(value)),
            picture,
        ]
        if isinstance(one.mu, Symbol) and one.mu.name in {x.name for x in lesson.scene.parameters}:
            tries = (Try(one.mu.name, value, ""),)
    claim = lesson.say("contacts.painleve", contact=one.name, limit=letter, mu=one.mu)
    yield Step(f"contacts:painleve:{one.name}", claim, tuple(blocks), lesson.say("contacts.painleve.reason"), tries=tries)


def _least(one: Struck, angle: Expr, nn: Expr, nt: Expr) -> tuple[Form, float, Picture] | None:
    """Return the least μ with a place, in closed form and by value, and the chart over the angle; None of other D.

    The form is held against the chart.
    """
    lesson, graph = one.lesson, one.lesson.graph
    units = dict(zip(lesson.state.q, SceneUnits(lesson.scene).coordinates, strict=True))
    if units[angle] != "rad":
        return None
    quarter = graph.pi / 4
    (level,), (upright,) = (substitute([nn], {angle: x}) for x in (graph.zero, 2 * quarter))
    (across,) = substitute([nt], {angle: quarter})
    x = np.linspace(-math.pi, math.pi, FINE)
    known = {y: np.asarray(value) for y, value in one.chosen.values.items()} | {angle: x}
    with np.errstate(all="ignore"):
        over, along = (np.broadcast_to(np.asarray(y, dtype=np.float64), x.shape) for y in evaluate([nn, nt], Batches(), known))
        limit = over / along
    value = float(evaluate([graph.sqrt(level * upright / (across * across))], Floats(), one.chosen.values)[0])
    if not abs(float(np.abs(limit).min()) - value) <= 1e-3 * value:
        return None
    try:
        form = shortened(lesson, level * upright / (across * across))
    except NO_FORM:
        return None
    symbols = latex_symbols(lesson.scene)
    top = TOP * value
    rubs = min(top, one.chosen.of(one.mu.express(graph))[0])
    curves = [
        Curve(np.stack([x, sign * limit], axis=1), look, Text.as_written(lesson.text(f"contacts.{mode}")))
        for sign, look, mode in ((1, SOLID, "ahead"), (-1, DASHED, "back"))
    ]
    name = Text.of_name(symbols[one.mu.name]) if isinstance(one.mu, Symbol) else Text.of_name(r"\mu")
    curves.append(Curve(np.array([[-math.pi, rubs], [math.pi, rubs]]), f"{DOTTED} level", name))
    panel = Panel(
        Text.of_name(symbols[str(angle.value)]).with_unit(lesson.scene.shown_unit("rad")), name,
        (-math.pi, 0.0), (math.pi, top), curves, (), (True, False),
    )  # fmt: skip
    title = lesson.text("contacts.painleve.alt", scene=lesson.scene.name)
    svg = chart(title, [panel], lesson.written, "painleve-")
    return _root(form), value, Picture(svg, lesson.say("contacts.painleve.caption"), title, "painleve")


def _root(form: Form) -> Form:
    """Return the square root of a quotient of positive factors, those that are squares outside of it."""
    outside, inside = list[Form](), list[Form]()
    for factor in form.factors:
        base, exponent = (factor.base, factor.exponent) if isinstance(factor, Power) else (factor, 1)
        for x in base.factors:
            inner, power = (x.base, x.exponent * exponent) if isinstance(x, Power) else (x, exponent)
            if isinstance(inner, Number):
                over = [math.isqrt(part) for part in inner.value.as_integer_ratio()]
                if Fraction(*over) ** 2 == inner.value:
                    inner, power = Number(Fraction(*over)), 2 * power
            outside += [inner.power(power // 2)] if power % 2 == 0 else []
            inside += [inner.power(power)] if power % 2 else []
    return Form.product((*outside, *([Function(Op.SQRT, (Form.product(inside),))] if inside else [])))
