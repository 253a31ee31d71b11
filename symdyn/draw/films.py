"""A motion in a file, by its ending: pages and pictures of our own, GIF and MP4 frame by frame, and glTF.

Frames are painted by matplotlib for both; Pillow writes GIF and ffmpeg, as imageio-ffmpeg brings it, MP4. A GIF has 256
colours for all frames of a film, and the nearest of them for every pixel.
"""

from __future__ import annotations

import math
import shutil
import tempfile
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from operator import index
from os import PathLike
from pathlib import Path
from typing import IO, Any

import numpy as np

from symdyn.arguments import checked, native
from symdyn.draw.animate import Moved, animation, as_arrays, moments, motion_of, moving, moving_picture
from symdyn.draw.gltf import glb, standing
from symdyn.draw.paint import File, Frame, Painter
from symdyn.draw.places import Array
from symdyn.draw.plots import require
from symdyn.draw.robot_meshes import robot_solids
from symdyn.draw.stage import Stage
from symdyn.draw.svg import Drawing
from symdyn.emit import Contents, write_file
from symdyn.errors import DrawError
from symdyn.frozen import dataclass
from symdyn.scene import Scene, SceneLike

FRAMES, EXACT = 9, 32  # frames that the colours of a GIF are taken from, and colours that are not mixed


def palette_of(shown: Sequence[Frame]) -> Frame:
    """Return 256 colours for all frames, taken from some of them, so that none flickers; those of faces are exact."""
    from PIL import Image

    packed, counts = np.unique(np.concatenate([_packed(one).ravel() for one in shown]), return_counts=True)
    colours = _unpacked(packed)
    exact = colours[np.argsort(-counts, kind="stable")[:EXACT]]
    mixed = Image.fromarray(colours[None]).quantize(256 - EXACT, method=Image.Quantize.MEDIANCUT).getpalette() or []
    found = np.concatenate([exact, np.array(mixed, dtype=np.uint8).reshape(-1, 3)])[:256]
    return np.concatenate([found, np.repeat(found[:1], 256 - len(found), axis=0)])


def _packed(frame: Frame) -> Any:
    return frame.astype(np.uint32) @ np.array([65536, 256, 1], dtype=np.uint32)


def _unpacked(packed: Any) -> Frame:
    return np.stack([packed >> 16, packed >> 8 & 255, packed & 255], axis=-1).astype(np.uint8)


class Nearest:
    """Gives every pixel of a frame its nearest colour of a palette; Pillow looks for one that is about as near."""

    def __init__(self, palette: Frame) -> None:
        from scipy.spatial import KDTree

        self.palette, self.tree = palette, KDTree(palette.astype(np.float64))
        self.known = np.full(2**24, -1, dtype=np.int16)

    def __call__(self, frame: Frame) -> Any:
        from PIL import Image

        packed = _packed(frame)
        new = np.unique(packed[self.known[packed] < 0])
        if len(new):
            self.known[new] = self.tree.query(_unpacked(new).astype(np.float64))[1]
        image = Image.fromarray(self.known[packed].astype(np.uint8))
        image.putpalette(self.palette.tobytes())
        return image


@dataclass(frozen=True)
class Reel:
    """How a film is shown.

    Attributes:
        fps: frames, or moments that are kept, a second of real time; None for what is usual of the kind of file.
        size: width in pixels, or width and height; None for the size of the drawing.
        loop: whether it begins again at its end.
    """

    fps: float | None = None
    size: int | tuple[int, int] | None = None
    loop: bool = True

    @staticmethod
    def endings() -> tuple[str, ...]:
        """Return the endings of files that films are written to."""
        return tuple(FILMS)


FASTEST = 240.0  # frames a second
MOST_FRAMES = 18_000  # ten minutes at 30 a second
MOST_PIXELS = 400_000_000  # of all frames of a .gif, which are held in memory
SMALLEST, LARGEST = 16, 4096  # pixels of a side
SHARP, LONGEST = 2.0, 1280  # pixels a unit of the picture where no size is given, and pixels of a side, at most

Told = Callable[[float], None]
Painted = Callable[[int], Frame]


@dataclass(frozen=True)
class Motion:
    """What a film shows: as of `film`."""

    scene: Scene
    times: Array
    positions: Array
    parameters: Mapping[str, float] | None
    view: tuple[float, float] | None
    scheme: str
    progress: Told
    note: Callable[[str], None]


@dataclass(frozen=True)
class Film:
    """A kind of file."""

    write: Callable[[Motion, Reel, float], Contents]  # its contents
    fps: float  # what is usual
    takes: tuple[str, ...]  # fields of `Reel` that it has a place for
    needs: tuple[str, ...] = ()  # packages of the extra "plot"
    fastest: float = FASTEST  # frames a second that players show


