"""Compiled sources on disk, found again by the hash of everything that went into them.

The key covers the text of every file, the flags, the compiler's command line, its version text and the features of the
machine it compiles for. A library is compiled in a folder aside and renamed into place, so that two builds at once both
end with a whole one.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import shlex
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from symdyn.build.compiler import FLAGS, PATIENCE, Compiler, compile_library
from symdyn.errors import BuildError

SUFFIX = ".dll" if sys.platform == "win32" else ".so"

CACHE_VARIABLE = "SYMDYN_CACHE_DIR"


@dataclass(frozen=True)
class Kind:
    """A kind of shared library.

    Attributes:
        suffix: how its file name ends.
        words: more of the compiler's command line.
        abi: what else it is compiled against, for the cache's key.
        open: loads the file; OSError or ImportError where it is none of this kind.
    """

    suffix: str
    words: tuple[str, ...]
    abi: tuple[str, ...]
    open: Callable[[Path], Any]


PLAIN = Kind(SUFFIX, (), (), lambda path: ctypes.CDLL(str(path)))


def cache_folder() -> Path:
    """Return where libraries are kept: $SYMDYN_CACHE_DIR, else the user's cache folder."""
    chosen = os.environ.get(CACHE_VARIABLE)
    if chosen:
        return Path(chosen)
    from platformdirs import user_cache_dir

    return Path(user_cache_dir("symdyn", appauthor=False))


def library_for(files: Mapping[str, str], compiler: Compiler, patience: float = PATIENCE, kind: Kind = PLAIN) -> Path:
    """Return the shared library of the C files among `files`, compiled unless that was done before.

    Raises:
        BuildError: the compiler refuses, or the cache folder cannot be written to.
    """
    name = next(iter(files))
    library = cache_folder() / f"{Path(name).stem}-{_key(files, compiler, kind)}{kind.suffix}"
    if not library.is_file():
        try:
            library.parent.mkdir(parents=True, exist_ok=True)
            _compile_aside(files, compiler, library, patience, kind)
        except OSError as fault:
            message = f"{library.parent}: cannot keep compiled code there ({fault.strerror})"
            raise BuildError(f"{message}; set {CACHE_VARIABLE} to a folder that you may write to") from fault
    return library


def load(
    files: Mapping[str, str], compiler: Compiler, patience: float = PATIENCE, kind: Kind = PLAIN
) -> tuple[Path, Any]:
    """Return the loaded library of `files` and its path; one that does not load is compiled again, once.

    Raises:
        BuildError: it cannot be compiled, or not be loaded even when it is fresh.
    """
    path = library_for(files, compiler, patience, kind)
    try:
        return path, kind.open(path)
    except (OSError, ImportError):
        path.unlink(missing_ok=True)
    path = library_for(files, compiler, patience, kind)
    try:
        return path, kind.open(path)
    except (OSError, ImportError) as fault:
        message = f"{shlex.join(compiler.command)} made a library that this Python cannot load ({fault})"
        raise BuildError(f"{message}; use a compiler for this machine ({sys.platform})") from fault


def _key(files: Mapping[str, str], compiler: Compiler, kind: Kind) -> str:
    """Return the hash of everything that decides what the library does."""
    parts = [
        *compiler.command,
        compiler.version,
        *FLAGS,
        *compiler.machine,
        compiler.features,
        sys.platform,
        *kind.words,
        *kind.abi,
    ]
    parts += [piece for name, text in files.items() for piece in (name, text)]
    digest = hashlib.sha256()
    for part in parts:
        data = part.encode()
        digest.update(f"{len(data)}:".encode() + data)
    return digest.hexdigest()[:24]


def _compile_aside(files: Mapping[str, str], compiler: Compiler, library: Path, patience: float, kind: Kind) -> None:
    """Compile in a folder beside `library`, then rename."""
    with tempfile.TemporaryDirectory(prefix=".build-", dir=library.parent) as aside:
        folder = Path(aside)
        for name, text in files.items():
            (folder / name).write_text(text, encoding="utf-8")
        fresh = folder / library.name
        parts = [folder / name for name in files if name.endswith(".c")]
        if len(parts) > 1:
            parts = _compile_parts(compiler, parts, patience, kind)
        first, *others = parts
        compile_library(compiler, first, fresh, patience, (*map(str, others), *kind.words))
        os.replace(fresh, library)


def _compile_parts(compiler: Compiler, sources: Sequence[Path], patience: float, kind: Kind) -> list[Path]:
    """Return the object files of `sources`, compiled at the same time."""

    def compile_part(source: Path) -> Path:
        part = source.with_suffix(".o")
        compile_library(compiler, source, part, patience, ("-c", *kind.words))
        return part

    with ThreadPoolExecutor() as pool:
        return list(pool.map(compile_part, sources))
