"""The language of what is looked at: letters that formulas of outputs, events and `--outputs` may use.

    x, x_dot, x_ddot            coordinates, velocities and their rates
    tau1, u, m1, t              drives, inputs, parameters, time
    point_tip_x                 places of declared points, ground axes, m
    reaction_hinge_fx           what the parent exerts on the child at a joint or loop, axes of the child's body, N and
                                N m; `.._joint` and `.._ground` in other axes
    multiplier_cut_fx_joint     multipliers of rows that close loops, as `simulate --reactions` calls them

All but the last are known from the scene; which rows are kept is decided where equations are derived.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from symdyn.scene.values.joint import acceleration_name
from symdyn.scene.values.mapping import map_quantities, substituted
from symdyn.scene.values.model import Parameter, Scene
from symdyn.scene.values.quantity import ZERO

REACTION, MULTIPLIER = "reaction_", "multiplier_"

COMPONENTS = ("fx", "fy", "fz", "mx", "my", "mz")

AXES = ("body", "joint", "ground")
"""What reactions are written in: axes of the child's body, of the joint frame on the parent, of the ground."""

LOOSE = "_not_unique"
"""Ends the names of what rigid bodies do not determine; their numbers are one choice among many."""

COLUMNS = (
    "kinetic_energy", "potential_energy", "energy_error", "drive_power", "other_power", "work", "loop_error",
    "loop_rate_error", "path_error",
)  # fmt: skip
"""What runs have beside what they are asked for."""


def is_column(name: str) -> bool:
    """Tell whether runs have a column of this name that no person names."""
    return name in COLUMNS or name.startswith(("point_", "momentum_", REACTION, MULTIPLIER))


def point_names(scene: Scene) -> list[str]:
    """Return the letters of declared points, three a point."""
    return [f"point_{one.name}_{axis}" for one in scene.points for axis in "xyz"]


def reaction_axes(scene: Scene) -> dict[str, str]:
    """Return the axes of every letter of a reaction, by its name."""
    return {
        f"{REACTION}{joint.name}_{component}{'' if axes == AXES[0] else f'_{axes}'}{loose}": axes
        for axes in AXES
        for joint in (*scene.joints, *scene.loops)
        for component in COMPONENTS
        for loose in ("", LOOSE)
    }


def as_parameters(scene: Scene) -> Scene:
    """Return the scene without outputs, its inputs being parameters: for who looks at it at one moment.

    An input that is zero where nobody gives it has no value then, so that it is seen where it acts.
    """
    if not scene.inputs:
        return replace(scene, outputs=()) if scene.outputs else scene
    more = tuple(
        Parameter(one.name, None if one.value == ZERO else one.value, False, one.unit, one.latex, one.text, one.texts)
        for one in scene.inputs
    )
    return replace(scene, parameters=(*scene.parameters, *more), inputs=(), outputs=())


def held(scene: Scene) -> Scene:
    """Return the scene without outputs, its inputs being what they are where nobody gives them.

    Raises:
        FormulaError: a formula has no value there.
    """
    if not scene.inputs:
        return replace(scene, outputs=()) if scene.outputs else scene
    values = {one.name: one.value for one in scene.inputs}
    return map_quantities(replace(scene, inputs=(), outputs=()), lambda one: substituted(one, values))


def plain_letters(scene: Scene) -> tuple[str, ...]:
    """Return the letters that are no parameter and need no derivation: time, coordinates, velocities, inputs."""
    return ("t", *scene.coordinates, *scene.velocities, *(one.name for one in scene.inputs))


def letters(scene: Scene, said: Iterable[str] = ()) -> tuple[str, ...]:
    """Return the names that formulas may use, parameters aside; of what is `said`, multipliers are known later."""
    accelerations = map(acceleration_name, scene.velocities)
    drives = (drive for drive in scene.drives if drive)
    late = (name for name in said if name.startswith(MULTIPLIER) and scene.is_closed)
    names = (*plain_letters(scene), *accelerations, *drives, *point_names(scene), *reaction_axes(scene), *late)
    return tuple(dict.fromkeys(names))
