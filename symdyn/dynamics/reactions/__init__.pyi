"""Names that `symdyn.dynamics.reactions` offers; each is imported when it is first used."""

from .dalembert import Equilibrium as Equilibrium, Unknown as Unknown
from .hinges import Hinge as Hinge
from .ties import why_no_reactions as why_no_reactions
