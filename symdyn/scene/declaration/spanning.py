"""A spanning tree of the joints: which of them carry bodies, which are cut and close loops, which are turned round.

Joints whose children are as many bodies, all hanging on ground, are a tree as they stand. Else the joints are sorted:
those that say what a cut joint cannot (a drive that is asked for, a rotor, damping, ...) come first, then those that
name or limit coordinates, few freedoms before many, those that a search breadth-first from ground meets before those
that close its rings, and declared order last; and each is kept unless it closes a loop with those before it (Kruskal
1956). A joint that then points towards ground is turned round, which leaves its coordinates what they were. A ball and
the like cannot be turned round, since their velocities are measured in the child; they are cut instead.

    pose of parent in child  =  tip⁻¹ · X(q)⁻¹ · origin⁻¹        X(q)⁻¹ is the same motion about the opposite axis
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence

from symdyn.arguments import argument
from symdyn.errors import listed, suggestion
from symdyn.frozen import dataclass, replace
from symdyn.scene.declaration.joint_table import acts, freedoms, joint_keys, loop_keys
from symdyn.scene.forces.force_kind import Pull
from symdyn.scene.forces.force_table import FORCES
from symdyn.scene.joints.joint_table import JOINTS
from symdyn.scene.values.entry import Entry, Faults, plain, show
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.model import Scene

KEPT = ("force", "forces", "motion", "mimic", "armature", "rotor", "damping", "locked", "drive", "drives")
"""What a joint that closes a loop cannot say; what else it says beside its place is not used, as its `coordinate`."""

NAMING = {"coordinate", "coordinates", "limits"}
ELSEWHERE = "take that from one joint of the loop; a spring or damper also acts between points, by from and to"


@dataclass(frozen=True)
class Span:
    """The joints of a scene as a tree and what closes loops."""

    joints: tuple[Entry, ...]  # those of the tree, each after the joint of its parent as far as they hang on ground
    cut: tuple[Entry, ...] = ()  # those that close loops, without the keys that only a joint of the tree has
    turned: frozenset[str] = frozenset()  # names of those of the tree that are declared from their child towards ground


@dataclass(frozen=True)
class _Edge:
    """A declared joint as an edge between two bodies."""

    entry: Entry
    parent: str
    child: str
    kind: str
    index: int

    def other(self, body: str) -> str:
        return self.child if body == self.parent else self.parent


def span(joints: Sequence[Entry], held: Sequence[str], cuts: Sequence[str] | None, faults: Faults) -> Span:
    """Return the spanning tree without the joints `cuts`, None to choose and note them; none that is `held` is cut."""
    edges = [_edge(entry, k) for k, entry in enumerate(joints)]
    unknown = [name for name in cuts or () if name not in {edge.entry.name for edge in edges}]
    for name in unknown:
        told = suggestion(name, [edge.entry.name for edge in edges])
        faults.add(argument("spanning_tree"), f'"{name}" is not a joint; {told}')
    strange = unknown or any(not edge.parent or not edge.child for edge in edges)  # reported where it stands
    if strange or (not cuts and _is_tree(edges)):
        return Span(tuple(edge.entry for edge in _parents_first(edges)))
    met = {Scene.GROUND, *(edge.other(body) for body, edge in _walk(edges, Scene.GROUND))}
    adrift = [edge for edge in edges if not {edge.parent, edge.child} & met]
    carried = {edge.child for edge in adrift if edge.parent != edge.child}
    if not cuts and adrift and len(carried) == len(adrift):  # no cut ties them to ground
        rest = span([edge.entry for edge in edges if edge not in adrift], held, cuts, faults)
        return replace(rest, joints=(*rest.joints, *(edge.entry for edge in adrift)))
    needed = {*held, *(name for edge in edges for name in _leaders(edge.entry))} - {""}
    return _cut(edges, set(cuts), needed, faults) if cuts else _chosen(edges, needed, faults)


def _edge(entry: Entry, index: int) -> _Edge:
    parent, child, kind = (entry.table.get(key) for key in ("parent", "child", "type"))
    texts = [one if isinstance(one, str) else "" for one in (parent, child, kind)]
    return _Edge(entry, texts[0], texts[1], texts[2], index)


def _leaders(entry: Entry) -> list[str]:
    """Return the joints that a joint follows."""
    mimic = entry.table.get("mimic")
    if not isinstance(mimic, Mapping):
        return []
    ratios = mimic.get("ratios")
    return [str(mimic.get("joint", "")), *(map(str, ratios) if isinstance(ratios, Mapping) else ())]


def _is_tree(edges: Sequence[_Edge]) -> bool:
    """Tell whether every body is the child of one joint and all hang on ground, as declared."""
    met = list(_walk(edges, Scene.GROUND))
    return len(met) == len(edges) and all(edge.parent == body for body, edge in met)


def _parents_first(edges: Sequence[_Edge]) -> list[_Edge]:
    """Return the joints in declared order, each after the joint that carries its parent; cycles stay as they are."""
    carrier = {edge.child: edge for edge in reversed(edges)}
    placed: dict[int, _Edge] = {}
    for edge in edges:
        path: dict[int, _Edge] = {}
        step: _Edge | None = edge
        while step is not None and step.index not in placed and step.index not in path:
            path[step.index] = step
            step = carrier.get(step.parent)
        placed.update(reversed(path.items()))
    return list(placed.values())


def _chosen(edges: Sequence[_Edge], held: set[str], faults: Faults) -> Span:
    """Return the tree that the module's rules choose."""
    met = {edge.index: k for k, (_, edge) in enumerate(_walk(edges, Scene.GROUND))}
    order = sorted(
        edges,
        key=lambda e: (
            not _kept(e.entry, held),
            NAMING.isdisjoint(_lost(e.entry)),
            freedoms(e.entry),
            met.get(e.index, len(met)),
        ),
    )
    banned: set[int] = set()
    while True:
        tree = _forest([*(e for e in order if e.index not in banned), *(e for e in order if e.index in banned)])
        back = _backwards(tree)
        wrong = [e for e in tree if e.index in back and not turnable(e.kind) and e.index not in banned]
        if not wrong:
            break
        banned.add(wrong[-1].index)
    for edge in tree:
        if edge.index in back and not turnable(edge.kind):
            ends = f'from "{edge.parent}" to "{edge.child}"'
            what = f"a {edge.kind} joint {ends} points towards ground and cannot be turned round"
            faults.add(edge.entry.where, f"{what}; swap parent and child")
    for edge in edges:
        if edge in tree or edge.parent == edge.child:
            continue
        way, told = _other_cut(edges, tree, edge, held), "closes a loop and is cut"
        if keys := _kept(edge.entry, held):
            faults.add(edge.entry.where, f"{told}, but a cut joint has no {listed(keys)}; {way or ELSEWHERE}")
        else:
            told += f": it has no coordinates{_unused(edge.entry)}"
            faults.note(edge.entry.where, "; ".join(filter(None, (told, way))))
    return _span(edges, tree, back, faults)