@checked(DrawError)
def film(
    scene: SceneLike | Moved,
    times: Sequence[float] | Array | File | None = None,
    positions: Sequence[Sequence[float]] | Array | None = None,
    file: File | None = None,
    parameters: Mapping[str, float] | None = None,
    view: tuple[float, float] | None = None,
    scheme: str = "auto",
    fps: float | None = None,
    size: int | tuple[int, int] | None = None,
    loop: bool = True,
    reported: Told | None = None,
    note: Callable[[str], None] | None = None,
) -> Path:
    """Write a motion to a .html, .svg, .gif, .mp4 or .glb file and return its path; all of it or nothing.

    `film(run, "arm.gif")` is all that a run takes, `film(scene, times, positions, "arm.gif")` any other motion. Between
    two positions that are given, points of the picture move in straight lines.

    Args:
        scene: a run; or any scene, or where it is.
        times: of a scene, increasing, s; shape (N,).
        positions: of a scene, q at every time, shape (N, nq).
        file: where it goes, of a run behind it; the ending says what it becomes.
        parameters: values of parameters; those without any are as in `picture`.
        view: azimuth and elevation of the viewer in degrees; None chooses. A .glb is looked at from anywhere.
        scheme: "auto" (as the reader prefers; light in .gif, .mp4), "light" or "dark".
        fps: frames a second of real time; None for 30, 25 of a .gif, which shows 50 at most.
        size: width in pixels, or width and height, of .svg, .gif and .mp4.
        loop: whether a .html, .svg or .gif begins again at its end; of others, who plays them decides.
        reported: is called with the share that is done.
        note: is called with what a user should know, such as a mesh that could not be read.

    Raises:
        DrawError: as of `animation`; an ending that is not known, or something that such a file cannot hold; a
            package that is missing; or a file that cannot be written.

    >>> import symdyn, tempfile
    >>> scene = symdyn.example("cart_pole")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = symdyn.film(scene, [0, 1], [[0, 0], [0.2, 1]], folder + "/cart.svg", size=400, loop=False)
    ...     print(path.name, "freeze" in path.read_text())
    cart.svg True
    """
    if isinstance(times, str | PathLike):
        times, file = None, times if file is None else file
    if file is None:
        raise DrawError("film: there is no file; give a name such as film.gif, whose ending says what it becomes")
    shown = motion_of(scene, times, positions)
    (fps,), (loop,) = native(float, fps), native(bool, loop)
    reel = Reel(fps, _sides(size), loop)
    path = check_film(file, reel)
    kind = FILMS[path.suffix.lower()]
    reported, note = reported or (lambda share: None), note or (lambda line: None)
    motion = Motion(shown[0], *as_arrays(*shown), parameters, view, scheme, reported, note)
    write_file(path, kind.write(motion, reel, fps or kind.fps), DrawError)
    return path


def _sides(size: int | tuple[int, int] | None) -> int | tuple[int, int] | None:
    """Return a size, whatever library its numbers are of."""
    if size is None:
        return None
    try:
        return index(size)  # type: ignore[arg-type]
    except TypeError:
        width, height = native(int, *size)  # type: ignore[misc]
        return width, height


def check_film(file: File, reel: Reel | None = None) -> Path:
    """Return the path of a film.

    Raises:
        DrawError: an ending that no film has, something that such a file cannot hold, a size or a rate that is
            none, or a package that is missing.
    """
    path, reel = Path(file), reel or Reel()
    ending = path.suffix.lower()
    if ending not in FILMS:
        raise DrawError(f"{path}: animations are written to {', '.join(FILMS)} files")
    kind = FILMS[ending]
    for name, given in (("fps", reel.fps is not None), ("size", reel.size is not None), ("loop", not reel.loop)):
        if given and name not in kind.takes:
            having = ", ".join(other for other, one in FILMS.items() if name in one.takes)
            raise DrawError(f"{path}: {WORDS[name]} belongs to {having}; leave it out")
    if reel.fps is not None and not 0 < reel.fps <= kind.fastest:
        raise DrawError(f"{path}: {reel.fps:g} frames a second; give more than 0 and at most {kind.fastest:g}")
    sides = () if reel.size is None else (reel.size,) if isinstance(reel.size, int) else reel.size
    if any(not SMALLEST <= side <= LARGEST for side in sides):
        raise DrawError(f"{path}: {'x'.join(map(str, sides))} pixels; give {SMALLEST} to {LARGEST} a side")
    if ending == ".mp4" and any(side % 2 for side in sides):
        raise DrawError(f"{path}: {'x'.join(map(str, sides))} pixels; sides of an .mp4 are even numbers")
    require(f"{ending} files", *kind.needs)
    return path


WORDS = {"fps": "a number of frames a second", "size": "a size in pixels", "loop": "playing once"}


def _page(motion: Motion, reel: Reel, fps: float) -> str:
    given = (motion.scene, motion.times, motion.positions, motion.parameters, motion.view, motion.scheme)
    return animation(*given, fps=fps, loop=reel.loop)


def _picture(motion: Motion, reel: Reel, fps: float) -> str:
    given = (motion.scene, motion.times, motion.positions, motion.parameters, motion.view, motion.scheme)
    return moving_picture(*given, fps=fps, loop=reel.loop, size=reel.size)


