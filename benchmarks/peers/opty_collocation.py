"""opty's side of `benchmarks/collocation.py`: problems as its examples write them, timed when a line on stdin asks.

Run by an interpreter that has opty and cyipopt, which need not have symdyn. Input is a line: a problem, a rule and a
task (build, time or solve); the answer is a line of JSON.

The pendulums are opty's examples beginner/plot_pendulum_swing_up_fixed_duration.py and …_variable_duration.py; the
cart-pole is written in the same way, with the equations (6.1) and (6.2) of Kelly's paper.
"""

import inspect
import json
import sys
import time
from statistics import median

import numpy as np
import sympy as sm
from opty import Problem, create_objective_function

NODES = 501
RULES = {"backward_euler": "backward euler", "implicit_midpoint": "midpoint"}


def fixed_pendulum(rule):  # noqa: D103
    duration = 10.0
    I, m, g, d, t = sm.symbols("I, m, g, d, t")  # noqa: E741
    theta, omega, T = sm.symbols("theta, omega, T", cls=sm.Function)
    eom = sm.Matrix([theta(t).diff() - omega(t), I * omega(t).diff() + m * g * d * sm.sin(theta(t)) - T(t)])
    states, step = (theta(t), omega(t)), duration / (NODES - 1)
    cost = sm.Integral(T(t) ** 2, t)
    obj, obj_grad = create_objective_function(cost, states, (T(t),), (), NODES, step, rule, time_symbol=t)
    return Problem(
        obj,
        obj_grad,
        eom,
        states,
        NODES,
        step,
        known_parameter_map={I: 1.0, m: 1.0, g: 9.81, d: 1.0},
        instance_constraints=(theta(0.0), theta(duration) - np.pi, omega(0.0), omega(duration)),
        bounds={T(t): (-2.0, 2.0)},
        time_symbol=t,
        integration_method=rule,
    )


def free_pendulum(rule):  # noqa: D103
    m, g, d, t, h = sm.symbols("m, g, d, t, h", real=True)
    theta, omega, T = sm.symbols("theta, omega, T", cls=sm.Function)
    eom = sm.Matrix([theta(t).diff() - omega(t), m * d**2 * omega(t).diff() + m * g * d * sm.sin(theta(t)) - T(t)])

    def obj(prob, free):
        _, T_vals, _, h_val = prob.parse_free(free)
        return h_val * np.sum(T_vals**2)

    def obj_grad(prob, free):
        T_vals = prob.extract_values(free, T(t))
        h_val = prob.extract_values(free, h)
        grad = np.zeros_like(free)
        prob.fill_free(grad, 2.0 * h_val * T_vals, T(t))
        prob.fill_free(grad, np.sum(T_vals**2), h)
        return grad

    last = (NODES - 1) * h
    return Problem(
        obj,
        obj_grad,
        eom,
        (theta(t), omega(t)),
        NODES,
        h,
        known_parameter_map={m: 1.0, g: 9.81, d: 1.0},
        instance_constraints=(theta(0 * h), theta(last) - np.pi, omega(0 * h), omega(last)),
        bounds={T(t): (-2.0, 2.0), h: (0.0, 0.5)},
        time_symbol=t,
        integration_method=rule,
    )


def cart_pole(rule):  # noqa: D103
    duration = 2.0
    m1, m2, l, g, t = sm.symbols("m1, m2, l, g, t")  # noqa: E741
    q1, q2, v1, v2, u = sm.symbols("q1, q2, v1, v2, u", cls=sm.Function)
    s, c = sm.sin(q2(t)), sm.cos(q2(t))
    eom = sm.Matrix(
        [
            q1(t).diff() - v1(t),
            q2(t).diff() - v2(t),
            (m1 + m2 * s**2) * v1(t).diff() - l * m2 * s * v2(t) ** 2 - u(t) - m2 * g * c * s,
            l * (m1 + m2 * s**2) * v2(t).diff() + l * m2 * c * s * v2(t) ** 2 + u(t) * c + (m1 + m2) * g * s,
        ]
    )
    start = (q1(0.0), q2(0.0), v1(0.0), v2(0.0))
    end = (q1(duration) - 1.0, q2(duration) - np.pi, v1(duration), v2(duration))
    states, step = (q1(t), q2(t), v1(t), v2(t)), duration / (NODES - 1)
    cost = sm.Integral(u(t) ** 2, t)
    obj, obj_grad = create_objective_function(cost, states, (u(t),), (), NODES, step, rule, time_symbol=t)
    return Problem(
        obj,
        obj_grad,
        eom,
        states,
        NODES,
        step,
        known_parameter_map={m1: 1.0, m2: 0.3, l: 0.5, g: 9.81},
        instance_constraints=start + end,
        bounds={u(t): (-20.0, 20.0), q1(t): (-2.0, 2.0)},
        time_symbol=t,
        integration_method=rule,
    )


PROBLEMS = {"fixed_pendulum": fixed_pendulum, "free_pendulum": free_pendulum, "cart_pole": cart_pole}
ENDS = {"fixed_pendulum": [np.pi, 0], "free_pendulum": [np.pi, 0], "cart_pole": [1.0, np.pi, 0, 0]}
STEP = {"free_pendulum": 0.02}
"""Guess of the time step where it is free: 10 s in all."""


def guess(name, prob):
    """Return a straight way from the start to the end, free of forces."""
    free = np.zeros(prob.num_free)
    for k, end in enumerate(ENDS[name]):
        free[k * NODES : (k + 1) * NODES] = np.linspace(0, end, NODES)
    if name in STEP:
        free[-1] = STEP[name]
    return free


def timed(call, at):
    """Return seconds of a call, the median of ten groups of twenty."""
    groups = []
    for _ in range(10):
        began = time.process_time()
        for _ in range(20):
            call(at)
        groups.append((time.process_time() - began) / 20)
    return median(groups)


def answer(name, rule, task, made):
    """Return what a line asks for."""
    if (name, rule) not in made:
        began = time.perf_counter()
        prob = PROBLEMS[name](RULES[rule])
        at = guess(name, prob) + 0.01
        prob.con(at), prob.con_jac(at)
        made[name, rule] = prob, time.perf_counter() - began
    prob, built = made[name, rule]
    if task == "build":
        lines = len(inspect.getsource(PROBLEMS[name]).splitlines())
        return {"seconds": built, "unknowns": prob.num_free, "rows": prob.num_constraints, "lines": lines}
    if task == "time":
        at = guess(name, prob) + 0.01
        return {"residual": timed(prob.con, at), "jacobian": timed(prob.con_jac, at)}
    prob.add_option("print_level", 0)
    prob.add_option("sb", "yes")
    prob.add_option("max_iter", 1000)
    began = time.process_time()
    _, info = prob.solve(guess(name, prob))
    wall = time.process_time() - began
    return {
        "seconds": wall,
        "iterations": len(prob.obj_value),
        "objective": float(info["obj_val"]),
        "status": info["status_msg"].decode()[:40],
    }


def main():
    """Answer line by line."""
    made = {}
    for line in sys.stdin:
        print(json.dumps(answer(*line.split(), made)), flush=True)


if __name__ == "__main__":
    main()
