"""The interactive part of a page: one piece of style, markup and script that needs nothing else.

What it computes is the JavaScript that `symdyn generate --target js` writes; the script of the page only draws, closes
loops by Newton's method and integrates the motion by Runge and Kutta.

Plots are coordinates and velocities over time, by unit, and pairs of both for phase portraits. Tables tell of what each
force is made, and what drives, loops and rows of a closed mechanism exert.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from symdyn.algebra import Floats
from symdyn.draw import Stage, Text, pose, style
from symdyn.dynamics.mechanism import quaternions
from symdyn.emit import TARGETS, emit, in_html, render, verbatim
from symdyn.emit.code import stem
from symdyn.emit.print import Letters, latex_symbols
from symdyn.errors import TeachError, listed
from symdyn.graph import Expr, Graph, evaluate
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import StateVariable, acceleration_name
from symdyn.teach.derivations.equation_steps import coefficient_unit
from symdyn.teach.languages import language_of
from symdyn.teach.lesson import called
from symdyn.teach.mathematics import inline, with_words
from symdyn.teach.played import Played
from symdyn.teach.render.controls import UNITS, controls, start
from symdyn.teach.render.live import Live, Term, by_hand, live


def plotted(scene: Scene, own: Sequence[int] = ()) -> list[dict[str, Any]]:
    """Return plots over time: what they are of, which entries (those of one unit), and the words of their axis.

    `own` are the parameters that are states.
    """
    symbols, found = latex_symbols(scene), list[dict[str, Any]]()
    told = SceneUnits(scene).inferred
    kinds = (
        ("q", scene.coordinates, SceneUnits(scene).coordinates, 0),
        ("qd", scene.velocities, SceneUnits(scene).velocities, 1),
    )
    for group, names, units, order in kinds:
        for unit in dict.fromkeys(units):
            rows = [k for k, one in enumerate(units) if one == unit]
            text = ", ".join(Text.of_latex(symbols[names[k]]).plain for k in rows)
            printed = scene.shown_unit(UNITS[unit][order])
            found.append({"group": group, "rows": rows, "unit": f"{text}, {printed}" if printed else text})
    free = [one.name for one in scene.parameters]
    for unit in dict.fromkeys(told[free[k]] for k in own):
        rows = [k for k in own if told[free[k]] == unit]
        text = ", ".join(Text.of_latex(symbols[free[k]]).plain for k in rows)
        found.append({"group": "params", "rows": rows, "unit": f"{text}, {unit}" if unit else text})
    return found


def pairs(scene: Scene) -> list[tuple[int, int, str, str]]:
    """Return (coordinate, velocity, words of both axes) where the velocity is the coordinate's rate."""
    symbols, found, first, start = latex_symbols(scene), [], 0, 0
    units = SceneUnits(scene).coordinates
    for joint in scene.moving:
        ball = JOINTS[joint.type].quaternion(joint)
        for k in range(len(joint.coordinates) if ball is None else ball):
            i, j = first + k, start + k
            q, u = (Text.of_latex(symbols[name]).plain for name in (scene.coordinates[i], scene.velocities[j]))
            place, rate = (scene.shown_unit(one) for one in UNITS[units[i]][:2])
            found.append((i, j, ", ".join(filter(None, (q, place))), ", ".join(filter(None, (u, rate)))))
        first, start = first + len(joint.coordinates), start + len(joint.rates)
    return found


PHRASES = (
    *("force along the track", "force across the track", "normal force", "force across the blade"),
    *("force along", "moment about", "with its moment", "constraint"),
)
"""What a multiplier may be, longer phrases first: keys of the words of the page."""


def force_tables(scene: Scene, computed: Live, words: Mapping[str, str]) -> list[dict[str, Any]]:
    """Return, row by row, its name, its unit and its terms."""
    symbols, letters = latex_symbols(scene), Letters(scene)
    units = SceneUnits(scene).velocities
    slides = [units[velocity] == "m" for velocity in computed.rows]
    tables = []
    for i, velocity in enumerate(computed.rows):
        drive = scene.drives[velocity]
        if computed.held:
            label, drives = rf"{letters.latex('tau')}_{{{i + 1}}}^{{*}}", computed.held.drives
            passive = velocity not in drives and set(drives) <= set(computed.rows)
        else:
            label, passive = symbols[drive] if drive else rf"{letters.latex('tau')}_{{{i + 1}}}", not drive
        terms = [(k, term) for k, term in enumerate(computed.terms) if term.row == i]
        tables.append(
            {
                "label": inline(label),
                "passive": passive,
                "unit": scene.shown_unit(UNITS[units[velocity]][3]),
                "terms": [
                    {
                        "number": k,
                        "unit": scene.shown_unit(coefficient_unit(term.of, [i + 1 for i in term.indices], slides)),
                        **_term(scene, term, symbols, letters, words, "*" if computed.held else ""),
                    }
                    for k, term in terms
                ],
            }
        )
    return tables


