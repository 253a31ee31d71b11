"""What more can be asked of a linear system that `symdyn linearize` has found: a row a flag.

A row finds something of a system, tells it in lines, and as data for --json. The endings of files say what is written.
"""

from __future__ import annotations

import argparse
import math
import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from symdyn.cli.seconds import seconds
from symdyn.cli.talk import say
from symdyn.cli.trajectory_options import ANIMATED, flattened, reel
from symdyn.emit import Contents
from symdyn.linear import (
    MODE_PERIOD,
    Bode,
    Linearization,
    Observer,
    Prepared,
    Reach,
    Regulator,
    Sampled,
    Symbolic,
    along_a_step,
    animate_modes,
    bode,
    bode_plot,
    bode_table,
    controllability,
    kalman,
    lqr,
    numbers,
    observability,
    read_weights,
    sampled,
    shown,
    transfers,
)
from symdyn.rounding import in_digits
from symdyn.simulation import write_whole

Lines: TypeAlias = list[str]
Data: TypeAlias = dict[str, Any]

PICTURES = (".svg", ".pdf", ".png")


@dataclass(frozen=True)
class System:
    """A linear system and what it came from.

    Attributes:
        asked: what was linearised; linear systems at other places, and values, are asked of it.
        found: the system.
        formulas: the same in formulas, where it is small.
    """

    asked: Prepared
    found: Linearization
    formulas: Symbolic | None


@dataclass(frozen=True)
class Asked:
    """What more can be asked of a linear system.

    Attributes:
        flag: the option, such as "--lqr".
        how: further arguments of `add_argument`.
        find: what it finds: lines to print, and what stands in JSON under the name of the option.
        writes: the option that names its file, if it has one.
    """

    flag: str
    how: Mapping[str, Any]
    find: Callable[[System, argparse.Namespace], tuple[Lines, Any]]
    writes: str = ""

    @property
    def name(self) -> str:
        """Name of its value among the options."""
        return self.flag.removeprefix("--").replace("-", "_")

    def given(self, options: argparse.Namespace) -> bool:
        """Whether it is asked for."""
        value = getattr(options, self.name)
        return value is not None and value is not False


def _transfer(system: System, options: argparse.Namespace) -> tuple[Lines, Any]:
    lines, data = [], []
    for one in transfers(system.found):
        if one.gain == 0:
            lines.append(f"{one.output} / {one.input}: 0, it does not follow")
        else:
            lines += [
                f"{one.output} / {one.input}: gain {in_digits(one.gain, 6)}",
                f"  zeros: {_listed(one.zeros)}",
                f"  poles: {_listed(one.poles)}",
            ]
        data.append({
            "output": one.output, "input": one.input, "gain": one.gain, "zeros": pairs_of(one.zeros),
            "poles": pairs_of(one.poles), "numerator": one.numerator.tolist(), "denominator": one.denominator.tolist(),
        })  # fmt: skip
    return lines or ["no input drives anything"], data


def _listed(values: Any) -> str:
    once = [value for value in values if value.imag >= 0]
    return ", ".join(map(shown, once)) or "none"


def pairs_of(values: Any) -> list[list[float]]:
    """Return complex numbers for JSON, real and imaginary parts."""
    return [[float(value.real), float(value.imag)] for value in values]


def _reach(system: System, options: argparse.Namespace) -> tuple[Lines, Any]:
    lines: Lines = []
    data: Data = {}
    for word, how, verb, found in (
        ("controllability", "no input moves", "moved", controllability(system.found)),
        ("observability", "no output shows", "seen", observability(system.found)),
    ):
        margin = f", {in_digits(found.margin, 2)} of the size of A from less" if found.rank else ""
        lines.append(f"{word}: rank {found.rank} of {found.order}{margin}")
        lines += [f"  {how} the mode {shown(mark.value)} 1/s, of {', '.join(mark.states)}" for mark in found.hidden]
        near = [mark for mark in found.marks if not mark.hidden][:1]
        lines += [f"  least {verb}: the mode {shown(mark.value)} 1/s, by {', '.join(mark.states)}" for mark in near]
        data[word] = _reached(found)
    return lines, data


