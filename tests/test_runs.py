"""A run as an object: columns by name, tables of other packages, CSV, and plots of what one wants to see."""

import io
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn import extras
from symdyn.cli import main
from symdyn.errors import DrawError, SceneError, SimulateError, SymdynError, UnknownNameError
from symdyn.scene import read, read_text
from symdyn.simulation import Trajectory, inverse, simulate
from symdyn.simulation.columns import columns
from symdyn.simulation.panels import _label, draw, panels
from symdyn.simulation.prescribed.formulas_in_time import Columns

EXAMPLES = Path(__file__).parents[1] / "examples"
ARM = EXAMPLES / "cart_pole.toml"


@pytest.fixture(scope="module")
def run() -> Trajectory:
    return simulate(
        ARM, forces="F=0.5*sin(t)", until=1.0, every=0.05, start="theta=0.2", method="dop853", reports="theta_dot"
    )


@pytest.mark.runs("cc")
def test_columns_come_by_name_and_a_wrong_name_is_told_the_right_one(run: Trajectory) -> None:
    assert np.array_equal(run["theta"], run.q[:, 1])
    assert np.array_equal(run["F"], run.tau[:, 0])
    assert np.array_equal(run["t"], run.t)
    assert run["energy_error"].shape == run.t.shape
    assert "theta" in run
    assert "thetta" not in run
    assert list(dict(run)) == list(run) == list(run.names)
    with pytest.raises(
        UnknownNameError, match=r"^cart_pole: there is no column thetta; did you mean theta\? \(there are t"
    ):
        run["thetta"]
    with pytest.raises(
        KeyError,
        match=r"^cart_pole: 3 is no name of a column; run.* there are t, ",
    ):
        run[3]  # type: ignore[index]
    assert np.array_equal(run[["theta", "F"]], np.stack([run.q[:, 1], run.tau[:, 0]], axis=1))
    assert run[[]].shape == (21, 0)
    with pytest.raises(UnknownNameError, match="there is no column thetta; did you mean theta"):
        run[["x", "thetta"]]
    assert issubclass(UnknownNameError, SymdynError)


@pytest.mark.runs("cc")
def test_a_run_is_a_data_frame_with_units(run: Trajectory) -> None:
    pytest.importorskip("pandas")
    frame = run.to_pandas()

    assert frame.index.name == "t"
    assert np.array_equal(frame.index, run.t)
    assert list(frame.columns) == list(run.names[1:])
    assert np.array_equal(frame["theta"], run["theta"])
    units = frame.attrs["units"]
    assert [units[name] for name in ("x", "theta", "theta_dot", "x_ddot", "F", "tau_theta", "work", "drive_power")] == [
        "m", "rad", "rad/s", "m/s^2", "N", "N m", "J", "W",
    ]  # fmt: skip
    assert (frame.attrs["scene"], frame.attrs["stopped"], frame.attrs["method"]) == ("cart_pole", "end", "dop853")


@pytest.mark.runs("cc")
def test_a_run_is_a_data_set_whose_variables_know_their_units(run: Trajectory) -> None:
    pytest.importorskip("xarray")
    found = run.to_xarray()

    assert found["t"].attrs == {"units": "s", "long_name": "time"}
    assert found["theta"].attrs == {"units": "rad", "long_name": "coordinates"}
    assert found["theta"].dims == ("t",)
    assert float(found["theta"].sel(t=1.0)) == run["theta"][-1]
    assert set(found.data_vars) == set(run.names[1:])
    assert all(isinstance(value, (str, float, int)) for value in found.attrs.values())  # so that netCDF takes them


@pytest.mark.runs("cc")
def test_csv_reads_back_to_the_same_digits_here_and_where_it_is_given_as_a_motion(
    run: Trajectory, tmp_path: Path
) -> None:
    assert run.to_csv(tmp_path / "run.csv") == str(tmp_path / "run.csv")
    text = run.to_csv()
    assert (tmp_path / "run.csv").read_text() == text
    assert run.to_csv(held := io.StringIO()) == ""
    assert held.getvalue() == text
    back = Columns.read(tmp_path / "run.csv")
    assert np.array_equal(back.values["theta"], run["theta"])
    assert np.abs(inverse(ARM, str(tmp_path / "run.csv"), run.t)["F"] - run["F"]).max() < 1e-9
    with pytest.raises(SymdynError, match=r"there is no folder"):
        run.to_csv("/dev/null/run.csv")


@pytest.mark.runs("cc")
def test_a_file_that_takes_no_text_is_told(run: Trajectory) -> None:
    for file in (io.BytesIO(), 5):
        with pytest.raises(symdyn.SymdynError, match="takes no text"):
            run.to_csv(file)  # type: ignore[arg-type]