def _term(
    scene: Scene, term: Term, symbols: Mapping[str, str], letters: Letters, words: Mapping[str, str], star: str
) -> dict[str, str]:
    """Return how a term is printed: its coefficient and what that is multiplied by."""
    names = {"qd": scene.velocities, "qdd": tuple(acceleration_name(v) for v in scene.velocities)}
    factors = [symbols[names[kind][k]] for kind, k in term.rates]
    square = len(factors) == 2 and factors[0] == factors[1]
    rate = inline(f"{_grouped(factors[0])}^{{2}}") if square else "\u00a0".join(inline(x) for x in factors)
    above = f"^{{{star}}}" if star else ""
    if term.sign < 0:
        Q = letters.latex("Q")
        return {"coefficient": f"−{inline(f'{Q}_{{{term.row + 1}}}{above}')}", "rate": "", "text": words["Q"]}
    coefficient = letters.coefficient(term.function, [index + 1 for index in term.indices])
    return {"coefficient": inline(f"{coefficient}{above}"), "rate": rate, "text": ""}


def _grouped(latex: str) -> str:
    return f"{{{latex}}}" if "^" in latex else latex


def exerted(scene: Scene, computed: Live, words: Mapping[str, str]) -> list[dict[str, Any]]:
    """Return rows of what drives and multipliers exert, none for a tree: name, words, unit, which result and entry."""
    if computed.held is None:
        return []
    symbols, multiplier = latex_symbols(scene), Letters(scene).latex("lambda")
    rows = []
    driven = [k for k, drive in enumerate(scene.drives) if drive]
    for k, (joint, drive, unit) in zip(driven, SceneUnits(scene).each_drive(), strict=True):
        if k in computed.held.drives:
            text = words["drive"].format(joint=joint.text or joint.name)
            rows.append(
                _exerted(
                    inline(symbols[drive]), text, scene.shown_unit(unit).replace(" ", "\u202f"), "inverse_dynamics", k
                )
            )
    for k, (owner, wrench) in enumerate(computed.held.multipliers):
        text = wrench.partition(" along (")[0].partition(" about (")[0]
        for phrase in PHRASES:
            text = text.replace(phrase, words[phrase])
        unit = "N" if wrench.startswith("force") else UNITS["rad"][3] if wrench.startswith("moment") else ""
        rows.append(
            _exerted(inline(rf"{multiplier}_{{{k + 1}}}"), f"{owner}: {text}", scene.shown_unit(unit), "multipliers", k)
        )
    return rows


def _exerted(label: str, text: str, unit: str, function: str, entry: int) -> dict[str, Any]:
    return {"label": label, "text": in_html(text), "unit": unit, "function": function, "entry": entry}


JS = TARGETS["js"]

DOCUMENTED = re.compile(r"^/\*\*\n(?: \*.*\n)+?(?=const )", re.MULTILINE)
"""What generated code says above each of its functions, which a page has no reader for."""

LISTED = re.compile(r"^ \*\n \* Functions, with .*?\*/", re.MULTILINE | re.DOTALL)
"""What generated code says of all its functions."""
ASSIGNED = re.compile(r"(const )?[\w[\]]+ = [\w.()[\] *+/-]*;$")
"""A line that gives a name, or an entry of a result, to a formula."""
SPACED = re.compile(r" ([=*/+-]) (?![+-])")
"""A sign between spaces, not one before another sign."""
CHOICES: Mapping[str, Mapping[str, str]] = {
    "shape": dict.fromkeys(("names", "angles", "places", "frames", "trails"), ""),
    "motion": {"velocities": "v", "accelerations": "a", "momenta": "p"},
    "forces": {"weights": "G", "forces": "F", "reactions": "R", "cone": "λ"},
    "inertia": {"inertia": "D", "coriolis": "C", "centrifugal": "Z"},
    "plots": dict.fromkeys(("plots", "phase"), ""),
}
"""Words of `Step.show` that the reader may tick, by group, and the sign at the tip of what each draws."""


