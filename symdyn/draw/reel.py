"""How a film is shown."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Reel:
    """How a film is shown.

    Attributes:
        fps: frames, or moments that are kept, a second of real time; None for what is usual of the kind of file.
        size: width in pixels, or width and height; None for the size of the drawing.
        loop: whether it begins again at its end.
    """

    fps: float | None = None
    size: int | tuple[int, int] | None = None
    loop: bool = True
