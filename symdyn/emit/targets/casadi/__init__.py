"""The CasADi target: `module.py` is its row, `jacobians.py` finds derivatives, `external.py` writes C for CasADi."""

from symdyn.emit.targets.casadi.jacobians import JacobianBlock, jacobians
from symdyn.emit.targets.casadi.module import CASADI, EXTERNAL

__all__ = ["CASADI", "EXTERNAL", "JacobianBlock", "jacobians"]
