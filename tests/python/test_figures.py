"""Figures in the common style and in display units; tables of results in notebooks."""

import subprocess
import sys

import matplotlib
import numpy as np
import pytest

import foldwing as fw

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402

from foldwing.style import PALETTE  # noqa: E402

BARE, WINDY, GOLAND = "examples/turbine/nrel_5mw.toml", "examples/turbine/nrel_5mw_wind.toml", "examples/models/goland_wing.toml"


@pytest.fixture(autouse=True)
def closed():
    yield
    pyplot.close("all")


def curves(axes):
    """Curves of a panel by label."""
    return {line.get_label(): line for line in axes.get_lines() if line.get_gid() == "curve"}


def test_runs_are_drawn_in_degrees_and_strains_in_um_m(wing):
    run = wing.simulate(0.2, outputs=["fold.angle", "fold.angular_velocity", "gauge.root.strain", "tip.position", "fold.latch_time"])
    figure = run.plot(["fold.angle", "fold.angular_velocity", "gauge.root.strain", "tip.position"])
    panels = figure.axes
    assert [panel.get_ylabel() for panel in panels] == ["fold.angle (deg)", "fold.angular_velocity (deg/s)", "gauge.root.strain (µm/m)", "position (m)"]
    assert np.allclose(curves(panels[0])["fold.angle"].get_ydata(), np.degrees(run["fold.angle"]), rtol=1e-15)
    assert np.allclose(curves(panels[2])["gauge.root.strain"].get_ydata(), 1e6 * run["gauge.root.strain"], rtol=1e-15)
    position = curves(panels[3])
    assert list(position) == ["tip.position.x", "tip.position.y", "tip.position.z"]
    assert [line.get_color() for line in position.values()] == list(PALETTE[:3])
    # labels at the ends, in the colours of their curves, and a mark where the latch closes
    texts = {text.get_text(): text.get_color() for text in panels[3].texts}
    assert texts == {name: line.get_color() for name, line in position.items()}
    marks = [line for line in panels[0].get_lines() if line.get_gid() is None]
    assert [mark.get_xdata()[0] for mark in marks] == run.latch_times() and len(marks) == 1
    assert panels[-1].get_xlabel() == "time (s)" and panels[0].get_title(loc="left") == "FoldingWing"
    assert not panels[0].spines["top"].get_visible() and pyplot.rcParams["axes.spines.top"], "the style is that of the figure alone"
    _, own = pyplot.subplots()
    assert run.plot("fold.angle", axes=own) is own.figure and list(curves(own)) == ["fold.angle"]
    with pytest.raises(fw.UsageError, match="axes: 2 axes for 3 panels; give one for all, or 3"):
        run.plot(["fold.angle", "gauge.root.strain", "tip.position"], axes=pyplot.subplots(2)[1])
    with pytest.raises(fw.UsageError, match="plot: none of 'fold.release' was recorded"):
        run.plot("fold.release")


def test_equilibria_and_modes_are_drawn(wing):
    rest = wing.static(settings={"fold.release": False})
    above, side = rest.plot().axes
    assert np.array_equal(curves(above)["outer"].get_ydata(), rest.shape("outer")[:, 2])
    assert np.array_equal(curves(side)["outer"].get_xydata(), rest.shape("outer")[:, :2]) and side.get_xlabel() == "x (m)"
    modes = wing.modes(4, settings={"fold.release": False})
    (panel,) = modes.plot().axes
    points = np.array([line.get_xydata()[0] for line in panel.get_lines()])
    assert np.allclose(points, np.column_stack([modes.frequency_Hz, 100.0 * modes.damping_ratio]))
    assert [text.get_text() for text in panel.texts] == ["1", "2", "3", "4"] and panel.get_ylabel() == "damping ratio (%)"


