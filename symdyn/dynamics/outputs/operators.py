"""What can be asked of every output: rows that are made of its row, by what is written behind its name.

Closed scenes have rows of their own in place of some, along the manifold of their states.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from symdyn.dynamics.mechanism.prescribed import INPUTS, TIME
from symdyn.dynamics.outputs.closed_derivatives import ALONG_MANIFOLD, CLOSED, MOTION_RESIDUAL, RESIDUAL, SOLVED
from symdyn.dynamics.outputs.derivative_outputs import BESIDE, by_parameters, derivatives, differentiable
from symdyn.dynamics.outputs.directional_outputs import ALONG_ONE
from symdyn.dynamics.outputs.output import Output
from symdyn.dynamics.outputs.output_table import OUTPUTS
from symdyn.dynamics.outputs.tangent_space import COLUMNS
from symdyn.errors import DerivationError

BY = "_by_"
"""Behind the name of an output, before that of an argument or a parameter."""

MOTION = ("q", "qd", "qdd", "tau", TIME)
"""What is an argument behind `BY`, though a parameter may be called so: NAME_by_parameters has its column."""


def _by(name: str, row: Output, only: str) -> Output:
    """Return the row of derivatives by an argument; by a parameter where that has the name and no argument has."""
    argument = only in row.arguments or only in (*MOTION, INPUTS)
    return derivatives(name, row, only) if argument else by_parameters(name, row, only)


OPERATORS: dict[str, Callable[[str, Output], Output]] = {
    **ALONG_ONE,
    "_derivatives": derivatives,
    **{f"{BY}{one}": partial(_by, only=one) for one in COLUMNS},
    f"{BY}parameters": by_parameters,
}
"""What can be asked of every output, by what is written behind its name, as in "inverse_dynamics_derivatives"."""

WORDS = tuple(f"NAME{one}" for one in (*OPERATORS, f"{BY}PARAMETER"))
"""The same in words, of an output called NAME."""


MANY: dict[str, Output] = {**OUTPUTS, RESIDUAL: MOTION_RESIDUAL}
"""Rows of which many others can be asked for, by a word behind their name."""


def words(of: str, closed: bool) -> list[str]:
    """Return what can be asked of an output, of closed scenes or of others."""
    if not closed or of not in ALONG_MANIFOLD:
        return _words_of(of, MANY[of])
    by = (f"{of}{BY}parameters", f"{of}{BY}PARAMETER") if of in SOLVED else ()
    return [*(one for one in CLOSED if one.startswith(f"{of}_")), *by]


def _words_of(name: str, row: Output) -> list[str]:
    """Return the same, those of arguments that it does not take left out."""
    along = differentiable(row)
    taken = [f"{BY}{one}" for one in (*along, *(BESIDE if along else ()), "parameters", "PARAMETER")]
    return [
        f"{name}{one}" for one in (*(OPERATORS if along else ()), f"{BY}PARAMETER") if BY not in one or one in taken
    ]


def of_another(name: str, outputs: Mapping[str, Output]) -> Output | None:
    """Return the row of what is asked of one of the outputs, such as "inverse_dynamics_derivatives"; None for no such.

    Raises:
        DerivationError: the output has no such derivatives.
    """
    for suffix, operator in OPERATORS.items():
        if name.endswith(suffix) and (row := outputs.get(of := name.removesuffix(suffix))):
            return operator(of, row)
    of, _, parameter = name.partition(BY)
    return by_parameters(of, outputs[of], parameter) if of in outputs and parameter.isidentifier() else None


def of_closed(name: str) -> Output | None:
    """Return the row that closed scenes have for what is asked; None where there is no other than that of all scenes.

    Raises:
        DerivationError: closed scenes have no such derivatives of what changes along their manifold.
    """
    if name in CLOSED:
        return CLOSED[name]
    output, by, parameter = name.partition(BY)
    if by and output in SOLVED and parameter not in MOTION:
        return ALONG_MANIFOLD[output].by_parameters("" if parameter == "parameters" else parameter)
    of = next((one for one in ALONG_MANIFOLD if name.startswith(f"{one}_") and of_another(name, OUTPUTS)), None)
    if of is None:
        return None
    raise DerivationError(
        f"where loops or rows close a scene there is no {name}; there are {', '.join(words(of, True))}"
    )
