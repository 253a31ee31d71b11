"""The function `equations`: the equations of motion of a scene, to be read or to be worked on with SymPy.

They are grouped one way or another, in every format, and base parameters with them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from symdyn.algebra import Form
from symdyn.arguments import argument, check_arguments, checked
from symdyn.dynamics import ClosedForm, closed_form
from symdyn.emit.print.formula_text import Latex, rounded, text_of
from symdyn.emit.print.printable import ENTRYWISE, Printable
from symdyn.emit.print.printed_names import latex_symbols
from symdyn.emit.print.sympy_page import sympy_definitions, sympy_page
from symdyn.emit.print.written_page import (
    base_parameter_name,
    latex_definitions,
    latex_document,
    latex_fragment,
    text_definitions,
    text_page,
)
from symdyn.errors import EmitError, choice, quoted
from symdyn.frozen import dataclass
from symdyn.rounding import requested_digits
from symdyn.scene import Scene, SceneLike, scene_of
from symdyn.shown import BySympy, Shown
from symdyn.unlocked import cached_property

if TYPE_CHECKING:
    from symdyn.algebra import Array
    from symdyn.emit.print.sympy_equations import SympyEquations


@dataclass(frozen=True)
class Format:
    """What equations are written in."""

    page: Callable[[Printable, str], str]  # writes equations by group
    definitions: Callable[[Scene, Sequence[tuple[str, Form]]], str]  # writes name = formula
    document: Callable[[Printable, str], str] | None = None  # writes a whole document of them; None where it has none
    digits: int | None = None  # most digits of a number; None leaves them exact, or to `page`


FORMATS = {
    "latex": Format(latex_fragment, latex_definitions, latex_document),
    "text": Format(text_page, text_definitions, digits=15),  # what every double holds
    "sympy": Format(sympy_page, sympy_definitions),
}
GROUPS = tuple(ENTRYWISE)

IN_PLACE = ("base-parameters", "inverse-kinematics")
"""What can be printed in place of equations."""

SHORT = ("sc", "SC")
"""Letters of sines and cosines by joint number; where a scene has s1 or c2, the next."""

_CHOICES = {"format": tuple(FORMATS), "group": GROUPS, "angles": ("long", "short")}


def equations_text(
    scene: Scene | ClosedForm,
    format: str = "latex",
    group: str = "equations",
    angles: str = "long",
    document: bool = False,
) -> str:
    r"""Return the equations of motion as text.

    Args:
        scene: the mechanism, or its closed forms.
        format: "latex", "text" (`symdyn.scene.parse` reads it back; numbers exact, but for those of more digits than
            a double holds, rounded to 15) or "sympy" (Python that runs after `from sympy import *`; numbers exact).
        group: "equations" (one a joint), "coefficients" (k_{z,11} = …), "textbook" (under-braced, as (5.40)) or
            "matrix" (M(q) q̈ + c + g).
        angles: "long" for \sin(q_1 + q_2), "short" for s_{12}, or S_{12} where a symbol has that letter.
        document: a whole LaTeX document with energies and a symbol table.

    Raises:
        EmitError: an unknown choice, or a document in another format than LaTeX.
        DerivationError: the scene has no closed form, or its loops cannot be assembled.
    """
    _check("format", format)
    _check("group", group)
    _check("angles", angles)
    write = FORMATS[format].document if document else FORMATS[format].page
    if write is None:
        raise EmitError(f"a document is written in LaTeX, not as {format}; leave the format out, or the document")
    letters = SHORT[group == "matrix" :] if angles == "short" else ()  # c_2 is an entry of M q̈ + c + g
    return write(Printable.of(scene, letters, requested_digits() or FORMATS[format].digits), group)


def base_parameters_text(scene: Scene, format: str = "latex") -> str:
    """Return every base parameter as `name = formula`, the ground's side first; `format` as for `equations_text`.

    Raises:
        EmitError: an unknown format.
        DerivationError: a formula has no closed form.
    """
    from symdyn.dynamics import base_parameter_forms

    _check("format", format)
    digits, named = requested_digits(), base_parameter_forms(scene)
    shown = named if digits is None else [(name, rounded(form, digits)) for name, form in named]
    return FORMATS[format].definitions(scene, shown)


def _check(name: str, value: str) -> None:
    if value not in _CHOICES[name]:
        raise EmitError(f"{name} {value!r} is not known; {choice(value, _CHOICES[name])}")


def base_parameter_texts(scene: Scene) -> list[dict[str, str]]:
    """Return name, formula, LaTeX of both, and unit of every base parameter, numbers exact."""
    from symdyn.dynamics import base_parameter_forms

    write = Latex(latex_symbols(scene), digits=None)
    return [
        {
            "name": name,
            "formula": text_of(form),
            "latex": f"{base_parameter_name(name)} = {write.unbroken(form)}",
            "unit": "kg" if name[0] == "M" else "kg m" if name[0] == "m" else "kg m^2",
        }
        for name, form in base_parameter_forms(scene)
    ]


def printed_text(
    scene: Scene | ClosedForm,
    format: str = "latex",
    what: str = "equations",
    angles: str = "long",
    document: bool = False,
    formulation: str = "lagrange",
) -> str:
    """Return the equations of motion as `equations_text` does, or what can be printed in place of them.

    `what` is a group of equations, "base-parameters", or "inverse-kinematics" of an arm; `formulation` "lagrange", or
    "dalembert" for (5.18).

    Raises:
        EmitError, DerivationError: as `equations_text`, or as those that print the others.
    """
    if formulation == "lagrange" and what not in IN_PLACE:
        return equations_text(scene, format, what, angles, document)
    if angles != "long":
        raise EmitError(f"{angles} angles are those of equations in closed form; leave {argument('angles')} out")
    plain = scene.scene if isinstance(scene, ClosedForm) else scene
    if formulation == "lagrange" and what == "base-parameters":
        if document:
            others = f"{argument('document')} out, or {argument('what', 'base-parameters')}"
            raise EmitError(f"a document holds equations; leave {others}")
        return base_parameters_text(plain, format)
    if formulation != "lagrange" and what != "equations":
        others = f"{argument('what')} out, or {argument('formulation', 'dalembert')}"
        raise EmitError(f"the formulation {formulation} is no {what}; leave {others}")
    if formulation == "dalembert":
        from symdyn.emit.print.dalembert_page import dalembert_equations

        return dalembert_equations(plain, format, document)
    from symdyn.emit.print.formulations_page import formulation_text

    _check("format", format)
    return formulation_text(plain, what if what in IN_PLACE else formulation, format, document)


FORMULATIONS = (
    "lagrange",
    "dalembert",
    "hamilton",
    "routh",
    "kane",
    "gibbs-appell",
    "udwadia-kalaba",
    "port-hamiltonian",
    "contact",
)

CHOICES = {**_CHOICES, "what": (*GROUPS, *IN_PLACE), "formulation": FORMULATIONS}
"""What can be printed, by argument of `printed_text`."""


@dataclass(frozen=True)
class EquationsOfMotion(Shown, BySympy):
    """The equations of motion of a scene in closed form.

    Attributes:
        scene: the mechanism.
        formulation: how they are derived and written: "lagrange", in closed form, or another that is printed.
        choices: what can be printed, by argument of `printed_text`.
    """

    choices: ClassVar[Mapping[str, tuple[str, ...]]] = CHOICES

    scene: Scene
    formulation: str = "lagrange"

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
            angles: "long" for \sin(q_1 + q_2), "short" for s_{12}, or S_{12} where a symbol has that letter.
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
        return self._printed("latex", group, angles, document)

    def text(self, group: str = "equations", angles: str = "long") -> str:
        """Return the equations in plain text, which `symdyn.scene.parse` reads back; the rest as for `latex`.

        >>> import symdyn
        >>> print(symdyn.equations(symdyn.example("pendulum")).text())
        m*l**2*q1_ddot + m*l*g*sin(q1) = tau1 - b*q1_dot
        """
        check_arguments(EquationsOfMotion.text, locals(), EmitError)
        return self._printed("text", group, angles)

    def _printed(self, format: str, *how: Any) -> str:
        if self.formulation == "lagrange":
            return equations_text(self.closed, format, *how)
        group, angles, document = (*how, False)[:3]
        return printed_text(self.scene, format, group, angles, document, self.formulation)

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
        from symdyn.emit.print.sympy_equations import sympy_equations  # with loops, which printing can do without

        check_arguments(EquationsOfMotion.sympy, locals(), EmitError)
        if self.formulation != "lagrange":
            raise EmitError(f"the equations of {self.formulation} are printed, by .latex(), .text() or printed_text")
        return sympy_equations(self.page, dynamic)

    def _sympy_(self) -> Any:
        return self.sympy()._sympy_()

    def subs(self, *given: Any, **by_name: Any) -> SympyEquations:
        """Return `.sympy()` with values in place of symbols; see `SympyEquations.subs`."""
        return self.sympy().subs(*given, **by_name)

    def solve_accelerations(self) -> tuple[Any, Any]:
        """Return accelerations and multipliers in SymPy; see `SympyEquations.solve_accelerations`."""
        return self.sympy().solve_accelerations()

    def state_space(self) -> tuple[Any, Any]:
        """Return x and f of ẋ = f in SymPy; see `SympyEquations.state_space`."""
        return self.sympy().state_space()

    def lambdify(self, values: Mapping[Any, Any] | None = None) -> Callable[[float, Any], Array]:
        """Return f(t, x) of ẋ = f for `solve_ivp`; see `SympyEquations.lambdify`."""
        return self.sympy().lambdify(values)


@checked(EmitError)
def equations(
    scene: SceneLike, formulation: str = "lagrange", values: Mapping[str, object] | None = None
) -> EquationsOfMotion:
    """Return the equations of motion of a scene: `.latex()`, `.text()`, `.sympy()`, `.state_space()`.

    A notebook shows them.

    Args:
        scene: a scene, a path or an open file.
        formulation: "lagrange"; or as "dalembert", "hamilton", "routh", "kane", "gibbs-appell", "udwadia-kalaba",
            "port-hamiltonian" and "contact" print them.
        values: of parameters, in place of whose names numbers stand, as with --bind in a shell; other names stay.

    Raises:
        SceneError: the file has faults, or a value that it cannot have.
        EmitError: there is no such formulation.

    >>> import symdyn
    >>> symdyn.equations(symdyn.example("pendulum")).sympy().M
    Matrix([[l**2*m]])
    """
    if formulation not in FORMULATIONS:
        raise EmitError(f"there is no formulation {quoted(formulation)}; {choice(formulation, FORMULATIONS)}")
    return EquationsOfMotion(scene_of(scene, values).in_numbers([*(values or ())]), formulation)
