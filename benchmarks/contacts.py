"""Contacts, stops and dry friction: times and velocities against closed forms, laws in numbers, time of a run.

    python benchmarks/contacts.py

Each line has what was set out to be reached; the script ends with 1 where one was missed.
"""

from __future__ import annotations

import ctypes
import json
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from bars import Bar

import symdyn
from symdyn.dynamics import derive
from symdyn.emit import beside, emit, write
from symdyn.program import lower
from symdyn.scene import Scene, read_text
from symdyn.simulation.equations.complementarity import FREE, SLIP, Case, Laws
from symdyn.simulation.return_map import ReturnMap
from symdyn.simulation.variations import state_covectors

DATA = Path(__file__).resolve().parent.parent / "tests" / "data" / "impacts"
RANDOM, COMPILED = 10_000, 100_000


def told(name: str, value: float, most: float, unit: str) -> Bar:
    """Print and return one line."""
    bar = Bar(name, f"{most:g} {unit}", f"{value:.3g} {unit}", value <= most)
    print(f"{name:64} {bar.shown:>14} of {bar.wanted:8} {bar.verdict}", flush=True)
    return bar


def ball() -> list[Bar]:
    """Return what was missed by a ball that bounces until it rests."""
    scene = symdyn.read(DATA / "scenes" / "ball.toml")
    first = (2 / 9.81) ** 0.5
    truth = [first * (1 + 2 * sum(0.8**i for i in range(1, k + 1))) for k in range(30)]
    missed = []
    for method in ("taylor", "dop853"):
        run = symdyn.simulate(scene, until=6, method=method, rtol=1e-13)
        hits = [one.t for one in run.impacts][:30]
        worst = float(np.abs(np.array(hits) - truth).max())
        missed.append(told(f"ball by {method}: time of 30 hits, largest error", worst, 1e-12, "s"))
        rest = abs((run.impacts[-1].rest or 0.0) - first * 1.8 / 0.2)
        missed.append(told(f"ball by {method}: when it rests, error", rest, 1e-10, "s"))
        missed.append(
            told(f"ball by {method}: its rate then", float(np.abs(run["z_dot"][run.t > 4.1]).max()), 0.0, "m/s")
        )
    times = []
    for _ in range(15):
        begin = time.process_time()
        run = symdyn.simulate(scene, until=6, method="taylor")
        times.append(1e3 * (time.process_time() - begin))
    ninety = median(times) * 90 / len(run.impacts)
    text = f"ball: {len(run.impacts)} events in {median(times):.0f} ms of a processor; ninety of them"
    missed.append(told(text, ninety, 50, "ms"))
    return missed


def references() -> list[Bar]:
    """Return what was missed of published figures; see tests/test_contacts.py."""
    missed = []
    for case in json.loads((DATA / "references.json").read_text())["cases"]:
        if "scene" not in case or case["id"] == "ball":
            continue
        run = symdyn.simulate(symdyn.read(DATA / case["scene"]), until=case["until"], method="taylor", rtol=1e-13)
        words = {"impact": "strikes", "stick": "sticks", "slip": "slips"}
        for kind, *rest in (one["what"] for one in case["expect"][:1]):
            if kind == "time":
                what, contact, k = rest
                hits = [one.t for one in run.impacts if one.what == words[what] and one.contact.startswith(contact)]
                wanted = case["expect"][0]
                off = abs([t for t in hits if t > 1e-9][k] - wanted["value"])
                missed.append(told(f"{case['id']}: time of the first event, error", off, wanted["tol"], "s"))
        kept = [value for name, value in run.monitors.items() if name.startswith("contact_laws")]
        missed.append(told(f"{case['id']}: laws of contact, every row", max(kept, default=0.0), 1e-12, ""))
        missed.append(told(f"{case['id']}: energy balance", float(np.abs(run["energy_error"]).max()), 1e-10, "J"))
    return missed


