"""The one door to walkthroughs: a scene and choices in, a document out."""

from __future__ import annotations

from symdyn.errors import EmitError
from symdyn.scene import Scene
from symdyn.teach.dalembert_road import STAGES, dalembert_walkthrough
from symdyn.teach.document import Document
from symdyn.teach.lagrange_road import UNTIL, lagrange_walkthrough
from symdyn.teach.languages import LANGUAGES

ROADS = {"lagrange": UNTIL, "dalembert": STAGES}
"""The parts of each road that a walkthrough may end with."""
DETAILS = ("brief", "full")


def walkthrough(
    scene: Scene, language: str = "en", detail: str = "full", until: str = "", road: str = "lagrange"
) -> Document:
    """Return the derivation of a scene's equations as a document.

    Args:
        scene: by Lagrange's road an open chain or tree with a closed form; by D'Alembert's any mechanism.
        language: "en" or "sk".
        detail: "full", or "brief" without the steps that a second reading needs.
        until: the last part, "" for all: on Lagrange's road "energies", "lagrangian", "equations", "coefficients" or
            "numbers", on D'Alembert's "count", "bodies", "reactions" or "roads".
        road: "lagrange" (5.21)-(5.23) or "dalembert" (5.1)-(5.20).

    Raises:
        EmitError: an unknown choice, or a scene that is too large to be read.
        DerivationError: the scene has no closed form, or constraints that Lagrange's road does not take.
    """
    for name, value, known in (("language", language, LANGUAGES), ("detail", detail, DETAILS), ("road", road, ROADS)):
        if value not in known:
            raise EmitError(f"{name} {value!r} is not known; give one of {', '.join(known)}")
    until = until or ROADS[road][-1]
    if until not in ROADS[road]:
        raise EmitError(f"until {until!r} is no part of the road {road}; give one of {', '.join(ROADS[road])}")
    make = dalembert_walkthrough if road == "dalembert" else lagrange_walkthrough
    document = make(scene, language, until)
    return document.brief() if detail == "brief" else document
