"""Every error that symdyn raises on purpose; the command line prints its text and nothing else.

A message says where, what was found and what would work.
"""

from __future__ import annotations

from collections.abc import Sequence


class SymdynError(Exception):
    """Base of all errors that a user can cause and mend."""


class SceneError(SymdynError):
    """A scene that cannot be built; carries all of its faults, one line each."""

    def __init__(self, faults: str | Sequence[str]) -> None:
        """Store the faults, shape (at least one line)."""
        self.faults: tuple[str, ...] = (faults,) if isinstance(faults, str) else tuple(faults)
        super().__init__("\n".join(self.faults))


class DerivationError(SymdynError):
    """Equations that do not exist for this scene, such as forward dynamics with a singular mass matrix."""


class NoValueError(SymdynError, ArithmeticError, ValueError):
    """A formula without a value as a double where it is asked for: log(-1), 1/0, exp(1000)."""


class EmitError(SymdynError):
    """A target that cannot express what was asked."""


class BuildError(SymdynError):
    """A compiler that is missing or that refused; carries the compiler's own words."""


class MissingCompiler(BuildError):  # noqa: N818  what is missing, not what went wrong
    """There is no C compiler on this machine."""


class MissingNode(BuildError):  # noqa: N818
    """There is no Node.js on this machine."""


class DrawError(SymdynError):
    """A picture that cannot be drawn."""


class VerifyError(SymdynError):
    """A certificate that cannot be made."""


class TeachError(SymdynError):
    """A lesson that cannot be made, or a student's text that cannot be read."""


class SimulateError(SymdynError):
    """A motion, force, start, event or method that cannot be used; carries all faults, one line each."""

    def __init__(self, faults: str | Sequence[str]) -> None:
        """Store the faults, shape (at least one line)."""
        self.faults: tuple[str, ...] = (faults,) if isinstance(faults, str) else tuple(faults)
        super().__init__("\n".join(self.faults))
