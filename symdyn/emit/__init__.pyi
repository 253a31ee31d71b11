"""Names that `symdyn.emit` offers; each is imported when it is first used."""

from .code.target import Draft as Draft, Sources as Sources, Target as Target
from .render import (
    in_code as in_code,
    in_html as in_html,
    in_latex as in_latex,
    in_markdown as in_markdown,
    render as render,
    verbatim as verbatim,
)
from .targets.c.c_and_cpp import C as C
from .targets.emit_program import TARGETS as TARGETS, Entries as Entries, beside as beside, emit as emit
from .targets.fmu import packed as packed
from .targets.gpu import budgets as budgets
from .targets.json_graph import read_program as read_program
from .targets.ufunc import Code as Code
from .writing import Contents as Contents, check_folder as check_folder, write as write, write_file as write_file
