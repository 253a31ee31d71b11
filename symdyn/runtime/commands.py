"""Commands that run, how they are stopped with all that they have started, and how compilers are spoken to.

A row for GCC and Clang, for both on Windows, for `cl`, `clang-cl`, `rustc`, `nvcc`. A command line is program, flags,
machine, files, what the code needs, where the library goes, in the words of the row.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, nullcontext, suppress
from contextvars import ContextVar
from pathlib import Path, PureWindowsPath

from symdyn.frozen import dataclass, replace


class Stopped(BaseException):
    """A command was stopped because nobody waits for it any longer; it has not failed."""


class Commands:
    """Commands that are stopped together: threads that wait for them hear no Ctrl-C."""

    def __init__(self, within: Commands | None = None) -> None:
        """Start with none; they are stopped with those that they belong to, too."""
        self._lock, self._running, self._stopped = threading.Lock(), set[subprocess.Popen[bytes]](), False
        self._within = within

    @contextmanager
    def holding(self, process: subprocess.Popen[bytes]) -> Iterator[None]:
        """Count a process as one of them inside; it is stopped at once if they were.

        Raises:
            Stopped: it was stopped in the meantime.
        """
        with self._within.holding(process) if self._within else nullcontext():
            yield from self._holding(process)

    def _holding(self, process: subprocess.Popen[bytes]) -> Iterator[None]:
        with self._lock:
            self._running.add(process)
            stopped = self._stopped
        if stopped:
            stop_command(process)
        try:
            yield
        finally:
            with self._lock:
                self._running.discard(process)
                stopped = self._stopped
        if stopped:
            raise Stopped

    def threads(self, most: int | None = None) -> ThreadPoolExecutor:
        """Return threads, at most so many, whose commands are among them."""
        return ThreadPoolExecutor(most, initializer=COMMANDS.set, initargs=(self,))

    def stop(self) -> None:
        with self._lock:
            self._stopped = True
            for process in self._running:
                stop_command(process)


COMMANDS = ContextVar("commands", default=Commands())  # noqa: B039  nobody stops these
"""Of which commands those are that run here."""


@contextmanager
def threads() -> Iterator[ThreadPoolExecutor]:
    """Lend threads whose commands are stopped where a fault or Ctrl-C leaves the block, or the starter is stopped."""
    commands = Commands(COMMANDS.get())
    with commands.threads() as pool:
        try:
            yield pool
        except BaseException:
            commands.stop()
            pool.shutdown(wait=False, cancel_futures=True)
            raise


@contextmanager
def waiting(process: subprocess.Popen[bytes]) -> Iterator[None]:
    """Wait inside for a process with a group of its own, which hears no Ctrl-C: it ends where nobody waits any longer.

    Raises:
        Stopped: it was stopped in the meantime.
    """
    try:
        with COMMANDS.get().holding(process):
            yield
    except Exception:
        raise
    except BaseException:
        stop_command(process)
        raise


def stop_command(process: subprocess.Popen[bytes]) -> None:
    """End a process, which has a group of its own, together with its children."""
    with suppress(OSError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:  # Windows, where a tree of processes is ended by a program of its own
            subprocess.run(("taskkill", "/F", "/T", "/PID", str(process.pid)), capture_output=True, check=False)
            process.kill()


Words = tuple[str, ...]


@dataclass(frozen=True)
class Needs:
    """What code needs beside its own text."""

    headers: Words = ()  # folders of headers
    libraries: tuple[tuple[str, str], ...] = ()  # folder and name of import libraries, which Windows links against
    exports: Words = ()  # functions that callers look up; where a library hands out none by itself they are named
    loose: bool = False  # whether names may stay open until the library is loaded (macOS says so)
    soon: bool = False  # whether to compile soon rather than well


@dataclass(frozen=True)
class Dialect:
    """The words of one kind of compiler.

    Attributes:
        flags: of every compilation.
        machines: by machine, flags for it; the first that the compiler takes are used, else none.
        version: words that make it say who it is.
        macros: words before flags for a machine that make it print its macros; None where nothing does.
        needs: spells what code needs.
        library: words that make a library of files, after all others.
        part: words that make an object file.
        object: how object files end.
        source: how the names of files end that it is given; others lie beside them.
    """

    flags: Words
    machines: Mapping[str, tuple[Words, ...]]
    version: Words
    macros: Words | None
    needs: Callable[[Needs], Words]
    library: Callable[[Path, Needs], Words]
    part: Callable[[Path], Words]
    object: str
    source: str

    def line(self, machine: Words, files: Sequence[Path], made: Path, needs: Needs, part: bool) -> Words:
        """Return what follows the compiler's own command: files become a library, or a part of one."""
        last = self.part(made) if part else self.library(made, needs)
        return (*self.flags, *machine, *map(str, files), *self.needs(needs), *last)


def _gnu_needs(needs: Needs) -> Words:
    headers = tuple(word for folder in needs.headers for word in ("-I", folder))
    loose = ("-undefined", "dynamic_lookup") if needs.loose else ()
    return (*headers, *(("-O1",) if needs.soon else ()), *loose)  # of several levels compilers take the last


def _gnu_part(made: Path) -> Words:
    return ("-c", "-o", str(made))


def _mingw_library(made: Path, needs: Needs) -> Words:
    linked = tuple(word for folder, name in needs.libraries for word in (f"-L{folder}", f"-l{name}"))
    return ("-o", str(made), *linked)


