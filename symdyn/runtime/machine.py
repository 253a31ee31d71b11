"""What this machine has to compile, run and show what is generated, and what one does without where it is missing."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from os import W_OK, access
from typing import Any

from symdyn.errors import BuildError, printable
from symdyn.runtime.cache import cache_folder, distrust
from symdyn.runtime.compiler import CPLUSPLUS, RUSTC, find_compiler, try_compiler
from symdyn.runtime.interpreters import NODE_COMMANDS, OCTAVE_COMMANDS
from symdyn.runtime.library import python_headers

PROGRAMS: Mapping[str, tuple[tuple[str, ...], str]] = {
    "LaTeX": (("pdflatex",), "walkthrough writes no PDF"),
    "C++ compiler": (CPLUSPLUS.candidates, "verify measures no C++, which is written all the same"),
    "Rust compiler": (RUSTC.candidates, "verify measures no Rust, which is written all the same"),
    "Node.js": (NODE_COMMANDS, "verify runs no JavaScript, which is written all the same"),
    "Octave": (OCTAVE_COMMANDS, "verify measures no MATLAB, which is written all the same"),
    "Chromium": (
        ("chromium", "chromium-browser", "google-chrome", "chrome"),
        "nothing: only tests of pages run it, and any browser shows them",
    ),
}
"""Programs by title: their commands, and what one does without."""

NO_COMPILER = "load, lambdify and simulate run the NumPy module: the same results, slower; verify measures no C"
NO_HEADERS = "load runs the NumPy module: the same results, slower"


def here() -> dict[str, Any]:
    """Return the compiler of C, Python's headers, the cache and programs as plain values; nothing is made."""
    programs = [_program(title, *row) for title, row in PROGRAMS.items()]
    return {"compiler": _compiler(), "headers": _headers(), "cache": _cache(), "programs": programs}


def _program(title: str, commands: tuple[str, ...], without: str) -> dict[str, Any]:
    """Return where a program is, or what one does without."""
    path = next((found for command in commands if (found := shutil.which(command))), None)
    return {"name": title, "path": path, "without": None if path else without}


def _compiler() -> dict[str, Any]:
    """Return the compiler, whether it compiles, and what one does without one that does."""
    facts: dict[str, Any] = {"command": None, "version": None, "works": False, "why": None, "without": NO_COMPILER}
    try:
        compiler = find_compiler()
        facts |= {
            "command": " ".join(compiler.command),
            "version": printable(next(iter(compiler.version.splitlines()), "")),
        }
        try_compiler(compiler)
    except (BuildError, OSError) as fault:
        return facts | {"why": str(fault).splitlines()[0]}
    return facts | {"works": True, "without": None}


def _headers() -> dict[str, Any]:
    """Return whether Python's headers are there."""
    try:
        return {"folder": python_headers(), "why": None, "without": None}
    except BuildError as fault:
        return {"folder": None, "why": str(fault), "without": NO_HEADERS}


def _cache() -> dict[str, Any]:
    """Return the folder of compiled code, whether it is safe, and how much is there; nothing is made or changed."""
    folder = cache_folder()
    facts: dict[str, Any] = {"folder": str(folder), "safe": True, "why": None, "entries": 0, "bytes": 0}
    try:
        if not folder.exists():
            above = next(one for one in folder.parents if one.exists())
            if not above.is_dir() or not access(above, W_OK):
                return facts | {"safe": False, "why": f"it is not there, and you may not write to {above}"}
            return facts | {"why": "is made when something is compiled"}
        reason = distrust(folder.stat()) or ("" if access(folder, W_OK) else "you may not write there")
        reason = reason if folder.is_dir() else "it is no folder"
        sizes = [path.lstat().st_size for path in folder.iterdir()] if folder.is_dir() else []
    except OSError as fault:
        return facts | {"safe": False, "why": fault.strerror or str(fault)}
    return facts | {"safe": not reason, "why": reason or None, "entries": len(sizes), "bytes": sum(sizes)}
