"""Frozen dataclasses that are made in a fifth of the time: a command makes hundreds of them while it starts.

Those of the standard library have six methods each, written as text and compiled one by one. Here `__init__` alone is
compiled; the others look the fields up. What is asked for beside `eq`, `repr` and `init`, and a class that may change,
is the standard library's; a frozen class of its kind inherits none from here.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable
from dataclasses import MISSING, FrozenInstanceError, InitVar, asdict, field, fields, is_dataclass, replace
from functools import cache, partial
from operator import attrgetter
from reprlib import recursive_repr
from types import CellType, CodeType, FunctionType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dataclasses import dataclass
else:

    def dataclass(
        cls: type | None = None, /, *, frozen: bool = False, eq: bool = True, repr: bool = True, init: bool = True,
        **more: bool,
    ) -> Any:  # fmt: skip
        """Return a class with its fields, as `dataclasses.dataclass` does, or what makes one of a class."""
        asked = {"frozen": frozen, "eq": eq, "repr": repr, "init": init, **more}
        if cls is None:
            return partial(dataclass, **asked)
        if not frozen or more or any("InitVar" in str(one) for one in getattr(cls, "__annotations__", {}).values()):
            return dataclasses.dataclass(cls, **asked)
        own = vars(dataclasses.dataclass(cls, init=False, repr=False, eq=False))
        methods: dict[str, Any] = {
            "__setattr__": _refused(cls, super(cls, cls).__setattr__, "assign to"),
            "__delattr__": _refused(cls, super(cls, cls).__delattr__, "delete"),
        }
        if init and "__init__" not in own:
            methods["__init__"] = _initial(cls)
        if eq and "__eq__" not in own:
            methods["__eq__"] = _equal(_values([one.name for one in fields(cls) if one.compare]))
        if eq and own.get("__hash__") is None:
            counted = (one for one in fields(cls) if (one.compare if one.hash is None else one.hash))
            methods["__hash__"] = _hash(_values([one.name for one in counted]))
        for name, method in methods.items():
            method.__name__, method.__qualname__ = name, f"{cls.__qualname__}.{name}"
            setattr(cls, name, method)
        if repr and "__repr__" not in own:
            cls.__repr__ = _shown
        return cls


class _Factory:
    def __repr__(self) -> str:
        return "<factory>"


_FACTORY = _Factory()
"""The default of a field that is made anew for every object."""


@cache
def _code(count: int, made: tuple[int, ...], post: bool) -> CodeType:
    """Return the code of `__init__` of fields _0, _1 and so on.

    Args:
        count: of fields that are arguments, the first ones.
        made: fields that are made anew where they are not given.
        post: whether `__post_init__` follows.
    """
    values = {k: f"_{k}" for k in range(count)}
    values |= {k: f"_made['_{k}']()" + f" if _{k} is _factory else _{k}" * (k < count) for k in made}
    body = [f"_put(self, '_{k}', {value})" for k, value in values.items()]
    head = f" def __init__({', '.join(['self', *(f'_{k}' for k in range(count))])}):"
    lines = "\n  ".join([head, *body, "self.__post_init__()" if post else "pass"])
    found: dict[str, Any] = {}
    exec(f"def outer(_put, _factory, _made):\n{lines}\n return __init__", found)
    code: CodeType = found["outer"](None, None, None).__code__
    return code


def _initial(cls: type) -> Callable[..., None]:
    """Return `__init__` of a class: the code that all with as many fields share, with the names of its own."""
    every = sorted(fields(cls), key=lambda one: one.kw_only is True)  # last, as they all have defaults
    made = {one.name: one.default_factory for one in every if one.default_factory is not MISSING}
    taken = {one.name: one for one in every if one.init}
    names = [*taken, *(name for name in made if name not in taken)]
    code = _code(len(taken), tuple(k for k, name in enumerate(names) if name in made), hasattr(cls, "__post_init__"))
    own: dict[object, str] = {f"_{k}": name for k, name in enumerate(names)}
    variables, values = (tuple(own.get(one, one) for one in part) for part in (code.co_varnames, code.co_consts))
    known = {"_put": object.__setattr__, "_factory": _FACTORY, "_made": made}
    usual = [_FACTORY if name in made else one.default for name, one in taken.items()]
    first = next((k for k, one in enumerate(usual) if one is not MISSING), len(usual))
    if MISSING in usual[first:]:
        raise TypeError(f"{cls.__qualname__}: a field without a default follows one with a default")
    method = FunctionType(
        code.replace(co_varnames=variables, co_consts=values), vars(sys.modules[cls.__module__]), "__init__",
        tuple(usual[first:]), tuple(CellType(known[name]) for name in code.co_freevars),
    )  # fmt: skip
    method.__annotations__ = {**{name: one.type for name, one in taken.items()}, "return": None}
    return method


@recursive_repr()
def _shown(self: Any) -> str:
    told = (f"{one.name}={getattr(self, one.name)!r}" for one in fields(self) if one.repr)
    return f"{type(self).__qualname__}({', '.join(told)})"


def _values(names: list[str]) -> Callable[[Any], tuple[Any, ...]]:
    """Return what gives the values of fields."""
    found: Callable[[Any], Any] = attrgetter(*names) if names else lambda self: ()
    return found if len(names) != 1 else lambda self: (found(self),)


def _equal(values: Callable[[Any], tuple[Any, ...]]) -> Callable[..., Any]:
    return lambda self, other: values(self) == values(other) if other.__class__ is self.__class__ else NotImplemented


def _hash(values: Callable[[Any], tuple[Any, ...]]) -> Callable[..., int]:
    return lambda self: hash(values(self))


def _refused(cls: type, change: Callable[..., None], words: str) -> Callable[..., None]:
    """Return what changes no field, and no attribute of the class itself."""

    def changed(self: Any, name: str, *value: Any) -> None:
        if type(self) is cls or name in cls.__dataclass_fields__:  # type: ignore[attr-defined]
            raise FrozenInstanceError(f"cannot {words} field {name!r}")
        change(self, name, *value)

    return changed


__all__ = ["MISSING", "InitVar", "asdict", "dataclass", "field", "fields", "is_dataclass", "replace"]
