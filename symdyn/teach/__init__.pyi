"""Names that `symdyn.teach` offers; each is imported when it is first used."""

from .document import Document as Document
from .languages import languages as languages
from .mathematics import flow as flow, inline as inline
from .render import rendered as rendered
from .render.handout import Handout as Handout, walkthrough as walkthrough
from .render.page import interactive_page as interactive_page
from .student.answer import in_words as in_words
from .student.derivation_check import check_derivation as check_derivation
