"""The only file that runs a compiler, of C and its kin: finding one, asking who it is, compiling a shared library.

FMUs whose sources `emit` wrote get binaries of this platform: model by model one shared library, portable code.
"""

from __future__ import annotations

import ctypes
import io
import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
import threading
import zipfile
from collections.abc import Callable, Sequence
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import IO

from symdyn.emit import TARGETS, Sources, packed
from symdyn.errors import BuildError, MissingCompiler, choice
from symdyn.extras import install
from symdyn.frozen import dataclass, replace
from symdyn.runtime.commands import (
    GNU,
    NVCC,
    RUST,
    Dialect,
    Needs,
    candidates,
    cpp_dialect_of,
    dialect_of,
    stop_command,
    waiting,
)

CANDIDATES = candidates()

COMPILER_VARIABLE = "CC"
"""Environment variable that names a compiler."""

MACHINES = ("native", "portable")
"""This very machine, and any of its family."""

NOTHING = Needs()
"""What plain C needs beside itself."""

PATIENCE = 300.0
"""Seconds that one compilation may take."""


class CompilerFault(BuildError):  # noqa: N818  that of a program, not of ours
    """A compiler that is there and fails, or whose library the system does not load."""


@dataclass(frozen=True)
class CompiledLanguage:
    """What a compiler is looked for."""

    name: str  # as people call it
    variable: str  # environment variable that names a compiler
    candidates: tuple[str, ...]  # commands that are looked for, in this order
    dialect: Callable[[Sequence[str]], Dialect]  # how a command is spoken to
    zig: str  # what the ziglang package calls its own; "" where it has none
    ways_out: Callable[[], str]  # what to do where there is none, or it fails


def _ways_out() -> str:
    return (
        f"install one (`{install('zig')}` will do), or use the NumPy module, which needs none: "
        "`symdyn generate SCENE --target numpy`"
    )


C = CompiledLanguage("C", COMPILER_VARIABLE, CANDIDATES, dialect_of, "cc", _ways_out)
CPLUSPLUS = CompiledLanguage(
    "C++", "CXX", ("g++", "clang++", "c++"), cpp_dialect_of, "", lambda: "install one, `apt-get install g++` for one"
)
RUSTC = CompiledLanguage(
    "Rust", "RUSTC", ("rustc",), lambda command: RUST, "", lambda: "install one, `apt-get install rustc` for one"
)
CUDA = CompiledLanguage(
    "CUDA",
    "NVCC",
    ("nvcc",),
    lambda command: NVCC,
    "",
    lambda: "install NVIDIA's CUDA toolkit, or call it with arguments on the CPU",
)


@dataclass(frozen=True)
class Compiler:
    """A compiler: the words of its command line, and what it says about itself."""

    command: tuple[str, ...]  # words of the command line
    version: str  # its own words
    machine: tuple[str, ...] = ()  # flags that say for which machine it compiles
    features: str = ""  # of that machine, as the compiler's macros tell; native code is kept apart by them
    dialect: Dialect = GNU  # how it is spoken to
    language: CompiledLanguage = C  # what it compiles


def find_compiler(requested: str | None = None, machine: str = "native", language: CompiledLanguage = C) -> Compiler:
    """Return the compiler to use: `requested`, else $CC, else cc, gcc, clang, else the one in the ziglang package.

    Args:
        requested: its command line; flags for a machine in there are kept.
        machine: "native" for code that runs on this machine, "portable" for the oldest of its family worth having
            (x86-64-v2; nothing is asked of other families).
        language: C, or another one: then its variable and its commands are looked for.

    Raises:
        BuildError: the one that was asked for is not there, or an unknown machine.
        MissingCompiler: there is none at all.
    """
    if machine not in MACHINES:
        raise BuildError(f"machine {machine!r} is not known; {choice(machine, MACHINES)}")
    asked, ways_out = requested or os.environ.get(language.variable, "").strip(), language.ways_out()
    if asked:
        origin = "compiler" if requested else f"the environment variable {language.variable}"
        try:
            words = [asked] if shutil.which(asked) else words_of(asked)
            if not words:
                raise ValueError("it is empty")
        except ValueError as fault:
            raise BuildError(f"{origin} = {asked} is no command line ({fault}); {ways_out}") from fault
        if shutil.which(words[0]) is None:
            raise BuildError(f"{origin} = {asked}: there is no such program; {ways_out}")
        return _known(tuple(words), machine, language)
    for name in language.candidates:
        path = shutil.which(name)
        if path is not None:
            return _known((path,), machine, language)
    if language.zig and find_spec("ziglang") is not None:
        return _known((sys.executable, "-m", "ziglang", language.zig), machine, language)
    package = " and the ziglang package" if language.zig else ""
    tried = f"${language.variable}, {', '.join(language.candidates)}{package}"
    raise MissingCompiler(f"no {language.name} compiler found (tried {tried}); {ways_out}")


