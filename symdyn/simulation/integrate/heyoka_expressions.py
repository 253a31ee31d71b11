"""Equations as heyoka's expressions, whether its series can follow them, and its integrators, kept between processes.

Functions have the graph's names, a power is an operator; what branches (abs, sign, select) is not here, nor are tables.

An integrator is compiled code, which belongs to one processor: in the cache its name is made of heyoka's version, the
processor, the expressions as heyoka pickles them, and its options.
"""

from __future__ import annotations

import hashlib
import importlib
import os
import pickle
import platform
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn import shell
from symdyn.dynamics import Function
from symdyn.dynamics.mechanism import TIME
from symdyn.errors import MissingCompiler
from symdyn.graph import Arithmetic, Expr, Op, evaluate, reachable
from symdyn.interrupts import interrupts_wait
from symdyn.program import Program
from symdyn.runtime import Kept
from symdyn.simulation.equations.compiled_routines import Compiled
from symdyn.simulation.equations.system import StateEquations

UNSEEN = (Op.EXP, Op.TANH)
"""Functions that are flat to the last digit of a double where they do not turn."""

BRANCHED = (Op.SQRT, Op.ATAN2, Op.POW)
"""Functions with branches: √x² is |x|, whose series on one side of zero says -x on the other."""

PI = Fraction("3.14159265358979323846264338327950288419716939937510")


def settle(heyoka: Any) -> None:
    """Let heyoka keep its code in our cache, in a process that is the shell's own; elsewhere its settings are others'.

    heyoka runs what it finds there, whoever wrote it. A folder that the user named in $HEYOKA_CACHE_DIR stays. Where
    there is none to trust, nothing is kept.
    """
    states = heyoka.llvm_state
    if shell.is_own() and not os.environ.get("HEYOKA_CACHE_DIR") and hasattr(states, "set_diskcache_path"):
        heyoka.set_logger_level_error()  # it warns where it can keep nothing, such as on a full disk
        with suppress(OSError, MissingCompiler):
            states.set_diskcache_path(str(Kept("heyoka").folder()))
            return
        states.set_diskcache_enabled(False)


def library() -> Any:
    """Return heyoka."""
    if "heyoka" not in sys.modules:
        with interrupts_wait(), without_sympy():
            settle(importlib.import_module("heyoka"))
    return sys.modules["heyoka"]


@contextmanager
def without_sympy() -> Iterator[None]:
    """Let an import find no SymPy, in a process that is the shell's own and has none yet.

    heyoka imports all of it, for translations of expressions that nobody asks for there: half of the time that a short
    run takes. In the processes of others it is left to do so.
    """
    hidden = shell.is_own() and "sympy" not in sys.modules
    if hidden:
        sys.modules["sympy"] = None  # type: ignore[assignment]
    try:
        yield
    finally:
        if hidden:
            del sys.modules["sympy"]


class Expressions(Arithmetic):
    """heyoka's expressions as an algebra."""

    def __init__(self, real: Callable[[Fraction], Any] = float) -> None:
        """Import heyoka; constants are rounded by `real`."""
        self.heyoka: Any = library()
        self.real = real

    def constant(self, value: Fraction) -> Any:
        return self.heyoka.expression(self.real(value))

    def pi(self) -> Any:
        return self.constant(PI)

    def function(self, node: Expr, args: Sequence[Any]) -> Any:
        return pow(*args) if node.op is Op.POW else getattr(self.heyoka, node.op.name.lower())(*args)


def refuses(system: StateEquations) -> str:
    """Return why the Taylor method does not apply to a system, "" if it does."""
    if system.forces.tables:
        return "a force is a table, which has no derivatives of high order"
    if system.forces.functions:
        return "a force is a function, which has no derivatives of high order"
    if system.forces.fed:
        return "a controller is no formula"
    branches = sorted(op.name.lower() for op in system.once(_operations) if op.turns)
    return f"{' and '.join(branches)} in the equations branch" if branches else ""


def overlooks(system: StateEquations) -> str:
    """Return which functions of the equations a series may overlook, "" if there are none."""
    return " and ".join(sorted(op.name.lower() for op in system.once(_operations) if op in UNSEEN))


