"""`symdyn identify SCENE DATA.csv`: base parameters from measured motion and forces, with standard errors.

What `symdyn identify -o` writes: a page, the identified scene, a table of parameters; the ending says which.

`symdyn identify --by output-error`: parameters with which simulated runs are closest to measured ones.

`symdyn identify --excite`: a motion to be measured.

`--payload FILE:BODY:mass=KG`: bodies of known mass that some logs were measured with.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from symdyn.cli.scene_options import again, read_scene, say_values_alone
from symdyn.cli.talk import Bar, Waiting, answer, give, print_table, print_text, say, wrote
from symdyn.cli.trajectory_options import flattened, pairs, write_table
from symdyn.emit import write_file
from symdyn.errors import IdentifyError, SimulateError, choice
from symdyn.frozen import dataclass
from symdyn.identification import Identification, Outcome, Payload, excite, identify
from symdyn.rounding import finite, in_digits
from symdyn.scene import Scene, parse
from symdyn.scene.values import FormulaError, Unit, UnitError, fits, split_commas
from symdyn.simulation import CHECKS
from symdyn.table import Table


@dataclass(frozen=True)
class FileKind:
    """A kind of file."""

    contents: Callable[[Outcome], str]  # what stands in it
    scene: bool = False  # whether it is a scene, which nobody wants to overwrite unawares


def _page(outcome: Outcome) -> str:
    text, why = outcome.page()
    if why:
        say(f"symdyn: the page has no identified scene: {why}")
    return text


def _scene(outcome: Outcome, format: str) -> str:
    text = outcome.text(format)
    for line in text.lost:
        say(f"symdyn: left out: {line}")
    return text.text


def _table(outcome: Outcome) -> str:
    found = outcome.identification
    numbers = np.column_stack([found.before, found.after, found.errors, found.interval()])
    heads = ("parameter", "before", "after", "standard error", "from", "to")
    return Table(heads, [(name, *row) for name, row in zip(found.names, numbers.tolist(), strict=True)]).csv()


FILES = {
    ".html": FileKind(_page),
    ".toml": FileKind(partial(_scene, format="toml"), True),
    ".urdf": FileKind(partial(_scene, format="urdf"), True),
    ".csv": FileKind(_table),
}
"""By ending."""

MADE = frozenset((".html", ".toml", ".urdf"))
"""Endings of files that tell of the identified scene."""


def check_files(options: argparse.Namespace, endings: Sequence[str] = ()) -> None:
    """Raise before the work begins what could not be written after it.

    Raises:
        IdentifyError: an ending that is none of these, a scene that exists, a total mass that is none.
    """
    faults = []
    for name in options.output:
        path = Path(name)
        kind = FILES.get(path.suffix.lower())
        if kind is None or path.suffix.lower() not in (endings or FILES):
            faults.append(f"{path}: -o writes {', '.join(endings or FILES)} files")
        elif kind.scene and path.exists() and not options.force:
            faults.append(f"{path} exists; give another name, or --force to overwrite it")
    total = getattr(options, "total_mass", None)
    if total is not None and not 0 < options.total_mass < float("inf"):
        faults.append(f"--total-mass: {total:g} is no mass; give one above zero, kg")
    if total is not None and not {Path(name).suffix.lower() for name in options.output} & MADE:
        faults.append("--total-mass: is of the identified scene; give a file for it, such as -o identified.toml")
    if faults:
        raise IdentifyError(faults)


def write_files(identification: Identification, outputs: Sequence[str], total_mass: float | None, command: str) -> None:
    """Write what `-o` asks for, all of it or nothing, and say where."""
    asked = Outcome(identification, total_mass, command)
    paths = [Path(name) for name in outputs]
    contents = [FILES[path.suffix.lower()].contents(asked) for path in paths]
    if any(FILES[path.suffix.lower()].scene for path in paths):
        for note in asked.made.notes:
            say(f"symdyn: {note}")
    for path, text in zip(paths, contents, strict=True):
        write_file(path, text)
    wrote(*paths)


OUTPUT_ERROR = "output-error"

RUNS = ("parameters", "start")
"""Options that are of output error alone."""


def run_output_error(scene: Scene, options: argparse.Namespace) -> int:
    """Fit runs, print; IdentifyError of what the data do not tell."""
    from symdyn.identification import output_error

    names = [name for part in split_commas(options.parameters or "") if (name := part.strip())]
    with Waiting("fitting runs"):
        found = output_error(scene, options.data, names or None, start=pairs(options.start, "--start") or None, say=say)
    for note in found.notes:
        say(note)
    if options.json:
        keys = ("name", "unit", "before", "after", "standard_error")
        numbers = (one.tolist() for one in (found.before, found.estimate, found.standard_errors))
        rows = zip(found.names, found.units, *numbers, strict=True)
        give(
            finite({"estimates": [dict(zip(keys, row, strict=True)) for row in rows], "degrees_of_freedom": found.dof})
        )
        return 0
    print_table(found.table())
    return 0


FORM = "FILE:BODY:mass=KG[,com=[X,Y,Z][,inertia=[XX,YY,ZZ]]]"

KEYS = {"mass": "kg", "com": "m", "inertia": "kg m^2"}
"""What is said of one, and its unit where none is said."""


def payloads(texts: Sequence[str]) -> tuple[Payload, ...]:
    """Return what `--payload` says, once for each payload.

    >>> payloads(["loaded.csv:tool:mass=3.2,com=[0,0,0.1]"])
    (Payload(body='tool', mass=3.2, com=(0.0, 0.0, 0.1), inertia=None, log='loaded.csv'),)
    >>> payloads(["loaded.csv:tool:mass=3200 g,com=[0,0,100 mm]"])[0].com
    (0.0, 0.0, 0.1)

    Raises:
        IdentifyError: with every fault, one line each.
    """
    faults, found = list[str](), list[Payload]()
    for text in texts:
        log, *rest = text.rsplit(":", 2)
        if len(rest) < 2 or not log or not rest[0]:
            faults.append(f"--payload: {text} is not of the form {FORM}")
            continue
        given = dict[str, tuple[float, ...]]()
        before = len(faults)
        for part in split_commas(rest[1]):
            key, _, value = (one.strip() for one in part.partition("="))
            if key not in KEYS:
                faults.append(f"--payload {text}: there is no {key}; {choice(key, KEYS)}")
                continue
            try:
                numbers = _numbers(value, KEYS[key])
            except UnitError as error:
                faults.append(f"--payload {text}: {key} = {value} {error}")
                continue
            if key in given:
                faults.append(f"--payload {text}: {key} is there twice")
            elif numbers is None or (key == "mass") is value.startswith("["):
                shown = "3.2" if key == "mass" else "[0,0,0.1]"
                faults.append(f"--payload {text}: {key} = {value}: give {'a number' if key == 'mass' else 'numbers'}, "
                              f"such as {key}={shown}")  # fmt: skip
            else:
                given[key] = numbers
        if "mass" not in given and len(faults) == before:
            faults.append(f"--payload {text}: without a mass it has no known size; give it, kg, as in mass=3.2")
        if len(faults) == before:
            found.append(Payload(rest[0], given["mass"][0], given.get("com"), given.get("inertia"), log))
    if faults:
        raise IdentifyError(faults)
    return tuple(found)


def _numbers(text: str, unit: str) -> tuple[float, ...] | None:
    """Return a number, or several in brackets, in a unit of SI; None where it is none.

    Raises:
        UnitError: one says a unit of another kind.
    """
    inside = split_commas(text[1:-1]) if text.startswith("[") and text.endswith("]") else [text]
    try:
        quantities = [parse(one) for one in inside]
        for one in quantities:
            fits(one, Unit.read(unit))
        values = [one.at({}) for one in quantities]
    except UnitError:
        raise
    except FormulaError:
        return None
    known = [float(one) for one in values if one is not None]
    return tuple(known) if len(known) == len(values) else None


def run_exciting(options: argparse.Namespace) -> int:
    """Find the motion, tell of it, write it."""
    if options.data:
        raise IdentifyError(f"--excite finds a motion to be measured; {options.data[0]} would be the log of one")
    try:
        for name in options.output:
            CHECKS["table"](Path(name))
        if options.plot:
            CHECKS["plot"](Path(options.plot))
    except SimulateError as fault:
        raise IdentifyError(fault.faults) from None
    scene = read_scene(options)
    say_values_alone(options, scene, "--excite")
    chosen: dict[str, Any] = {name: one for name in CHOSEN if (one := getattr(options, name)) is not None}
    with Bar(f"exciting {scene.name}") as progress:
        found = excite(
            scene,
            **chosen,
            box=flattened(options.box),
            noise=_noise(options.noise),
            progress=progress,
            say=lambda line: say(f"symdyn: {line}"),
        )
    for name in options.output:
        write_table(found.run, Path(name))
        wrote(name)
    if options.plot:
        found.run.save_plot(options.plot)
        wrote(options.plot)
    if options.json:
        columns = dict(zip(found.names, found.run.table()[1].T.tolist(), strict=True))
        give(found.as_json() | ({} if options.output else {"columns": columns}))
    elif options.output:
        print_text("\n".join(found.lines()))
    else:
        for line in found.lines():
            say(line)
        sys.stdout.write(found.to_csv())
    return 0


def _noise(text: str | None) -> dict[str, float]:
    """Return the standard deviations of `tau1=0.5,tau2=0.2`."""
    found, faults = {}, []
    for name, number in pairs(text, "--noise").items():
        try:
            found[name] = float(number)
        except ValueError:
            faults.append(f"--noise: {name}={number} is no number; give N m or N, such as tau1=0.5")
    if faults:
        raise IdentifyError(faults)
    return found


EXCITE, REGRESSION = "--excite", "--by regression"

CHOSEN = ("period", "family", "terms", "criterion", "starts", "seed", "every")

EXCITING = (*CHOSEN, "box", "noise", "plot")
"""Options that are of exciting motions alone."""

WAYS = {
    REGRESSION: ("band", "friction", "hold_back", "units", "payload", "keep_outliers", "output", "total_mass", "force"),
    f"--by {OUTPUT_ERROR}": RUNS,
    EXCITE: (*EXCITING, "output"),
}
"""What the verb can do, and the options that are of it; one that would do nothing is refused."""


def run(options: argparse.Namespace) -> int:
    """Identify, print, write."""
    way = EXCITE if options.excite else f"--by {options.by}"
    _check_way(options, way)
    if options.excite:
        return run_exciting(options)
    scene = read_scene(options)
    if not options.data:
        raise IdentifyError(
            f"{scene.name}: no data; give a CSV file, as in `symdyn identify {options.scene} log.csv`, with the "
            "columns t, coordinates and driving forces"
        )
    if options.by == OUTPUT_ERROR:
        return run_output_error(scene, options)
    if not options.output:
        say_values_alone(options, scene, "identify without -o")
    check_files(options)
    carried = payloads(options.payload)
    terms = [one.strip() for one in split_commas(options.friction or "")]
    with Waiting("identifying"):
        found = identify(
            scene,
            options.data,
            options.band,
            Identification.friction_terms if terms == ["all"] else [one for one in terms if one],
            options.hold_back or 0.0,
            not options.keep_outliers,
            pairs(options.units, "--units"),
            payloads=carried,
        )
    for note in found.notes:
        say(note)
    write_files(found, options.output, options.total_mass, again(options))
    answer(finite(found.as_dict()), lambda: show(found))
    return 0


def _check_way(options: argparse.Namespace, way: str) -> None:
    """Raise IdentifyError for options of another way."""
    faults = []
    if options.excite and options.by == OUTPUT_ERROR:
        faults.append(f"--by {OUTPUT_ERROR}: {EXCITE} fits nothing; leave one of the two out")
    for other, names in WAYS.items():
        for name in names:
            value = getattr(options, name)
            if name not in WAYS[way] and not (value is None or value is False or value == []):
                option = "-o" if name == "output" else f"--{name.replace('_', '-')}"
                faults.append(f"{option}: of {other}, which is not given")
    if faults:
        raise IdentifyError(list(dict.fromkeys(faults)))


def show(identification: Identification) -> None:
    """Print the tables."""
    for table in identification.tables:
        print_table(table)
    regression = identification.regression
    print_text(
        f"condition number {in_digits(regression.condition, 3)}, band {in_digits(identification.band, 3)} Hz, "
        f"{len(regression.tau)} rows, {regression.dof} degrees of freedom"
    )
