"""Pictures and animations of a scene: SVG and HTML text that needs nothing else, and files of many kinds.

Doors are imported when they are first used: a plot of a run needs none of them.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from symdyn.draw.animate import animation
    from symdyn.draw.films import check_film, film
    from symdyn.draw.force_arrows import Wrench
    from symdyn.draw.free_bodies import acting_on, free_body
    from symdyn.draw.pictures import Lettered, picture
    from symdyn.draw.positions import pose
    from symdyn.draw.reel import Reel
    from symdyn.draw.smil import moving_picture

_DOORS = {
    "Lettered": "pictures",
    "Reel": "reel",
    "Wrench": "force_arrows",
    "acting_on": "free_bodies",
    "animation": "animate",
    "check_film": "films",
    "film": "films",
    "free_body": "free_bodies",
    "moving_picture": "smil",
    "picture": "pictures",
    "pose": "positions",
}

__all__ = [
    "Lettered",
    "Reel",
    "Wrench",
    "acting_on",
    "animation",
    "check_film",
    "film",
    "free_body",
    "moving_picture",
    "picture",
    "pose",
]

if not TYPE_CHECKING:  # else a type checker would believe that there is whatever is asked for

    def __getattr__(name):
        """Import a door when it is first asked for."""
        if name not in _DOORS:
            raise AttributeError(f"symdyn.draw has no {name!r}; it has {', '.join(__all__)}")
        return getattr(import_module(f"symdyn.draw.{_DOORS[name]}"), name)
