"""How every verb reads its scene: the options that say how, and the notes of the reader on stderr."""

from __future__ import annotations

import argparse
import re
import shlex
import sys
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from symdyn.cli.talk import say
from symdyn.errors import DerivationError, SceneError, listed, printable
from symdyn.scene import Scene, SceneUnits, bind, parse, read_noting, with_symbols
from symdyn.scene.values import Faults, FormulaError, Parameter, split_commas

if TYPE_CHECKING:
    from symdyn.dynamics import LoopChoices

MOST_NOTES = 20

STDIN = "-"
"""The scene that is standard input."""

BY_VALUES = {"bench": (), "draw": (), "inverse": (), "simulate": ("stop", "report"), "stress": ()}
"""Verbs that take parameters by their values alone, and their options that read names."""


def closing_of(options: argparse.Namespace, scene: Scene) -> LoopChoices:
    """Return what the options choose about the loops of a scene.

    Raises:
        DerivationError: a choice that means nothing, or a scene without loops and rows.
    """
    given = [f"--{name}" for name in ("independent", "baumgarte") if getattr(options, name) is not None]
    if given and not scene.is_constrained:
        raise DerivationError(
            f"{scene.name}: {' and '.join(given)}: it has no loops and no rows, all its coordinates are independent; "
            f"leave {' and '.join(given)} out"
        )
    names = split(options.independent) or ()
    if options.independent is not None and not names:
        raise DerivationError("--independent: no name is given; write --independent phi,psi")
    alpha, beta = (Fraction(0), Fraction(0)) if options.baumgarte is None else _rates(options.baumgarte)
    from symdyn.dynamics import LoopChoices

    return LoopChoices(names, alpha, beta)


def _rates(text: str) -> tuple[Fraction, Fraction]:
    try:
        alpha, beta = (Fraction(part.strip()) for part in split_commas(text))
    except (ValueError, ZeroDivisionError) as fault:
        raise DerivationError(
            f"--baumgarte {text}: these are no two numbers; write ALPHA,BETA in 1/s, as in --baumgarte 5,5"
        ) from fault
    if min(alpha, beta) < 0:
        raise DerivationError(
            f"--baumgarte {text}: a negative rate drives the loops apart; give numbers that are zero or positive"
        )
    return alpha, beta


class StandardInput:
    """What is piped in, as an open file."""

    name = "stdin"

    def read(self, size: int, /) -> bytes | str:
        """Return at most so many bytes; SceneError where there is none."""
        content: bytes | str = getattr(sys.stdin, "buffer", sys.stdin).read(size)
        if not content:
            raise SceneError(f"{self.name}: is empty; pipe a scene in, as in `cat arm.toml | symdyn info -`")
        return content


def read_scene(options: argparse.Namespace) -> Scene:
    """Return the scene that the options name; what the reader notes goes to stderr."""
    scene, notes = scene_and_notes(options)
    for note in notes:
        say(note)
    if options.verb in BY_VALUES and not any(getattr(options, name) for name in BY_VALUES[options.verb]):
        say_values_alone(options, scene, options.verb)
    if options.verb == "equations" and any(one.ends for one in scene.struts):
        from symdyn.simulation import Forces, valueless  # of few scenes

        if not (scene.loops or scene.free_parameters) and (told := valueless(scene, Forces())):
            say(f"{scene.name}: at the start {told}")
    opening = [one.name for one in scene.unilaterals]
    opening += [f"stops of {one.name}" for one in scene.joints if one.limits.restitution is not None]
    opening += [f"freewheel of {one.name}" for one in scene.joints if one.limits.one_way]
    if opening and options.verb in OPEN and getattr(options, "formulation", "") != "contact":
        say(f"{scene.name}: all contacts open: {listed(opening)}; runs, sensitivity, gait and masks close them")
    return scene


OPEN = ("equations", "info", "generate", "verify", "bench", "stress", "check-derivation")
"""Verbs whose functions are those of contacts that are open, but for what is asked of contacts by name."""


def say_values_alone(options: argparse.Namespace, scene: Scene, who: str) -> None:
    """Say that --symbolic, where it is given, changes nothing of what somebody does who takes values of parameters."""
    if options.symbolic:
        say(
            f"{scene.name}: --symbolic {options.symbolic}: changes nothing here, since the names have the values that "
            f"the numbers had, and {who} takes those; info and equations show the names, and they stay parameters in "
            "generate --target fmu"
        )


