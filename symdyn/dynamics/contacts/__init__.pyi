"""Names that `symdyn.dynamics.contacts` offers; each is imported when it is first used."""

from .contact_equations import ContactEquations as ContactEquations, contact_equations as contact_equations
from .contact_rows import MODE as MODE, Touch as Touch, lacks_modes as lacks_modes, with_modes as with_modes
