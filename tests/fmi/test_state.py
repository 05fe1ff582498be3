"""State, instances and life cycle: rollback, serialisation, independence, reset, memory."""

import multiprocessing
import sys

import pytest
from driving import Instance, answer_of, instance
from fmpy.fmi1 import FMICallException

# State outside the snapshot would be noticed at events: the latch closes at 0.1222 s.
BEFORE_LATCH = 121, 1e-3  # steps and their size in s
SPANNING_STEP_S = 2e-3
STEPS_BEYOND = 15


def test_f20_restored_state_repeats_the_step_bit_for_bit(either_wing):
    """F-20. Rollback: a step that includes the latching, repeated from a restored state, gives identical outputs.

    Equality is exact: same binary, same inputs, and no state outside the snapshot. The state is restored twice, the second time after the
    run has continued much further.
    """
    with instance(either_wing) as fmu:
        fmu.initialize().advance(*BEFORE_LATCH)
        at = fmu.time_s
        before = fmu.slave.getFMUstate()
        standing = fmu.bits()
        first = fmu.history(3, SPANNING_STEP_S)
        assert fmu.get("fold.latched")
        for excursion in (0, 50):
            fmu.advance(excursion, 1e-3)
            fmu.slave.setFMUstate(before)
            fmu.time_s = at
            assert not fmu.get("fold.latched")
            assert fmu.bits() == standing
            assert fmu.history(3, SPANNING_STEP_S) == first
        fmu.slave.freeFMUstate(before)


def test_f21_state_holds_inputs_and_parameters(wing):
    """F-21. Inputs and tunable parameters set after a snapshot are undone by restoring it."""
    with instance(wing) as fmu:
        fmu.initialize(fold__motor_stiffness=0.03).advance(20, 1e-3)
        at = fmu.time_s
        fmu.set("fold.external_torque", 0.01)
        state = fmu.slave.getFMUstate()
        expected = fmu.history(20, 1e-3)
        fmu.set("fold.external_torque", -0.02)
        fmu.set("fold.motor_stiffness", 0.05)
        fmu.slave.setFMUstate(state)
        fmu.time_s = at
        assert fmu.get("fold.external_torque") == 0.01 and fmu.get("fold.motor_stiffness") == 0.03
        assert fmu.history(20, 1e-3) == expected
        fmu.slave.freeFMUstate(state)


def continue_elsewhere(fmu_path, folder, serialized, time_s, steps, queue):
    """Body of the other process: restores a serialised state in a fresh instance and continues."""
    from driving import Fmu

    with instance(Fmu(fmu_path, folder)) as fmu:
        fmu.initialize()
        state = fmu.slave.deSerializeFMUstate(serialized)
        fmu.slave.setFMUstate(state)
        fmu.slave.freeFMUstate(state)
        fmu.time_s = time_s
        queue.put(fmu.history(steps, SPANNING_STEP_S))


def test_f22_serialised_state_continues_in_another_process(wing, tmp_path):
    """F-22. A state serialised during the deployment and restored in another process continues bit-identically past the latch."""
    with instance(wing) as fmu:
        fmu.initialize().advance(*BEFORE_LATCH)
        at = fmu.time_s
        state = fmu.slave.getFMUstate()
        serialized = fmu.slave.serializeFMUstate(state)
        assert fmu.slave.serializeFMUstate(state) == serialized
        fmu.slave.freeFMUstate(state)
        here = fmu.history(STEPS_BEYOND, SPANNING_STEP_S)
        assert fmu.get("fold.latched")

    context = multiprocessing.get_context("spawn")  # inherits nothing
    queue = context.Queue()
    other = context.Process(
        target=continue_elsewhere, args=(wing.path, str(tmp_path), serialized, at, STEPS_BEYOND, queue), daemon=True
    )
    other.start()
    assert answer_of(other, queue) == here


