"""How every verb reads its scene: the options that say how, and the notes of the reader on stderr."""

from __future__ import annotations

import argparse
import shlex
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from symdyn.errors import printable

if TYPE_CHECKING:
    from symdyn.dynamics import LoopChoices
    from symdyn.scene import Scene

MOST_NOTES = 20


def add_reading_options(verb: argparse.ArgumentParser, optional: bool = False) -> None:
    """Add the scene, which may be left out where it is optional, and the options that say how to read it."""
    files = "scene or robot file: .toml, .urdf, .mjcf, .xml or .par"
    verb.add_argument("scene", metavar="SCENE", nargs="?" if optional else None, help=files)
    group = verb.add_argument_group("reading")
    group.add_argument(
        "--symbolic",
        choices=("inertia", "geometry", "all"),
        help="named parameters in place of numbers, with those numbers as values",
    )
    group.add_argument(
        "--no-snap",
        dest="snap",
        action="store_false",
        help="keep 1.5707963 as it is; without this, decimals that are a multiple of pi at their own digits become one",
    )
    group.add_argument(
        "--allow-invalid-inertia", action="store_true", help="accept inertias that no body has, with a note for each"
    )
    group.add_argument(
        "--spanning-tree", metavar="LIST", help="joints to cut where joints close loops, e.g. elbow,slider"
    )
    group.add_argument(
        "--floating-base",
        metavar="NAME",
        help="a free joint NAME between the ground and the root link of a robot in URDF or MJCF; without this, the "
        "root is the ground",
    )
    group.add_argument(
        "--bind", metavar="LIST", help="values for parameters, e.g. m1=2.5,h1=1/2; what is zero drops out"
    )


def add_formulation(verb: argparse.ArgumentParser) -> None:
    """Add the choice of the derivation that becomes code."""
    verb.add_argument(
        "--formulation",
        choices=("rnea", "crba", "aba", "lagrange"),
        help="take this derivation where a function has it; without this, the one with the fewest operations",
    )


def add_prepare(verb: argparse.ArgumentParser) -> None:
    """Add the choice to take work on parameters alone out of the calls."""
    verb.add_argument(
        "--prepare",
        action="store_true",
        help="a function prepare(params) does the work on free parameters alone; its result is the last argument of "
        "all others, in place of params",
    )


def add_closing(verb: argparse.ArgumentParser) -> None:
    """Add what can be chosen about closed loops."""
    group = verb.add_argument_group("closed loops")
    group.add_argument(
        "--independent",
        metavar="LIST",
        help="coordinates that determine the others, e.g. phi,psi; without this, those with the best conditioning",
    )
    group.add_argument(
        "--baumgarte",
        metavar="ALPHA,BETA",
        help="stabilise forward dynamics: G qdd = -Gdot qd - 2 ALPHA G qd - BETA^2 r, in 1/s; without this, exact",
    )


def closing_of(options: argparse.Namespace, scene: Scene) -> LoopChoices:
    """Return what the options choose about the loops of a scene.

    Raises:
        DerivationError: a choice that means nothing, or a scene without loops and rows.
    """
    from symdyn.dynamics import LoopChoices
    from symdyn.errors import DerivationError

    given = [f"--{name}" for name in ("independent", "baumgarte") if getattr(options, name) is not None]
    if given and not scene.is_closed:
        raise DerivationError(
            f"{scene.name}: {' and '.join(given)}: it has no loops and no rows, all its coordinates are independent; "
            f"leave {' and '.join(given)} out"
        )
    names = tuple(name.strip() for name in (options.independent or "").split(",") if name.strip())
    if options.independent is not None and not names:
        raise DerivationError("--independent: no name is given; write --independent phi,psi")
    alpha, beta = (Fraction(0), Fraction(0)) if options.baumgarte is None else _rates(options.baumgarte)
    return LoopChoices(names, alpha, beta)


def _rates(text: str) -> tuple[Fraction, Fraction]:
    """Return alpha and beta."""
    from symdyn.errors import DerivationError

    try:
        alpha, beta = (Fraction(part.strip()) for part in text.split(","))
    except (ValueError, ZeroDivisionError) as fault:
        raise DerivationError(
            f"--baumgarte {text}: these are no two numbers; write ALPHA,BETA in 1/s, as in --baumgarte 5,5"
        ) from fault
    if min(alpha, beta) < 0:
        raise DerivationError(
            f"--baumgarte {text}: a negative rate drives the loops apart; give numbers that are zero or positive"
        )
    return alpha, beta


def closing_words(options: argparse.Namespace) -> list[str]:
    """Return the words of a command that choose the same."""
    words = ["--independent", options.independent.replace(" ", "")] if options.independent else []
    return words + (["--baumgarte", options.baumgarte.replace(" ", "")] if options.baumgarte else [])


def read_scene(options: argparse.Namespace) -> Scene:
    """Return the scene that the options name; what the reader notes goes to stderr."""
    from symdyn.cli.talk import say
    from symdyn.scene import ReadOptions, bind, read_bindings, read_noting, with_symbols

    cuts = options.spanning_tree and tuple(name.strip() for name in options.spanning_tree.split(","))
    how = ReadOptions(options.snap, options.allow_invalid_inertia, cuts, options.floating_base)
    reading = read_noting(options.scene, how)
    for note in reading.notes[:MOST_NOTES]:
        say(f"symdyn: {note}")
    if len(reading.notes) > MOST_NOTES:
        say(f"symdyn: {options.scene}: and {len(reading.notes) - MOST_NOTES} notes more")
    scene = with_symbols(reading.scene, options.symbolic) if options.symbolic else reading.scene
    return bind(scene, read_bindings(options.bind)) if options.bind is not None else scene


def read_scene_to_move(options: argparse.Namespace) -> Scene:
    """Return the scene that the options name, for what is compiled with its parameters free: those bound are numbers.

    What the reader notes goes to stderr.
    """
    from symdyn.scene import in_numbers, read_bindings

    scene = read_scene(options)
    return in_numbers(scene, read_bindings(options.bind)) if options.bind is not None else scene


def reading_words(options: argparse.Namespace) -> list[str]:
    """Return the words of a command that read the same scene in the same way, free of folders.

    They stand in files that are written, so that a file's name may be no more than a word of a shell, in one line.
    """
    words = [shlex.quote(printable(Path(options.scene).name, keep=""))]
    words += ["--symbolic", options.symbolic] if options.symbolic else []
    words += ["--no-snap"] if not options.snap else []
    words += ["--allow-invalid-inertia"] if options.allow_invalid_inertia else []
    words += ["--spanning-tree", shlex.quote(options.spanning_tree.replace(" ", ""))] if options.spanning_tree else []
    words += ["--floating-base", shlex.quote(options.floating_base)] if options.floating_base else []
    words += ["--bind", shlex.quote(options.bind.replace(" ", ""))] if options.bind else []
    return words
