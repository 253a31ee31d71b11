"""Names that `symdyn.transcription` offers; each is imported when it is first used."""

from .grid import METHODS as METHODS, Method as Method
from .problem import collocation as collocation
from .solution import Solution as Solution, along as along
from .transcribed import Collocation as Collocation
