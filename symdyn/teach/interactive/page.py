"""The interactive part of a page: one piece of style, markup and script that needs nothing else.

What it computes is the JavaScript that `symdyn generate --target js` writes; the script of the page only draws, closes
loops by Newton's method and integrates the motion by Runge and Kutta.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from symdyn.draw import Stage, Text, pose, style
from symdyn.dynamics.mechanism import quaternions
from symdyn.emit import TARGETS, emit, in_html, render, verbatim
from symdyn.emit.code import stem
from symdyn.emit.print import Letters, latex_symbols
from symdyn.graph import Expr
from symdyn.scene import Scene
from symdyn.teach.interactive.controls import controls, start
from symdyn.teach.interactive.live import Live, by_hand, live
from symdyn.teach.interactive.plotted import pairs, plotted
from symdyn.teach.interactive.tables import exerted, force_tables
from symdyn.teach.languages import language_of
from symdyn.teach.mathml import inline

JS = TARGETS["js"]

DOCUMENTED = re.compile(r"^/\*\*\n(?: \*.*\n)+?(?=const )", re.MULTILINE)
"""What generated code says above each of its functions, which a page has no reader for."""

LISTED = re.compile(r"^ \*\n \* Functions, with .*?\*/", re.MULTILINE | re.DOTALL)
"""What generated code says of all its functions."""
ASSIGNED = re.compile(r"(const )?[\w[\]]+ = [\w.()[\] *+/-]*;$")
"""A line that gives a name, or an entry of a result, to a formula."""
SPACED = re.compile(r" ([=*/+-]) (?![+-])")
"""A sign between spaces, not one before another sign."""
CHOICE = (
    *("frames", "angles", "places", "velocities", "accelerations", "weights", "forces", "inertia", "coriolis"),
    *("centrifugal", "momenta", "reactions", "trails", "plots", "phase"),
)
"""Words of `Step.show` that the reader may tick, in their order."""


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
) -> Interactive:
    """Return the interactive part of a lesson; several scenes may stand in one page.

    Sliders begin where lessons show numbers. Classes begin with "live" and ids with "live-" and the scene's name; the
    picture has the class "symdyn" and the colours of pictures. The script adds to one global name, `symdyn`.

    Args:
        scene: any of not too many velocities.
        parameters: where parameters begin instead.
        language: "en" or "sk".
        named: values that `symdyn.NAME.named()` of the page returns too, see `live`.

    Raises:
        TeachError: a scene that sliders cannot move, or an unknown language.
        DrawError: a name that is no parameter, or loops that do not close.
        DerivationError: equations that do not exist.
        EmitError: latex2mathml is not installed.
    """
    sentences = language_of(language).page
    scene = scene.as_parameters().in_language(language)
    begun, whole = start(scene), scene
    scene = by_hand(scene)
    if parameters:
        q, values = pose(scene, parameters={**begun.parameters, **parameters})
        begun = replace(begun, q=[float(x) for x in q], parameters=values)
    q, values = np.array(begun.q), begun.parameters
    stage = Stage(scene, q.reshape(1, -1), values)
    computed = live(scene, values, named, stage.places.outlines)
    name = stem(scene.name)
    stuck = sentences["freed"] if scene != whole else f"{sentences['stuck']} {computed.stuck}" if computed.stuck else ""
    extent = float(np.round(stage.extent, 2)) or 1.0
    letters, symbols = Letters(scene), latex_symbols(scene)
    body = {
        "letters": {key: inline(letters.latex(key)) for key in ("K", "P")},
        "numbered": bool(named),
        "name": name,
        "title": in_html(scene.name),
        "words": sentences,
        "groups": controls(scene, begun, extent, computed.held, [k for _, k in computed.led]),
        "rows": force_tables(scene, computed, sentences),
        "exerted": exerted(scene, computed, sentences),
        "closed": computed.held is not None,
        "planar": stage.view.planar,
        "plotted": [in_html(one["unit"]) for one in plotted(scene)],
        "pairs": [in_html(f"{below}; {beside}") for *_, below, beside in pairs(scene)],
        "ticks": _ticks(computed),
        "ghosts": [in_html(Text.of_latex(symbols[p.name]).plain) for p in scene.parameters],
        "stuck": in_html(stuck),
        "undriven": in_html(computed.held.undriven) if computed.held else "",
    }
    state = {"q": begun.q, "qd": begun.qd, "qdd": begun.qdd}
    params = [values[p.name] for p in scene.parameters]
    data = {"start": {**state, "params": params, "t": begun.t}, **_data(scene, computed, stage, sentences)}
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


def _short(code: str) -> str:
    """Return generated code without what its readers need: indents, the list of functions, spaces in formulas."""
    plain = LISTED.sub("*/", DOCUMENTED.sub("", code), count=1)
    lines = [line.lstrip() for line in plain.splitlines() if line]
    return "\n".join(SPACED.sub(r"\1", line) if ASSIGNED.match(line) else line for line in lines)


def interactive_page(scene: Scene, parameters: Mapping[str, float] | None = None, language: str = "en") -> str:
    """Return the interactive part as a page of its own, which needs nothing else; see `interactive`."""
    parts = interactive(scene, parameters, language)
    values = {"title": in_html(scene.name), "language": language, **parts._asdict(), "body": parts.body}
    return render("teach/interactive_page.html.jinja", values)


def _ticks(computed: Live) -> list[str]:
    """Return the words of what the reader may have shown."""
    arrows = computed.arrows
    lacking = {
        "angles": computed.sheet.coordinates,
        "coriolis": len(computed.rows) > 1,
        "forces": arrows.actions,
        "reactions": arrows.joints,
    }
    return [word for word in CHOICE if lacking.get(word, True)]


# What the script is told


def _data(scene: Scene, computed: Live, stage: Stage, sentences: Mapping[str, str]) -> dict[str, Any]:
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
        "plotted": plotted(scene),
        "pairs": pairs(scene),
        "view": (np.round([seen.right, seen.up, seen.toward], 9) + 0.0).tolist(),
        "words": {key: sentences[key] for key in ("play", "pause", "lost", "open", "point", "leaks", "joules")},
    }
