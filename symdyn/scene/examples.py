"""The scenes that come with the package, and what a new scene may begin as: commented TOML, without a fault."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from symdyn.arguments import check_arguments
from symdyn.errors import SceneError
from symdyn.resources import folder
from symdyn.scene.scene_files import read
from symdyn.scene.values.model import Scene
from symdyn.scene.values.names import check_scene_name, choice

COUNTED = {"chain": 1024, "n_four_bar": 1000}
"""Templates of n parts, and the largest n."""


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


@dataclass(frozen=True)
class Starter:
    """A new scene of a name, and what it may begin as.

    Attributes:
        name: of the scene.
        TEMPLATES: those that there are, in words.
    """

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

    def from_example(self, example: str) -> str:
        """Return the file of a scene that comes with the package, comments and all, under the name.

        Raises:
            SceneError: there is no such example, and which there are; or the name will not do.
        """
        text = path_of(example).read_text(encoding="utf-8")
        self._check()
        return text.replace(f'name = "{example}"', f'name = "{self.name}"', 1)

    def _check(self) -> None:
        if fault := check_scene_name(self.name):
            raise SceneError(f'the name "{self.name}" {fault}')
