"""Scenes to start from: commented TOML that reads back without a fault."""

from __future__ import annotations

from symdyn.errors import SceneError
from symdyn.resources import template_folder
from symdyn.scene.names import check_name, suggestion

STARTERS: dict[str, str] = {
    "rr": "planar arm, two revolute joints",
    "rrr": "articulated arm, three revolute joints, by a Denavit-Hartenberg table",
    "rrp": "spherical arm, two revolute joints and a sliding boom",
    "cart_pole": "cart on a rail with a passive pole",
    "puma": "PUMA 560, six axes, published numbers",
    "arm7": "seven-axis arm with full inertias",
    "chain": "planar chain of n point masses",
}

LONGEST_CHAIN = 1000


def starter(name: str, template: str, n: int | None = None) -> str:
    """Return the text of a new scene.

    Args:
        name: of the scene.
        template: a key of `STARTERS`.
        n: number of links, 1 to 1000, for the chain only; two when left out.

    Raises:
        SceneError: the name or the template will not do, or n does not fit.
    """
    fault = check_name(name)
    if fault:
        raise SceneError(f'the name "{name}" {fault}')
    if template not in STARTERS:
        known = ", ".join(STARTERS)
        raise SceneError(f'there is no template "{template}"; {suggestion(template, STARTERS)} (there are {known})')
    if n is not None and template != "chain":
        raise SceneError(f'n = {n} goes with the template "chain" only; "{template}" has a fixed number of joints')
    links = 2 if n is None else n
    if not 1 <= links <= LONGEST_CHAIN:
        raise SceneError(f"n = {links} is out of range; a chain has 1 to {LONGEST_CHAIN} links")

    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(template_folder() / "scenes"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    return environment.get_template(f"{template}.toml.jinja").render(name=name, n=links)
