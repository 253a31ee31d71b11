"""Names that `symdyn.draw` offers; each is imported when it is first used."""

from .animate import animation as animation
from .diagram import Diagram as Diagram
from .figures import FilledFigure as FilledFigure
from .films import FILMS as FILMS, check_film as check_film, film as film
from .force_arrows import Wrench as Wrench
from .free_bodies import acting_on as acting_on, free_body as free_body
from .lettering import Text as Text
from .pictures import Lettered as Lettered, picture as picture
from .positions import pose as pose
from .reel import Reel as Reel
from .sheet import Sheet as Sheet
from .smil import moving_picture as moving_picture
from .stage import Stage as Stage
from .style import style as style
from .swing import swing as swing
from .tex import tex_picture as tex_picture
