"""Controllers by one line: a linear law from measured signals to forces, and PID control of one signal."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from symdyn.arguments import native
from symdyn.errors import SimulateError
from symdyn.scene.values import Faults
from symdyn.simulation.equations.controller import Feedback, Size
from symdyn.simulation.equations.linear_law import LinearLaw, numbers_by_signal
from symdyn.simulation.prescribed import timed


@timed(SimulateError)
def linear_law(
    A: object,
    B: object,
    C: object,
    D: object,
    measures: str | Sequence[str],
    inputs: str | Sequence[str],
    *,
    period: float | None = None,
    y0: object = None,
    u0: object = None,
    reference: Mapping[str, object] | str | float | None = None,
    states: Sequence[str] = (),
) -> Feedback:
    """Return a linear controller with states, z: ż = A z + B (r - y), u = u0 + C z + D (r - y).

    Its states are integrated along with the motion, from 0 on; or, with a period, z' = A z + B (r - y) are those at the
    next sample, and u is held in between.

    >>> from symdyn.simulation import linear_law, simulate
    >>> import symdyn
    >>> lead = linear_law(-20, 1, -340, 20, "theta", "F")  # F = 20 (s + 3)/(s + 20) (0 - theta)
    >>> run = simulate(symdyn.example("cart_pole"), until=0.1, start={"theta": 0.1}, feedback=lead)
    >>> run["controller_x1"].shape
    (201,)

    Args:
        A: shape (n, n); n may be 0.
        B: shape (n, p).
        C: shape (m, n).
        D: shape (m, p).
        measures: the p signals y: names of coordinates, velocities, points' places or outputs, or formulas of these.
        inputs: names of the m drives or inputs of the scene.
        period: seconds between samples; None is none.
        y0: the signals where the law was designed, by name or in order; 0 where nothing is said.
        u0: forces or inputs there, likewise.
        reference: r by name of the signal, a number or formula; y0 where nothing is said.
        states: names of the n columns that show z; `controller_x1`, .. without.

    Raises:
        SimulateError: with every fault: matrices of other sizes, names that are not there.
    """
    faults = Faults("linear law")
    signals, driven = ((one,) if isinstance(one, str) else tuple(one) for one in (measures, inputs))
    law = LinearLaw.read({"A": A, "B": B, "C": C, "D": D}, signals, driven, faults)
    at, given = (
        numbers_by_signal(one, names, where, faults) for one, names, where in ((y0, signals, "y0"), (u0, driven, "u0"))
    )
    names = ((states,) if isinstance(states, str) else tuple(states)) or law.states
    if len(set(names)) != len(law.states):
        faults.add("states", f"{', '.join(names)} are not {len(law.states)} different names")
    faults.close(SimulateError)
    law = replace(
        law,
        y0=tuple(at.get(name, 0.0) for name in signals),
        initial=tuple(given.get(name, 0.0) for name in driven),
        states=names,
    )
    return Feedback(law, driven, period, measures=signals, reference=reference)


@timed(SimulateError)
def pid(
    measures: str,
    inputs: str,
    kp: float,
    ki: float = 0.0,
    kd: float = 0.0,
    *,
    reference: str | float = 0.0,
    filter: float | None = None,
    limits: Mapping[str, Size] | Size | None = None,
    antiwindup: bool | float = True,
    period: float | None = None,
) -> Feedback:
    """Return a PID controller of one signal: v = kp e + I + kd ė, İ = ki e, e = r - y; limits cut v to sat(v).

    The derivative is that of e through a filter of first order, which begins at rest: kd (e - f)/T, T ḟ = e - f. While
    a limit cuts the command the integral is held back by back calculation, İ = ki e + (sat(v) - v)/T_t. With a period
    the integral takes steps forward in time, the derivative differences backward. States are the columns
    `pid_integral`, I, and `pid_filter`.

    >>> import symdyn
    >>> pole = symdyn.pid("theta", "F", kp=60, ki=20, kd=8, limits=10)
    >>> run = symdyn.simulate(symdyn.example("cart_pole"), until=2, start={"theta": 0.2}, feedback=pole)
    >>> bool(abs(run["theta"][-1]) < 0.01), run["pid_integral"].shape
    (True, (201,))

    Args:
        measures: the signal y: a coordinate, velocity, point's place or output, or a formula of these.
        inputs: the drive, or input of the scene.
        kp: force a unit of e.
        ki: force a unit of e and second.
        kd: force a unit of ė.
        reference: r, a number or formula.
        filter: T, s; a tenth of the derivative time kd/kp without.
        limits: largest size of the force, or its smallest and largest value; by the name of the drive, too.
        antiwindup: T_t, s; True takes sqrt(kd/ki), kp/ki without a derivative, and one period at least; False none.
        period: seconds between samples; None is none.

    Raises:
        SimulateError: with every fault of the arguments, one line each.

    Reference: Åström and Hägglund, Advanced PID Control (2006), chapters 3 (filter, back calculation and its time) and
    13 (samples).
    """
    faults, times = Faults("pid"), {"filter": filter, "period": period}
    for name, x in {"kp": kp, "ki": ki, "kd": kd, **times, "antiwindup": antiwindup}.items():
        if x is not None and not math.isfinite(float(x)):
            faults.add(f"{name} = {x}", "give a finite number")
        elif x is not None and (name in times or (name == "antiwindup" and x is not False)) and not x > 0:
            faults.add(f"{name} = {x:g}", "give a time above 0, s")
    faults.close(SimulateError)
    (kp, ki, kd, period), h = native(float, kp, ki, kd, period), float(period or 0.0)
    T = float(filter) if filter is not None else abs(kd / kp) / 10 if kp else 0.0
    usual = math.sqrt(abs(kd / ki)) if ki and kd else abs(kp / ki) if ki else 0.0
    T_t = max(usual if antiwindup is True else float(antiwindup), h)
    if filter is not None and not kd:
        faults.add("filter", "is of the derivative; give kd too, or leave it out")
    if kd and not T > 0:
        faults.add("filter", f"kd = {kd:g} beside kp = {kp:g} tells no time of a filter; give one, s")
    if ki and limits is not None and antiwindup is True and not T_t > 0:
        faults.add("antiwindup", f"ki = {ki:g} alone tells no time in which the integral is to follow; give one, s")
    faults.close(SimulateError)
    back = 1 / T_t if antiwindup is not False and T_t else 0.0
    states = dict[str, tuple[float, ...]]()  # of each: A, B, C, D, its start over e, L
    if ki:
        states["pid_integral"] = (1.0, ki * h, 1.0, 0.0, 0.0, back * h) if h else (0.0, ki, 1.0, 0.0, 0.0, back)
    if kd and h:  # T/(T + h) D - kd/(T + h) e of the sample before
        states["pid_filter"] = (T / (T + h), -kd * h / (T + h) ** 2, 1.0, kd / (T + h), -kd / (T + h), 0.0)
    elif kd:
        states["pid_filter"] = (-1 / T, 1 / T, -kd / T, kd / T, 1.0, 0.0)
    A, B, C, D, start, L = np.array(list(states.values())).reshape(-1, 6, 1).swapaxes(0, 1)
    law = LinearLaw(np.diagflat(A), B, C.T, np.array([[kp + D.sum()]]), (0.0,), (0.0,), tuple(states), L, start)
    return Feedback(
        law, inputs, period, limits={} if limits is None else limits, measures=measures, reference=reference
    )
