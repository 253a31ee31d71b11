"""Names that `symdyn.bench` offers; each is imported when it is first used."""

from .case import Stress as Stress
from .measurements import (
    Bench as Bench,
    Curve as Curve,
    Errors as Errors,
    Measured as Measured,
    MotionPrecision as MotionPrecision,
    Point as Point,
)
from .report import (
    as_json as as_json,
    best as best,
    choices_of as choices_of,
    html as html,
    markdown as markdown,
    nanoseconds as nanoseconds,
    stress_html as stress_html,
    stress_markdown as stress_markdown,
    stress_rows as stress_rows,
)
from .stress import FAMILIES as FAMILIES, stress as stress
from .time_and_error import bench as bench
