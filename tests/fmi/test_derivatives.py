"""Derivatives of inputs, of outputs, and of outputs with respect to inputs and parameters, through FMPy."""

import math

import pytest
from driving import Instance, instance
from fmpy.fmi1 import FMICallException

LOAD, LOAD_N, OMEGA_1_S = "load.outer[4].force.z", 0.05, 125.0
PHASE_RAD = 0.7  # the first-order error comes from the load at the start: held loads act half a step late
END_S = 0.064  # before the latch closes


def under_sine(wing, steps, with_derivatives):
    """Fold angle in rad after a sinusoidal load that is set at the communication points."""
    with instance(wing) as fmu:
        fmu.initialize(solver__tolerance=1e-8)
        reference = fmu.fmu.variables[LOAD].valueReference
        for _ in range(steps):
            phase = OMEGA_1_S * fmu.time_s + PHASE_RAD
            fmu.set(LOAD, LOAD_N * math.sin(phase))
            if with_derivatives:
                fmu.slave.setRealInputDerivatives([reference], [1], [LOAD_N * OMEGA_1_S * math.cos(phase)])
            fmu.step(END_S / steps)
        return fmu.get("fold.angle")


def test_f70_input_derivatives_raise_the_order(wing):
    """F-70. With held values, the error of a sinusoidal load falls with the communication step; with derivatives, with its square.

    Orders of the two finest steps; the next power of the step changes them by a few per cent.
    """
    exact = under_sine(wing, 2048, True)

    def order(with_derivatives):
        coarse, fine = (abs(under_sine(wing, steps, with_derivatives) - exact) for steps in (64, 128))
        return math.log2(coarse / fine)

    held, interpolated = order(False), order(True)
    print(f"F-70: orders {held:.2f} held, {interpolated:.2f} with derivatives")
    assert held == pytest.approx(1, abs=0.15)
    assert interpolated == pytest.approx(2, abs=0.15)


def test_f71_output_derivatives_are_the_rates(wing):
    """F-71. The derivative of a position is the velocity in another output, to 1e-3: both are interpolated between the ends of a step."""
    with instance(wing) as fmu:
        fmu.initialize().advance(50, 1e-3)
        pairs = [("fold.angle", "fold.angular_velocity")] + [(f"tip.position.{i}", f"tip.velocity.{i}") for i in "xyz"]
        references = [wing.variables[of].valueReference for of, _ in pairs]
        derivatives = fmu.slave.getRealOutputDerivatives(references, [1] * len(pairs))
        for (of, rate), derivative in zip(pairs, derivatives):
            # interpolated separately between the ends of a step: they differ by the interpolation error
            assert derivative == pytest.approx(fmu.get(rate), rel=1e-3), of
        with pytest.raises(FMICallException):
            fmu.slave.getRealOutputDerivatives([wing.variables["fold.external_torque"].valueReference], [1])


def test_f72_directional_derivatives_in_initialization_mode(wing):
    """F-72. The derivatives of all outputs with respect to every Real input equal central differences between evaluations.

    1e-6 of the derivative, plus the round-off of the difference (1e-11 of the values, 1e-13, divided by the step). Initial values are
    polynomials of second degree in loads and root motion: large steps are exact.
    """
    outputs = [v.valueReference for v in wing.outputs if v.type == "Real"]
    inputs = [v for v in wing.description.modelVariables if v.causality == "input" and v.type == "Real"]
    made = Instance(wing)
    try:
        slave = made.slave
        forces = {row.valueReference for row in wing.description.modelVariables if "specific_force" in row.name}
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        for known in inputs:
            given = slave.getDirectionalDerivative(outputs, [known.valueReference], [1.0])
            value = made.get(known.name)
            sides = []
            size = 1e-3 if known.name.startswith("fold.") else 0.5
            for step in (size, -size):
                made.set(known.name, value + step)
                sides.append(slave.getReal(outputs))
            made.set(known.name, value)
            for reference, derivative, above, below in zip(outputs, given, *sides):
                difference = (above - below) / (2 * size)
                # specific forces are differences between accelerations and gravity
                gravity = 2 * 9.81 if reference in forces else 0.0
                allowed = 1e-6 * abs(derivative) + (1e-11 * (abs(above) + abs(below) + gravity) + 1e-13) / size
                assert abs(derivative - difference) <= allowed, (known.name, reference, derivative, difference)
    finally:
        made.slave.freeInstance()
