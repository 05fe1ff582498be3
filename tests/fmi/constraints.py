"""Checks that tests of the FMUs of one model in both versions have in common: constraints, several aerodynamic models, DC motors."""

import csv
import re
import subprocess

import fmpy
import fmpy.validation
import numpy as np
from driving import Fmu, Instance
from fmpy.fmi3 import FMU3Slave

SAVED, LAST = 37, 97  # communication steps up to the saved state, and up to the end


def in_array(name):
    """Variable of FMI 3.0 that contains a scalar of FMI 2.0, and the place in it: vectors, and vectors at all stations, are arrays."""
    station = re.fullmatch(r"(.+)\[(\d+)\](\..+)\.([xyz])", name)
    if station:
        return station[1] + station[3], (int(station[2]) - 1, "xyz".index(station[4]))
    return (name[:-2], ("xyz".index(name[-1]),)) if name[-2:] in (".x", ".y", ".z") else (name, ())


def columns_of_the_command(foldwing, model, fmu, folder, names, step_s, stop_s):
    """Columns of variables, by the names of FMI 2.0, from `foldwing simulate`. FMPy finds no problem in the FMU, and its co-simulation gives
    the same bits."""
    out = folder / "out.csv"
    named = [word for name in names for word in ("--variables", name)]
    subprocess.run([foldwing, "simulate", model, "--csv", out, "-q", "--stop", str(stop_s), "--step", str(step_s), *named], check=True)
    with open(out) as file:
        rows = list(csv.DictReader(file))
    assert fmpy.validation.validate_fmu(str(fmu)) == []
    scalars = {variable.name for variable in fmpy.read_model_description(str(fmu)).modelVariables}
    places = {name: (name, ()) if name in scalars else in_array(name) for name in names}
    asked = sorted({variable for variable, _ in places.values()})
    found = fmpy.simulate_fmu(str(fmu), fmi_type="CoSimulation", stop_time=stop_s, output_interval=step_s, output=asked)
    assert len(rows) == len(found) == round(stop_s / step_s) + 1
    columns = {name: np.array([float(row[name]) for row in rows]) for name in names}
    for name, (variable, place) in places.items():
        assert np.array_equal(found[variable][(slice(None), *place)], columns[name]), name
    return columns


def states_are_whole(path, folder, step_s):
    """FMI 2.0: a saved state continues bit by bit, in the same instance and, as bytes, in another one, which has not moved."""
    fmu = Fmu(path, folder)
    first, second = Instance(fmu).initialize(), Instance(fmu).initialize()
    first.advance(SAVED, step_s)
    slave = first.slave
    state, time_s, there = slave.getFMUstate(), first.time_s, first.bits()
    onward = first.history(LAST - SAVED, step_s)
    assert onward[-1] != there
    slave.setFMUstate(state)
    first.time_s = time_s
    assert first.bits() == there
    assert first.history(LAST - SAVED, step_s) == onward
    copy = second.slave.deSerializeFMUstate(slave.serializeFMUstate(state))
    second.slave.setFMUstate(copy)
    second.time_s = time_s
    assert second.history(LAST - SAVED, step_s) == onward


def states_of_fmi_3_are_whole(path, folder, names, step_s):
    """FMI 3.0: the same for the variables of some names, which are those of FMI 2.0, with the arrays that contain them whole."""
    unzipped = fmpy.extract(str(path), str(folder))
    description = fmpy.read_model_description(str(path))
    arrays = {in_array(name)[0] for name in names}
    variables = [variable for variable in description.modelVariables if variable.name in arrays]
    assert len(variables) == len(arrays)
    chosen = [variable.valueReference for variable in variables]
    count = sum(int(np.prod(variable.shape)) if variable.shape else 1 for variable in variables)

    def started():
        slave = FMU3Slave(guid=description.guid, unzipDirectory=unzipped,
                          modelIdentifier=description.coSimulation.modelIdentifier, instanceName="constrained")
        slave.instantiate()
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        return slave

    def history(slave, first, last):
        rows = []
        for step in range(first, last):
            slave.doStep(step * step_s, step_s)
            rows.append(list(slave.getFloat64(chosen, nValues=count)))
        return rows

    one, other = started(), started()
    history(one, 0, SAVED)
    state = one.getFMUState()
    onward = history(one, SAVED, LAST)
    assert len({tuple(row) for row in onward}) == len(onward)
    one.setFMUState(state)
    assert history(one, SAVED, LAST) == onward
    other.setFMUState(other.deserializeFMUState(one.serializeFMUState(state)))
    assert history(other, SAVED, LAST) == onward
    for slave in (one, other):
        slave.terminate()
        slave.freeInstance()


def derivatives_are_slopes(path, folder, outputs, inputs, change, forces, step_s):
    """FMI 2.0 in the middle of the motion: directional derivatives of outputs by each input equal central differences; each input moves
    the first `forces` outputs, the constraint forces."""
    fmu = Fmu(path, folder)
    one = Instance(fmu).initialize()
    one.advance(20, step_s)
    for name in inputs:
        references = [[fmu.variables[v].valueReference for v in names] for names in (outputs, [name])]
        found = np.array(one.slave.getDirectionalDerivative(*references, [1.0]))
        sides = []
        for value in (change, -change):
            one.set(name, value)
            sides.append(np.array([one.get(output) for output in outputs]))
        one.set(name, 0.0)
        expected = (sides[0] - sides[1]) / (2.0 * change)
        # the outputs are linear in loads: what remains is their round-off over the difference
        assert np.abs(found - expected).max() < 1e-8 * np.abs(expected).max(), name
        assert np.abs(found[:forces]).max() > 1e-6, f"{name} does not change the constraint forces"
