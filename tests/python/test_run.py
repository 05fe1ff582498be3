"""Runs: bit-identical to the command, inputs of every form, exceptions with the command's messages, Ctrl-C."""

import csv
import pickle
import signal
import math
import subprocess
import threading
import time
from pathlib import Path

import numpy as np
import pandas
import pytest

import foldwing as fw

MODEL = "examples/models/folding_wing.toml"
COLUMNS = ["fold.angle", "gauge.root.strain", "fold.latched"]


def of_command(command, tmp_path, *options):
    """Columns written by the command."""
    out = tmp_path / "out.csv"
    named = [word for name in COLUMNS for word in ("--variables", name)]
    subprocess.run([command, "simulate", MODEL, "--csv", out, "-q", *named, *options], check=True)
    with open(out) as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in ["time", *COLUMNS]}


def test_a_run_has_the_bits_of_the_command(wing, command, tmp_path):
    expected = of_command(command, tmp_path, "--stop", "0.3", "--step", "0.0007", "--set", "fold.start_angle=2")
    run = wing.simulate(stop=0.3, step=0.0007, settings={"fold.start_angle": 2.0}, outputs=COLUMNS)
    for name, values in expected.items():
        assert np.array_equal(run[name], values), name


def test_inputs_of_every_form_act_alike(wing, command, tmp_path):
    """Results with a mapping of arrays and with a DataFrame are bit-identical to the command with the same CSV; functions sampled at the
    same points are bit-identical to each other."""
    times = np.array([0.0, 0.013, 0.05, 0.2])
    pull, free = np.array([0.0, -0.02, 0.05, 0.01]), np.array([0, 1, 1, 1])
    table = tmp_path / "in.csv"
    pandas.DataFrame({"time": times, "load.outer[4].force.z": pull, "fold.release": free}).to_csv(table, index=False)
    expected = of_command(command, tmp_path, "--stop", "0.1", "--inputs", str(table))
    mapping = {"time": times, "load.outer[4].force.z": pull, "fold.release": free}
    frame = pandas.DataFrame({"load.outer[4].force.z": pull, "fold.release": free}, index=times)
    for inputs in (mapping, frame):
        run = wing.simulate(stop=0.1, inputs=inputs, outputs=COLUMNS)
        for name, values in expected.items():
            assert np.array_equal(run[name], values), name

    def torque(time):
        return 0.01 * np.sin(40 * time)

    by_name = wing.simulate(stop=0.1, inputs={"fold.external_torque": torque}, outputs=COLUMNS)
    by_loop = wing.simulate(stop=0.1, inputs=lambda time, sim: {"fold.external_torque": torque(time)}, outputs=COLUMNS)
    again = wing.simulate(stop=0.1, inputs={"time": by_loop.inputs[0], **by_loop.inputs[1]}, outputs=COLUMNS)
    for name in COLUMNS:
        assert np.array_equal(by_name[name], by_loop[name]) and np.array_equal(by_name[name], again[name]), name
    still = wing.simulate(stop=0.1, outputs=COLUMNS)
    assert not np.array_equal(still["fold.angle"], by_name["fold.angle"])
    mixed = wing.simulate(stop=0.1, inputs={**mapping, "fold.external_torque": lambda time: 0.0}, outputs=COLUMNS)
    assert np.array_equal(mixed["fold.angle"], expected["fold.angle"])


def test_a_controller_is_a_loop_over_steps(wing):
    """The function reads the machine at its start: with it also the first action is bit-identical to that of a manual loop."""
    names = ["fold.angle", "fold.angular_velocity", "tip.position"]
    seen = []

    def damper(time, sim):
        seen.append((time, sim["fold.angle"]))
        return {"fold.external_torque": -0.05 * sim["fold.angle"]}

    run = wing.simulate(stop=0.05, step=0.005, inputs=damper, outputs=names)
    sim = wing.start()
    assert seen[0] == (0.0, sim["fold.angle"]) and sim["fold.angle"] > 2.9
    for point, end in enumerate(run.time[1:], start=1):
        sim["fold.external_torque"] = -0.05 * sim["fold.angle"]
        sim.step_to(end)
        for name in names:
            assert np.array_equal(run[name][point], sim[name]), (name, end)
    times, columns = run.inputs
    assert np.array_equal(columns["fold.external_torque"][:-1], [-0.05 * angle for angle in run["fold.angle"][:-1]])


