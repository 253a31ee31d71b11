"""The scenes that come with the package."""

from __future__ import annotations

from symdyn.arguments import check_arguments
from symdyn.errors import SceneError
from symdyn.resources import example_folder
from symdyn.scene.scene_files import read
from symdyn.scene.values.model import Scene
from symdyn.scene.values.names import choice


def examples() -> tuple[str, ...]:
    """Return the names of the scenes that come with the package, in order.

    >>> examples()[:3]
    ('arm7', 'bicycle', 'cart_pole')
    """
    return tuple(sorted(path.stem for path in example_folder().glob("*.toml")))


def example(name: str) -> Scene:
    """Return a scene that comes with the package; `symdyn new --example NAME` writes its file.

    >>> example("four_bar").coordinates
    ('phi', 'psi', 'chi')

    Raises:
        SceneError: there is none of this name; tells those that there are.
    """
    check_arguments(example, locals(), SceneError)
    _check(name)
    return read(example_folder() / f"{name}.toml")


def example_text(name: str) -> str:
    """Return the file of a scene that comes with the package, comments and all.

    Raises:
        SceneError: there is none of this name; tells those that there are.
    """
    _check(name)
    return (example_folder() / f"{name}.toml").read_text(encoding="utf-8")


def _check(name: str) -> None:
    known = examples()
    if name not in known:
        raise SceneError(f'there is no example "{name}"; {choice(name, known)}')
