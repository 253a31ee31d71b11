"""Names that `symdyn.dynamics.mechanism` offers; each is imported when it is first used."""

from .angles import angles_of as angles_of
from .cost import cost as cost
from .ldl import solve as solve
from .loads import (
    declared_forces as declared_forces,
    elastic_energy as elastic_energy,
    generalized_forces as generalized_forces,
    joint_resistance as joint_resistance,
    pull as pull,
    refuse_ideal_friction as refuse_ideal_friction,
    squared_length as squared_length,
)
from .placements import body_placements as body_placements, ends_apart as ends_apart, joint_placement as joint_placement
from .prescribed import TIME as TIME, has_motion as has_motion, prescribed as prescribed
from .row_solve import RowSolve as RowSolve
from .state import State as State, quaternions as quaternions, vector as vector
from .tree import body_inertia as body_inertia
