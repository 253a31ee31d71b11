"""The header of contact forces beside generated C, compiled, against enumeration and Lemke's pivots of runs."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from test_c_project import LANGUAGES, by_hand

import symdyn
from symdyn.dynamics import derive
from symdyn.emit import beside, emit, write
from symdyn.emit.targets.c.c_and_cpp import PIVOTS
from symdyn.program import Program, lower
from symdyn.scene import Scene, read_text
from symdyn.simulation.equations import many_contacts
from symdyn.simulation.equations.complementarity import FREE, SLIP, Case, Laws
from symdyn.simulation.equations.settling import part

pytestmark = [pytest.mark.runs("cc"), pytest.mark.usefixtures("optimised")]

SCENES = Path(__file__).parent / "data" / "impacts" / "scenes"
ASKED = ("delassus", "contact_bias")
Numbers = np.ndarray


def plank(feet: int, name: str = "plank") -> Scene:
    """Return a plank that moves in a plane and stands on some feet."""
    text = f'name = "{name}"\ngravity = [0, 0, -9.81]\n[bodies.slide]\n[bodies.lift]\n'
    text += '[bodies.plank]\nmass = 2\ninertia = [0.1, 0.1, 0.1]\ninertia_about = "com"\ncom = [0, 0, 0.2]\n'
    for joint_name, parent, child, rest in (
        ("px", "ground", "slide", 'type = "prismatic"\naxis = [1, 0, 0]'),
        ("pz", "slide", "lift", 'type = "prismatic"\naxis = [0, 0, 1]'),
        ("turn", "lift", "plank", 'type = "revolute"\naxis = [0, 1, 0]'),
    ):
        text += f'[joints.{joint_name}]\nparent = "{parent}"\nchild = "{child}"\n{rest}\n'
    for k in range(feet):
        at = f"[{(k - (feet - 1) / 2) / 4}, 0, 0]"
        rough = f"friction = {0.2 + 0.05 * k}\n" if k != 1 else ""  # the second one is smooth
        text += f'[contacts.foot{k}]\nbody = "plank"\nat = {at}\nnormal = [0, 0, 1]\n{rough}'
    return read_text(text)


@cache
def program(scene: Scene) -> Program:
    return lower(derive(scene, ASKED))


def files(scene: Scene, real: str = "double", option: str = "") -> dict[str, str]:
    sources = emit(program(scene), "c", real, option=option)
    return {**sources.texts, **beside(sources)}


def compiled(scene: Scene, folder: Path, change: Callable[[str], str] = str) -> Callable[..., tuple[int, Numbers]]:
    """Return the compiled functions, which take contact_laws or contact_forces and arrays."""
    written = files(scene)
    name = scene.name
    written[f"{name}_contacts.h"] = change(written[f"{name}_contacts.h"])
    laws = "D, d, mu, mask, slip, least, lambda"
    text = f'#include "{name}_contacts.h"\n'
    for what, names in (("laws", laws), ("forces", "q, qd, tau, mu, mask, slip, lambda")):
        declared = ", ".join(f"{'' if one == 'lambda' else 'const '}double *{one}" for one in names.split(", "))
        text += f"int {what}({declared});\nint {what}({declared})\n{{ return {name}_contact_{what}({names}); }}\n"
    write({**written, "called.c": text}, folder)
    strict = ["-std=c99", "-O0", "-Wall", "-Wextra", "-Wshadow", "-Wconversion", "-Werror", "-fPIC", "-shared"]
    command = ["cc", *strict, "called.c", f"{name}.c", "-o", "called.so", "-lm"]
    subprocess.run(command, cwd=folder, check=True, timeout=300)
    library = ctypes.CDLL(str(folder / "called.so"))
    m = len(laws_of(scene).D)

    def call(what: str, *given: Numbers | None) -> tuple[int, Numbers]:
        kept = [None if one is None else np.ascontiguousarray(one, dtype=np.float64) for one in given]
        found = np.zeros(m)
        where = [None if one is None else ctypes.c_void_p(one.ctypes.data) for one in (*kept, found)]
        return int(getattr(library, what)(*where)), found

    return call


def laws_of(scene: Scene) -> Laws:
    """Return laws of contacts with the rows that the labels of D tell, and numbers of zero."""
    labels = program(scene).routines[0].function.labels[0]
    names = list(dict.fromkeys(one.partition(" of ")[2] for one in labels))
    places = {one: k for k, one in enumerate(labels)}
    normals = tuple(places.get(f"normal of {one}") for one in names)
    along = tuple((places[f"tangent of {one}"],) if f"tangent of {one}" in places else () for one in names)
    return Laws(np.zeros((len(labels),) * 2), normals, along, *np.zeros((3, len(names))))


def drawn(rng: np.random.Generator, k: int) -> tuple[Numbers, ...]:
    """Return a mode and friction of k contacts."""
    mask = (rng.uniform(size=k) < 0.8).astype(float)
    slip = rng.choice([-1.0, 0.0, 0.0, 0.0, 1.0], size=k)
    return rng.uniform(0.0, 1.0, k), mask, slip


def every_way(laws: Laws, d: Numbers, slip: Numbers) -> list[Numbers]:
    """Return all solutions of closed contacts, by enumeration of the cases."""
    options = [
        (FREE, *(laws.slips(k) if not z or not along else (Case(True, SLIP, (z,), moving=True),)))
        for k, (z, along) in enumerate(zip(slip.tolist(), laws.tangents, strict=True))
    ]
    return [found for _, found in laws.solutions(d, options)]


def compared(scene: Scene, folder: Path, states: int) -> tuple[int, int]:
    """Return of how many states neither road finds forces, and in how many forces are none of those by enumeration."""
    call, rng = compiled(scene, folder), np.random.default_rng(7)
    numbers, every = symdyn.load(scene, list(ASKED)), laws_of(scene)
    none = differ = 0
    for i in range(states):
        q, u, tau = rng.uniform(-1, 1, (3, len(scene.coordinates))) * (i % 10 > 0)  # natural states too: all zero
        mu, mask, slip = drawn(rng, len(every.normals))
        some = np.flatnonzero(mask).tolist()
        if not some:
            continue
        D, d = numbers.delassus(q), numbers.contact_bias(q, u, tau)
        laws, rows = part(replace(every, D=D, friction=mu, static=mu), some)
        pivots, found = call("forces", q, u, tau, mu, mask, slip)
        ways = every_way(laws, d[rows], slip[some])
        if pivots < 0:
            none, differ = none + (not ways), differ + bool(ways)
            assert np.isnan(found).all()
            assert slip[some].any()  # else there is a solution, and it is found
            continue
        assert not np.delete(found, rows).any()
        size = 1e-8 * max(1.0, float(np.abs(d).max()))
        differ += min((float(np.abs(laws.D @ (way - found[rows])).max()) for way in ways), default=np.inf) > size
    return none, differ


@pytest.mark.parametrize("name", ["walker", "rocking_block"])
def test_forces_are_those_of_all_cases(name: str, tmp_path: Path) -> None:
    assert compared(symdyn.read(SCENES / f"{name}.toml"), tmp_path, 200)[1] == 0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["walker", "rocking_block"])
def test_forces_are_those_of_all_cases_in_many_states(name: str, tmp_path: Path) -> None:
    assert compared(symdyn.read(SCENES / f"{name}.toml"), tmp_path, 10_000)[1] <= 1  # slips: two motions fit, on a ray


def test_both_languages_pivot_alike_and_keep_the_laws_of_impacts(tmp_path: Path) -> None:
    """Nine feet, one smooth, of which eight at most stand; twice for compression and expansion."""
    scene = plank(9)
    call, every, rng = compiled(scene, tmp_path), laws_of(scene), np.random.default_rng(3)
    k, m = len(every.normals), len(every.D)
    for _ in range(20):
        W, B = rng.normal(size=(m, m + 2)), rng.normal(size=(m + 2, m + 2))
        D, v = W @ np.linalg.solve(B @ B.T + 0.1 * np.eye(m + 2), W.T), W @ rng.normal(size=m + 2)
        mu, mask, slip = drawn(rng, k)
        mask[int(rng.integers(k))] = 0.0
        some, least, none = np.flatnonzero(mask).tolist(), rng.uniform(0, 0.1, k), np.zeros(m)
        laws, rows = part(replace(every, D=D, friction=mu, static=mu), some)
        for d, offset, slides in ((v, None, slip), (v, least, slip), (v, None, 0 * slip)):
            pivots, found = call("laws", D, d, mu, mask, slides, offset)
            of = np.zeros(len(some)) if offset is None else offset[some]
            wanted = laws.by_pivots(d[rows], slides[some].tolist(), of, none[rows])
            assert (pivots >= 0) == (wanted is not None)
            assert pivots >= 0 or slides.any()  # without slip there is a solution, and it is found
            if wanted is not None:
                assert found[rows] == pytest.approx(wanted, rel=1e-9, abs=1e-9 * np.abs(wanted).max())
        feet = some[:2]
        laws, rows = part(replace(every, D=D, friction=mu, static=mu), feet)
        mask = np.isin(np.arange(k), feet).astype(float)
        e = np.full(k, 0.6)
        first = call("laws", D, v, mu, mask, 0 * slip, None)[1]
        normal = first[list(every.normals)]
        more = call("laws", D, v + D @ first, mu, mask, 0 * slip, e * normal)[1]
        by_cases = replace(laws, restitution=e[: len(feet)]).impact(v[rows], [True] * len(feet))
        assert (first + more)[rows] == pytest.approx(by_cases, rel=1e-8, abs=1e-8 * np.abs(v).max())


def test_what_has_no_forces_is_told_by_a_number(tmp_path: Path) -> None:
    scene = plank(9)
    call, m = compiled(scene, tmp_path / "plain"), 17
    D, d, ones, zeros = np.eye(m), -np.ones(m), np.ones(9), np.zeros(9)
    one = np.eye(9)[0]
    rough = D.copy()
    rough[0, 1] = rough[1, 0] = 0.9  # a normal force and its friction push each other in
    bad = np.where(np.arange(m) == 3, np.nan, d)
    for wanted, given in (
        (-3, (D, d, ones, ones, zeros)),
        (-1, (rough, d, 2 * ones, one, one)),
        (-4, (D, bad, ones, np.eye(9)[2], zeros)),
        (-4, (D, np.where(np.isnan(bad), np.inf, d), ones, np.eye(9)[2], zeros)),
        (-4, (D, d, ones * np.nan, one, zeros)),
    ):
        pivots, found = call("laws", *given, None)
        assert pivots == wanted
        assert np.isnan(found).all()
    pivots, found = call("laws", D, bad, ones, one, zeros, None)  # what is open is not looked at
    assert (pivots > 0, found[0], np.count_nonzero(found)) == (True, 1.0, 2)
    assert not call("laws", D, -d, ones, ones - one, zeros, None)[1].any()  # all go up
    short = compiled(plank(2), tmp_path / "short", lambda text: text.replace(f"< {PIVOTS})", "< 1)"))
    assert short("laws", np.eye(3), d[:3], ones, ones, zeros, None)[0] == -2
    assert many_contacts.PIVOTS == PIVOTS


SPATIAL = """
name = "puck"
[bodies.puck]
mass = 1
inertia = [1, 1, 1]
inertia_about = "com"
[joints.free]
type = "free"
parent = "ground"
child = "puck"
[contacts.rim]
body = "puck"
friction = 0.3
"""


def test_what_it_cannot_do_it_refuses_where_it_is_included(tmp_path: Path) -> None:
    for scene, real, wanted in (
        (read_text(SPATIAL), "double", "contacts.rim can slip along two directions"),
        (plank(1), "float", "these functions are of float: generate without --real"),
        (plank(1), "dd", "these functions are of dd: generate without --real"),
    ):
        write({**files(scene, real), "called.c": f'#include "{scene.name}_contacts.h"\n'}, tmp_path)
        ran = subprocess.run(["cc", "-c", "called.c"], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert ran.returncode == 1
        assert wanted in ran.stderr
    assert not any(name.endswith("_contacts.h") for name in beside(emit(lower(derive(plank(1), ASKED[:1])), "c")))


@pytest.mark.runs("gcc", "g++")
@pytest.mark.parametrize("language", LANGUAGES)
def test_headers_of_two_scenes_stand_side_by_side_in_both_languages(language: str, tmp_path: Path) -> None:
    for name in ("plank", "board"):
        write(files(plank(2, name), option="header-only"), tmp_path)
    text = '#include "plank_contacts.h"\n#include "board_contacts.h"\n#include "plank_contacts.h"\n'
    text += """int main(void) {
        const double q[3] = {0.0, 0.0, 0.0}, mu[2] = {0.5, 0.5}, mask[2] = {1.0, 1.0}, slip[2] = {0.0, 0.0};
        double lambda[3];
        const int found = plank_contact_forces(q, q, q, mu, mask, slip, lambda);
        return !(found > 0 && fabs(lambda[0] + lambda[2] - 2.0 * 9.81) < 1e-12);
    }"""
    (tmp_path / "one.c").write_text(text)
    ran = by_hand(tmp_path, language, ["one.c"])
    assert ran.returncode == 0
