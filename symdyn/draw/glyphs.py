"""Letters as outlines, from the fonts that come with matplotlib: the same on every machine, whatever is installed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from symdyn.draw.canvas import import_matplotlib
from symdyn.draw.lettering import DROP, FONT, SMALL, Text
from symdyn.draw.places import Array

FACES = {"": "STIXGeneral.ttf", "i": "STIXGeneralItalic.ttf", "t": "DejaVuSansMono.ttf"}
"""Faces of runs; STIX is what style sheets of pictures ask for first."""

WIDEST = "DejaVuSans.ttf"
"""Has what the face of a run lacks; what it lacks too is shown as a box."""

EM = 100.0


@dataclass(frozen=True)
class Outline:
    """Vertices, shape (n, 2), and what leads to each, as matplotlib codes them; units of the picture, y down."""

    vertices: Array
    codes: Any


@cache
def outlined(text: Text) -> Outline:
    """Return a name as outlines, centred on (0, 0), which lies on its line."""
    vertices, codes, x = [np.zeros((0, 2))], [np.zeros(0, dtype=np.uint8)], 0.0
    for run in text.runs:
        size = FONT * (SMALL if run.level else 1.0) / EM
        for character in run.text:
            glyph, verbs, wide = _glyph(FACES[run.face], character)
            vertices.append(glyph * (size, -size) + (x, -run.level * DROP * FONT))
            codes.append(verbs)
            x += wide * size
    return Outline(np.concatenate(vertices) - (x / 2, 0), np.concatenate(codes))


@cache
def _glyph(name: str, character: str) -> tuple[Array, Any, float]:
    """Return the outline of a character at a size of EM, y up, and how far the next one stands."""
    font = _font(name) if _font(name).get_char_index(ord(character)) else _font(WIDEST)
    found = font.load_glyph(font.get_char_index(ord(character)), flags=_unhinted())  # 0 where there is none: a box
    vertices, codes = font.get_path()
    return np.array(vertices).reshape(-1, 2), np.array(codes, dtype=np.uint8), found.linearHoriAdvance / 65536


@cache
def _font(name: str) -> Any:
    mpl = import_matplotlib()
    from matplotlib.ft2font import FT2Font

    font = FT2Font(str(Path(mpl.get_data_path()) / "fonts" / "ttf" / name))
    font.set_size(EM, 72)
    return font


@cache
def _unhinted() -> Any:
    """Return the flag of outlines as they were designed, by whichever name matplotlib has it."""
    from matplotlib import ft2font

    flags: Any = getattr(ft2font, "LoadFlags", None)
    return vars(ft2font)["LOAD_NO_HINTING"] if flags is None else flags.NO_HINTING
