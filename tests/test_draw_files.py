"""Pictures in files: what rsvg-convert, Chromium, Qt, poppler and matplotlib show of one drawing is one picture."""

from __future__ import annotations

import io
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from arms import EXAMPLES
from browser import chromium, window

from symdyn.draw import free_body, picture
from symdyn.draw.paint import painted
from symdyn.draw.pictures import drawing
from symdyn.draw.plots import FilledFigure, outlined
from symdyn.draw.style import SCHEMES, Text
from symdyn.draw.svg import Drawing, svg
from symdyn.errors import DrawError
from symdyn.scene import read

image = pytest.importorskip("matplotlib.image", reason="needs matplotlib, the extra plot")

SCENES = ("four_bar", "puma560", "rolling_disc", "cart_pole")
ROOT = Path(__file__).parent.parent


def pixels(data: bytes) -> np.ndarray:
    """Return the pixels of a PNG, 0 to 255, shape (height, width, 3)."""
    return np.round(255 * image.imread(io.BytesIO(data))[:, :, :3])


def alike(first: np.ndarray, second: np.ndarray) -> None:
    """Fail unless two pictures differ at edges alone, by which programs blend colours as they like."""
    height, width = (min(a, b) for a, b in zip(first.shape[:2], second.shape[:2], strict=True))
    assert abs(first.shape[0] - second.shape[0]) <= 1
    assert abs(first.shape[1] - second.shape[1]) <= 1
    off = np.abs(first[:height, :width] - second[:height, :width]).max(axis=2)
    assert off.mean() < 1.5, off.mean()
    assert (off > 128).mean() < 1e-3, (off > 128).mean()


def bare(name: str) -> Drawing:
    """Return the drawing of an example without letters, which programs take from fonts that are installed."""
    return replace(drawing(read(EXAMPLES / f"{name}.toml")), labels=())


def ours(name: str, scheme: str = "light") -> np.ndarray:
    return pixels(painted(bare(name), "png", scheme))


@pytest.mark.long(0)
@pytest.mark.runs("rsvg-convert")
@pytest.mark.parametrize("name", SCENES)
def test_librsvg_and_matplotlib_draw_one_picture(name: str, tmp_path: Path) -> None:
    (tmp_path / "a.svg").write_text(svg(bare(name)))
    png = subprocess.run(["rsvg-convert", "-z", "2", str(tmp_path / "a.svg")], check=True, capture_output=True).stdout

    alike(pixels(png), ours(name))


@pytest.mark.long(0)
@pytest.mark.runs("chromium")
def test_chromium_draws_it_too_and_in_the_dark(tmp_path: Path) -> None:
    with chromium() as browser:
        for scheme in ("light", "dark"):
            page = window(browser, color_scheme=scheme, device_scale_factor=2)
            for name in SCENES[1:3]:
                path = tmp_path / f"{name}.svg"
                path.write_text(svg(bare(name)))
                page.goto(path.as_uri())
                alike(pixels(page.locator("svg").screenshot()), ours(name, scheme))


@pytest.mark.long(0)
@pytest.mark.runs("pdftoppm")
@pytest.mark.parametrize("name", SCENES[:2])
def test_a_pdf_is_the_picture(name: str, tmp_path: Path) -> None:
    (tmp_path / "a.pdf").write_bytes(painted(bare(name), "pdf"))
    line = ["pdftoppm", "-r", "192", "-png", "-singlefile", str(tmp_path / "a.pdf")]  # an inch has 96 units
    png = subprocess.run(line, check=True, capture_output=True).stdout

    alike(pixels(png), ours(name))


QT = """
import sys
from PySide6.QtGui import QColor, QGuiApplication, QImage, QPainter
from PySide6.QtSvg import QSvgRenderer
app = QGuiApplication(["qt", "-platform", "offscreen"])
for path in sys.argv[1:]:
    renderer = QSvgRenderer(path)
    shown = QImage(renderer.defaultSize() * 2, QImage.Format.Format_RGB32)
    shown.fill(QColor("white"))
    painter = QPainter(shown)
    renderer.render(painter)
    painter.end()
    shown.save(path + ".png")
"""


