"""Pictures without a mechanism: lines, dots and texts, in the looks of the style sheet."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from symdyn.draw.label_places import Label, Put
from symdyn.draw.lettering import FONT, Text
from symdyn.draw.shapes import Item, Shape, dot, path
from symdyn.draw.svg import Drawing, svg
from symdyn.draw.titles import Title


@dataclass
class Diagram:
    """A picture that is made shape by shape; places are in units of the picture, y down.

    Attributes:
        title: for readers and screen readers.
        id: of the group of all shapes.
        FONT: height of letters, units of the picture.
    """

    title: str
    id: str
    shapes: list[Shape] = field(default_factory=list)
    labels: list[Put] = field(default_factory=list)
    FONT: ClassVar[float] = FONT

    def text(self, text: Text, x: float, y: float) -> None:
        """Put a text with its middle at a point."""
        label = Label(f"label-{len(self.labels)}", text, np.array([[x, y]]), 0.0)
        self.labels.append(Put(label, np.zeros(2)))

    def line(self, look: str, points: npt.ArrayLike, size: float = 1.0) -> None:
        """Draw a line through points, shape (K, 2), so thick."""
        self.shapes.append(path(look, np.array([points], dtype=np.float64), size=size))

    def dot(self, look: str, at: npt.ArrayLike, radius: float) -> None:
        """Draw a dot about a point, shape (2,)."""
        self.shapes.append(dot(look, np.array([at], dtype=np.float64), radius))

    def svg(self, prefix: str) -> str:
        """Return it as SVG; `prefix` stands in front of ids."""
        item = Item(self.id, Title("{text}", text=self.title), 1, np.zeros(1), tuple(self.shapes))
        return svg(Drawing(self.title, (item,), tuple(self.labels)), prefix)
