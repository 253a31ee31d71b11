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

from dataclasses import dataclass


@dataclass(frozen=True)
class SignalLetters:
    """What letters of what is looked at are made of.

    Attributes:
        reaction, multiplier: what the letters of these begin with.
        components: of a reaction, force and moment.
        axes: what reactions are written in: axes of the child's body, of the joint frame on the parent, of the ground.
        loose: ends the names of what rigid bodies do not determine; their numbers are one choice among many.
        columns: what runs have beside what they are asked for.
    """

    reaction: str = "reaction_"
    multiplier: str = "multiplier_"
    components: tuple[str, ...] = ("fx", "fy", "fz", "mx", "my", "mz")
    axes: tuple[str, ...] = ("body", "joint", "ground")
    loose: str = "_not_unique"
    columns: tuple[str, ...] = (
        "kinetic_energy", "potential_energy", "energy_error", "drive_power", "other_power", "work", "loop_error",
        "loop_rate_error", "path_error",
    )  # fmt: skip

    def has_column(self, name: str) -> bool:
        """Tell whether runs have a column of this name that no person names."""
        return name in self.columns or name.startswith(("point_", "momentum_", self.reaction, self.multiplier))


LETTERS = SignalLetters()
