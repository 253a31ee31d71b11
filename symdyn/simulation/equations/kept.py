"""What was made for a few keys, the last ones asked for: a process holds so many, and no more."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Generic, TypeVar

T = TypeVar("T")


class Kept(Generic[T]):
    """Things by key, of which the one that was longest not asked for goes first."""

    def __init__(self, most: int = 16) -> None:
        """Hold so many at most."""
        self._most = most
        self._things: dict[Any, T] = {}

    def get(self, key: Any, make: Callable[[], T]) -> T:
        """Return the thing of a key, made if there is none."""
        found = self._things.pop(key, None)
        self.put(key, make() if found is None else found)
        return self._things[key]

    def put(self, key: Any, thing: T) -> None:
        """Hold a thing as the one that was asked for last."""
        self._things.pop(key, None)
        self._things[key] = thing
        while len(self._things) > self._most:
            del self._things[next(iter(self._things))]

    def __iter__(self) -> Iterator[Any]:
        return iter(tuple(self._things))
