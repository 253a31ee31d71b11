"""Names that `symdyn.watch` offers; each is imported when it is first used."""

from .watching import Watched as Watched, watch as watch
