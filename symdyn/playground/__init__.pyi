"""Names that `symdyn.playground` offers; each is imported when it is first used."""

from .answers import Settings as Settings, answer as answer
from .following import play as play
