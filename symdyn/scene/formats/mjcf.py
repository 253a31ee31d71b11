"""Scenes from MJCF, the files of MuJoCo, through MuJoCo's own compiler (extra `robots`).

The compiler resolves what only it knows: default classes, includes, frames, inertia from geoms, units. Before it sees
the file, the file and everything it includes is read by the hardened parser, and what could keep a machine busy is
refused. Before it compiles, everything that is drawn, sensed or touched is taken out, so that no picture is ever
opened, and no mesh but those that give moving bodies their inertia. What remains, a tree of bodies, `mjcf_tree` reads.

What a few letters of an MJCF file make the compiler fill memory with, counted before it sees them.

Meshes that give bodies of an MJCF file their inertia: MuJoCo's compiler opens them, if they are there and of a size.

All other meshes are taken out unopened: what is drawn or touched has no part in the equations.

Faces of OBJ files, looked at before anybody takes them apart: one face of millions of corners fills a machine.
"""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import import_module
from math import inf
from pathlib import Path
from typing import Any

from symdyn.bounds import BOUNDS
from symdyn.errors import SceneError
from symdyn.extras import install
from symdyn.scene.declaration.declare import reading_of
from symdyn.scene.declaration.reading import Opened, Reading, ReadOptions
from symdyn.scene.formats.mjcf_tree import Tree, nonzero
from symdyn.scene.formats.xml import XmlElement
from symdyn.scene.values.entry import Faults, shorten, show

RESOLUTIONS = {"cone": (0,), "wedge": (0, 1), "plate": (0, 1)}
"""Which parameters of a built-in mesh its corners are the product of; of all others they are the first one squared."""

ADVICE = {
    "heights of the hfields of an MJCF file": "no equation depends on a height field: delete it",
    "corners of the built-in meshes of an MJCF file": 'give the body <inertial pos="..." mass="..."/> instead',
}


def check_made(elements: Iterable[XmlElement], faults: Faults) -> None:
    """Report height fields and built-in meshes that are larger than is read, all of them together."""
    made = dict.fromkeys(ADVICE, 0.0)
    lines: dict[str, int] = {}
    copies = 1
    for element in elements:
        copies += element.tag == "attach"
        for what, count in _made(element).items():
            made[what] += count
            lines.setdefault(what, element.line)
    for what, count in made.items():
        if count * copies > BOUNDS[what]:
            found = f"{count * copies:.0f}" if count < 10**9 else f"{count * copies:.0e}"
            most = f"{BOUNDS[what]} are the most that is read"
            faults.add(f"line {lines[what]}", f"makes {found} {what}; {most}; {ADVICE[what]}")


def _made(element: XmlElement) -> Mapping[str, float]:
    """Return how much an element makes, by what."""
    heights, corners = ADVICE
    given = element.attributes
    if element.tag == "hfield":
        return {heights: _number(given.get("nrow", "0")) * _number(given.get("ncol", "0"))}
    if element.tag == "mesh" and "params" in given:
        numbers = [_number(word) for word in given["params"].split()] or [0.0]
        product = 1.0
        for k in RESOLUTIONS.get(given.get("builtin", ""), (0, 0)):
            product *= numbers[min(k, len(numbers) - 1)]
        return {corners: product}
    return {}


def _number(word: str) -> float:
    """Return the size of a number, without end where it is none that is read."""
    try:
        found = abs(float(word))
    except ValueError:
        return inf
    return found if found < 1e100 else inf


MOST_CORNERS = BOUNDS["corners of a face of a mesh"]

_LONG = re.compile(rb"^[ \t]*f[ \t][^\n]{%d,}" % (2 * MOST_CORNERS - 1), re.MULTILINE)
"""A face of more corners has at least a digit and a blank for each."""


def long_face(content: bytes) -> str | None:
    """Return what is wrong with a face of an OBJ file that has more corners than are read, None if there is none."""
    text = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n").replace(b"\\\n", b" ")
    for face in _LONG.finditer(text):
        if len(face[0].split(None, MOST_CORNERS + 2)) > MOST_CORNERS + 1:
            line = text.count(b"\n", 0, face.start()) + 1
            return f"has a face of more than {MOST_CORNERS} corners, line {line}; make triangles of it"
    return None


LARGEST_MESH = BOUNDS["bytes of a mesh"]
MOST_IN_ALL = BOUNDS["bytes of the meshes that give inertia"]

ENDINGS = (".stl", ".obj", ".msh")

INSTEAD = 'give the body <inertial pos="..." mass="..." diaginertia="..."/> instead'


