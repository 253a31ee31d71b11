"""FMUs of scenes, packed and unpacked, for tests."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from xml.etree import ElementTree

from symdyn.emit import TARGETS, Sources, emit
from symdyn.program import tunable
from symdyn.scene import Scene

VERSIONS = ("fmi2", "fmi3")


def sources_of(scene: Scene) -> Sources:
    """Return both FMUs of a scene, without binaries."""
    needed = TARGETS["fmu"].functions
    assert needed is not None
    return emit(tunable(scene, needed(scene)), "fmu")


def unpacked(sources: Sources, version: str) -> dict[str, bytes]:
    """Return the files of the FMU of a version."""
    (archive,) = (text for name, text in sources.items() if name.endswith(f"_{version}.fmu"))
    assert isinstance(archive, bytes)
    with zipfile.ZipFile(io.BytesIO(archive)) as opened:
        return {name: opened.read(name) for name in opened.namelist()}


def unpack(sources: Sources, version: str, folder: Path) -> None:
    """Write the sources of the FMU of a version into a folder."""
    for name, text in unpacked(sources, version).items():
        (folder / Path(name).name).write_bytes(text)


def model_of(sources: Sources, version: str) -> ElementTree.Element:
    """Return the model description of a version."""
    return ElementTree.fromstring(unpacked(sources, version)["modelDescription.xml"])