def test_messages_name_keywords_and_not_options(wing):
    """The messages of the command about its options name the arguments of the functions here."""
    refused = [
        (fw.UsageError, "^stop=-1", lambda: wing.simulate(stop=-1.0)),
        (fw.UsageError, "^step=0", lambda: wing.simulate(step=0.0)),
        (fw.UsageError, "solve_for= and target=", lambda: wing.trim(["fold.external_torque", "fold.angle_command"], {"fold.angle": 1.0})),
        (fw.StaticsError, "name the joint of the shaft", lambda: wing.periodic(10.0)),
        (fw.UsageError, "Model.variables has the names", lambda: wing.simulate(outputs="zzzzzz")),
    ]
    for kind, pattern, call in refused:
        with pytest.raises(kind, match=pattern) as found:
            call()
        assert "--" not in str(found.value) and "`foldwing " not in str(found.value), found.value


def test_a_loop_is_the_run(wing):
    """Stepping manually, from saved states, in steps or at once."""
    run = wing.simulate(stop=0.25, outputs=["fold.angle", "fold.latch_time", "tip.position"])
    sim = wing.start()
    states = {}
    for point, time_s in enumerate(run.time[1:], start=1):
        sim.step_to(time_s)
        assert sim["fold.angle"] == run["fold.angle"][point]
        if point in (100, 300):
            states[point] = sim.save()
    assert sim["fold.latch_time"] == run["fold.latch_time"][-1] > 0.12
    assert np.array_equal(sim["tip.position"], run["tip.position"][-1])
    for point, state in states.items():
        sim.restore(fw.State.from_bytes(wing._native, state.to_bytes()))
        assert sim.time == run.time[point]
        sim.step_to(run.time[point + 50])
        assert sim["fold.angle"] == run["fold.angle"][point + 50]
    assert sim.statistics()["steps"] > 0


def test_values_are_read_and_set_by_name(wing):
    sim = wing.start()
    assert sim["fold.release"] is True and isinstance(sim["fold.latch_count"], int)
    sim["load.outer[4].force"] = [0.0, 0.1, 0.2]
    assert sim["load.outer[4].force.z"] == 0.2 and sim["load.outer[4].force"].tolist() == [0.0, 0.1, 0.2]
    sim["fold.release"] = 0
    assert sim["fold.release"] is False
    for name, value, words in [
        ("fold.external_torqe", 1.0, "did you mean `fold.external_torque`?"),
        ("fold.external_torque", "much", "is not a number"),
        ("fold.external_torque", float("nan"), "must be finite"),
        ("fold.release", 2, "is not a Boolean"),
        ("fold.angle", 0.0, "cannot be set: it is an output"),
        ("fold.start_angle", 0.0, "is fixed"),
        ("load.outer[4].force", [1.0, 2.0], "2 values for 3 components"),
    ]:
        with pytest.raises(fw.UsageError, match=None) as refused:
            sim[name] = value
        assert words in str(refused.value), str(refused.value)
    with pytest.raises(fw.UsageError, match="positive"):
        sim.step(-1.0)
    other = fw.load("examples/models/roll_fold.toml").start()
    with pytest.raises(fw.UsageError, match="belongs to the model"):
        other.restore(sim.save())


def test_a_summary_has_the_warnings_of_the_command():
    behind = fw.load("examples/tutorial/sketch.toml").with_values({"file:aerodynamics.wind_m_s": [0.0, 12.0, 0.0]}).check()
    assert "from behind" in behind.warnings[0] and f"warning: {behind.warnings[0]}" in behind
    ahead = fw.load("examples/tutorial/sketch.toml").check()
    assert ahead.warnings == [] and "warning" not in ahead


def test_settings_take_degrees_and_name_keys_of_the_file(wing):
    degrees, radians = (wing.simulate(0.01, settings={"fold.start_angle": start}) for start in ("60 deg", math.pi / 3))
    # 180/pi rounds differently
    assert abs(degrees["fold.angle"] - radians["fold.angle"]).max() < 1e-15
    for name, value, words in [
        ("fold.start_angle", "60 mm", "'mm' is not one of its units; allowed: rad and deg"),
        ("fold.motor_damping", "3 deg", "allowed: N.m.s/rad"),
        ("fold.start_angle", "far", "settings: fold.start_angle: 'far' is not a number"),
        ("file:body.inner.length_m", 0.2, "model.with_values({'file:body.inner.length_m': 0.2})"),
    ]:
        with pytest.raises(fw.UsageError) as refused:
            wing.simulate(0.01, settings={name: value})
        assert words in str(refused.value), str(refused.value)


