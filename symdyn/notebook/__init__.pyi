"""Names that `symdyn.notebook` offers; each is imported when it is first used."""

from .mechanisms import equations_of_motion as equations_of_motion
from .page import bundle as bundle
