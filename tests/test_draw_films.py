"""Films: as many frames as were asked for, of the size that was, each the picture of its moment."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from arms import EXAMPLES, two_link
from browser import chromium, opened

import symdyn
from symdyn.cli import main
from symdyn.draw import film
from symdyn.draw.animate import moving
from symdyn.draw.paint import Painter
from symdyn.draw.style import LIGHT
from symdyn.errors import DrawError
from symdyn.scene import read
from symdyn.simulation import simulate

Image = pytest.importorskip("PIL.Image", reason="needs matplotlib, the extra plot")

T = np.linspace(0.0, 1.0, 21)
Q = np.stack([np.sin(3 * T), np.cos(2 * T)], axis=1)


def drawn(moment: float, size: tuple[int, int]) -> np.ndarray:
    """Return what is painted of the motion at a moment, counted in positions that are given."""
    drawing, t = moving(two_link(), T, Q, None, None, 30.0)
    assert len(t) == len(T)
    return Painter(drawing, size)(moment).astype(int)


def gif(path: Path) -> list[np.ndarray]:
    with Image.open(path) as shown:
        frames = []
        for k in range(shown.n_frames):
            shown.seek(k)
            frames.append(np.asarray(shown.convert("RGB")).astype(int))
        return frames


@pytest.mark.long
def test_a_gif_has_every_frame_at_its_time(tmp_path: Path) -> None:
    path = film(two_link(), T, Q, tmp_path / "a.gif", fps=15, size=(320, 240))
    frames = gif(path)
    with Image.open(path) as shown:
        lasting = []
        for k in range(shown.n_frames):
            shown.seek(k)
            lasting.append(shown.info["duration"])
        assert shown.info["loop"] == 0

    assert len(frames) == 16
    assert sum(lasting) == pytest.approx(16 / 15 * 1000, abs=10)
    assert set(lasting) == {60, 70}
    for k in (0, 7, 15):
        off = np.abs(frames[k] - drawn(k / 15 * 20, (320, 240))).max(axis=2)
        assert off.mean() < 1.0, k
    assert np.abs(frames[0] - frames[8]).max() > 100
    assert tuple(frames[3][0, 0]) == tuple(bytes.fromhex(LIGHT["paper"][1:]))
    assert path.read_bytes() == film(two_link(), T, Q, tmp_path / "b.gif", fps=15, size=(320, 240)).read_bytes()


@pytest.mark.long
def test_a_gif_that_plays_once_has_no_loop(tmp_path: Path) -> None:
    path = film(two_link(), T, Q, tmp_path / "a.gif", fps=5, size=120, loop=False)

    assert b"NETSCAPE" not in path.read_bytes()
    with Image.open(path) as shown:
        assert shown.width == 120


def decoded(path: Path, width: int, height: int) -> list[np.ndarray]:
    import imageio_ffmpeg

    frames = imageio_ffmpeg.read_frames(str(path))
    about = next(frames)
    assert about["size"] == (width, height)
    return [np.frombuffer(frame, dtype=np.uint8).reshape(height, width, 3).astype(int) for frame in frames]


@pytest.mark.long(0)
@pytest.mark.runs
def test_an_mp4_has_every_frame_and_tells_nothing_of_who_made_it(tmp_path: Path) -> None:
    pytest.importorskip("imageio_ffmpeg", reason="needs imageio-ffmpeg, the extra plot")
    path = film(two_link(), T, Q, tmp_path / "a.mp4", fps=10, size=(320, 240))
    frames = decoded(path, 320, 240)

    assert len(frames) == 11
    for k in (0, 4, 10):
        assert np.abs(frames[k] - drawn(2 * k, (320, 240))).mean() < 3, k
    assert np.abs(frames[0] - frames[5]).max() > 100
    assert not re.search(rb"x264 - core|20\d\d-\d\d-\d\d|Lavc\d|Lavf\d", path.read_bytes())
    assert path.read_bytes() == film(two_link(), T, Q, tmp_path / "b.mp4", fps=10, size=(320, 240)).read_bytes()


AGAIN = "(window.furthest = Math.max(window.furthest ?? 0, Number(time.value))) > Number(time.value)"
"""Whether a film has begun again, looked at once a picture."""


@pytest.mark.slow
@pytest.mark.long(0)
@pytest.mark.runs("chromium")
def test_pages_and_pictures_play_once_or_for_ever(tmp_path: Path) -> None:
    short = (two_link(), T[:7], Q[:7])
    with chromium() as browser:
        for loop in (True, False):
            page_path = film(*short, tmp_path / f"page{loop}.html", fps=20, loop=loop)
            with opened(browser, page_path) as page:
                page.wait_for_function(AGAIN if loop else "time.value === time.max && play.textContent === 'Play'")
                assert page.inner_text("#play") == ("Pause" if loop else "Play")
    once, always = (film(*short, tmp_path / "a.svg", size=(300, 200), loop=k).read_text() for k in (False, True))

    assert 'repeatCount="indefinite"' in always
    assert "repeatCount" not in once
    assert 'fill="freeze"' in once
    assert 'width="300" height="200">' in once


@pytest.mark.parametrize(
    ("file", "more", "message"),
    [
        ("a.avi", {}, r"written to \.html, \.svg, \.gif, \.glb, \.mp4"),
        ("a.gif", {"fps": 60}, "at most 50"),
        ("a.html", {"fps": 0}, "more than 0"),
        ("a.mp4", {"fps": float("nan")}, "more than 0"),
        ("a.html", {"size": 300}, r"a size in pixels belongs to \.svg, \.gif, \.mp4"),
        ("a.mp4", {"loop": False}, r"playing once belongs to \.html, \.svg, \.gif"),
        ("a.glb", {"size": 300}, "a size in pixels belongs to"),
        ("a.mp4", {"size": (321, 240)}, "even numbers"),
        ("a.gif", {"size": (3, 9000)}, "16 to 4096 a side"),
        ("none/full/a.gif", {}, "there is no folder"),
    ],
)
def test_what_no_film_can_be_is_told(file: str, more: dict[str, object], message: str, tmp_path: Path) -> None:
    (tmp_path / "none").write_text("")
    with pytest.raises(DrawError, match=message):
        film(two_link(), T[:3], Q[:3], tmp_path / file, **more)
    assert [path.name for path in tmp_path.iterdir()] == ["none"]


def test_a_film_that_never_ends_is_refused_before_it_is_drawn(tmp_path: Path) -> None:
    with pytest.raises(DrawError, match="more than 18000 frames; give fewer a second"):
        film(two_link(), [0.0, 1e6], Q[:2], tmp_path / "a.gif")
    with pytest.raises(DrawError, match=r"more than a \.gif can be made of; give a smaller size or fewer frames"):
        film(two_link(), [0.0, 100.0], Q[:2], tmp_path / "a.gif")
    with pytest.raises(DrawError, match="must be finite"):
        film(two_link(), [0.0, float("inf")], Q[:2], tmp_path / "a.svg")


def test_a_package_that_is_missing_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == "imageio_ffmpeg" else name)
    with pytest.raises(DrawError, match=r'\.mp4 files need imageio_ffmpeg; pip install "symdyn\[plot\]"'):
        film(two_link(), T, Q, tmp_path / "a.mp4")


@pytest.mark.runs
@pytest.mark.long(0)
def test_an_ffmpeg_that_fails_leaves_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", "false")
    import imageio_ffmpeg._utils as found

    found.get_ffmpeg_exe.cache_clear() if hasattr(found.get_ffmpeg_exe, "cache_clear") else None
    with pytest.raises(DrawError, match="ffmpeg made no film"):
        film(two_link(), T, Q, tmp_path / "a.mp4", fps=5, size=64)
    assert not list(tmp_path.iterdir())


@pytest.mark.long(0)
@pytest.mark.runs
def test_three_verbs_write_films(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["--fps", "5", "--size", "200x120"]
    pendulum = str(EXAMPLES / "double_pendulum.toml")

    assert (
        main(
            [
                "simulate",
                pendulum,
                "--until",
                "0.4",
                "--start",
                "q1=1",
                "--method",
                "dop853",
                "--animate",
                "a.gif",
                *words,
            ]
        )
        == 0
    )
    motion = ["--motion", "q1=sin(t)", "q2=0", "--until", "0.4"]
    assert main(["inverse", pendulum, *motion, "--animate", "b.gif", "--once", *words]) == 0
    assert main(["linearize", pendulum, "--start", "q1=0,q2=0", "--animate", "c.gif", *words]) == 0
    said = capsys.readouterr()
    assert {"a.gif", "b.gif"} <= set(said.out.split())
    assert [len(gif(Path(name))) for name in ("a.gif", "b.gif")] == [3, 3]
    modes = sorted(tmp_path.glob("c-*.gif"))
    assert len(modes) == 2
    assert gif(modes[0])[0].shape == (120, 200, 3)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("--animate a.gif --size 10cm", "--size 10cm: give width and height in pixels"),
        ("--animate a.mp4 --once", "playing once belongs to"),
        ("--fps 20", "--fps: of --animate, which is not given"),
        ("--animate a.gif --fps 0", "0 frames a second"),
    ],
)
@pytest.mark.parametrize("verb", ["simulate --until 1", "linearize"])
def test_a_mistake_is_one_line(verb: str, line: str, message: str, capsys: pytest.CaptureFixture[str]) -> None:
    first, *more = verb.split()

    assert main([first, str(EXAMPLES / "double_pendulum.toml"), *more, *line.split()]) == 1
    said = capsys.readouterr().err
    assert message in said
    assert said.count("\n") == 1


def test_pages_and_pictures_keep_as_many_moments_a_second(tmp_path: Path) -> None:
    page, shown = (film(two_link(), T, Q, tmp_path / name, fps=4).read_text() for name in ("a.html", "a.svg"))

    assert json.loads(re.search(r'type="application/json">(.*?)</script>', page)[1])["t"] == [0, 0.25, 0.5, 0.75, 1]
    assert {text.count(";") for text in re.findall(r'attributeName="c[xy]" values="([^"]*)"', shown)} == {4}


@pytest.mark.runs
@pytest.mark.long(0)
def test_a_run_writes_its_film(tmp_path: Path) -> None:
    run = simulate(read(EXAMPLES / "double_pendulum.toml"), until=0.2, start={"q1": 1.0}, method="dop853")
    path = run.film(tmp_path / "a.gif", fps=10, size=64, loop=False)

    assert len(gif(path)) == 3
    assert symdyn.film(run, tmp_path / "b.gif", fps=10, size=64, loop=False).read_bytes() == path.read_bytes()
    assert run.animate() == symdyn.animation(run) == symdyn.animation(run.scene, run.t, run.q)
    for wrong, message in (
        (lambda: symdyn.film(run), "film: there is no file; give a name such as film.gif"),
        (lambda: symdyn.film(run, run.t, run.q, tmp_path / "c.gif"), "a run has times and positions of its own"),
        (lambda: symdyn.animation(run.scene, run.t), "a scene moves by times and positions: give both behind it, or a"),
        (lambda: symdyn.film(run.scene, tmp_path / "c.gif"), "a scene moves by times and positions: give both behind"),
    ):
        with pytest.raises(DrawError, match=message):
            wrong()


FAR = np.linspace(0.0, 5.0, 101)


def ridden(length: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a motion of a cart that goes so far, its pole turning."""
    return FAR, np.stack([length * FAR / 5, 0.3 * np.sin(3 * FAR)], axis=1)