@pytest.mark.runs("cc")
@pytest.mark.parametrize("package", ["pandas", "xarray"])
def test_a_package_that_is_missing_is_told_with_the_way_out(
    run: Trajectory, monkeypatch: pytest.MonkeyPatch, package: str
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(SimulateError, match=rf"^to_{package}\(\) needs {package}, .*; pip install {package}, or take "):
        getattr(run, f"to_{package}")()


@pytest.mark.runs("cc")
def test_plots_without_matplotlib_are_told_the_command(run: Trajectory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(extras, "find_spec", lambda name: None)
    with pytest.raises(SimulateError, match=r'^plots need matplotlib; pip install "symdyn\[plot\]"$'):
        run.plot()


@pytest.mark.runs("cc")
def test_every_axis_of_a_plot_has_one_unit_and_forces_that_are_zero_are_left_out(run: Trajectory) -> None:
    pytest.importorskip("matplotlib")
    axes = run.plot().axes

    assert [axis.get_title(loc="left") for axis in axes] == [
        "coordinates, m", "coordinates, rad", "velocities, m/s", "velocities, rad/s", "driving forces, N",
        "energies, J",
    ]  # fmt: skip
    assert not any(panel.mixed for panel in panels(run))
    labels = [[line.get_label() for line in axis.get_lines() if line.get_label()[0] != "_"] for axis in axes]
    assert labels[:5] == [["$x$"], [r"$\theta$"], [r"$\dot x$"], [r"$\dot{\theta}$"], ["$F$"]]
    assert labels[5] == ["kinetic energy", "potential energy", "work"]
    still = simulate(ARM, until=0.1, start="theta=0.2", method="dop853")
    assert not any("forces" in panel.title for panel in panels(still))
    rest = simulate(ARM, until=0.1, method="dop853")
    assert not rest.q.any()
    assert [panel.title for panel in panels(rest)][:2] == ["coordinates, m", "coordinates, rad"]


@pytest.mark.runs("cc")
def test_columns_of_a_plot_are_chosen_by_name_and_by_pattern_also_where_they_are_zero(run: Trajectory) -> None:
    found = panels(run, ["theta", "tau_*", "theta", "x", "point_tip_?"])
    assert [(panel.title, [one.column.name for one in panel.curves]) for panel in found] == [
        ("coordinates, rad", ["theta"]), ("driving forces, N m", ["tau_theta"]),
        ("coordinates, points, m", ["x", "point_tip_x", "point_tip_y", "point_tip_z"]),
    ]  # fmt: skip
    assert [panel.title for panel in panels(run, ["x_ddot", "energy_error"])] == [
        "accelerations, m/s²", "error of the energy balance, J",
    ]  # fmt: skip
    assert found[2].curves[1].label == r"$x_{\mathrm{tip}}$"
    with pytest.raises(UnknownNameError, match="there is no column thetta; did you mean theta"):
        run.plot("x", "thetta")
    with pytest.raises(UnknownNameError, match=r"there is no column q\*; there are"):
        run.plot(["q*"])
    with pytest.raises(UnknownNameError, match=r"names = .*: give"):
        run.plot(3)  # type: ignore[arg-type]


@pytest.mark.runs("cc")
def test_panels_are_those_that_a_user_groups_with_titles_of_their_own(run: Trajectory) -> None:
    found = panels(run, [["x", "theta"], ["point_tip_x"], ["point_tip_y"], "theta_dot"])
    assert [panel.title for panel in found] == [
        "coordinates, m and rad", "point tip x, m", "point tip y, m", "velocities, rad/s",
    ]  # fmt: skip
    pytest.importorskip("matplotlib")
    first = run.plot([["x", "theta"]]).axes[0]
    assert [line.get_label() for line in first.get_lines()] == ["$x$, m", r"$\theta$, rad"]


@pytest.mark.runs("cc")
def test_reactions_are_drawn_where_a_run_has_them_but_for_those_that_are_zero() -> None:
    pulled = simulate(ARM, forces="F=1", until=0.1, start="theta=0.2", method="dop853", reactions=True)
    drawn = {panel.title: [one.column.name for one in panel.curves] for panel in panels(pulled)}
    assert drawn["reactions, N"] == [f"reaction_{name}_f{axis}" for name in ("rail", "hinge") for axis in "xy"]
    assert "reactions, N m" in drawn or not np.abs(pulled["reaction_rail_mz"]).max() > 1e-9
    back = inverse(ARM, pulled, pulled.t, reactions=True)
    assert [panel.title for panel in panels(back)].count("reactions, N") == 1


@pytest.mark.runs("cc")
def test_plots_fit_a_column_and_a_slide_and_go_into_axes_of_others(run: Trajectory) -> None:
    plt = pytest.importorskip("matplotlib.pyplot")
    sizes = [run.plot("x", "theta", width=width).get_size_inches() for width in (None, "column", "slide", 4.0)]
    assert [width for width, _ in sizes] == [8.0, 3.3, 11.0, 4.0]
    letters = [run.plot("x", width=w).axes[0].get_legend().get_texts()[0].get_size() for w in (None, "column", "slide")]
    assert letters == [9.0, 7.0, 16.0]
    with pytest.raises(SimulateError, match=r'width = "poster": write "column", "slide" or inches'):
        run.plot("x", width="poster")
    with pytest.raises(SimulateError, match=r"width = 0 in: give 1 to 50"):
        run.plot("x", width=0)
    mine, axes = plt.subplots(2, 1)
    assert run.plot("x", "theta", axes=axes) is mine
    assert [len(axis.get_lines()) for axis in axes] == [1, 1]
    for wrong in (axes, axes[0], 3, [3, 4]):
        with pytest.raises(DrawError, match=r"^axes: give (one|2) axes of matplotlib, such as pyplot.subplots"):
            run.plot("x", *([] if wrong is axes else ["theta"]), axes=wrong)
    plt.close(mine)


@pytest.mark.runs("cc")
def test_energies_far_from_zero_are_counted_from_their_least_value() -> None:
    """A pendulum that hangs 1 km up moves by millijoules; nearer to zero its energy is drawn as it is."""
    text = (EXAMPLES / "pendulum.toml").read_text()
    high = simulate(read_text(text), until=1.0, start="q1=1e-2", method="dop853", values={"g": 9.81})
    (energies,) = [panel for panel in panels(high) if panel.title == "energies, J"]
    potential = energies.curves[1]

    assert potential.zero == high["potential_energy"].min()
    assert np.array_equal(potential.values, high["potential_energy"] - potential.zero)
    assert potential.label == f"potential energy + {-potential.zero:.5g} J"
    assert energies.curves[0].zero == 0.0
    (alone,) = panels(high, ["potential_energy"])
    assert np.array_equal(alone.curves[0].values, high["potential_energy"])
    swinging = simulate(ARM, until=2.0, start="theta=0.2", method="dop853")
    (near,) = [panel for panel in panels(swinging) if panel.title == "energies, J"]
    assert [one.zero for one in near.curves] == [0.0] * len(near.curves)


@pytest.mark.runs("cc")
@pytest.mark.long(0)
def test_no_name_of_a_scene_breaks_a_plot_or_becomes_mathematics() -> None:
    pytest.importorskip("matplotlib")
    names = ["lambda1", "a__b", "x_", "Ixx1", "theta_left", "I1xx", "epsilon", "Upsilon", "ab", "m_1_dot_x", "tau99"]
    text = 'name = "odd"\n'
    for k, name in enumerate(names):
        text += (
            f'[bodies.b{k}]\nmass = 1\ncom = [0, 0, 0]\n[joints.j{k}]\ntype = "prismatic"\nparent = "ground"\n'
            f'child = "b{k}"\naxis = [1, 0, 0]\ncoordinate = "{name}"\n'
        )
    scene = read_text(text)
    t, zeros = np.linspace(0, 1, 5), np.ones((5, len(names)))
    made = Trajectory(scene, t, zeros, zeros, zeros, zeros)
    figure = made.plot("*")
    for panel in panels(made, ["*"]):
        assert all(_label(one) == one.label for one in panel.curves), panel
    assert b"<svg" in draw(made, "svg")
    hostile = replace(made, scene=replace(scene, name=r"$x^2$ <b>&amp; \frac"))  # which no reader lets through
    picture = draw(hostile, "svg").decode()
    assert "$x^2$ &lt;b&gt;&amp;amp; \\frac" in picture
    assert len(figure.axes) == 4


@pytest.mark.runs("cc")
def test_a_coordinate_that_is_called_work_has_its_column_and_the_work_another() -> None:
    scene = read_text(
        'name = "w"\n[bodies.b]\nmass = 1\ncom = [0, 0, 0]\n[joints.j]\ntype = "prismatic"\nparent = "ground"\n'
        'child = "b"\naxis = [1, 0, 0]\ncoordinate = "work"\nstart_rates = 1\n'
    )
    run = simulate(scene, forces="work=3", until=1.0, method="dop853")
    assert run["work"][-1] == pytest.approx(2.5)
    assert run["work_"][-1] == pytest.approx(7.5)
    assert [one.unit for one in run.columns if one.name in ("work", "work_")] == ["m", "J"]
    assert len(set(run.names)) == len(run.names)
    assert np.abs(inverse(scene, run, run.t)["tau1"] - 3.0).max() < 1e-9


DRIVEN = (
    'name = "w"\n[inputs.u]\nunit = "UNIT"\n[bodies.b]\nmass = 1\ncom = [0, 0, 0]\n[joints.j]\n'
    'type = "prismatic"\nparent = "ground"\nchild = "b"\naxis = [1, 0, 0]\nforce = "u"\ndrive = false\n'
)


@pytest.mark.runs("cc")
def test_units_of_a_stranger_are_text() -> None:
    """No file has such a unit; a scene that somebody puts together of its nouns may."""
    pytest.importorskip("matplotlib")
    scene = read_text(DRIVEN.replace("UNIT", "N"))
    (u,) = scene.inputs
    run = simulate(scene, forces="u=1", until=1.0, method="dop853")
    run = replace(run, scene=replace(scene, inputs=(replace(u, unit="$\\frac <b>"),)))
    assert b"<!-- inputs, $\\frac &lt;b&gt; -->" in draw(run, "svg", ["u"])
    assert run.to_pandas().attrs["units"]["u"] == "$\\frac <b>"


@pytest.mark.parametrize("unit", ["$\\\\frac <b>", "N</text>", "N\\u202e", "\\\\kg", "N;x", "N\\u0000"])
def test_a_hostile_unit_is_refused(unit: str) -> None:
    with pytest.raises(SceneError, match=r"is no unit|unprintable"):
        read_text(DRIVEN.replace("UNIT", unit))


@pytest.mark.runs("cc")
@pytest.mark.long(0)
def test_a_notebook_shows_the_figure(run: Trajectory) -> None:
    pytest.importorskip("matplotlib")
    formatters = pytest.importorskip("IPython.core.formatters")
    figure = run.plot("theta")
    figure.axes[0].set_title("mine")
    shown, _ = formatters.DisplayFormatter().format(figure)
    assert "mine" in shown["image/svg+xml"]
    assert shown["image/svg+xml"].startswith("<?xml")
    assert figure._repr_mimebundle_() == figure._repr_mimebundle_()  # the same bytes


@pytest.mark.runs("cc")
def test_units_of_reactions_multipliers_and_momenta_are_known() -> None:
    disc = read(EXAMPLES / "rolling_disc.toml")
    names = [
        "reaction_flight_fx", "reaction_flight_my_joint", "multiplier_contact_normal", "multiplier_hinge_mx_joint",
        "multiplier_slip", "momentum_flight_Px", "momentum_flight_Ly", "momentum_flight_wx", "loop_rate_error",
    ]  # fmt: skip
    found = columns(disc, names)[-len(names) :]
    assert [one.unit for one in found] == [
        "N", "N m", "N", "N m", "", "kg m/s", "kg m^2/s", "kg m^2/s", "m/s or rad/s",
    ]  # fmt: skip


@pytest.mark.runs("cc")
@pytest.mark.long(0)
def test_the_shell_picks_columns_and_tells_a_wrong_one_before_it_computes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("matplotlib")
    picture, table = tmp_path / "run.svg", tmp_path / "run.csv"
    command = ["simulate", str(ARM), "--until", "0.2", "--start", "theta=0.2", "--method", "dop853", "-o", str(table)]
    assert main([*command, "--plot", str(picture), "--plot-columns", "theta,point_tip_*"]) == 0
    text = picture.read_text()
    assert "<text" not in text  # outlines, which every program draws alike, dots above letters as well
    assert "<!-- points, m -->" in text
    assert "velocities" not in text
    assert main([*command, "--plot", str(picture), "--plot-columns", "theta+point_tip_x, x_dot"]) == 0
    assert "<!-- coordinates, points, rad and m -->" in picture.read_text()
    assert "<!-- velocities, m/s -->" in picture.read_text()
    capsys.readouterr()

    table.unlink()
    assert main([*command, "--plot", str(picture), "--plot-columns", "theta,thetta"]) == 1
    assert "--plot-columns: cart_pole: there is no column thetta; did you mean theta" in capsys.readouterr().err
    assert not table.exists()
    assert main([*command, "--plot-columns", "theta"]) == 1
    assert "--plot-columns: of --plot, which is not given" in capsys.readouterr().err
    assert main([*command, "--plot", str(picture), "--plot-columns", "reaction_*"]) == 1  # which --reactions would have
    assert "there is no column reaction_*" in capsys.readouterr().err
    assert table.exists()


@pytest.mark.runs
@pytest.mark.long(0)
def test_matplotlib_and_pandas_are_imported_when_they_are_asked_for() -> None:
    code = (
        "import sys, symdyn\n"
        f"run = symdyn.simulate({str(ARM)!r}, until=0.1, method='dop853')\n"
        "run['theta'], run.to_csv(), run.columns\n"
        "print([name for name in ('pandas', 'xarray', 'matplotlib') if name in sys.modules])"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout == "[]\n", found.stdout
    assert symdyn.simulate is simulate
