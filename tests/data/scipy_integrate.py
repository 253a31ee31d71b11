"""Runge and Kutta's classical method at steps of 0.01, under the name of SciPy's door."""

from types import SimpleNamespace

import numpy as np


def solve_ivp(f, span, y0, method="", t_eval=None, **settings):
    """Return t and y, shape (n, N), at the times asked for, or at 401 of them."""
    begin, end = map(float, span)
    times = np.linspace(begin, end, 401).tolist() if t_eval is None else [float(t) for t in t_eval]
    t, y, rows = begin, [float(x) for x in y0], []

    def rate(t, y, by, before):
        return [float(x) for x in f(t, np.asarray([x + by * v for x, v in zip(y, before, strict=True)]))]

    for to in times:
        for left in range(int(abs(to - t) / 0.01) + 1, 0, -1):
            h = (to - t) / left
            a = rate(t, y, 0.0, y)
            b = rate(t + h / 2, y, h / 2, a)
            c = rate(t + h / 2, y, h / 2, b)
            d = rate(t + h, y, h, c)
            y = [x + h / 6 * (i + 2 * j + 2 * k + m) for x, i, j, k, m in zip(y, a, b, c, d, strict=True)]
            t += h
        rows.append(y)
    found = {"t_events": None, "y_events": None, "success": True, "status": 0, "message": ""}
    return SimpleNamespace(t=np.asarray(times), y=np.asarray(rows).T, **found)
