"""Gradients of runs and identification: against the command, and for known parameters."""

import csv
import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

import foldwing as fw

WING = "examples/models/folding_wing.toml"
ARM = """
name = "Arm"
gravity_m_s2 = [0.0, 0.0, 0.0]

[rigid_body.arm]
mass_kg = 1.0
inertia_kg_m2 = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]

[joint.hinge]
type = "revolute"
parent = "root"
child = "arm"
axis = [0.0, 0.0, 1.0]
"""
OF = ["fold.latch_time", "peak(gauge.root.strain)", "tip.position@0.1"]
BY = ["fold.motor_stiffness", "file:body.outer.length_m"]


def test_gradient_is_that_of_the_command(command):
    words = [word for name in OF for word in ("--of", name)] + [word for name in BY for word in ("--by", name)]
    arguments = [command, "gradient", WING, *words, "--set", "fold.start_angle=2.8", "--stop", "0.25", "--json"]
    theirs = json.loads(subprocess.run(arguments, capture_output=True, text=True, check=True).stdout)
    wing = fw.load(WING)
    found = wing.gradient(OF, BY, stop=0.25, settings={"fold.start_angle": 2.8})
    assert found.data == theirs
    assert found.of == [*OF[:2], *(f"tip.position.{axis}@0.1" for axis in "xyz")] and found.by == BY
    assert found.jacobian.shape == (5, 2) and found.values.shape == found.times_s.shape == (5,)
    assert found["fold.latch_time", BY[0]] == found.jacobian[0, 0] and found.value(OF[0]) == found.values[0]
    weights = np.array([1.0, -2.0, 0.5, 0.0, 3.0])
    assert np.array_equal(found.vjp(weights), weights @ found.jacobian)
    assert "5 results by 2 numbers" in repr(found)
    adjoint = wing.gradient(OF, BY, stop=0.25, settings={"fold.start_angle": 2.8}, mode="adjoint")
    assert np.allclose(adjoint.jacobian, found.jacobian, rtol=1e-8, atol=1e-8 * np.abs(found.jacobian).max())
    assert (found.data["mode"], adjoint.data["mode"]) == ("forward", "adjoint")


def test_gradient_is_the_slope_of_runs_with_close_tolerance():
    """At a tolerance of 1e-9 and with damped strains, without which fast axial vibrations make the results fluctuate, differences of runs
    are accurate before the latch."""
    damped = {f"file:body.{name}.stiffness_damping_s": 1e-4 for name in ("inner", "outer")}
    wing = fw.load(WING).with_values({"file:solver.tolerance": 1e-9, **damped})
    of, by = ["fold.angle@0.08", "gauge.root.strain@0.08", "tip.position.z@0.08"], ["fold.motor_damping", "file:mass.actuator.mass_kg"]
    found = wing.gradient(of, by, stop=0.08)
    for column, (name, value) in enumerate(zip(by, found.numbers)):
        shift = 1e-3 * value

        def run(sign):
            there, settings = wing, {}
            if name.startswith("file:"):
                there = wing.with_values({name: value + sign * shift})
            else:
                settings = {name: value + sign * shift}
            return there.gradient(of, stop=0.08, settings=settings).values

        slope = (run(1.0) - run(-1.0)) / (2.0 * shift)
        assert found.jacobian[:, column] == pytest.approx(slope, rel=1e-4)


def test_relative_slopes_are_drawn():
    """GR-31: the change in % for 1 % is that of differences, positive for a negative result that increases; the figure has a text per
    cell."""
    pytest.importorskip("matplotlib", reason="Matplotlib is not installed: the figure is drawn where it is").use("Agg")
    found = fw.load(WING).gradient(["fold.latch_time", "min(gauge.root.strain)", "tip.position.y"], ["fold.motor_stiffness", "fold.external_torque"])
    assert found.relative.shape == (3, 2) and np.isnan(found.relative[2]).all() and np.isnan(found.relative[:, 1]).all()
    assert found.relative[0, 0] == found.jacobian[0, 0] * found.numbers[0] / found.values[0]
    assert found.values[1] < 0.0 and found.relative[1, 0] == found.jacobian[1, 0] * found.numbers[0] / -found.values[1]
    axes = found.plot().axes[0]
    texts = [text.get_text() for text in axes.texts]
    assert len(texts) == 6 and texts.count("\u2013") == 4 and f"{found.relative[0, 0]:.2g}".replace("-", "\u2212") in texts
    assert [label.get_text() for label in axes.get_yticklabels()] == found.by


