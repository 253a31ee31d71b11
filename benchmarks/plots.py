"""Time against the number of joints, and operations against time, as SVG."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt

Found = Mapping[str, Any]

SETTINGS = {"svg.hashsalt": "symdyn", "font.size": 9, "axes.grid": True, "grid.alpha": 0.3, "figure.dpi": 110}

LINES = {
    ("symdyn", "state"): ("symdyn, C", "C0", "-"),
    ("symdyn", "batch"): ("symdyn, batch", "C0", "--"),
    ("Pinocchio C++", "state"): ("Pinocchio C++", "C1", "-"),
    ("MuJoCo C", "state"): ("MuJoCo C", "C2", "-"),
    ("CasADi C", "state"): ("CasADi C", "C3", "-"),
    ("heyoka, our graph", "batch"): ("heyoka, batch", "C4", "--"),
    ("symdyn, NumPy module", "batch"): ("symdyn, NumPy module, batch", "C5", "--"),
}

NAMES = {"inverse_dynamics": "inverse dynamics", "mass_matrix": "M(q)", "forward_dynamics": "forward dynamics"}
NAMES |= {"gravity_forces": "gravity"}


def draw(found: Found, folder: Path) -> None:
    """Write both plots into a folder."""
    with plt.rc_context():
        matplotlib.rcdefaults()  # a matplotlibrc that lies about draws no part of them
        matplotlib.rcParams.update(SETTINGS)
        _save(_against_joints(found), folder / "time_against_n")
        _save(_against_operations(found), folder / "operations_against_time")


def _save(figure: Any, path: Path) -> None:
    figure.tight_layout()
    figure.savefig(path.with_suffix(".svg"), metadata={"Date": None})
    plt.close(figure)


def _against_joints(found: Found) -> Any:
    """Return time a state of chains of 2 to 64 joints, one panel an output."""
    figure, panels = plt.subplots(2, 2, figsize=(9, 7), sharex=True)
    for panel, (output, title) in zip(panels.flat, NAMES.items(), strict=True):
        for (peer, way), (label, colour, style) in LINES.items():
            points = sorted(
                (row["joints"], row["median"], *row["quartiles"])
                for row in found["times"]
                if row["robot"].startswith("chain") and (row["output"], row["peer"], row["way"]) == (output, peer, way)
            )
            if points:
                n, middle, low, high = zip(*points, strict=True)
                panel.plot(n, middle, style, color=colour, label=label, marker="o", markersize=3)
                panel.fill_between(n, low, high, color=colour, alpha=0.15, linewidth=0)
        panel.set(xscale="log", yscale="log", title=f"{title} of chains")
        panel.set_xticks([2, 4, 8, 16, 32, 64], [str(n) for n in (2, 4, 8, 16, 32, 64)])
        panel.minorticks_off()
    for panel in panels[:, 0]:
        panel.set_ylabel("ns a state")
    for panel in panels[1]:
        panel.set_xlabel("joints")
    if panels[0, 0].lines:
        panels[0, 0].legend(fontsize=7)
    return figure


def _against_operations(found: Found) -> Any:
    """Return operations against time of our code, every robot and output a point."""
    figure, panel = plt.subplots(figsize=(7, 4.5))
    for k, (output, title) in enumerate(NAMES.items()):
        for way, marker in (("state", "o"), ("batch", "^")):
            points = [
                (row["operations"], row["median"])
                for row in found["times"]
                if (row["output"], row["peer"], row["way"]) == (output, "symdyn", way)
            ]
            if points:
                label = f"{title}, {'C' if way == 'state' else 'batch'}"
                panel.plot(*zip(*points, strict=True), marker, color=f"C{k}", label=label, markersize=5, alpha=0.8)
    panel.set(xscale="log", yscale="log", xlabel="multiplications, additions and divisions", ylabel="ns a state")
    panel.legend(fontsize=7)
    return figure
