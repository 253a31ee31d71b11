"""What a student needs who sees no derivation: joints and masses with all coordinates zero, in axes of the ground."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symdyn.algebra import Form
from symdyn.dynamics.mechanism import State, body_placements, vector
from symdyn.graph import Expr, Graph, substitute
from symdyn.scene import Scene
from symdyn.spatial import Mat
from symdyn.table import Table
from symdyn.teach.document import Document, Step, Words
from symdyn.teach.languages import fill, language_of
from symdyn.teach.masses import Mass, masses
from symdyn.teach.practice.derived import shortest

ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Of an inertia: xx, yy, zz, xy, xz, yz."""


def with_given(document: Document) -> Document:
    """Return the document with a step at the end of its first section that says where everything is at zero.

    A scene with quaternions, which are never all zero, is returned as it is.
    """
    if any(joint.velocities for joint in document.scene.joints):
        return document
    first, *others = document.sections
    shown = replace(first, steps=(*first.steps, _given(document.scene, document.language)))
    return replace(document, sections=(shown, *others))


def _given(scene: Scene, language: str) -> Step:
    texts, graph = language_of(language).lesson, Graph()
    for parameter in scene.parameters:  # first, which is the order that forms print
        graph.symbol(parameter.name)
    state = State.of(scene, graph)
    zero = dict.fromkeys(state.q, graph.zero)
    placed = body_placements(scene, graph)

    def row(nodes: Sequence[Expr]) -> Words:
        """Return numbers at zero in brackets."""
        forms: list[Form] = [shortest(x, scene, state) or Form.of(x) for x in substitute(list(nodes), zero)]
        parts = [part for form in forms for part in (", ", form)]
        return Words(("(", *parts[1:], ")"))

    joints = []
    for joint in (*scene.joints, *scene.loops):
        T = placed[joint.parent] @ joint.origin.transform(graph)
        axis = row(T.R @ vector(joint.axis, graph)) if "axis" in dict(joint.shape) else Words(())
        joints.append((Words((joint.name,)), row(T.p), axis))
    bodies = []
    for mass in masses(scene, graph, placed):
        at = row(mass.place)
        if mass.h is not None:
            at = Words(fill(texts["given.moment"], {"place": at, "moment": row(mass.h)}))
        m = Words((Form.of(mass.m),))
        inertia = row(_turned(mass, placed[mass.body.name].R, graph)) if mass.spins else Words(("0",))
        bodies.append((Words((f"{mass.tag} {mass.body.name}",)), m, at, inertia))
    heads = [[Words((texts[key],)) for key in keys] for keys in (
        ("table.joint", "given.through", "given.axis"), ("given.body", "given.mass", "given.at", "given.inertia"),
    )]  # fmt: skip
    tables = (Table(tuple(heads[0]), tuple(joints)), Table(tuple(heads[1]), tuple(bodies)))
    reason = texts["given.closed" if scene.loops else "given.reason"]
    return Step("given", Words((texts["given"],)), tables, Words((reason,)))


def _turned(mass: Mass, R: Mat, graph: Graph) -> list[Expr]:
    """Return the entries of an inertia along the axes of the ground, R I Rᵀ."""
    columns = [R @ (mass.inertia @ (R.T @ e)) for e in Mat.identity(graph)]
    return [columns[j][i] for i, j in ENTRIES]
