"""Names that `symdyn.draw` offers; each is imported when it is first used."""

from .animate import animation as animation, moving_picture as moving_picture
from .films import Reel as Reel, check_film as check_film, film as film
from .force_arrows import Wrench as Wrench
from .free_bodies import acting_on as acting_on, free_body as free_body
from .ground import pushes as pushes
from .paint import tex_picture as tex_picture
from .pictures import Lettered as Lettered, picture as picture, swing as swing
from .plots import FilledFigure as FilledFigure
from .sheet import Sheet as Sheet
from .stage import Stage as Stage, pose as pose
from .style import Text as Text, style as style
from .svg import Diagram as Diagram