def scene_and_notes(options: argparse.Namespace) -> tuple[Scene, list[str]]:
    """Return the scene that the options name, and what its reader notes."""
    cuts = options.spanning_tree and split_commas(options.spanning_tree)
    path = Path(options.scene)
    reading = read_noting(
        StandardInput() if options.scene == STDIN else path, options.snap, options.allow_invalid_inertia, cuts,
        options.floating_base, options.no_units,
    )  # fmt: skip
    told = [one for one in reading.notes if options.verb == "info" or not one.endswith(reading.UNUSED)]
    whole, name = (printable(str(one), keep="") for one in (path, path.name))
    notes = [one.replace(whole, name, 1) if one.startswith(whole) else one for one in told[:MOST_NOTES]]
    if len(told) > MOST_NOTES:
        notes.append(f"{name}: and {len(told) - MOST_NOTES} notes more")
    scene = with_symbols(reading.scene, options.symbolic) if options.symbolic else reading.scene
    if options.bind is None:
        return scene, notes
    given = read_bindings(options.bind)
    if over := getattr(options, "over", None):
        from symdyn.study import check_unbound

        check_unbound(over, given, faults := Faults(""))
        faults.close(SceneError)
    return bind(scene, given), notes


def read_bindings(
    text: str, option: str = "--bind", what: str = "parameter", write: str = "m1=2.5,h1=1"
) -> dict[str, str]:
    """Return name and formula of every part of `m1=2.5, h1=1/2`; all but `text` is for messages.

    Raises:
        SceneError: a part that is no name = value, a name that comes twice, or a value that is no formula.
    """
    values: dict[str, str] = {}
    for part in split_commas(text) or [""]:
        name, equals, value = (piece.strip() for piece in part.partition("="))
        if not name or not equals or not value:
            raise SceneError(f'{option}: "{part.strip()}" gives no {what} a value; write {write}')
        if name in values:
            raise SceneError(f"{option}: {name} gets two values, {values[name]} and {value}; give one of them")
        try:
            parse(value)
        except FormulaError as fault:
            raise SceneError(f"{option}: {name}: {fault}") from None
        values[name] = value
    return values


def read_numbers(text: str, scene: Scene | None = None) -> dict[str, float]:
    """Return name and value of every part of `q1=0.3, q2=90 deg` of --at; with a scene, in units that fit its names.

    Raises:
        SceneError: a part that is no name = number, or a name that comes twice.
    """
    from symdyn.simulation.prescribed import read_number  # of few verbs

    letter, faults = Parameter if scene is None else SceneUnits(scene).letter, Faults("--at")
    given = read_bindings(text, "--at", "coordinate", "--at q1=0.3,q2=1")
    values = {name: read_number(x, {}, name, faults, letter(name)) or 0.0 for name, x in given.items()}
    faults.close()
    return values


def read_scene_to_move(options: argparse.Namespace) -> Scene:
    """Return the scene that the options name, for what takes its parameters by name: those bound are numbers.

    What the reader notes goes to stderr.
    """
    scene = read_scene(options)
    return scene.in_numbers([*read_bindings(options.bind)]) if options.bind is not None else scene


_SPARE = r"(?<!\w) +| +(?!\w)"
"""Spaces that a list does not need; the one of "3 kg m^2" it needs."""


def again(options: argparse.Namespace, always: str = "") -> str:
    """Return the command that does the same again, free of folders: what is not as usual, and what is told `always`.

    It stands in files that are written, so that a file's name may be no more than a word of a shell, in one line.
    """
    words = ["symdyn", options.verb]
    for action in options.parser._actions:
        value = getattr(options, action.dest, None)
        if value in (None, "") or action.dest in ("json", "quiet", "output"):
            continue
        if not action.option_strings:
            given = value if isinstance(value, list) else [value]
            words += [shlex.quote(printable(Path(one).name, keep="")) for one in given]
        elif action.nargs == 0 and value == action.const != action.default:
            words.append(action.option_strings[0])
        elif action.nargs != 0 and (value != action.default or action.dest == always):
            repeated = isinstance(action, argparse._AppendAction) and isinstance(value, list)
            for one in value if repeated else [value]:
                several = one if isinstance(one, list) else [one]
                words += [action.option_strings[0], *(shlex.quote(re.sub(_SPARE, "", str(each))) for each in several)]
    return " ".join(words)


def split(names: str | None) -> tuple[str, ...] | None:
    """Return the names of a comma-separated list, each once; None for no list."""
    return None if names is None else tuple(dict.fromkeys(filter(None, split_commas(names))))


def functions_of(options: argparse.Namespace, scene: Scene) -> tuple[str, ...] | None:
    """Return the requests of `--functions`, each once, whichever of its names it is asked for by; None without."""
    from symdyn.dynamics import request_of

    names = split(options.functions)
    return None if names is None else tuple(dict.fromkeys(request_of(name, scene) for name in names))
