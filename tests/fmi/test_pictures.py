"""Figures and VTK files of a run, compared with its CSV."""

import csv
import json
import re
import subprocess

import meshio
import numpy as np
import pytest
from conftest import ROOT
from lxml import etree
from PIL import Image

MODEL = ROOT / "examples/models/folding_wing.toml"
TUNNEL = ROOT / "examples/models/folding_wing_in_tunnel.toml"
SVG = "{http://www.w3.org/2000/svg}"
OVER_TIME = {"fold_angles", "fold_torques", "tips", "root_moment", "strains", "energies"}
FIGURES = OVER_TIME | {"tip_path", "shapes"}


def simulate(foldwing, model, folder, *arguments):
    """Simulates and returns the columns of the CSV."""
    table = folder / "run.csv"
    subprocess.run([foldwing, "simulate", model, "--csv", table, *map(str, arguments)], check=True)
    with table.open() as lines:
        rows = list(csv.reader(lines))
    return {name: np.array([float(row[i]) for row in rows[1:]]) for i, name in enumerate(rows[0])}


@pytest.fixture(scope="module")
def still_air(foldwing, tmp_path_factory):
    """Folder and columns of the deployment in still air with all pictures."""
    folder = tmp_path_factory.mktemp("still_air")
    return folder, simulate(foldwing, MODEL, folder, "--plot", folder / "plots", "--vtk", folder / "vtk", "--frames", 800)


def polylines(path):
    """Points of the curves of a figure, except curves of a single point and the legend, in tenths of a user unit."""
    lines = etree.parse(path).getroot().iter(f"{SVG}polyline")
    found = [np.array([[float(c) for c in point.split(",")] for point in line.get("points").split()]) for line in lines]
    return [line for line in found if len(line) > 2]


def misfit(values, pixels):
    """Largest distance of pixels from the best straight line from values to pixels."""
    matrix = np.column_stack([values, np.ones_like(values)])
    return np.abs(matrix @ np.linalg.lstsq(matrix, pixels, rcond=None)[0] - pixels).max()


def test_f180_figures_show_the_columns(still_air):
    """F-180. Every point of the curves of fold angle, strain and energies is at the value in the CSV.

    Coordinates in a picture are whole tenths of a user unit, so the straight line from values to positions fits within one tenth.
    """
    folder, columns = still_air
    time = columns["time"]
    curves = {"fold_angles": ["fold.angle"], "fold_torques": ["fold.total_torque"], "strains": ["gauge.root.strain"],
              "tips": [f"tip.position.{axis}" for axis in "xyz"], "root_moment": [f"root.moment.{axis}" for axis in "xyz"], "energies": [
        f"energy.{name}" for name in ("kinetic", "elastic", "gravity", "motor", "work", "dissipated", "total")]}
    for stem, names in curves.items():
        lines = polylines(folder / f"plots/{stem}.svg")
        assert len(lines) == len(names), stem
        for name, line in zip(names, lines):
            assert len(line) == len(time), (stem, name)
            assert misfit(time, line[:, 0]) < 1.0, (stem, name)
            assert misfit(columns[name], line[:, 1]) < 1.0, (stem, name)
    tip = polylines(folder / "plots/tip_path.svg")[0]
    assert misfit(columns["tip.position.x"], tip[:, 0]) < 1.0 and misfit(columns["tip.position.z"], tip[:, 1]) < 1.0


def test_f181_figures_say_what_they_show(still_air):
    """F-181. All eight figures and the overview exist, the figures with units on both axes and names; the latch instant is that of the CSV."""
    folder, columns = still_air
    assert {path.stem for path in (folder / "plots").glob("*.svg")} == FIGURES | {"overview"}
    latch_s = columns["fold.latch_time"][-1]
    for stem in FIGURES:
        texts = [text.text.strip() for text in etree.parse(folder / f"plots/{stem}.svg").getroot().iter(f"{SVG}text")]
        assert sum(bool(re.search(r"\((s|m|J|°|10⁻³|N·m)\)", text)) for text in texts) == 2, (stem, texts)
        assert (f"fold latched, {latch_s:.4f} s" in texts) == (stem in OVER_TIME), stem


