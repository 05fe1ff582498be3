"""Rotors: periodic steady states and operating points, against the command."""

import json
import subprocess

import numpy as np
import pytest

import foldwing as fw

BARE, WINDY = "examples/turbine/nrel_5mw.toml", "examples/turbine/nrel_5mw_wind.toml"


def said(command, *words):
    """JSON output of the command."""
    return json.loads(subprocess.run([command, *words, "--json"], capture_output=True, text=True, check=True).stdout)


def test_the_motion_is_that_of_the_command(command):
    names = ["body.blade1.deflection.y"]
    theirs = said(command, "periodic", BARE, "--speed-rpm", "12.1", "--steps", "144", "--count", "0", "--variables", ",".join(names))
    turn = fw.load(BARE).periodic(12.1, steps=144, count=0, outputs=names)
    assert {key: value for key, value in turn.data.items() if key in theirs} == theirs
    edge = turn[names[0]]
    assert edge.shape == (145,) and turn.turn_deg[[0, -1]].tolist() == [0.0, 360.0]
    assert edge[-1] == pytest.approx(edge[0], abs=1e-6)
    assert turn.mean(names[0]) == pytest.approx(edge[:-1].mean(), rel=1e-12)
    wave = 2.0 * abs(np.mean(edge[:-1] * np.exp(-1j * np.radians(turn.turn_deg[:-1]))))
    assert turn.amplitude(names[0], 1) == pytest.approx(wave, rel=1e-9) and wave > 0.3
    assert len(turn.multipliers) == 0 and "at 12.1 rpm" in repr(turn)
    with pytest.raises(KeyError, match="not among the outputs"):
        turn["tip"]


def test_modes_beside_the_motion():
    turn = fw.load(BARE).periodic(12.1, steps=288, count=4, outputs="body.tower.deflection.z")
    assert turn.stable and len(turn.multipliers) == 4 and turn.motions[0].startswith("tower")
    assert abs(turn.eigenvalues_1_s[0]) / (2.0 * np.pi) == pytest.approx(0.3139, rel=1e-3)


def test_points_are_those_of_the_command(command):
    words = ["--wind-m-s", "8", "--speed-rpm", "9.16", "--pitch-deg", "1", "--steps", "144", "--tolerance", "1e-5"]
    theirs = said(command, "operating-points", WINDY, *words, "--variables", "rotor.*")
    table = fw.load(WINDY).operating_points(8.0, speed_rpm=9.16, pitch_deg=1.0, outputs="rotor.*", steps=144, tolerance=1e-5)
    assert table.data == theirs and len(table) == 1 and table.state == ["periodic"] and table.held == [None]
    assert table.speed_rpm[0] == pytest.approx(9.16) and table.pitch_deg[0] == 1.0
    assert table["rotor.power"][0] == pytest.approx(1.85e6, rel=0.02) and table.peak_to_peak("rotor.power")[0] > 0.0
    assert "rotor.thrust" in table.names() and "1 points" in repr(table)
    with pytest.raises(KeyError, match="not among the outputs"):
        table["rotor.pwer"]


def test_what_cannot_be_asked_is_refused_by_name():
    bare, windy = fw.load(BARE), fw.load(WINDY)
    with pytest.raises(fw.UsageError, match="has no aerodynamics; operating points need"):
        bare.operating_points(8.0)
    with pytest.raises(fw.UsageError, match="solve_for= and target= must be given together"):
        windy.operating_points(8.0, solve_for=("pitch_deg", 0.0, 40.0))
    with pytest.raises(fw.UsageError, match=r'must be \("pitch_deg", begin, end\) or'):
        windy.operating_points(8.0, solve_for=("pitch", 0.0, 40.0), target=("rotor.power", 1.0))
    with pytest.raises(fw.UsageError, match="has no value"):
        windy.operating_points([])
    with pytest.raises(fw.UsageError, match="wind.velocity.x"):
        windy.operating_points(8.0, settings={"wind.velocty.x": 1.0})
    with pytest.raises(fw.StaticsError, match="the speed of the shaft"):
        windy.operating_points(8.0, speed_rpm=0.0)
    with pytest.raises(fw.StaticsError, match="no speed in the model"):
        bare.periodic()


def test_linear_models_have_the_states_of_wake_and_stall(tmp_path):
    blade = "[rigid_body.hub]\nmass_kg = 10.0\ninertia_kg_m2 = [1, 1, 1, 0, 0, 0]\n[joint.shaft]\ntype = 'revolute'\nparent = 'root'\nchild = 'hub'\naxis = [1, 0, 0]\nstart_rate_deg_s = 240.0\n"
    blade += "[rigid_body.blade]\nmass_kg = 20.0\ncentre_of_mass_m = [4, 0, 0]\ninertia_kg_m2 = [1, 100, 100, 0, 0, 0]\n[joint.mount]\ntype = 'clamped'\nparent = 'hub'\nchild = 'blade'\n"
    blade += "parent_offset_m = [0, 0, 0.5]\nmount_rotation_deg = [127.27922061357854, 0.0, 127.27922061357854]\n"
    air = "[aerodynamics]\nmodel = 'bem'\nhub = 'hub'\nhub_radius_m = 0.5\nblades = 3\nwind_m_s = [8.0, 0, 0]\nstep_s = 0.02\ndynamic_inflow = true\ndynamic_stall = true\n"
    air += "[surface.blade]\nbody = 'blade'\nlength_m = 9.5\nelastic_axis_fraction = 0.25\nstations_m = [0.0, 5.0, 9.0]\npolars = ['p', 'p', 'p']\nchord_m = 0.5\nincidence_deg = -3.0\n"
    air += "[polar.p]\nrows = [[-180, 0, 0.5, 0], [-12, -1.1, 0.03, 0], [12, 1.1, 0.03, 0], [180, 0, 0.5, 0]]\n"
    (tmp_path / "rotor.toml").write_text('name = "rotor"\n' + blade + air)
    model = fw.load(tmp_path / "rotor.toml").linearize("start", inputs="wind.velocity.x", outputs="rotor.thrust")
    names = [state.name for state in model.states if ".station[" in state.name]
    # neither root nor tip has an aerodynamic load
    assert len(names) == 8 and "blade.station[2].attachment" in names and model.D[0, 0] > 0.0
    assert np.linalg.eigvals(model.A).real.max() < 100.0
