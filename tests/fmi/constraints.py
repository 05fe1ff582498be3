"""Checks that FMUs of models with constraint forces have in common: rigid loops, skates and wheels."""

import fmpy
import numpy as np
from driving import Fmu, Instance
from fmpy.fmi3 import FMU3Slave

SAVED, LAST = 37, 97  # communication steps up to the saved state, and up to the end


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


def states_of_fmi_3_are_whole(path, folder, names, count, step_s):
    """FMI 3.0: the same for the variables of some names, which have `count` values together."""
    unzipped = fmpy.extract(str(path), str(folder))
    description = fmpy.read_model_description(str(path))
    chosen = [variable.valueReference for variable in description.modelVariables if variable.name in names]
    assert len(chosen) == len(names)

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