@pytest.mark.slow
@pytest.mark.runs
def test_qt_draws_it_too(tmp_path: Path) -> None:
    place = ROOT / "build" / "qt"
    python = place / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", str(place)], check=True)
        subprocess.run([str(python), "-m", "pip", "install", "-q", "PySide6-Essentials"], check=True)
    for name in SCENES:
        (tmp_path / f"{name}.svg").write_text(svg(bare(name)))
    paths = [str(tmp_path / f"{name}.svg") for name in SCENES]
    subprocess.run([str(python), "-c", QT, *paths], check=True)

    for name in SCENES:
        alike(pixels((tmp_path / f"{name}.svg.png").read_bytes()), ours(name))


@pytest.mark.parametrize("kind", ["png", "pdf"])
def test_the_same_picture_is_the_same_bytes_and_tells_no_day_or_version(kind: str) -> None:
    shown = drawing(read(EXAMPLES / "two_link.toml"))
    data = painted(shown, kind)

    assert data == painted(shown, kind)
    for word in (b"Date", b"Producer", b"Creator", b"matplotlib", b"Software"):
        assert word not in data


def test_letters_are_drawn_where_the_labels_are() -> None:
    scene = read(EXAMPLES / "four_bar.toml")
    with_names, without = (pixels(painted(drawing(scene, labels=kinds), "png")) for kinds in (("bodies",), ()))
    shown = drawing(scene, labels=("bodies",))
    left, top, _, _ = shown.box

    for one in shown.labels:
        (x0, y0), (x1, y1) = np.round((one.box[0] - (left, top)) * 2).astype(int)
        inked = (with_names != without).any(axis=2)[y0:y1, x0:x1]
        if one.label.id.startswith("label-body"):
            assert 0.1 < inked.mean() < 0.9, one.label.id
    assert with_names.shape == without.shape


def test_names_that_no_font_has_are_outlined_all_the_same(recwarn: pytest.WarningsRecorder) -> None:
    for name in ("\u9023\u687f", "\U0001f600", "\u0161\u0165\u00e1va q\u0307", "a\nb"):
        assert len(outlined(Text.of_part(name)).vertices), name
    assert not recwarn.list


def test_the_paper_is_that_of_the_scheme(tmp_path: Path) -> None:
    scene = read(EXAMPLES / "two_link.toml")
    for scheme in SCHEMES:
        free_body(scene, "link1", scheme=scheme, file=tmp_path / "a.png")
        paper = tuple(int(x) for x in pixels((tmp_path / "a.png").read_bytes())[0, 0])
        assert paper == tuple(bytes.fromhex(SCHEMES[scheme]["paper"][1:]))


def test_faults_come_before_work_and_say_what_would_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = read(EXAMPLES / "two_link.toml")

    with pytest.raises(DrawError, match=r"pictures are written to \.svg, \.pdf, \.png files"):
        picture(scene, file=tmp_path / "a.gif")
    (tmp_path / "full").write_text("")
    with pytest.raises(DrawError, match="there is no folder"):
        picture(scene, file=tmp_path / "full" / "a.png")
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(DrawError, match=r'pip install "symdyn\[plot\]"'):
        picture(scene, file=tmp_path / "a.pdf")
    assert picture(scene, file=tmp_path / "a.svg") == (tmp_path / "a.svg").read_text()


def test_a_plot_is_the_same_whatever_the_last_digits_of_its_layout_are(monkeypatch):
    engine = pytest.importorskip("matplotlib.layout_engine").ConstrainedLayoutEngine
    plot = FilledFigure("pendulum", (4, 3), lambda figure: figure.subplots(2).flat[0].plot([0, 1], [1, 0]))
    first, place = plot.picture("svg"), engine.execute

    def elsewhere(self, figure):
        place(self, figure)
        for axes in figure.axes:
            axes.set_position([x + 1e-14 for x in axes.get_position(original=True).bounds])
            axes.set_in_layout(True)

    monkeypatch.setattr(engine, "execute", elsewhere)

    assert plot.picture("svg") == first
