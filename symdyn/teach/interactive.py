"""The interactive page: sliders move the mechanism, every coefficient, every torque and the energies follow.

The page is one piece of style, markup and script that needs nothing else. What it computes is the JavaScript that
`symdyn generate --target js` writes; the script of the page only draws, and integrates the motion by Runge and Kutta.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from html import escape
from typing import Any, NamedTuple

import numpy as np

from symdyn.draw.door import spread, watched
from symdyn.draw.lettering import from_latex, words
from symdyn.draw.places import places
from symdyn.draw.pose import pose, values_of
from symdyn.draw.style import style
from symdyn.draw.view import View
from symdyn.emit import emit
from symdyn.emit.latex_layout import together
from symdyn.emit.names import stem
from symdyn.emit.render import render
from symdyn.emit.symbols import latex_symbols
from symdyn.errors import TeachError
from symdyn.scene import JOINTS, Joint, Parameter, Scene, acceleration_name
from symdyn.scene.value import value_of
from symdyn.teach.live import Live, Mark, Term, live
from symdyn.teach.render.mathml import inline

FREE_FALL = 9.81  # m/s^2: of a parameter in this unit that has no value

RATES = {"rad": (8.0, 20.0), "m": (3.0, 10.0)}  # largest velocity and acceleration of a slider
UNITS = {"rad": ("rad", "rad/s", "rad/s^2", "N\u202fm"), "m": ("m", "m/s", "m/s^2", "N")}

WORDS: Mapping[str, Mapping[str, str]] = {
    "en": {
        "title": "Try it",
        "picture": "the mechanism",
        "frames": "frames",
        "turn": "turn the view",
        "play": "Play",
        "pause": "Pause",
        "reset": "Reset",
        "speed": "speed",
        "drives": "drives while it plays",
        "none": "none",
        "held": "as they are now",
        "q": "Coordinates",
        "qd": "Velocities",
        "qdd": "Accelerations",
        "params": "Parameters",
        "torques": "What each driving force is made of",
        "times": "times",
        "coefficient": "coefficient",
        "value": "value",
        "share": "share",
        "Q": "what else acts",
        "passive": "not driven",
        "energies": "Energies",
        "K": "kinetic",
        "P": "potential",
        "E": "total",
        "drift": "drift",
        "drift_text": "Drift is the total energy less that at the start and the work of all forces since: the error of "
        "the integration.",
        "lost": "The motion ran away; it was stopped.",
        "stuck": "The motion cannot be played:",
        "script": "This part needs JavaScript.",
        "time": "time",
    },
    "sk": {
        "title": "Vyskúšajte",
        "picture": "mechanizmus",
        "frames": "súradnicové systémy",
        "turn": "otočiť pohľad",
        "play": "Spustiť",
        "pause": "Zastaviť",
        "reset": "Späť na začiatok",
        "speed": "rýchlosť",
        "drives": "hnacie sily počas pohybu",
        "none": "nulové",
        "held": "ako sú teraz",
        "q": "Súradnice",
        "qd": "Rýchlosti",
        "qdd": "Zrýchlenia",
        "params": "Parametre",
        "torques": "Z čoho sa skladajú zovšeobecnené hnacie sily",
        "times": "krát",
        "coefficient": "koeficient",
        "value": "hodnota",
        "share": "podiel",
        "Q": "čo ešte pôsobí",
        "passive": "bez pohonu",
        "energies": "Energie",
        "K": "kinetická",
        "P": "potenciálna",
        "E": "celková",
        "drift": "odchýlka",
        "drift_text": "Odchýlka je celková energia bez energie na začiatku a bez práce všetkých síl odvtedy: chyba "
        "integrovania.",
        "lost": "Pohyb sa vymkol; výpočet sa zastavil.",
        "stuck": "Pohyb sa nedá spustiť:",
        "script": "Táto časť potrebuje JavaScript.",
        "time": "čas",
    },
}


class Interactive(NamedTuple):
    """The page in three pieces: rules for a `<style>`, markup, and text for a `<script>` after it."""

    css: str
    body: str
    script: str


def interactive(scene: Scene, parameters: Mapping[str, float] | None = None, language: str = "en") -> Interactive:
    """Return the interactive part of a lesson; several scenes may stand in one page.

    Classes begin with "live" and ids with "live-" and the scene's name; the picture has the class "symdyn" and the
    colours of pictures. The script adds to one global name, `symdyn`.

    Args:
        scene: a tree whose coordinates are angles and lengths.
        parameters: where parameters begin; those without a value begin at 9.81 for free fall, else at 1.
        language: "en" or "sk".

    Raises:
        TeachError: a scene that sliders cannot move, or an unknown language.
        DrawError: a name that is no parameter.
        DerivationError: equations that do not exist.
        EmitError: latex2mathml is not installed.
    """
    if language not in WORDS:
        raise TeachError(f"there is no language {language!r}; there are {', '.join(WORDS)}")
    computed = live(scene)
    name = stem(scene.name)
    values = _values(scene, parameters)
    q, values = pose(scene, parameters=values)
    found = places(scene, q.reshape(1, -1), values)
    seen = watched(scene, found, values, q, None)
    extent = float(np.round(np.ptp(spread(found), axis=0).max(), 2)) or 1.0
    groups = _groups(scene, q, values, extent)
    sentences = WORDS[language]
    body = {
        "name": name,
        "title": escape(scene.name),
        "words": sentences,
        "groups": groups,
        "rows": _rows(scene, computed, sentences),
        "planar": seen.planar,
        "stuck": escape(computed.stuck),
    }
    data = _data(computed, groups, seen, sentences)
    script = {
        "code": _harmless(
            emit(computed.program, "js", command=f"symdyn walkthrough {scene.name}.toml --format html").files[1][1]
        ),
        "data": _harmless(json.dumps(data, ensure_ascii=False, separators=(",", ":"))),
        "name": name,
    }
    return Interactive(
        style("auto") + render("teach/interactive.css.jinja", {}),
        render("teach/interactive.html.jinja", body),
        render("teach/interactive.js.jinja", script),
    )


def interactive_page(scene: Scene, parameters: Mapping[str, float] | None = None, language: str = "en") -> str:
    """Return the interactive part as a page of its own, which needs nothing else; see `interactive`."""
    parts = interactive(scene, parameters, language)
    values = {"title": escape(scene.name), "language": language, **parts._asdict()}
    return render("teach/interactive_page.html.jinja", values)


def _harmless(text: str) -> str:
    """Return text that cannot end the script that it stands in: comments and strings alone hold such characters."""
    return text.replace("</", "<\\/").replace("<!--", "<\\!--")


def _values(scene: Scene, parameters: Mapping[str, float] | None) -> dict[str, float]:
    """Return where all parameters begin."""
    falls = {p.name: FREE_FALL for p in scene.free_parameters if p.unit.replace("²", "^2") == "m/s^2"}
    return values_of(scene, {**falls, **(parameters or {})})


# Sliders


def _groups(scene: Scene, q: Any, values: Mapping[str, float], extent: float) -> list[dict[str, Any]]:
    """Return sliders for position, velocity, acceleration and parameters: label, unit, range and value of each."""
    symbols = latex_symbols(scene)
    units = [unit for joint in scene.moving for unit in JOINTS[joint.type].coordinates(joint)]
    joints = [joint for joint in scene.moving for _ in joint.coordinates]
    velocities = scene.velocities
    wide = {"rad": math.pi, "m": extent}
    spans = [_span(joint, wide[unit], float(x), values) for joint, unit, x in zip(joints, units, q, strict=True)]
    groups = [("q", scene.coordinates, 0, spans, [float(x) for x in q])]
    for k, names in ((1, velocities), (2, tuple(acceleration_name(v) for v in velocities))):
        largest = [RATES[unit][k - 1] for unit in units]
        groups.append((("qd", "qdd")[k - 1], names, k, [(-x, x) for x in largest], [0.0] * len(names)))
    found = [
        {
            "key": key,
            "sliders": [
                _slider(name, symbols[name], UNITS[unit][k], span, value, "")
                for name, unit, span, value in zip(names, units, ranges, given, strict=True)
            ],
        }
        for key, names, k, ranges, given in groups
    ]
    if scene.parameters:
        sliders = [
            _slider(p.name, symbols[p.name], p.unit, _range(p, values[p.name]), values[p.name], p.text)
            for p in scene.parameters
        ]
        found.append({"key": "params", "sliders": sliders})
    return found


def _slider(name: str, latex: str, unit: str, span: tuple[float, float], value: float, text: str) -> dict[str, Any]:
    plain = from_latex(latex).plain
    spoken = f"{plain}, {text}" if text else plain
    return {
        "name": name,
        "label": inline(latex),
        "spoken": escape(spoken),
        "text": escape(text),
        "unit": re.sub(r"\^(\d)", r"<sup>\1</sup>", escape(unit)),
        "low": span[0],
        "high": span[1],
        "value": value,
    }


def _span(joint: Joint, wide: float, at: float, values: Mapping[str, float]) -> tuple[float, float]:
    """Return the range of a coordinate: the joint's limits where it has them, else `wide` each way."""
    low, high = min(-wide, at), max(wide, at)
    if len(joint.coordinates) == 1:
        bounds = [None if x is None else value_of(x, values) for x in (joint.limits.lower, joint.limits.upper)]
        low = low if bounds[0] is None or not math.isfinite(bounds[0]) else min(float(bounds[0]), at)
        high = high if bounds[1] is None or not math.isfinite(bounds[1]) else max(float(bounds[1]), at)
    return low, high


