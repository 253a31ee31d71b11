"""Instructions with variables by name, and the places that these get.

Engines order what has no effect as they like, by how far it is from the end, and then have to move hundreds of values
between registers and stack. So every value is stored as it is computed, which keeps all in the order of the program,
and of too many that one goes which is needed last (Belady's rule); it is loaded again where it is needed.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

from symdyn.emit.targets.wasm.encoding import Signature, at, instruction, unsigned

REGISTERS = 13
"""Values that are held at a time: processors have 16 registers, and a sum takes some on its way."""

BASE = "base"
"""The argument that comes first: from which address on memory is used."""


@dataclass(frozen=True)
class Variable:
    """A read of a variable, or a write."""

    name: str
    write: bool


@dataclass(frozen=True)
class Home:
    """Where a variable stands in memory: at an address beyond that in a variable, and how it is loaded from there."""

    load: str
    index: str
    address: int


@dataclass
class Instructions:
    """Instructions in order, to which more are added.

    Attributes:
        types: of the variables, by name.
        items: bytes, or reads and writes of variables.
        homes: of variables that stand in memory from the beginning.
    """

    types: dict[str, bytes]
    items: list[bytes | Variable] = field(default_factory=list)
    homes: dict[str, Home] = field(default_factory=dict)

    def add(self, name: str, *immediates: bytes) -> None:
        """Add an instruction that has nothing to do with variables."""
        self.items.append(instruction(name, *immediates))

    def get(self, name: str) -> None:
        """Put the value of a variable on the stack."""
        assert name in self.types, f"{name} is read before it is written"
        self.items.append(Variable(name, False))

    def set(self, name: str, kind: bytes) -> None:
        """Take the value of a variable from the stack."""
        self.types[name] = kind
        self.items.append(Variable(name, True))

    def stands(self, name: str, kind: bytes, home: Home) -> None:
        """Say where a variable stands in memory."""
        self.types[name] = kind
        self.homes[name] = home

    def held(self, kind: bytes, load: str, store: str, start: int) -> tuple[Instructions, int]:
        """Return instructions that hold few values of a type at a time, and the end of the memory that they take.

        Every value is stored from address `start` on, unless it stands in memory anyway.
        """
        return _Holder(self, kind, load, store, start).made()

    def encoded(
        self, signature: Signature, arguments: Sequence[str], kept: Collection[str] = ()
    ) -> tuple[tuple[bytes, ...], bytes]:
        """Return the types of the variables behind the arguments, and the code.

        Args:
            signature: of the function.
            arguments: names of its arguments, which come first in the count of variables.
            kept: variables whose places are never used again, since a loop reads them in its next turn.
        """
        last = {item.name: k for k, item in enumerate(self.items) if isinstance(item, Variable)}
        last |= dict.fromkeys(kept, len(self.items))
        places = {name: number for number, name in enumerate(arguments)}
        free: dict[bytes, list[int]] = {}
        kinds = list(signature.takes)
        code: list[bytes] = []
        for k, item in enumerate(self.items):
            if isinstance(item, bytes):
                code.append(item)
                continue
            if item.name not in places:
                kind = self.types[item.name]
                if not free.setdefault(kind, []):
                    free[kind].append(len(kinds))
                    kinds.append(kind)
                places[item.name] = free[kind].pop()
            place = unsigned(places[item.name])
            ends = k == last[item.name]  # its value is not needed any more
            if ends and item.name not in arguments:
                free[self.types[item.name]].append(places[item.name])
            if item.write and ends:
                code.append(instruction("drop"))
            elif item.write and self.items[k + 1] == Variable(item.name, False):
                code.append(b"" if last[item.name] == k + 1 else instruction("local.tee", place))
            elif item.write or self.items[k - 1] != Variable(item.name, True):
                code.append(instruction("local.set" if item.write else "local.get", place))
            # else it is on the stack still
        return tuple(kinds[len(arguments) :]), b"".join(code)


class _Holder:
    """Goes through instructions once; `held` has, by name, what a value is called while it is held."""

    def __init__(self, code: Instructions, kind: bytes, load: str, store: str, start: int) -> None:
        self.code, self.kind, self.load, self.store, self.end = code, kind, load, store, start
        self.result = Instructions(dict(code.types))
        self.homes = dict(code.homes)
        self.held: dict[str, str] = {}
        self.free: list[int] = []
        self.reads: dict[str, list[int]] = {}
        for k, item in enumerate(code.items):
            if isinstance(item, Variable) and not item.write:
                self.reads.setdefault(item.name, []).append(k)

    def made(self) -> tuple[Instructions, int]:
        """Return the instructions, and the end of memory."""
        for k, item in enumerate(self.code.items):
            if isinstance(item, bytes) or self.code.types[item.name] != self.kind:
                self.result.items.append(item)
            elif item.write:
                self._write(item.name, k)
            else:
                self._read(item.name, k)
        return self.result, self.end

    def _after(self, name: str, k: int) -> int:
        """Return where a variable is read next, behind all instructions if it is not."""
        later = self.reads.get(name, [])
        place = bisect_right(later, k)
        return later[place] if place < len(later) else len(self.code.items)

    def _hold(self, name: str, k: int) -> None:
        """Take the value on the stack as that of a variable, while others go."""
        for other in [other for other in self.held if self._after(other, k) == len(self.code.items)]:
            del self.held[other]
        if len(self.held) >= REGISTERS:
            del self.held[max(self.held, key=lambda other: self._after(other, k))]
        self.held[name] = f"{name} {k}"
        self.result.set(self.held[name], self.kind)

    def _write(self, name: str, k: int) -> None:
        self._hold(name, k)
        if self._after(name, k) < len(self.code.items):
            if not self.free:
                self.free.append(self.end)
                self.end += 16
            self.homes[name] = Home(self.load, BASE, self.free.pop())
            self.result.get(BASE)
            self.result.get(self.held[name])
            self.result.add(self.store, at(self.homes[name].address))

    def _read(self, name: str, k: int) -> None:
        home = self.homes[name]
        if name not in self.held:
            self.result.get(home.index)
            self.result.add(home.load, at(home.address))
            self._hold(name, k)
        self.result.get(self.held[name])
        if self._after(name, k) == len(self.code.items) and name not in self.code.homes:
            self.free.append(home.address)