def test_flutter_is_drawn_with_its_speed():
    goland = fw.load(GOLAND)
    found = goland.flutter([120.0, 130.0, 140.0], count=2)
    damping, frequency = found.plot().axes
    assert np.allclose(curves(damping)["mode 2"].get_ydata(), 100.0 * found.damping_ratio[:, 1], equal_nan=True)
    assert np.allclose(curves(frequency)["mode 1"].get_ydata(), found.frequency_Hz[:, 0], equal_nan=True)
    assert "flutter 137.4 m/s" in [text.get_text() for text in damping.texts]
    over = goland.flutter_map("aero.density", [1.0, 1.225], [120.0, 160.0], count=2)
    (panel,) = over.plot().axes
    assert np.array_equal(curves(panel)["flutter"].get_xydata(), np.column_stack([over.values, over.flutter_m_s]))
    assert list(curves(panel)) == ["flutter"] and panel.get_xlabel() == "aero.density"


def test_rotors_are_drawn():
    bare = fw.load(BARE)
    diagram = bare.campbell([0.0, 6.0, 12.0], undeformed=True, count=4)
    (panel,) = diagram.plot().axes
    assert np.array_equal(curves(panel)[diagram.motions[3]].get_ydata(), diagram.frequency_Hz[:, 3])
    assert {"1P", "3P", "6P"} <= {text.get_text() for text in panel.texts} and panel.get_xlabel() == "rotor speed (rpm)"
    turn = bare.periodic(12.1, steps=144, count=0, outputs=["body.blade1.deflection.*", "yaw.angular_velocity"])
    angle = ["yaw.angular_velocity"]
    (panel,) = turn.plot(angle).axes
    assert panel.get_ylabel() == f"{angle[0]} (deg/s)" and panel.get_xlabel() == "rotation of the shaft (deg)"
    assert np.allclose(curves(panel)[angle[0]].get_ydata(), np.degrees(turn[angle[0]]), rtol=1e-15)
    with pytest.raises(fw.UsageError, match="plot: none of the outputs matches 'tip'"):
        turn.plot("tip")
    settings = {"gravity": [0.0, 0.0, 0.0]}
    points = fw.load(WINDY).operating_points([7.0, 8.0], speed_rpm=9.0, settings=settings, steps=144, tolerance=1e-3)
    power, thrust, torque = points.plot().axes
    assert (power.get_ylabel(), torque.get_ylabel()) == ("rotor.power (W)", "rotor.torque (N·m)")
    assert np.array_equal(thrust.get_lines()[0].get_ydata(), points["rotor.thrust"])


def test_frequency_responses_are_drawn(wing):
    model = wing.linearize(inputs="load.outer[4].force.z", outputs=["tip.position.z", "gauge.root.strain"], settings={"fold.release": False})
    at_Hz = np.geomspace(0.5, 50.0, 40)
    response = model.frequency_response(at_Hz)
    control = model.to_control()
    assert np.allclose(response[:, 0, 0], [control(2j * np.pi * f)[0, 0] for f in at_Hz], rtol=1e-9)
    gain, phase = model.plot(at_Hz).axes
    assert np.allclose(curves(gain)["tip.position.z"].get_ydata(), np.abs(response[:, 0, 0]))
    assert np.allclose(np.exp(1j * np.radians(curves(phase)["tip.position.z"].get_ydata())), response[:, 0, 0] / np.abs(response[:, 0, 0]))
    assert gain.get_yscale() == gain.get_xscale() == "log" and phase.get_ylabel() == "phase (deg)"
    sampled = model.discretize(1e-3)
    # at low frequencies the sampled model is the continuous one with a delay of half a step due to the hold
    slow = np.array([0.5, 1.0])
    hold = np.exp(-1j * np.pi * slow * 1e-3)
    assert np.allclose(sampled.frequency_response(slow)[:, 0, 0], model.frequency_response(slow)[:, 0, 0] * hold, rtol=1e-4)
    # an input without effect: the hinge is locked
    still = wing.linearize(inputs="fold.external_torque", outputs="tip.position.z", settings={"fold.release": False})
    assert not np.any(still.frequency_response(at_Hz)) and len(still.plot(at_Hz).axes) == 2
    assert len(model.plot().axes) == 2 and len(sampled.plot().axes) == 2


