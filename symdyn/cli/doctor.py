"""`symdyn doctor`: versions, compiler, cache, extras and programs, and what one does without where they are missing.

It ends with 0 whatever is missing: nothing but Python packages has to be there.
"""

from __future__ import annotations

import argparse
import platform
import shutil
import sys
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, packages_distributions, version as installed
from importlib.util import find_spec
from os import W_OK, access
from typing import Any

from symdyn.build import (
    CACHE_VARIABLE,
    CPLUSPLUS,
    NODE_COMMANDS,
    OCTAVE_COMMANDS,
    RUSTC,
    cache_folder,
    distrust,
    find_compiler,
    python_headers,
    try_compiler,
)
from symdyn.cli.talk import give, print_table, print_text
from symdyn.errors import BuildError, printable
from symdyn.extras import EXTRAS, install
from symdyn.resources import version

PACKAGES = ("numpy", "scipy", "sympy", "mpmath", "python-flint", "jinja2", "rich", "platformdirs", "defusedxml")

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


def add_options(verb: argparse.ArgumentParser) -> None:
    """Add what the verb takes: nothing of its own."""


def run(options: argparse.Namespace) -> int:
    """Look around and tell."""
    found = looked()
    if options.json:
        give(found)
    else:
        show(found)
    return 0


def looked() -> dict[str, Any]:
    """Return what is there, for JSON."""
    packages = packages_distributions()
    return {
        "symdyn": version(),
        "python": {"version": platform.python_version(), "path": sys.executable},
        "system": platform.platform(),
        "packages": {name: _version(name) for name in PACKAGES},
        "compiler": _compiler(),
        "headers": _headers(),
        "cache": _cache(),
        "extras": [_extra(name, packages) for name in EXTRAS],
        "programs": [_program(title) for title in PROGRAMS],
    }


def _version(package: str) -> str | None:
    try:
        return installed(package)
    except PackageNotFoundError:
        return None


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


def _extra(name: str, packages: Mapping[str, list[str]]) -> dict[str, Any]:
    """Return what an extra has of what it needs; `packages` are those that bring a module."""
    extra = EXTRAS[name]
    versions = {
        module: _version(packages.get(module, [module])[0]) or "there" if find_spec(module) is not None else None
        for module in extra.modules
    }
    there = None not in versions.values()
    return {
        "name": name, "there": there, "modules": versions,
        "without": None if there else extra.without, "install": install(name),
    }  # fmt: skip


def _program(title: str) -> dict[str, Any]:
    """Return where a program is, or what one does without."""
    commands, without = PROGRAMS[title]
    path = next((found for command in commands if (found := shutil.which(command))), None)
    return {"name": title, "path": path, "without": None if path else without}


def show(found: Mapping[str, Any]) -> None:
    """Print what is there for people."""
    python, cache, compiler = found["python"], found["cache"], found["compiler"]
    print_text(f"symdyn {found['symdyn']}, Python {python['version']} ({python['path']}), {found['system']}")
    print_text(", ".join(f"{name} {version or 'MISSING'}" for name, version in found["packages"].items()) + "\n")
    used = f"{cache['entries']} files, {cache['bytes'] / 2**20:.0f} MB"
    unsafe = f"compiled for each process anew; give {CACHE_VARIABLE} a folder that only you may write to"
    headers = found["headers"]
    rows = [
        ("C compiler", compiler["version"] if compiler["works"] else f"no: {compiler['why']}", compiler["without"]),
        ("Python.h", headers["folder"] or "no", headers["without"]),
        ("cache", cache["folder"], None),
        ("", used if cache["safe"] else f"NOT SAFE: {cache['why']}", None if cache["safe"] else unsafe),
    ]
    rows += [(one["name"], one["path"] or "no", one["without"]) for one in found["programs"]]
    print_table("Programs and folders", ("", "found", "without it"), [(a, b, c or "") for a, b, c in rows])
    extras = [
        (
            one["name"],
            ", ".join(f"{module} {version or 'missing'}" for module, version in one["modules"].items()),
            one["without"] or "",
            "" if one["there"] else one["install"],
        )
        for one in found["extras"]
    ]
    print_table("Extras", ("", "found", "without it", "to install"), extras)
