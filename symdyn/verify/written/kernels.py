"""The meaning of kernels for CUDA and OpenCL: one state a thread, entry i of state k at [i * n + k].

The arrays of a kernel do not overlap, which `restrict` promises to the compiler and a comment to the caller. What a
thread begins with, its number k and that there is nothing to do from n on, is read word by word.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

from symdyn.graph import Expr, Op
from symdyn.verify.written.c import definitions
from symdyn.verify.written.c_family import MATH, CFile, CReader, blanked, parameters
from symdyn.verify.written.memory import Fault, Index, Pointer, Work
from symdyn.verify.written.reading import ReadLanguage, Text, TextReading, kinds, line_of, spaced, text_of, unread
from symdyn.verify.written.straight_line import Value, takes

if TYPE_CHECKING:
    from tree_sitter import Node

C, CUDA_GRAMMAR = "tree_sitter_c", "tree_sitter_cuda"

UNKNOWN = re.compile(rb"\b(__kernel|__global|__local|__constant)\b")
"""What a grammar of C knows nothing of: where arrays are."""

STARTS = {
    CUDA_GRAMMAR: "const size_t k = (size_t)blockIdx.x * blockDim.x + threadIdx.x;",
    C: "const ulong k = get_global_id(0);",
}
"""How a thread learns which state is its own."""

BEYOND = "if (k >= n) { return; }"

PLACES = {
    CUDA_GRAMMAR: re.compile(r"__shared__ volatile (\w+) waiting_places\[(\d+) \* (\d+)\];"),
    C: re.compile(r"volatile (\w+) waiting_places\[(\d+) \* (\d+)\];"),
}
"""Places in memory of the block, so many for each of so many threads."""

BLOCK = {CUDA_GRAMMAR: "__launch_bounds__({})", C: "__attribute__((reqd_work_group_size({}, 1, 1)))"}
"""What stands before a kernel whose blocks have no more threads than there are places for."""

OWN = {
    CUDA_GRAMMAR: "volatile {} *const waiting = waiting_places + threadIdx.x;",
    C: "volatile {} *const waiting = waiting_places + get_local_id(0);",
}
"""Where those of a thread begin."""


PARTS = {
    CUDA_GRAMMAR: re.compile(r"for \(unsigned part = blockIdx\.y; part < (\d+); part \+= gridDim\.y\)"),
    C: re.compile(r"for \(uint part = get_group_id\(1\); part < (\d+); part \+= get_num_groups\(1\)\)"),
}
"""Every part is computed by one row of blocks, however many rows there are."""


def read(text: Text, grammar: str) -> TextReading:
    """Return what the kernels of a file compute."""
    file = CFile(text, definitions(text.root), grammar=grammar)
    functions = []
    for wanted in text.expected:
        name = f"{text.stem}_{wanted.name}"
        if name in file.functions:
            node, reader = file.functions[name], KernelStatements(file, wanted)
            takes(node, parameters(node), ["n", *wanted.arguments, "out"])
            result = reader.open(columns=True, apart=True)
            reader.names["n"] = Index(0, 0, 1)
            reader.body(name)
            if reader.begun != len(BEGINNING):
                raise unread(node, "does not begin with the number of its state")
            reader.bounded(node)
            functions.append(reader.finished(name, node, result))
    return TextReading(tuple(functions), tuple(file.cuts.values()))


BEGINNING = ("declaration", "if_statement")


@dataclass
class KernelStatements(CReader):
    """What only kernels say: which state is theirs, and both sines of an angle at once."""

    begun: int = 0
    waiting: set[str] = field(default_factory=set)
    threads: int = 0
    size: int = 0
    divided: bool = False

    def statement(self, node: Node) -> None:
        if self.begun == len(BEGINNING):
            if node.type == "for_statement":
                self.parts(node)
            elif not self.places(node):
                super().statement(node)
            return
        expected = (STARTS[self.file.grammar], BEYOND)[self.begun]
        if spaced(node) != expected:
            raise unread(node, f"is not {expected}")
        self.begun += 1
        if self.begun == len(BEGINNING):
            self.names["k"] = Index(0, 1)

    def places(self, node: Node) -> bool:
        """Read where values wait, if that is said here; each thread has every so many-th place."""
        words = spaced(node)
        found = PLACES[self.file.grammar].fullmatch(words)
        if found and found[1] == self.real_word and not self.threads and "waiting" not in self.names:
            self.threads, self.size = int(found[3]), int(found[2]) * int(found[3])
            self.arrays["waiting"] = words
            return self.threads > 0
        if self.threads and "waiting" not in self.names and words == OWN[self.file.grammar].format(self.real_word):
            self.names["waiting"] = Pointer(Places(self.size, self.threads))
            return True
        return False

    def parts(self, node: Node) -> None:
        """Read parts, each a block of its own that finds nothing in the names and places of another one."""
        body = node.children[-1]
        found = PARTS[self.file.grammar].fullmatch(spaced(node).partition(" {")[0])
        if self.divided or not found or body.type != "compound_statement" or len(body.children) != int(found[1]) + 2:
            raise unread(node, "is no loop over the parts of a kernel")
        self.divided, before = True, dict(self.names)
        for number, part in enumerate(body.children[1:-1]):
            words = spaced(part).partition(" {")[0]
            if kinds(part.children)[::2] != ["if", "compound_statement"] or words != f"if (part == {number})":
                raise unread(part, f"is not part {number} of the kernel")
            if self.threads:
                before["waiting"] = Pointer(Places(self.size, self.threads))
            self.names = dict(before)
            self.block(part.children[2])
        self.names = before

    def bounded(self, node: Node) -> None:
        """Refuse a kernel whose values wait, if its blocks may have more threads than there are places for."""
        bound = BLOCK[self.file.grammar].format(self.threads)
        if self.threads and bound not in [spaced(one) for one in node.children]:
            raise unread(node, f"has places for blocks of {self.threads} threads, and not {bound}")

    def function_of(self, name: str) -> Op | None:
        """Return which operation a function is, None if none; OpenCL has one name for all types."""
        if self.file.grammar == CUDA_GRAMMAR or name in self.file.functions:
            return super().function_of(name)
        return MATH.get(name)

    def declare_array(self, node: Node) -> None:
        """Read `double c1;`, which a call of sincos will set."""
        if node.type != "identifier":
            raise unread(node, "is no declaration that is read here")
        self.set(node, Pointer(Work(1)))
        self.waiting.add(text_of(node))

    def name(self, node: Node) -> Value:
        """Return what a name stands for; what waits for sincos has no value before."""
        value = super().name(node)
        if isinstance(value, Pointer) and type(value.memory) is Work:
            return value.load(Index(0))
        return value

    def address(self, node: Node) -> Value:
        """Return where a number will be set."""
        operator, operand = node.children
        if operator.type != "&" or text_of(operand) not in self.waiting:
            raise unread(node, "is not the address of a number that waits for a value")
        self.waiting.remove(text_of(operand))
        return self.names[text_of(operand)]

    def perform(self, node: Node) -> None:
        """Read `sincos(q_1, &s1, &c1)` of CUDA."""
        name = "sincosf" if self.file.text.real == "float" else "sincos"
        callee, given = self.call(node)
        if self.file.grammar != CUDA_GRAMMAR or text_of(callee) != name or len(given) != 3:
            super().perform(node)
            return
        angle = self.real(given[0])
        self._let(given[1], Op.SIN, angle)
        self._let(given[2], Op.COS, angle)

    def _let(self, node: Node, op: Op, angle: Expr) -> None:
        """Let a number that waits for it be the sine or the cosine of an angle."""
        number = self.value(node)
        if not isinstance(number, Pointer):
            raise unread(node, "sets no number")
        number.store(Index(0), self.file.text.graph.function(op, angle), line_of(node))

    def called(self, node: Node) -> Value:
        """Return the value of a call; sincos of OpenCL returns the sine and sets the cosine, symdyn_again(n) is n."""
        if text_of(node.children[0]) == "symdyn_again" and "symdyn_again" in self.file.functions:
            return self.value(*self.call(node)[1])
        if self.file.grammar == CUDA_GRAMMAR or text_of(node.children[0]) != "sincos":
            return super().called(node)
        _, given = self.call(node)
        if len(given) != 2:
            raise unread(node, "has another number of arguments")
        angle = self.real(given[0])
        self._let(given[1], Op.COS, angle)
        return self.file.text.graph.sin(angle)


class Places(Work):
    """Memory of a block as one of its threads has it: place p is p times as many entries on as there are threads."""

    def __init__(self, size: int, threads: int) -> None:
        """Have `size` entries, those of all threads."""
        super().__init__(size)
        self.threads = threads

    def _place(self, index: Index) -> int:
        place = super()._place(index)
        if place % self.threads:
            raise Fault(f"is entry {place} of the block, which another of its {self.threads} threads has")
        return place


CUDA = ReadLanguage("CUDA", CUDA_GRAMMAR, partial(read, grammar=CUDA_GRAMMAR))
OPENCL = ReadLanguage("OpenCL", C, partial(read, grammar=C), partial(blanked, unknown=UNKNOWN))
