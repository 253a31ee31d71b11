"""Plots of a trajectory: coordinates, velocities, driving forces and energies over time; svg, pdf, png or html."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from symdyn.algebra.numeric import Array
from symdyn.draw.canvas import import_matplotlib, saved, settings
from symdyn.dynamics.mechanism.state import quaternions
from symdyn.emit.escape import in_html
from symdyn.emit.render import render
from symdyn.errors import SimulateError
from symdyn.extras import install
from symdyn.simulation.integrate import importable
from symdyn.simulation.prescribed.forces import drive_names
from symdyn.simulation.record import write_whole
from symdyn.simulation.trajectory import Trajectory

ENDINGS = (".svg", ".pdf", ".png", ".html")

MONITORS = {
    "energy": "largest error of the energy balance, J",
    "energy_scale": "energy that moved, J",
    "loops": "largest residual of the loops, m or 1",
    "loop_rates": "largest velocity against the rows, m/s or rad/s",
    "quaternions": "largest error of a squared length of a quaternion",
    "momenta": "largest change of a conserved momentum",
    "normal_force": "smallest normal force, N",
    "friction_coefficient": "largest friction coefficient that is needed",
}
"""What the monitors of a run tell, in words; those of a contact have its name behind theirs."""

MOST_LINES = 12
"""Curves of one panel; further ones are left out, and the title says so."""


def check_plot(path: Path) -> None:
    """Raise SimulateError where a plot cannot be made: an ending that is not known, or no matplotlib."""
    if path.suffix.lower() not in ENDINGS:
        raise SimulateError(f"{path}: plots are written to {', '.join(ENDINGS)} files")
    if not importable("matplotlib"):
        raise SimulateError(f"plots need matplotlib; {install('plot')}")


def plot(trajectory: Trajectory, path: Path) -> None:
    """Write a plot of a trajectory.

    Raises:
        SimulateError: an ending that is not known, no matplotlib, or a file that cannot be written.
    """
    check_plot(path)
    kind = path.suffix.lower()
    picture = draw(trajectory, "svg" if kind == ".html" else kind[1:])
    write_whole(path, _page(trajectory, picture) if kind == ".html" else picture)


def panels(trajectory: Trajectory) -> list[tuple[str, list[tuple[str, Array]]]]:
    """Return title and curves of every panel."""
    scene, extra = trajectory.scene, trajectory.extra
    columns = [
        (
            f"coordinates, {'rad, m, or 1 for quaternions' if quaternions(scene) else 'rad or m'}",
            list(zip(scene.coordinates, trajectory.q.T, strict=True)),
        ),
        ("velocities, per s", list(zip(scene.velocities, trajectory.qd.T, strict=True))),
        ("driving forces, N m or N", list(zip(drive_names(scene), trajectory.tau.T, strict=True))),
    ]
    if not np.any(trajectory.tau):
        columns.pop()
    energies = [(name, extra[name]) for name in ("kinetic_energy", "potential_energy", "work") if name in extra]
    errors = [(name, extra[name]) for name in ("energy_error", "loop_error") if name in extra]
    columns += [("energies, J", energies)] if energies else []
    columns += [("errors: energy, J; loops, m or 1", errors)] if errors else []
    return columns


def draw(trajectory: Trajectory, kind: str) -> bytes:
    """Return the picture as "svg", "pdf" or "png"; the same trajectory, the same bytes."""
    parts = panels(trajectory)

    def fill(figure: Any) -> None:
        axes: Any = figure.subplots(len(parts), 1, sharex=True, squeeze=False)[:, 0]
        for axis, (title, curves) in zip(axes, parts, strict=True):
            for name, values in curves[:MOST_LINES]:
                axis.plot(trajectory.t, values, label=name, linewidth=1.0)
            more = len(curves) - MOST_LINES
            axis.set_title(title + (f" (and {more} more)" if more > 0 else ""), loc="left", fontsize=9)
            axis.grid(alpha=0.3)
            axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=8)
            for event in trajectory.events:
                axis.axvline(event.t, color="0.5", linewidth=0.6, linestyle=":")
        axes[-1].set_xlabel("t, s")

    return framed(trajectory.scene.name, (8.0, 2.2 * len(parts)), kind, fill)


def framed(title: str, size: tuple[float, float], kind: str, fill: Callable[[Any], None]) -> bytes:
    """Return a picture as "svg", "pdf" or "png" that `fill` draws on a figure, its size in inches."""
    import_matplotlib()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with settings({"svg.hashsalt": title, "svg.fonttype": "none", "font.size": 9.0}):
        figure = Figure(figsize=size, layout="constrained")
        FigureCanvasAgg(figure)
        fill(figure)
        figure.suptitle(title, x=0.01, ha="left")
        return saved(figure, kind, 150)


def _page(trajectory: Trajectory, svg: bytes) -> str:
    """Return a page that shows the plot and what is known of the run, without anything from elsewhere."""
    picture = svg.decode()
    picture = picture[picture.index("<svg") :]
    facts = [("scene", trajectory.scene.name)]
    if trajectory.method:
        facts += [
            ("method", f"{trajectory.method}, tolerances {trajectory.rtol:g} relative, {trajectory.atol:g} absolute"),
            ("steps", f"{trajectory.steps}"),
            ("ended by", trajectory.stopped),
        ]
    for name, value in trajectory.monitors.items():
        kind, _, contact = name.partition(" ")
        facts.append((MONITORS[kind] + (f", of {contact}" if contact else ""), f"{value:.3g}"))
    facts += [(f"event {event.formula}", f"t = {event.t!r} s") for event in trajectory.events]
    safe = [(in_html(name), in_html(text)) for name, text in facts]
    title = in_html(trajectory.scene.name)
    return render("plot/page.html.jinja", {"title": title, "picture": picture, "facts": safe})
