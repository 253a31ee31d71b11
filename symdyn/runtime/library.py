"""Compiled sources on disk, found again by the hash of everything that went into them.

The key covers the text of every file, the flags, the compiler's command line, its version text and the features of the
machine it compiles for. A library is compiled in a folder aside, sealed and renamed into place, so that two builds at
once both end with a whole one. What is in the cache is loaded only if it is what was put there
(`symdyn.runtime.cache`), in a folder where only the user may write (`symdyn.runtime.cache`). The ufunc target is
compiled against this Python and this NumPy, and imported from there.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import shlex
import shutil
import sys
import sysconfig
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from errno import ENOSPC
from functools import partial
from importlib.machinery import EXTENSION_SUFFIXES, ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from symdyn.emit import Sources
from symdyn.errors import BuildError, MissingCompiler
from symdyn.frozen import dataclass
from symdyn.runtime.cache import (
    Damaged,
    check_target,
    folder_aside,
    instead,
    load_entry,
    private_folder,
    seal,
    trusted_folder,
    warn,
)
from symdyn.runtime.commands import Needs, threads
from symdyn.runtime.compiler import NOTHING, PATIENCE, Compiler, CompilerFault, compile_library, find_compiler

SUFFIX = ".dll" if sys.platform == "win32" else ".so"

SEALED = "sealed, 1"
"""Part of the key: how entries are kept. What was kept otherwise is not looked at."""

ROOM = 1 << 20
"""Bytes that a disk has free at least, or it is full: compilers and linkers say so each in words of their own."""


@dataclass(frozen=True)
class LibraryKind:
    """A kind of shared library."""

    suffix: str  # how its file name ends
    needs: Needs  # what the code needs beside its own text
    abi: tuple[str, ...]  # what else it is compiled against, for the cache's key
    open: Callable[[str], Any]  # loads the file of a path; OSError or ImportError where it is none of this kind


PLAIN = LibraryKind(SUFFIX, NOTHING, (), ctypes.CDLL)


Files = Mapping[str, str]


def load_library(
    files: Files,
    compiler: Compiler,
    patience: float = PATIENCE,
    kind: LibraryKind = PLAIN,
    write: Callable[[], Files] | None = None,
) -> tuple[Path, Any]:
    """Return the loaded library of the sources among `files` and its path, compiled unless that was done before.

    Where writing the sources takes long, `files` stand for them, and `write` returns them. A library that is damaged
    or does not load is compiled again. Where the cache folder cannot be written to, or others may write there, code is
    compiled for this process alone. Both are said.

    Raises:
        BuildError: it cannot be compiled, or not be loaded even when it is fresh.
        MissingCompiler: there is no folder to compile in.
    """
    folder = trusted_folder()
    try:
        return _load_in(folder, files, compiler, patience, kind, write)
    except OSError as fault:
        reason = fault.strerror or str(fault)
    private = private_folder(os.getpid())
    if folder != private:
        try:
            return _load_in(instead(folder, reason), files, compiler, patience, kind, write)
        except OSError as fault:  # such as a scanner that holds each file it sees
            folder, reason = private, fault.strerror or str(fault)
    raise MissingCompiler(f"{folder}: nothing can be compiled there ({reason}); set TMPDIR to another folder")


def load_functions(
    files: Files, symbols: Iterable[str], compiler: Compiler | None = None, patience: float = PATIENCE
) -> tuple[Path, ctypes.CDLL]:
    """Return the loaded library of plain code and its path, as `load_library` does.

    Args:
        files: sources by name.
        symbols: functions that are looked up in it.
        compiler: what to compile with; None looks for one of C.
        patience: seconds until a compiler that hangs is stopped.

    Raises:
        BuildError: as `load_library`; MissingCompiler, which is one, where no compiler is found.
    """
    kind = LibraryKind(SUFFIX, Needs(exports=tuple(symbols)), (), ctypes.CDLL)
    path, library = load_library(files, compiler or find_compiler(), patience, kind)
    return path, library


def entry_name(files: Mapping[str, str], compiler: Compiler, kind: LibraryKind = PLAIN) -> str:
    """Return the name of the library of `files` in the cache."""
    return f"{Path(next(iter(files))).stem}-{_key(files, compiler, kind)}{kind.suffix}"


def _load_in(
    folder: Path,
    files: Files,
    compiler: Compiler,
    patience: float,
    kind: LibraryKind,
    write: Callable[[], Files] | None,
) -> tuple[Path, Any]:
    """Return the loaded library, which is kept in `folder`, and its path; OSError where it cannot be written."""
    path = folder / entry_name(files, compiler, kind)
    try:
        return path, load_entry(path, kind.open)
    except FileNotFoundError:
        pass
    except Damaged as fault:
        warn(f"{path}: {fault}; it is compiled again")
    except (OSError, ImportError) as fault:
        warn(f"{path}: this Python cannot load it ({fault}); it is compiled again")
    _compile_aside(write() if write else files, compiler, path, patience, kind)
    try:
        return path, load_entry(path, kind.open)
    except (OSError, ImportError, Damaged) as fault:
        with suppress(OSError):
            path.unlink()
        message = f"{shlex.join(compiler.command)} made a library that this Python cannot load ({fault})"
        raise CompilerFault(f"{message}; use a compiler for this machine ({sys.platform})") from fault


def _key(files: Mapping[str, str], compiler: Compiler, kind: LibraryKind) -> str:
    """Return the hash of everything that decides what the library does."""
    parts = [
        SEALED,
        *compiler.command,
        compiler.version,
        *compiler.dialect.flags,
        *compiler.machine,
        compiler.features,
        sys.platform,
        *compiler.dialect.needs(kind.needs),
        *(f"{folder}{name}" for folder, name in kind.needs.libraries),
        *kind.abi,
    ]
    parts += [piece for name, text in files.items() for piece in (name, text)]
    digest = hashlib.sha256()
    for part in parts:
        data = part.encode()
        digest.update(f"{len(data)}:".encode() + data)
    return digest.hexdigest()[:24]


def _compile_aside(
    files: Mapping[str, str], compiler: Compiler, library: Path, patience: float, kind: LibraryKind
) -> None:
    """Compile in a folder beside `library`, seal, then rename; OSError where that cannot be written."""
    with folder_aside(library.parent) as folder:
        for name, text in files.items():
            (folder / name).write_text(text, encoding="utf-8")
        fresh = folder / library.name
        parts = [folder / name for name in files if name.endswith(compiler.dialect.source)]
        try:
            given = _compile_parts(compiler, parts, patience, kind) if len(parts) > 1 else parts
            compile_library(compiler, given, fresh, patience, kind.needs)
        except BuildError as fault:
            if shutil.disk_usage(library.parent).free < ROOM:
                raise OSError(ENOSPC, os.strerror(ENOSPC)) from fault
            raise
        seal(fresh)
        os.replace(fresh, library)


def _compile_parts(compiler: Compiler, sources: Sequence[Path], patience: float, kind: LibraryKind) -> list[Path]:
    """Return the object files of `sources`, compiled at the same time."""

    def compile_part(source: Path) -> Path:
        part = source.with_suffix(compiler.dialect.object)
        compile_library(compiler, source, part, patience, kind.needs, part=True)
        return part

    with threads() as pool:
        return list(pool.map(compile_part, sources))


INCLUDE = Path(sysconfig.get_path("include"))
"""Where Python's headers are; asked once, since several threads that ask first at a time get half an answer."""


