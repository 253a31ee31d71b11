"""Joints hang every body on ground, each on one joint; what closes a loop connects two bodies."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from symdyn.scene.checks.draft import Draft
from symdyn.scene.joints.joint_table import JOINTS
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.model import Scene
from symdyn.scene.values.names import listed, suggestion
from symdyn.scene.values.table import Faults


def check_tree(draft: Draft, faults: Faults) -> None:
    """Report ends that are no bodies, bodies that hang on nothing or on themselves, and a scene that stands still."""
    scene = draft.scene
    bodies = {body.name: None for body in scene.bodies}
    ends = {**bodies, Scene.GROUND: None}
    carrier: dict[str, Joint] = {}
    for where, joint in zip(draft.where["joints"], scene.joints, strict=True):
        _ends(where, joint, bodies, ends, faults)
        if joint.child == Scene.GROUND:
            faults.add(where, f'child = "{Scene.GROUND}" cannot move; swap parent and child')
        elif joint.child in carrier:
            faults.add(where, f'child = "{joint.child}" already hangs on the joint {carrier[joint.child].name}')
        elif joint.child:
            carrier[joint.child] = joint
    joined = {body for joint in (*scene.joints, *scene.loops) for body in (joint.parent, joint.child)}
    for where, body in zip(draft.where["bodies"], scene.bodies, strict=True):
        if body.name in carrier or body.name == Scene.GROUND:
            continue
        if body.name in joined:
            lost = f"no joint leads from {Scene.GROUND} to the body{_company(scene, body.name)}"
            faults.add(where, f'{lost}; add one with child = "{body.name}"')
        else:
            faults.add(where, f'the body hangs on no joint; add one with child = "{body.name}"')
    for where, point in zip(draft.where["points"], scene.points, strict=True):
        _named(where, "body", point.body, ends, faults)
    _cycles(draft, carrier, faults)
    if not any(joint.moves for joint in scene.joints):
        faults.add("", "nothing moves; declare at least one body and a revolute or prismatic joint that carries it")


def _ends(where: str, joint: Joint, bodies: Mapping[str, None], ends: Mapping[str, None], faults: Faults) -> None:
    _named(where, "parent", joint.parent, ends, faults)
    if joint.child != Scene.GROUND:  # reported by itself
        _named(where, "child", joint.child, bodies, faults)


def _named(where: str, key: str, name: str, bodies: Collection[str], faults: Faults) -> None:
    faults.nameless(where, key, name)
    if name and name not in bodies:
        faults.add(where, f'{key} = "{name}" is not a body; {suggestion(name, bodies)}')


def _company(scene: Scene, name: str) -> str:
    """Return which bodies float together with one, and whether their joints form a ring, "" if there are none."""
    joints = [joint for joint in (*scene.joints, *scene.loops) if joint.parent != joint.child]
    group, stack = {name: None}, [name]
    while stack:
        here = stack.pop()
        ends = [(joint.parent, joint.child) for joint in joints if here in (joint.parent, joint.child)]
        stack += [x for pair in ends for x in pair if x not in group]
        group.update(dict.fromkeys(stack))
    others = [x for x in group if x != name]
    if not others or Scene.GROUND in group:
        return ""
    ring = [joint.name for joint in joints if joint.parent in group and joint.child in group]
    shape = f" in a ring ({listed(ring)})" if len(ring) >= len(group) else ""
    return f" or to {listed(others)}, which {'hangs' if len(others) == 1 else 'hang'} together with it{shape}"


def _cycles(draft: Draft, carrier: Mapping[str, Joint], faults: Faults) -> None:
    settled: set[str] = set()
    for where, joint in zip(draft.where["joints"], draft.scene.joints, strict=True):
        path: dict[str, None] = {}
        name = joint.child
        while name in carrier and name not in settled and name not in path:
            path[name] = None
            name = carrier[name].parent
        if name in path:
            ring = list(path)[list(path).index(name) :]
            shown = " -> ".join([*ring[:10], *(["..."] if len(ring) > 10 else []), name])
            faults.add(
                where, f"its body hangs on itself: {shown} (child -> parent); let one of them hang on {Scene.GROUND}"
            )
        settled.update(path)


def check_loops(draft: Draft, faults: Faults) -> None:
    """Report joints that close loops between bodies that are one, or that say what they forbid in no formula."""
    scene = draft.scene
    bodies = {body.name: None for body in scene.bodies}
    ends, rigid = {**bodies, Scene.GROUND: None}, _rigid(scene.joints)
    for where, joint in zip(draft.where["loops"], scene.loops, strict=True):
        _ends(where, joint, bodies, ends, faults)
        if joint.parent == joint.child:
            faults.add(where, f'joins "{joint.parent}" with itself; a loop is closed between two bodies')
        elif rigid.get(joint.parent, joint.parent) == rigid.get(joint.child, joint.child):
            both = f'"{joint.parent}" and "{joint.child}"'
            faults.add(where, f"joins {both}, which fixed joints make one body; close the loop between two bodies")
        kind = JOINTS[joint.type]
        if kind.forbids is None:
            advice = "since what it forbids has no formula; cut another joint"
            faults.add(where, f"a {joint.type} joint closes no loop, {advice}")
        elif not kind.class_t(joint):
            faults.add(where, f"a {joint.type} joint forbids nothing and closes no loop; leave it out")


def _rigid(joints: tuple[Joint, ...]) -> dict[str, str]:
    """Return for every body that hangs on fixed joints the one at their beginning; parents come first."""
    root: dict[str, str] = {}
    for joint in joints:
        if not JOINTS[joint.type].velocities(joint):
            root[joint.child] = root.get(joint.parent, joint.parent)
    return root
