"""Whether stated intervals hold the truth: base parameters of simulated arms over 100 seeds, and FIGAROH beside.

    python benchmarks/identification.py [--arms puma560,arm7] [--gains two_link] [--said puma560]
        [--noise sprung_arm,pendulum,cart_pole] [--seeds 100] [--figaroh PYTHON]

Logs are those of `tests/simulated_logs.py`: friction, encoders that count, noisy torques; seeds are 0, 1, 2, ... and
none is picked. Counted is for how many the 95 % interval of each base parameter holds its true value, and the joint
ellipsoid all of them. `--gains` does so where drives show currents, without and with a payload of which the mass is
told: gains and the payload are among the parameters. `--said` says the gains of all drives, without and with one of
them wrong, and prints how many times as long that takes as the same logs in N m. `--noise` counts runs of several Hz
under known forces, with white noise of positions from 1e-5 to 1e-3 rad and of forces, in the band that is chosen and in
the widest. `--figaroh` names the Python of an
environment with `pip install figaroh==1.0.2`, which is given the same log of the first seed and the same motion,
differentiated and filtered by us, as its own examples do by theirs.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(Path(__file__).resolve().parent), str(ROOT), str(ROOT / "tests")]

import numpy as np  # noqa: E402
from scipy.stats import binom  # noqa: E402
from simulated_logs import (  # noqa: E402
    ARMS,
    DRIVEN,
    FORCED,
    TERMS,
    Arm,
    Coverage,
    Driven,
    Forced,
    coverage,
    coverage_of_gains,
    coverage_of_noise,
)

from symdyn.identification import identify  # noqa: E402
from symdyn.scene import write_text  # noqa: E402

NOISES, FORCE_NOISE, WIDEST = (1e-5, 1e-4, 1e-3), 0.02, 80.0
"""Of positions, rad and m, and of forces, N m and N; Hz."""

LEAST, MOST = 90, 99
"""Seeds of 100 that are to hold."""

SAID = (1.5, 5.0)
"""Times the same logs with forces that gains may take which are said: all rightly, and one wrongly."""


def told(found: Coverage, seconds: float) -> None:
    """Print what was counted."""
    seeds, held = found.seeds, found.held
    print(f"{found.arm}: {len(held)} parameters, {seeds} seeds, {seconds / seeds:.2f} s of one core each")
    print(f"  held on average {100 * held.mean() / seeds:.1f} %, least {held.min()}, most {held.max()} of {seeds}")
    low, high = LEAST * seeds / 100, MOST * seeds / 100
    outside = [f"{name} {k}" for name, k in zip(found.names, held, strict=True) if not low <= k <= high]
    chance = len(held) * (binom.cdf(np.ceil(low) - 1, seeds, 0.95) + binom.sf(np.floor(high), seeds, 0.95))
    print(f"  outside {low:g} to {high:g}: {', '.join(outside) or 'none'}; {chance:.1f} expected of exact intervals")
    gains = {name: int(k) for name, k in zip(found.names, held, strict=True) if name.startswith("gain")}
    if gains:
        print(f"  of gains least {min(gains.values())}, most {max(gains.values())} of {seeds}: {gains}")
    print(f"  joint ellipsoid: {found.joint} of {seeds}; (β - truth)/error has rms {found.ratio:.3f}")


def noisy(forced: Forced, seeds: int) -> None:
    """Print what was counted by noise of the positions, and in which band."""
    for noise in NOISES:
        for wanted in (None, WIDEST):
            found = coverage_of_noise(forced, noise, FORCE_NOISE, seeds, wanted)
            share = 100 * found.held.mean() / seeds
            band = identify(forced.scene, forced.log(0, noise, FORCE_NOISE), wanted).band
            asked = " (asked for)" if wanted else ""
            print(f"{forced.name}, {noise:g} rad or m, band {band:.3g} Hz{asked}: held on average {share:.1f} %,")
            print(f"  least {found.held.min()} of {seeds}; joint {found.joint}; errors have rms {found.ratio:.2f}")


def said(driven: Driven, seeds: int) -> None:
    """Print what it costs to say all gains: times the same logs with forces, medians of ratios inside a round."""
    names, scene = list(driven.units), driven.arm.scene

    def seconds(logs: list[dict[str, np.ndarray]], gains: list[float] | None, loaded: bool) -> float:
        units = gains and {name: f"{k!r}*A" for name, k in zip(names, gains, strict=True)}
        begin = time.process_time()
        identify(scene, logs, friction=TERMS, units=units or None, payloads=driven.given if loaded else ())
        return time.process_time() - begin

    right = list(driven.gains)
    wrong = [0.6 * k if j == (len(names) - 1) // 2 else k for j, k in enumerate(right)]
    for loaded in (True, False):
        rounds = []
        for seed in range(seeds + 1):
            logs = driven.logs(seed)[: 2 if loaded else 1]
            forces = [one | {name: k * one[name] for name, k in zip(names, right, strict=True)} for one in logs]
            rounds.append([seconds(forces, None, loaded), seconds(logs, right, loaded), seconds(logs, wrong, loaded)])
        plain, *others = np.array(rounds[1:]).T  # what is compiled is compiled in the first
        print(f"{driven.arm.name}, all gains said, {'with' if loaded else 'without'} a payload, {seeds} seeds")
        print(f"  forces {np.median(plain):.2f} s of one core")
        for title, one, most in zip(("right", "one wrong"), others, SAID, strict=True):
            times = float(np.median(one / plain))
            verdict = "reached" if times <= most else "missed"
            print(f"  {title}: {np.median(one):.2f} s, {times:.2f} times; wanted at most {most:g}: {verdict}")


def beside(arm: Arm, python: str) -> None:
    """Print how far predicted torques are off on a fresh motion, ours and FIGAROH's, from the same log."""
    log = arm.log(0)
    begin = time.perf_counter()
    found = identify(arm.scene, log, friction=["viscous", "coulomb"])
    ours = time.perf_counter() - begin
    _, q, qd, qdd = arm.fourier(np.random.default_rng(99))
    Y = arm.model.regressor(q, qd, qdd)
    right = Y @ arm.model.prior
    size = np.sqrt(np.mean(right**2, axis=0))
    print(f"{arm.name}, one log, torques of a fresh motion, error in % of their rms, by joint")
    print(f"  symdyn   {ours:5.2f} s   {percent(Y @ found.after - right, size)}")
    motion = found.motions[0]
    with TemporaryDirectory() as folder:
        urdf = write_text(arm.scene, "urdf", lossy=True).text
        urdf = urdf.replace('type="continuous"', 'type="revolute"')  # Pinocchio takes a continuous joint as cos and sin
        urdf = urdf.replace("</joint>", '<limit lower="-9" upper="9" effort="999" velocity="99"/></joint>')
        (Path(folder) / "arm.urdf").write_text(urdf)
        arrays = {"q": motion.q, "qd": motion.qd, "qdd": motion.qdd, "tau": motion.tau, "step": 1 / arm.rate}
        arrays |= {"band": found.band, "q_new": q, "qd_new": qd, "qdd_new": qdd}
        np.savez(Path(folder) / "log.npz", **arrays)
        command = [python, str(Path(__file__).parent / "peers" / "figaroh_base.py"), folder]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            print(f"  FIGAROH: {done.stderr.strip().splitlines()[-1]}")
            return
        theirs = json.loads(done.stdout.strip().splitlines()[-1])
        new = np.load(Path(folder) / "tau.npy")
    print(f"  FIGAROH  {theirs['seconds']:5.2f} s   {percent(new - right, size)}   ({theirs['count']} parameters)")


