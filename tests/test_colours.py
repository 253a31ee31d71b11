"""Colours of bodies and arrows, on both papers, are told apart by everybody, and read on their paper.

Vision of one kind of cones less: Machado, Oliveira, Fernandes, A physiologically-based model for simulation of color
vision deficiency, IEEE TVCG 15 (2009), severity 1. Differences are CIE 1976 ΔE*ab, 2.3 of which is just noticed;
contrast is that of WCAG 2.
"""

from __future__ import annotations

import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from symdyn.algebra import Array
from symdyn.draw.style import DARK, LIGHT

VISIONS = {
    "of all cones": np.eye(3),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "tritanopia": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    ),
}
TO_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
WHITE = np.array([0.95047, 1.0, 1.08883])
TEACH = Path(__file__).parent.parent / "templates/teach"
PAPERS, PAGES = (
    [
        dict(re.findall(r"--([a-z-]+):(#[0-9a-f]+)", line))
        for line in (TEACH / name).read_text(encoding="utf-8").splitlines()[:2]
    ]
    for name in ("interactive_figure.css", "interactive.css")
)
PALETTES = {
    **{
        f"bodies, {name}": {k: x for k, x in one.items() if k.startswith("body")}
        for name, one in (("light", LIGHT), ("dark", DARK))
    },
    **{
        f"arrows, {name}": {k: x for k, x in one.items() if len(k) < 4}
        for name, one in zip(("light", "dark"), PAPERS, strict=True)
    },
    **{
        f"energies, {name}": {k: one[f"live-{k}"] for k in ("plus", "minus", "e")}
        for name, one in zip(("light", "dark"), PAGES, strict=True)
    },
}
LEAST = {"bodies": 12.0, "arrows": 25.0, "energies": 25.0}


def linear(colour: str) -> Array:
    """Return linear red, green and blue of a colour as #rrggbb."""
    values = np.array([int(colour.ljust(7, colour[-1])[k : k + 2], 16) for k in (1, 3, 5)]) / 255
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def lab(rgb: Array) -> Array:
    """Return L*, a*, b* of what is linear."""
    xyz = TO_XYZ @ np.clip(rgb, 0, 1) / WHITE
    x, y, z = np.where(xyz > 216 / 24389, np.cbrt(xyz), (24389 / 27 * xyz + 16) / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("vision", VISIONS)
@pytest.mark.parametrize("palette", PALETTES)
def test_colours_are_told_apart(palette: str, vision: str) -> None:
    seen = {name: lab(VISIONS[vision] @ linear(colour)) for name, colour in PALETTES[palette].items()}
    assert len(seen) == {"bodies": 6, "arrows": 9, "energies": 3}[palette.partition(",")[0]]
    apart = {(a, b): float(np.linalg.norm(seen[a] - seen[b])) for a, b in combinations(seen, 2)}
    assert min(apart.values()) > LEAST[palette.partition(",")[0]], sorted(apart.items(), key=lambda one: one[1])[:3]


@pytest.mark.parametrize("palette", PALETTES)
def test_colours_are_read_on_their_paper(palette: str) -> None:
    paper = (DARK if "dark" in palette else LIGHT)["paper"]
    light = {
        name: float(TO_XYZ[1] @ linear(colour)) + 0.05 for name, colour in {**PALETTES[palette], "": paper}.items()
    }
    own = light.pop("")
    assert min(max(own, one) / min(own, one) for one in light.values()) > 4.5
