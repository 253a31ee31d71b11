"""Names that `symdyn.dynamics.mechanism` offers; each is imported when it is first used."""

from .angles import angles_of as angles_of
from .cost import cost as cost
from .kane import Kane as Kane
from .kinematics import joints_below as joints_below
from .linear_solve import RowSolve as RowSolve, solve as solve, vanishes as vanishes
from .ropes import Taut as Taut
from .state import (
    TIME as TIME,
    State as State,
    body_placements as body_placements,
    declared_forces as declared_forces,
    elastic_energy as elastic_energy,
    ends_apart as ends_apart,
    generalized_forces as generalized_forces,
    has_motion as has_motion,
    joint_placement as joint_placement,
    joint_resistance as joint_resistance,
    prescribed as prescribed,
    pull as pull,
    quaternions as quaternions,
    refuse_ideal_friction as refuse_ideal_friction,
    strut_way as strut_way,
    vector as vector,
)
from .tree import body_inertia as body_inertia