class Interactive(NamedTuple):
    """The page in pieces: rules for a `<style>`, two pieces of markup, and text for a `<script>` after both."""

    css: str
    figure: str
    panel: str
    script: str

    @property
    def body(self) -> str:
        """The figure beside the panel of its sliders and tables."""
        return f'<div class="live-both">\n{self.figure}{self.panel}</div>'


def interactive(
    scene: Scene,
    parameters: Mapping[str, float] | None = None,
    language: str = "en",
    named: Sequence[Expr] = (),
    states: Sequence[StateVariable] = (),
    played: Played | None = None,
) -> Interactive:
    """Return the interactive part of a lesson; several scenes may stand in one page.

    Sliders begin where lessons show numbers. Classes begin with "live" and ids with "live-" and the scene's name; the
    picture has the class "symdyn" and the colours of pictures. The script adds to one global name, `symdyn`.

    Args:
        scene: any of not too many velocities.
        parameters: where parameters begin instead.
        language: "en" or "sk".
        named: values that `symdyn.NAME.named()` of the page returns too, see `live`.
        states: parameters of the scene that are states, which begin where a lesson shows them.
        played: its run with the contacts that it has been taken without.

    Raises:
        TeachError: a scene that sliders cannot move, or an unknown language.
        DrawError: a name that is no parameter, or loops that do not close.
        DerivationError: equations that do not exist.
        EmitError: latex2mathml is not installed.
    """
    sentences = language_of(language).page
    scene.refuse_contacts("the page with sliders", TeachError)
    declared, states = scene.states, states or scene.states
    if jumps := [one.name for one in states if one.reset is not None]:
        raise TeachError(
            f"{scene.name}: the page with sliders knows no resets, and there is {listed(jumps)}; take them out"
        )
    scene = scene.as_parameters().in_language(language)
    begun, whole = start(scene), scene
    begun = replace(begun, parameters=begun.parameters | _starts(declared, begun.parameters))
    scene = by_hand(scene)
    if parameters:
        q, values = pose(scene, parameters={**begun.parameters, **parameters})
        begun = replace(begun, q=[float(x) for x in q], parameters=values)
    q, values = np.array(begun.q), begun.parameters
    stage = Stage(scene, q.reshape(1, -1), values)
    touches = played.scene.unilaterals if played else ()
    computed = live(scene, values, named, stage.places.outlines, states, touches)
    own = [[one.name for one in scene.parameters].index(one.name) for one in states]
    name = stem(scene.name)
    stuck = sentences["freed"] if scene != whole else f"{sentences['stuck']} {computed.stuck}" if computed.stuck else ""
    extent = float(np.round(stage.extent, 2)) or 1.0
    letters, symbols = Letters(scene), latex_symbols(scene)
    body = {
        "letters": {key: inline(letters.latex(key)) for key in ("K", "P")},
        "numbered": bool(named),
        "name": name,
        "title": in_html(called(scene)),
        "words": sentences,
        "groups": controls(scene, begun, extent, computed.held, [k for _, k in computed.led]),
        "rows": force_tables(scene, computed, sentences),
        "exerted": exerted(scene, computed, sentences),
        "closed": computed.held is not None,
        "planar": stage.view.planar,
        "plotted": [in_html(one["unit"]) for one in plotted(scene, own)],
        "pairs": [in_html(f"{below}; {beside}") for *_, below, beside in pairs(scene)],
        "choices": _choices(computed, played),
        "ghosts": [in_html(Text.of_latex(symbols[p.name]).plain) for p in scene.parameters],
        "stuck": in_html(stuck),
        "played": played and ("played" if played.rows else "unplayed"),
        "undriven": in_html(computed.held.undriven) if computed.held else "",
    }
    state = {"q": begun.q, "qd": begun.qd, "qdd": begun.qdd}
    params = [values[p.name] for p in scene.parameters]
    data = {"start": {**state, "params": params, "t": begun.t}, **_data(scene, computed, stage, sentences, own)}
    data["played"] = {"rows": played.rows, "frictions": played.frictions} if played and played.rows else None
    command = f"symdyn walkthrough {scene.name}.toml --format html"
    code = emit(computed.program, JS.name, command=command).texts[f"{name}.js"]
    script = {
        "code": _short(code),
        "data": data,
        "name": name,
    }
    return Interactive(
        style("auto") + verbatim("teach/interactive.css") + verbatim("teach/interactive_figure.css") + "\n",
        render("teach/interactive_figure.html.jinja", body),
        render("teach/interactive_panel.html.jinja", body),
        render("teach/interactive.js.jinja", script),
    )


