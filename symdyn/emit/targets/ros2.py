"""The ROS 2 target: a package of ament around our C, with a plugin for dynamics and one for kinematics.

    Dynamics      inverse_dynamics_solver::InverseDynamicsSolver: H(q) ddq + C(q, dq) dq + f(dq) + g(q) = tau
    Kinematics    kinematics_interface::KinematicsInterface, 2.0 or later: poses and Jacobians of links, by name

The interfaces know joints of one coordinate each, and forces that are of the four kinds above: what a scene has beyond
that is refused. Friction is what joints say of damping and of dry friction; it depends on no position, and is found by
inverse dynamics at zero. The chain of a link, by which its vectors are as long as KDL's, are the columns of its
Jacobian that are not identically zero.

Reference: https://github.com/unisa-acg/inverse-dynamics-solver; https://control.ros.org, kinematics_interface 2.4.
"""

from __future__ import annotations

import re
from dataclasses import asdict
from typing import Any

from symdyn.arguments import argument
from symdyn.emit.code.identifiers import stem
from symdyn.emit.code.target import Contents, Draft, Sources, Target
from symdyn.emit.code.worked_example import worked_example
from symdyn.emit.render import in_comment, in_markdown, in_xml, render
from symdyn.emit.targets.c.c_and_cpp import BUILD, C
from symdyn.errors import EmitError, listed
from symdyn.program import Program, Routine
from symdyn.scene import Quantity, Scene

CALLS = {
    "mass_matrix": "dynamics.getInertiaMatrix(q)",
    "velocity_forces": "dynamics.getCoriolisVector(q, qd)",
    "gravity_forces": "dynamics.getGravityVector(q)",
    "inverse_dynamics": "dynamics.getTorques(q, qd, qdd) + dynamics.getFrictionVector(qd)",
}
"""Functions that the plugin for dynamics is made of, and what comes out of it as they do."""

POSE, JACOBIAN = "pose", "jacobian"

PLUGINS = {
    "Dynamics": "inverse_dynamics_solver::InverseDynamicsSolver",
    "Kinematics": "kinematics_interface::KinematicsInterface",
}


def needed(scene: Scene, _: str = "") -> tuple[str, ...]:
    """Return the functions that the package of a scene is made of.

    Raises:
        EmitError: the scene has what the interfaces know nothing of.
    """
    several = [joint.name for joint in scene.moving if not joint.coordinate]
    led = [joint.name for joint in scene.joints if joint.motion is not None]
    acting = [one.name for one in scene.elements] + [
        joint.name for joint in scene.joints if any(x != Quantity.ZERO for x in joint.forces)
    ]
    strange = {
        "closed loops": [joint.name for joint in scene.loops],
        "joints that have several coordinates": several,
        "motions that are prescribed": led,
        "forces beside gravity, damping and friction of joints": acting,
        "inputs": [one.name for one in scene.inputs],
        "states of one's own": [one.name for one in scene.states],
    }
    told = [f"{what} ({listed(names)})" for what, names in strange.items() if names]
    if told:
        raise EmitError(
            f"{scene.name}: the interfaces of ROS 2 know nothing of {listed(told)}; take them out, or generate target "
            f"{C.name} and call it in a node of your own"
        )
    if not scene.moving:
        raise EmitError(f"{scene.name}: nothing moves: no joint has a coordinate")
    return (*CALLS, *(f"{kind}:{name}" for name in frames_of(scene) for kind in (POSE, JACOBIAN)))


def frames_of(scene: Scene) -> tuple[str, ...]:
    """Return the names of links and points."""
    return tuple(dict.fromkeys([*(one.name for one in scene.bodies), *(one.name for one in scene.points)]))


def package_of(scene: Scene) -> str:
    """Return the package's name, in small letters and single strokes, as ROS has them (REP 144)."""
    return re.sub("_+", "_", f"symdyn_{stem(scene.name).lower()}").rstrip("_")


