"""Names that `symdyn.transcription` offers; each is imported when it is first used."""

from .ipopt import solve as solve
from .problem import collocation as collocation
from .solution import Solution as Solution, along as along
from .tableaux import METHODS as METHODS, Method as Method
from .transcribed import Collocation as Collocation