def laws() -> list[Bar]:
    """Return whether two ways to solve the laws of random contacts find the same."""
    rng, differ, count = np.random.default_rng(0), 0, 0
    times = {"cases": 0.0, "pivots": 0.0}
    for _ in range(RANDOM):
        k = int(rng.integers(1, 3))
        B, W = rng.normal(size=(8, 8)), rng.normal(size=(2 * k, 8))
        D = W @ np.linalg.solve(B @ B.T + 0.1 * np.eye(8), W.T)
        mu, e = rng.uniform(0, 1, k), np.full(k, rng.uniform(0, 1))
        one = Laws(D, tuple(range(0, 2 * k, 2)), tuple((i,) for i in range(1, 2 * k, 2)), mu, mu, e)
        v = W @ rng.normal(size=8)
        if not np.any(v[::2] < 0):
            continue
        count += 1
        target = np.zeros(2 * k)
        target[::2] = -e * v[::2]
        begin = time.perf_counter()
        cases = [found for _, found in one.solutions(v, [(FREE, *one.slips(i)) for i in range(k)], None, target)]
        between = time.perf_counter()
        pivots = one.by_pivots(v, [0.0] * k, np.zeros(k), target)
        times["cases"] += between - begin
        times["pivots"] += time.perf_counter() - between
        size = max(1e-6, *(float(np.abs(found).max()) for found in cases))
        differ += pivots is None or min(float(np.abs(found - pivots).max()) for found in cases) > 1e-8 * size
    print(f"{count} random impacts of one or two contacts: all cases {1e6 * times['cases'] / count:.0f} us each, "
          f"Lemke {1e6 * times['pivots'] / count:.0f} us")  # fmt: skip
    return [told("all cases and Lemke's pivots, differences", differ, 0, "")]


def gains() -> list[Bar]:
    """Return what energy Poisson's law adds with one restitution, of random contacts, one or two at a time."""
    rng, worst, count, begin = np.random.default_rng(1), 0.0, 0, time.process_time()
    while count < COMPILED:
        for k in (1, 2):
            D, d, mu, _ = problems(rng, 1000, k)
            restitution = rng.uniform(0, 1, 1000)
            for i in np.flatnonzero((d[:, ::2] < 0).any(axis=1)).tolist():
                e = np.full(k, restitution[i])
                one = Laws(D[i], tuple(range(0, 2 * k, 2)), tuple((j,) for j in range(1, 2 * k, 2)), mu[i], mu[i], e)
                impulses = one.impact(d[i], [True] * k)
                change, size = impulses @ (2 * d[i] + D[i] @ impulses) / 2, np.abs(impulses * d[i]).sum()
                worst = max(worst, change / size if size else 0.0)
                count += 1
    print(f"{count} impacts by Poisson's law in {time.process_time() - begin:.0f} s")
    return [told("Poisson's law, one restitution: energy added, relative", worst, 1e-14, "")]


def by_differences(walk: symdyn.simulation.Gait) -> Bar:
    """Return how far multipliers of a gait are from those of differences of its return map, of fourth order."""
    returns = ReturnMap.of(walk.problem, walk.section, walk.swap, 0.0, walk.until, 1e-13)
    x, there = returns.fixed_point()
    returns = replace(returns, section=replace(returns.section, sooner=0.1))
    U, sizes, _ = np.linalg.svd(there.slope)
    basis = U[:, sizes > 1e-8]  # on the section, where a foot has struck
    rows = state_covectors(returns.flow, x)[returns._ways(x)[2]]
    moved, behind = np.zeros((2, *basis.shape))
    for k, way in enumerate(basis.T):
        for part, weight in ((1, 2 / 3), (-1, -2 / 3), (2, -1 / 12), (-2, 1 / 12)):
            y = returns._moved(x, there, part * 5e-5 * way)
            moved[:, k] += weight / 5e-5 * (rows @ (y - x))
            behind[:, k] += weight / 5e-5 * (rows @ (y - x) + returns.missed(y, returns.at(y)))
    found = np.linalg.eigvals(np.linalg.lstsq(moved, behind, rcond=None)[0])
    off = max(float(np.abs(found - one).min()) for one in walk.multipliers)
    return told("walker: multipliers, off those of differences", off, 1e-8, "")


def gaits() -> list[Bar]:
    """Return what was missed by periodic motions: a biped's fixed point with its multipliers, from a loaded scene."""
    walker = symdyn.read(DATA / "scenes" / "walker.toml")
    asked: dict[str, Any] = {"section": "strikes foot_a", "swap": "a=b"}
    found = symdyn.gait(walker, **asked).continued("slope", [0.0095])[0]
    times = []
    for slope in (0.0096, 0.0097, 0.0098, 0.0099, 0.01):
        begin = time.process_time()
        (found,) = found.continued("slope", [slope])
        times.append(time.process_time() - begin)
    return [
        by_differences(symdyn.gait(walker, **asked).continued("m", [3e-3, 6e-3, 1e-2])[-1]),
        told("walker: a fixed point and its multipliers, processor time", median(times), 0.1, "s"),
        told("walker: what its fixed point misses itself by", found.missed, 1e-9, ""),
    ]


