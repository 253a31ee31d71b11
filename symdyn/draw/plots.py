"""Plots: figures of matplotlib, the same bytes on every machine.

Matplotlib, which rasterises and writes PDF, is imported safely and with settings that are its own. Letters are outlines
from the fonts that come with it, whatever is installed.
"""

from __future__ import annotations

import contextlib
import importlib.util
import io
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cache, partial
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from symdyn import shell
from symdyn.draw.places import Array
from symdyn.draw.style import DROP, FONT, SMALL, Text
from symdyn.errors import DrawError
from symdyn.extras import install
from symdyn.frozen import dataclass

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


METADATA: Mapping[str, dict[str, None]] = {
    "svg": {"Date": None},
    "png": {"Software": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}
"""What files would tell of the program, its version and the day, by the kind of file: the kinds that are written."""


def import_matplotlib() -> Any:
    """Return matplotlib, imported where no stranger's file lies.

    As it is imported it reads a file matplotlibrc in the current folder, which may have come with a scene: one that is
    no text ends the import, and one that is text may ask for a program to typeset with. DrawError where it is missing.
    """
    if "matplotlib" not in sys.modules:
        require("plots", "matplotlib")
        spec = importlib.util.find_spec("matplotlib")
        assert spec is not None
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
    with _placed(figure):
        figure.savefig(buffer, format=kind, dpi=dpi, metadata=METADATA[kind])
    return buffer.getvalue()


@contextlib.contextmanager
def _placed(figure: Any) -> Iterator[None]:
    """Have the axes of a figure where its layout puts them, rounded: its last digits differ from run to run."""
    layout = figure.get_layout_engine()
    if layout is None:
        yield
        return
    place = layout.execute

    def rounded(figure: Any) -> Any:
        found = place(figure)
        for axes in figure.axes:
            kept = axes.get_in_layout()
            axes.set_position([round(x, 9) for x in axes.get_position(original=True).bounds])
            axes.set_in_layout(kept)
        return found

    layout.execute = rounded
    try:
        yield
    finally:
        del layout.execute


MOST_POINTS = 20_000
"""Points of curves beyond which dots make a smaller picture than lines."""

DPI = 150

SETTINGS: dict[str, Any] = {"svg.fonttype": "path", "axes.formatter.useoffset": False}
"""Letters are outlines: what is above another one, as the dots of rates, librsvg and Qt would put elsewhere."""


@dataclass(frozen=True)
class FilledFigure:
    """A plot, for which matplotlib must be installed.

    Attributes:
        title: above it; no mathematics, whatever a scene is called.
        size: width and height, inches.
        fill: draws on a figure that has no axes yet.
        letters: size of letters, points.
        headed: whether the title is shown.
    """

    title: str
    size: tuple[float, float]
    fill: Callable[[Any], None]
    letters: float = 9.0
    headed: bool = True

    @property
    def settings(self) -> dict[str, Any]:
        return SETTINGS | {"font.size": self.letters, "svg.hashsalt": self.title}

    def picture(self, kind: str) -> bytes:
        """Return it as "svg", "pdf" or "png"; the same plot, the same bytes."""
        import_matplotlib()
        with settings(self.settings):
            return saved(self._made(), kind, DPI)

    def figure(self, points: int, axes: Axes | Sequence[Axes] | None = None) -> Figure:
        """Return a figure that a notebook shows: as SVG, or as PNG where it has many points; or that of given axes."""
        if axes is not None:
            self.fill(SimpleNamespace(subplots=partial(_given, axes)))
            return np.ravel(np.asarray(axes))[0].figure  # type: ignore[no-any-return]
        with settings(self.settings):
            found = self._made()
        kind = ("svg", "image/svg+xml") if points <= MOST_POINTS else ("png", "image/png")
        found._repr_mimebundle_ = partial(_bundle, found, self.settings, *kind)  # type: ignore[attr-defined]
        return found

    def _made(self) -> Figure:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        made = Figure(figsize=self.size, layout="constrained")
        FigureCanvasAgg(made)
        self.fill(made)
        if self.headed:
            made.suptitle(self.title, x=0.01, ha="left").set_parse_math(False)
        return made


def _given(axes: Any, rows: int = 1, columns: int = 1, squeeze: bool = True, **_: object) -> Any:
    """Return axes of a user's figure as `Figure.subplots` does, shape (rows, columns)."""
    given: Any = ()
    with suppress(ValueError, RecursionError):  # lists in themselves, of other lengths
        given = np.asarray(axes, object).ravel()
    if len(given) != rows * columns or not all(hasattr(one, "get_xlim") for one in given):
        many = f"{rows * columns} axes" if rows * columns > 1 else "one axes"
        raise DrawError(f"axes: give {many} of matplotlib, such as pyplot.subplots({rows}, {columns})[1]")
    found = given.reshape(rows, columns)
    return found.squeeze()[()] if squeeze else found


def _bundle(
    figure: Figure, chosen: Mapping[str, Any], kind: str, media: str, include: object = None, exclude: object = None
) -> dict[str, str | bytes]:
    """Return what a notebook shows of a figure, as it is now."""
    with settings(chosen):
        picture = saved(figure, kind, DPI)
    return {media: picture.decode() if kind == "svg" else picture, "text/plain": repr(figure)}


FACES = {"": "STIXGeneral.ttf", "i": "STIXGeneralItalic.ttf", "t": "DejaVuSansMono.ttf"}
"""Faces of runs; STIX is what style sheets of pictures ask for first."""

WIDEST = "DejaVuSans.ttf"
"""Has what the face of a run lacks; what it lacks too is shown as a box."""

EM = 100.0


@dataclass(frozen=True)
class Outline:
    """Vertices, shape (n, 2), and what leads to each, as matplotlib codes them; units of the picture, y down."""

    vertices: Array
    codes: Any


@cache
def outlined(text: Text) -> Outline:
    """Return a name as outlines, centred on (0, 0), which lies on its line."""
    vertices, codes, x = [np.zeros((0, 2))], [np.zeros(0, dtype=np.uint8)], 0.0
    for run in text.runs:
        size = FONT * (SMALL if run.level else 1.0) / EM
        for character in run.text:
            glyph, verbs, wide = _glyph(FACES[run.face], character)
            vertices.append(glyph * (size, -size) + (x, -run.level * DROP * FONT))
            codes.append(verbs)
            x += wide * size
    return Outline(np.concatenate(vertices) - (x / 2, 0), np.concatenate(codes))


@cache
def _glyph(name: str, character: str) -> tuple[Array, Any, float]:
    """Return the outline of a character at a size of EM, y up, and how far the next one stands."""
    font = _font(name) if _font(name).get_char_index(ord(character)) else _font(WIDEST)
    found = font.load_glyph(font.get_char_index(ord(character)), flags=_unhinted())  # 0 where there is none: a box
    vertices, codes = font.get_path()
    return np.array(vertices).reshape(-1, 2), np.array(codes, dtype=np.uint8), found.linearHoriAdvance / 65536


@cache
def _font(name: str) -> Any:
    mpl = import_matplotlib()
    from matplotlib.ft2font import FT2Font

    font = FT2Font(str(Path(mpl.get_data_path()) / "fonts" / "ttf" / name))
    font.set_size(EM, 72)
    return font


@cache
def _unhinted() -> Any:
    """Return the flag of outlines as they were designed, by whichever name matplotlib has it."""
    from matplotlib import ft2font

    flags: Any = getattr(ft2font, "LoadFlags", None)
    return vars(ft2font)["LOAD_NO_HINTING"] if flags is None else flags.NO_HINTING