def _reached(found: Reach) -> Data:
    marks = [
        {"eigenvalue": pairs_of([m.value])[0], "margin": m.margin, "hidden": m.hidden, "states": list(m.states)}
        for m in found.marks
    ]
    return {"rank": found.rank, "order": found.order, "margin": found.margin, "modes": marks}


def _bode(system: System, options: argparse.Namespace) -> tuple[Lines, Any]:
    hertz = numbers(options.hertz, "--hertz") if options.hertz else None
    found = bode(system.found, hertz)
    if not options.bode:
        return bode_table(found).splitlines(), _response(found)
    title = f"{system.found.scene.name}: frequency response"
    lines = written(options.bode, lambda: bode_table(found), lambda kind: bode_plot(found, title, kind))
    return lines, _response(found)


def _response(found: Bode) -> Data:
    channels = [
        {"of": title, "decibels": _finite(size), "degrees": _finite(phase)} for title, size, phase in found.pairs
    ]
    return {"hertz": found.hertz.tolist(), "channels": channels}


def _finite(values: Any) -> list[float | None]:
    return [float(x) if math.isfinite(x) else None for x in values]


def _animate(system: System, options: argparse.Namespace) -> tuple[Lines, Any]:
    found = animate_modes(system.found, Path(options.animate), reel(options), lambda line: say(f"symdyn: {line}"))
    lines = [
        f"{path}: the mode {shown(mode.value)} 1/s"
        + (f", {in_digits(mode.frequency, 6)} Hz, a round in {MODE_PERIOD:g} s" if mode.oscillates else "")
        for path, mode in found
    ]
    return lines, [{"file": str(path), "eigenvalue": pairs_of([mode.value])[0]} for path, mode in found]


def _sampled(system: System, options: argparse.Namespace) -> tuple[Lines, Any]:
    period = options.dt
    exact, stepped = sampled(system.found, period), along_a_step(system.asked, system.found, period)
    apart = max(float(np.abs(x - y).max(initial=0.0)) for x, y in ((exact.A, stepped.A), (exact.B, stepped.B)))
    told = stepped if system.found.kind == "moving" else exact
    lines = [f"x(t + T) = Phi x(t) + Gamma w(t), T = {period:g} s, inputs held"]
    lines += _matrix("Phi", told.A) + (_matrix("Gamma", told.B) if told.B.size else [])
    lines.append(f"eigenvalues: {', '.join(map(shown, [z for z in told.eigenvalues if z.imag >= 0]))}")
    lines.append(
        f"by variational equations along the step the same to {apart:.1g}"
        if system.found.kind != "moving"
        else f"along the motion from this point; with A and B of its beginning entries are off by up to {apart:.1g}"
    )
    return lines, _steps(told) | {"roads_differ_by": apart}


def _steps(found: Sampled) -> Data:
    return {"period": found.period, "Phi": found.A.tolist(), "Gamma": found.B.tolist(),
            "eigenvalues": pairs_of(found.eigenvalues)}  # fmt: skip


def _matrix(name: str, M: Any) -> Lines:
    cells = [[in_digits(x, 6) for x in row] for row in M.tolist()]
    width = max(len(cell) for row in cells for cell in row)
    head = f"{name} = "
    return [
        (head if k == 0 else " " * len(head)) + "[" + " ".join(cell.rjust(width) for cell in row) + "]"
        for k, row in enumerate(cells)
    ]


