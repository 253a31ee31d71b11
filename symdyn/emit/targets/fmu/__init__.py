"""The FMU target: a mechanism as a model of FMI 2.0 and of FMI 3.0; `functional_mockup.py` is its row."""

from symdyn.emit.targets.fmu.functional_mockup import FMU, needed, packed

__all__ = ["FMU", "needed", "packed"]