def _cut(edges: Sequence[_Edge], cuts: set[str], held: set[str], faults: Faults) -> Span:
    """Return the tree that is left without some joints."""
    left = [edge for edge in edges if edge.entry.name not in cuts]
    tree = _forest(left)
    asked = argument("spanning_tree", sorted(cuts))
    for edge in left:
        if edge not in tree:
            ring = " -> ".join(_ring(tree, edge))
            faults.add("", f"{asked} leaves a loop: {ring}; cut one more of its joints")
    met = {Scene.GROUND} | {edge.child for edge in tree} | {edge.parent for edge in tree}
    for edge in edges:
        if edge.entry.name not in cuts:
            continue
        if unused := _unused(edge.entry):
            faults.note(edge.entry.where, f"is cut and has no coordinates{unused}")
        if keys := _kept(edge.entry, held):
            way = _other_cut(edges, tree, edge, held) or ELSEWHERE
            faults.add(edge.entry.where, f"is to be cut, but a cut joint has no {listed(keys)}; {way}")
        for body in (edge.parent, edge.child):
            if body not in met:
                faults.add("", f"{asked} leaves nothing that carries {body}; cut others")
    back = _backwards(tree)
    for edge in tree:
        if edge.index in back and not turnable(edge.kind):
            why = f"a {edge.kind} joint cannot be turned round, as {argument('spanning_tree')} would need it"
            faults.add(edge.entry.where, f"{why}; cut it, or swap its parent and child")
    return _span(edges, tree, back, faults)


def _other_cut(edges: Sequence[_Edge], tree: Sequence[_Edge], closing: _Edge, held: Container[str]) -> str:
    """Return what cuts another joint of the loop that one closes: the one that loses least; "" where none can be."""
    ring = _ring(tree, closing)
    free = [edge for edge in reversed(tree) if edge.entry.name in ring and not _kept(edge.entry, held)]
    for other in sorted(free, key=lambda e: (not NAMING.isdisjoint(_lost(e.entry)), len(_lost(e.entry)))):
        rest = [closing, *(edge for edge in tree if edge is not other)]
        if all(turnable(edge.kind) for edge in rest if edge.index in _backwards(rest)):
            cuts = [edge.entry.name for edge in edges if edge not in rest]
            return f"{argument('spanning_tree', cuts)} cuts another"
    return ""


