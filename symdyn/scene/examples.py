"""The scenes that come with the package."""

from __future__ import annotations

from pathlib import Path

from symdyn.arguments import check_arguments
from symdyn.errors import SceneError
from symdyn.resources import folder
from symdyn.scene.scene_files import read
from symdyn.scene.values.model import Scene
from symdyn.scene.values.names import choice


def examples() -> tuple[str, ...]:
    """Return the names of the scenes that come with the package, in order.

    >>> examples()[:3]
    ('arm7', 'bicycle', 'cart_pole')
    """
    return tuple(sorted(path.stem for path in folder("examples").glob("*.toml")))


def example(name: str) -> Scene:
    """Return a scene that comes with the package; `symdyn new --example NAME` writes its file.

    >>> example("four_bar").coordinates
    ('phi', 'psi', 'chi')

    Raises:
        SceneError: there is none of this name; tells those that there are.
    """
    check_arguments(example, locals(), SceneError)
    return read(path_of(name))


def path_of(example: str) -> Path:
    """Return the file of a scene that comes with the package; SceneError where there is none, and which there are."""
    known = examples()
    if example not in known:
        raise SceneError(f'there is no example "{example}"; {choice(example, known)}')
    return folder("examples") / f"{example}.toml"