def percent(off: np.ndarray, size: np.ndarray) -> str:
    """Return errors by joint."""
    return " ".join(f"{100 * x:.2f}" for x in np.sqrt(np.mean(off**2, axis=0)) / size)


def main() -> None:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--arms", default="puma560,arm7", help=f"of {', '.join(ARMS)}")
    parser.add_argument("--gains", default="", help=f"of {', '.join(DRIVEN)}")
    parser.add_argument("--said", default="", help=f"of {', '.join(DRIVEN)}")
    parser.add_argument("--noise", default="", help=f"of {', '.join(FORCED)}")
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--figaroh", metavar="PYTHON", help="of an environment that has it")
    asked = parser.parse_args()
    for name in filter(None, asked.arms.split(",")):
        if asked.seeds:
            begin = time.process_time()
            told(coverage(ARMS[name], asked.seeds), time.process_time() - begin)
        if asked.figaroh:
            beside(ARMS[name], asked.figaroh)
    for name in filter(None, asked.gains.split(",")):
        begin = time.process_time()
        told(coverage_of_gains(DRIVEN[name], asked.seeds), time.process_time() - begin)
    for name in filter(None, asked.noise.split(",")):
        noisy(FORCED[name], asked.seeds)
    for name in filter(None, asked.said.split(",")):
        said(DRIVEN[name], asked.seeds)


if __name__ == "__main__":
    main()