def chain(links: int, feet: dict[str, int], close: float = 0.0) -> Scene:
    """Return links one after the other in a plane, and contacts at tips of some of them, or `close` to each other."""
    text = 'name = "chain"\n'
    for k in range(links):
        text += f'[bodies.b{k}]\nmass = {1 + k / 10}\ninertia = [0.1, 0.1, 0.1]\ninertia_about = "com"\n'
        text += f"com = [0.5, 0, 0]\n[joints.j{k}]\ntype = 'revolute'\naxis = [0, 1, 0]\nchild = 'b{k}'\n"
        text += f"parent = '{f'b{k - 1}' if k else 'ground'}'\norigin = [{1 if k else 0}, 0, 0]\n"
    for k, (name, link) in enumerate(feet.items()):
        text += (
            f"[contacts.{name}]\nbody = 'b{link}'\nat = [{1 - close * k}, 0, 0]\nnormal = [0, 0, 1]\nfriction = 0.5\n"
        )
    return read_text(text)


LAWS = """#include "chain_contacts.h"
void many(int count, const double *D, const double *d, const double *mu, const double *slip, double *out, int *pivots);
void many(int count, const double *D, const double *d, const double *mu, const double *slip, double *out, int *pivots)
{
    double mask[K];
    for (int i = 0; i < K; i++) { mask[i] = 1.0; }
    for (int k = 0; k < count; k++) {
        pivots[k] = chain_contact_laws(D + 4*K*K*k, d + 2*K*k, mu + K*k, mask, slip + K*k, (double *)0, out + 2*K*k);
    }
}
"""

IMPACT = """#include "chain_contacts.h"
int many(int count, const double *q, const double *u, double *out);
int many(int count, const double *q, const double *u, double *out)
{
    const double mask[2] = {1.0, 1.0}, slip[2] = {0.0, 0.0}, mu[2] = {0.5, 0.5};
    int failed = 0;
    for (int k = 0; k < count; k++, q += 7, u += 7, out += 7) {
        double D[16], a[3], b[3], A[21], B[21], lambda[4];
        chain_delassus(q, D);
        chain_gap_rate_a(q, u, a);
        chain_gap_rate_b(q, u, b);
        const double v[4] = {a[0], a[1], b[0], b[1]};
        failed += chain_contact_laws(D, v, mu, mask, slip, (double *)0, lambda) < 0;
        chain_impact_matrix_a(q, A);
        chain_impact_matrix_b(q, B);
        for (int i = 0; i < 7; i++) {
            out[i] = u[i] + A[3*i]*lambda[0] + A[3*i + 1]*lambda[1] + B[3*i]*lambda[2] + B[3*i + 1]*lambda[3];
        }
    }
    return failed;
}
"""


def compiled(scene: Scene, asked: list[str], text: str) -> Any:
    """Return a function `many` of C beside a scene's."""
    sources = emit(lower(derive(scene, ["delassus", "contact_bias", *asked])), "c")
    with tempfile.TemporaryDirectory() as folder:
        write({**sources, **beside(sources), "many.c": text}, folder)
        words = [f"-DK={len(scene.unilaterals)}", "-O3", "-march=native", "-fPIC", "-shared", "many.c", "chain.c"]
        subprocess.run(["cc", *words, "-o", "many.so", "-lm"], cwd=folder, check=True)
        return ctypes.CDLL(str(Path(folder) / "many.so")).many


def called(many: Any, count: int, *arrays: np.ndarray) -> float:
    """Return the time of one of so many calls, µs, the least of several goes."""
    places, times = [ctypes.c_void_p(one.ctypes.data) for one in arrays], []
    for _ in range(7):
        begin = time.perf_counter()
        many(count, *places)
        times.append(time.perf_counter() - begin)
    return 1e6 * min(times) / count


def problems(rng: np.random.Generator, count: int, k: int) -> tuple[np.ndarray, ...]:
    """Return D, rates and friction of random contacts, and which way they slip already."""
    W, B = rng.normal(size=(count, 2 * k, 2 * k + 4)), rng.normal(size=(count, 2 * k + 4, 2 * k + 4))
    M = B @ B.transpose(0, 2, 1) + 0.1 * np.eye(2 * k + 4)
    D = np.ascontiguousarray(W @ np.linalg.solve(M, W.transpose(0, 2, 1)))
    d = (W @ rng.normal(size=(count, 2 * k + 4, 1)))[:, :, 0].copy()
    return D, d, rng.uniform(0, 1, (count, k)), np.zeros((count, k))


def missed_by(laws: Laws, d: np.ndarray, found: np.ndarray) -> float:
    """Return by how much forces miss Signorini's and Coulomb's laws, over the largest of their kind."""
    xi, most = laws.D @ found + d, laws.friction * found[::2]
    force, slip, size = found[1::2], xi[1::2], max(np.abs(found).max(), 1e-300)
    fast = max(np.abs(d).max(), np.abs(laws.D).max() * size)
    off = [-found[::2] / size, -xi[::2] / fast, (np.abs(force) - most) / size, found[::2] * xi[::2] / size / fast]
    return float(max(*map(np.max, off), np.abs(np.abs(slip) * force + most * slip).max() / size / fast))


