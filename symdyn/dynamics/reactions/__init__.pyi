"""Names that `symdyn.dynamics.reactions` offers; each is imported when it is first used."""

from .bivectors import known_bivectors as known_bivectors
from .dalembert import Equilibrium as Equilibrium, Unknown as Unknown
from .hanging import Hanging as Hanging
from .hinges import Hinge as Hinge
from .least import InNumbers as InNumbers
from .recursion import reactions as reactions
from .ties import carried as carried, ties as ties, why_no_reactions as why_no_reactions
