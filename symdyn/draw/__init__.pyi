"""Names that `symdyn.draw` offers; each is imported when it is first used."""

from .animate import animation as animation
from .canvas import import_matplotlib as import_matplotlib, saved as saved, settings as settings
from .curves import Curve as Curve, curves as curves, ellipse as ellipse
from .drawn import Key as Key, drawn as drawn
from .films import FILMS as FILMS, Told as Told, check_film as check_film, film as film
from .force_arrows import Wrench as Wrench, from_zero as from_zero
from .free_bodies import acting_on as acting_on, free_body as free_body
from .label_places import Label as Label, Put as Put
from .lettering import (
    FONT as FONT,
    Run as Run,
    Text as Text,
    from_latex as from_latex,
    lettered as lettered,
    words as words,
)
from .looks import Look as Look, look_of as look_of
from .outlines import Formed as Formed, outline as outline
from .picture_files import check_picture as check_picture
from .pictures import (
    Lettered as Lettered,
    mechanism as mechanism,
    picture as picture,
    spread as spread,
    watched as watched,
)
from .places import Array as Array, places as places
from .positions import extent_of as extent_of, limits_of as limits_of, pose as pose, values_of as values_of
from .reel import Reel as Reel
from .shapes import Item as Item, Shape as Shape, dot as dot, path as path
from .shown_text import HtmlText as HtmlText, SvgText as SvgText
from .smil import moving_picture as moving_picture
from .style import style as style
from .svg import Drawing as Drawing, svg as svg
from .titles import Title as Title
from .view import View as View