def test_refusals_have_the_words_of_the_command(command, tmp_path):
    text = open(MODEL).read().replace("length_m = 0.15", "lenght_m = 0.15", 1)
    file = tmp_path / "bad.toml"
    file.write_text(text)
    said = subprocess.run([command, "check", file], capture_output=True, text=True).stderr
    with pytest.raises(fw.ModelError) as refused:
        fw.load(file)
    # the command formats the message around an excerpt of the file
    pieces = str(refused.value).split("; ")
    assert len(pieces) == 3 and all(piece in said for piece in pieces), said
    line, key, words = refused.value.problems[0]
    assert text.splitlines()[line - 1].startswith("lenght_m") and key.endswith(".lenght_m") and "length_m" in words
    with pytest.raises(fw.FilesError, match="cannot be read"):
        fw.load(tmp_path / "none.toml")
    assert issubclass(fw.ModelError, ValueError) and issubclass(fw.FilesError, OSError)


def test_a_model_takes_the_files_that_it_names_with_it(command, tmp_path):
    """Polars are read from the model's folder, and are included in pickles and FMUs of the model."""
    folder = Path("examples/turbine")
    (tmp_path / "polars").mkdir()
    for polar in (folder / "polars").iterdir():
        (tmp_path / "polars" / polar.name).write_bytes(polar.read_bytes())
    file = tmp_path / "turbine.toml"
    file.write_text((folder / "nrel_5mw_wind.toml").read_text())
    turbine = fw.load(file)
    assert turbine.text == fw.load(folder / "nrel_5mw_wind.toml").text and "cylinder1.csv" not in turbine.text
    turbine.package(tmp_path / "ours.fmu", reference=False)
    subprocess.run([command, "package", file, "-o", tmp_path / "theirs.fmu", "--no-reference"], check=True)
    assert (tmp_path / "ours.fmu").read_bytes() == (tmp_path / "theirs.fmu").read_bytes()
    (tmp_path / "polars/cylinder1.csv").unlink()
    assert pickle.loads(pickle.dumps(turbine)).variables == turbine.variables
    with pytest.raises(fw.ModelError, match="polar.cylinder1.file") as refused:
        fw.load(file)
    assert refused.value.problems[0][1] == "polar.cylinder1.file"


def test_bad_inputs_are_refused_by_name(wing):
    times = [0.0, 0.1]
    for inputs, words in [
        ({"fold.external_torqe": 1.0}, "did you mean `fold.external_torque`?"),
        ({"fold.angle": 1.0}, "is not an input"),
        ({"fold.external_torque": [1.0, 2.0]}, "but there is no entry `time`"),
        ({"time": times, "fold.external_torque": [1.0]}, "1 values for 2 times"),
        ({"time": times, "fold.external_torque": [1.0, np.nan]}, "in row 1 is not a finite number"),
        ({"time": [0.1, 0.0], "fold.external_torque": [1.0, 2.0]}, "times must ascend"),
        ({"time": [0.1, 0.1, 0.1], "fold.external_torque": [1.0, 2.0, 3.0]}, "three rows"),
        ({"time": times, "fold.release": [1.0, 0.5]}, "is not a Boolean"),
        ({"fold.external_torque": "much"}, "not all values are numbers"),
        (3, "neither a mapping, a DataFrame nor a function"),
    ]:
        with pytest.raises(fw.UsageError) as refused:
            wing.simulate(stop=0.1, inputs=inputs)
        assert words in str(refused.value), str(refused.value)
    for arguments, words in [
        ({"stop": -1.0}, "must be after the start time"),
        ({"step": 0.0}, "must be positive"),
        ({"outputs": "fold.anlge"}, "did you mean `fold.angle`?"),
        ({"settings": {"fold.start_angle": 9.0}}, "it must be from"),
    ]:
        with pytest.raises(fw.UsageError) as refused:
            wing.simulate(**arguments)
        assert words in str(refused.value), str(refused.value)


