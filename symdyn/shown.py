"""What a notebook asks an object for: every noun that a door returns shows itself by its row in `symdyn.notebook`."""

from __future__ import annotations

from importlib import import_module
from typing import Any


class Shown:
    """A noun that a notebook shows as a person wants to see it.

    The room that knows how is above all others, and is imported when a notebook asks.
    """

    __slots__ = ()

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, str]:
        """Return what is shown, by media type: HTML, LaTeX; plain text is `repr`."""
        found: dict[str, str] = import_module("symdyn.notebook").bundle(self)
        return found
