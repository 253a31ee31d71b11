"""What an integrator is given and what it yields.

An integrator is a generator: it yields the samples of the stretch that it has just covered, so that whoever draws them
can show progress, and stop between any two with all before them in hand.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import SimulateError
from symdyn.simulation.equations.system import Projection, StateEquations
from symdyn.simulation.feedback.loop import ControllerError


class IntegrationError(SimulateError):
    """An integrator that cannot go on: what it said."""


@dataclass(frozen=True)
class InitialValueProblem:
    """One integration from t = 0.

    Attributes:
        system: the equations.
        x: state at t = 0, shape (nx,).
        times: where samples are wanted, ascending, from 0 to the end; shape (N,).
        rtol, atol: tolerances on a step, relative and absolute.
        stops: whether the event of each of the system's formulas ends the run.
        project: brings states back to their constraints.
        low: what the state is beyond its doubles, shape (nx,); None for nothing.
        unsure: from when on in a step passages of an event may have been overlooked, s, by event; the search fills it.
    """

    system: StateEquations
    x: Array
    times: Array
    rtol: float
    atol: float
    stops: tuple[bool, ...]
    project: Projection
    low: Array | None = None
    unsure: dict[int, float] = field(default_factory=dict)

    @property
    def until(self) -> float:
        """Time of the end."""
        return float(self.times[-1])

    @property
    def outward(self) -> int:
        """The first of the events that are limits, of which only passages outwards count, where they turn positive."""
        return len(self.stops) - len(self.system.limits)

    @property
    def bound(self) -> float:
        """Time beyond which no step may go: where a controller is due, else the end."""
        return self.until if self.system.loop is None else self.system.loop.due


@dataclass(frozen=True)
class Hit:
    """An event: which formula crossed zero, when and where."""

    event: int
    t: float
    x: Array


@dataclass(frozen=True)
class Piece:
    """What an integrator has found since the last piece.

    Attributes:
        t: times of the samples, shape (k,), k may be 0.
        x: their states, shape (k, nx).
        hits: events in that stretch, in order.
        now: where the integration stands: time and state.
        steps: steps taken in that stretch.
        evaluations: of the right-hand side in that stretch.
        stopped: whether the last hit ended the run.
        low: what states are beyond their doubles, shape (k, nx); None of methods that compute in doubles.
    """

    t: Array
    x: Array
    hits: tuple[Hit, ...]
    now: tuple[float, Array]
    steps: int
    evaluations: int
    stopped: bool = False
    low: Array | None = None


Integrator = Callable[[InitialValueProblem], Iterator[Piece]]

SHARE = 0.1
"""Part of the tolerance that multistep methods are given for a step: the errors of theirs add up, to ten and more."""


DOUBLES = 1e-16
"""The finest relative tolerance that means anything in doubles."""


@dataclass(frozen=True)
class Method:
    """An integrator.

    Attributes:
        library: whose it is.
        text: what it is, one line.
        module: what must be importable.
        extra: the extra of this package that installs it; "" for none.
        rtol: tolerance if none is given.
        run: the integrator.
        refuses: why it does not apply to a system, "" if it does.
        finds_events: whether it looks for zeros of formulas, and stops at limits of joints.
        finest: the finest relative tolerance that it works with, and that means anything in the numbers it computes in.
        absolute: whether it has an absolute tolerance too.
    """

    library: str
    text: str
    module: str
    extra: str
    rtol: float
    run: Integrator
    refuses: Callable[[StateEquations], str] = lambda system: ""
    finds_events: bool = True
    finest: float = DOUBLES
    absolute: bool = True

    @property
    def installed(self) -> bool:
        """Whether its module is."""
        return importable(self.module)

    @property
    def beyond_doubles(self) -> bool:
        """Whether it computes with more digits than doubles have."""
        return self.finest < DOUBLES

    def tolerances(self, name: str, rtol: float | None, atol: float | None) -> tuple[float, float, list[str]]:
        """Return the relative and the absolute tolerance that it takes, and what is said of others that are asked for.

        `name` is its own; None asks for none.
        """
        relative = self.rtol if rtol is None else max(rtol, self.finest)
        absolute = relative if atol is None or not self.absolute else atol
        said = []
        if rtol is not None and rtol < self.finest:
            said.append(f"rtol = {rtol:g} is finer than what {name} works with; it takes {self.finest:.2g}")
        if atol is not None and not self.absolute and atol != relative:
            said.append(
                f"atol = {atol:g} has no effect: {name} has one tolerance, rtol = {relative:g}, relative to the "
                "largest number of a state, or absolute where that is below 1"
            )
        return relative, absolute, said


LIBRARIES_RAISE = (ArithmeticError, ValueError, RuntimeError, MemoryError)
"""What integrators and linear algebra of others end with, where a state is not finite or a matrix is singular."""


def integrate(method: Method, problem: InitialValueProblem) -> Iterator[Piece]:
    """Yield the pieces of a motion; whatever a library ends with is told in words, and what came before it stands.

    Raises:
        IntegrationError: the integrator cannot go on.
    """
    t = 0.0
    try:
        with np.errstate(all="ignore"):  # what tells that a motion ends there is said in words
            for piece in method.run(problem):
                t = piece.now[0]
                yield piece
    except ControllerError as fault:
        raise IntegrationError(str(fault)) from fault
    except LIBRARIES_RAISE as fault:
        if isinstance(fault.__cause__ or fault.__context__, KeyboardInterrupt):  # a library's own words for Ctrl-C
            raise KeyboardInterrupt from fault
        raise IntegrationError(f"{method.library} cannot go on after t = {t:g} s: {fault}") from fault


def importable(name: str) -> bool:
    """Tell whether a module is installed."""
    from importlib.util import find_spec

    return find_spec(name) is not None
