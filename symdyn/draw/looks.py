"""The style sheet read by rule, for what draws without a browser: which colours and lines an element has."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from symdyn.draw.style import plain, style

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
