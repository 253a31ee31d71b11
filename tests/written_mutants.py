"""Faults planted into written files, one token at a time, to see whether reading them back finds each one.

    python tests/written_mutants.py puma560 --target c --every 10 [--option batch] [--prepare]

Every tenth token is changed: an operator for another, a digit, a name for the one used before it, an index by one, a
sign, or it is dropped or doubled; which of these, goes round from token to token. A mutant that is proved in spite of
it must be the same program: it is compiled (C, C++ and kernels: the same object code, byte for byte), else run at 1,000
states beside the file (the same results, bit for bit). If it is not, it was missed. Comments are left out.
"""

from __future__ import annotations

import argparse
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path, PurePath
from typing import Any

import numpy as np

import symdyn
from symdyn.emit import Sources, emit
from symdyn.errors import SymdynError
from symdyn.program import Program, prepare as prepare_program
from symdyn.runtime import RUNNERS
from symdyn.verify.building import files_of
from symdyn.verify.written import READERS, languages, printed, prove_texts
from symdyn.verify.written.proof import read_text
from symdyn.verify.written.reading import ReadLanguage, parse

STATES = 1000

Spans = list[tuple[int, int]] | None

SWAPS = {"+": "-", "-": "+", "*": "/", "/": "*", "=": "==", "<": "<=", ".*": "./", "./": ".*", "(": "[", ")": "]"}
WORDS = {"sin": "cos", "cos": "sin", "sqrt": "fabs", "const": "", "double": "float", "size_t": "int", "let": "var"}


@dataclass(frozen=True)
class Mutant:
    """A file with one token changed.

    Attributes:
        file: its name.
        line: of the token.
        change: what was done, in words.
        text: all of it.
    """

    file: str
    line: int
    change: str
    text: str


def tokens(source: bytes, language: ReadLanguage) -> Iterator[tuple[int, int, int]]:
    """Yield start, end and line of every token that is no comment; -1 as a line for one in a comment."""
    stack = [parse(language.grammar, language.plain(source))]
    while stack:
        node = stack.pop()
        if node.type in language.comments:
            yield from ((node.start_byte, node.end_byte, -1) for _ in (node.text or b"").split())
        elif node.children:
            stack += reversed(node.children)
        elif node.end_byte > node.start_byte:
            yield node.start_byte, node.end_byte, node.start_point[0] + 1


