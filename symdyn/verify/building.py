"""Files of a certificate, each written once, and compilers at work while proofs run.

A compiler is a process of its own, so that what it takes is the longer of two times and not their sum. Modules come out
in the order of the targets, as if one had been built after the other.
"""

from __future__ import annotations

from collections.abc import Container, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, replace
from types import TracebackType
from typing import Any

from symdyn.dynamics import row_of
from symdyn.emit import TARGETS, Sources, emit
from symdyn.errors import BuildError, EmitError, MissingProgram
from symdyn.program import Program
from symdyn.runtime import RUNNERS, Commands
from symdyn.verdict import Unclaimed


@dataclass(frozen=True)
class Modules:
    """What was built of a program.

    Attributes:
        built: modules by target.
        missing: targets that this machine cannot run, and what it lacks.
        refused: the words of what refused the code, behind which nothing more was built; "" for nothing.
    """

    built: dict[str, Any]
    missing: tuple[Unclaimed, ...]
    refused: str = ""


class Building:
    """The files of a program, and the modules that they make."""

    def __init__(self, program: Program, real: str, accuracy: str = "") -> None:
        """Start with nothing written; accuracy as for `emit`."""
        self.program, self.real, self.accuracy = program, real, accuracy
        small = [
            one for one in program.routines if not (one.function.request and row_of(one.function.request)[0].is_large)
        ]
        whole = len(small) == len(program.routines)
        self._usual = program if whole else replace(program, routines=tuple(small))
        self._written: dict[tuple[bool, str, str], Sources] = {}
        self._begun: dict[tuple[bool, str, str], Future[Any]] = {}
        self._commands, most = Commands(), max(1, sum(runner.aside for runner in RUNNERS.values()))
        self._threads = self._commands.threads(most)

    def __enter__(self) -> Building:
        """Return it; what was begun ends before the block does."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Wait for the compilers; stop them where nobody wants any longer what they make."""
        if kind is not None:
            self._commands.stop()
        self._threads.shutdown(cancel_futures=True)

    def written(self, target: str, option: str, part: Program | None = None) -> Sources:
        """Return the files of a target, of the whole program or a part of it."""
        key = self._key(target, option, part)
        if key not in self._written:
            self._written[key] = emit(part or self.program, target, self.real, option=option, accuracy=self.accuracy)
        return self._written[key]

    def options(self, target: str, every: bool = False) -> tuple[str, ...]:
        """Return the options of a target that are looked at: what is measured, or `every` one that has the accuracy."""
        measured = RUNNERS[target].measured if target in RUNNERS else ""
        row = TARGETS[target]
        wanted = dict.fromkeys((measured, "", *row.options) if every else (measured,))
        if not self.accuracy:
            return tuple(wanted)
        having = tuple(one for one in wanted if one in row.shortens) or row.shortens[:1]
        return having or tuple(wanted)  # which is refused in words

    def begin(self, targets: Sequence[str], many: Container[str] = ()) -> None:
        """Let compilers start on what a certificate measures of targets, and on code for `many` states of these."""
        there = [name for name in targets if name in RUNNERS and RUNNERS[name].aside]
        for name in sorted(there, key=lambda name: not RUNNERS[name].usual):  # first what takes longest
            if self._part(name).routines:
                self._begin(name, self.options(name)[0], self._part(name))
            if name in many:
                self._begin(name, RUNNERS[name].many, self.program)

    def compiled(self, target: str, option: str, part: Program | None = None) -> tuple[Sources, Any]:
        """Return the files of a target, and the module that they make.

        Raises:
            BuildError: no compiler, or its own words when it refuses.
        """
        sources = self.written(target, option, part)
        begun = self._begun.get(self._key(target, option, part))
        return sources, RUNNERS[target].run(sources) if begun is None else begun.result()

    def modules(self, targets: Sequence[str]) -> Modules:
        """Return the built modules of targets, what of them cannot be run here, and what refused the code."""
        built: dict[str, Any] = {}
        missing: list[Unclaimed] = []
        for name in targets:
            if name not in RUNNERS or not self._part(name).routines:
                continue
            try:
                _, built[name] = self.compiled(name, self.options(name)[0], self._part(name))
            except MissingProgram as fault:
                missing.append(Unclaimed(f"the error of {TARGETS[name].title}", str(fault)))
            except BuildError as fault:
                return Modules(built, tuple(missing), str(fault))
        return Modules(built, tuple(missing))

    def _begin(self, target: str, option: str, part: Program) -> None:
        key = self._key(target, option, part)
        if key not in self._begun:
            try:
                sources = self.written(target, option, part)
            except (MissingProgram, BuildError):
                return  # the same words come again where they are waited for
            self._begun[key] = self._threads.submit(RUNNERS[target].run, sources)

    def _part(self, name: str) -> Program:
        return self._usual if RUNNERS[name].usual else self.program

    def _key(self, target: str, option: str, part: Program | None) -> tuple[bool, str, str]:
        return part is None or part is self.program, target, option


def requested_targets(targets: Sequence[str] | None, real: str, accuracy: str = "") -> tuple[str, ...]:
    """Return the targets to measure: those named, else what has type and accuracy and is not for those who ask."""
    if targets is None:
        quick = {name for name, runner in RUNNERS.items() if not runner.by_name_only}
        having = {name for name, row in TARGETS.items() if real in row.reals and (row.shortens or not accuracy)}
        return tuple(name for name in TARGETS if name in quick & having)
    if len(targets) == 0:
        raise EmitError("no target is asked for: the list is empty; name some, or leave targets out")
    for name in targets:
        row = TARGETS[name]
        if row.functions is not None:
            raise EmitError(f"target {name} ({row.text}) has no functions to call; measure {' or '.join(RUNNERS)}")
        if real not in row.reals:
            raise EmitError(f"real type {real!r}: target {name} takes {' or '.join(row.reals)} alone")
    return tuple(dict.fromkeys(targets))


def unmeasured(targets: Sequence[str]) -> list[Unclaimed]:
    """Return the errors that we measure on no machine: of these targets nothing is claimed in numbers."""
    titles = [TARGETS[name].title for name in targets if name not in RUNNERS]
    return [Unclaimed(f"the error of {title}", f"not measured: symdyn runs no {title}") for title in titles]


def run_nowhere(program: Program, targets: Sequence[str], measured: Container[str]) -> list[Unclaimed]:
    """Return the functions of a program that are not among those measured, though some of these targets run here."""
    runs = [TARGETS[name].title for name in targets if name in RUNNERS]
    names = [
        one.function.name for one in program.routines if one.function.entries and one.function.name not in measured
    ]
    return [Unclaimed(f"the error of {name}", f"{', '.join(runs)} leaves it out") for name in names if runs]


def modules_of(program: Program, real: str, targets: Sequence[str]) -> Modules:
    """Return the built modules by name, and what is missing here or refuses the code."""
    with Building(program, real) as building:
        building.begin(targets)
        return building.modules(targets)
