"""What the figure of a page shows while a step of Lagrange's lesson is read, by what the key of the step begins with.

A step that is not listed shows what the one before it showed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from symdyn.teach.document import Section, Step
from symdyn.teach.masses import Mass

SHOWS: Mapping[str, tuple[str, ...]] = {
    "scene": ("frames",),
    "coordinates": ("angles",),
    "acting": ("forces",),
    "lengths": ("forces",),
    "principle:forces": ("forces",),
    "rotation": ("frames", "angles"),
    "position": ("places",),
    "velocity": ("velocities",),
    "turning": ("frames", "velocities"),
    "square": ("velocities",),
    "spin": ("velocities",),
    "offset": ("velocities",),
    "kinetic": ("velocities", "energies"),
    "potential": ("places", "weights"),
    "springs": ("forces", "energies"),
    "energies": ("energies",),
    "lagrangian": ("energies",),
    "momentum": ("momenta",),
    "rate": ("momenta", "accelerations"),
    "slope": ("weights", "forces"),
    "equation": ("inertia", "weights", "forces"),
    "coefficients:k_z": ("accelerations", "inertia"),
    "coefficients:k_C": ("coriolis",),
    "coefficients:k_D": ("centrifugal",),
    "coefficients:k_G": ("weights",),
    "coefficients:k_E": ("forces",),
    "meaning:k_z": ("accelerations", "inertia"),
    "meaning:k_C": ("coriolis",),
    "meaning:k_D": ("centrifugal",),
    "meaning:k_G": ("weights",),
    "state": ("angles", "velocities", "accelerations"),
    "torque": ("inertia", "weights", "forces"),
    "power": ("energies", "plots"),
}
"""Words of `symdyn.teach.interactive.shown`; of two beginnings the longer one counts."""

OF_A_MASS = ("position", "velocity", "turning", "square", "spin", "offset", "kinetic", "potential")
"""Steps whose key ends with the index of a mass: the figure points at its body."""


def with_figures(section: Section, result: list[Mass]) -> Section:
    """Return a section whose steps say what the figure shows, those that say it themselves as they are."""
    bodies = {mass.tag: mass.body.name for mass in result}
    return replace(section, steps=tuple(step if step.show else _shown(step, bodies) for step in section.steps))


def _shown(step: Step, bodies: Mapping[str, str]) -> Step:
    kind, _, of = step.key.partition(":")
    known = [key for key in SHOWS if step.key == key or step.key.startswith((f"{key}:", f"{key},"))]
    words = SHOWS[max(known, key=len)] if known else ()
    pointed = (f"body:{bodies[of]}",) if kind in OF_A_MASS and of in bodies else ()
    return replace(step, show=(*words, *pointed))