def _starts(states: Sequence[StateVariable], parameters: Mapping[str, float]) -> dict[str, float]:
    """Return where states start."""
    graph = Graph()
    known = {graph.symbol(name): value for name, value in parameters.items()}
    found = evaluate([one.value.express(graph) for one in states], Floats(), known)
    return dict(zip((one.name for one in states), map(float, found), strict=True))


def _short(code: str) -> str:
    """Return generated code without what its readers need: indents, the list of functions, spaces in formulas."""
    plain = LISTED.sub("*/", DOCUMENTED.sub("", code), count=1)
    lines = [line.lstrip() for line in plain.splitlines() if line]
    return "\n".join(SPACED.sub(r"\1", line) if ASSIGNED.match(line) else line for line in lines)


def interactive_page(scene: Scene, parameters: Mapping[str, float] | None = None, language: str = "en") -> str:
    """Return the interactive part as a page of its own, which needs nothing else; see `interactive`."""
    parts = interactive(scene, parameters, language)
    values = {"title": in_html(called(scene)), "language": language, **parts._asdict(), "body": parts.body}
    return with_words(render("teach/interactive_page.html.jinja", values), language_of(language).page)


def _choices(computed: Live, played: Played | None) -> list[tuple[str, list[tuple[str, str]]]]:
    """Return the groups of what the reader may have shown, and words and signs of each."""
    arrows = computed.arrows
    lacking = {
        "angles": computed.sheet.coordinates,
        "coriolis": len(computed.rows) > 1,
        "forces": arrows.actions,
        "reactions": arrows.joints,
        "cone": played and played.frictions,
    }
    found = {group: [one for one in signs.items() if lacking.get(one[0], True)] for group, signs in CHOICES.items()}
    return [(group, ticks) for group, ticks in found.items() if ticks]


# What the script is told


def _data(
    scene: Scene, computed: Live, stage: Stage, sentences: Mapping[str, str], own: Sequence[int]
) -> dict[str, Any]:
    calls = {
        routine.function.name: [argument.name for argument in routine.function.arguments]
        for routine in computed.program.routines
    }
    tied, names, seen = computed.held, list(scene.coordinates), stage.view
    balls = [names.index(group[0]) for group in quaternions(scene)]
    return {
        "calls": calls,
        "balls": balls,
        "turns": [first for first in balls if tied is None or first in tied.moved],
        "loops": None if tied is None or not tied.closing.blocks else {str(k): v for k, v in tied.moved.items()},
        "led": [list(pair) for pair in computed.led],
        "terms": [[t.function, t.entry, t.row, t.sign, *map(list, t.rates)] for t in computed.terms],
        "total": "inverse_dynamics" if tied is None else "row_forces",
        "marks": [
            [m.kind, list(m.rows), m.body, Text.of_part(m.text).svg() if m.text else "", m.joint]
            for m in computed.sheet.marks
        ],
        "bodies": [body.name for body in scene.bodies],
        "called": [body.text or body.name for body in scene.bodies],
        "rows": list(computed.rows),
        "arrows": {
            "masses": computed.arrows.masses,
            "actions": computed.arrows.actions,
            "joints": computed.arrows.joints,
        },
        "coordinates": [
            [c.slides, names.index(c.name), Text.of_latex(latex_symbols(scene)[c.name]).svg(), c.at, c.axis, c.tips]
            for c in computed.sheet.coordinates
        ],
        "points": computed.sheet.points,
        "gravity": computed.sheet.gravity,
        "own": own,
        "plotted": plotted(scene, own),
        "pairs": pairs(scene),
        "view": (np.round([seen.right, seen.up, seen.toward], 9) + 0.0).tolist(),
        "signs": {word: sign for signs in CHOICES.values() for word, sign in signs.items() if sign},
        "words": {key: sentences[key] for key in ("play", "pause", "lost", "open", "point", "leaks", "joules")},
    }