def test_more_numbers_than_measurements_are_refused():
    with pytest.raises(fw.UsageError, match="1 measurements cannot determine 2 numbers"):
        fw.load(WING).fit({"fold.latch_time": 0.12}, ["fold.motor_damping", "fold.motor_stiffness"])
    with pytest.raises(fw.UsageError, match="max_runs=0"):
        fw.load(WING).fit({"fold.latch_time": 0.12}, ["fold.motor_damping"], max_runs=0)


def test_names_and_values_that_do_not_fit_are_refused():
    wing = fw.load(WING)
    refusals = [
        (lambda: wing.gradient("fold.angel", "fold.motor_damping"), fw.UsageError, "did you mean `fold.angle`"),
        (lambda: wing.gradient("fold.angle", "fold.motor_dampin"), fw.UsageError, "by=fold.motor_dampin"),
        (lambda: wing.gradient("fold.angle", "file:body.inner"), fw.UsageError, "is a table"),
        (lambda: wing.gradient("fold.angle", "solver.tolerance"), fw.UsageError, "setting of the integrator"),
        (lambda: wing.gradient("fold.angle", stop=-1.0), fw.UsageError, "stop=-1: must be after the start time"),
        (lambda: wing.gradient("fold.angle", mode="reverse"), fw.UsageError, "mode='reverse'"),
        (lambda: fw.load("examples/models/folding_wing_in_tunnel.toml").gradient("tip.position.z"), fw.FoldwingError, "gradients do not cover the vortex lattice"),
        (lambda: wing.with_values({"fold.damping": 1.0}), fw.UsageError, "not a key of the model file"),
        (lambda: wing.with_values({"file:name.first": 1.0}), fw.UsageError, "name is not a table"),
        (lambda: wing.with_values({"file:gravity_m_s2.3": 1.0}), fw.UsageError, "3 entries; indices start at 0"),
        (lambda: wing.with_values({"file:body.inner.length_m": -1.0}), fw.ModelError, "length_m"),
    ]
    for refused, kind, words in refusals:
        with pytest.raises(kind, match=words.replace("(", r"\(")):
            refused()
    with pytest.raises(KeyError, match="no number is named"):
        wing.gradient("fold.angle@0.01", "fold.motor_damping", stop=0.02)["fold.angle@0.01", "other"]


TRUTH = {"fold.motor_damping": 8e-4, "fold.motor_constant_torque": 0.043, "file:section.plate.youngs_modulus_Pa": 2.83e9}
SIGMA = {"fold.angle": 2e-3, "gauge.root.strain": 2e-5, "fold.latch_time": 1e-5}


def measured(wing, seed):
    """Angle and strain of a deployment to 0.16 s with noise, and its latch time."""
    random = np.random.default_rng(seed)
    clean = wing.gradient([f"{name}@{time!r}" for name in ("fold.angle", "gauge.root.strain") for time in TIMES] + ["fold.latch_time"], stop=0.16)
    columns = clean.values[:-1].reshape(2, -1)
    data = {"time": np.array(TIMES), "fold.latch_time": clean.values[-1] + SIGMA["fold.latch_time"] * random.standard_normal()}
    for name, column in zip(("fold.angle", "gauge.root.strain"), columns):
        data[name] = column + SIGMA[name] * random.standard_normal(len(TIMES))
    data["gauge.root.strain"][3] = np.nan
    return data


TIMES = [round(0.01 * point, 2) for point in range(17)]