def test_a_failed_run_keeps_what_was_computed(wing):
    def blow(time_s, sim):
        return {"load.outer[4].force.z": 0.0 if time_s < 0.05 else 1e12}

    pull = {"time": [0.0, 0.05, 0.0501], "load.outer[4].force.z": [0.0, 0.0, 1e12]}
    for inputs in (blow, pull):
        with pytest.raises(fw.SimulationError) as failed:
            wing.simulate(stop=0.2, inputs=inputs, outputs="fold.angle")
        result = failed.value.result
        assert 0.04 < result.time[-1] < 0.2 and len(result["fold.angle"]) == len(result.time)


def test_results_go_where_they_are_wanted(wing, tmp_path):
    run = wing.simulate(stop=0.2, outputs=["fold.*", "tip.position"])
    frame = run.to_pandas()
    assert frame.index.name == "time" and frame.attrs["units"]["fold.angle"] == "rad"
    assert np.array_equal(frame["tip.position.z"], run["tip.position"][:, 2])
    data = run.to_xarray()
    assert data["fold.angle"].attrs["units"] == "rad" and "joint fold" in data["fold.angle"].attrs["long_name"]
    assert all(wing.variables[name].causality == "output" for name in run)
    assert run.latch_times() == [run["fold.latch_time"][-1]]
    import matplotlib

    matplotlib.use("Agg")
    figure = run.plot(["fold.angle", "tip.position"])
    assert [axes.get_ylabel() for axes in figure.axes] == ["fold.angle (deg)", "position (m)"]
    page = run.view(tmp_path / "run.html", show=False)
    assert "FoldingWing" in page.read_text() and page.stat().st_size > 100_000
    (tmp_path / "mine.html").write_text("mine")
    with pytest.raises(fw.FilesError, match="not recognised"):
        run.view(tmp_path / "mine.html", show=False)
    with pytest.raises(KeyError, match="was not recorded"):
        run["gauge.root.strain"]


def test_films_are_decoded_with_their_length(wing, tmp_path, command):
    """The GIF by Pillow, the MP4 by FFmpeg if PyAV is installed: frames, length, size, and the wing in the last frame."""
    from PIL import Image

    run = wing.simulate(stop=0.2, outputs=["fold.angle"])
    film = run.video(tmp_path / "wing.gif", size=(320, 180), fps=10, speed=0.1, camera="fixed,side")
    assert (film.frames, film.speed, film.camera, film.span) == (21, 0.1, "fixed", (0.0, 0.2))
    assert "<img" in film._repr_html_() and repr(film).startswith("<foldwing.Video ")
    with Image.open(film.path) as image:
        assert image.n_frames == 21 and image.size == (320, 180)
        length = 0
        for number in range(image.n_frames):
            image.seek(number)
            length += image.info["duration"]
        assert length == 2100
        shown = np.asarray(image.convert("RGB"), dtype=float)
    exact = run.video(tmp_path / "wing.png", size=(320, 180), fps=10, speed=0.1, camera=["side", "fixed"])
    assert len(exact.files) == 21
    with Image.open(exact.files[-1]) as image:
        drawn = np.asarray(image.convert("RGB"), dtype=float)
    # 255 colours for the film: a few per cent error for rare colours
    assert np.abs(shown - drawn).mean() < 1.0 and (drawn < 250).any(axis=2).mean() > 0.02
    subprocess.run([command, "render", "examples/models/folding_wing.toml", "--stop", "0.2", "--video", tmp_path / "same.gif",
                    "--size", "320x180", "--fps", "10", "--speed", "0.1", "--camera", "side,fixed"], check=True, capture_output=True)  # fmt: skip
    assert (tmp_path / "same.gif").read_bytes() == film.path.read_bytes()
    film = run.video(size=(320, 180), fps=10, speed=0.1, camera="fixed,side")
    assert film.path.suffix == ".mp4" and "<video" in film._repr_html_()
    with pytest.raises(fw.UsageError, match="output=.*videos are .mp4"):
        run.video(tmp_path / "wing.webm")
    with pytest.raises(fw.UsageError, match="size=20x20: must be"):
        run.video(tmp_path / "wing.mp4", size=(20, 20))
    with pytest.raises(fw.UsageError, match="camera=.*below: must be follow, fixed"):
        run.video(tmp_path / "wing.mp4", camera="below")
    av = pytest.importorskip("av", reason="PyAV is not installed: the MP4 is decoded where it is")
    with av.open(str(film.path)) as container:
        images = [image.to_ndarray(format="rgb24") for image in container.decode(video=0)]
    assert len(images) == 21 and images[0].shape == (180, 320, 3)
    assert np.abs(images[-1] - drawn).mean() < 1.5  # chrominance has half the resolution


