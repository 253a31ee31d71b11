"""The scenes that come with the package."""

from __future__ import annotations

from symdyn.arguments import check_arguments
from symdyn.errors import SceneError
from symdyn.resources import folder
from symdyn.scene.scene_files import read
from symdyn.scene.values.model import Scene
from symdyn.scene.values.names import check_scene_name, choice


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
    _check(name)
    return read(folder("examples") / f"{name}.toml")


def example_text(example: str, name: str) -> str:
    """Return the file of a scene that comes with the package, comments and all, under a name.

    Raises:
        SceneError: there is no such example, and which there are; or the name will not do.
    """
    _check(example)
    text = (folder("examples") / f"{example}.toml").read_text(encoding="utf-8")
    if fault := check_scene_name(name):
        raise SceneError(f'the name "{name}" {fault}')
    return text.replace(f'name = "{example}"', f'name = "{name}"', 1)


def _check(name: str) -> None:
    known = examples()
    if name not in known:
        raise SceneError(f'there is no example "{name}"; {choice(name, known)}')
