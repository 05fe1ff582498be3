"""Statics, modes, flutter and trim, against the command."""

import json
import pickle
import subprocess

import numpy as np
import pytest

import foldwing as fw

GOLAND, TIP = "examples/models/goland_wing.toml", "examples/models/flared_wing_tip.toml"


def said(command, *words):
    """JSON output of the command."""
    return json.loads(subprocess.run([command, *words, "--json"], capture_output=True, text=True, check=True).stdout)


def test_flutter_is_that_of_the_command(command):
    theirs = said(command, "flutter", GOLAND, "--wind-m-s", "125:145:3", "--count", "3")["results"][0]
    found = fw.load(GOLAND).flutter([125.0, 135.0, 145.0], count=3)
    assert found.data == theirs
    assert found.flutter_m_s.tolist() == [flutter["speed_m_s"] for flutter in theirs["flutter"] if flutter["begins"]]
    assert found.eigenvalues_1_s.shape == (len(found.speed_m_s), 3) and set(found.speed_m_s) >= {125.0, 135.0, 145.0}
    # the second mode grows above the flutter speed, and only there
    growing = found.damping_ratio[:, 1] < 0.0
    assert np.array_equal(growing, found.speed_m_s > found.flutter_m_s[0])
    assert found.frequency_Hz[0, 0] == pytest.approx(abs(found.eigenvalues_1_s[0, 0]) / (2.0 * np.pi), rel=1e-15)
    assert "flutter at 137.405" in repr(found) and "neither" in repr(fw.load(GOLAND).flutter([20.0, 30.0], count=2))


def test_mode_shapes_have_the_page_of_the_command(command, tmp_path):
    goland = fw.load(GOLAND)
    wind = {"wind.velocity.y": -140.0}
    for name, words, found in [
        ("modes", ["modes", GOLAND, "--count", "3", "--set", "wind.velocity.y=-140"], goland.modes(3, settings=wind)),
        ("bare", ["modes", GOLAND, "--count", "3", "--state", "undeformed"], goland.modes(3, state="undeformed")),
        ("flutter", ["flutter", GOLAND, "--wind-m-s", "130:140:2", "--count", "2"], goland.flutter([130.0, 140.0], count=2)),
    ]:
        theirs = tmp_path / f"{name}_theirs.html"
        subprocess.run([command, *words, "--view", theirs], check=True, capture_output=True)
        file = found.view(tmp_path / f"{name}.html", show=False)
        assert file.read_bytes() == theirs.read_bytes(), name
        assert pickle.loads(pickle.dumps(found)).page() == found.page(), name
    turbine = fw.load("examples/turbine/nrel_5mw.toml")
    turn = turbine.periodic(12.1, outputs="body.blade1.deflection.*", count=2, perturbations=40)
    page = turn.view(tmp_path / "turn.html", show=False).read_text()
    assert "Floquet modes about the periodic motion at 12.1 rpm" in page
    with pytest.raises(fw.UsageError, match="does not contain its model"):
        goland.flutter_map("aero.density", [1.0, 1.2], [130.0, 140.0], count=2).results[0].view()
    with pytest.raises(fw.FoldwingError, match="no modes to draw"):
        goland.modes(0).view(tmp_path / "none.html", show=False)
    assert not (tmp_path / "none.html").exists()


def test_flutter_over_a_quantity_is_that_of_the_command(command):
    words = ["--wind-m-s", "120:160:2", "--count", "2", "--set", "root.acceleration.x=0"]
    for over, values in [("aero.density", [1.0, 1.225]), ("file:surface.wing.elastic_axis_fraction", [0.3, 0.33])]:
        theirs = said(command, "flutter", GOLAND, *words, "--vary", f"{over}={values[0]},{values[1]}")["results"]
        found = fw.load(GOLAND).flutter_map(over, values, [120.0, 160.0], count=2, settings={"root.acceleration.x": 0.0})
        assert found.over == over and found.values == values
        assert [{**result.data, "value": None} for result in found.results] == [{**result, "value": None} for result in theirs]
        first = [result["flutter"][0]["speed_m_s"] for result in theirs]
        assert found.flutter_m_s.tolist() == first and np.isnan(found.divergence_m_s).all()
        assert "2 values" in repr(found)
    with pytest.raises(fw.FoldwingError, match="densty"):
        fw.load(GOLAND).flutter_map("aero.densty", [1.0, 2.0], [120.0, 160.0])


