"""The ufunc target compiled against this Python and this NumPy, and imported from the cache."""

from __future__ import annotations

import sys
import sysconfig
from functools import partial
from importlib.machinery import EXTENSION_SUFFIXES, ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import numpy as np

from symdyn.emit import Sources
from symdyn.errors import MissingCompiler
from symdyn.runtime.compiler import PATIENCE, find_compiler
from symdyn.runtime.dialects import Needs
from symdyn.runtime.library import LibraryKind, load_library
from symdyn.runtime.warned import check_target

INCLUDE = Path(sysconfig.get_path("include"))
"""Where Python's headers are; asked once, since several threads that ask first at a time get half an answer."""


def build_extension(
    sources: Sources,
    compiler: str | None = None,
    patience: float = PATIENCE,
    machine: str = "native",
) -> tuple[Path, ModuleType]:
    """Return the extension module of sources that `emit(program, "ufunc")` made, and its file.

    Args:
        sources: of target "ufunc".
        compiler: as for `symdyn.runtime.build`.
        patience: likewise.
        machine: likewise.

    Raises:
        BuildError: sources of another target, no headers of Python, no compiler, or its own words when it refuses.
    """
    check_target(sources, "ufunc")
    kind = extension_kind(Path(sources.files[0][0]).stem)
    path, module = load_library(sources.texts, find_compiler(compiler, machine), patience, kind)
    assert isinstance(module, ModuleType), "an extension's kind opens modules"
    module.__file__ = str(path)
    return path, module


def extension_kind(name: str) -> LibraryKind:
    """Return how an extension module of this Python and this NumPy is compiled, and opened under a name.

    Raises:
        MissingCompiler: there are no headers of Python.
    """
    suffix = EXTENSION_SUFFIXES[0]
    needs = Needs(
        headers=(python_headers(), np.get_include()),
        libraries=python_libraries(),
        loose=sys.platform == "darwin",
    )
    return LibraryKind(suffix, needs, (sys.version, suffix, np.__version__), partial(imported, name))


def python_headers() -> str:
    """Return the folder of Python.h.

    Raises:
        MissingCompiler: it is not installed.
    """
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