def mesh_paths(spec: Any, mesh: Any, folder: Path) -> list[Path]:
    """Return where MuJoCo looks for the file of a mesh: in the folder for meshes, beside the file that names it."""
    own = getattr(mesh, "compiler", None) or spec.compiler
    name = Path(mesh.file).name if spec.strippath else mesh.file
    meshdirs = dict.fromkeys([getattr(own, "meshdir", "") or "", getattr(spec, "meshdir", "") or ""])
    return [folder / meshdir / name for meshdir in meshdirs]


def check_meshes(needed: Sequence[tuple[str, Sequence[Path]]], faults: Faults) -> None:
    """Report meshes that are not there, are none that MuJoCo reads, or are larger than a link's mesh needs to be.

    Args:
        needed: the body that takes its inertia from a mesh, and where the file of the mesh may be.
        faults: takes what is wrong.
    """
    total = 0
    for body, paths in needed:
        path = next((path for path in paths if is_file(path)), paths[0])
        takes = f"takes its inertia from the mesh {show(_shown(path, faults))}"
        if not is_file(path):
            faults.add(body, f"{takes}, and there is no such file; put it there, or {INSTEAD}")
        elif path.suffix.lower() not in ENDINGS:
            faults.add(body, f"{takes}, which is none of {', '.join(ENDINGS)}; convert it, or {INSTEAD}")
        else:
            size = path.stat().st_size
            total += size
            if size > LARGEST_MESH:
                most = f"{LARGEST_MESH >> 20} are the most that is read"
                faults.add(body, f"{takes} of {size >> 20} MB; {most}; {INSTEAD}")
            elif path.suffix.lower() == ".obj" and (fault := long_face(path.read_bytes())):
                faults.add(body, f"{takes}, which {fault}, or {INSTEAD}")
    if total > MOST_IN_ALL:
        what = f"the meshes that bodies take their inertia from have {total >> 20} MB together"
        faults.add("", f"{what}; {MOST_IN_ALL >> 20} are the most that is read; give bodies <inertial> instead")


def _shown(path: Path, faults: Faults) -> str:
    """Return the path as it is seen from the folder of the scene, where it lies below it."""
    folder = Path(faults.source).parent
    return str(path.relative_to(folder)) if path.is_relative_to(folder) else str(path)


