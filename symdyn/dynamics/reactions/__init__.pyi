"""Names that `symdyn.dynamics.reactions` offers; each is imported when it is first used."""

from .closure_equations import unknown_forces as unknown_forces, why_no_reactions as why_no_reactions
from .dalembert import Equilibrium as Equilibrium, Unknown as Unknown
from .free_bodies import carried as carried, percussions as percussions
from .joint_frames import JointFrames as JointFrames