def test_numbers_are_identified_within_their_standard_errors():
    """Three parameters, 20 % off at the start, from two noisy columns with a gap and the latch time: chi squared per degree of freedom, and
    the errors relative to their standard errors, are consistent with the noise (three standard errors)."""
    wing = fw.load(WING)
    data = measured(wing, 1)
    start = {name: 1.2 * value for name, value in TRUTH.items()}
    found = wing.fit(data, list(TRUTH), start=start, sigma=SIGMA)
    assert found.converged and found.runs <= 15 and not found.unidentified, found
    assert len(found.residuals) == len(found.measurements) == 2 * len(TIMES)
    degrees = len(found.residuals) - len(TRUTH)
    assert abs(np.sum(found.residuals**2) / degrees - 1.0) < 3.0 * np.sqrt(2.0 / degrees)
    for name, value in TRUTH.items():
        error = found.standard_errors[found.names.index(name)]
        assert abs(found[name] - value) < 3.0 * error < 0.1 * value, name
    assert np.allclose(np.diag(found.correlation), 1.0)
    # the fitted model with the fitted settings reproduces the residuals
    again = found.model.gradient(found.measurements, settings=found.settings, stop=0.4)
    assert again.value("fold.latch_time") == pytest.approx(data["fold.latch_time"] + SIGMA["fold.latch_time"] * found.residuals[found.measurements.index("fold.latch_time")])
    # an unknown noise level is estimated from the residuals; bounds hold; a robust loss limits an outlier
    bounded = wing.fit({"time": data["time"], "fold.angle": data["fold.angle"]}, {"fold.motor_damping": (0.0, 7e-4)}, start={"fold.motor_damping": 6e-4})
    assert bounded["fold.motor_damping"] == pytest.approx(7e-4) and 0.0 < bounded.noise < 1.0
    # steps stay within the ranges of the parameters: a damping does not become negative, whatever the measurements
    quick = {"time": data["time"][:8], "fold.angle": data["fold.angle"][:8] - 0.05 * np.arange(8)}
    assert 0.0 <= wing.fit(quick, ["fold.motor_damping"], max_runs=10)["fold.motor_damping"] < 7e-4
    data["gauge.root.strain"][9] += 50.0 * SIGMA["gauge.root.strain"]
    start = dict(zip(found.names, found.values))
    plain, robust = (wing.fit(data, list(TRUTH), start=start, sigma=SIGMA, loss=loss) for loss in ("linear", "soft_l1"))
    off = [np.abs(other.values - found.values) / found.standard_errors for other in (plain, robust)]
    assert off[0].max() > 3.0 and off[1].max() < 1.5, off


def test_a_direction_that_is_not_determined_is_named():
    """Mass and stiffness of the plate contain only products with its width: width up with density and modulus down changes nothing, so the
    three are not determined."""
    wing = fw.load(WING)
    free = ["file:section.plate.width_m", "file:section.plate.density_kg_m3", "file:section.plate.youngs_modulus_Pa", "fold.motor_damping"]
    data = measured(wing, 2)
    found = wing.fit(data, free, sigma=SIGMA, max_runs=6)
    assert np.isnan(found.standard_errors).all() and len(found.unidentified) == 1, found
    weak = found.unidentified[0]
    assert weak[free[1]] == pytest.approx(-weak[free[0]], rel=0.05) and weak[free[2]] == pytest.approx(-weak[free[0]], rel=0.05)
    assert abs(weak[free[3]]) < 0.05 and "not determined" in repr(found)


def test_data_that_do_not_fit_are_refused():
    wing = fw.load(WING)
    times = np.array([0.0, 0.1])
    refusals = [
        (dict(data={"fold.angle": times}, free=["fold.motor_damping"]), "but there is no entry `time`"),
        (dict(data={"time": times[::-1], "fold.angle": times}, free=["fold.motor_damping"]), "must increase"),
        (dict(data={"time": times, "fold.angle": times[:1]}, free=["fold.motor_damping"]), "one value per time"),
        (dict(data={"time": times}, free=["fold.motor_damping"]), "no measurement"),
        (dict(data={"time": times, "fold.angle": times}, free=[]), "no number is named"),
        (dict(data={"time": times, "fold.angle": times}, free=["fold.motor_damping"], start={"fold.stiffness": 1.0}), "is not free"),
        (dict(data={"time": times, "fold.angle": times}, free={"fold.motor_damping": (1.0, 2.0)}), "outside its bounds"),
        (dict(data={"time": times, "fold.angle": times}, free=["fold.motor_damping"], sigma=0.0), "must be positive"),
        (dict(data={"time": times, "fold.angle": times}, free=["fold.motor_damping"], sigma={"tip": 1.0}), "no value for fold.angle"),
        (dict(data={"time": times, "fold.angle": times}, free=["fold.motor_damping"], loss="l2"), "loss='l2'"),
        (dict(data={"time": times, "fold.angle": times}, free=["fold.motor_*"]), "name each number"),
        (dict(data=3.0, free=["fold.motor_damping"]), "a mapping of names to values"),
        (dict(data={"tip.position": 1.0}, free=["fold.motor_damping"]), "name each measurement"),
    ]
    for arguments, words in refusals:
        with pytest.raises(fw.UsageError, match=words.replace("*", r"\*")):
            wing.fit(**arguments)