def test_sweeps_are_drawn_in_degrees(wing):
    table = wing.sweep({"fold.start_angle": [1.0, 0.5, 2.0]}, stop=0.05, outputs="fold.angle")
    (panel,) = table.plot("fold.start_angle", "fold.angle").axes
    order = [1, 0, 2]
    expected = np.degrees(np.column_stack([table["fold.start_angle"], table["fold.angle"]]))[order]
    assert np.allclose(curves(panel)["fold.angle"].get_xydata(), expected) and panel.get_xlabel() == "fold.start_angle (deg)"
    assert [axes.get_ylabel() for axes in table.plot("fold.start_angle").axes] == [
        "fold.angle (deg)", "fold.first_latch_time (s)", "gauge.root.strain.peak (µm/m)"
    ]  # fmt: skip
    with pytest.raises(fw.UsageError, match="plot: fold.angel is not a column; columns are variant"):
        table.plot("fold.start_angle", "fold.angel")
    with pytest.raises(fw.UsageError, match="plot: message has no numbers|plot: status has no numbers"):
        table.plot("status")


def test_results_are_tables_in_notebooks(wing):
    held = {"fold.release": False}
    goland = fw.load(GOLAND)
    run = wing.simulate(0.2, outputs=["fold.angle", "fold.latch_time"])
    shown = {
        "a model": (wing, ["FoldingWing", "<td style='text-align:left'>fold.external_torque</td>", "more rows"]),
        "a run": (run, ["fold.angle", "<td style='text-align:left'>rad</td>", f"latched at {run.latch_times()[0]:.6g} s"]),
        "an equilibrium": (wing.static(settings=held), ["static equilibrium, stable", "170", "deg"]),
        "modes": (wing.modes(2, settings=held), ["frequency (Hz)", "flap"]),
        "flutter": (goland.flutter([130.0, 140.0], count=2), ["flutter", "137.405"]),
        "a map": (goland.flutter_map("aero.density", [1.225], [130.0, 140.0], count=2), ["aero.density", "137.405"]),
        "a sweep": (wing.sweep({"fold.start_angle": [1.0, 2.0]}, stop=0.01), ["2 variants, 0 failed", "fold.start_angle"]),
        "a trim": (fw.load("examples/models/flared_wing_tip.toml").trim("wind.velocity.z", {"root.force.z": 0.0}), ["solved", "wind.velocity.z"]),
        "a linear model": (wing.linearize(inputs="fold.external_torque", outputs="tip.position.z", settings=held), ["LinearModel", "tip.position.z"]),
        "a diagram": (fw.load(BARE).campbell([0.0, 6.0], undeformed=True, count=2), ["rotor speed (rpm)", "shaft, free"]),
    }
    for what, (result, words) in shown.items():
        html = result._repr_html_()
        assert html.count("<table>") == html.count("</table>") == 1 and "nan" not in html, what
        for word in words:
            assert word in html, (what, word)
    named = fw.Model.from_dict({
        "name": "Beam", "description": "<b>bold</b> & more",
        "section": {"s": dict(shape="rectangle", width_m=0.1, height_m=0.004, density_kg_m3=1600, youngs_modulus_Pa=60e9, poisson_ratio=0.3)},
        "body": {"beam": {"length_m": 0.5, "section": "s", "elements": 2}},
        "joint": {"mount": {"type": "clamped", "parent": "root", "child": "beam"}},
    })  # fmt: skip
    assert "&lt;b&gt;bold&lt;/b&gt; &amp; more" in named._repr_html_()


def test_figures_without_matplotlib_name_the_package(tmp_path):
    """The message names the missing package and how to install it."""
    (tmp_path / "matplotlib.py").write_text("raise ImportError('not here')\n")
    code = "import foldwing as fw; fw.load('examples/models/folding_wing.toml').simulate(0.01, outputs='fold.angle').plot()"
    done = subprocess.run([sys.executable, "-c", f"import sys; sys.path.insert(0, {str(tmp_path)!r}); {code}"], capture_output=True, text=True)
    assert "ImportError: matplotlib is not installed; type: pip install matplotlib" in done.stderr
