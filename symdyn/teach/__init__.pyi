"""Names that `symdyn.teach` offers; each is imported when it is first used."""

from .document import Document as Document
from .interactive.page import interactive_page as interactive_page
from .languages import languages as languages
from .mathml import flow as flow, inline as inline
from .practice.exercises import GRADES as GRADES, with_exercises as with_exercises
from .practice.sheet import sheet as sheet
from .practice.variants import variant as variant, with_changes as with_changes
from .render import rendered as rendered
from .roads.lessons import walkthrough as walkthrough
from .student.answer import Answer as Answer
from .student.answers import in_words as in_words
from .student.derivation_check import check_derivation as check_derivation
from .student.statements import find_target as find_target