def _write(draft: Draft) -> dict[str, Contents]:
    """Return the sources and what describes the plugins."""
    scene = draft.program.scene
    routines = [one.function for one in draft.program.routines]
    free = [str(x.value) for f in routines for one in f.arguments if one.name == Program.PARAMS for x in one.symbols]
    if free:
        names = dict.fromkeys(free, 1)
        raise EmitError(f"{scene.name}: {listed(names)} without a value; give {argument('values', names)}")
    values = _values(scene) | {"scene": in_comment(scene.name, ""), **_calls(draft)}
    code = C.write(C.draft(draft.program, draft.real, draft.page.command))
    sources = {name: render(f"ros2/{name}.jinja", values) for name in ("plugins.hpp", "dynamics.cpp", "kinematics.cpp")}
    described = {
        f"{name.lower()}.xml": render(
            "ros2/plugin.xml.jinja", values | {"name": name, "what": name, "base": base, "scene": in_xml(scene.name)}
        )
        for name, base in PLUGINS.items()
    }
    return {f"src/{name}": text for name, text in {**code, **sources}.items()} | described


def _values(scene: Scene) -> dict[str, Any]:
    return {
        "package": package_of(scene),
        "stem": stem(scene.name),
        "joints": [joint.name for joint in scene.moving],
        "friction": any(one.damping != Quantity.ZERO or one.dry is not None for one in scene.joints),
    }


def _calls(draft: Draft) -> dict[str, Any]:
    """Return the names of functions of C, and of each frame its own and the joints that move it."""
    pairs = zip(draft.program.routines, draft.page.functions, strict=True)
    there = {one.function.request or one.function.name: (one, text.name) for one, text in pairs}
    frames = [
        {
            "name": name,
            "pose": there[f"{POSE}:{name}"][1],
            "jacobian": there[f"{JACOBIAN}:{name}"][1],
            "chain": _chain(there[f"{JACOBIAN}:{name}"][0]),
        }
        for name in frames_of(draft.program.scene)
    ]
    return {"calls": {name: there[name][1] for name in CALLS}, "frames": frames}


def _chain(jacobian: Routine) -> list[int]:
    """Return the columns that are not zero everywhere."""
    entries, count = jacobian.function.entries, jacobian.function.shape[1]
    return [k for k in range(count) if not all(one.is_zero for one in entries[k::count])]


def _beside(sources: Sources) -> dict[str, str]:
    """Return what builds, describes and tests the package; each is plain of what a scene says but for its name."""
    scene = sources.program.scene
    made, known = worked_example(sources), _values(scene)
    requests = {
        name: one.function.request or one.function.name
        for name, one in zip(sources.functions, sources.program.routines, strict=True)
    }
    called = []
    for one in made.called:
        kind, _, link = requests[one.name].partition(":")
        called.append({**asdict(one), "link": link, "pose": kind == POSE, "code": CALLS.get(kind, "")})
    values = known | {
        "scene": in_xml(scene.name),
        "title": in_markdown(in_xml(scene.name)),
        "frames": frames_of(scene),
        "follow": [one.name for one in scene.joints if one.coupling is not None],
        "given": made.given,
        "called": called,
        "left_out": made.left_out,
        "n": len(known["joints"]),
    }
    places = {"package.xml": "package.xml", BUILD: BUILD, "README.md": "README.md", "test/numbers.cpp": "numbers.cpp"}
    return {place: render(f"ros2/{template}.jinja", values) for place, template in places.items()}


ROS2 = Target(
    name="ros2",
    title="ROS 2",
    text="a package with plugins of inverse_dynamics_solver and kinematics_interface",
    files={
        "src/{stem}.c": str,
        "src/{stem}.h": str,
        **{f"src/{name}": str for name in ("plugins.hpp", "dynamics.cpp", "kinematics.cpp")},
        **{f"{name.lower()}.xml": str for name in PLUGINS},
    },
    keywords=frozenset(),  # every function begins with the name of the scene
    functions=needed,
    printer=C.printer,
    comment=C.comment,
    write=_write,
    beside=_beside,
)