def _range(parameter: Parameter, value: float) -> tuple[float, float]:
    """Return the range of a parameter's slider: a tenth to three times its value where it must be positive."""
    if value == 0.0:
        return (0.1, 1.0) if parameter.positive else (-1.0, 1.0)
    return (value / 10, 3 * value) if parameter.positive else (-3 * abs(value), 3 * abs(value))


# Torques


def _rows(scene: Scene, computed: Live, sentences: Mapping[str, str]) -> list[dict[str, Any]]:
    """Return, driving force by driving force, its name, its unit and its terms."""
    symbols = latex_symbols(scene)
    units = [unit for joint in scene.moving for unit in JOINTS[joint.type].velocities(joint)]
    rows = []
    for i, (drive, unit) in enumerate(zip(scene.drives, units, strict=True)):
        label = inline(symbols[drive] if drive else rf"\tau_{{{i + 1}}}")
        terms = [(k, term) for k, term in enumerate(computed.terms) if term.row == i]
        rows.append(
            {
                "label": label,
                "passive": not drive,
                "unit": UNITS[unit][3],
                "terms": [{"number": k, **_term(scene, term, symbols, sentences)} for k, term in terms],
            }
        )
    return rows


def _term(scene: Scene, term: Term, symbols: Mapping[str, str], sentences: Mapping[str, str]) -> dict[str, str]:
    """Return how a term is printed: its coefficient and what that is multiplied by."""
    names = {"qd": scene.velocities, "qdd": tuple(acceleration_name(v) for v in scene.velocities)}
    factors = [symbols[names[kind][k]] for kind, k in term.rates]
    square = len(factors) == 2 and factors[0] == factors[1]
    rate = inline(f"{factors[0]}^{{2}}") if square else "\u00a0".join(inline(x) for x in factors)
    if term.function == "applied_forces":
        return {"coefficient": f"−{inline(f'Q_{{{term.row + 1}}}')}", "rate": "", "text": sentences["Q"]}
    letter, (first, *rest) = term.function[2:], [str(index + 1) for index in term.indices]
    index = f"{letter},{first},{together(rest)}" if letter == "C" else f"{letter},{together([first, *rest])}"
    return {"coefficient": inline(f"k_{{{index}}}"), "rate": rate, "text": ""}


# What the script is told


def _data(computed: Live, groups: list[dict[str, Any]], seen: View, sentences: Mapping[str, str]) -> dict[str, Any]:
    calls = {
        routine.function.name: [argument.name for argument in routine.function.arguments]
        for routine in computed.program.routines
    }
    return {
        "calls": calls,
        "start": {group["key"]: [slider["value"] for slider in group["sliders"]] for group in groups},
        "spans": [[slider["low"], slider["high"]] for slider in groups[0]["sliders"]],
        "terms": [[t.function, t.entry, t.row, t.sign, *map(list, t.rates)] for t in computed.terms],
        "marks": [[m.kind, list(m.rows), m.body, _letters(m)] for m in computed.marks],
        "points": list(computed.points),
        "gravity": computed.gravity,
        "view": [_rounded(axis) for axis in (seen.right, seen.up, seen.toward)],
        "words": {key: sentences[key] for key in ("play", "pause", "lost")},
    }


def _letters(mark: Mark) -> str:
    """Return the SVG of a mark's name."""
    return words(mark.text).svg() if mark.kind in ("point", "load") else ""


def _rounded(axis: Any) -> list[float]:
    return [float(x) for x in np.round(axis, 9) + 0.0]
