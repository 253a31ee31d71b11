"""Names that `symdyn.scene.forces` offers; each is imported when it is first used."""

from .constraints import in_plane as in_plane
from .force_table import (
    FORCES as FORCES,
    elastic as elastic,
    without_place as without_place,
)