def mutants(file: str, text: str, language: ReadLanguage, every: int, inside: Spans) -> tuple[list[Mutant], int]:
    """Return a mutant of every so many tokens, and how many were left out since they are comments.

    Of tokens `inside` these parts of the file alone, where they are not None.
    """
    source, found, silent, count = text.encode(), [], 0, 0
    other = b"x1"
    for start, end, line in tokens(source, language):
        if inside is not None and not any(first <= start and end <= last for first, last in inside):
            continue
        old, count = source[start:end], count + 1
        if count % every == 0:
            if line < 0:
                silent += 1
                continue
            kind, new = changed(old, other, count // every)
            mutated = source[:start] + new + source[end:]
            found.append(Mutant(file, line, f"{kind} {old.decode()!r} -> {new.decode()!r}", mutated.decode()))
        if old.decode().isidentifier():
            other = old
    return found, silent


def changed(old: bytes, other: bytes, turn: int) -> tuple[str, bytes]:
    """Return one way to change a token, and what it becomes."""
    word = old.decode()
    ways: list[tuple[str, str]] = []
    if word in SWAPS:
        ways.append(("operator", SWAPS[word]))
    if word[0].isdigit():
        ways += [("digit", _digit(word, turn)), ("sign", f"-{word}")]
        if word.isdigit():
            ways.append(("index", str(int(word) + 1)))
    if word.isidentifier():
        ways += [("name", other.decode()), ("name", WORDS.get(word, f"{word}_"))]
    ways += [("dropped", ""), ("doubled", f"{word} {word}")]
    kind, new = ways[turn % len(ways)]
    return kind, new.encode()


def _digit(word: str, turn: int) -> str:
    places = [place for place, letter in enumerate(word) if letter.isdigit()]
    place = places[turn % len(places)]
    return f"{word[:place]}{(int(word[place]) + 1) % 10}{word[place + 1 :]}"


@dataclass
class Score:
    """What became of the mutants of one file."""

    caught: int = 0
    same: int = 0
    comments: int = 0
    missed: tuple[Mutant, ...] = ()


def score(program: Program, target: str, every: int, option: str = "", first: int | None = None) -> Score:
    """Return what became of the mutants of a program's files, or of about `first` of them, spread over all.

    Functions are written one by one, each with the fixed text around it, whose tokens are changed once.
    """
    alone = [replace(program, routines=(routine,)) for routine in program.routines]
    total = Score()
    for place, one in enumerate([program] if program.is_prepared else alone):
        sources = emit(one, target, option=option)
        planted, silent = _planted(sources, every, with_fixed_text=place == 0)
        total.comments += silent
        step = 1 if first is None else max(1, len(planted) * len(program.routines) // first)
        files, numbers = files_of(sources), printed(one, sources.real)
        fresh = dict(files.contents)
        for mutant in planted[place % step :: step]:
            if mutant.text == fresh[mutant.file]:
                continue
            mutated = replace(files, contents={**fresh, mutant.file: mutant.text})
            if not all(found.passed for found in prove_texts(numbers, mutated, languages(target, option), fresh)):
                total.caught += 1
            elif same(sources, mutant):
                total.same += 1
            else:
                total.missed += (mutant,)
    return total


def _planted(sources: Sources, every: int, with_fixed_text: bool) -> tuple[list[Mutant], int]:
    """Return the mutants of all files, and how many tokens of comments were left out."""
    files, numbers, found, silent = files_of(sources), printed(sources.program, sources.real), [], 0
    for file, contents in sources.texts.items():
        language = languages(sources.target, sources.option).get(PurePath(file).suffix)
        if language is not None:
            reading, _ = read_text(numbers, files, contents.encode(), language)
            inside = None if with_fixed_text else [(cut.start, cut.end) for cut in reading.cuts]
            more, comments = mutants(file, contents, language, every, inside)
            found += more
            silent += comments
    return found, silent


def same(sources: Sources, mutant: Mutant) -> bool:
    """Tell whether a mutant is the same program as its file, as far as a compiler, or 1,000 states, can tell."""
    ending = PurePath(mutant.file).suffix
    if ending in COMPILERS:
        before, after = (COMPILERS[ending](sources, mutant.file, text) for text in (sources[mutant.file], mutant.text))
        if before is not None and before == after:
            return True
    try:
        files = tuple((name, mutant.text if name == mutant.file else text) for name, text in sources.files)
        old, new = (RUNNERS[sources.target].run(one) for one in (sources, replace(sources, files=files)))
        return all(
            _same_results(getattr(old, name), getattr(new, name), k, sources)
            for k, name in enumerate(sources.functions)
        )
    except (SymdynError, ArithmeticError, AttributeError, KeyError, TypeError, ValueError):
        return False


def _same_results(old: Callable[..., Any], new: Callable[..., Any], place: int, sources: Sources) -> bool:
    rng = np.random.default_rng(1)
    function = sources.program.routines[place].function
    for _ in range(STATES):
        state = [
            float(rng.uniform(-2, 2)) if argument.scalar else rng.uniform(-2, 2, len(argument.symbols))
            for argument in function.arguments
        ]
        if np.asarray(old(*state)).tobytes() != np.asarray(new(*state)).tobytes():
            return False
    return True


def _object_of_c(sources: Sources, file: str, text: str | bytes) -> bytes | None:
    """Return the object code of C, None where it does not compile."""
    return _object(sources, file, str(text), [shutil.which("gcc") or "cc", "-std=c99"], ".c", "")


def _object_of_cpp(sources: Sources, file: str, text: str | bytes) -> bytes | None:
    """Return the object code of every function of a C++ header for doubles, None where it does not compile."""
    calls = []
    for name, routine in zip(sources.functions, sources.program.routines, strict=True):
        types = ["double" if a.scalar else "const double *" for a in routine.function.arguments]
        calls.append(f"template void {PurePath(file).stem}::raw::{name}<double>({', '.join([*types, 'double *'])});")
    return _object(sources, file, str(text), [shutil.which("g++") or "c++", "-std=c++17"], ".cpp", "\n".join(calls))


def _object_of_cuda(sources: Sources, file: str, text: str | bytes) -> bytes | None:
    """Return the object code of kernels as C++, for which CUDA's words mean nothing."""
    return _object(sources, file, str(text), [shutil.which("g++") or "c++"], ".cpp", "", CUDA)


def _object_of_opencl(sources: Sources, file: str, text: str | bytes) -> bytes | None:
    """Return the code of OpenCL kernels, None where clang does not compile it."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "main.cl").write_text(str(text), encoding="utf-8")
        words = [shutil.which("clang") or "clang", "-O2", "-w", "-cl-std=CL1.2", "-Xclang", "-finclude-default-header"]
        target = ["-target", "spir64-unknown-unknown", "-emit-llvm", "-S", "main.cl", "-o", "main.ll"]
        ran = subprocess.run([*words, *target], cwd=folder, capture_output=True, check=False)
        return Path(folder, "main.ll").read_bytes() if ran.returncode == 0 else None


CUDA = """#include <cmath>
#include <cstddef>
#define __global__
#define __device__
#define __forceinline__ inline
#define __launch_bounds__(n)
#define __restrict__ __restrict
struct Place { unsigned x; };
extern Place blockIdx, blockDim, threadIdx;
"""


@cache
def _of_octave() -> tuple[str, ...]:
    """Return flags that find the headers of MEX, if Octave is there with its own."""
    mkoctfile = shutil.which("mkoctfile")
    if mkoctfile is None:
        return ()
    told = subprocess.run([mkoctfile, "-p", "INCFLAGS"], capture_output=True, text=True, check=False)
    return tuple(shlex.split(told.stdout))


def _object(
    sources: Sources, file: str, text: str, compiler: list[str], ending: str, after: str, before: str = ""
) -> bytes | None:
    with tempfile.TemporaryDirectory() as folder:
        for name, contents in sources.texts.items():
            path = Path(folder, name)
            path.parent.mkdir(exist_ok=True)
            path.write_text(text if name == file else contents, encoding="utf-8")
        main = Path(folder, f"main{ending}")
        main.write_text(f'{before}#include "{file}"\n{after}\n', encoding="utf-8")
        words = [*compiler, *_of_octave(), "-O2", "-w", "-fkeep-inline-functions", "-c", main.name, "-o", "main.o"]
        ran = subprocess.run(words, cwd=folder, capture_output=True, check=False)
        return Path(folder, "main.o").read_bytes() if ran.returncode == 0 else None


COMPILERS: dict[str, Callable[[Sources, str, str | bytes], bytes | None]] = {
    ".c": _object_of_c,
    ".h": _object_of_c,
    ".hpp": _object_of_cpp,
    ".cu": _object_of_cuda,
    ".cl": _object_of_opencl,
}


def main() -> int:
    """Print what became of the mutants of a scene's files; exit status 1 if one was missed."""
    words = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    words.add_argument("scene", help="name of an example")
    words.add_argument("--target", choices=tuple(READERS), default="c")
    words.add_argument("--option", default="")
    words.add_argument("--every", type=int, default=10)
    words.add_argument("--prepare", action="store_true")
    words.add_argument("--functions", help="comma-separated; default: all")
    asked = words.parse_args()
    wanted = asked.functions.split(",") if asked.functions else None
    program = symdyn.program.lower(symdyn.dynamics.derive(symdyn.example(asked.scene), wanted))
    if asked.prepare:
        program = prepare_program(program)
    found = score(program, asked.target, asked.every, asked.option)
    for one in found.missed:
        print(f"missed: {one.file}:{one.line}: {one.change}")
    planted = found.caught + found.same + len(found.missed)
    name = f"{asked.scene}, {asked.target}{' --' + asked.option if asked.option else ''}"
    print(
        f"{name}: {planted} mutants, {found.caught} caught, {found.same} the same program, {len(found.missed)} missed; "
        f"{found.comments} in comments left out"
    )
    return 1 if found.missed else 0


if __name__ == "__main__":
    sys.exit(main())
