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