def hats(times, rows):
    """Second integral of each row's contribution at the end, and the first: angle and rate of an arm of 1 kg·m² as functions of the row
    values."""
    grid = np.linspace(times[0], times[-1], 200_001)
    step = grid[1] - grid[0]
    rates, angles = [], []
    for row in rows:
        share = np.interp(grid, times, np.eye(len(times))[row])
        rate = np.concatenate([[0.0], np.cumsum(0.5 * (share[1:] + share[:-1]) * step)])
        rates.append(rate[-1])
        angles.append(np.sum(0.5 * (rate[1:] + rate[:-1]) * step))
    return np.array(angles), np.array(rates)


def test_gradient_by_rows_is_that_of_the_command(command, tmp_path):
    table = tmp_path / "push.csv"
    table.write_text("time,fold.external_torque,fold.release\n0,0,1\n0.05,0.01,1\n0.05,0.02,1\n0.1,0,1\n")
    arguments = [command, "gradient", WING, "--of", "fold.latch_time", "--by", "fold.external_torque@*", "--by", BY[0], "--inputs", table]
    theirs = json.loads(subprocess.run([*arguments, "--json"], capture_output=True, text=True, check=True).stdout)
    wing = fw.load(WING)
    push = {"time": [0.0, 0.05, 0.05, 0.1], "fold.external_torque": [0.0, 0.01, 0.02, 0.0]}
    found = wing.gradient("fold.latch_time", ["fold.external_torque@*", BY[0]], inputs=push)
    assert found.of == ["fold.latch_time"]
    assert found.by == [f"fold.external_torque@{row}" for row in ("0.0", "0.05-", "0.05+", "0.1")] + [BY[0]]
    assert found.jacobian == pytest.approx(np.array([theirs["of"][0]["derivatives"]]), rel=1e-12)
    one = wing.gradient("fold.latch_time", "fold.external_torque@0.05+", inputs=push)
    assert one.jacobian[0, 0] == pytest.approx(found.jacobian[0, 2], rel=1e-9)


@pytest.mark.parametrize(
    ("by", "inputs", "cause"),
    [
        ("fold.external_torque@0.1", None, "all inputs are constant"),
        ("fold.external_torque@0.07", {"time": [0.0, 0.1], "fold.external_torque": [0.0, 0.1]}, "no row is at 0.07 s; the nearest is at 0.1 s"),
        ("fold.external_torque@now", {"time": [0.0, 0.1], "fold.external_torque": [0.0, 0.1]}, "neither a time in s nor"),
        ("fold.external_torque", {"time": [0.0, 0.1], "fold.external_torque": [0.0, 0.1]}, "varies over time"),
        ("load.outer[4].force.z@0", {"time": [0.0, 0.1], "fold.external_torque": [0.0, 0.1]}, "not among the inputs over time"),
        ("fold.release@0", {"time": [0.0, 0.1], "fold.release": [True, True]}, "not a real number"),
        ("fold.external_torque@0.1", {"time": [0.1, 0.1], "fold.external_torque": [0.0, 0.1]}, "two rows are at 0.1 s"),
        ("fold.external_torque@0+", {"time": [0.0, 0.1], "fold.external_torque": [0.0, 0.1]}, "leave out the sign"),
        (["fold.external_torque@*", "fold.external_torque@0"], {"time": [0.0, 0.1], "fold.external_torque": [0.0, 0.1]}, "named twice"),
        ("fold.external_torque@0", {"fold.external_torque": lambda time: time}, "sample functions"),
    ],
)
def test_rows_that_do_not_exist_are_refused(by, inputs, cause):
    with pytest.raises(fw.UsageError, match=cause.replace("(", r"\(").replace("*", r"\*")):
        fw.load(WING).gradient("fold.latch_time", by, inputs=inputs)