def words_of(line: str, platform: str = sys.platform) -> list[str]:
    r"""Return the words of a command line; on Windows a backslash stands in paths.

    >>> words_of(r'"C:\Program Files\cl.exe" /O1', "win32")
    ['C:\\Program Files\\cl.exe', '/O1']
    """
    if platform != "win32":
        return shlex.split(line)
    return [word.strip('"') for word in shlex.split(line, posix=False)]


_ASKING = threading.Lock()


def _known(command: tuple[str, ...], machine: str, language: CompiledLanguage) -> Compiler:
    """Return the compiler behind a command line; it is asked who it is once a process, whichever thread comes first."""
    with _ASKING:
        return _asked(command, machine, language)


@cache
def _asked(command: tuple[str, ...], machine: str, language: CompiledLanguage) -> Compiler:
    dialect = language.dialect(command)
    _, words = _run((*command, *dialect.version), patience=30.0)
    chosen = any(word.startswith(("-march", "-mcpu", "/clang:-march", "/arch", "-Ctarget-cpu")) for word in command)
    if dialect.macros is None:
        return Compiler(command, words, dialect=dialect, language=language)
    for flags in ((),) if chosen else (*dialect.machines[machine], ()):
        code, macros = _run((*command, *dialect.macros, *flags, os.devnull), patience=30.0)
        if code is None:
            break
        if code == 0:
            return Compiler(command, words, flags, macros, dialect, language)
    return Compiler(command, words, dialect=dialect, language=language)


def compile_library(
    compiler: Compiler,
    sources: Path | Sequence[Path],
    made: Path,
    patience: float = PATIENCE,
    needs: Needs = NOTHING,
    part: bool = False,
) -> None:
    """Compile files into a shared library, or one of them into a part of it.

    Raises:
        CompilerFault: the compiler refuses, says nothing for `patience` seconds, or leaves nothing behind.
    """
    files = [sources] if isinstance(sources, Path) else list(sources)
    source, library = files[0], made
    command = (*compiler.command, *compiler.dialect.line(compiler.machine, files, made, needs, part))
    code, words = _run(command, patience, library.parent)
    shown, ways_out = shlex.join(compiler.command), compiler.language.ways_out()
    if code is None:
        raise CompilerFault(f"{shown} did not finish {source.name} within {patience:g} s and was stopped; {ways_out}")
    if code != 0 or not library.is_file():
        said = words.strip() or "(it said nothing)"
        raise CompilerFault(f"{shown} could not compile {source.name} (exit {code}):\n{said}\n{ways_out}")


def try_compiler(compiler: Compiler, patience: float = 30.0) -> None:
    """Compile a line of C into a library, and forget it; CompilerFault where the compiler does not do it, and why."""
    with tempfile.TemporaryDirectory(prefix="symdyn-") as folder:
        source = Path(folder) / "probe.c"
        source.write_text("double probe(double x);\ndouble probe(double x) { return x; }\n", encoding="utf-8")
        compile_library(compiler, source, source.with_suffix(".so"), patience, Needs(exports=("probe",)))


def _run(command: Sequence[str], patience: float, place: Path | None = None) -> tuple[int | None, str]:
    """Run a command and return its exit code (None: it had to be stopped) and all it said.

    Words go to a file and the command gets a process group of its own, so that a compiler which hangs, or whose
    children do, is stopped and waits for nobody. What it writes on its way goes to `place`, which is taken away even if
    the command is killed.
    """
    with _file_of_words() as words:
        try:
            process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=words,
                stderr=words,
                start_new_session=True,
                env=os.environ if place is None else os.environ | dict.fromkeys(("TMPDIR", "TMP", "TEMP"), str(place)),
            )
        except OSError as fault:
            raise CompilerFault(f"{shlex.join(command)} cannot be run ({fault.strerror}); {_ways_out()}") from fault
        late = threading.Event()

        def stop() -> None:
            late.set()
            stop_command(process)

        timer = threading.Timer(patience, stop)  # wait(patience) would look only every 50 ms
        try:
            with waiting(process):  # at once, or who is interrupted meanwhile leaves it running
                timer.start()
                code = process.wait()
        finally:
            timer.cancel()
        words.seek(0)
        return None if late.is_set() else code, words.read().decode(errors="replace")