def test_f182_pixels_show_the_same(still_air):
    """F-182. Each PNG has two pixels per user unit of its SVG and shows its curves' colours at the points of the SVG."""
    folder, _ = still_air
    for stem in FIGURES:
        root = etree.parse(folder / f"plots/{stem}.svg").getroot()
        image = Image.open(folder / f"plots/{stem}.png").convert("RGB")
        assert image.size == (2 * int(root.get("width")), 2 * int(root.get("height"))), stem
        pixels = np.asarray(image).astype(int)
        line = [line for line in root.iter(f"{SVG}polyline") if len(line.get("points").split()) > 2][-1]
        colour = np.array([int(line.get("stroke")[i:i + 2], 16) for i in (1, 3, 5)])
        points = [[float(c) / 5 for c in point.split(",")] for point in line.get("points").split()]
        near = [np.abs(pixels[max(0, int(y) - 2):int(y) + 3, max(0, int(x) - 2):int(x) + 3] - colour).sum(axis=2).min() for x, y in points]
        # the last curve is drawn on top; its edge is blended with the background
        assert np.mean(np.array(near) < 60) > 0.98, stem


def test_f183_chosen_outputs_are_drawn_by_unit(foldwing, tmp_path):
    """F-183. Variables of `--variables` with the same unit share a figure; figures without CSV are possible and reproducible."""
    names = ["fold.angle", "gauge.root.strain", "fold.angular_velocity"]
    for folder in "ab":
        command = [foldwing, "simulate", MODEL, "--quiet", "--plot", tmp_path / folder]
        subprocess.run([*command, *(f"--variables={name}" for name in names)], check=True)
    stems = {path.stem for path in (tmp_path / "a").glob("*.svg")} - FIGURES - {"overview"}
    assert stems == {"outputs_1", "outputs_2", "outputs_3"}
    texts = [text.text.strip() for text in etree.parse(tmp_path / "a/outputs_1.svg").getroot().iter(f"{SVG}text")]
    assert "fold.angle (rad)" in texts and "fold.angle" in texts
    for path in (tmp_path / "a").iterdir():
        assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes(), path.name
    # infinite limits are not drawn, so that the others are visible; an axis for several variables names the ones with its unit
    subprocess.run([foldwing, "simulate", MODEL, "--quiet", "--plot", tmp_path / "c", "--variables", "fold.*"], check=True)
    texts = {text.text.strip() for path in (tmp_path / "c").glob("outputs_*.svg") for text in etree.parse(path).getroot().iter(f"{SVG}text")}
    assert {"moment (N·m)", "angle (rad)", "force (N)", "fold.latch_torque"} <= texts
    assert not {"fold.motor_torque_limit", "fold.motor_rate_limit"} & texts and not any("e2" in text or "e30" in text for text in texts), texts


def series(folder, stem):
    """Times and meshes listed in a `.pvd` file."""
    sets = etree.parse(folder / f"{stem}.pvd").getroot().iter("DataSet")
    return [(float(entry.get("timestep")), meshio.read(folder / entry.get("file"))) for entry in sets]


def test_f184_vtk_holds_the_outputs(still_air):
    """F-184. meshio reads the wing's surface at every time of the CSV. Position and velocity of the middle of the last section are those of
    the tip, and displacements are differences of positions.

    The tip's values are the mean over a rectangle: round-off of a few sums, 1e-13 m and 1e-11 m/s.
    """
    folder, columns = still_air
    meshes = series(folder / "vtk", "wing")
    assert [time for time, _ in meshes] == list(columns["time"])
    first = meshes[0][1].points
    for i, (_, mesh) in enumerate(meshes):
        assert sum(len(cells) for cells in mesh.cells) == 2 * (16 * 4 + 2)
        tip = mesh.points[-4:].mean(axis=0)
        expected = np.array([columns[f"tip.position.{axis}"][i] for axis in "xyz"])
        assert np.abs(tip - expected).max() < 1e-13
        velocity = mesh.point_data["velocity_m_s"][-4:].mean(axis=0)
        assert np.abs(velocity - [columns[f"tip.velocity.{axis}"][i] for axis in "xyz"]).max() < 1e-11
        assert np.abs(mesh.point_data["displacement_m"] - (mesh.points - first)).max() < 1e-15


