"""`symdyn doctor`: versions, compiler, cache, extras and programs, and what one does without where they are missing.

It ends with 0 whatever is missing: nothing but Python packages has to be there.
"""

from __future__ import annotations

import argparse
import platform
import sys
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, packages_distributions, version as installed
from importlib.util import find_spec
from typing import Any

from symdyn.cli.talk import answer, print_table, print_text
from symdyn.extras import EXTRAS, install
from symdyn.resources import version
from symdyn.runtime import CACHE_VARIABLE, here
from symdyn.table import Table

PACKAGES = ("numpy", "scipy", "sympy", "mpmath", "python-flint", "jinja2", "rich", "platformdirs", "defusedxml")


def run(options: argparse.Namespace) -> int:
    """Look around and tell."""
    found = looked()
    answer(found, lambda: show(found))
    return 0


def looked() -> dict[str, Any]:
    """Return what is there, for JSON."""
    packages, machine = packages_distributions(), here()
    programs = machine.pop("programs")
    return {
        "symdyn": version(),
        "python": {"version": platform.python_version(), "path": sys.executable},
        "system": platform.platform(),
        "packages": {name: _version(name) for name in PACKAGES},
        **machine,
        "extras": [_extra(name, packages) for name in EXTRAS],
        "programs": programs,
    }


def _version(package: str) -> str | None:
    try:
        return installed(package)
    except PackageNotFoundError:
        return None


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


def show(result: Mapping[str, Any]) -> None:
    """Print what is there for people."""
    python, cache, compiler = result["python"], result["cache"], result["compiler"]
    print_text(f"symdyn {result['symdyn']}, Python {python['version']} ({python['path']}), {result['system']}")
    print_text(", ".join(f"{name} {version or 'MISSING'}" for name, version in result["packages"].items()) + "\n")
    used = f"{cache['entries']} files, {cache['bytes'] / 2**20:.0f} MB"
    unsafe = f"compiled for each process anew; give {CACHE_VARIABLE} a folder that only you may write to"
    headers = result["headers"]
    rows = [
        ("C compiler", compiler["version"] if compiler["works"] else f"no: {compiler['why']}", compiler["without"]),
        ("Python.h", headers["folder"] or "no", headers["without"]),
        ("cache", cache["folder"], None),
        ("", used if cache["safe"] else f"NOT SAFE: {cache['why']}", None if cache["safe"] else unsafe),
    ]
    rows += [(one["name"], one["path"] or "no", one["without"]) for one in result["programs"]]
    shown = [(a, b, c or "") for a, b, c in rows]
    print_table(Table(("", "found", "without it"), shown, title="Programs and folders"))
    extras = [
        (
            one["name"],
            ", ".join(f"{module} {version or 'missing'}" for module, version in one["modules"].items()),
            one["without"] or "",
            "" if one["there"] else one["install"],
        )
        for one in result["extras"]
    ]
    print_table(Table(("", "found", "without it", "to install"), extras, title="Extras"))
