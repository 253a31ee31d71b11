"""A load: a wrench on a body."""

from __future__ import annotations

from typing import Literal

from symdyn.graph import Graph
from symdyn.scene.forces.attachments import AtBody
from symdyn.scene.forces.force_kind import ForceKind, Push
from symdyn.scene.values.entry import Entry, EntryReader, Three, entry
from symdyn.scene.values.joint import Load
from symdyn.scene.values.key import TIMED, Key, Stand, one_of
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import NULL, Vector, spell
from symdyn.spatial import Vec, Wrench


def _wrench(load: Load, graph: Graph) -> Wrench:
    return Wrench(_vector(load.force, graph), _vector(load.couple, graph))


def _vector(vector: Vector, graph: Graph) -> Vec:
    x, y, z = (entry.express(graph) for entry in vector)
    return (x, y, z)


def _check(load: Load, stand: Stand) -> None:
    if load.place.body == Scene.GROUND:
        stand.fault(f"acts on {Scene.GROUND}, which does not move; name a body")


def _law_words(load: Load) -> str:
    force, couple = (f"({', '.join(map(spell, vector))})" for vector in (load.force, load.couple))
    return f"force {force}, couple {couple}, axes of the {load.frame}"


LOAD = ForceKind(
    section="loads",
    noun=Load,
    letter="w",
    parts=(
        AtBody(),
        Key(
            "force",
            EntryReader.vector,
            NULL,
            silent=lambda load: load.force == NULL and load.couple != NULL,
            letters=("Fx", "Fy", "Fz"),
            unit="N",
            text="force of {}",
            names=TIMED,
        ),
        Key(
            "couple", EntryReader.vector, NULL, letters=("Cx", "Cy", "Cz"), unit="N m", text="couple of {}", names=TIMED
        ),
        one_of("frame", ("ground", "body"), "whose axes the components are along", "ground"),
    ),
    needs=("force", "couple"),
    missing="has neither force nor couple; write one, such as force = [0, 0, 10]",
    law=Push(_wrench),
    law_words=_law_words,
    words={"en": "load", "sk": "zaťaženie"},
    lost="a wrench, which acts in the equations",
    check=_check,
)


def load(
    name: str,
    *,
    body: str | None = None,
    at: Three | None = None,
    point: str | None = None,
    force: Three | None = None,
    couple: Three | None = None,
    frame: Literal["ground", "body"] | None = None,
) -> Entry:
    """Declare a wrench on a body.

    Args:
        name: of the load.
        body: that it acts on.
        at: the place in body coordinates, m; the origin when left out.
        point: that it acts at, in place of body and place.
        force: N, formulas in t, parameters, coordinates and velocities.
        couple: N m, the same.
        frame: "ground" or "body", whose axes the components are along; the ground's when left out.
    """
    return entry("loads", **locals())