# Frames


def _frames(motion: Motion, reel: Reel, fps: float, even: bool) -> tuple[tuple[int, int], int, Painted]:
    """Return width and height in pixels, the number of frames, and what paints one of them."""
    span = float(motion.times[-1] - motion.times[0]) if motion.times.size else 0.0
    if not span * fps < MOST_FRAMES:  # not finite neither
        told = f"{span:g} s at {fps:g} frames a second are more than {MOST_FRAMES} frames"
        raise DrawError(f"{motion.scene.name}: {told}; give fewer a second, or a shorter motion")
    drawing, t = moving(motion.scene, motion.times, motion.positions, motion.parameters, motion.view, fps, MOST_FRAMES)
    count = round(span * fps) + 1
    size = pixels(drawing, reel.size, even)
    paint = Painter(drawing, size, motion.scheme)

    def painted(k: int) -> Frame:
        motion.progress(k / count)
        return paint(float(np.interp(t[0] + k / fps, t, np.arange(len(t)))))

    return size, count, painted


def pixels(drawing: Drawing, size: int | tuple[int, int] | None, even: bool) -> tuple[int, int]:
    """Return width and height of a film, even numbers where they must be."""
    if isinstance(size, tuple):
        return size
    _, _, wide, high = drawing.box
    scale = min(SHARP, LONGEST / max(wide, high)) if size is None else size / wide
    step = 2 if even else 1
    width, height = (max(SMALLEST, min(LARGEST, math.ceil(side * scale / step) * step)) for side in (wide, high))
    return (width if size is None else size), height


def _gif(motion: Motion, reel: Reel, fps: float) -> Contents:
    (width, height), count, frame = _frames(motion, reel, fps, even=False)
    if width * height * count > MOST_PIXELS:
        told = f"{count} frames of {width}x{height} pixels are more than a .gif can be made of"
        raise DrawError(f"{motion.scene.name}: {told}; give a smaller size or fewer frames, or write an .mp4")
    palette = palette_of([frame(int(k)) for k in np.unique(np.linspace(0, count - 1, FRAMES).astype(int))])
    nearest = Nearest(palette)
    plain = [nearest(frame(k)) for k in range(count)]
    ends = [10 * round(100 * k / fps) for k in range(count + 1)]  # ms; players know hundredths of a second
    lasting = [after - before for before, after in pairwise(ends)]
    options: dict[str, Any] = {"loop": 0} if reel.loop else {}

    def fill(file: IO[bytes]) -> None:
        first, *others = plain
        duration = lasting if others else lasting[0]
        first.save(file, "GIF", save_all=True, append_images=others, duration=duration, disposal=1, **options)

    return fill


PLAIN = [
    "-crf", "18", "-preset", "medium", "-tune", "animation", "-movflags", "+faststart", "-map_metadata", "-1",
    "-fflags", "+bitexact", "-flags:v", "+bitexact", "-bsf:v", "filter_units=remove_types=6", "-threads", "1",
]  # fmt: skip
"""Sharp lines; a file that begins to play before it is whole, and that tells no version, day or number of cores."""


def _mp4(motion: Motion, reel: Reel, fps: float) -> Contents:
    import imageio_ffmpeg

    size, count, frame = _frames(motion, reel, fps, even=True)

    def fill(file: IO[bytes]) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "film.mp4"
            try:
                writer = imageio_ffmpeg.write_frames(
                    str(path), size, fps=fps, codec="libx264", macro_block_size=1, quality=None, output_params=PLAIN,
                    ffmpeg_log_level="error",
                )  # fmt: skip
                writer.send(None)
                for k in range(count):
                    writer.send(frame(k).tobytes())
                writer.close()
                with path.open("rb") as made:
                    shutil.copyfileobj(made, file)
            except (OSError, RuntimeError) as fault:
                lines = str(fault).strip().splitlines() or [type(fault).__name__]
                raise DrawError(f"ffmpeg made no film ({lines[-1]}); write a .gif or .html instead") from fault

    return fill


def _glb(motion: Motion, reel: Reel, fps: float) -> bytes:
    scene = motion.scene
    t, q, values = moments(scene, motion.times, motion.positions, motion.parameters, fps)
    stage = Stage(scene, q, values, motion.view)
    found, seen = stage.places, stage.view
    given = robot_solids(scene, motion.note)
    return glb(scene.name, found.bodies, standing(scene, found, seen, given), t, seen, found.gravity, Scene.GROUND)


FILMS: Mapping[str, Film] = {
    ".html": Film(_page, 30.0, ("fps", "loop")),
    ".svg": Film(_picture, 30.0, ("fps", "size", "loop")),
    ".gif": Film(_gif, 25.0, ("fps", "size", "loop"), ("matplotlib", "PIL"), fastest=50.0),
    ".glb": Film(_glb, 30.0, ("fps",), ("pygltflib",)),
    ".mp4": Film(_mp4, 30.0, ("fps", "size"), ("matplotlib", "imageio_ffmpeg")),
}
"""Kinds of files by ending."""
