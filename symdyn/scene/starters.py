"""Scenes to start from: commented TOML that reads back without a fault."""

from __future__ import annotations

from symdyn.errors import SceneError
from symdyn.resources import folder
from symdyn.scene.values.names import check_scene_name, choice

STARTERS: dict[str, str] = {
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

COUNTED = {"chain": 1024, "n_four_bar": 1000}
"""Templates of n parts, and the largest n."""


def starter(name: str, template: str, n: int | None = None) -> str:
    """Return the text of a new scene.

    Args:
        name: of the scene.
        template: a key of `STARTERS`.
        n: number of links of a chain, or of four-bars; two when left out.

    Raises:
        SceneError: the name or the template will not do, or n does not fit.
    """
    fault = check_scene_name(name)
    if fault:
        raise SceneError(f'the name "{name}" {fault}')
    if template not in STARTERS:
        raise SceneError(f'there is no template "{template}"; {choice(template, STARTERS)}')
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
    return environment.get_template(f"{template}.toml.jinja").render(name=name, n=links)
