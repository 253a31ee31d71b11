"""A function of the page on the workspace's graph."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics import Function, Workspace
from symdyn.dynamics.mechanism.prescribed import TIME
from symdyn.dynamics.roads.equations import arguments
from symdyn.graph import Expr, Op, reachable


def function(
    workspace: Workspace,
    name: str,
    text: str,
    entries: Sequence[Expr],
    takes: Sequence[str],
    shape: tuple[int, ...] | None = None,
) -> Function:
    """Return entries as a function of what it takes, of time too where they depend on it."""
    timed = any(node.op is Op.SYMBOL and node.value == TIME for node in reachable(entries))
    given = arguments(workspace, (*takes, *((TIME,) if timed else ())))
    return Function(name, text, given, name, (len(entries),) if shape is None else shape, tuple(entries), "", name)
