"""Names that `symdyn.scene.forces` offers; each is imported when it is first used."""

from .contact import in_plane as in_plane
from .force_kind import Mark as Mark, Rim as Rim, Touch as Touch
from .force_table import (
    elastic as elastic,
    formula_of as formula_of,
    resisting as resisting,
    rub_of as rub_of,
    touch_of as touch_of,
    touches as touches,
    without_place as without_place,
)
