"""The errors that packages raise in common; the command line prints the text of every one and nothing else.

A message says where, what was found and what would work. It may quote a stranger's file, so it is made printable here,
at one place for all: a terminal that shows it obeys nothing that the file says.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence


def printable(text: str, keep: str = "\n\t") -> str:
    r"""Return text whose control and direction characters are spelled, \x1b, but for those to keep.

    >>> printable("\x1b[2J\u202etxt.exe")
    '\\x1b[2J\\u202etxt.exe'
    """
    if text.isprintable():
        return text
    return "".join(x if x.isprintable() or x in keep else _spelled(x) for x in text)


LONGEST_WORD = 240
"""Characters of a run of letters without a space that a message shows; of a longer one, its begin and its end."""

QUOTED = 60
"""Characters of a wrong value that a message quotes."""

_LONG = re.compile(rf"\S{{{LONGEST_WORD + 1},}}")


def quoted(value: object) -> str:
    """Return what a message shows of a wrong value, in one line; of what cannot be shown, its type.

    >>> quoted("a" * 100)[-5:]
    'aa...'
    """
    try:
        text = " ".join(repr(value).split())
    except Exception:  # a list in a list in a list, or a class of the user's whose own words fail
        text = f"<{type(value).__name__}>"
    return printable(text if len(text) <= QUOTED else f"{text[:QUOTED]}...", keep="")


def spoken(value: object) -> str:
    """Return something as text, whatever it is."""
    try:
        return str(value)
    except Exception:  # as of `quoted`
        return f"<{type(value).__name__}>"


def _told(message: object, keep: str = "\n\t") -> str:
    """Return a message made printable, a name of a page's length shortened."""
    return printable(without_long_words(spoken(message)), keep)


def without_long_words(text: str) -> str:
    """Return text in which a name of a page's length is shortened to its begin and its end."""
    return _LONG.sub(lambda found: f"{found[0][:80]}...{found[0][-40:]}", text)


def _spelled(character: str) -> str:
    space = unicodedata.category(character) == "Zs"  # a thin space is no control
    return character if space else character.encode("unicode_escape").decode("ascii")


class SymdynError(Exception):
    """Base of all errors that a user can cause and mend."""

    def __init__(self, message: object = "") -> None:
        """Store the message, made printable; a name of a page's length is shortened."""
        super().__init__(_told(message))


class _FaultsError(SymdynError):
    """Carries faults, one line each."""

    def __init__(self, faults: str | Sequence[str]) -> None:
        """Store the faults, shape (at least one line); no fault breaks its line, to begin one that looks like ours."""
        every = (faults,) if isinstance(faults, str) else faults
        self.faults: tuple[str, ...] = tuple(_told(fault, keep="") for fault in every)
        super().__init__("\n".join(self.faults))

    def __reduce__(self) -> tuple[type[_FaultsError], tuple[tuple[str, ...]]]:
        """Return how to make it again in another process."""
        return type(self), (self.faults,)


class SceneError(_FaultsError):
    """A scene that cannot be built; carries all of its faults, one line each."""


class SymdynWarning(RuntimeWarning):
    """What the user should know though the work goes on, such as slower code for want of a compiler."""


class DerivationError(SymdynError):
    """Equations that do not exist for this scene, such as forward dynamics with a singular mass matrix."""


class NoValueError(SymdynError, ArithmeticError, ValueError):
    """A formula without a value as a double where it is asked for: log(-1), 1/0, exp(1000)."""


class UnknownNameError(SymdynError, KeyError):
    """A name that something does not have, asked for in brackets: run["q9"]."""

    __str__ = Exception.__str__  # that of KeyError puts its text into quotes


class ArgumentError(SymdynError, TypeError, ValueError):
    """A call of a function with a value that is missing, or that it does not take."""


class EmitError(SymdynError):
    """A target that cannot express what was asked."""


class BuildError(SymdynError):
    """A compiler that is missing or that refused; carries the compiler's own words."""


class MissingProgram(BuildError):  # noqa: N818  what is missing, not what went wrong
    """What would run the code is not on this machine."""


class MissingCompiler(MissingProgram):
    """There is no C compiler on this machine, or no folder that it may write to."""


class DrawError(SymdynError):
    """A picture that cannot be drawn."""


class VerifyError(SymdynError):
    """A certificate that cannot be made."""


class TeachError(SymdynError):
    """A lesson that cannot be made, or a student's text that cannot be read."""


class SimulateError(_FaultsError):
    """A motion, force, start, event or method that cannot be used; carries all faults, one line each."""


class MethodError(SimulateError):
    """An integrator that does not apply, wherever a run starts."""


class LinearizeError(_FaultsError):
    """A mechanism that cannot be linearised where it is asked for; carries all faults, one line each."""


class IdentifyError(_FaultsError):
    """Data from which parameters cannot be found as asked; carries all faults, one line each."""


class StudyError(SimulateError):
    """Workers, a scheduler or a store that cannot be used for a study; carries all faults, one line each."""
