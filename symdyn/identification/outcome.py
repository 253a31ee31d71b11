"""What is written of an identification: a page, and the identified scene as text."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.errors import IdentifyError
from symdyn.identification.identification import Identification
from symdyn.identification.report import report
from symdyn.identification.scene import Identified, identified
from symdyn.identification.written_scene import written
from symdyn.scene import Written
from symdyn.unlocked import cached_property


@dataclass(frozen=True)
class Outcome:
    """What is to be written about.

    Attributes:
        identification: the identification.
        total_mass: of all bodies, kg; None leaves it to the data.
        command: that made it.
    """

    identification: Identification
    total_mass: float | None
    command: str

    @cached_property
    def made(self) -> Identified:
        """The identified scene."""
        return identified(self.identification, self.total_mass)

    def page(self) -> tuple[str, str]:
        """Return the page, and why it has no identified scene; "" where it has one."""
        try:
            made, why = self.made, ""
        except IdentifyError as fault:  # the page tells what was identified all the same
            made, why = None, str(fault)
        return report(self.identification, made, self.command), why

    def text(self, format: str) -> Written:
        """Return the identified scene, and what the format cannot hold; errors as of `identified`."""
        return written(self.made, format, [f"identified by: {self.command}"] if self.command else [])
