"""Routines as functions that read their arguments in memory and leave their results there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from symdyn.emit.code.real import REALS, nearest
from symdyn.emit.targets.wasm.encoding import EMPTY, I32, V128, Body, Signature, at, signed, unsigned
from symdyn.emit.targets.wasm.instructions import BASE, Home, Instructions
from symdyn.emit.targets.wasm.lanes import PAIR, SINGLE, Lanes
from symdyn.emit.targets.wasm.sincos import CHAINS, ROW
from symdyn.graph import Expr, Op
from symdyn.program import ANGULAR, Program, Routine, shared

COUNT, STATE, LAST = "count", "state", "last"
"""Variables of a loop: how many states there are, where the first of a pair stands, where they end."""


@dataclass(frozen=True)
class Columns:
    """Where the numbers of a function stand in memory, in bytes.

    Attributes:
        arguments: of every entry of every argument, in calling order.
        results: of every entry of the result.
        common: nodes of the arguments that all states have in common.
        end: where they end.
    """

    arguments: Mapping[Expr, int]
    results: tuple[int, ...]
    common: frozenset[Expr]
    end: int


def columns(routine: Routine, stride: int) -> Columns:
    """Return columns one after another, `stride` bytes from each to the next."""
    function = routine.function
    name = shared([argument.name for argument in function.arguments])
    symbols = [symbol for argument in function.arguments for symbol in argument.symbols]
    common = frozenset(symbol for one in function.arguments if one.name == name for symbol in one.symbols)
    places = {symbol: stride * number for number, symbol in enumerate(symbols)}
    first = stride * len(symbols)
    end = first + stride * len(function.entries)
    return Columns(places, tuple(range(first, end, stride)), common, end)


class RoutineWriter:
    """Writes one routine, for one state or for pairs of states.

    Attributes:
        work: from where on memory is free for intermediate values; once functions are written, from where on still.
    """

    def __init__(self, program: Program, routine: Routine, calls: Mapping[str, int], work: int) -> None:
        """Write a routine of a program; `calls` are the numbers of functions that do what no instruction does."""
        self.program, self.routine, self.calls, self.work = program, routine, calls, work
        self.names = routine.names
        self.angular = [step for step in routine.steps if step.node.op in ANGULAR]

    def single(self, name: str, where: Columns) -> Body:
        """Return the function of one state."""
        self._begin(SINGLE, where, BASE)
        for step in self.routine.steps:
            self._step(step.node)
        self._results(where, BASE)
        return self._body(name, Signature((I32,), ()), (BASE,), exported=True)

    def batch(self, name: str, where: Columns, number: int) -> list[Body]:
        """Return the function of as many states as its argument says, 1 or more, which go in pairs.

        What they have in common is computed once, by a function that comes before it, as the `number`-th of the module.
        """
        uniform = self._uniform(where)
        places = {node: self.work + 8 * k for k, node in enumerate(uniform)}
        self.work += 8 * len(uniform) + 15 & -16
        bodies = [self._common(f"{name}_common", where, places)] if uniform else []
        code = self._begin(PAIR, where, STATE)
        for node, address in places.items():
            code.stands(self.names[node], V128, Home(PAIR.fill, BASE, address))
            self.done.add(node)
        if uniform:
            code.get(BASE)
            code.add("call", unsigned(number))
        code.get(BASE)
        code.set(STATE, I32)
        code.get(BASE)
        code.get(COUNT)
        code.add("i32.const", signed(8))
        code.add("i32.mul")
        code.add("i32.add")
        code.set(LAST, I32)
        code.add("loop", EMPTY)
        for step in self.routine.steps:
            self._step(step.node)
        self._results(where, STATE)
        code.get(STATE)
        code.add("i32.const", signed(16))
        code.add("i32.add")
        code.set(STATE, I32)
        code.get(STATE)
        code.get(LAST)
        code.add("i32.lt_u")
        code.add("br_if", b"\x00")
        code.add("end")
        return [*bodies, self._body(f"{name}_batch", Signature((I32, I32), ()), (BASE, COUNT), exported=True)]

    def _common(self, name: str, where: Columns, places: Mapping[Expr, int]) -> Body:
        """Return the function of what all states have in common, which leaves each node at its address."""
        code = self._begin(SINGLE, where, BASE)
        for node in places:
            self._step(node)
        for node, address in places.items():
            code.get(BASE)
            self._value(node)
            code.add("f64.store", at(address))
        return self._body(name, Signature((I32,), ()), (BASE,), exported=False)

    def _begin(self, lanes: Lanes, where: Columns, index: str) -> Instructions:
        """Begin a function whose arguments stand beyond an index."""
        self.lanes, self.done = lanes, {step.node for step in self.routine.inputs}
        self.code = Instructions({BASE: I32, COUNT: I32})
        for step in self.routine.inputs:
            common = step.node in where.common
            home = Home(lanes.fill if common else lanes.load, BASE if common else index, where.arguments[step.node])
            self.code.stands(step.name, lanes.kind, home)
        return self.code

    def _body(self, name: str, signature: Signature, arguments: tuple[str, ...], exported: bool) -> Body:
        code, self.work = self.code.held(self.lanes.kind, self.lanes.load, self.lanes.store, self.work)
        variables, encoded = code.encoded(signature, arguments, (STATE, LAST))
        return Body(name, signature, variables, encoded, exported)

    def _uniform(self, where: Columns) -> list[Expr]:
        """Return the steps whose value all states have in common."""
        found: dict[Expr, None] = {}
        for step in self.routine.steps:
            if all(leaf in found or leaf in where.common for leaf in self._leaves(step.node)):
                found[step.node] = None
        return list(found)

    def _leaves(self, node: Expr) -> Iterator[Expr]:
        """Yield the named nodes that an operation is computed from."""
        for arg in node.args:
            if arg in self.names:
                yield arg
            elif arg not in self.program.constants:
                yield from self._leaves(arg)

    def _step(self, node: Expr) -> None:
        """Write what gives a step its name, unless it was done together with an earlier one."""
        if node in self.done:
            return
        if node.op in ANGULAR:
            self._angles([node.args[0], *self._others(node.args[0])])
        else:
            self._operation(node)
            self.code.set(self.names[node], self.lanes.kind)
            self.done.add(node)

    def _angles(self, angles: list[Expr]) -> None:
        """Write the call for some angles, as many as it takes or fewer."""
        code, taken = self.code, self.lanes.angles
        code.get(BASE)
        code.add("i32.const", signed(self.work))
        code.add("i32.add")
        for number in range(taken * CHAINS):
            self._value(angles[number] if number < len(angles) else angles[0])
            if self.lanes is SINGLE:
                code.add(*(("f64x2.replace_lane", b"\x01") if number % 2 else ("f64x2.splat",)))
        code.add("call", unsigned(self.calls["sincos"]))
        for step in self.angular:
            if step.node.args[0] in angles:
                number = angles.index(step.node.args[0])
                address = self.work + 2 * ROW * (number // taken) + 8 * (number % taken)
                address += ROW if step.node.op is Op.COS else 0
                code.stands(step.name, self.lanes.kind, Home(self.lanes.load, BASE, address))
                self.done.add(step.node)
        self.work += 2 * ROW * CHAINS

    def _others(self, angle: Expr) -> list[Expr]:
        """Return the next angles that can be taken together with one."""
        found: dict[Expr, None] = {}
        for step in self.angular:
            other = step.node.args[0]
            if step.node not in self.done and other is not angle:
                leaves = [other] if other in self.names else self._leaves(other)
                if all(leaf in self.done for leaf in leaves):
                    found[other] = None
        return list(found)[: self.lanes.angles * CHAINS - 1]

    def _results(self, where: Columns, index: str) -> None:
        """Write what leaves the result in memory."""
        for entry, address in zip(self.routine.function.entries, where.results, strict=True):
            self.code.get(index)
            self._value(entry)
            self.code.add(self.lanes.store, at(address))

    def _value(self, node: Expr) -> None:
        """Put the value of a node on the stack."""
        if node in self.program.constants:
            self.code.items.append(self.lanes.constant(nearest(self.program.constants[node], REALS["double"])))
        elif node in self.names:
            self.code.get(self.names[node])
        else:
            self._operation(node)

    def _operation(self, node: Expr) -> None:
        """Put what a node computes from its operands on the stack."""
        for arg in node.args:
            self._value(arg)
        if node.op in self.lanes.plain:
            self.code.add(self.lanes.plain[node.op])
        else:
            self.code.add("call", unsigned(self.calls[node.op.name.lower() + self.lanes.ending]))