def generated() -> list[Bar]:
    """Return what was missed by Lemke's pivots in generated C: against all cases, and in time."""
    rng, missed = np.random.default_rng(0), list[Bar]()
    many = compiled(chain(7, {"a": 3, "b": 6}), [], LAWS)
    D, d, mu, slip = problems(rng, COMPILED, 2)
    slip[COMPILED // 2 :] = rng.choice([-1.0, 0.0, 1.0], (COMPILED - COMPILED // 2, 2))
    found, pivots = np.zeros((COMPILED, 4)), np.zeros(COMPILED, dtype=np.intc)
    called(many, COMPILED, D, d, mu, slip, found, pivots)
    differ, none = 0, 0
    for k in range(COMPILED):
        one, ways = Laws(D[k], (0, 2), ((1,), (3,)), mu[k], mu[k], np.zeros(2)), slip[k].tolist()
        options = [(FREE, *((Case(True, SLIP, (z,), moving=True),) if z else one.slips(i))) for i, z in enumerate(ways)]
        cases = [some for _, some in one.solutions(d[k], options)]
        if pivots[k] < 0 and not cases:
            none += 1
            continue
        size = 1e-8 * max(1e-6, *(float(np.abs(some).max()) for some in cases), 0.0)
        if pivots[k] < 0 or not any(np.abs(some - found[k]).max() <= size for some in cases):
            differ += 1
            kept = "no forces" if pivots[k] < 0 else f"misses {missed_by(one, d[k], found[k]):.1e}"
            told_by = [f"{missed_by(one, d[k], some):.1e}" for some in cases]
            print(f"  {k}: cond D {np.linalg.cond(D[k]):.1e}, slip {ways}: {pivots[k]}, {kept}; cases {told_by}")
    print(f"C, {COMPILED} problems of two contacts: {differ} differ from all cases; neither finds forces in {none}; "
          f"{pivots.max()} pivots or cases at most")  # fmt: skip
    missed.append(told("C and all cases, differences", differ, 0, ""))
    some = called(many, COMPILED // 2, D, d, mu, slip, found, pivots)
    print(f"C, two contacts: {some:.2f} us, {pivots[: COMPILED // 2].mean():.1f} pivots")
    given = problems(rng, 2000, 8)
    found, pivots = np.zeros((2000, 16)), np.zeros(2000, dtype=np.intc)
    eight = compiled(chain(7, {f"foot{k}": 6 for k in range(8)}, close=0.1), [], LAWS)
    some = called(eight, 2000, *given, found, pivots)
    print(f"C, eight contacts: {some:.2f} us, {pivots.mean():.1f} pivots, {pivots.max()} at most")
    missed.append(told("C, eight contacts: problems without forces", int((pivots < 0).sum()), 0, ""))
    asked = [f"{one}:{foot}" for one in ("gap_rate", "impact_matrix") for foot in "ab"]
    struck = compiled(chain(7, {"a": 3, "b": 6}), asked, IMPACT)
    q, u = rng.uniform(-1, 1, (2, 2000, 7))
    missed.append(told("impact map in C, two contacts, seven axes", called(struck, 2000, q, u, 0 * u), 1.0, "us"))
    return missed


def steps() -> list[Bar]:
    """Return what was missed by the order of Moreau's steps; what they miss beside MuJoCo tells contact_steps.py."""
    missed, brick, errors = list[Bar](), symdyn.read(DATA / "scenes" / "brick.toml"), list[float]()
    for step in (0.01, 0.005, 0.0025):
        off = []
        for phase in (np.arange(16) + 0.5) / 16:
            start = {"y": 9.81 * np.cos(0.3) * (0.2 + phase * step) ** 2 / 2}
            pair = [symdyn.simulate(brick, until=0.6, every=0.3, start=start, method=method)["x"][-1]
                    for method in ("dop853", f"moreau:{step}")]  # fmt: skip
            off.append(pair[1] - pair[0])
        errors.append(float(np.sqrt(np.mean(np.square(off)))))
    for coarse, fine in pairwise(errors):
        order = np.log2(coarse / fine)
        missed.append(told(f"brick thrown on its incline, order {order:.3f}, off 1 by", abs(order - 1), 0.1, ""))
    return missed


if __name__ == "__main__":
    found = [*ball(), *references(), *laws(), *gains(), *generated(), *gaits(), *steps()]
    sys.exit(any(bar.reached is False for bar in found))
