"""What makes tests of a process faster and changes no answer.

Pure functions of frozen values are asked once: a scene is read once for its text, its source and the options, and what
tells a student's terms apart is found once for a scene and a quantity. Nothing that has a state is kept. C and C++ are
compiled as they stand, without optimising, and heyoka's code likewise: half of all the time of tests was gcc's. A test
of what optimised code does says `optimised`, and `make slow` compiles well all that it runs.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache, wraps
from typing import Any

from symdyn.runtime import commands
from symdyn.scene import toml
from symdyn.scene.declaration.reading import Reading, ReadOptions
from symdyn.scene.values.entry import Faults
from symdyn.simulation.integrate import heyoka_expressions
from symdyn.teach.student import diagnosis

KEPT = 32
"""Answers of one function; of scenes eight times as many."""

_soon = [True]


@contextmanager
def optimised() -> Iterator[None]:
    """Compile well for now."""
    before, _soon[0] = _soon[0], False
    try:
        yield
    finally:
        _soon[0] = before


def begin(well: bool = False) -> None:
    """Let this process do so from now on; `well` compiles well everywhere, as `make slow` does."""
    _soon[0] = not well
    toml._reading = _read_once(toml._reading)
    diagnosis.motions_of = _once(diagnosis.motions_of, lambda scene, course: (scene, course is None))
    diagnosis.evidence_of = _once(diagnosis.evidence_of, lambda course, motions, key: (course.scene, key))
    needs, integrator = commands.GNU.needs, heyoka_expressions.integrator

    def needed(of: commands.Needs) -> commands.Words:
        return (*needs(of), *(("-O0",) if _soon[0] else ()))  # the last of several levels is taken

    def lent(expressions: Sequence[Any], options: dict[str, Any], make: Callable[[], Any]) -> Any:
        if _soon[0]:
            options.setdefault("opt_level", 0)  # `make` hands them on
        return integrator(expressions, options, make)

    object.__setattr__(commands.GNU, "needs", needed)
    heyoka_expressions.integrator = lent


def _read_once(read: Callable[[str, Faults, ReadOptions], Reading]) -> Callable[[str, Faults, ReadOptions], Reading]:
    @lru_cache(maxsize=8 * KEPT)
    def found(text: str, source: str, options: ReadOptions) -> Reading:
        return read(text, Faults(source), options)

    return lambda text, faults, options: found(text, faults.source, options)


def _once(made: Callable[..., Any], key: Callable[..., Hashable]) -> Callable[..., Any]:
    """Return a function whose last answers are kept by a key of its arguments."""
    found: dict[Hashable, Any] = {}

    @wraps(made)
    def call(*arguments: Any) -> Any:
        name = key(*arguments)
        if name not in found:
            if len(found) == KEPT:
                del found[next(iter(found))]
            found[name] = made(*arguments)
        return found[name]

    return call
