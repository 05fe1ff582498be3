"""FMI 2.0 Model Exchange through FMPy: its checks, its CVode, against co-simulation of the same FMU."""

import subprocess

import numpy as np
import pytest
from conftest import MODELS, ROOT, WHOLE, whole
from driving import Fmu
from fmpy.validation import validate_fmu

STRIPS = {"flared_wing_tip", "goland_wing", "slender_wing"}
SAMPLED = {"folding_wing_in_tunnel"}
FREE_OF_AIR = [model for model in MODELS if model not in STRIPS | SAMPLED]
LATCH_S = 1e-6  # allowed difference of latch times at a tolerance of 1e-9
TOLERANCE = 1e-9


@pytest.fixture(scope="session")
def exchanged(foldwing, tmp_path_factory):
    """FMUs of both interface types, by the name of the model file."""
    folder = tmp_path_factory.mktemp("exchanged")

    def make(model, elements=4):
        name = f"{model}_{elements}"
        fmu = folder / f"{name}.fmu"
        if not fmu.exists():
            path = folder / f"{name}.toml"
            path.write_text(with_elements((ROOT / "examples/models" / f"{model}.toml").read_text(), elements))
            subprocess.run(
                [foldwing, "package", path, "-o", fmu, "--interface", "cs,me", "--no-reference"], check=True
            )
        return Fmu(fmu, folder / name)

    return make


def with_elements(text, elements):
    """A model text with another number of elements per body than the shipped four: the time of CVode grows at least with the cube of this
    number, while latches and failures are events of the hinge and hardly depend on the mesh."""
    return text if elements == 4 else text.replace("elements = 4", f"elements = {elements}")


@pytest.mark.parametrize("model", FREE_OF_AIR)
def test_f300_shipped_models_run_in_model_exchange(model, exchanged):
    """F-300. Every shipped machine without aerodynamics: FMPy finds no problem in the FMU and integrates it with CVode at a tolerance of
    1e-6 (FMPy allows 500 steps per output, so outputs are 50 µs apart); angles and positions of tips agree with co-simulation to 1e-4 of
    their scale. The first 5 ms, in full studies 20 ms."""
    fmu = exchanged(model)
    assert validate_fmu(fmu.path) == []
    assert fmu.description.modelExchange is not None
    points = 400 if WHOLE else 100
    stop_s = 5e-5 * points
    names = [v.name for v in fmu.outputs if v.type == "Real" and v.name.endswith((".angle", ".position.z"))]
    arguments = {"stop_time": stop_s, "output_interval": stop_s / points, "output": names, "record_events": False}
    found = fmu.simulate(fmi_type="ModelExchange", relative_tolerance=1e-6, **arguments)
    expected = fmu.simulate(
        fmi_type="CoSimulation", start_values={"solver.tolerance": 1e-8}, **arguments
    )
    assert len(found) == len(expected) == points + 1
    worst = max(np.abs(found[name] - expected[name]).max() for name in names)
    print(f"{model}: {fmu.description.numberOfContinuousStates} states, worst difference {worst:.1e}")
    assert worst < 1e-4


@pytest.mark.parametrize("elements", [1, pytest.param(4, marks=whole)])
def test_f301_the_wing_latches_as_in_co_simulation(exchanged, elements):
    """F-301. FMPy's CVode at a tolerance of 1e-9 finds the latch by the event indicator, within 1e-6 s of co-simulation at the same
    tolerance, and strains and energies after it agree to 1e-6."""
    fmu = exchanged("folding_wing", elements)
    arguments = {"stop_time": 0.13, "output_interval": 1e-4}
    found = fmu.simulate(fmi_type="ModelExchange", relative_tolerance=TOLERANCE, **arguments)
    expected = fmu.simulate(
        fmi_type="CoSimulation", start_values={"solver.tolerance": TOLERANCE}, **arguments
    )
    latch_s, reference_s = found["fold.latch_time"][-1], expected["fold.latch_time"][-1]
    print(f"latch at {latch_s:.9f} s, {latch_s - reference_s:+.1e} s beside co-simulation")
    assert found["fold.latch_count"][-1] == 1
    assert abs(latch_s - reference_s) < LATCH_S
    events = found["time"][np.flatnonzero(np.diff(found["time"]) == 0)]
    assert latch_s in events, "the importer has located the event"
    for name in ["fold.angle", "gauge.root.strain", "energy.total", "energy.work", "energy.dissipated"]:
        difference = abs(found[name][-1] - expected[name][-1])
        print(f"{name}: {difference:.1e}")
        assert difference < 1e-6, name


@pytest.mark.parametrize("model", sorted(STRIPS))
def test_f332_strips_are_part_of_the_equations(model, exchanged):
    """F-332. Machines with strip theory: FMPy finds no problem in the FMU and integrates it with CVode; tips and angles agree with
    co-simulation, whose aerodynamic steps are of second order, within 1 % of their motion. The tolerance is 1e-7, because one joint moves
    by only 7e-5 rad. HY-02 is the comparison with refined steps in the engine."""
    fmu = exchanged(model)
    assert validate_fmu(fmu.path) == []
    lags = [variable for variable in fmu.description.modelVariables if ".lag[" in variable.name and variable.name.startswith("state.")]
    assert lags and all(variable.declaredType.name == "Velocity" for variable in lags)
    stop_s = 0.1
    names = [v.name for v in fmu.outputs if v.type == "Real" and v.name.endswith((".angle", ".position.z"))]
    arguments = {"stop_time": stop_s, "output_interval": stop_s / 1000, "output": names, "record_events": False}
    found = fmu.simulate(fmi_type="ModelExchange", relative_tolerance=1e-7, **arguments)
    expected = fmu.simulate(fmi_type="CoSimulation", start_values={"solver.tolerance": 1e-8}, **arguments)
    for name in names:
        moved = np.ptp(expected[name])
        difference = np.abs(found[name] - expected[name]).max()
        print(f"{model} {name}: {difference:.1e} of {moved:.1e}")
        # CVode has an error of 1e-7 m for motionless points
        assert difference < 0.01 * moved + 1e-7, name


@pytest.mark.parametrize("model", sorted(SAMPLED))
def test_f302_sampled_air_is_refused_by_name(model, foldwing, tmp_path):
    """F-302. A lattice has fixed aerodynamic steps: no Model Exchange, and the message gives the remedy."""
    path = ROOT / "examples/models" / f"{model}.toml"
    command = [foldwing, "package", path, "-o", tmp_path / "x.fmu", "--interface", "cs,me", "--no-reference"]
    outcome = subprocess.run(command, capture_output=True, text=True)
    assert outcome.returncode == 1
    assert "--interface me" in outcome.stderr and "[aerodynamics]" in outcome.stderr and "strip" in outcome.stderr
    assert not (tmp_path / "x.fmu").exists()
