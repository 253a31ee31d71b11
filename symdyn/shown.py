"""What a notebook asks an object for: every noun that a function returns is shown by what registers here."""

from __future__ import annotations

from collections.abc import Callable

_BUNDLES: list[Callable[[object], dict[str, str]]] = []


def shown_by(bundle: Callable[[object], dict[str, str]]) -> None:
    """Take what returns the text of a noun by media type; it is above all nouns, and says so itself."""
    _BUNDLES[:] = [bundle]


class Shown:
    """A noun that a notebook shows as a person wants to see it."""

    __slots__ = ()

    def _repr_mimebundle_(self, include: object = None, exclude: object = None) -> dict[str, str]:
        """Return what is shown, by media type: HTML, LaTeX; plain text is `repr`."""
        (bundle,) = _BUNDLES
        return bundle(self)
