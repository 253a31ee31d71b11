"""Names that `symdyn.dynamics.contacts` offers; each is imported when it is first used."""

from .contact_equations import (
    MODE as MODE,
    ContactEquations as ContactEquations,
    Touch as Touch,
    contact_equations as contact_equations,
    has_modes as has_modes,
    with_modes as with_modes,
)