@pytest.mark.parametrize("damage", ["cut", "flipped", "empty", "foreign"])
def test_f23_damaged_or_foreign_state_is_refused(fmus, damage):
    """F-23. A serialised state that was truncated, changed, emptied or made by another model is rejected; the run continues."""
    with instance(fmus["folding_wing"]) as fmu, instance(fmus["three_bodies"]) as other:
        fmu.initialize().advance(10, 1e-3)
        other.initialize().advance(10, 1e-3)
        donor = other if damage == "foreign" else fmu
        state = donor.slave.getFMUstate()
        good = donor.slave.serializeFMUstate(state)
        flipped = good[: len(good) // 2] + bytes([good[len(good) // 2] ^ 1]) + good[len(good) // 2 + 1 :]
        bad = {"cut": good[:-1], "flipped": flipped, "empty": b"", "foreign": good}[damage]
        with pytest.raises(FMICallException):
            fmu.slave.deSerializeFMUstate(bad)
        before = fmu.bits()
        fmu.step(1e-3)
        assert fmu.bits() != before


def test_f24_interleaved_instances_equal_each_alone(wing):
    """F-24. Two instances with different inputs, stepped alternately, are bit-identical to single instances."""
    settings = [{}, {"fold__external_torque": 0.01, "gravity__z": -3.0}]

    def alone(values):
        with instance(wing) as fmu:
            return fmu.initialize(**values).history(150, 1e-3)

    with instance(wing, name="one") as one, instance(wing, name="two") as two:
        one.initialize(**settings[0])
        two.initialize(**settings[1])
        rows = [(one.advance(1, 1e-3).bits(), two.advance(1, 1e-3).bits()) for _ in range(150)]
    together = [list(column) for column in zip(*rows)]
    assert together == [alone(values) for values in settings]


def test_f25_reset_equals_fresh(wing):
    """F-25. After a run with other inputs and parameters, a reset instance is bit-identical to a new one."""
    with instance(wing) as fmu:
        fresh = fmu.initialize().history(150, 1e-3)
        fmu.slave.reset()
        fmu.initialize(fold__start_angle=1.0, fold__angle_command=0.2, body__outer__mass_factor=2.0).advance(50, 1e-3)
        fmu.slave.reset()
        assert fmu.initialize().history(150, 1e-3) == fresh


def anonymous_kib():
    """Resident anonymous memory of this process in KiB, counted page by page (the kernel's counters lag)."""
    with open("/proc/self/smaps") as file:
        return sum(int(line.split()[1]) for line in file if line.startswith("Anonymous:"))


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_f26_instantiating_and_freeing_leaves_memory_flat(wing):
    """F-26. Creating and freeing instances, half of them with steps and states, does not increase memory use.

    The memory of a process still grows by about 2 MiB in the first 1500 (Python collects cycles late, the allocator settles) and by less
    than 20 KiB in the next 1500 (measured). 256 KiB over the last 600 would be a leak of 0.4 KiB each; a table of variables has some 50
    KiB.
    """
    keeper = Instance(wing).initialize()  # keeps the library loaded

    def cycle(index):
        fmu = Instance(wing)
        if index % 2:
            fmu.initialize().advance(2, 1e-3)
            states = [fmu.slave.getFMUstate() for _ in range(3)]
            fmu.slave.freeFMUstate(states[0])  # the instance frees the other two
        fmu.slave.freeInstance()

    for index in range(1800):
        cycle(index)
    before = anonymous_kib()
    for index in range(600):
        cycle(index)
    grown_kib = anonymous_kib() - before
    keeper.slave.freeInstance()
    assert grown_kib < 256, f"memory grew by {grown_kib} KiB"


def test_f27_wrong_guid_is_refused(wing):
    """F-27. A description with the GUID of another model is rejected at instantiation."""
    from fmpy.fmi2 import FMU2Slave

    slave = FMU2Slave(
        guid="{00000000-0000-0000-0000-000000000000}",
        unzipDirectory=wing.folder,
        modelIdentifier=wing.description.coSimulation.modelIdentifier,
        instanceName="wing",
    )
    with pytest.raises(Exception, match="instantiate"):
        slave.instantiate()
    slave.freeLibrary()


def test_f28_bad_steps_are_refused_and_harm_nothing(wing):
    """F-28. Steps of zero or negative size and inconsistent times are rejected; the run continues unaffected."""
    with instance(wing) as fmu:
        undisturbed = fmu.initialize().history(20, 1e-3)
    with instance(wing) as fmu:
        fmu.initialize().advance(10, 1e-3)
        now = fmu.time_s
        for time_s, step_s in [(now, 0.0), (now, -1e-3), (now + 0.5, 1e-3), (now, float("nan"))]:
            with pytest.raises(FMICallException):
                fmu.slave.doStep(time_s, step_s)
        assert fmu.history(10, 1e-3) == undisturbed[10:]
