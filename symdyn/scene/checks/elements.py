"""What acts: everything that its kind and the parts of its table know to be wrong."""

from __future__ import annotations

from collections.abc import Mapping

from symdyn.scene.checks.draft import Draft
from symdyn.scene.forces import FORCES
from symdyn.scene.forces.kind import Stand
from symdyn.scene.values.table import Faults
from symdyn.scene.values.value import Value


def check_elements(draft: Draft, values: Mapping[str, Value], faults: Faults) -> None:
    """Report what is wrong with the elements, one by one."""
    for where, one in zip(draft.where["elements"], draft.scene.elements, strict=True):
        kind, stand = FORCES[one.kind], Stand(where, draft.scene, values, faults)
        for part in kind.parts:
            part.check(one, stand)
        if kind.check is not None:
            kind.check(one, stand)
