"""Names that `symdyn.bench` offers; each is imported when it is first used."""

from .measurements import (
    Bench as Bench,
    Curve as Curve,
    Errors as Errors,
    Measured as Measured,
    MotionPrecision as MotionPrecision,
    Point as Point,
)
from .stress import FAMILIES as FAMILIES, stress as stress
from .time_and_error import bench as bench
