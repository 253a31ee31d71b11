"""Binaries of this platform in FMUs whose sources `emit` wrote: model by model one shared library, portable code."""

from __future__ import annotations

import ctypes
import io
import platform
import sys
import tempfile
import zipfile
from dataclasses import replace
from pathlib import Path

from symdyn.emit import TARGETS, Sources, packed
from symdyn.errors import BuildError
from symdyn.runtime.compiler import PATIENCE, Compiler, compile_library, find_compiler

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