def is_file(path: Path) -> bool:
    """Tell whether a file is there; a name that no system allows names none."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


OLDEST = (3, 4)
MOST_FILES = BOUNDS["files that an MJCF file includes"]
MOST_ELEMENTS = BOUNDS["elements that an MJCF file makes"]
MOST_BODIES = BOUNDS["bodies of an MJCF file"]
LARGEST_COUNT = BOUNDS["reserved by an attribute of an MJCF file"]

RESERVING = ("nuser", "nkey", "numeric size")
"""Beginnings of attributes, with their element, that make the compiler reserve memory for every element."""

FOREIGN = {
    "flexcomp": "deformable bodies are not part of a tree of rigid bodies",
    "flex": "deformable bodies are not part of a tree of rigid bodies",
    "composite": "write out the bodies that it stands for",
    "plugin": "what a plugin does is not known here",
}

PASSING = ("pairs", "excludes", "sensors", "keys", "actuators", "textures", "materials", "hfields", "skins")
"""What is taken out before the model is compiled: it touches, senses, drives or is drawn."""

LARGEST_NUMBER = 1e100
UNIT = 1e-6
LONGEST_REASON = 400

NUMBERS = {
    "body": ("pos", "quat", "mass", "ipos", "iquat", "inertia"),
    "jnt": ("axis", "pos", "range", "stiffness", "actfrcrange"),
    "dof": ("armature", "damping", "frictionloss"),
    "site": ("pos", "quat"),
    "eq": ("data",),
}
"""What is read from the compiled model, by kind of element."""

ARENA = ("memory", "nstack", "njmax", "nconmax")
"""Sizes of what a simulation works in; there will be none."""


def read(file: Path | Opened, options: ReadOptions) -> Reading:
    """Return the scene in an MJCF file.

    Raises:
        SceneError: with every fault found, one line each; or the package mujoco is not there.
    """
    path = file.path if isinstance(file, Opened) else file
    faults = Faults(str(path))
    root = XmlElement.read(file, faults.note)
    if root.tag != "mujoco":
        raise SceneError(f"{path}: its root is <{root.tag}>; the root of an MJCF file is <mujoco>")
    files = _files(path, root)
    total = sum(1 for element in files.values() for _ in element.walk())
    if sum(_harden(file, element, total, faults) for file, element in files.items()) > MOST_ELEMENTS:
        faults.add("", f"<replicate> and <attach> make more than {MOST_ELEMENTS} elements; use fewer copies")
    check_made((one for element in files.values() for one in element.walk()), faults)
    faults.close()
    mujoco = _package(path)
    said: list[str] = []
    with _heard(mujoco, path, said):
        spec = _spec(mujoco, file, files)
    _strip(mujoco, spec, path.parent, faults)
    faults.close()
    with _heard(mujoco, path, said):
        model = spec.compile()
    for warning in dict.fromkeys(said):
        faults.note("", f"MuJoCo warns: {shorten(warning)}")
    _sane(model, faults)
    faults.close()
    declaration = Tree(mujoco, spec, model, faults, options).declaration(path.stem)
    return reading_of(declaration, faults, options)


def _spec(mujoco: Any, file: Path | Opened, files: Mapping[Path, XmlElement]) -> Any:
    """Return the parsed file; MuJoCo opens no file whose name does not end in .xml, so such a one is handed over."""
    if isinstance(file, Opened):
        path, content = file.path, file.content
    elif file.suffix == ".xml":
        return mujoco.MjSpec.from_file(str(file))  # parses MJCF, opens nothing else
    else:
        path, content = file, file.read_bytes()
    others = {os.path.relpath(other, path.parent): other.read_bytes() for other in files if other != path}
    spec = mujoco.MjSpec.from_string(content.decode("utf-8"), include=others)
    spec.modelfiledir = str(path.parent)  # where meshes are looked for
    return spec


# The text


def _files(path: Path, root: XmlElement) -> dict[Path, XmlElement]:
    """Return a file and all that it includes or attaches, each read by the hardened parser.

    The compiler looks for a file beside the first one or beside the one that names it; where it is not, the compiler
    says so.
    """
    files = {path: root}
    waiting: list[tuple[Path, XmlElement, tuple[Path, ...]]] = [(path, root, (path.resolve(),))]
    while waiting:
        file, element, chain = waiting.pop()
        for child in element.walk():
            name = child.attributes.get("file", "")
            if child.tag not in ("include", "model") or not name:
                continue
            if child.tag == "model" and file != path:
                raise SceneError(f"{file}: line {child.line}: an attached model attaches another one; join the two")
            for other in dict.fromkeys((path.parent / name, file.parent / name)):
                if _is_strange(other):
                    raise SceneError(f"{file}: line {child.line}: {shorten(name)} is no file; give one with MJCF")
                if is_file(other):
                    if other.resolve() in chain:
                        raise SceneError(f"{file}: line {child.line}: {other.name} includes itself; break the ring")
                    if other not in files:
                        files[other] = XmlElement.read(other)
                        waiting.append((other, files[other], (*chain, other.resolve())))
        if len(files) > MOST_FILES:
            raise SceneError(f"{path}: includes more than {MOST_FILES} files; join some of them")
    return files


def _is_strange(path: Path) -> bool:
    """Tell whether a pipe, a device or a folder stands there, at which the compiler would wait or read on."""
    try:
        return path.exists() and not path.is_file()
    except (OSError, ValueError):
        return False


def _harden(file: Path, root: XmlElement, total: int, faults: Faults) -> int:
    """Refuse what would keep the compiler busy, or make it write a log; return how many elements it will make.

    Args:
        file: where the elements stand.
        root: first of them.
        total: elements of all files together; an attached model has no more.
        faults: takes what is refused.
    """
    made = 0
    stack = [(root, 1)]
    while stack:
        element, copies = stack.pop()
        made += copies * (total if element.tag == "attach" else 1)
        where = f"{file.name} line {element.line}" if str(file) != faults.source else f"line {element.line}"
        if element.tag in FOREIGN:
            faults.add(where, f"<{element.tag}> is not read: {FOREIGN[element.tag]}; delete it")
        for key, value in element.attributes.items():
            if any(word.lower().lstrip("+-") in ("nan", "inf", "infinity") for word in value.split()):
                faults.add(where, f"<{element.tag}> {key}={show(value)} is not finite; give a number such as 0.1")
            if (key.startswith(RESERVING) or f"{element.tag} {key}" in RESERVING) and not _small(value):
                advice = f"{LARGEST_COUNT} is the most that is read; leave it out"
                faults.add(where, f"<{element.tag}> {key}={show(value)} asks for much memory; {advice}")
        if element.tag == "replicate":
            count = element.attributes.get("count", "1").strip()
            copies *= int(count) if count.isdecimal() and len(count) <= 9 else MOST_ELEMENTS
        stack.extend((child, copies) for child in reversed(element.children))
    return made


def _small(value: str) -> bool:
    text = value.strip()
    return text == "-1" or (text.isdecimal() and len(text) <= 9 and int(text) <= LARGEST_COUNT)


# The compiler


def _package(path: Path) -> Any:
    try:
        mujoco = import_module("mujoco")
    except ImportError:
        advice = f"install it with {install('robots')}"
        raise SceneError(
            f"{path}: MJCF is read by MuJoCo's compiler, and the package mujoco is missing; {advice}"
        ) from None
    version = re.match(r"(\d+)\.(\d+)", mujoco.__version__)
    if version is None or (int(version[1]), int(version[2])) < OLDEST:
        what = f"mujoco {mujoco.__version__} is too old, {OLDEST[0]}.{OLDEST[1]} is needed"
        raise SceneError(f"{path}: {what}; pip uninstall mujoco, then {install('robots')}")
    return mujoco


@contextmanager
def _heard(mujoco: Any, path: Path, specified: list[str]) -> Iterator[None]:
    """Collect what MuJoCo warns of, which goes into a file in the working directory otherwise; reword its errors."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: specified.append(_one_line(str(text))))
    try:
        with warnings.catch_warnings(record=True) as python:
            warnings.simplefilter("always")
            yield
        specified.extend(_one_line(str(warning.message)) for warning in python)
    except (ValueError, TypeError, RuntimeError, OSError, MemoryError) as error:
        reason = _one_line(str(error))[:LONGEST_REASON] or type(error).__name__
        raise SceneError(f"{path}: MuJoCo's compiler refuses it: {reason}") from None
    finally:
        mujoco.set_mju_user_warning(before)


