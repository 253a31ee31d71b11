"""Names that `symdyn.dynamics.reactions` offers; each is imported when it is first used."""

from .closure_equations import why_no_reactions as why_no_reactions
from .dalembert import Equilibrium as Equilibrium, Unknown as Unknown
from .free_bodies import percussions as percussions
from .joint_frames import JointFrames as JointFrames
