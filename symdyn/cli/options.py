"""What a verb takes, from the table `options.json`, so that help and messages about usage import nothing else.

`make golden` writes the table from `verbs.toml` and from signatures and docstrings of the functions behind the verbs.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from typing import Any

from symdyn.errors import spoken
from symdyn.rounding import DIGITS


def seconds(text: str) -> float:
    """Return a time in seconds.

    >>> seconds("0.5"), seconds("100 ms"), seconds("1 min")
    (0.5, 0.1, 60.0)

    Raises:
        argparse.ArgumentTypeError: it is no number, or one in a unit that is none of time.
    """
    try:
        return float(text)
    except ValueError:
        pass
    from symdyn.scene import parse
    from symdyn.scene.values import FormulaError, Unit, fits

    try:
        formula = parse(text)
        fits(formula, Unit.read("s"))
        value = formula.at({})
    except FormulaError as error:
        reason = f"{text} {error}" if str(error).startswith(("is ", "divides ")) else str(error)
        raise argparse.ArgumentTypeError(f"{reason}; give seconds, as 0.5, or a unit too, as 500ms") from None
    if value is None:
        raise argparse.ArgumentTypeError(f"{text} is no number; give seconds, as 0.5, or a unit too, as 500ms")
    return float(value)


def _digits(text: str) -> int:
    if text.lstrip("0") in DIGITS:
        return DIGITS[text.lstrip("0")]
    raise argparse.ArgumentTypeError(f"{text} is no number of digits; give 1 to {max(DIGITS.values())}, or all")


TYPES: dict[str, Callable[[str], Any]] = {"int": int, "float": float, "seconds": seconds, "digits": _digits}
"""What reads a value; others are functions of a verb's file, such as "generate.target_name"."""


PYTHON = {
    **{"values": "bind", "parameters": "bind", "payloads": "payload", "what": "as", "target": "what"},
    **{"stops": "stop", "reports": "report"},
}
"""Options that arguments of Python are at a verb that has none of the same name."""


def flag(options: Mapping[str, argparse.Action], name: str, value: object = None) -> str:
    """Return what an argument of Python is among the options of a verb.

    >>> flag({}, "every", 0.1), flag({}, "ignore_limits", True), flag({}, "start", {"q1": 0, "q2": 1})
    ('--every 0.1', '--ignore-limits', '--start q1=0,q2=1')
    """
    from shlex import quote  # help needs none

    same = f"--{name.replace('_', '-')}"
    option = f"--{PYTHON[name]}" if name in PYTHON and same not in options else same
    if value is None or value is True:
        return option
    every = value if isinstance(value, tuple | list) else [value]
    words = [f"{name}={one}" for name, one in value.items()] if isinstance(value, Mapping) else map(spoken, every)
    apart = option in options and options[option].nargs in ("+", "*")
    said = (" " if apart else ",").join(word if set(word).isdisjoint(" ();&") else quote(word) for word in words)
    return f"{option} {said}"


class OpenChoices(tuple[Any, ...]):
    """Choices that help and shells tell; what reads the value knows which there are."""

    def __contains__(self, value: object) -> bool:
        return True


@cache
def groups() -> dict[str, dict[str, Any]]:
    """Return the options of every verb, and groups of them, by name."""
    table: dict[str, dict[str, Any]] = json.loads(Path(__file__).with_name("options.json").read_bytes())
    return table


def add_options(verb: argparse.ArgumentParser, name: str) -> None:
    """Add what the verb of this name takes, and what it does."""
    verb.description = groups()[name]["description"]
    _add(verb, groups()[name]["options"])


def _add(container: argparse._ActionsContainer, entries: Sequence[Any]) -> None:
    """Add options, each its flags and further arguments of `add_argument`, and groups by their names."""
    for entry in entries:
        if isinstance(entry, str):
            group, inside = groups()[entry], container
            if "title" in group:
                inside = container.add_argument_group(group["title"])
            elif "exclusive" in group:
                inside = container.add_mutually_exclusive_group()
            _add(inside, group["options"])
        else:
            flags, words = entry
            container.add_argument(*flags, **_read(words))


def _read(words: dict[str, Any]) -> dict[str, Any]:
    """Return arguments of `add_argument` with what reads a value in place of its name."""
    name = words.get("type")
    if name is None or name in TYPES:
        return words if name is None else {**words, "type": TYPES[name]}
    choices = OpenChoices(words["choices"]) if "choices" in words else None
    return {**words, "type": str if name == "text" else partial(_read_late, name), "choices": choices}


def _read_late(name: str, text: str) -> Any:
    """Return a value by a function of a verb's file, which is imported then."""
    verb, _, function = name.partition(".")
    return getattr(import_module(f"symdyn.cli.{verb}"), function)(text)
