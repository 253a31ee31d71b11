"""A function of a scene, ready to call with arrays: values go by place or by name, and errors name what they are about.

A call by place alone is the compiled function's own; only one that it refuses, or that names values, is looked at here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from inspect import Parameter, Signature
from typing import Any, ClassVar

import numpy as np

from symdyn.dynamics import Function
from symdyn.errors import ArgumentError
from symdyn.scene import Scene
from symdyn.scene.values import listed, spell, suggestion
from symdyn.shown import Shown

WORDS = frozenset({"out", "axes", "casting", "dtype", "order", "signature", "subok"})
"""Keywords of NumPy; what has one of these names in a scene is given by place."""

REAL = "biuf"
"""Kinds of NumPy's types that are real numbers."""

BY_NAME = ("params", "inputs")
"""Arguments whose entries a call is likely to name."""


@dataclass(frozen=True)
class Operand:
    """One argument of a function.

    Attributes:
        name: such as "q" or "params".
        entries: names of its entries, such as "m1".
        scalar: whether it is one number, as time is.
    """

    name: str
    entries: tuple[str, ...]
    scalar: bool


@dataclass(frozen=True, eq=False, repr=False)
class NumericFunction(Shown):
    """A function of arrays (n,) or (..., n), whose leading dimensions broadcast.

    `f(q, qd, qdd, params)` goes by place; `f(q, qd, qdd, m1=2, h1=1)` names the entries of what is left out, and
    `f(q, qd, params=x)` whole arguments. It pickles: the other process makes it again.

    Attributes:
        name: such as "mass_matrix".
        call: what computes, by place alone.
        operands: its arguments, in order.
        description: how it is called, such as "mass_matrix(q, params) -> M: (2),(5)->(2,2)".
        usual: values of entries that a call need not give, such as inputs.
        fixed: parameters that are numbers in its code, with their values as text.
        again: a function and its arguments, which make it in another process.
    """

    name: str
    call: Callable[..., Any]
    operands: tuple[Operand, ...]
    description: str
    usual: Mapping[str, float] = field(default_factory=dict)
    fixed: Mapping[str, str] = field(default_factory=dict)
    again: tuple[Callable[..., Any], tuple[Any, ...]] | None = None
    words: ClassVar[frozenset[str]] = WORDS

    def __post_init__(self) -> None:
        """Take over what help shows."""
        self.__dict__.update(__name__=self.name, __qualname__=self.name, __doc__=self.call.__doc__)

    def __call__(self, *given: Any, **named: Any) -> Any:
        """Return the result; see the class.

        Raises:
            ArgumentError: a value that is missing, given twice, or nothing that the function takes.
        """
        if len(given) < len(self.operands) or not self.words.issuperset(named):
            values = {key: named.pop(key) for key in list(named) if key not in self.words}
            given = self._completed(given, values)
        try:
            return self.call(*given, **named)
        except (TypeError, ValueError) as error:
            faults = self._faults(given)
            if not faults:
                raise
            raise ArgumentError(f"{self.name}: {'; '.join(faults)}") from error

    def __repr__(self) -> str:
        return f"<{self.description}>"

    def __reduce__(self) -> Any:
        if self.again is None:
            raise TypeError(f"{self.name} does not say how to make it again")
        return self.again

    @property
    def __signature__(self) -> Signature:
        """What editors and help show."""
        takes = [Parameter(one.name, Parameter.POSITIONAL_OR_KEYWORD) for one in self.operands]
        names = [name for one in self.operands if one.name in BY_NAME for name in one.entries if name.isidentifier()]
        taken = {one.name for one in self.operands} | self.words
        kind = Parameter.KEYWORD_ONLY
        free = [Parameter(name, kind, default=self.usual.get(name)) for name in names if name not in taken]
        return Signature([*takes, *free])

    def _completed(self, given: Sequence[Any], named: dict[str, Any]) -> tuple[Any, ...]:
        """Return all arguments by place."""
        known = {one.name: value for one, value in zip(self.operands, given, strict=False)}
        faults = []
        for one in self.operands[len(given) :]:
            if one.name in named:
                known[one.name] = named.pop(one.name)
                continue
            taken = {name: named.pop(name) for name in one.entries if name in named}
            missing = [name for name in one.entries if name not in taken and name not in self.usual]
            if missing:
                faults.append(f"{one.name} is missing" + (f": {listed(missing)}" if missing != [one.name] else ""))
            elif one.scalar:
                known[one.name] = (taken or self.usual)[one.entries[0]]
            else:
                known[one.name] = self._together([taken.get(name, self.usual.get(name)) for name in one.entries])
        faults += [self._strange(name, known) for name in named]
        if faults:
            raise ArgumentError(f"{self.name}: {'; '.join(faults)}; {self.description}")
        return (*(known[one.name] for one in self.operands), *given[len(self.operands) :])

    def _strange(self, name: str, known: Mapping[str, Any]) -> str:
        """Return what is wrong with a name."""
        if name in self.fixed:
            return (
                f'{name} has the value {self.fixed[name]} in the scene and is a number here; load(…, free="{name}") '
                "takes it by name"
            )
        if name in known:
            return f"{name} is given by place and by name"
        for one in self.operands:
            if name in one.entries and one.name in known:
                return f"{name} is given by name and in {one.name}"
        names = [name for one in self.operands if one.name not in known for name in (one.name, *one.entries)]
        return f"there is no {name}" + (f"; {suggestion(name, names)}" if names else "")

    def _faults(self, given: Sequence[Any]) -> list[str]:
        """Return what is wrong with arguments, as far as it can be told."""
        if len(given) > len(self.operands) + 1:
            return [f"{len(given)} arguments are given; {self.description}"]
        faults, leading = [], {}
        for one, value in zip(self.operands, given, strict=False):
            shape = self._shape(value)
            wanted = "one number" if one.scalar else f"{len(one.entries)} numbers, {listed(one.entries)}"
            if shape is None:
                faults.append(f"{one.name} is no array of real numbers; give {wanted}")
            elif not one.scalar and shape[-1:] != (len(one.entries),):
                found = f"has {shape[-1]} in its last dimension" if shape else "is one number"
                faults.append(f"{one.name} {found}; give {wanted}")
            else:
                leading[one.name] = shape if one.scalar else shape[:-1]
        try:
            np.broadcast_shapes(*leading.values())
        except ValueError:
            shown = ", ".join(f"{name} {shape}" for name, shape in leading.items())
            faults.append(f"leading dimensions do not broadcast: {shown}")
        return faults

    def _shape(self, value: Any) -> tuple[int, ...] | None:
        """Return the shape of real numbers, None of anything else."""
        try:
            array = np.asarray(value)
        except ValueError:  # rows of several lengths
            return None
        return array.shape if array.dtype.kind in REAL else None

    def _together(self, values: Sequence[Any]) -> Any:
        """Return entries as one array, along its last dimension."""
        try:
            return self._stack(values)
        except (ValueError, RuntimeError) as error:
            raise ArgumentError(f"values by name do not broadcast: {error}") from error

    def _stack(self, values: Sequence[Any]) -> Any:
        """Return the same; ValueError where they do not broadcast."""
        return np.stack(np.broadcast_arrays(*values), axis=-1)


def numeric_function(
    scene: Scene,
    name: str,
    function: Function,
    call: Callable[..., Any],
    usual: Mapping[str, float],
    again: tuple[Callable[..., Any], tuple[Any, ...]],
) -> NumericFunction:
    """Return a function that computes as `call`, with the names that a scene gives its arguments' entries."""
    operands = tuple(
        Operand(one.name, tuple(str(x.value) for x in one.symbols), one.scalar) for one in function.arguments
    )
    free = {entry for one in operands for entry in one.entries}
    usual = {**{one.name: float(one.value.at({}) or 0) for one in scene.inputs}, **usual}
    fixed = {p.name: spell(p.value) for p in scene.parameters if p.value is not None and p.name not in free}
    return NumericFunction(name, call, operands, signature(name, function), usual, fixed, again)


def signature(name: str, function: Function) -> str:
    """Return how a function is called, and the lengths of its operands."""
    names = ", ".join(argument.name for argument in function.arguments)
    lengths = ",".join(f"({','.join(map(str, argument.shape))})" for argument in function.arguments)
    shape = ",".join(map(str, function.shape))
    return f"{name}({names}) -> {function.result}: {lengths}->({shape})"
