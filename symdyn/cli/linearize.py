"""`symdyn linearize SCENE`: A, B, C, D about an equilibrium, a steady motion or along a run; modes and stability."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Callable, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from symdyn.cli.scene_options import read_scene_to_move, split
from symdyn.cli.talk import Waiting, answer, give, print_paths, print_text, say
from symdyn.cli.trajectory_options import collected, flattened, pairs, reel
from symdyn.draw import Reel
from symdyn.emit import Contents, check_folder, write_file
from symdyn.errors import LinearizeError, SimulateError, choice
from symdyn.frozen import dataclass, replace
from symdyn.linear import StateSpace, System, SystemsFile, locus_over, poles_in_words
from symdyn.rounding import in_digits
from symdyn.scene import Scene
from symdyn.scene.values import Faults, split_commas
from symdyn.simulation import CHECKS, Problem

Lines: TypeAlias = list[str]
Data: TypeAlias = dict[str, Any]

PICTURES = (".svg", ".pdf", ".png")


@dataclass(frozen=True)
class LinearRequest:
    """What more can be asked of a linear system."""

    name: str  # the word of --show, or the option, without its strokes; what it finds stands under it in JSON
    find: Callable[[System, argparse.Namespace], tuple[Lines, Any]]  # what it finds: lines to print, and data
    writes: str = ""  # the option that names its file, if it has one
    shown: bool = False  # whether it is a word of --show

    @property
    def flag(self) -> str:
        return f"--show {self.name}" if self.shown else f"--{self.name}"

    def given(self, options: argparse.Namespace) -> bool:
        return self.name in (split(options.show) or ()) or getattr(options, self.name, None) is not None


def _transfer(system: System, options: argparse.Namespace) -> tuple[Lines, Any]:
    lines: Lines = []
    found = system.linearization.transfer()
    for one in found:
        if one.gain == 0:
            lines.append(f"{one.output} / {one.input}: 0, it does not follow")
        else:
            lines += [
                f"{one.output} / {one.input}: gain {in_digits(one.gain, 6)}",
                f"  zeros: {poles_in_words(one.zeros)}",
                f"  poles: {poles_in_words(one.poles)}",
            ]
    return lines or ["no input drives anything"], [one.as_json() for one in found]


def _reach(system: System, options: argparse.Namespace) -> tuple[Lines, Any]:
    lines: Lines = []
    data: Data = {}
    for word, how, verb, found in (
        ("controllability", "no input moves", "moved", system.linearization.controllability()),
        ("observability", "no output shows", "seen", system.linearization.observability()),
    ):
        margin = f", {in_digits(found.margin, 2)} of the size of A from less" if found.rank else ""
        lines.append(f"{word}: rank {found.rank} of {found.order}{margin}")
        near = [mark for mark in found.marks if not mark.hidden][:1]
        for mark in (*found.hidden, *near):
            said = f"{how} the mode" if mark.hidden else f"least {verb}: the mode"
            by = f"{'of' if mark.hidden else 'by'} {', '.join(mark.states)}"
            lines.append(f"  {said} {poles_in_words([mark.value])} 1/s, {by}")
        data[word] = found.as_json()
    return lines, data


def _bode(system: System, options: argparse.Namespace) -> tuple[Lines, Any]:
    one: StateSpace = system.linearization if options.lqr is None else system.lqr(options.lqr, options.dt).loop
    found = one.bode(hertz=options.hertz or True)
    lines = [] if options.bode else found.table().csv().splitlines()
    if options.lqr is not None:
        say("symdyn: bode: the open loop of the regulator, K (s I - A)^-1 B; without --lqr that of the mechanism")
    return lines + written(options.bode or (), found.table().csv, found.picture), found.as_json()


def _margins(system: System, options: argparse.Namespace) -> tuple[Lines, Any]:
    one, lines, data = system.linearization, Lines(), []
    for output, input in product(one.outputs.names, one.inputs.names):
        found = one.margins(output, input)
        lines.append(f"loop {input} = -{output}, {found.verdict}: {found.words}")
        data.append({"output": output, "input": input, **found.as_json()})
    if options.lqr is not None:
        regulator = system.lqr(options.lqr, options.dt)
        others = " and closed at the other drives" * (len(regulator.inputs) > 1)
        for drive in regulator.inputs:
            found = regulator.margins(drive)
            lines.append(f"loop of the regulator, cut open at {drive}{others}, {found.verdict}: {found.words}")
            data.append({"output": drive, "input": drive, **found.as_json()})
    return lines or ["no input drives anything"], data


def _step(system: System, options: argparse.Namespace) -> tuple[Lines, Any]:
    table = system.linearization.step().table()
    columns = zip(table.columns, zip(*table.rows, strict=True), strict=True)
    return table.csv().splitlines(), {str(name): list(values) for name, values in columns}


def _animate(system: System, options: argparse.Namespace) -> tuple[Lines, Any]:
    found = system.animate(Path(options.animate), reel(options), lambda line: say(f"symdyn: {line}"))
    data = [{"file": str(path), "eigenvalue": [mode.value.real, mode.value.imag]} for path, mode, _ in found]
    return [f"{path}: {words}" for path, _, words in found], data


def _sampled(system: System, options: argparse.Namespace) -> tuple[Lines, Any]:
    period = options.dt
    exact, stepped = system.sampled(period)
    apart = max(float(np.abs(x - y).max(initial=0.0)) for x, y in ((exact.A, stepped.A), (exact.B, stepped.B)))
    told = stepped if system.linearization.kind == "moving" else exact
    lines = [f"x(t + T) = Phi x(t) + Gamma w(t), T = {period:g} s, inputs held"]
    lines += _matrix("Phi", told.A) + (_matrix("Gamma", told.B) if told.B.size else [])
    lines.append(f"eigenvalues: {poles_in_words(told.poles)}")
    lines.append(
        f"by variational equations along the step the same to {apart:.1g}"
        if system.linearization.kind != "moving"
        else f"along the motion from this point; with A and B of its beginning entries are off by up to {apart:.1g}"
    )
    data = {"period": period, "Phi": told.A.tolist(), "Gamma": told.B.tolist()}
    eigenvalues = [[z.real, z.imag] for z in told.poles.tolist()]
    return lines, data | {"eigenvalues": eigenvalues, "formulations_differ_by": apart}


def _matrix(name: str, M: Any) -> Lines:
    cells = [[in_digits(x, 6) for x in row] for row in M.tolist()]
    width = max(len(cell) for row in cells for cell in row)
    head = f"{name} = "
    return [
        (head if k == 0 else " " * len(head)) + "[" + " ".join(cell.rjust(width) for cell in row) + "]"
        for k, row in enumerate(cells)
    ]


def _lqr(system: System, options: argparse.Namespace) -> tuple[Lines, Any]:
    found = system.lqr(options.lqr, options.dt)
    behind = "(of Phi - Gamma K)" if found.period else "1/s"
    lines = [*found.lines(), f"closed-loop poles: {poles_in_words(found.poles)} {behind}", *found.notes]
    if options.gains:
        path = Path(options.gains)
        write_file(path, found.text())
        words = ["symdyn", "simulate", options.scene, "--until", "10", "--feedback", str(path)]
        words += ["--bind", options.bind] if options.bind else []
        words += ["--forces", *flattened(options.forces)] if system.linearization.feeding else []
        lines += [str(path), f"run it: {shlex.join(words)}"]
    return lines, found.as_json()


def _kalman(system: System, options: argparse.Namespace) -> tuple[Lines, Any]:
    found = system.kalman(options.kalman, options.dt)
    behind = "(of Phi - L C)" if found.period else "1/s"
    lines = [*_matrix("L", found.L), f"filter poles: {poles_in_words(found.poles)} {behind}", *found.notes]
    return lines, found.as_json()


# A row finds something of a system, tells it in lines, and as data for --json.
ASKED: tuple[LinearRequest, ...] = (
    LinearRequest("transfer", _transfer, shown=True),
    LinearRequest("reach", _reach, shown=True),
    LinearRequest("bode", _bode, "bode", shown=True),
    LinearRequest("margins", _margins, shown=True),
    LinearRequest("step", _step, shown=True),
    LinearRequest("dt", _sampled),
    LinearRequest("lqr", _lqr, "gains"),
    LinearRequest("kalman", _kalman),
    LinearRequest("animate", _animate, "animate"),
)
"""What more can be asked, in the order in which it is told."""


def written(names: Sequence[str], table: Callable[[], str], picture: Callable[[str], bytes]) -> Lines:
    """Write files by their endings, and return their names."""
    for name in names:
        ending = Path(name).suffix.lower()
        contents: Contents = table() if ending == ".csv" else picture(ending[1:])
        write_file(name, contents)
    return [str(name) for name in names]


ENDINGS = {"bode": (".csv", *PICTURES), "locus": (".csv", *PICTURES), "gains": (".json",), "animate": Reel.endings()}
"""What files may be, by the option that names them."""


def check_flags(options: argparse.Namespace) -> None:
    """Raise LinearizeError for flags that want another one, or files that could not be written in the end."""
    faults = Faults("")
    words = {one.name: one for one in ASKED if one.shown}
    for word in () if options.show is None else split(options.show) or ("",):
        if word not in words:
            faults.add("--show", f'there is no "{word}"; {choice(word, words)}')
    if options.bode == []:
        faults.add("--bode", "names no file; --show bode prints the responses")
    if options.hertz is not None and not words["bode"].given(options):
        faults.add("--hertz", "belongs to --show bode, which is not given")
    for name, wants in {"gains": "lqr", "locus": "over"}.items():
        if getattr(options, name) is not None and getattr(options, wants) is None:
            faults.add(f"--{name}", f"belongs to --{wants}, which is not given")
    if options.over is not None:
        alone = [one.flag for one in ASKED if one.given(options)]
        alone += [flag for flag, given in (("--output", options.output), ("--along", options.along)) if given]
        if options.outputs is not None:
            faults.add("--outputs", "has no part in eigenvalues, which are what --over finds; leave it out")
        for flag in alone:
            faults.add(flag, "is of one system, and --over makes many; give one of them")
        if options.start == "rest":
            faults.add("--start", "rest may be many places; name one, and it is followed: --start NAME=VALUE")
    for option, endings in ENDINGS.items():
        given = getattr(options, option) or ()
        for path in map(Path, [given] if isinstance(given, str) else given):
            ending = path.suffix.lower()
            if ending not in endings:
                faults.add(f"--{option}", f"{path} is no {' or '.join(endings)} file")
                continue
            with faults.noted():
                check_folder(path, SimulateError)
                if option == "animate":
                    CHECKS["film"](path, reel(options))
                elif ending in PICTURES:
                    CHECKS["plot"](path)
    if not options.animate:
        with faults.noted():
            reel(options)
    faults.close(LinearizeError)


def rates_of(options: argparse.Namespace) -> dict[str, str]:
    """Return the velocities that --start-rates and --speed give, formulas by name."""
    return pairs(options.start_rates, "--start-rates") | pairs(options.speed, "--speed")


def locus_over_range(scene: Scene, options: argparse.Namespace) -> tuple[Lines, Data]:
    """Return lines and data of the root locus over a range, and write its files."""
    problem = Problem(scene, flattened(options.forces), pairs(options.start, "--start"), rates_of(options))
    found = locus_over(problem, options.over, split(options.independent) or (), options.anywhere)
    lines = found.lines() + written(options.locus or [], found.table().csv, found.picture)
    return lines, found.as_json()


FORMATS: Mapping[str, Callable[[System], str]] = {"text": System.text, "latex": System.latex}

REST = "rest"


def run(options: argparse.Namespace) -> int:
    """Linearise, print, write."""
    scene = read_scene_to_move(options)
    check_flags(options)
    if options.over:
        with Waiting("linearising"):
            lines, data = locus_over_range(scene, options)
        answer(data, lambda: print_text("\n".join(lines)))
        return 0
    if options.along is not None and (options.start or options.start_rates):
        raise LinearizeError("--along takes its points from a run; leave --start and --start-rates out")
    if options.start == REST and options.start_rates:
        raise LinearizeError("--start rest has no velocities; leave --start-rates out, or say where with --start")
    file = SystemsFile(Path(options.output)) if options.output else None
    with Waiting("linearising"):
        systems, notes = _systems(scene, options)
        files = [one.flag for one in ASKED if one.given(options) and one.writes and getattr(options, one.writes)]
        if len(systems) > 1 and files:
            raise LinearizeError(
                f"{', '.join(files)}: there are {len(systems)} systems; give the place of one, as --start LIST"
            )
        told = [_json(one, options) if options.json else _text(one, options) for one in systems]
    loops = ("bode", "margins") * (options.lqr is not None)
    alone = [one.flag for one in ASKED if one.shown and one.given(options) and one.name not in loops]
    if alone and options.dt is not None:
        notes = [*notes, f"--dt {options.dt:g}: {', '.join(alone)}: of the mechanism all the time, without samples"]
    for note in (*notes, *_without_formulas(systems, scene)):
        say(f"symdyn: {note}")
    if file is not None:
        file.write([one.linearization for one in systems])
        print_paths(options.output)
    if options.json:
        give(told if options.along is not None or options.start == REST else told[0])
    elif not (options.output and options.along):
        print_text("\n\n".join(map(str, told)))
    return 0


def _systems(scene: Scene, options: argparse.Namespace) -> tuple[list[System], Sequence[str]]:
    """Return the linear systems that the options ask for, and what is said of how they were found."""
    outputs = [] if options.outputs is None else split_commas(options.outputs) or [""]
    independent, mode = split(options.independent) or (), pairs(options.mode, "--mode")
    problem = Problem(scene, flattened(options.forces))
    if options.start == REST or options.along is not None:
        where = REST if options.along is None else Path(options.along)
        return System.find(problem, where, outputs, independent, options.anywhere, mode)
    forces = problem.forces if scene.rates else ()
    _, start = collected(
        lambda: problem.driving,
        lambda: Problem(scene, forces, pairs(options.start, "--start"), rates_of(options)).initial,
    )
    problem = replace(problem, start=start)  # type: ignore[arg-type]
    return System.find(problem, "start", outputs, independent, options.anywhere, mode)


def _without_formulas(systems: Sequence[System], scene: Scene) -> Lines:
    """Return why no formulas are printed, and what has them."""
    if len(systems) == 1 and not scene.parameters:
        return ["no formulas of A and B: the scene has numbers and no parameters; --symbolic all gives them names"]
    if len(systems) == 1 and systems[0].formulas is None:
        where = "symdyn.linearize(...).formulas in Python has them of any size"
        return [f"formulas of A and B are printed where these are short, at rest; {where}"]
    return []


def _text(system: System, options: argparse.Namespace) -> str:
    more = ["\n".join(one.find(system, options)[0]) for one in ASKED if one.given(options)]
    return "\n\n".join([FORMATS[options.format](system), *more])


def _json(system: System, options: argparse.Namespace) -> dict[str, Any]:
    more = {one.name: one.find(system, options)[1] for one in ASKED if one.given(options)}
    return system.as_json() | more
