"""Parameters that are made up to stand for numbers, no two of one name."""

from __future__ import annotations

from symdyn.graph import Graph
from symdyn.scene.values.folding import neg
from symdyn.scene.values.model import Parameter
from symdyn.scene.values.quantity import Quantity


class Names:
    """Parameters as they are made up."""

    def __init__(self, suffix: str) -> None:
        self.suffix = suffix
        self.added: list[Parameter] = []

    def of(self, quantity: Quantity, name: str, unit: str, text: str, positive: bool = False) -> Quantity:
        """Return a symbol for a number, and what is zero or a formula in symbols as it is.

        Args:
            quantity: what may be a number.
            name: of the parameter; another one of that name is called <name>_2.
            unit: of the parameter.
            text: of the parameter.
            positive: let the parameter be the magnitude of the number, and the sign stand in front of it.
        """
        if quantity.symbols:
            return quantity
        if quantity.express(Graph()).is_zero:
            return Quantity.ZERO
        value = quantity.at({})
        negative = positive and value is not None and value < 0
        quantity = neg(quantity) if negative else quantity
        taken = {parameter.name for parameter in self.added}
        unique, k = f"{name}{self.suffix}", 1
        while unique in taken:
            k += 1
            unique = f"{name}_{k}{self.suffix}"
        self.added.append(Parameter(unique, quantity, positive, unit, None, text))
        return -Quantity.symbol(unique) if negative else Quantity.symbol(unique)