def _lqr(system: System, options: argparse.Namespace) -> tuple[Lines, Any]:
    given = read_weights("--lqr", options.lqr, ("Q", "R"))
    found = lqr(system.found, given.get("Q"), given.get("R"), options.dt)
    lines = [f"{row} = {_terms(found, k)}" for k, row in enumerate(found.inputs)]
    lines.append(f"closed-loop poles: {_listed(found.poles)}" + (" (of Phi - Gamma K)" if found.period else " 1/s"))
    lines += list(found.notes)
    if options.gains:
        path = Path(options.gains)
        write_whole(path, found.text())
        words = ["symdyn", "simulate", options.scene, "--until", "10", "--feedback", str(path)]
        words += ["--bind", options.bind] if options.bind else []
        words += ["--forces", *flattened(options.forces)] if system.found.feeding else []
        lines += [str(path), f"run it: {shlex.join(words)}"]
    return lines, found.gains() | {"poles": pairs_of(found.poles), "notes": list(found.notes)}


def _terms(found: Regulator, row: int) -> str:
    parts = [
        f"{-x:+.6g} {name}" for x, name in zip(found.K[row], found.system.states.names, strict=True) if abs(x) > 1e-12
    ]
    return " ".join(parts).replace("+", "+ ").replace("-", "- ").replace("e- ", "e-").replace("e+ ", "e+") or "0"


def _kalman(system: System, options: argparse.Namespace) -> tuple[Lines, Any]:
    given = read_weights("--kalman", options.kalman, ("W", "V"))
    found = kalman(system.found, given.get("W"), given.get("V"), options.dt)
    lines = _matrix("L", found.L)
    lines.append(f"filter poles: {_listed(found.poles)}" + (" (of Phi - L C)" if found.period else " 1/s"))
    return lines + list(found.notes), _observer(found, system.found)


def _observer(found: Observer, one: Linearization) -> Data:
    return {
        "L": found.L.tolist(), "states": list(one.states.names), "outputs": list(one.outputs.names),
        "poles": pairs_of(found.poles),
    }  # fmt: skip


ASKED: tuple[Asked, ...] = (
    Asked(
        "--transfer",
        {"action": "store_true", "help": "transfer functions from every input to every output: gains, zeros, poles"},
        _transfer,
    ),
    Asked(
        "--reach",
        {"action": "store_true", "help": "controllability and observability: ranks, how far from less, hidden modes"},
        _reach,
    ),
    Asked(
        "--bode",
        {"nargs": "*", "metavar": "FILE", "help": "frequency responses: .csv, .svg, .pdf, .png; without a file as CSV"},
        _bode,
        "bode",
    ),
    Asked(
        "--dt",
        {
            "type": seconds,
            "metavar": "T",
            "help": "the sampled system, inputs held for T s; gains are those of it then",
        },
        _sampled,
    ),
    Asked(
        "--lqr",
        {
            "nargs": "*",
            "metavar": "WEIGHT",
            "help": 'the linear quadratic regulator: "Q=x:10;theta:100" "R=F:0.1", what is not named weighs 0 in Q '
            "and 1 in R; or an .npz file with Q and R; without any all weigh 1",
        },
        _lqr,
        "gains",
    ),
    Asked(
        "--kalman",
        {
            "nargs": "*",
            "metavar": "VARIANCE",
            "help": 'the gain of a Kalman filter: "W=F:1" of what disturbs states or inputs, "V=x:1e-4" of outputs; '
            "or an .npz file",
        },
        _kalman,
    ),
    Asked(
        "--animate",
        {"metavar": "FILE", "help": f"every mode as a moving picture, numbered: {ANIMATED}"},
        _animate,
        "animate",
    ),
)
"""What more can be asked, in the order in which it is told."""


def written(names: Sequence[str], table: Callable[[], str], picture: Callable[[str], bytes]) -> Lines:
    """Write files by their endings, and return their names."""
    for name in names:
        ending = Path(name).suffix.lower()
        contents: Contents = table() if ending == ".csv" else picture(ending[1:])
        write_whole(Path(name), contents)
    return [str(name) for name in names]
