"""The function `equations`: the equations of motion of a scene, to be read or to be worked on with SymPy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from symdyn.arguments import check_arguments
from symdyn.dynamics import ClosedForm, closed_form
from symdyn.emit.print.equations_text import CHOICES, equations_text
from symdyn.emit.print.printable import Printable
from symdyn.emit.print.sympy_equations import SympyEquations, sympy_equations
from symdyn.errors import EmitError
from symdyn.scene import Scene, SceneLike, scene_of
from symdyn.shown import Shown
from symdyn.unlocked import cached_property


@dataclass(frozen=True)
class EquationsOfMotion(Shown):
    """The equations of motion of a scene in closed form.

    Attributes:
        scene: the mechanism.
        choices: what can be printed, by argument of `printed_text`.
    """

    choices: ClassVar[Mapping[str, tuple[str, ...]]] = CHOICES

    scene: Scene

    def __repr__(self) -> str:
        return f"<EquationsOfMotion of {self.scene.name}: .latex(), .text(), .sympy()>"

    @cached_property
    def closed(self) -> ClosedForm:
        """The coefficients, worked out when they are first asked for; DerivationError where there is no closed form."""
        return closed_form(self.scene)

    @cached_property
    def page(self) -> Printable:
        """What is said of the scene, before it is spelled; DerivationError where nobody would read it."""
        return Printable.of(self.closed)

    def latex(self, group: str = "equations", angles: str = "long", document: bool = False) -> str:
        r"""Return the equations in LaTeX, for a text that loads amsmath.

        Args:
            group: "equations" (one a joint), "coefficients" (k_{z,11} = …), "textbook" (under-braced) or "matrix".
            angles: "long" for \sin(q_1 + q_2), "short" for s_{12}.
            document: a whole document, with energies and a table of symbols.

        Raises:
            EmitError: an unknown choice.
            DerivationError: the scene has no closed form, or its loops cannot be assembled.

        >>> import symdyn
        >>> print(symdyn.equations(symdyn.example("pendulum")).latex())
        \begin{align*}
          m l^2 \ddot q_1 + m l g \sin q_1 &= \tau_1 - b \dot q_1
        \end{align*}
        """
        check_arguments(EquationsOfMotion.latex, locals(), EmitError)
        return equations_text(self.closed, "latex", group, angles, document)

    def text(self, group: str = "equations", angles: str = "long") -> str:
        """Return the equations in plain text, which `symdyn.scene.parse` reads back; the rest as for `latex`.

        >>> import symdyn
        >>> print(symdyn.equations(symdyn.example("pendulum")).text())
        m*l**2*q1_ddot + m*l*g*sin(q1) = tau1 - b*q1_dot
        """
        check_arguments(EquationsOfMotion.text, locals(), EmitError)
        return equations_text(self.closed, "text", group, angles)

    def sympy(self, dynamic: bool = False) -> SympyEquations:
        """Return the equations as matrices and symbols of SymPy, numbers exact.

        Args:
            dynamic: whether coordinates, drives, inputs and multipliers are SymPy's `dynamicsymbols`, which are
                functions of time, and velocities their derivatives; else all are symbols, real, and positive where a
                parameter is.

        Raises:
            DerivationError: as for `latex`. What would take minutes is refused, with what works in its place.

        >>> import symdyn
        >>> arm = symdyn.equations(symdyn.example("two_link")).sympy()
        >>> arm.M[1, 1], arm.g[1]
        (h2**2*m2, g*h2*m2*sin(q1 + q2))
        """
        check_arguments(EquationsOfMotion.sympy, locals(), EmitError)
        return sympy_equations(self.page, dynamic)


def equations(scene: SceneLike) -> EquationsOfMotion:
    """Return the equations of motion of a scene: `.latex()`, `.text()` and `.sympy()`; a notebook shows them.

    Args:
        scene: a scene, a path or an open file.

    Raises:
        SceneError: the file has faults.

    >>> import symdyn
    >>> symdyn.equations(symdyn.example("pendulum")).sympy().M
    Matrix([[l**2*m]])
    """
    return EquationsOfMotion(scene_of(scene))