def _file_of_words() -> IO[bytes]:
    """Return a file that ends when it is closed; MissingCompiler where nothing can be written, compilers neither."""
    try:
        return tempfile.TemporaryFile()
    except OSError as fault:
        raise MissingCompiler(
            f"no folder to compile in ({fault.strerror}); set TMPDIR to one; {_ways_out()}"
        ) from fault


FMU = TARGETS["fmu"]

SYSTEMS = {
    "linux": ("linux", "linux", ".so"),
    "darwin": ("darwin", "darwin", ".dylib"),
    "win32": ("win", "windows", ".dll"),
}
"""By `sys.platform`: what FMI 2 calls it, what FMI 3 calls it, how libraries end."""

FAMILIES = {
    "x86_64": "x86_64",
    "amd64": "x86_64",
    "arm64": "aarch64",
    "aarch64": "aarch64",
    "i686": "x86",
    "x86": "x86",
}
"""Families of machines, as FMI 3 calls them."""


def with_binaries(sources: Sources, compiler: str | None = None, patience: float = PATIENCE) -> Sources:
    """Return FMUs with a binary of this platform beside their sources.

    Args:
        sources: of the target fmu.
        compiler: command to compile with; None looks for $CC, cc, gcc, clang and the ziglang package.
        patience: seconds until a compiler that hangs is stopped.

    Raises:
        MissingCompiler: there is none.
        BuildError: sources of another target, a platform that FMI has no name for, or the compiler refuses.
    """
    if sources.target != FMU.name:
        raise BuildError(f"binaries are for FMUs, and these are sources of target {sources.target}")
    compiling = find_compiler(compiler, "portable")
    with tempfile.TemporaryDirectory(prefix="symdyn-") as folder:
        files = tuple(
            (name, _filled(name, archive, compiling, patience, Path(folder)))
            for name, archive in sources.files
            if isinstance(archive, bytes)
        )
    return replace(sources, files=files)


def _filled(name: str, archive: bytes, compiler: Compiler, patience: float, folder: Path) -> bytes:
    identifier, _, version = name.removesuffix(".fmu").rpartition("_")
    target = binary_place(version, identifier)
    with zipfile.ZipFile(io.BytesIO(archive)) as opened:
        found = {member: opened.read(member) for member in opened.namelist()}
    place = folder / version
    place.mkdir()
    for file, text in found.items():
        if file.startswith("sources/"):
            (place / Path(file).name).write_bytes(text)
    equations = folder / f"equations{compiler.dialect.object}"
    if not equations.exists():  # the same for all versions
        compile_library(compiler, place / f"{identifier}.c", equations, patience, part=True)
    made = place / f"model{Path(target).suffix}"
    compile_library(compiler, [place / f"{version}-functions.c", equations], made, patience)
    return packed({**found, target: made.read_bytes()})


def binary_place(version: str, identifier: str) -> str:
    """Return where the binary of this platform stands in an FMU of version "fmi2" or "fmi3".

    Raises:
        BuildError: FMI has no name for this platform.
    """
    system, family = SYSTEMS.get(sys.platform), FAMILIES.get(platform.machine().lower())
    if system is None or family is None:
        raise BuildError(
            f"FMI has no name for {sys.platform} on {platform.machine()}; the sources can be compiled there"
        )
    bits = 8 * ctypes.sizeof(ctypes.c_void_p)
    folder = f"{system[0]}{bits}" if version == "fmi2" else f"{family}-{system[1]}"
    return f"binaries/{folder}/{identifier}{system[2]}"


COMPLETED: dict[str, tuple[Callable[[Sources], Sources], str]] = {
    "fmu": (with_binaries, "sources, and a binary for this platform")
}
"""By target: what adds to its sources, and what they hold then."""


def complete(sources: Sources) -> tuple[Sources, str]:
    """Return sources with what a compiler adds, as they are where it cannot; and what is to be said, "" for nothing."""
    if sources.target not in COMPLETED:
        return sources, ""
    add, held = COMPLETED[sources.target]
    names = ", ".join(sources)
    try:
        return add(sources), f"{names}: {held}"
    except BuildError as fault:
        return sources, f"{names}: sources alone; {fault}"
