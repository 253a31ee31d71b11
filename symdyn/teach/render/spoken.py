"""What a screen reader says of the formulas of a page: `alttext` of MathML, and hidden words in heads of tables.

A program that reads MathML by itself goes by the markup and leaves the text aside.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from xml.etree import ElementTree

from symdyn.emit import in_html

_MATH = re.compile(r"<math>(.*?)</math>", re.DOTALL)
_HEAD = re.compile(r"<th(| [^>]*)>((?:(?!</th>).)*?</math>)</th>", re.DOTALL)
_TAG = re.compile(r"<[^>]*>")
DOTS = {"˙": "dot", "¨": "dots", "¯": "bar"}
SIGNS = {"+": "plus", "−": "minus", "=": "equal", "≈": "about", "∂": "partial", "⋅": "times", "·": "times"}


def with_words(page: str, words: Mapping[str, str]) -> str:
    """Return a page whose formulas say in words what they show; `words` by the keys "say_…" of a language's page."""
    said: dict[str, str] = {}

    def text(inside: str) -> str:
        if inside not in said:
            said[inside] = in_html(_said(ElementTree.fromstring(f"<math>{inside}</math>"), words))
        return said[inside]

    def head(found: re.Match[str]) -> str:
        if _TAG.sub("", _MATH.sub("", found[2])).strip():
            return found[0]
        label = " ".join(text(inside) for inside in _MATH.findall(found[2]))
        return f'<th{found[1]}><span class="said">{label}</span><span aria-hidden="true">{found[2]}</span></th>'

    page = _HEAD.sub(head, page)
    return _MATH.sub(lambda found: f'<math alttext="{text(found[1])}">{found[1]}</math>', page)


def _said(element: ElementTree.Element, words: Mapping[str, str]) -> str:
    """Return an element in words."""
    parts = [_said(child, words) for child in element]
    tag, own = element.tag, (element.text or "").strip()
    if not parts:
        return words[f"say_{SIGNS[own]}"] if own in SIGNS else own
    if tag == "mfrac":
        return f"{_grouped(parts[0])} {words['say_over']} {_grouped(parts[1])}"
    if tag == "msqrt":
        return f"{words['say_root']} {_grouped(' '.join(parts))}"
    if tag == "mover" and parts[1] in DOTS:
        return f"{parts[0]} {words[f'say_{DOTS[parts[1]]}']}"
    if tag in ("msup", "msubsup"):
        base, power = " ".join(parts[:-1]), parts[-1]
        return f"{base} {words['say_squared']}" if power == "2" else f"{base} {words['say_power']} {power}"
    return " ".join(filter(None, parts))


def _grouped(text: str) -> str:
    """Return what is more than one word in brackets, so that it is heard where it ends."""
    return f"({text})" if " " in text else text
