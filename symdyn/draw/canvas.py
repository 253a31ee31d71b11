"""Matplotlib, imported safely and with settings that are its own: what rasterises, and writes PDF."""

from __future__ import annotations

import contextlib
import importlib.util
import io
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from symdyn import shell
from symdyn.errors import DrawError
from symdyn.extras import install

METADATA: Mapping[str, dict[str, None]] = {
    "svg": {"Date": None},
    "png": {"Software": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}
"""What files would tell of the program, its version and the day, by the kind of file: the kinds that are written."""


def import_matplotlib() -> Any:
    """Return matplotlib, imported where no stranger's file lies.

    As it is imported it reads a file matplotlibrc in the current folder, which may have come with a scene: one that is
    no text ends the import, and one that is text may ask for a program to typeset with.
    """
    if "matplotlib" not in sys.modules:
        spec = importlib.util.find_spec("matplotlib")
        assert spec is not None, "who draws has seen that it is importable"
        assert spec.origin is not None, "a package that is imported has a file"
        with contextlib.chdir(Path(spec.origin).parent / "mpl-data"):  # where its own defaults are
            found = importlib.import_module("matplotlib")
            with undocumented():
                importlib.import_module("matplotlib.figure")
            return found
    return sys.modules["matplotlib"]


@contextlib.contextmanager
def undocumented() -> Iterator[None]:
    """Let artists be imported without lists of their properties for `help`, in a process that is the shell's own.

    Those take a third of the time. In the processes of others they are written.
    """
    if not shell.is_own():
        yield
        return
    artist: Any = importlib.import_module("matplotlib.artist")
    written, artist.kwdoc = artist.kwdoc, lambda _: ""
    try:
        yield
    finally:
        artist.kwdoc = written


def require(what: str, *modules: str) -> None:
    """Raise DrawError where a package of the extra "plot" is missing that something is made with."""
    for module in modules:
        if importlib.util.find_spec(module) is None:
            raise DrawError(f"{what} need {module}; {install('plot')}")


@contextlib.contextmanager
def settings(more: Mapping[str, Any]) -> Iterator[None]:
    """Have matplotlib's own settings and these, whatever stands in files of the user or of the program around us."""
    mpl = import_matplotlib()
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(more)
        yield


def saved(figure: Any, kind: str, dpi: float) -> bytes:
    """Return a figure as a file of a kind of `METADATA`; the same figure, the same bytes."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format=kind, dpi=dpi, metadata=METADATA[kind])
    return buffer.getvalue()