def _one_line(text: str) -> str:
    return ", ".join(part.strip() for part in text.splitlines() if part.strip())


def _strip(mujoco: Any, spec: Any, folder: Path, faults: Faults) -> None:
    """Take out what has no part in a tree of rigid bodies; refuse what has a part that cannot be read."""
    if len(spec.bodies) > MOST_BODIES:
        faults.add("", f"there are {len(spec.bodies)} bodies; {MOST_BODIES} are the most that is read")
        faults.close()
    _refuse_actuators(spec, faults)
    counts = {kind: len(found) for kind in PASSING if len(found := list(getattr(spec, kind, ())))}
    told = {"actuators": "actuators", "sensors": "sensors", "pairs": "contact pairs", "keys": "keyframes"}
    shown = [
        f"{counts[kind]} {word if counts[kind] > 1 else word[:-1]}" for kind, word in told.items() if kind in counts
    ]
    if shown:
        faults.note("", f"{', '.join(shown)} left out; every joint has a drive of its own")
    for kind in PASSING:
        for element in list(getattr(spec, kind, ())):
            spec.delete(element)
    for key in ARENA:
        setattr(spec, key, -1)
    for drawn in (*spec.geoms, *spec.sites, *spec.tendons):
        drawn.material = ""
    files = {mesh.name: mesh for mesh in spec.meshes if mesh.file}
    needed: dict[str, str] = {}
    for geom in list(spec.geoms):
        if geom.meshname in files or geom.hfieldname:
            if geom.meshname in files and _weighs(mujoco, spec, geom):
                needed.setdefault(geom.meshname, f"body {geom.parent.name or geom.parent.info}")
            else:
                spec.delete(geom)
    for name, mesh in files.items():
        if name not in needed:
            spec.delete(mesh)
    check_meshes([(where, mesh_paths(spec, files[name], folder)) for name, where in needed.items()], faults)


def _refuse_actuators(spec: Any, faults: Faults) -> None:
    for actuator in spec.actuators:
        for key in ("armature", "damping"):
            if nonzero(getattr(actuator, key, 0.0)):
                advice = "give the joint that it drives this value times gear squared instead"
                faults.add(f"actuator {actuator.name}", f"{key} of an actuator is not read; {advice}")


def _weighs(mujoco: Any, spec: Any, geom: Any) -> bool:
    """Whether the inertia of a moving body comes from this geom."""
    source, kinds = spec.compiler.inertiafromgeom, mujoco.mjtInertiaFromGeom
    body = geom.parent
    if body.name == "world" or source == kinds.mjINERTIAFROMGEOM_FALSE:
        return False
    if source == kinds.mjINERTIAFROMGEOM_AUTO and body.explicitinertial:
        return False
    low, high = spec.compiler.inertiagrouprange
    massless = geom.mass == 0 or (geom.mass != geom.mass and geom.density == 0)
    return bool(low <= geom.group <= high) and not massless


def _sane(model: Any, faults: Faults) -> None:
    """Refuse a compiled model with numbers that overflow: 1e300 in the file, or an axis of length 1e-300."""
    arrays = {f"{kind}_{key}": getattr(model, f"{kind}_{key}") for kind, keys in NUMBERS.items() for key in keys}
    arrays |= {"qpos0": model.qpos0, "qpos_spring": model.qpos_spring, "gravity": model.opt.gravity}
    for name, array in arrays.items():
        bad = ~(abs(array) < LARGEST_NUMBER)
        if name.endswith("quat"):
            bad |= ~(abs((array * array).sum(axis=1, keepdims=True) - 1) < UNIT)
        if bad.any():
            what = f"the compiled model has numbers of {name} that are not finite, larger than {LARGEST_NUMBER:g}, or"
            faults.add("", f"{what} no unit quaternion; look for such numbers in the file")
