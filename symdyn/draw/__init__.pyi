"""Names that `symdyn.draw` offers; each is imported when it is first used."""

from .animate import animation as animation
from .diagram import Diagram as Diagram
from .drawn import drawn as drawn
from .figures import FilledFigure as FilledFigure
from .films import FILMS as FILMS, check_film as check_film, film as film
from .force_arrows import Wrench as Wrench, from_zero as from_zero
from .free_bodies import acting_on as acting_on, free_body as free_body
from .lettering import Text as Text
from .outlines import outline as outline
from .picture_files import check_picture as check_picture
from .pictures import Lettered as Lettered, picture as picture
from .positions import extent_of as extent_of, pose as pose
from .reel import Reel as Reel
from .shown_text import HtmlText as HtmlText, SvgText as SvgText
from .smil import moving_picture as moving_picture
from .stage import Stage as Stage
from .style import style as style
from .swing import swing as swing
from .tex import tex_picture as tex_picture
