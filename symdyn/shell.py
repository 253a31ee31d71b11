"""Whether this process is the shell's own: nobody else's program runs in it, so libraries need not serve one.

Half of what importing takes is the compiling of dataclasses' methods, of which a command calls a few. There they are
compiled when they are first called.
"""

from __future__ import annotations

import gc
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from inspect import Signature

_OWN = [False]

SELDOM = 200_000
"""Objects after which Python looks for cycles among them: unasked 700, of which imports and graphs make very many."""


def take() -> None:
    """Say that the process runs one command line and nothing else."""
    _OWN[0] = True
    gc.set_threshold(SELDOM)


def is_own() -> bool:
    """Tell whether that was said."""
    return _OWN[0]


def postpone() -> None:
    """Let methods of the dataclasses that are imported from now on be compiled when they are first called."""
    import dataclasses  # help needs none

    if _OWN[0] and hasattr(dataclasses, "_create_fn"):  # later than Python 3.12 all of a class are compiled at once
        create = dataclasses._create_fn
        dataclasses._create_fn = lambda name, *words, **named: _Later(lambda: create(name, *words, **named)).method(
            name
        )


class _Later:
    """A method that is not compiled yet; `inspect` asks it for its signature."""

    def __init__(self, compiled: Callable[[], Callable[..., Any]]) -> None:
        self.compiled = compiled

    @property
    def __signature__(self) -> Signature:
        from inspect import signature

        return signature(self.compiled())

    def method(self, name: str) -> Callable[..., Any]:
        """Return a function that takes the place of the method until it is called, and is called once."""

        def late(this: object, *given: Any, **named: Any) -> Any:
            found = self.compiled()
            found.__qualname__ = late.__qualname__
            for owner in type(this).__mro__:
                if vars(owner).get(name) is late:
                    setattr(owner, name, found)
            return found(this, *given, **named)

        late.__name__, late.__wrapped__ = name, self  # type: ignore[attr-defined]
        return late
