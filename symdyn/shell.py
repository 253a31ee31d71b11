"""Whether this process is the shell's own: nobody else's program runs in it, so libraries need not serve one."""

from __future__ import annotations

import dataclasses
import gc
from collections.abc import Callable
from functools import cache, partial
from typing import Any

_OWN = [False]

SELDOM = 50_000
"""Objects after which Python looks for cycles among them: unasked 700, of which imports and graphs make very many."""

LATE = ("__init__", "__repr__", "__eq__", "__hash__", "__setattr__", "__delattr__")
"""Methods that `dataclass` writes as text and compiles for every class; few classes of many are ever asked for them."""

COMPILE = "_create_fn"
"""What it compiles them by in Python 3.11 and 3.12; later ones compile all methods of a class at once."""


def take() -> None:
    """Say that the process runs one command line and nothing else."""
    compiled = getattr(dataclasses, COMPILE, None)
    if compiled is not None and not is_own():
        setattr(dataclasses, COMPILE, _late(compiled))
    _OWN[0] = True
    gc.set_threshold(SELDOM)


def is_own() -> bool:
    """Tell whether that was said."""
    return _OWN[0]


def _late(compiled: Callable[..., Any]) -> Callable[..., Any]:
    """Return what compiles methods of dataclasses, those of `LATE` when they are first called."""

    def method_of(name: str, *text: Any, **known: Any) -> Any:
        if name not in LATE:
            return compiled(name, *text, **known)

        made = cache(partial(compiled, name, *text, **known))

        def late(self: object, *given: Any, **named: Any) -> Any:
            method = made()
            method.__qualname__ = late.__qualname__
            for owner in type(self).__mro__:
                if vars(owner).get(name) is late:
                    setattr(owner, name, method)
            return method(self, *given, **named)

        late.__name__ = name
        return late

    return method_of
