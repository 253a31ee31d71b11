"""Names that `symdyn.notebook` offers; each is imported when it is first used."""

from .mechanisms import closed_form as closed_form, equations_of_motion as equations_of_motion
from .page import bundle as bundle
