"""How operations are written for one state and for two states side by side."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from symdyn.emit.targets.wasm.encoding import F64, V128, Body, Signature, instruction, real, unsigned
from symdyn.emit.targets.wasm.instructions import Instructions
from symdyn.graph import Op

ONE, TWO = Signature((F64,), (F64,)), Signature((F64, F64), (F64,))

IMPORTED: Mapping[Op, tuple[str, Signature]] = {
    Op.SIN: ("sin", ONE),
    Op.COS: ("cos", ONE),
    Op.EXP: ("exp", ONE),
    Op.LOG: ("log", ONE),
    Op.TANH: ("tanh", ONE),
    Op.SIGN: ("sign", ONE),
    Op.ATAN2: ("atan2", TWO),
}
"""What WebAssembly has no instruction for, by its name in JavaScript's Math."""


@dataclass(frozen=True)
class Lanes:
    """One row: how many states go side by side, and the instructions for them.

    Attributes:
        kind: type of a value.
        plain: the instruction of an operation that there is one for.
        load, store: entries of memory.
        fill: loads one entry for all states.
        angles: how many angles of one state a vector takes.
        ending: of the names of functions that do the rest.
    """

    kind: bytes
    plain: Mapping[Op, str]
    load: str
    store: str
    fill: str
    angles: int
    ending: str

    def constant(self, value: float) -> bytes:
        """Return what puts a number on the stack, for all states the same."""
        single = instruction("f64.const", real(value))
        return single if self.kind == F64 else single + instruction("f64x2.splat")


def _plain(shape: str) -> Mapping[Op, str]:
    named = {op: op.name.lower() for op in (Op.ADD, Op.SUB, Op.MUL, Op.DIV, Op.NEG, Op.SQRT, Op.ABS)}
    return {op: f"{shape}.{name}" for op, name in named.items()}


SINGLE = Lanes(F64, _plain("f64"), "f64.load", "f64.store", "f64.load", 2, "")
PAIR = Lanes(V128, _plain("f64x2"), "v128.load", "v128.store", "v128.load64_splat", 1, "_pair")


def pair_of(op: Op, number: int) -> Body:
    """Return the function that calls an imported one, which is the `number`-th, for each of two states."""
    name, single = IMPORTED[op]
    arguments = tuple(f"x{k}" for k, _ in enumerate(single.takes))
    code, signature = Instructions(dict.fromkeys(arguments, V128)), Signature((V128,) * len(arguments), (V128,))
    for lane in (0, 1):
        for argument in arguments:
            code.get(argument)
            code.add("f64x2.extract_lane", bytes([lane]))
        code.add("call", unsigned(number))
        if lane:
            code.add("f64x2.replace_lane", bytes([lane]))
        else:
            code.add("f64x2.splat")
    variables, encoded = code.encoded(signature, arguments)
    return Body(f"{name}_pair", signature, variables, encoded, exported=False)
