"""The graph of the target "json" as Python callables, one state a call: what any reader of the file has to do."""

from __future__ import annotations

import json
import math
import operator
from collections.abc import Callable, Mapping
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.emit import Sources
from symdyn.runtime.warned import check_target

OPERATIONS: Mapping[str, Callable[..., float]] = {
    "pi": lambda: math.pi,
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "div": lambda a, b: float(np.divide(a, b)),
    "neg": operator.neg,
    "abs": abs,
    "sign": lambda a: float(np.sign(a)),
    **{name: getattr(math, name) for name in ("sin", "cos", "sqrt", "exp", "log", "tanh", "atan2")},
}


def run_json(sources: Sources) -> SimpleNamespace:
    """Return the functions of sources that `emit(program, "json")` made, evaluated in doubles, node by node.

    Raises:
        BuildError: sources of another target.
    """
    check_target(sources, "json")
    (text,) = sources.texts.values()
    graph = json.loads(text)
    named = zip(sources.functions, graph["functions"], strict=True)
    return SimpleNamespace(**{name: _call(graph["nodes"], function) for name, function in named})


def _call(nodes: list[list[Any]], function: dict[str, Any]) -> Callable[..., Any]:
    needed = {*function["entries"]}
    for number in range(len(nodes) - 1, -1, -1):
        if number in needed and nodes[number][0] not in ("constant", "symbol"):
            needed.update(nodes[number][1:])

    def call(*values: npt.ArrayLike) -> Any:
        value: dict[int, float] = {}
        for argument, given in zip(function["arguments"], values, strict=True):
            value.update(zip(argument["entries"], np.ravel(given).astype(float).tolist(), strict=True))
        for number in sorted(needed - {*value}):
            name, *rest = nodes[number]
            constant = name == "constant"
            value[number] = float(Fraction(rest[0])) if constant else OPERATIONS[name](*(value[k] for k in rest))
        return np.array([value[entry] for entry in function["entries"]]).reshape(function["shape"])[()]

    return call
