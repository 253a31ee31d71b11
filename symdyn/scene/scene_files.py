"""A scene from any file that is understood, and its text in any format that is written.

The scenes that come with the package, and what a new scene may begin as: commented TOML, without a fault.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from os import PathLike
from pathlib import Path
from typing import ClassVar, Literal

from symdyn.arguments import argument, checked
from symdyn.errors import SceneError, choice, suggestion
from symdyn.frozen import dataclass, replace
from symdyn.graph import growing
from symdyn.resources import example_files, folder
from symdyn.scene.declaration.reading import (
    BEGIN,
    Opened,
    Readable,
    Reading,
    ReadOptions,
    Written,
    opened,
    read_bounded,
)
from symdyn.scene.symbolic import bind
from symdyn.scene.values.entry import Faults, show
from symdyn.scene.values.grammar import check_scene_name
from symdyn.scene.values.model import Scene

READERS: Mapping[str, str] = {
    "toml": "symdyn.scene.toml",
    "urdf": "symdyn.scene.formats.urdf",
    "sdf": "symdyn.scene.formats.sdf",
    "mjcf": "symdyn.scene.formats.mjcf",
    "par": "symdyn.scene.formats.par",
}

WRITERS: Mapping[str, str] = {
    "toml": "symdyn.scene.toml",
    "urdf": "symdyn.scene.formats.urdf_writer",
    "sdf": "symdyn.scene.formats.sdf_writer",
    "par": "symdyn.scene.formats.par_writer",
}

EXTENSIONS: Mapping[str, str] = {
    ".toml": "toml",
    ".urdf": "urdf",
    ".sdf": "sdf",
    ".world": "sdf",
    ".mjcf": "mjcf",
    ".par": "par",
}

MOST_TOLD = 12
"""Joints whose coordinates are named when a robot file is read."""

ROOTS: Mapping[str, str] = {"robot": "urdf", "mujoco": "mjcf", "sdf": "sdf"}

FileLike = str | PathLike[str] | Readable
"""A path, or an open file."""

SceneLike = Scene | FileLike
"""What every function takes for a scene."""


@checked(SceneError)
def scene_of(source: SceneLike, values: Mapping[str, object] | None = None) -> Scene:
    """Return a scene as it is, or the one in a file, as `read` does, bound where values are given.

    Args:
        source: a scene, a path or an open file.
        values: of parameters, as `bind` takes them: anything that has items, such as a series of pandas.

    Raises:
        SceneError: with every fault of the file, or of the values, one line each; or what a value without a unit may
            mean, of a parameter that the scene has in another unit than that of SI.
    """
    scene = source if isinstance(source, Scene) else read(source)
    if values is None or not len(values):
        return scene
    return bind(scene, values)


@checked(SceneError)
def read(
    path: FileLike,
    *,
    snap: bool = True,
    allow_invalid_inertia: bool = False,
    spanning_tree: Sequence[str] | None = None,
    floating_base: str | None = None,
    units: Literal["none"] | None = None,
) -> Scene:
    """Return the scene in a file: TOML, URDF, SDF, MJCF or Khalil's .par.

    >>> from symdyn.resources import example_files, folder
    >>> read(folder("examples") / "cart_pole.toml")
    <Scene cart_pole: 2 bodies; coordinates x, theta; drives F>

    Args:
        path: the extension gives the format; for .xml the root element does. Of an open file its name does; without
            one it is TOML, or what its root element shows.
        snap: read decimals of robot files with at least eight digits that are a small rational multiple of π at all of
            them as that multiple.
        allow_invalid_inertia: accept inertias that no real body has, of every body.
        spanning_tree: names of the joints to cut where joints close loops; chosen when left out.
        floating_base: name of a free joint between the ground and the root link of a URDF or the base of an MJCF file,
            with a quaternion and no drives; without it the root is the ground. In SDF, of the one that is there.
        units: "none" of a scene that is without dimensions on purpose, so that none is checked.

    Raises:
        SceneError: with every fault of the file, one line each.
    """
    return read_noting(path, snap, allow_invalid_inertia, spanning_tree, floating_base, units == "none").scene


@growing()
def read_noting(
    path: FileLike,
    snap: bool = True,
    allow_invalid_inertia: bool = False,
    spanning_tree: Sequence[str] | None = None,
    floating_base: str | None = None,
    dimensionless: bool = False,
) -> Reading:
    """Return the scene in a file, and notes of what the reader changed, doubts or leaves out of the equations.

    Raises:
        SceneError: with every fault of the file, one line each.
    """
    cuts = None if spanning_tree is None else tuple(spanning_tree)
    options = ReadOptions(snap, allow_invalid_inertia, cuts, floating_base, dimensionless)
    file = _file(path)
    format = _format(file)
    if options.floating_base is not None:
        from symdyn.scene.formats.inertias import check_base

        faults = Faults(str(file))
        check_base(options.floating_base, format, faults)
        faults.close()
    reader: Callable[[Path | Opened, ReadOptions], Reading] = import_module(READERS[format]).read
    reading = reader(file, options)
    told = reading.scene.coordinates_of_joints(MOST_TOLD)
    return replace(reading, notes=(*reading.notes, f"{file}: coordinates: {told}")) if told else reading


@checked(SceneError)
def write_text(scene: Scene, format: str, lossy: bool = False) -> Written:
    """Return the scene as text.

    Args:
        scene: what to write.
        format: a key of `WRITERS`.
        lossy: leave out what the format cannot hold; it is listed in the result.

    Raises:
        SceneError: the format is not one that is written, or cannot hold all of the scene and `lossy` is not given.
    """
    if format not in WRITERS:
        raise SceneError(f'"{format}" is not a format that is written; {suggestion(format, WRITERS)}')
    writer: Callable[[Scene], Written] = import_module(WRITERS[format]).write_text
    written = writer(scene)
    if written.lost and not lossy:
        told = f"{format} cannot hold all of this; {argument('lossy', True)} leaves it out"
        raise SceneError([*written.lost, f"{scene.name}: {told}"])
    return written


def format_to_write(path: str | PathLike[str]) -> str:
    """Return the format that the extension of a file to be written names.

    Raises:
        SceneError: it names none.
    """
    format = EXTENSIONS.get(Path(path).suffix.lower())
    if format in WRITERS:
        return str(format)
    known = ", ".join(ending for ending, name in EXTENSIONS.items() if name in WRITERS)
    raise SceneError(f"{path}: no format to write is known by this name; give it one of the extensions {known}")


def _file(path: FileLike) -> Path | Opened:
    if isinstance(path, str) and ("\n" in path or " = " in path):
        raise SceneError("this is the text of a scene, and no path: symdyn.scene.read_text(text) reads it")
    if isinstance(path, (str, PathLike)):
        return Path(path)
    if hasattr(path, "read"):
        return opened(path)
    raise SceneError(f"{show(path)} is no scene; give a Scene, the path of a file such as arm.toml, or an open file")


def _format(file: Path | Opened) -> str:
    """Return the format of a file, a value of `EXTENSIONS`."""
    ending = (file.path if isinstance(file, Opened) else file).suffix.lower()
    if ending in EXTENSIONS:
        return EXTENSIONS[ending]
    from symdyn.scene.formats.xml import LARGEST_FILE, TOO_LARGE, XmlElement, find_root

    content = read_bounded(file, LARGEST_FILE, "a scene file such as arm.toml", TOO_LARGE, BEGIN)
    first = find_root(content)
    if isinstance(file, Opened) and first is None and ending != ".xml":
        return "toml"
    if not isinstance(file, Opened) and ending != ".xml":
        known = choice(ending, (*EXTENSIONS, ".xml"))
        raise SceneError(f'{file}: the extension "{ending}" names no format; {known}')
    # where there is no element, the parser says what is wrong with the text
    root = first[1].decode("ascii") if first else XmlElement.parse(content, str(file)).tag
    if root not in ROOTS:
        known = ", ".join(f"<{name}>" for name in ROOTS)
        raise SceneError(f"{file}: has the root element <{root[:40]}>; expected one of {known}")
    return ROOTS[root]


COUNTED = {"chain": 1024, "n_four_bar": 1000}
"""Templates of n parts, and the largest n."""


def examples() -> tuple[str, ...]:
    """Return the names of the scenes that come with the package, in order.

    >>> examples()[:3]
    ('actuator', 'arm7', 'backlash')
    """
    return tuple(sorted(example_files()))


@checked(SceneError)
def example(name: str, *, floating_base: str | None = None) -> Scene:
    """Return a scene that comes with the package, of the gallery too; `symdyn new --example NAME` writes its file.

    >>> example("four_bar").coordinates
    ('phi', 'psi', 'chi')
    >>> example("furuta").coordinates
    ('theta1', 'theta2')

    Args:
        name: of the scene.
        floating_base: as `read` takes it, of a robot file.

    Raises:
        SceneError: there is none of this name; the message names those that there are.
    """
    return read(path_of(name), floating_base=floating_base)


def path_of(example: str) -> Path:
    """Return the file of a scene that comes with the package; SceneError where there is none, and which there are."""
    known = example_files()
    if example not in known:
        raise SceneError(f'there is no example "{example}"; {choice(example, sorted(known))}')
    return known[example]


@dataclass(frozen=True)
class Starter:
    """A new scene of a name, and what it may begin as."""

    TEMPLATES: ClassVar[Mapping[str, str]] = {
        "rr": "planar arm, two revolute joints",
        "rrr": "articulated arm, three revolute joints, by a Denavit-Hartenberg table",
        "rrp": "spherical arm, two revolute joints and a sliding boom",
        "cart_pole": "cart on a rail with a passive pole",
        "puma": "PUMA 560, six axes, published numbers",
        "arm7": "seven-axis arm with full inertias",
        "chain": "planar chain of n point masses",
        "four_bar": "crank-rocker of three uniform rods, a closed loop",
        "slider_crank": "crank, connecting rod and piston, a closed loop",
        "n_four_bar": "n four-bars in a row, n closed loops",
    }

    name: str

    def from_template(self, template: str, n: int | None = None) -> str:
        """Return the text that a template gives.

        Args:
            template: a key of `TEMPLATES`.
            n: number of links of a chain, or of four-bars; two when left out.

        Raises:
            SceneError: the name or the template will not do, or n does not fit.
        """
        self._check()
        if template not in self.TEMPLATES:
            raise SceneError(f'there is no template "{template}"; {choice(template, self.TEMPLATES)}')
        if n is not None and template not in COUNTED:
            some = " and ".join(COUNTED)
            raise SceneError(f'n = {n} goes with the templates {some} only; "{template}" has a fixed number of joints')
        links = 2 if n is None else n
        if not 1 <= links <= COUNTED.get(template, links):
            raise SceneError(f"n = {links} is out of range; {template} takes 1 to {COUNTED[template]}")

        from jinja2 import Environment, FileSystemLoader, StrictUndefined

        environment = Environment(
            loader=FileSystemLoader(folder("templates") / "scenes"),
            undefined=StrictUndefined,
            trim_blocks=True,
            lstrip_blocks=True,
            keep_trailing_newline=True,
        )
        return environment.get_template(f"{template}.toml.jinja").render(name=self.name, n=links)

    def from_example(self, example: str) -> tuple[str, str]:
        """Return the file of a scene that comes with the package, comments and all, under the name: its name, its text.

        Raises:
            SceneError: there is no such example, and which there are; or the name will not do.
        """
        path = path_of(example)
        text = path.read_text(encoding="utf-8")
        self._check()
        renamed = re.sub(rf'(name ?= ?)"{example}"', rf'\1"{self.name}"', text, count=1)
        return f"{self.name}{path.suffix}", renamed

    def _check(self) -> None:
        if fault := check_scene_name(self.name):
            raise SceneError(f'the name "{self.name}" {fault}')
