"""From measured motion to parameters: base parameters with their standard errors, and a scene that has them."""

from symdyn.identification.criteria import CRITERIA
from symdyn.identification.door import identify
from symdyn.identification.excitation import Excitation
from symdyn.identification.exciting_motion import excite
from symdyn.identification.families import FAMILIES
from symdyn.identification.gains import Gain
from symdyn.identification.identification import Identification
from symdyn.identification.log import Log
from symdyn.identification.output_error import output_error
from symdyn.identification.output_fit import OutputFit
from symdyn.identification.payload import Payload
from symdyn.identification.regression import Regression
from symdyn.identification.scene import Identified, identified, with_parameters

__all__ = [
    "CRITERIA",
    "FAMILIES",
    "Excitation",
    "Gain",
    "Identification",
    "Identified",
    "Log",
    "OutputFit",
    "Payload",
    "Regression",
    "excite",
    "identified",
    "identify",
    "output_error",
    "with_parameters",
]
