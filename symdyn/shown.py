"""What a notebook asks an object for: every noun that a function returns is shown by what registers here."""

from __future__ import annotations

from collections.abc import Callable
from types import FunctionType
from typing import TYPE_CHECKING, Any

_BUNDLES: list[Callable[[object], dict[str, str]]] = []


def shown_by(bundle: Callable[[object], dict[str, str]]) -> None:
    """Take what returns the text of a noun by media type; it is above all nouns, and says so itself."""
    _BUNDLES[:] = [bundle]


INSTEAD: dict[str, dict[str, str]] = {
    "damp": {
        **{"eigenvalues": "it is poles", "mode_table": "it is damp()", "transfers": "it is transfer()"},
        **{"control": "it is to_control()", "pzmap": "plot() draws poles and zeros"},
        **dict.fromkeys(
            ("lsim", "initial", "initial_response", "forced_response", "response"),
            "python-control has it, of .to_control(); symdyn.simulate runs the mechanism itself",
        ),
        **dict.fromkeys(
            ("transmissibility", "freqresp", "frequency_response", "frequencyresponse", "evalfr"),
            "abs(lin.bode(output, input).response) has ratios, lin.transfer(output, input).at(s) a value",
        ),
        **{"dcgain": "lin.transfer(output, input).at(0) has it", "save": "lin.to_control() and lin.latex() have it"},
        **dict.fromkeys(("symbolic", "sympy", "subs"), "formulas has A, B, C and D in SymPy"),
        "info": "print(lin) shows it; poles, damp(), margins() and step().info() are numbers of it",
    },
    "closed_loop": {
        **dict.fromkeys(
            ("kr", "x0", "setpoint", "set_point", "reference"),
            "symdyn.Feedback(regulator, reference={...}) sets another point",
        ),
        **dict.fromkeys(("step", "impulse", "bode", "stable", "damp"), "its .closed_loop has them"),
    },
    "observer": dict.fromkeys(("K", "L"), "gains are those of its parts, .regulator.K and .observer.L"),
    "coordinates_of_joints": {
        "info": "symdyn info FILE in a shell has it; symdyn.equations(scene).text() its equations",
        **dict.fromkeys(
            ("save", "write", "dump", "to_toml", "to_urdf"), 'symdyn.scene.write_text(scene, "toml").text is its file'
        ),
        **dict.fromkeys(
            ("plot", "draw", "show", "animate"),
            "symdyn.picture(scene) draws it, symdyn.simulate(scene, until=...).plot() its motion",
        ),
        **dict.fromkeys(
            ("equations", "simulate", "linearize", "inverse"),
            "it is a function: symdyn.equations(scene), symdyn.simulate(scene, ...) and others",
        ),
        **dict.fromkeys(
            ("replace", "bind", "with_values", "subs", "set"),
            'simulate(scene, values={"NAME": 0.2}) and others take values; symdyn.scene.bind(scene, {...}) keeps them',
        ),
    },
    "held": {
        "info": "print(run), run.notes, run.events and run.columns tell of it",
        "reactions": 'columns have them, run["reaction_JOINT_fx"], where reactions=True is asked for',
        **{"sol": "run(0.5) has all columns at a time", "final": "run(run.t[-1]) has all columns at the end"},
        **dict.fromkeys(("y", "x"), 'run.q and run.qd, or columns by name, run["theta"]'),
    },
    "violation": {"u": 'its run has forces by name, run["F"]'},
    "formulation": {
        **{one: f"it is .sympy().{one}" for one in (*"MCcgGKP", "tau")},
        **dict.fromkeys(("mass_matrix", "forcing"), "it is one of .sympy(), such as M"),
        **dict.fromkeys(("save", "write"), 'pathlib.Path("FILE").write_text(equations.latex()) keeps it'),
    },
    "numerator": {"to_control": "a system has it, lin[output, input].to_control()"},
    "optima": dict.fromkeys(("t", "q", "animate", "film", "to_csv", "table"), "its .run has it, such as .run.t"),
    "solve_accelerations": {"forcing": "it is tau - c - g - k_E", "L": "Lagrange's function is K - P"},
    "not_identifiable": {
        **dict.fromkeys(("report", "plot", "to_html"), "symdyn.identification.report(identification) is its page"),
        **{"values": "as_dict() has them; .scene is the identified scene", "to_csv": "to_pandas().to_csv(FILE) does"},
    },
    "isprintable": dict.fromkeys(("save", "savefig", "write"), 'pathlib.Path("FILE").write_text(...) keeps it'),
}
"""What has what an attribute was asked for, by one that nouns have which are asked; for errors alone."""


class Suggesting:
    """A noun that says which of its attributes was meant by a name that is none, and how a method is called."""

    __slots__ = ()

    def __init_subclass__(cls, **words: Any) -> None:
        """Let its methods say how they are called where a call does not fit."""
        super().__init_subclass__(**words)
        for name, method in list(vars(cls).items()):
            if isinstance(method, FunctionType) and not name.startswith("_"):
                from symdyn.arguments import suggesting  # no noun is made where the package is only imported

                setattr(cls, name, suggesting(method))

    if not TYPE_CHECKING:  # else type checkers would take every name for an attribute

        def __getattr__(self, name: str) -> object:
            """Raise AttributeError; of a column or another name that brackets take, it says so."""
            kind = type(self)
            if name.startswith("_") or hasattr(kind, name) or name in getattr(kind, "__dataclass_fields__", ()):
                return object.__getattribute__(self, name)  # raises what it has raised before
            from symdyn.errors import suggestion  # an error's own

            keys = self.keys() if hasattr(kind, "keys") and not isinstance(self, str) else ()
            known = [one for one in dir(self) if not one.startswith("_")]
            told = next((one[name] for has, one in INSTEAD.items() if has in known and name in one), "")
            told = f'write ["{name}"]' if name in keys else told or suggestion(name, [*known, *keys])
            raise AttributeError(f"{kind.__name__} has no attribute {name!r}; {told}")


class Shown(Suggesting):
    """A noun that a notebook shows as a person wants to see it."""

    __slots__ = ()

    def _repr_mimebundle_(self, include: object = None, exclude: object = None) -> dict[str, str]:
        """Return what is shown, by media type: HTML, LaTeX; plain text is `repr`."""
        (bundle,) = _BUNDLES
        return bundle(self)


class BySympy:
    """A noun that is an expression to `sympy.sympify`, `sympy.latex` and `sympy.pprint`: what `_sympy_` returns."""

    __slots__ = ()

    def _latex(self, printer: Any) -> Any:
        return printer._print(self._sympy_())  # type: ignore[attr-defined]

    _pretty = _latex
