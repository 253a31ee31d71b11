"""The laws of contacts by mode, Signorini's and Coulomb's, and the cone of friction with the reaction in it.

    0 ≤ g, 0 ≤ λn, g λn = 0        |λt| ≤ μ λn

Reference: Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 5.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from symdyn.algebra import Form
from symdyn.draw import Diagram, Text
from symdyn.teach.derivations.contacts import Struck
from symdyn.teach.document import Block, Letter, Picture, Step
from symdyn.teach.lesson import Lesson


def law_steps(lesson: Lesson, struck: Sequence[Struck]) -> Iterator[Step]:
    """Yield the laws by mode, once of all contacts that have the same."""
    alike = dict[tuple[object, ...], list[Struck]]()
    for one in struck:
        alike.setdefault((one.touch.normal is None, one.mu, one.static, len(one.touch.tangents)), []).append(one)
    g, rate = (lesson.called(f"gap{dots}:any", Letter("g", dots=dots)) for dots in (0, 1))
    s = lesson.called("slip:any", Letter("s"))
    n, t = (lesson.called(f"lambda{way}:", Letter("lambda", (way,))) for way in "nt")
    for k, (one, *others) in enumerate(alike.values(), 1):
        dry, ways = one.touch.normal is None, len(one.touch.tangents)
        rubs, holds = (x if dry else Form.product((x, n)) for x in (one.mu, one.static))
        places: dict[str, Form] = {"g": g, "rate": rate, "s": s, "n": n, "t": t, "rubs": rubs, "holds": holds}
        places["against"] = rubs.negative
        modes = [] if dry else ["open"] if ways else ["open", "closed"]
        modes += ["sticks", "any"] if ways > 1 else ["sticks", "ahead", "back"] if ways else []
        rows = [
            [lesson.say(f"contacts.{x}"), *(lesson.say(f"contacts.{x}.{y}", **places) for y in ("law", "while"))]
            for x in modes
        ]
        table = lesson.table(("contacts.mode", "contacts.law", "contacts.while"), rows)
        names, key = ", ".join(x.name for x in (one, *others)), "dry" if dry else "rough" if ways else "smooth"
        claim = lesson.say(f"contacts.laws.{key}", names=names, **places)
        reason = lesson.once(f"contacts.laws.{key}.reason", **places)
        shown: tuple[Block, ...] = (table,)
        if ways and not dry:
            shown = (table, cone(lesson, *one.chosen.of(*(x.express(lesson.graph) for x in (one.static, one.mu))), str(k)))
        yield Step(f"contacts:laws:{k}" if reason.parts else f"more.contacts:laws:{k}", claim, shown, reason)


APART, HIGH, DEEP = 190.0, 100.0, 30.0  # of the modes, and how high a cone is drawn; units of the picture
STEEPEST = 0.9  # how wide half a cone is, in its height, at most: a rougher one is cut

CONE = (("sticks", 0.35, 0), ("ahead", -1.0, 1), ("back", 1.0, -1))
"""Modes, where the reaction lies between the edges of the cone, -1 to 1, and where it slips to."""


def cone(lesson: Lesson, holds: float, rubs: float, number: str) -> Picture:
    """Return the cone of friction in every mode that is closed, with the reaction in it.

    Args:
        holds, rubs: the coefficients of friction while it sticks, and while it slips.
        number: of the laws, where there are several.
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
