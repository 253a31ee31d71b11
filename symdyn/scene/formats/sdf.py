"""SDF files are refused, with the way out.

There is no maintained SDF parser to build on: Gazebo's own sdformat is C++ outside the package registry,
python-sdformat had its last release in 2022, and the package called sdformat is a file format of another science.
"""

from __future__ import annotations

from pathlib import Path

from symdyn.errors import SceneError
from symdyn.scene.declaration.reading import Opened, Reading, ReadOptions


def read(path: Path | Opened, options: ReadOptions) -> Reading:
    """Refuse the file.

    Raises:
        SceneError: always; it says how to get the robot in another format.
    """
    del options
    raise SceneError(
        f"{path}: is SDF, which is not read here, as there is no maintained parser for it to rely on; give the URDF "
        "that the SDF was made from (gz sdf -p makes SDF of URDF), or write its links as [bodies.NAME] and its joints "
        "as [joints.NAME] of a TOML file; begin one with symdyn new"
    )
