"""Colours of a GIF: 256 for all frames of a film, and the nearest of them for every pixel."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from symdyn.draw.paint import Frame

FRAMES, EXACT = 9, 32  # frames that the colours of a GIF are taken from, and colours that are not mixed


def palette_of(shown: Sequence[Frame]) -> Frame:
    """Return 256 colours for all frames, taken from some of them, so that none flickers; those of faces are exact."""
    from PIL import Image

    packed, counts = np.unique(np.concatenate([_packed(one).ravel() for one in shown]), return_counts=True)
    colours = _unpacked(packed)
    exact = colours[np.argsort(-counts, kind="stable")[:EXACT]]
    mixed = Image.fromarray(colours[None]).quantize(256 - EXACT, method=Image.Quantize.MEDIANCUT).getpalette() or []
    found = np.concatenate([exact, np.array(mixed, dtype=np.uint8).reshape(-1, 3)])[:256]
    return np.concatenate([found, np.repeat(found[:1], 256 - len(found), axis=0)])


def _packed(frame: Frame) -> Any:
    return frame.astype(np.uint32) @ np.array([65536, 256, 1], dtype=np.uint32)


def _unpacked(packed: Any) -> Frame:
    return np.stack([packed >> 16, packed >> 8 & 255, packed & 255], axis=-1).astype(np.uint8)


class Nearest:
    """Gives every pixel of a frame its nearest colour of a palette; Pillow looks for one that is about as near."""

    def __init__(self, palette: Frame) -> None:
        from scipy.spatial import KDTree

        self.palette, self.tree = palette, KDTree(palette.astype(np.float64))
        self.known = np.full(2**24, -1, dtype=np.int16)

    def __call__(self, frame: Frame) -> Any:
        """Return the frame as an image of Pillow."""
        from PIL import Image

        packed = _packed(frame)
        new = np.unique(packed[self.known[packed] < 0])
        if len(new):
            self.known[new] = self.tree.query(_unpacked(new).astype(np.float64))[1]
        image = Image.fromarray(self.known[packed].astype(np.uint8))
        image.putpalette(self.palette.tobytes())
        return image
