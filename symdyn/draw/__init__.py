"""Pictures and animations of a scene: SVG and HTML text that needs nothing else, and files of many kinds."""

from symdyn.draw.animate import animation, moving_picture
from symdyn.draw.films import Reel, check_film, film
from symdyn.draw.force_arrows import Wrench
from symdyn.draw.free_body import acting_on, free_body
from symdyn.draw.pictures import Lettered, picture
from symdyn.draw.pose import pose

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