@pytest.fixture
def interruptible():
    """SIGINT raises KeyboardInterrupt however the tests were started: `nohup make test &` ignores it, and Python does not change this."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_ctrl_c_ends_whatever_lasts(wing, interruptible):
    long = {"stop": 1000.0, "outputs": "fold.angle"}
    goland, turbine = fw.load("examples/models/goland_wing.toml"), fw.load("examples/turbine/nrel_5mw_wind.toml")
    for work in (
        lambda: wing.simulate(**long),
        lambda: wing.sweep({"fold.start_angle": np.linspace(1.0, 2.0, 5000)}),
        lambda: wing.simulate(**long, inputs=lambda time_s, sim: None),
        lambda: goland.flutter(np.linspace(10.0, 130.0, 10_000)),
        lambda: goland.flutter_map("aero.density", [1.0, 1.1], np.linspace(10.0, 130.0, 10_000)),
        lambda: turbine.operating_points(np.linspace(4.0, 10.0, 5000), speed_rpm=9.0, steps=144),
        lambda: turbine.campbell(np.linspace(0.0, 10.0, 5000), undeformed=True),
    ):
        # a signal after the end of the work would interrupt pytest
        working = threading.Event()
        working.set()
        sent = []

        def interrupt():
            if working.is_set():
                sent.append(time.process_time())
                signal.raise_signal(signal.SIGINT)

        timer = threading.Timer(0.5, interrupt)
        timer.start()
        try:
            with pytest.raises(KeyboardInterrupt):
                try:
                    work()
                finally:
                    working.clear()
        finally:
            timer.cancel()
            timer.join()
        # duration for which the work continues, in processor time, which does not depend on the load of the computer
        assert time.process_time() - sent[0] < 5.0


def test_threads_run_beside_each_other(wing):
    """The interpreter lock is released: two threads simulate while a third counts."""
    counted = []
    stop = threading.Event()

    def count():
        while not stop.is_set():
            counted.append(None)
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    counter.start()
    time.sleep(0.02)
    before = len(counted)
    wing.simulate(stop=5.0, outputs="fold.angle")
    during = len(counted) - before
    stop.set()
    counter.join()
    assert during > 5, during


def test_models_from_code(wing):
    tree = {"name": "Beam", "section": {"spar": {"shape": "rectangle", "width_m": np.float64(0.1), "height_m": 0.004,
            "density_kg_m3": 1600, "youngs_modulus_Pa": 60e9, "poisson_ratio": 0.3}},
            "body": {"b": {"length_m": 0.5, "section": "spar", "elements": np.int64(4)}, "a": {"length_m": 0.2,
            "section": "spar", "elements": 2}},
            "joint": {"mount": {"type": "clamped", "parent": "root", "child": "b"},
                      "hinge": {"type": "revolute", "parent": "b", "child": "a", "axis": np.array([0.0, 1.0, 0.0])}}}
    model = fw.Model.from_dict(tree)
    names = [body["name"] for body in model.check().data["bodies"]]
    assert names == ["b", "a"], "in the order of the mapping"
    assert fw.Model(model.text).variables == model.variables
    tree["body"]["b"]["length_m"] = -1
    with pytest.raises(fw.ModelError, match="body.b.length_m"):
        fw.Model.from_dict(tree)
    tree["body"]["b"]["length_m"] = None
    with pytest.raises(fw.UsageError, match="from_dict"):
        fw.Model.from_dict(tree)
    assert pickle.loads(pickle.dumps(wing)).text == wing.text


def test_vectors_are_start_values(wing):
    """The name of a vector represents its components in every function with `settings`."""
    vector = {"gravity": [0.0, 0.0, -1.62]}
    parts = {"gravity.x": 0.0, "gravity.y": 0.0, "gravity.z": -1.62}
    runs = [wing.simulate(0.02, outputs="tip.position", settings=given)["tip.position"] for given in (vector, parts, {})]
    assert np.array_equal(runs[0], runs[1]) and not np.array_equal(runs[0], runs[2])
    held = {"fold.release": False}
    assert wing.static(settings={**held, **vector}).data == wing.static(settings={**held, **parts}).data
    assert wing.modes(2, settings={**held, "gravity": np.zeros(3)}).data == wing.modes(2, settings={**held, **dict.fromkeys(parts, 0.0)}).data
    assert wing.start(settings=vector)["gravity"].tolist() == vector["gravity"]
    tables = [wing.sweep({"fold.start_angle": [1.0, 2.0]}, stop=0.05, outputs="tip.position", settings=given) for given in (vector, parts)]
    assert all(np.array_equal(tables[0][name], tables[1][name]) for name in tables[0] if name != "message")
    with pytest.raises(fw.UsageError, match=r"settings: gravity: an array of shape \(2,\) for 3 components; give x, y, z"):
        wing.static(settings={"gravity": [0.0, 1.0]})
    with pytest.raises(fw.UsageError, match="settings: gravity: one number for 3 components"):
        wing.simulate(settings={"gravity": 9.81})
    with pytest.raises(fw.UsageError, match="gravity: 'down' is not a sequence of numbers"):
        wing.simulate(settings={"gravity": "down"})
    with pytest.raises(fw.UsageError, match="did you mean `gravity"):
        wing.simulate(settings={"gravty": [0.0, 0.0, 0.0]})


def test_steps_keep_the_pace(wing, monkeypatch):
    """Paced steps return on a fixed schedule, make up for late steps, and do not change results."""
    import foldwing.simulation as module

    class Clock:
        """A clock for which a step of the simulation takes `cost_s`."""

        now_s, cost_s = 100.0, 0.0

        def monotonic(self):
            return self.now_s

        def sleep(self, time_s):
            self.now_s += time_s

    clock = Clock()
    monkeypatch.setattr(module, "clock", clock)
    sim, plain = wing.start(), wing.start()
    sim.step(0.01, speed=1.0)
    assert clock.now_s == pytest.approx(100.01, abs=1e-12) and sim.late_s == 0.0
    # half speed starts a new schedule
    sim.step(0.01, speed=0.5)
    assert clock.now_s == pytest.approx(100.03, abs=1e-12)
    # other work between two steps shortens the wait
    clock.now_s += 0.015
    sim.step(0.01, speed=0.5)
    assert clock.now_s == pytest.approx(100.05, abs=1e-12) and sim.late_s == 0.0
    # a late step does not wait, and the next one is on time again
    clock.now_s += 0.03
    sim.step(0.01, speed=0.5)
    assert clock.now_s == pytest.approx(100.08, abs=1e-12) and sim.late_s == pytest.approx(0.01, abs=1e-12)
    sim.step(0.01, speed=0.5)
    assert clock.now_s == pytest.approx(100.09, abs=1e-12) and sim.late_s == 0.0
    # a step without pace ends the schedule, a restored state starts another one
    state = sim.save()
    sim.step(0.01)
    clock.now_s += 5.0
    sim.step(0.01, speed=1.0)
    assert clock.now_s == pytest.approx(105.10, abs=1e-12)
    sim.restore(state)
    clock.now_s += 5.0
    sim.step(0.01, speed=1.0)
    assert clock.now_s == pytest.approx(110.11, abs=1e-12) and sim.late_s == 0.0
    for _ in range(6):
        plain.step(0.01)
    assert plain["fold.angle"] == sim["fold.angle"]
    for speed in (0.0, -1.0, float("inf"), float("nan")):
        with pytest.raises(fw.UsageError, match="must be a positive, finite number of simulated seconds per second"):
            sim.step(0.01, speed=speed)


def test_names_are_completed(wing):
    run = wing.simulate(0.01, outputs=["tip.position", "fold.angle"])
    parts = {f"tip.position.{axis}" for axis in "xyz"}
    assert {"time", "fold.angle", "tip.position", *parts} == set(run._ipython_key_completions_())
    for name in run._ipython_key_completions_():
        assert len(run[name]) == len(run.time)
    sim = wing.start()
    assert {"gravity", "fold.angle"} <= set(sim._ipython_key_completions_())
    table = wing.sweep({"fold.start_angle": [1.0, 2.0]}, stop=0.01)
    assert set(table._ipython_key_completions_()) == set(table)
