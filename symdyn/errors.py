"""The errors that packages raise in common; the command line prints the text of every one and nothing else.

A message says where, what was found and what would work. It may quote a stranger's file, so it is made printable here,
at one place for all: a terminal that shows it obeys nothing that the file says.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from pathlib import Path


def printable(text: str, keep: str = "\n\t") -> str:
    r"""Return text whose control and direction characters are spelled, \x1b, but for those to keep.

    >>> printable("\x1b[2J\u202etxt.exe")
    '\\x1b[2J\\u202etxt.exe'
    """
    if text.isprintable():
        return text
    shown = {x for x in {*text} if x.isprintable() or x in keep or unicodedata.category(x) == "Zs"}
    return "".join(x if x in shown else x.encode("unicode_escape").decode("ascii") for x in text)


LONGEST_WORD = 240
"""Characters of a run of letters without a space that a message shows; of a longer one, its begin and its end."""

QUOTED = 60
"""Characters of a wrong value that a message quotes."""

_LONG = rf"\S{{{LONGEST_WORD + 1},}}"


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
    return re.sub(_LONG, lambda found: f"{found[0][:80]}...{found[0][-40:]}", text)


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

    def __reduce__(self) -> tuple[type[_FaultsError], tuple[Any, ...]]:
        """Return how to make it again in another process."""
        return type(self), (self.faults,)


class Place(NamedTuple):
    """Where something stands in a text: line and column of its first character, from 1, and how many they are."""

    line: int
    column: int
    length: int = 1


class SceneError(_FaultsError):
    """A scene that cannot be built; carries all of its faults, one line each.

    Attributes:
        places: where each fault stands in the text of a TOML file; empty for all else.
    """

    def __init__(self, faults: str | Sequence[str], places: Sequence[Place] = ()) -> None:
        super().__init__(faults)
        self.places = tuple(places)

    def __reduce__(self) -> tuple[type[_FaultsError], tuple[Any, ...]]:
        """Return how to make it again in another process."""
        return type(self), (self.faults, self.places)


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


# What was meant by a name that is not known

LONGEST_NAME = 60

MOST_KNOWN, MOST_COMPARED = 5000, 50
"""Known names that are looked at for one that a wrong one may have meant, and those that are compared with it."""

_RATE = r"(d{1,2})?_?(?P<of>.*?)_?(d{1,2}|p{1,2}|d?dot)?"
SECOND = ("dd", "pp", "ddot")
"""How others write rates, dtheta, theta_d or thetap, and which of these are of second order."""


def nearest(name: object, known: Iterable[str], scene: Any = None) -> str | None:
    """Return the known name that `name` was probably meant to be, or None; what is no text meant none.

    Of many names only those are compared that begin and end most like it; a name of a line's length is none. In a scene
    the name of a joint means its coordinate, or else its drive, and a rate of an output that of what it is.
    """
    if not isinstance(name, str) or len(name) > LONGEST_NAME:
        return None
    lowered = {candidate.lower(): candidate for candidate in known}
    for joint in (one for one in getattr(scene, "joints", ()) if one.name == name):
        for here in (one for one in (*joint.coordinates, *joint.drives) if one in lowered.values()):
            return str(here)
    for one in (one for one in getattr(scene, "outputs", ()) if name.startswith(f"{one.name}_")):
        if (here := f"{one.formula.value}{name.removeprefix(one.name)}") in lowered.values():
            return here
    meant, candidates = name.lower(), list(lowered)[:MOST_KNOWN]
    bare = meant.lstrip("-")
    words = [f"{meant.removesuffix(bare)}{one.lower()}" for one in hint("names", bare.replace("_", "-")).split()]
    for here in (*words, *(one for word in words for one in candidates if one.startswith(f"{word}_"))):
        if here in lowered:
            return lowered[here]
    rate = re.fullmatch(_RATE, meant)
    if rate and (here := f"{rate['of']}_{'d' * any(one in rate.groups() for one in SECOND)}dot") in lowered:
        return lowered[here]
    found = _likest(meant, candidates, 1, 0.6)
    return lowered[found[0]] if found else None


def beside(path: Path, otherwise: str = "check the path") -> str:
    """Return "did you mean X?" where a file that is not there has a name like one beside it, else what ends alike."""
    try:
        names = sorted(one.name for one in path.parent.iterdir() if one.is_file())
    except OSError:
        return otherwise
    near, ending = nearest(path.name, names) or "", path.suffix
    alike = [name for name in names if ending and name.endswith(ending)]
    numbered = near in alike and re.sub(r"\d", "", near) == re.sub(r"\d", "", path.name)  # m1.toml and m2.toml
    if near and (numbered or nearest(path.stem, [near.rpartition(".")[0]])):
        return f"did you mean {path.with_name(near)}?"
    return f"{otherwise}; there {'is' if len(alike) == 1 else 'are'} {listed(alike, 3)}" if alike else otherwise


def _likest(name: str, candidates: Sequence[str], most: int, cutoff: float = 0.0) -> list[str]:
    """Return the names that are most like one, the likest first."""
    from difflib import get_close_matches  # an error's own
    from heapq import nlargest

    if name.startswith("--"):  # what all options have in common says nothing
        bare = {one.lstrip("-"): one for one in candidates}
        return [bare[one] for one in _likest(name.lstrip("-"), [*bare], most, cutoff)]

    if len(candidates) > MOST_COMPARED:
        candidates = nlargest(MOST_COMPARED, candidates, key=lambda candidate: _in_common(name, candidate))
    return get_close_matches(name, candidates, most, cutoff)


def _in_common(a: str, b: str) -> int:
    """Return how many letters two names have in common at their beginnings and their ends."""
    differ = [x != y for x, y in zip(a, b, strict=False)]
    ahead = differ.index(True) if True in differ else len(differ)
    behind = [x != y for x, y in zip(a[ahead:][::-1], b[ahead:][::-1], strict=False)]
    return ahead + (behind.index(True) if True in behind else len(behind))


MOST_LISTED, ALIKE = 12, 0.4
"""Names that a message lists, and how like a wrong one those are that come before the others."""


def listed(names: Iterable[str], most: int = MOST_LISTED) -> str:
    """Return names as text for a message, shortened when there are many."""
    every = list(names)
    return ", ".join(every[:most] or ["none"]) + (f", ... ({len(every)} in all)" if len(every) > most else "")


_NUMBERS = r"\d[\d.e+-]*"
_MORE = r" \(and (\d+) alike\)$"


def alike(notes: Iterable[str]) -> tuple[str, ...]:
    """Return notes, of those that differ in numbers alone the first, and how many more there are.

    >>> alike(["ended at 0.1 s", "a", "ended at 0.25 s", "ended at 0.3 s (and 4 alike)"])
    ('ended at 0.1 s (and 6 alike)', 'a')
    """
    firsts, counts = dict[str, str](), dict[str, int]()
    for note in dict.fromkeys(notes):
        more = re.search(_MORE, note)
        plain = note[: more.start()] if more else note
        kind = re.sub(_NUMBERS, "#", plain)
        firsts.setdefault(kind, plain)
        counts[kind] = counts.get(kind, -1) + 1 + (int(more[1]) if more else 0)
    return tuple(f"{note} (and {counts[kind]} alike)" * (counts[kind] > 0) or note for kind, note in firsts.items())


@cache
def hints() -> Any:
    """Return what to write in place of what is not there, by its names, `$` for the one that was written; for errors.

    Attributes ([] are brackets), options and keys stand behind what the noun, the verb has too, or the section; with
    keywords and arguments stands another one of the function, or its name. Names are words of other tools and books; of
    several that they stand for the first that something has is meant.
    """
    import json
    from pathlib import Path

    return json.loads(Path(__file__).with_name("hints.json").read_text(encoding="utf-8"))


def hint(kind: str, name: str, known: Iterable[str] = ()) -> Any:
    """Return the hint of a name, of an attribute or an option beside one of the known, "" where there is none."""
    rows = hints()[kind]
    groups = [rows[has] for has in rows if has in known] if kind in ("attributes", "options", "keys") else [rows]
    fits = (told for group in groups for names, told in group.items() if name in names.split())
    return next((told for told in fits if kind != "keywords" or told[0] in known), "")


def names_of(noun: object, kind: str) -> list[str]:
    """Return the names of what a noun, or its scene, has several of, such as outputs, or one of, such as an output."""
    nouns = (noun, getattr(noun, "scene", None) if "scene" in dir(noun) else None)
    for one, has in ((one, has) for one in nouns for has in (kind, kind[:-1]) if has in dir(one)):
        some = getattr(getattr(one, has), "names", getattr(one, has))
        every = [some] if isinstance(some, str) else some if isinstance(some, Iterable) else ()
        names = (getattr(each, "name", each) for each in every)
        if found := [each for each in names if each and isinstance(each, str)]:
            return found
    return []


HELD = {"values": "parameters", "over": "parameters", "start": "coordinates", "forces": "drives"}
"""Arguments that take values by name, and what a scene has of these names."""

OWN = {"OUTPUT": "outputs", "INPUT": "inputs", "NAME": "parameters", "COORDINATE": "coordinates", "DRIVE": "drives",
       "MEASURE": "measures", "SYMBOL": "point"}  # fmt: skip
"""What stands in hints for a name that the user has."""


def with_own_names(told: str, noun: object) -> str:
    """Return a hint with names of what is held in the places of these; where it has none, the place stays."""
    return re.sub("|".join(OWN), lambda word: (names_of(noun, OWN[word[0]]) or [word[0]])[0], told)


def suggestion(name: object, known: Iterable[str], scene: Any = None) -> str:
    """Return "did you mean X?" when something known is near, else the known names, of many the likest first."""
    every = list(dict.fromkeys(known))
    near = nearest(name, every, scene)
    if not near and isinstance(name, str) and MOST_LISTED < len(every) <= MOST_KNOWN and len(name) <= LONGEST_NAME:
        first = _likest(name, every, MOST_LISTED, ALIKE)
        every = [*first, *(one for one in every if one not in first)]
    return f"did you mean {near}?" if near else f"known are {listed(every)}"


def choice(name: object, known: Iterable[str], scene: Any = None) -> str:
    """Return all known names, of which a user chooses one, and "did you mean X?" when one of them is near."""
    every = list(known)
    near, all_of_them = nearest(name, every, scene), f"there are {', '.join(every) or 'none'}"
    return f"did you mean {near}? ({all_of_them})" if near else all_of_them
