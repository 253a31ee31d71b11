"""Meshes that give bodies of an MJCF file their inertia: MuJoCo's compiler opens them, if they are there and of a size.

All other meshes are taken out unopened: what is drawn or touched has no part in the equations.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from symdyn.bounds import BOUNDS
from symdyn.scene.formats.mesh_faces import long_face
from symdyn.scene.values.table import Faults, show

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