FLAGS = ("-O3", "-fPIC", "-shared", "-ffp-contract=fast", "-fopenmp-simd", "-fno-math-errno")
"""No -std=c99 here: as a build flag it turns fused multiply-add off. And never -ffast-math, which breaks NaN.

-fopenmp-simd reads the pragmas of batch loops and links nothing; without -fno-math-errno a square root is a call.
"""

GNU = Dialect(
    flags=FLAGS,
    machines={
        "native": (("-march=native", "-mprefer-vector-width=512"), ("-march=native",), ("-mcpu=native",)),
        "portable": (("-march=x86-64-v2",), ("-march=x86_64_v2",)),
    },
    version=("--version",),
    macros=("-E", "-dM", "-x", "c"),
    needs=_gnu_needs,
    library=lambda made, needs: ("-o", str(made), "-lm"),
    part=_gnu_part,
    object=".o",
    source=".c",
)

MINGW = Dialect(
    flags=tuple(flag for flag in FLAGS if flag != "-fPIC"),  # all code moves there, and Clang refuses the word
    machines=GNU.machines,
    version=GNU.version,
    macros=GNU.macros,
    needs=_gnu_needs,
    library=_mingw_library,  # mathematics is in the C library
    part=_gnu_part,
    object=".o",
    source=".c",
)


def _cl_needs(needs: Needs) -> Words:
    return (*(f"/I{folder}" for folder in needs.headers), *(("/O1",) if needs.soon else ()))


def _cl_library(made: Path, needs: Needs) -> Words:
    linked = tuple(word for folder, name in needs.libraries for word in (f"/LIBPATH:{folder}", f"{name}.lib"))
    exported = (f"/EXPORT:{name}" for name in needs.exports)
    return ("/LD", f"/Fe:{made}", f"/Fo{made.parent}\\", "/link", "/NOLOGO", "/INCREMENTAL:NO", *linked, *exported)


def _cl_part(made: Path) -> Words:
    return ("/c", f"/Fo{made}")


CL = Dialect(
    flags=("/nologo", "/utf-8", "/std:c11", "/O2", "/fp:precise"),  # C11, for `restrict`
    machines={"native": ((),), "portable": ((),)},  # it knows no machine but by name
    version=(),  # it says who it is when nothing is asked of it
    macros=None,
    needs=_cl_needs,
    library=_cl_library,
    part=_cl_part,
    object=".obj",
    source=".c",
)

CLANG_CL = Dialect(
    flags=(
        "/nologo", "/utf-8", "/O2", "/fp:precise",
        "/clang:-ffp-contract=fast", "/clang:-fopenmp-simd", "/clang:-fno-math-errno",
    ),
    machines={"native": (("/clang:-march=native",),), "portable": (("/clang:-march=x86-64-v2",),)},
    version=("--version",),
    macros=("/E", "/clang:-dM", "/TC"),
    needs=_cl_needs,
    library=_cl_library,
    part=_cl_part,
    object=".obj",
    source=".c",
)  # fmt: skip

RUST = Dialect(
    flags=("--edition=2021", "--crate-type=cdylib", "-Copt-level=3"),
    machines={"native": (("-Ctarget-cpu=native",),), "portable": (("-Ctarget-cpu=x86-64-v2",),)},
    version=("--version", "--verbose"),
    macros=("--print", "cfg"),
    needs=lambda needs: (),
    library=lambda made, needs: ("-o", str(made)),
    part=lambda made: ("--emit=obj", "-o", str(made)),
    object=".o",
    source="_calls.rs",  # the file of `symdyn.emit.entries` that the others are modules of
)

NVCC = Dialect(
    flags=("-O3", "-std=c++17", "-shared", "-Xcompiler", "-fPIC"),
    machines={},  # it compiles for a card, which who asks names
    version=("--version",),
    macros=None,
    needs=_gnu_needs,
    library=lambda made, needs: ("-o", str(made)),
    part=lambda made: ("-c", "-o", str(made)),
    object=".o",
    source=".cu",
)

BY_NAME: Mapping[str, Dialect] = {"cl": CL, "clang-cl": CLANG_CL}
"""Dialects of programs, by their names without .exe; all others speak GNU."""


def dialect_of(command: Sequence[str], platform: str = sys.platform) -> Dialect:
    """Return how a compiler is spoken to, by the name of its program: of Windows' path or any other."""
    name = PureWindowsPath(command[0]).name.lower().removesuffix(".exe")
    return BY_NAME.get(name) or (MINGW if platform == "win32" else GNU)


def cpp_dialect_of(command: Sequence[str], platform: str = sys.platform) -> Dialect:
    """Return how a compiler of C++ is spoken to; C++17 is asked for by its GNU name, which leaves fused operations."""
    dialect = dialect_of(command, platform)
    if dialect.macros is None or dialect is CLANG_CL:
        flags = tuple(flag for flag in dialect.flags if flag != "/std:c11")
        return replace(dialect, flags=(*flags, "/std:c++17", "/EHsc"), source=".cpp")
    return replace(dialect, flags=(*dialect.flags, "-std=gnu++17"), macros=("-E", "-dM", "-x", "c++"), source=".cpp")


def candidates(platform: str = sys.platform) -> Words:
    """Return the compilers that are looked for, in this order."""
    return ("cl", "clang-cl", "gcc", "clang", "cc") if platform == "win32" else ("cc", "gcc", "clang")
