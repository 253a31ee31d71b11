"""Linear systems with what they came from: at a point, at all positions of rest, or along the run of a file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from symdyn.draw import Reel
from symdyn.errors import LinearizeError
from symdyn.linear.bode import Bode, bode
from symdyn.linear.equilibrium import equilibria
from symdyn.linear.formulas import Symbolic
from symdyn.linear.linearization import Linearization
from symdyn.linear.linearized import along, search_report
from symdyn.linear.modes import MODE_PERIOD, Mode, animate_modes
from symdyn.linear.prepared import Prepared, prepared
from symdyn.linear.reach import shown
from symdyn.linear.regulator import Observer, Regulator, kalman, lqr, read_weights
from symdyn.linear.report import as_json, latex, text
from symdyn.linear.run_files import read_run
from symdyn.linear.sampled import Sampled, along_a_step, sampled
from symdyn.linear.steady import settled
from symdyn.linear.symbolic import symbolic
from symdyn.rounding import in_digits
from symdyn.simulation import Problem


@dataclass(frozen=True)
class System:
    """A linear system and what it came from.

    Attributes:
        prepared: what was linearised; linear systems at other places, and values, are asked of it.
        linearization: the system.
        formulas: the same in formulas, where it is small.
    """

    prepared: Prepared
    linearization: Linearization
    formulas: Symbolic | None

    def text(self) -> str:
        """Return it as text: where, states, matrices, modes, stability."""
        return text(self.linearization, self.formulas)

    def latex(self) -> str:
        """Return it in LaTeX: formulas where there are some, else numbers."""
        return latex(self.linearization, self.formulas)

    def as_json(self) -> dict[str, Any]:
        """Return it for JSON, all digits."""
        return as_json(self.linearization, self.formulas)

    def bode(self, hertz: str | None = None) -> Bode:
        """Return the frequency responses; `hertz` and errors as of `bode`."""
        return bode(self.linearization, hertz)

    def sampled(self, period: float) -> tuple[Sampled, Sampled]:
        """Return the system between samples, exactly and along a step; errors as of `sampled` and `along_a_step`."""
        return sampled(self.linearization, period), along_a_step(self.prepared, self.linearization, period)

    def lqr(self, weights: Sequence[str], period: float | None = None) -> Regulator:
        """Return the regulator of weights that --lqr says; errors as of `read_weights` and `lqr`."""
        given = read_weights("--lqr", weights, ("Q", "R"))
        return lqr(self.linearization, given.get("Q"), given.get("R"), period)

    def kalman(self, variances: Sequence[str], period: float | None = None) -> Observer:
        """Return the gain of the filter of variances that --kalman says; errors as of `read_weights` and `kalman`."""
        given = read_weights("--kalman", variances, ("W", "V"))
        return kalman(self.linearization, given.get("W"), given.get("V"), period)

    def animate(self, path: Path, reel: Reel, note: Callable[[str], None]) -> list[tuple[Path, Mode, str]]:
        """Write every mode as a film, and return which is where, in words too; errors as of `animate_modes`."""
        made = animate_modes(self.linearization, path, reel, note)
        return [(where, mode, _words(mode)) for where, mode in made]

    @classmethod
    def find(
        cls,
        problem: Problem,
        where: Path | str,
        outputs: Sequence[str] = (),
        independent: Sequence[str] = (),
        anywhere: bool = False,
    ) -> tuple[list[System], Sequence[str]]:
        """Return the linear systems of a scene, and what is said of how they were found.

        `where` is a file of a run, for a system at every sample; "rest" for all positions of rest; "start" for where
        the problem starts. Other arguments as of `linearize`.

        Raises:
            LinearizeError: as of `linearize`; no position of rest, or a file that is no run of the scene.
        """
        asked = prepared(problem, outputs, independent)
        if isinstance(where, Path):
            return [cls(asked, one, None) for one in along(asked, read_run(problem.scene, where))], ()
        if where != "rest":
            start = problem.initial
            found = settled(asked, asked.at(start.q, start.u, notes=start.notes), anywhere)
            return [cls(asked, found, symbolic(asked, found))], ()
        places = equilibria(asked)
        notes = search_report(places)
        if not places.systems:
            way = "" if places.crossings or places.locked else "; give forces that hold it, as in --forces NAME=FORMULA"
            raise LinearizeError([f"{problem.scene.name}: {notes[0]}{way}", *notes[1:]])
        return [cls(asked, one, symbolic(asked, one)) for one in places.systems], notes


def _words(mode: Mode) -> str:
    turns = f", {in_digits(mode.frequency, 6)} Hz, a round in {MODE_PERIOD:g} s" if mode.oscillates else ""
    return f"the mode {shown(mode.value)} 1/s{turns}"
