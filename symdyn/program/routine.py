"""The nouns of this package: a program is a tuple of routines, a routine is a tuple of named steps.

A step gives a name to a node; every node between two names is printed inside the line that uses it. The nodes stay
what they were, exact expressions on one graph, so a program runs over any algebra: `evaluate(program.outputs, …)`.
A pass is a function `Program -> Program` and ends with `checked`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import ClassVar

from symdyn.arguments import check_arguments
from symdyn.dynamics import Function
from symdyn.dynamics.outputs import Counts
from symdyn.errors import UnknownNameError
from symdyn.graph import Expr, Graph, Op
from symdyn.scene import Scene
from symdyn.scene.values import listed
from symdyn.shown import Shown


@dataclass(frozen=True)
class RoutineStep:
    """One line of a routine: `name` stands for `node` from here on."""

    name: str
    node: Expr


@dataclass(frozen=True)
class Routine:
    """One function as straight-line code.

    Attributes:
        function: what it computes; its entries are nodes of the program's graph.
        inputs: names of the argument entries that are needed, in calling order.
        steps: named intermediate results, each after all it needs.
        unused: names of the arguments of which no entry is needed.
        binding: operations of one call by binding time, as `Counts.by_binding` gives them.
        operations: which there are.
    """

    function: Function
    inputs: tuple[RoutineStep, ...]
    steps: tuple[RoutineStep, ...]
    unused: tuple[str, ...]
    binding: Mapping[str, Counts]
    operations: frozenset[Op]

    @property
    def counts(self) -> Counts:
        """Operations of one call."""
        return sum(self.binding.values(), Counts())

    @property
    def prepare(self) -> Counts:
        """Operations on parameters alone, the same at every call."""
        return self.binding["params"]

    @property
    def state_counts(self) -> Counts:
        """Operations that depend on the state."""
        return self.counts - self.prepare

    @property
    def names(self) -> dict[Expr, str]:
        """The name of every node that has one."""
        return {step.node: step.name for step in self.inputs + self.steps}


@dataclass(frozen=True)
class Program(Shown):
    """The routines of a scene on one graph of their own.

    Attributes:
        scene: the mechanism; its parameters with values are constants here.
        graph: of this program alone; all entries are nodes of it.
        routines: in the order of the equations.
        constants: value of every node without symbols, exact where it is rational, else to 50 digits or more.
        PARAMS, PREPARED: what the arguments are called: free parameters, and what depends on them alone.
        PREPARE: what the function is called that computes these.
    """

    scene: Scene
    graph: Graph
    routines: tuple[Routine, ...]
    constants: Mapping[Expr, Fraction]

    PARAMS: ClassVar[str] = "params"
    PREPARED: ClassVar[str] = "prepared"
    PREPARE: ClassVar[str] = "prepare"

    def __repr__(self) -> str:
        return f"<Program of {self.scene.name}: {listed(one.function.name for one in self.routines)}>"

    def __contains__(self, name: object) -> bool:
        """Tell whether there is a routine called `name`, or asked for by it."""
        return any(name in (routine.function.name, routine.function.request) for routine in self.routines)

    def __getitem__(self, name: str) -> Routine:
        """Return the routine called `name`, or asked for by it; UnknownNameError if there is none."""
        check_arguments(Program.__getitem__, locals(), UnknownNameError)
        for routine in self.routines:
            if name in (routine.function.name, routine.function.request):
                return routine
        raise UnknownNameError(f"no routine {name}; there are {', '.join(r.function.name for r in self.routines)}")

    @property
    def outputs(self) -> tuple[Expr, ...]:
        """Entries of all routines, one routine after the other."""
        return tuple(entry for routine in self.routines for entry in routine.function.entries)

    @property
    def is_prepared(self) -> bool:
        """Whether work on parameters alone is in a function of its own, of whose result the others are functions."""
        return any(
            argument.name == Program.PREPARED for routine in self.routines for argument in routine.function.arguments
        )

    def checked(self) -> Program:
        """Return it after asserting what every pass must keep: names are unique and defined before they are used."""
        for routine in self.routines:
            where = routine.function.name
            names = [step.name for step in routine.inputs + routine.steps]
            assert len(set(names)) == len(names), f"{where}: a name is given twice"
            size = 1
            for length in routine.function.shape:
                size *= length
            there = size if not routine.function.is_loop_alone else 0
            shape = routine.function.shape
            assert len(routine.function.entries) == there, f"{where}: shape {shape} and entries disagree"
            defined = {*self.constants, *(step.node for step in routine.inputs)}
            for step in routine.steps:
                late = _undefined(step.node, defined)
                assert not late, f"{where}: {step.name} needs {late}, which come later or are no arguments"
                defined.add(step.node)
            for entry in routine.function.entries:
                missing = _undefined(entry, defined)
                assert not missing, f"{where} needs {missing}, which are none of its arguments"
        return self


def _undefined(node: Expr, defined: set[Expr]) -> list[Expr]:
    """Return the symbols below `node` that are reached without passing a defined node."""
    found, stack, seen = [], [node], set()
    while stack:
        here = stack.pop()
        if here in defined or here in seen:
            continue
        seen.add(here)
        if here.op is Op.SYMBOL:
            found.append(here)
        stack += here.args
    return found