def test_an_aircraft_is_trimmed_in_a_turn(command):
    aircraft = "examples/flight/folding_aircraft.toml"
    controls = ["aero.control_surface.elevator_left.angle_command,aero.control_surface.elevator_right.angle_command", "aero.control_surface.rudder.angle_command"]
    controls += ["aero.control_surface.aileron_left.angle_command,-aero.control_surface.aileron_right.angle_command", "load.fuselage[1].force.x"]
    free = ["turn.rate", "attitude.pitch", *controls]
    words = [word for name in free for word in ("--solve-for", name)]
    theirs = said(command, "trim", aircraft, *words, "--set", "attitude.roll=0.3")
    trim = fw.load(aircraft).trim(free, settings={"attitude.roll": 0.3})
    assert trim.data == theirs and "attitude.roll" not in trim.settings
    assert trim.free["turn.rate"] == pytest.approx(9.81 * np.tan(0.3) / 18.0, rel=5e-3)


def test_trim_is_that_of_the_command_and_a_setting(command):
    wing = fw.load(TIP)
    words = ["--solve-for", "wind.velocity.z", "--target", "root.force.z=5", "--set", "fold.release=0"]
    theirs = said(command, "trim", TIP, *words)
    trim = wing.trim("wind.velocity.z", {"root.force.z": 5.0}, settings={"fold.release": False})
    assert trim.data == theirs and trim.settings == {"fold.release": False, **theirs["settings"]}
    assert theirs["settings"] == theirs["free"]
    assert wing.static(settings=trim.settings).root_force_N[2] == pytest.approx(5.0, abs=1e-8)
    assert "wind.velocity.z = " in repr(trim)


def test_what_cannot_be_asked_is_refused_by_name(wing):
    goland, tip = fw.load(GOLAND), fw.load(TIP)
    for speeds in ([50.0], [60.0, 50.0], [0.0, 50.0], [50.0, float("nan")], [50.0, 50.0], []):
        with pytest.raises(fw.UsageError, match="wind_m_s: two or more positive speeds in m/s in ascending order are needed"):
            goland.flutter(speeds)
    with pytest.raises(fw.UsageError, match="count: 61 must be from 1 to 60"):
        goland.flutter([50.0, 60.0], count=61)
    with pytest.raises(fw.UsageError, match="has no aerodynamics; flutter needs"):
        wing.flutter([5.0, 10.0])
    with pytest.raises(fw.UsageError, match="wind.velocity.x"):
        tip.trim("wind.velocty.x", {"root.force.z": 0.0})
    with pytest.raises(fw.UsageError, match="is not a real output"):
        tip.trim("wind.velocity.z", {"fold.external_torque": 0.0})
    with pytest.raises(fw.UsageError, match="2 unknowns for 1 targets"):
        tip.trim(["wind.velocity.z", "wind.velocity.y"], {"root.force.z": 0.0})
    with pytest.raises(fw.UsageError, match="there is no unknown"):
        tip.trim([], {})
    with pytest.raises(fw.UsageError, match="not a finite number"):
        tip.trim("wind.velocity.z", {"root.force.z": float("inf")})
    with pytest.raises(fw.StaticsError, match="no trim: .*root.force.x"):
        tip.trim("fold.external_torque", {"root.force.x": 1e6})