def test_f185_vtk_strain_is_the_gauge(foldwing, tmp_path):
    """F-185. With constant elements, the strain of the surface at the section of a gauge is that of the gauge: the same formula, so
    round-off. With pairs it is the strain of the elements (NOTATION G7): exactly zero in the unstrained state.
    """
    columns = simulate(foldwing, ROOT / "examples/models/folding_wing_constant.toml", tmp_path, "--vtk", tmp_path)
    meshes = series(tmp_path, "wing")
    assert [time for time, _ in meshes] == list(columns["time"][::2]), "no more than 600 frames of 801 points"
    # the upper points of the section there: the inner body lies along x at the start
    first = meshes[0][1].points
    at = [i for i, (x, _, z) in enumerate(first) if abs(x - 0.02) < 1e-12 and z > 0]
    assert len(at) == 2
    for (_, mesh), strain in zip(meshes, columns["gauge.root.strain"][::2]):
        assert abs(mesh.point_data["axial_strain"][at].mean() - strain) < 1e-15
    pairs = tmp_path / "pairs"
    simulate(foldwing, MODEL, tmp_path, "--vtk", pairs, "--stop", 0.01, "--force")
    meshes = series(pairs, "wing")
    assert np.abs(meshes[0][1].point_data["axial_strain"]).max() == 0.0 < np.abs(meshes[-1][1].point_data["axial_strain"]).max()


def test_f186_vtk_holds_the_wake(foldwing, tmp_path):
    """F-186. Wake of the tunnel: nodes and circulations at the last time are bit-identical to those written by `--lattice`."""
    lattice = tmp_path / "lattice.json"
    simulate(foldwing, TUNNEL, tmp_path, "--stop", 0.1, "--vtk", tmp_path, "--lattice", lattice, "--lattice-at", 0.1)
    surfaces = json.loads(lattice.read_text())[0]["surfaces"]
    wake = series(tmp_path, "wake")[-1][1]
    nodes = np.concatenate([np.array(surface["wake_node_m"]).reshape(-1, 3) for surface in surfaces])
    rings = np.concatenate([np.ravel(surface["wake_circulation_m2_s"]) for surface in surfaces])
    assert len(rings) > 100 and np.array_equal(wake.points, nodes)
    assert np.array_equal(np.concatenate(wake.cell_data["circulation_m2_s"]), rings)
    surface = series(tmp_path, "surfaces")[-1][1]
    assert len(surface.points) == 2 * sum(len(surface["corner_m"][0]) for surface in surfaces)


def test_f265_one_series_has_all_parts(foldwing, tmp_path):
    """F-265. `run.pvd` lists every part at every time. Positions and values of gauges, loads and joints are bit-identical to the CSV,
    except for round-off in the position of a gauge (1e-13 m)."""
    columns = simulate(foldwing, MODEL, tmp_path, "--stop", 0.02, "--vtk", tmp_path / "vtk", "--set", "load.outer[4].force.z=0.05")
    sets = list(etree.parse(tmp_path / "vtk/run.pvd").getroot().iter("DataSet"))
    names = ["wing", "joints", "gauges", "loads"]
    assert [entry.get("name") for entry in sets] == names * len(columns["time"])
    assert [int(entry.get("part")) for entry in sets[:4]] == [0, 1, 2, 3]
    for i, time in enumerate(columns["time"]):
        parts = {entry.get("name"): meshio.read(tmp_path / "vtk" / entry.get("file")) for entry in sets[4 * i : 4 * i + 4]}
        assert {float(entry.get("timestep")) for entry in sets[4 * i : 4 * i + 4]} == {time}
        assert parts["gauges"].point_data["strain"][0] == columns["gauge.root.strain"][i]
        joint = parts["joints"]
        assert joint.point_data["angle_rad_or_position_m"][0] == columns["fold.angle"][i]
        frame = np.array([joint.point_data[f"frame_{axis}"][0] for axis in "xyz"])
        assert np.abs(frame @ frame.T - np.eye(3)).max() < 1e-12
        assert np.abs(joint.point_data["axis"][0] - frame[1]).max() < 1e-12, "the fold's axis is the body's chord"
        loads = parts["loads"]
        station = np.array([columns[f"station.outer[4].position.{axis}"][i] for axis in "xyz"])
        assert np.abs(loads.points[-1] - station).max() < 1e-13
        assert list(loads.point_data["force_N"][-1]) == [0.0, 0.0, 0.05] and not loads.point_data["air_force_N"].any()


def test_f187_bad_places_are_refused_before_the_run(foldwing, tmp_path):
    """F-187. A folder that cannot be created is rejected with a message and its exit code."""
    (tmp_path / "file").write_text("")
    for option in ("--plot", "--vtk"):
        done = subprocess.run([foldwing, "simulate", MODEL, option, tmp_path / "file/plots"], capture_output=True, text=True)
        assert done.returncode == 4 and "file/plots: cannot be written" in done.stderr, done.stderr
        assert "simulated" not in done.stderr
