"""From measured motion to parameters: base parameters with their standard errors, and a scene that has them."""

from symdyn.identification.door import identify
from symdyn.identification.identification import Identification
from symdyn.identification.log import Log
from symdyn.identification.regression import Regression

__all__ = ["Identification", "Log", "Regression", "identify"]
