"""What an object works out once, when it is first asked for it.

The `cached_property` of Python 3.11 has a lock, one for all objects of a class, and a child that was forked while
another thread worked something out finds it shut for ever. From 3.12 on there is none, and two threads that ask first
at a time may both work it out.
"""

from __future__ import annotations

import functools
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING or sys.version_info >= (3, 12):
    from functools import cached_property
else:

    class cached_property(functools.cached_property):  # noqa: N801  as in the standard library
        """That of Python 3.12."""

        def __get__(self, instance: Any, owner: type | None = None) -> Any:
            if instance is None:
                return self
            found = instance.__dict__
            if self.attrname not in found:
                found[self.attrname] = self.func(instance)
            return found[self.attrname]


__all__ = ["cached_property"]
