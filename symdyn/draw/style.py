"""The style sheet of pictures: colours for light and dark, the same shapes in both; light in print.

The style sheet read by rule, for what draws without a browser: which colours and lines an element has.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from symdyn.draw.lettering import FONT
from symdyn.errors import DrawError

LIGHT = {
    "paper": "#ffffff", "ink": "#1b1f24", "soft": "#5c6672", "shade": "#e9edf2", "mark": "#00665f",
    "force": "#b3261e", "couple": "#7a3aa8", "x": "#b3261e", "y": "#1f7a3d", "z": "#2456b8",
    "body0": "#2f66b0", "body1": "#b4540f", "body2": "#2a7f50", "body3": "#86479f", "body4": "#8a6500",
    "body5": "#b5375a",
}  # fmt: skip

DARK = {
    "paper": "#12171d", "ink": "#e8ebef", "soft": "#a3adb8", "shade": "#2a323c", "mark": "#58d1c4",
    "force": "#ff8a7d", "couple": "#d0a2f2", "x": "#ff8a7d", "y": "#74d394", "z": "#8db8ff",
    "body0": "#86b4f2", "body1": "#f2a06e", "body2": "#73cc9c", "body3": "#cba4e2", "body4": "#dcbb55",
    "body5": "#f090ae",
}  # fmt: skip

SCHEMES = {"light": LIGHT, "dark": DARK}

RULES = """
@media screen{.symdyn{max-width:100%;height:auto}}
.symdyn .sheet{fill:[paper]}
.symdyn path,.symdyn circle,.symdyn ellipse{fill:none;stroke:[ink];stroke-linejoin:round}
.symdyn .joint,.symdyn .com,.symdyn .ring{fill:[paper]}
.symdyn ellipse.joint,.symdyn path.joint,.symdyn .ball{fill:[shade]}
.symdyn .edge,.symdyn .inside{fill:none}
.symdyn path.inside{stroke:[shade]}
.symdyn .halo{stroke:[paper];stroke-linecap:round}
.symdyn .link{stroke-linecap:round}
.symdyn ellipse.link{stroke-width:3}
.symdyn .quarters,.symdyn .weld{fill:[ink];stroke:none}
.symdyn .stem,.symdyn .hatch,.symdyn .rail,.symdyn .flight,.symdyn .axis,.symdyn .rod,.symdyn .trace{stroke:[soft]}
.symdyn .support,.symdyn .stand,.symdyn .plate{fill:[shade];stroke:[soft]}
.symdyn .post{stroke:[soft]}
.symdyn .plate{fill-opacity:.4}
.symdyn .axis{stroke-dasharray:7 2.5 1.5 2.5}
.symdyn .axis.head{fill:[soft];stroke-dasharray:none}
.symdyn .flight,.symdyn .gap{stroke-dasharray:4 3}
.symdyn .gap{stroke:[force]}
.symdyn .mark{stroke:[mark]}
.symdyn .sense{stroke-dasharray:4 2.5}
.symdyn .head{stroke-dasharray:none}
.symdyn .mark.head{fill:[mark]}
.symdyn .zero{stroke:[soft];stroke-dasharray:3 2.5}
.symdyn .extension,.symdyn .leader{stroke:[soft]}
.symdyn .force{stroke:[force]}
.symdyn .force.head{fill:[force]}
.symdyn .couple{stroke:[couple]}
.symdyn .couple.head{fill:[couple]}
.symdyn .gravity{stroke:[ink]}
.symdyn .gravity.head{fill:[ink]}
.symdyn text{fill:[ink];font-family:serif;text-anchor:middle}
.symdyn text:nth-child(n){\
font-family:"STIX Two Text","Latin Modern Roman",Cambria,Georgia,"Times New Roman",serif}
.symdyn .mark-text{fill:[mark]}
.symdyn .force-text{fill:[force]}
.symdyn .couple-text{fill:[couple]}
.symdyn .i{font-style:italic}
.symdyn .t{font-family:monospace}
"""

"""Programs of Qt know no list of fonts and no selector that counts: they take the first of both rules for letters."""

HALO = """\
@supports (paint-order:stroke){.symdyn text{stroke:[paper];stroke-width:3;paint-order:stroke;stroke-linejoin:round}}
"""
"""Letters stand out of lines by an edge, where it is painted behind them; other programs would paint it over them."""


def plain(scheme: str) -> str:
    """Return the scheme that stands for one where there is no reader whose preference it could follow.

    Raises:
        DrawError: another scheme.
    """
    if scheme not in ("auto", *SCHEMES):
        raise DrawError(f'colour scheme "{scheme}" is unknown; known are auto, light, dark')
    return "light" if scheme == "auto" else scheme


def style(scheme: str) -> str:
    """Return the style sheet.

    Colours are written out, and once more for the dark: programs that draw pictures outside browsers know no variables
    of CSS, and paint black what they cannot read. The scheme "auto" follows the reader's preference.

    Raises:
        DrawError: another scheme.
    """
    if scheme != "auto":
        return _coloured(SCHEMES[plain(scheme)])
    dark = "\n".join(line for line in _coloured(DARK).splitlines() if "fill:" in line or "stroke:" in line)
    return (
        f"{_coloured(LIGHT)}{HALO.replace('[paper]', LIGHT['paper'])}"
        f"@media screen and (prefers-color-scheme:dark){{\n{dark}\n{HALO.replace('[paper]', DARK['paper'])}}}\n"
    )


def _coloured(colours: dict[str, str]) -> str:
    """Return the rules in one scheme."""
    rules = f"{RULES.strip()}\n.symdyn text{{font-size:{FONT:g}px}}\n"
    rules += "".join(
        f".symdyn .link.body{k}{{stroke:[body{k}]}}\n.symdyn .particle.body{k}{{fill:[body{k}]}}\n" for k in range(6)
    )
    rules += "".join(
        f".symdyn .triad-{a}{{stroke:[{a}]}}\n.symdyn .triad-{a}.head,.symdyn .{a}-text{{fill:[{a}]}}\n" for a in "xyz"
    )
    for name, colour in colours.items():
        rules = rules.replace(f"[{name}]", colour)
    return rules


Look = dict[str, str]


@dataclass(frozen=True)
class Rule:
    """What the style sheet says of one kind of element.

    Attributes:
        tag: its name, "" for any.
        classes: that it must have.
        look: properties by name.
    """

    tag: str
    classes: frozenset[str]
    look: Mapping[str, str]


@cache
def rules(scheme: str = "light") -> tuple[Rule, ...]:
    """Return the rules of a plain scheme, in order; "auto" is light, as it is in print.

    Raises:
        DrawError: another scheme.
    """
    found = []
    text = style(plain(scheme))
    for selectors, body in re.findall(r"^([^@{}\n][^{}]*)\{([^{}]*)\}", text, re.MULTILINE):
        look = dict(part.split(":", 1) for part in body.split(";") if ":" in part)
        for selector in selectors.split(","):
            tag, *classes = selector.split()[-1].split(".")
            found.append(Rule(tag, frozenset(classes), look))
    return tuple(found)


def look_of(tag: str, classes: str, scheme: str = "light", **own: str) -> Look:
    """Return how an element looks that has classes and attributes of its own; the style sheet has the last word."""
    having = set(classes.split())
    fitting = [rule for rule in rules(scheme) if rule.tag in ("", tag) and rule.classes <= having]
    fitting.sort(key=lambda rule: (len(rule.classes), bool(rule.tag)))  # stable: the later of two alike wins
    look: Look = dict(own)
    for rule in fitting:
        look |= rule.look
    return look