def build_extension(
    sources: Sources, compiler: str | None = None, patience: float = PATIENCE, machine: str = "native"
) -> tuple[Path, ModuleType]:
    """Return the extension module of sources that `emit(program, "ufunc")` made, and its file.

    Raises:
        BuildError: sources of another target, no headers of Python, no compiler, or its own words when it refuses.
    """
    check_target(sources, "ufunc")
    kind = extension_kind(Path(sources.files[0][0]).stem)
    path, module = load_library(sources.texts, find_compiler(compiler, machine), patience, kind)
    assert isinstance(module, ModuleType), "an extension's kind opens modules"
    module.__file__ = str(path)
    return path, module


def extension_kind(name: str, soon: bool = False) -> LibraryKind:
    """Return how an extension module of this Python and this NumPy is compiled, if `soon` less well, and opened.

    Raises:
        MissingCompiler: there are no headers of Python.
    """
    suffix = EXTENSION_SUFFIXES[0]
    needs = Needs(
        headers=(python_headers(), np.get_include()),
        libraries=python_libraries(),
        loose=sys.platform == "darwin",
        soon=soon,
    )
    return LibraryKind(suffix, needs, (sys.version, suffix, np.__version__), partial(imported, name))


def python_headers() -> str:
    """Return the folder of Python.h; MissingCompiler where it is not installed."""
    if not (INCLUDE / "Python.h").is_file():
        raise MissingCompiler(
            f"{INCLUDE}: there is no Python.h, which an extension module needs; install Python's headers "
            "(python3-dev), or use the NumPy module, which needs none: `symdyn generate SCENE --target numpy`"
        )
    return str(INCLUDE)


def python_libraries(platform: str = sys.platform) -> tuple[tuple[str, str], ...]:
    """Return folder and name of the library that extensions are linked against: pythonXY, on Windows alone."""
    if platform != "win32":
        return ()
    threads = "t" if sysconfig.get_config_var("Py_GIL_DISABLED") else ""
    name = f"python{sys.version_info.major}{sys.version_info.minor}{threads}"
    return ((str(Path(sys.base_prefix) / "libs"), name),)


def imported(name: str, path: str) -> ModuleType:
    """Return the extension module in a file; it is not entered into `sys.modules`."""
    loader = ExtensionFileLoader(name, path)
    spec = spec_from_file_location(name, path, loader=loader)
    assert spec is not None, "a loader was given"
    module = module_from_spec(spec)
    loader.exec_module(module)
    return module