def guarded(system: StateEquations) -> bool:
    """Tell whether steps are checked: a series may overlook a turn, or go on where a root or an angle turns back."""
    return any(op in (*UNSEEN, *BRANCHED) for op in system.once(_operations))


def size(system: StateEquations) -> int:
    """Return how many operations are compiled."""
    return system.once(_operations).total()


def equations(system: StateEquations) -> Function:
    """Return the rates that series are made of, of a closed mechanism by all rows at once.

    What fails where a choice of independent velocities does would end the series there.
    """
    made = _compiled(system)
    return made.prepared["together" if made is not system.compiled else "rates"].function


def _compiled(system: StateEquations) -> Compiled:
    closed = system.together if system.swerves else None
    return system.compiled if closed is None else closed


def _operations(system: StateEquations) -> Counter[Op]:
    return Counter(node.op for node in reachable(equations(system).entries) if node.args)


def translate(system: StateEquations, real: Callable[[Fraction], Any] | None = None) -> tuple[list[Any], list[Any]]:
    """Return the variables of the state and its rates as heyoka's expressions.

    W, the work, is a state that nothing depends on. Prepared values are heyoka's parameters, in the order of
    `parameters`; or constants where `real` is given, which rounds all of them.
    """
    algebra = Expressions(real or float)
    function = equations(system)
    symbols = {argument.name: argument.symbols for argument in function.arguments}
    states = [*symbols["q"], *symbols["qd"]]
    names = [str(symbol.value) for symbol in states] + (["work of forces"] if system.works else [])
    variables = [algebra.heyoka.expression(one) for one in names]
    values: dict[Expr, Any] = dict(zip(states, variables, strict=False))
    values[symbols[TIME][0]] = algebra.heyoka.time
    prepared = symbols.get(Program.PREPARED, ())
    if real is None:
        values |= {symbol: algebra.heyoka.par[k] for k, symbol in enumerate(prepared)}
    else:
        known = parameters(system)
        values |= {symbol: algebra.constant(Fraction(float(x))) for symbol, x in zip(prepared, known, strict=True)}
    return variables, evaluate(function.entries, algebra, values)


def parameters(system: StateEquations) -> npt.NDArray[np.float64]:
    """Return the prepared values of the rates."""
    return _compiled(system).values(system.opened.values)


def taylor_of(system: StateEquations, start: Any, real: Callable[[Fraction], Any], kind: Any) -> tuple[Any, Any]:
    """Return Taylor's method for numbers of a kind, at a start, and the outcome of one that reaches its time."""
    heyoka = library()
    rates = list(zip(*translate(system, real=real), strict=True))
    return heyoka.taylor_adaptive(rates, start, compact_mode=True, fp_type=kind), heyoka.taylor_outcome.time_limit


SUFFIX = ".heyoka"

MOST = 64
"""Integrators that are kept, of a few hundred kB each."""


def integrator(expressions: Sequence[Any], options: Mapping[str, Any], make: Callable[[], Any]) -> Any:
    """Return an integrator of expressions with options: the one that is kept, or the one that `make` compiles.

    The caller sets its state, time and parameters, which are those that it was made with.
    """
    kept = Kept(_name(expressions, options))
    content = kept.content()
    if content is not None:
        with suppress(Exception):  # a heyoka of the same version that was built otherwise
            return pickle.loads(content)  # our own bytes: folder, owner and hash were looked at
    made = make()
    kept.keep(pickle.dumps(made), MOST)
    return made


def _name(expressions: Sequence[Any], options: Mapping[str, Any]) -> str:
    digest = hashlib.sha256()
    about = (library().__version__, platform.python_version(), *processor(), repr(sorted(options.items())))
    for part in (*(one.encode() for one in about), pickle.dumps(list(expressions))):
        digest.update(f"{len(part)}:".encode() + part)
    return f"integrator-{digest.hexdigest()[:24]}{SUFFIX}"


@cache
def processor() -> tuple[str, ...]:
    """Return what tells processors apart that run different code: model and features, else the machine's own name."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError):
        return (*platform.uname(),)
    told = ("model name", "flags", "Features", "CPU part", "isa", "uarch", "cpu")
    return (platform.machine(), *sorted({line for line in lines if line.partition(":")[0].strip() in told}))
