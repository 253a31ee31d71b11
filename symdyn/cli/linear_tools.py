"""What more can be asked of a linear system that `symdyn linearize` has found: a row a word of --show, or a flag.

A row finds something of a system, tells it in lines, and as data for --json. The endings of files say what is written.
"""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from symdyn.cli.scene_options import split
from symdyn.cli.talk import say
from symdyn.cli.trajectory_options import flattened, reel
from symdyn.emit import Contents, write_file
from symdyn.linear import System, shown
from symdyn.rounding import in_digits

Lines: TypeAlias = list[str]
Data: TypeAlias = dict[str, Any]

PICTURES = (".svg", ".pdf", ".png")


@dataclass(frozen=True)
class LinearRequest:
    """What more can be asked of a linear system.

    Attributes:
        name: the word of --show, or the option, without its strokes; what it finds stands under it in JSON.
        find: what it finds: lines to print, and data.
        writes: the option that names its file, if it has one.
        shown: whether it is a word of --show.
    """

    name: str
    find: Callable[[System, argparse.Namespace], tuple[Lines, Any]]
    writes: str = ""
    shown: bool = False

    @property
    def flag(self) -> str:
        """How it is asked for."""
        return f"--show {self.name}" if self.shown else f"--{self.name}"

    def given(self, options: argparse.Namespace) -> bool:
        """Whether it is asked for."""
        return self.name in (split(options.show) or ()) or getattr(options, self.name, None) is not None


def _transfer(system: System, options: argparse.Namespace) -> tuple[Lines, Any]:
    lines: Lines = []
    found = system.linearization.transfers()
    for one in found:
        if one.gain == 0:
            lines.append(f"{one.output} / {one.input}: 0, it does not follow")
        else:
            lines += [
                f"{one.output} / {one.input}: gain {in_digits(one.gain, 6)}",
                f"  zeros: {_listed(one.zeros)}",
                f"  poles: {_listed(one.poles)}",
            ]
    return lines or ["no input drives anything"], [one.as_json() for one in found]


def _listed(values: Any) -> str:
    once = [value for value in values if value.imag >= 0]
    return ", ".join(map(shown, once)) or "none"


def _reach(system: System, options: argparse.Namespace) -> tuple[Lines, Any]:
    lines: Lines = []
    data: Data = {}
    for word, how, verb, found in (
        ("controllability", "no input moves", "moved", system.linearization.controllability()),
        ("observability", "no output shows", "seen", system.linearization.observability()),
    ):
        margin = f", {in_digits(found.margin, 2)} of the size of A from less" if found.rank else ""
        lines.append(f"{word}: rank {found.rank} of {found.order}{margin}")
        lines += [f"  {how} the mode {shown(mark.value)} 1/s, of {', '.join(mark.states)}" for mark in found.hidden]
        near = [mark for mark in found.marks if not mark.hidden][:1]
        lines += [f"  least {verb}: the mode {shown(mark.value)} 1/s, by {', '.join(mark.states)}" for mark in near]
        data[word] = found.as_json()
    return lines, data


def _bode(system: System, options: argparse.Namespace) -> tuple[Lines, Any]:
    found = system.bode(options.hertz or None)
    title = f"{system.linearization.scene.name}: frequency response"
    lines = [] if options.bode else found.table().csv().splitlines()
    return lines + written(options.bode or (), found.table().csv, lambda kind: found.plot(title, kind)), found.as_json()


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
    lines.append(f"eigenvalues: {', '.join(map(shown, [z for z in told.eigenvalues if z.imag >= 0]))}")
    lines.append(
        f"by variational equations along the step the same to {apart:.1g}"
        if system.linearization.kind != "moving"
        else f"along the motion from this point; with A and B of its beginning entries are off by up to {apart:.1g}"
    )
    return lines, told.as_json() | {"formulations_differ_by": apart}


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
    lines = found.lines()
    lines.append(f"closed-loop poles: {_listed(found.poles)}" + (" (of Phi - Gamma K)" if found.period else " 1/s"))
    lines += list(found.notes)
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
    lines = _matrix("L", found.L)
    lines.append(f"filter poles: {_listed(found.poles)}" + (" (of Phi - L C)" if found.period else " 1/s"))
    return lines + list(found.notes), found.as_json()


ASKED: tuple[LinearRequest, ...] = (
    LinearRequest("transfer", _transfer, shown=True),
    LinearRequest("reach", _reach, shown=True),
    LinearRequest("bode", _bode, "bode", shown=True),
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
