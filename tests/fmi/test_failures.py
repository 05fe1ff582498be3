"""Failures through FMPy, in FMI 2.0 and 3.0: an importer triggers them, and locates them in Model Exchange."""

import subprocess

import numpy as np
import pytest
from conftest import ROOT, whole
from driving import Fmu
from fmpy.validation import validate_fmu
from test_model_exchange import with_elements

TRIGGER_S = 0.08


@pytest.fixture(scope="module")
def failing(foldwing, tmp_path_factory):
    """FMU of a model of `examples/failures` for either version and both interface types, with its text modified by `change`."""
    folder = tmp_path_factory.mktemp("failing")

    def make(model, fmi, change=lambda text: text, elements=4):
        name = f"{model}_{fmi}_{elements}"
        path, fmu = folder / f"{name}.toml", folder / f"{name}.fmu"
        path.write_text(with_elements(change((ROOT / "examples/failures" / f"{model}.toml").read_text()), elements))
        command = [foldwing, "package", path, "-o", fmu, "--interface", "cs,me", "--no-reference", "--fmi", fmi]
        subprocess.run(command, check=True)
        return Fmu(fmu, folder / name)

    return make


def only_by_input(text):
    """The model text without the time of the failure."""
    return text.replace("at_time_s = 0.05", "# at_time_s = 0.05")


@pytest.mark.parametrize("fmi", ["2", "3"])
def test_f330_an_importer_triggers_a_failure(failing, fmi):
    """F-330. The trigger at 0.08 s keeps the latch open, which closes at 0.122 s without it.

    Only in co-simulation: FMPy also sets Boolean inputs of Model Exchange outside Event Mode, where the standard forbids it.
    """
    fmu = failing("latch_no_capture", fmi, only_by_input)
    assert validate_fmu(fmu.path) == []
    dtype = [("time", float), ("failure.latch.trigger", bool)]
    trigger = np.array([(0.0, False), (TRIGGER_S, False), (TRIGGER_S, True), (0.2, True)], dtype=dtype)
    names = ["fold.latched", "failure.latch.failed", "failure.latch.time"]
    arguments = {"stop_time": 0.15, "output_interval": 1e-3, "output": names, "fmi_type": "CoSimulation"}
    sound = fmu.simulate(**arguments)
    assert sound["fold.latched"][-1] and not sound["failure.latch.failed"][-1]
    failed = fmu.simulate(input=trigger, **arguments)
    assert not failed["fold.latched"][-1] and failed["failure.latch.failed"][-1]
    print(f"fails at {failed['failure.latch.time'][-1]} s")
    assert abs(failed["failure.latch.time"][-1] - TRIGGER_S) < 2e-3


@pytest.mark.parametrize("elements", [1, pytest.param(4, marks=whole)])
@pytest.mark.parametrize("fmi", ["2", "3"])
def test_f331_model_exchange_fails_as_co_simulation(failing, fmi, elements):
    """F-331. A bound on an angle is an event that FMPy's CVode locates: times agree to 1e-6 s, and angles after it to 1e-5 rad."""
    fmu = failing("motor_loss", fmi, elements=elements)
    names = ["fold.angle", "failure.motor.time", "energy.dissipated"]
    arguments = {"stop_time": 0.1, "output_interval": 1e-4, "output": names}
    found = fmu.simulate(fmi_type="ModelExchange", relative_tolerance=1e-9, **arguments)
    expected = fmu.simulate(fmi_type="CoSimulation", start_values={"solver.tolerance": 1e-9}, **arguments)
    differences = {name: abs(found[name][-1] - expected[name][-1]) for name in names}
    print(differences)
    assert expected["failure.motor.time"][-1] > 0
    assert differences["failure.motor.time"] < 1e-6
    assert differences["fold.angle"] < 1e-5 and differences["energy.dissipated"] < 1e-6
