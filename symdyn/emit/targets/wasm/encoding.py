"""WebAssembly in bytes: numbers, instructions, functions and the sections of a module.

Source: WebAssembly Core Specification 2.0, chapter 5 (binary format), with its vector instructions (SIMD 128).
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

I32, F64, V128 = b"\x7f", b"\x7c", b"\x7b"
"""Types of values."""

EMPTY = b"\x40"
"""The type of a block without a result."""

PAGE = 65_536
"""Bytes of a page of memory."""

MAGIC = b"\x00asm\x01\x00\x00\x00"

PLAIN: Mapping[str, int] = {
    "loop": 0x03,
    "if": 0x04,
    "end": 0x0B,
    "br_if": 0x0D,
    "call": 0x10,
    "drop": 0x1A,
    "local.get": 0x20,
    "local.set": 0x21,
    "local.tee": 0x22,
    "f64.load": 0x2B,
    "f64.store": 0x39,
    "i32.const": 0x41,
    "f64.const": 0x44,
    "i32.eqz": 0x45,
    "i32.ne": 0x47,
    "i32.lt_u": 0x49,
    "f64.lt": 0x63,
    "i32.add": 0x6A,
    "i32.mul": 0x6C,
    "f64.abs": 0x99,
    "f64.neg": 0x9A,
    "f64.sqrt": 0x9F,
    "f64.add": 0xA0,
    "f64.sub": 0xA1,
    "f64.mul": 0xA2,
    "f64.div": 0xA3,
}

VECTOR: Mapping[str, int] = {
    "v128.load": 0x00,
    "v128.load64_splat": 0x0A,
    "v128.store": 0x0B,
    "v128.const": 0x0C,
    "f64x2.splat": 0x14,
    "f64x2.extract_lane": 0x21,
    "f64x2.replace_lane": 0x22,
    "f64x2.lt": 0x49,
    "v128.and": 0x4E,
    "v128.xor": 0x51,
    "i64x2.bitmask": 0xC4,
    "i64x2.shl": 0xCB,
    "i64x2.sub": 0xD1,
    "f64x2.abs": 0xEC,
    "f64x2.neg": 0xED,
    "f64x2.sqrt": 0xEF,
    "f64x2.add": 0xF0,
    "f64x2.sub": 0xF1,
    "f64x2.mul": 0xF2,
    "f64x2.div": 0xF3,
}
"""These follow the prefix FD."""


def unsigned(number: int) -> bytes:
    """Return a number of 0 or more in LEB128: seven bits a byte, the lowest first."""
    low, rest = number & 0x7F, number >> 7
    return bytes([low | 0x80]) + unsigned(rest) if rest else bytes([low])


def signed(number: int) -> bytes:
    """Return a number in signed LEB128."""
    low, rest = number & 0x7F, number >> 7
    last = rest == (-1 if low & 0x40 else 0)
    return bytes([low]) if last else bytes([low | 0x80]) + signed(rest)


def real(number: float) -> bytes:
    """Return the eight bytes of a double."""
    return struct.pack("<d", number)


def instruction(name: str, *immediates: bytes) -> bytes:
    """Return one instruction with what stands behind it."""
    code = bytes([PLAIN[name]]) if name in PLAIN else b"\xfd" + unsigned(VECTOR[name])
    return b"".join((code, *immediates))


def at(offset: int, align: int = 3) -> bytes:
    """Return what stands behind a load or a store: the alignment, as a power of two, and the address to be added."""
    return unsigned(align) + unsigned(offset)


def vector(items: Sequence[bytes]) -> bytes:
    """Return items behind their number."""
    return unsigned(len(items)) + b"".join(items)


def sized(contents: bytes) -> bytes:
    """Return bytes behind their number."""
    return unsigned(len(contents)) + contents


@dataclass(frozen=True)
class Signature:
    """Types of what a function takes and returns."""

    takes: tuple[bytes, ...]
    returns: tuple[bytes, ...]

    @property
    def encoded(self) -> bytes:
        """Its bytes."""
        return b"\x60" + vector(self.takes) + vector(self.returns)


@dataclass(frozen=True)
class Body:
    """One function.

    Attributes:
        name: how others call it.
        signature: its types.
        variables: types of its variables behind the arguments.
        code: its instructions without the last `end`.
        exported: whether it can be called from outside, by its name.
    """

    name: str
    signature: Signature
    variables: tuple[bytes, ...]
    code: bytes
    exported: bool

    @property
    def encoded(self) -> bytes:
        """Its bytes, behind their number."""
        runs: list[tuple[int, bytes]] = []
        for kind in self.variables:
            if runs and runs[-1][1] == kind:
                runs[-1] = (runs[-1][0] + 1, kind)
            else:
                runs.append((1, kind))
        variables = vector([unsigned(count) + kind for count, kind in runs])
        return sized(variables + self.code + instruction("end"))


def module(imported: Sequence[tuple[str, Signature]], bodies: Sequence[Body], memory: int, made_by: str) -> bytes:
    """Return a module.

    Args:
        imported: functions of the import module "Math", which come first in the count of functions.
        bodies: the others.
        memory: bytes of memory, which is exported as "memory".
        made_by: a text for who opens the file, in a section "made by" that no program reads.
    """
    signatures = list(dict.fromkeys([one for _, one in imported] + [body.signature for body in bodies]))
    place = {signature: unsigned(number) for number, signature in enumerate(signatures)}
    exports = [_name("memory") + b"\x02\x00"]
    for number, body in enumerate(bodies, len(imported)):
        exports += [_name(body.name) + b"\x00" + unsigned(number)] if body.exported else []
    sections = [
        (1, vector([signature.encoded for signature in signatures])),
        (2, vector([_name("Math") + _name(name) + b"\x00" + place[signature] for name, signature in imported])),
        (3, vector([place[body.signature] for body in bodies])),
        (5, vector([b"\x01" + 2 * unsigned(-(-memory // PAGE))])),
        (7, vector(exports)),
        (10, vector([body.encoded for body in bodies])),
        (0, _name("made by") + made_by.encode()),
    ]
    return MAGIC + b"".join(bytes([number]) + sized(contents) for number, contents in sections)


def _name(text: str) -> bytes:
    return sized(text.encode())