def test_a_film_goes_with_what_travels_far_and_fills_the_frame(tmp_path: Path) -> None:
    scene = read(EXAMPLES / "cart_pole.toml")
    near, _ = moving(scene, *ridden(0.3), None, None)
    far, t = moving(scene, *ridden(20.0), None, None)
    assert near.camera is None
    assert far.camera is not None
    assert far.camera.shape == (len(t), 2)
    assert np.ptp(far.camera[:, 1]) == 0.0
    assert np.diff(far.camera[:, 0]) == pytest.approx(float(np.ptp(far.camera[:, 0])) / (len(t) - 1), rel=0.05)

    (left, top, width, height), sizes = far.box, []
    for item in far.items:
        if item.id in ("body-pole", "joint-hinge", "gravity"):
            inside = far.framed(
                np.concatenate([shape.points for shape in item.shapes if len(shape.points) > 1], axis=1)
            )
            assert inside[..., 0].min() > left
            assert inside[..., 1].min() > top
            assert inside[..., 0].max() < left + width
            assert inside[..., 1].max() < top + height
            sizes.append(float(np.ptp(inside[..., 1])))
    assert max(sizes) > 0.5 * height

    page, shown = (film(scene, *ridden(20.0), tmp_path / name).read_text() for name in ("a.html", "a.svg"))
    frames = json.loads(re.search(r'type="application/json">(.*?)</script>', page)[1])["view"]
    assert len(frames) == len(t)
    assert f'viewBox="{frames[0]}"' in page
    assert f'<animate attributeName="viewBox" values="{";".join(frames)}" dur="5s"' in shown
    assert "view" not in json.loads(
        re.search(r'type="application/json">(.*?)</script>', symdyn.animation(scene, *ridden(0.3)))[1]
    )


def test_frames_of_a_film_that_goes_along_are_painted_where_the_page_shows_them() -> None:
    """The pole stands still in the frame of a steady ride, and the ground goes by."""
    scene = read(EXAMPLES / "cart_pole.toml")
    t, q = ridden(20.0)
    drawing, _ = moving(scene, t, q * [1, 0], None, None)
    first, last = (Painter(drawing, (400, 400))(moment).astype(int) for moment in (30, 70))
    red = [np.argwhere(one[:, :, 0] > one[:, :, 2] + 60).mean(axis=0) for one in (first, last)]
    assert np.abs(red[0] - red[1]).max() < 2
    assert np.abs(first - last).max() > 100


def test_paths_of_points_are_finer_than_frames() -> None:
    scene = read(EXAMPLES / "double_pendulum.toml")
    t = np.linspace(0, 1, 101)
    drawing, kept = moving(scene, t, np.stack([t, t], axis=1), None, None, 10.0)

    assert len(kept) == 11
    traces = [shape for item in drawing.items if item.id.startswith("trace-") for shape in item.shapes]
    assert [shape.parts for shape in traces] == [(101,)]