def _kept(entry: Entry, held: Container[str]) -> list[str]:
    """Return what a joint has that one which closes a loop cannot: by keys, and by what names it."""
    pulls = ", ".join(kind.words["en"] for kind in FORCES.values() if isinstance(kind.law, Pull))
    keys = [key for key in KEPT if _says(entry.table.get(key))] + ["friction"] * acts(entry.table.get("friction"))
    return keys + [f"{pulls} or mimic at it"] * (entry.name in held)


def _lost(entry: Entry) -> list[str]:
    """Return the keys by which a joint says what one of the tree alone has."""
    return [key for key, raw in entry.table.items() if key in joint_keys() and key not in loop_keys() and _says(raw)]


def _unused(entry: Entry) -> str:
    """Return what is told of what a cut joint says in vain."""
    lost = _lost(entry)
    return f", and its {listed(lost)} {'is' if len(lost) == 1 else 'are'} not used" if lost else ""


def _says(raw: object) -> bool:
    """Tell whether a raw value is given: drive = false, or [false, false], says nothing."""
    raw = plain(raw)
    return any(map(_says, raw)) if isinstance(raw, (list, tuple)) else raw is not None and raw is not False


def _walk(edges: Sequence[_Edge], start: str) -> Iterator[tuple[str, _Edge]]:
    """Yield the joints by which a search breadth-first meets bodies, each with the body that it comes from."""
    at: dict[str, list[_Edge]] = {}
    for edge in edges:
        for body in (edge.parent, edge.child):
            at.setdefault(body, []).append(edge)
    seen, queue = {start}, [start]
    for body in queue:
        for edge in at.get(body, ()):
            if edge.other(body) not in seen:
                seen.add(edge.other(body))
                queue.append(edge.other(body))
                yield body, edge


def _forest(order: Sequence[_Edge]) -> list[_Edge]:
    """Return the joints that close no loop with those before them, in declared order."""
    root: dict[str, str] = {}

    def find(body: str) -> str:
        while root.get(body, body) != body:
            body = root[body]
        return body

    kept = []
    for edge in order:
        a, b = find(edge.parent), find(edge.child)
        if a != b:
            root[a] = b
            kept.append(edge)
    return sorted(kept, key=lambda edge: edge.index)


def _backwards(tree: Sequence[_Edge]) -> set[int]:
    """Return the joints of a tree whose child is the end nearer to ground."""
    return {edge.index for body, edge in _walk(tree, Scene.GROUND) if edge.child == body}


def _ring(tree: Sequence[_Edge], closing: _Edge) -> list[str]:
    """Return the joints of the loop that one more joint closes in a tree, that joint last."""
    path: dict[str, list[str]] = {closing.parent: []}
    for body, edge in _walk(tree, closing.parent):
        path[edge.other(body)] = [*path[body], edge.entry.name]
    return [*path.get(closing.child, []), closing.entry.name]


def _span(edges: Sequence[_Edge], tree: Sequence[_Edge], back: set[int], faults: Faults) -> Span:
    for edge in tree:
        if edge.index in back:
            way = f"{show(edge.child)} carries {show(edge.parent)}; its coordinates stay what they are"
            faults.note(edge.entry.where, f"is turned round: {way}")
    directed = [replace(e, parent=e.child, child=e.parent) if e.index in back else e for e in tree]
    inside = {edge.index for edge in tree}
    cut = []
    for edge in edges:
        if edge.index not in inside:
            told = edge.entry.table  # what is no key is reported by its reader
            table = {key: raw for key, raw in told.items() if key in loop_keys() or key not in joint_keys()}
            cut.append(replace(edge.entry, table=table))
    names = frozenset(edge.entry.name for edge in tree if edge.index in back)
    return Span(tuple(edge.entry for edge in _parents_first(directed)), tuple(cut), names)


def turnable(kind: str) -> bool:
    """Tell whether joints of a type can be turned round; a type that is none stands for a revolute joint."""
    return kind not in JOINTS or JOINTS[kind].turned is not None


def turned(joint: Joint) -> Joint:
    """Return a joint from its child to its parent, coordinates and velocities unchanged; its type must be turnable.

    Of one that is not, a fault of the scene by then, only the frames are swapped.
    """
    frames = replace(
        joint, parent=joint.child, child=joint.parent, origin=joint.tip.inverse(), tip=joint.origin.inverse()
    )
    turn = JOINTS[joint.type].turned
    return turn(frames) if turn else frames
