"""Names that `symdyn.dynamics.reactions` offers; each is imported when it is first used."""

from .bivectors import frames as frames, inertia_bivector as inertia_bivector, known_bivectors as known_bivectors
from .dalembert import (
    COUPLING as COUPLING,
    DRIVE as DRIVE,
    REACTION as REACTION,
    Equilibrium as Equilibrium,
    Unknown as Unknown,
    equilibrium as equilibrium,
)
from .hanging import Hanging as Hanging
from .hinges import PLACES as PLACES, TINY as TINY, Hinge as Hinge, drives as drives, relative_twists as relative_twists
from .least import InNumbers as InNumbers, equations as equations, wrench_rows as wrench_rows
from .members import acting as acting, own_forces as own_forces, placements as placements, way_apart as way_apart
from .recursion import reactions as reactions
from .ties import Tie as Tie, sizes as sizes, ties as ties, undriven as undriven, why_no_reactions as why_no_reactions
