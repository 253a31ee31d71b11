"""The laws of contacts by mode, the cone of friction, energy that Newton's law of impact gains, and Painlevé's places.

    0 ≤ g, 0 ≤ λn, g λn = 0        |λt| ≤ μ λn
    sticks by Newton's law     ΔK = -(D_tt (1 - e²) ġ² - 2 D_nt ġ s + D_nn s²)/(2 det D)
    slips                      g̈ = (D_nn ∓ μ D_nt) λn + ...        where that factor is not above zero, Painlevé's place

ΔK is largest for the slip s = D_nt ġ/D_nn. Where D_nn is α + β cos 2θ of one angle, and D_nt is γ sin 2θ, the least μ
at which a place exists is √(D_nn(0) D_nn(π/2))/|D_nt(π/4)|.

References: Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapters 5 and 8; Painlevé, Leçons
sur le frottement (1895); Génot and Brogliato, Eur. J. Mech. A 18 (1999) 653.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from symdyn.algebra import Array, Batches, Floats, Form, Function, Number, Power, Symbol
from symdyn.draw import Diagram, Text
from symdyn.dynamics import Workspace, derive_one
from symdyn.emit.print import latex_symbols
from symdyn.graph import Expr, Op, evaluate, reachable, substitute
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import Unilateral
from symdyn.teach.derivations.charts import DASHED, DOTTED, SOLID, Curve, Panel, chart
from symdyn.teach.derivations.contacts import ONE, Struck
from symdyn.teach.derivations.precession import NO_FORM, shortened
from symdyn.teach.document import Block, Formula, Letter, Picture, Step, Try
from symdyn.teach.lesson import Lesson, named


def law_steps(lesson: Lesson, struck: Sequence[Struck]) -> Iterator[Step]:
    """Yield the laws by mode, once of all contacts that have the same."""
    alike = dict[tuple[object, ...], list[Struck]]()
    for one in struck:
        touch = one.touch
        law = (touch.normal is None, touch.law.at_rates, one.mu, one.static, len(touch.tangents))
        alike.setdefault(law, []).append(one)
    g, rate = (lesson.called(f"gap{dots}:any", Letter("g", dots=dots)) for dots in (0, 1))
    s = lesson.called("slip:any", Letter("s"))
    n, t = (lesson.called(f"lambda{way}:", Letter("lambda", (way,))) for way in "nt")
    for k, (one, *others) in enumerate(alike.values(), 1):
        dry, ways = one.touch.normal is None, len(one.touch.tangents)
        rubs, holds = (x if dry else Form.product((x, n)) for x in (one.mu, one.static))
        places: dict[str, Form] = {"g": g, "rate": rate, "s": s, "n": n, "t": t, "rubs": rubs, "holds": holds}
        places["against"] = rubs.negative
        at_rates = one.touch.law.at_rates
        modes = [] if dry else ["free", "locked"] if at_rates else ["open"] if ways else ["open", "closed"]
        modes += ["sticks", "any"] if ways > 1 else ["sticks", "ahead", "back"] if ways else []
        rows = [
            [lesson.say(f"contacts.{x}"), *(lesson.say(f"contacts.{x}.{y}", **places) for y in ("law", "while"))]
            for x in modes
        ]
        table = lesson.table(("contacts.mode", "contacts.law", "contacts.while"), rows)
        names = ", ".join(x.name for x in (one, *others))
        key = "dry" if dry else "one_way" if at_rates else "rough" if ways else "smooth"
        claim = lesson.say(f"contacts.laws.{key}", names=names, **places)
        reason = lesson.once(f"contacts.laws.{key}.reason", **places)
        shown: tuple[Block, ...] = (table,)
        if ways == 1 and not dry:
            at = one.chosen.of(*(x.express(lesson.graph) for x in (one.static, one.mu)))
            shown = (table, cone(lesson, str(k), *at))
        key = f"contacts:laws:{k}" if reason.parts else f"more.contacts:laws:{k}"
        yield Step(key, claim, shown, reason, show=("cone", "names"))


APART, HIGH, DEEP = 190.0, 100.0, 30.0  # of the modes, and how high a cone is drawn; units of the picture
STEEPEST = 0.9  # how wide half a cone is, in its height, at most: a rougher one is cut

CONE = (("sticks", 0.35, 0), ("ahead", -1.0, 1), ("back", 1.0, -1))
"""Modes, where the reaction lies between the edges of the cone, -1 to 1, and where it slips to."""


def cone(lesson: Lesson, number: str, holds: float, rubs: float) -> Picture:
    """Return the cone of friction in every mode that is closed, with the reaction in it.

    `holds` and `rubs` are the coefficients of friction while it sticks, and while it slips.
    """
    title = lesson.text("contacts.cone.alt")
    sheet, letters = Diagram(title, "cone"), {x: lesson.letters.latex(x) for x in ("lambda", "s")}
    for k, (mode, lies, slips) in enumerate(CONE):
        x, half = k * APART, (rubs if slips else holds) * HIGH
        top = HIGH * min(1.0, STEEPEST * HIGH / half)
        half = half * top / HIGH
        sheet.line("floor", [(x - 70, 0), (x + 70, 0)], 2.0)
        for stroke in range(-7, 7):
            sheet.line("hatch", [(x + 10 * stroke + 8, 0), (x + 10 * stroke, 8)], 1.2)
        sheet.line("stem", [(x, 0), (x, -HIGH)], 0.9)
        sheet.line("link body0", [(x - half, -top), (x, 0), (x + half, -top)], 1.6)
        sheet.arrow("force", (x, 0), (x + lies * half * 0.85, -top * 0.85))
        if slips:
            sheet.arrow("link body1", (x - 34 * slips, DEEP), (x + 34 * slips, DEEP))
            sheet.text(Text.of_name(letters["s"]), x + 46 * slips, DEEP)
        if not k:
            sheet.text(Text.of_name(rf"{letters['lambda']}_n"), x - 14, -HIGH - 4)
        sheet.text(Text.as_written(lesson.text(f"contacts.{mode}")), x, DEEP + 26)
    angles = [lesson.about(round(math.degrees(math.atan(mu)), 1)) for mu in dict.fromkeys((holds, rubs))]
    caption = lesson.say("contacts.cone", angle=" / ".join(angles))
    return Picture(sheet.svg(f"cone{number}-"), caption, title, f"cone{number}")


# Energy

DRAWN = 4000
"""States that are looked at."""

WIDEST = 3.0
"""Slips that are looked at, in rates of the gap."""

GAINED = REGULAR = 1e-9
"""Of a kinetic energy, what is no rounding; and of D_nn D_tt the determinant of what has an inverse."""


def limit_steps(one: Struck, touched: Scene) -> Iterator[Step]:
    """Yield what Newton's law of impact gains, and Painlevé's places, of a contact that slips along one direction."""
    if one.columns is None or len(one.touch.tangents) != 1 or one.touch.normal is None:
        return
    if not one.is_tied and isinstance(one.D[0][1], Symbol):
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
    (mu,) = one.chosen.of(one.mu.express(graph))
    sound = (D[:, 0, 0] > mu * np.abs(D[:, 0, 1])) & (np.linalg.det(D) > REGULAR * D[:, 0, 0] * D[:, 1, 1])
    D = np.where(sound[:, None, None], D, np.eye(2))
    strikes = np.linalg.solve(D, v[..., None])[..., 0]
    u = np.einsum("nk,kin->in", strikes, C)
    elements = tuple(
        replace(x, law=law) if isinstance(x, Unilateral) and x.name == one.name else x for x in touched.elements
    )
    w = Workspace(replace(touched, elements=elements))
    entries = derive_one(w, f"impact:{one.name}").entries
    names = {str(x.value): y for x, y in (known | dict(zip(state.qd, u, strict=True))).items()}
    given = {x: names[str(x.value)] for x in reachable(entries) if x.op is Op.SYMBOL}
    impulse = np.stack(_many(list(entries[-2:]), given), axis=1)
    after = v + np.einsum("nkl,nl->nk", D, impulse)
    gained = np.einsum("nk,nk->n", impulse, v + after) / np.einsum("nk,nk->n", strikes, v)
    return q | {graph.symbol("slip:drawn"): slips}, np.where(sound & np.isfinite(gained), gained, 0.0)


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
    yield Step(
        f"contacts:painleve:{one.name}", claim, tuple(blocks), lesson.say("contacts.painleve.reason"), tries=tries
    )


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
        over, along = (
            np.broadcast_to(np.asarray(y, dtype=np.float64), x.shape) for y in evaluate([nn, nt], Batches(), known)
        )
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
    return square_root(form), value, Picture(svg, lesson.say("contacts.painleve.caption"), title, "painleve")


def square_root(form: Form) -> Form:
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
