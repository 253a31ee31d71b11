"""Functions of C as loops over a table of joints: constants are data, the text is the same for all joints of a kind."""

from collections.abc import Callable

from symdyn.dynamics.recursive.table_loops import TableLoop
from symdyn.emit.code.operators import Printer
from symdyn.emit.targets.c.loops.forward import ForwardText, forward_text
from symdyn.emit.targets.c.loops.inverse import InverseText, inverse_text
from symdyn.scene import Scene

__all__ = ["loop_text"]

_TEXTS: dict[str, Callable[..., InverseText | ForwardText]] = {"rnea_loop": inverse_text, "aba_loop": forward_text}


def loop_text(loop: TableLoop, scene: Scene, printer: Printer, width: int) -> InverseText | ForwardText:
    """Return what the template needs of a loop over a table of a scene; a number takes `width` bytes."""
    return _TEXTS[loop.road](loop.table, scene, printer, width)