def test_locks_close_during_the_run():
    """GR-36: a lock that an input closes and opens again, forward and adjoint."""
    inputs = {"time": [0.0, 0.05, 0.1], "fold.release": [True, False, True]}
    wing = fw.load(WING)
    forward, adjoint = (wing.gradient("fold.angle@0.11", "fold.motor_stiffness", inputs=inputs, stop=0.12, mode=mode) for mode in ("forward", "adjoint"))
    assert forward.jacobian[0, 0] != 0.0
    assert np.allclose(forward.jacobian, adjoint.jacobian, rtol=1e-8, atol=0.0)


def test_optimize_finds_the_optimum_of_a_linear_program():
    """GR-18: the largest rest-to-rest rotation of an arm of 1 kg·m² without a spring within 1 s, by 9 values of a torque of at most 2 N·m:
    a linear program in the values, solved by another method."""
    from scipy.optimize import linprog

    arm = fw.Model(ARM)
    times = np.linspace(0.0, 1.0, 9)
    found = arm.optimize(
        {"hinge.angle": -1.0},
        {"hinge.external_torque@*": (-2.0, 2.0)},
        constraints={"hinge.angular_velocity": 0.0},
        inputs={"time": times, "hinge.external_torque": np.zeros(9)},
        stop=1.0,
        tolerance=1e-10,
    )
    angles, rates = hats(times, range(9))
    known = linprog(-angles, A_eq=[rates], b_eq=[0.0], bounds=[(-2.0, 2.0)] * 9, method="highs")
    assert found.converged and found.violation < 1e-6, found.message
    assert found.results["hinge.angle"] == pytest.approx(-known.fun, rel=1e-6)
    assert found.inputs["hinge.external_torque"] == pytest.approx(known.x, abs=1e-4)
    assert found["hinge.external_torque@0.125"] == found.values[1] and len(found.history) == found.gradients <= found.runs


def test_optimize_meets_a_constraint_of_the_latch_time():
    """The smallest peak strain with a bound on the latch time: none of 40 numbers within the bounds that also satisfies it is better."""
    wing = fw.load(WING)
    of, name = ["peak(gauge.root.strain)", "fold.latch_time"], "fold.motor_damping"
    found = wing.optimize(of[0], {name: (0.0, 2e-3)}, constraints={of[1]: (None, 0.15)}, tolerance=1e-8)
    assert found.violation < 1e-6 and 0.0 <= found[name] <= 2e-3
    for value in np.linspace(0.0, 2e-3, 40):
        peak, latch_s = wing.gradient(of, settings={name: value}).values
        assert latch_s > 0.15 or abs(peak) >= found.objective * (1.0 - 1e-5), value
    again = found.model.gradient(of, settings=found.settings)
    assert abs(again.value(of[0])) == found.objective == found.results[of[0]]


def test_optimize_returns_the_best_point_when_the_runs_are_used_up():
    """The result is the best run, not the start, whose peak strain is 1.2 times that of the sixth run."""
    found = fw.load(WING).optimize("peak(gauge.root.strain)", {"fold.motor_damping": (0.0, 2e-3)}, max_runs=6)
    assert not found.converged and found.runs == 6 and "max_runs=6 is reached" in found.message
    assert found.objective <= min(found.history) and found.objective < 0.9 * found.history[0]


def test_optimize_goes_on_where_trials_fail():
    """The latest closing of the latch as a function of the motor's damping: beyond it the latch is not reached within the run, and trials
    fail there. The search ends near the limit, and is not reported as converged."""
    wing, name = fw.load(WING), "fold.motor_damping"
    found = wing.optimize({"fold.latch_time": -1.0}, {name: (0.0, 1.0)}, stop=0.3, max_runs=150)
    assert not found.converged and "trials fail beyond the best point: the run has no closing" in found.message, found.message
    assert 0.27 < found.results["fold.latch_time"] <= 0.3 and found.objective == -found.results["fold.latch_time"]
    with pytest.raises(fw.StaticsError, match="no closing of the latch"):
        wing.gradient("fold.latch_time", stop=0.3, settings={name: 1.5 * found[name]})


