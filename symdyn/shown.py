"""What a notebook asks an object for: every noun that a function returns is shown by what registers here."""

from __future__ import annotations

from collections.abc import Callable
from types import FunctionType
from typing import TYPE_CHECKING, Any

_BUNDLES: list[Callable[[object], dict[str, str]]] = []

OF_ARRAYS = ("ndim", "strides", "dtype")
"""What arguments are asked for, to tell arrays from nouns: often, and by no user."""

NAMED = ("parameters", "joints", "bodies", "points")
"""What has entries in brackets by their names, of a scene."""


def shown_by(bundle: Callable[[object], dict[str, str]]) -> None:
    """Take what returns the text of a noun by media type; it is above all nouns, and says so itself."""
    _BUNDLES[:] = [bundle]


class Suggesting:
    """A noun that says which of its attributes was meant by a name that is none, and how a method is called."""

    __slots__ = ()

    def __init_subclass__(cls, **words: Any) -> None:
        """Let its methods say how they are called where a call does not fit."""
        super().__init_subclass__(**words)
        for name, method in list(vars(cls).items()):
            own = getattr(method, "__func__", method)  # of a class method
            if isinstance(own, FunctionType) and (name == "__call__" or not name.startswith("_")):
                from symdyn.arguments import suggesting  # no noun is made where the package is only imported

                called = suggesting(own)
                setattr(cls, name, called if own is method else type(method)(called))

    if not TYPE_CHECKING:  # else type checkers would take every name for an attribute

        def __getattr__(self, name: str) -> object:
            """Raise AttributeError; of a column or another name that brackets take, it says so."""
            kind = type(self)
            fields = (*OF_ARRAYS, *getattr(kind, "__dataclass_fields__", ()))
            if name.startswith("_") or hasattr(kind, name) or name in fields:
                return object.__getattribute__(self, name)  # raises what it has raised before
            from symdyn.errors import hint, listed, nearest, suggestion, with_own_names  # an error's own

            keys = self.keys() if hasattr(kind, "keys") and not isinstance(self, str) else ()
            known = [one for one in dir(self) if not one.startswith("_")]
            told = with_own_names(hint("attributes", name, known), self).replace("$", name)
            has = [one for one in NAMED if one in known and name in getattr(getattr(self, one), "keys", tuple)()]
            if name in keys:
                told = f'write ["{name}"]'
            elif has and not told:
                told = f'write .{has[0]}["{name}"]'
            elif not told and (near := nearest(name, [*known, *keys])) not in known and near:
                told = f'did you mean ["{near}"]?'
            told = told or suggestion(name, known) + (f"; brackets take {listed(keys, 4)}" if keys else "")
            raise AttributeError(f"{kind.__name__} has no attribute {name!r}; {told}")

        def __getitem__(self, key: object) -> object:
            """Raise ArgumentError; a noun that has something in brackets has a method of its own."""
            from symdyn.errors import ArgumentError, hint, with_own_names

            told = hint("attributes", "[]", dir(self)).replace("$", key if isinstance(key, str) else "NAME")
            told = with_own_names(told, self) or "it is no list"
            raise ArgumentError(f"{type(self).__name__}: key = {key!r:.60}: nothing is in its brackets; {told}")


class Shown(Suggesting):
    """A noun that a notebook shows as a person wants to see it."""

    __slots__ = ()

    def _repr_mimebundle_(self, include: object = None, exclude: object = None) -> dict[str, str]:
        """Return what is shown, by media type: HTML, LaTeX; plain text is `repr`."""
        (bundle,) = _BUNDLES
        return bundle(self)


class BySympy:
    """A noun that is an expression to `sympy.sympify`, `sympy.latex` and `sympy.pprint`: what `_sympy_` returns."""

    __slots__ = ()

    def _latex(self, printer: Any) -> Any:
        return printer._print(self._sympy_())  # type: ignore[attr-defined]

    _pretty = _latex
