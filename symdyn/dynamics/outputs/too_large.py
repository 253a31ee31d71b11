"""Requests that are too large to be written as lines: refused in words, before they are begun."""

from __future__ import annotations

from symdyn.dynamics.mechanism.cost import cost
from symdyn.dynamics.outputs.derivative_outputs import differentiable
from symdyn.dynamics.outputs.operators import BY, OPERATORS
from symdyn.dynamics.outputs.output_table import OUTPUTS
from symdyn.dynamics.outputs.requests import row_of
from symdyn.dynamics.outputs.size import INVERSE, PLENTY, depths_of
from symdyn.dynamics.outputs.workspace import Workspace


def too_large(workspace: Workspace, request: str) -> str:
    """Return why an output that the scene has is not written as lines, with its size and what to ask for instead.

    "" where it is; inverse dynamics is derived for that only where the size by rows alone is too large.
    """
    if expected_size(workspace, request) <= PLENTY:
        return ""
    simple = workspace.once(simplicity)
    size = expected_size(workspace, request, simple)
    if size <= PLENTY:
        return ""
    ways = [other for other in _instead(workspace, request) if expected_size(workspace, other, simple) <= PLENTY]
    ask = f"ask for {' or '.join(ways)}" if ways else "ask for fewer functions"
    return (
        f"{workspace.scene.name}: {request} would take some {_rounded(size):,} operations, and {PLENTY:,} are "
        f"the most that are written as lines; {ask}; inverse_dynamics and forward_dynamics are loops at any length"
    )


def expected_size(workspace: Workspace, request: str, simple: float = 1.0) -> float:
    """Return about how many operations a request takes, weighed; `simple` is 1 where joints turn every way."""
    return row_of(request, workspace.scene)[0].size.of(workspace.once(_depths), simple)


def _depths(workspace: Workspace) -> list[int]:
    return depths_of(workspace.scene)


def simplicity(workspace: Workspace) -> float:
    """Return how many times as large inverse dynamics is as that of joints that turn every way."""
    w = workspace
    entries = w.once(OUTPUTS["inverse_dynamics"].formulations["rnea"].derive)
    return cost(entries, {*w.state.q, *w.state.qd, *w.state.qdd}) / INVERSE.of(w.once(_depths))


def _instead(workspace: Workspace, request: str) -> list[str]:
    """Return what says the same in parts, or along one direction."""
    name, colon, place = request.partition(":")
    suffix = next((one for one in OPERATORS if name.endswith(one)), "")
    base = name.removesuffix(suffix)
    row = row_of(f"{base}{colon}{place}", workspace.scene)[0]
    words = [*(f"{BY}{one}" for one in differentiable(row)), "_jvp", "_vjp"] if suffix else []
    return [f"{base}{word}{colon}{place}" for word in words if word != suffix]


def _rounded(size: float) -> int:
    """Return a size to two digits."""
    return int(float(f"{size:.1e}"))