def test_fit_identifies_rows_of_an_input():
    """A torque over time and a parameter of the model, identified from the motion that they cause."""
    wing = fw.load(WING)
    truth = {"time": [0.0, 0.04, 0.08], "fold.external_torque": [0.01, -0.005, 0.008]}
    times = np.linspace(0.005, 0.09, 18)
    angles = wing.gradient([f"fold.angle@{float(time)!r}" for time in times], inputs=truth).values
    guess = {"time": truth["time"], "fold.external_torque": [0.0, 0.0, 0.0]}
    found = wing.fit({"time": times, "fold.angle": angles}, ["fold.external_torque@*"], inputs=guess)
    assert found.converged and found.inputs["fold.external_torque"] == pytest.approx(truth["fold.external_torque"], abs=1e-7)


def test_optimize_refuses_what_it_cannot_do():
    wing = fw.load(WING)
    refusals = [
        (lambda: wing.optimize("fold.latch_time", []), "no number is named"),
        (lambda: wing.optimize({}, ["fold.motor_damping"]), "no result is named"),
        (lambda: wing.optimize("fold.latch_time", ["fold.motor_damping"], start={"fold.motor_dampin": 1.0}), "is not free"),
        (lambda: wing.optimize("fold.latch_time", {"fold.motor_damping": (0.0, 1e-5)}), "outside its bounds"),
        (lambda: wing.optimize("fold.latch_time", ["fold.motor_damping"], constraints={"fold.angle": (1.0, 0.0)}), "lower and the upper limit"),
        (lambda: wing.optimize("tip.position", ["fold.motor_damping"]), "name each result"),
    ]
    for call, cause in refusals:
        with pytest.raises(fw.UsageError, match=cause):
            call()
    with pytest.raises(fw.StaticsError, match="no closing of the latch"):
        wing.optimize("fold.latch_time", {"fold.motor_damping": (0.0, 1.0)}, start={"fold.motor_damping": 0.9})


def random_gradients():
    """Models and derivatives that the test GR-82 has written: `make python` names the folder."""
    folder = os.environ.get("FOLDWING_GRADIENTS")
    return sorted(Path(folder).glob("gradient_*.json")) if folder else []


@pytest.mark.parametrize("path", random_gradients(), ids=lambda path: path.stem)
def test_gr86_random_machines_have_the_derivatives_of_the_command(path):
    """GR-86. Derivatives of random machines with events and inputs over time are those of the command, equal numbers in both modes, and
    products of both are equal to 1e-6 of their terms, as in GR-82: `⟨ȳ, J δ⟩ = ⟨Jᵀ ȳ, δ⟩`."""
    known = json.loads(path.read_text(encoding="utf-8"))
    model = fw.load(path.with_suffix(".toml"))
    table = path.with_suffix(".csv")
    inputs = None
    if table.exists():
        names, *rows = list(csv.reader(table.read_text(encoding="utf-8").splitlines()))
        inputs = dict(zip(names, np.array(rows, dtype=float).T))
    options = {"stop": known["stop"], "inputs": inputs}
    forward, adjoint = (model.gradient(known["of"], known["by"], mode=mode, **options) for mode in ("forward", "adjoint"))
    printed = np.array([row["derivatives"] for row in known["printed"]["of"]])
    assert np.array_equal(forward.jacobian, printed)
    sizes = np.where(forward.numbers == 0.0, 1.0, np.abs(forward.numbers))
    largest = np.abs(forward.jacobian * sizes).max(axis=1)
    random = np.random.default_rng(1)
    weights = random.uniform(-1.0, 1.0, len(forward.of)) / np.where(largest > 1e-4, largest, np.inf)
    along = random.uniform(-1.0, 1.0, len(forward.by)) * sizes
    terms = np.abs(weights[:, None] * forward.jacobian * along).sum()
    assert abs(weights @ (forward.jacobian @ along) - adjoint.vjp(weights) @ along) <= 1e-6 * terms