def test_progress_is_reported(monkeypatch):
    """Studies report the completed fraction, which rises to 1. The number of reports depends on the computer: the longest studies give more
    than one."""
    import foldwing.model
    import foldwing.rotor
    from contextlib import contextmanager

    shares = []

    @contextmanager
    def bar(wanted):
        yield shares.append

    monkeypatch.setattr(foldwing.model, "bar", bar)
    monkeypatch.setattr(foldwing.rotor, "bar", bar)
    goland, turbine = fw.load(GOLAND), fw.load("examples/turbine/nrel_5mw_wind.toml")
    partial = 0
    for work in (
        lambda: goland.flutter(np.linspace(20.0, 120.0, 100), count=2),
        lambda: goland.flutter_map("aero.density", [1.0, 1.1], [60.0, 90.0], count=2),
        lambda: turbine.operating_points([7.0, 8.0], speed_rpm=9.0, pitch_deg=0.0, settings={"gravity": [0.0, 0.0, 0.0]}, steps=144, tolerance=1e-3),
        lambda: fw.load("examples/turbine/nrel_5mw.toml").campbell([0.0, 6.0, 12.0], undeformed=True, count=4),
    ):
        shares.clear()
        work()
        assert shares == sorted(shares) and shares[-1] == 1.0, shares
        partial += shares[0] < 1.0
    assert partial


def test_campbell_diagrams_are_those_of_the_command(command):
    bare = "examples/turbine/nrel_5mw.toml"
    theirs = said(command, "modes", bare, "--state", "undeformed", "--vary", "rotor_speed_rpm=0,6,12", "--count", "4")
    diagram = fw.load(bare).campbell([0.0, 6.0, 12.0], undeformed=True, count=4)
    assert diagram.data == theirs and diagram.frequency_Hz.shape == (3, 4) and diagram.speed_rpm.tolist() == [0.0, 6.0, 12.0]
    assert diagram.motions[0] == "shaft, free" and diagram.motions[1].startswith("tower")
    assert np.allclose(np.abs(diagram.eigenvalues_1_s) / (2.0 * np.pi), diagram.frequency_Hz, rtol=1e-12)
    assert "4 modes from 0 to 12 rpm" in repr(diagram)
    for speeds in ([1.0], [2.0, 1.0, 3.0], []):
        with pytest.raises(fw.UsageError, match="speed_rpm: needs two or more values in ascending or descending order"):
            fw.load(bare).campbell(speeds)
    with pytest.raises(fw.StaticsError, match="shaft"):
        fw.load(GOLAND).campbell([0.0, 1.0], undeformed=True)


def test_equilibria_have_the_warnings_of_the_command(tmp_path):
    """A pendulum in equilibrium at 90 deg, away from its latch at 120 deg: `static` and `trim` report the open latch, and nothing with the
    latch disabled."""
    path = tmp_path / "pendulum.toml"
    path.write_text(
        'name = "Pendulum"\ngravity_m_s2 = [0.0, 0.0, -9.81]\n[rigid_body.arm]\nmass_kg = 1.0\ninertia_kg_m2 = [0.01, 0.1, 0.1, 0.0, 0.0, 0.0]\n'
        'centre_of_mass_m = [0.3, 0.0, 0.0]\n[joint.hinge]\ntype = "revolute"\nparent = "root"\nchild = "arm"\naxis = [0.0, 1.0, 0.0]\n'
        'start_angle_deg = 20.0\nlatch = { angle_deg = 120.0, kind = "rigid" }\n'
    )
    pendulum = fw.load(path)
    trim = pendulum.trim("hinge.external_torque", {"hinge.angle": np.pi / 2.0})
    for warnings in (pendulum.static().warnings, trim.warnings):
        assert len(warnings) == 1 and warnings[0].startswith("the latch of joint hinge at 120 deg is open"), warnings
    assert pendulum.static(settings={"hinge.latch_enable": False}).warnings == []
