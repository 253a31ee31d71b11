"""Compiled sources on disk, found again by the hash of everything that went into them.

The key covers the text of every file, the flags, the compiler's command line and its version text. A library is
compiled in a folder aside and renamed into place, so that two builds at once both end with a whole one.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import shlex
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

from symdyn.build.compiler import FLAGS, PATIENCE, Compiler, compile_library
from symdyn.errors import BuildError

SUFFIX = ".dll" if sys.platform == "win32" else ".so"

CACHE_VARIABLE = "SYMDYN_CACHE_DIR"


def cache_folder() -> Path:
    """Return where libraries are kept: $SYMDYN_CACHE_DIR, else the user's cache folder."""
    chosen = os.environ.get(CACHE_VARIABLE)
    if chosen:
        return Path(chosen)
    from platformdirs import user_cache_dir

    return Path(user_cache_dir("symdyn", appauthor=False))


def library_for(files: Mapping[str, str], compiler: Compiler, patience: float = PATIENCE) -> Path:
    """Return the shared library of `files`, the first of which is compiled unless that was done before.

    Raises:
        BuildError: the compiler refuses, or the cache folder cannot be written to.
    """
    name = next(iter(files))
    library = cache_folder() / f"{Path(name).stem}-{_key(files, compiler)}{SUFFIX}"
    if not library.is_file():
        try:
            library.parent.mkdir(parents=True, exist_ok=True)
            _compile_aside(files, compiler, library, patience)
        except OSError as fault:
            message = f"{library.parent}: cannot keep compiled code there ({fault.strerror})"
            raise BuildError(f"{message}; set {CACHE_VARIABLE} to a folder that you may write to") from fault
    return library


def load(files: Mapping[str, str], compiler: Compiler, patience: float = PATIENCE) -> tuple[Path, ctypes.CDLL]:
    """Return the loaded library of `files` and its path; one that does not load is compiled again, once.

    Raises:
        BuildError: it cannot be compiled, or not be loaded even when it is fresh.
    """
    path = library_for(files, compiler, patience)
    try:
        return path, ctypes.CDLL(str(path))
    except OSError:
        path.unlink(missing_ok=True)
    path = library_for(files, compiler, patience)
    try:
        return path, ctypes.CDLL(str(path))
    except OSError as fault:
        message = f"{shlex.join(compiler.command)} made a library that this Python cannot load ({fault})"
        raise BuildError(f"{message}; use a compiler for this machine ({sys.platform})") from fault


def _key(files: Mapping[str, str], compiler: Compiler) -> str:
    """Return the hash of everything that decides what the library does."""
    parts = [*compiler.command, compiler.version, *FLAGS, sys.platform]
    parts += [piece for name, text in files.items() for piece in (name, text)]
    digest = hashlib.sha256()
    for part in parts:
        data = part.encode()
        digest.update(f"{len(data)}:".encode() + data)
    return digest.hexdigest()[:24]


def _compile_aside(files: Mapping[str, str], compiler: Compiler, library: Path, patience: float) -> None:
    """Compile in a folder beside `library`, then rename."""
    with tempfile.TemporaryDirectory(prefix=".build-", dir=library.parent) as aside:
        folder = Path(aside)
        for name, text in files.items():
            (folder / name).write_text(text, encoding="utf-8")
        fresh = folder / library.name
        compile_library(compiler, folder / next(iter(files)), fresh, patience)
        os.replace(fresh, library)
