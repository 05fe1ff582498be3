#!/usr/bin/env python3
"""Deployment of Otsuka et al., Table 5, without aerodynamics in Exudyn: Exudyn's part of `studies/compare_exudyn.py`.

Body A is clamped at the origin along +X, body B starts at the hinge, rotated by 170 degrees. Exudyn's planar beams lie in its x-y plane:
the paper's X is its x, the paper's Z its y. Torque of the hinge on B: -(k θ + c θ' + T), reaction on A. Geometrically exact beam
elements with 3 nodes; the mass-proportional damping, of the beams only, is lumped at the nodes. From the first step that starts with θ
<= 0, the latch multiplies k by 1e4.

The model is a copy of a script written for this project, whose figures are given in the design. Differences: it is a function; values
that never varied are constants; the latch time is interpolated in the function called before each step; sensors store values at the
output interval, not at every step. Times are those of `SolveDynamic` alone.

  pip install -r python/requirements-peers.txt
  python benches/peers/exudyn_folding_wing.py --elements 15 --step 5e-5
"""
import argparse
import os
import sys
import time

os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.exudynFast = True  # Exudyn's module without range checks

import exudyn as exu
import numpy as np
from exudyn.beams import GenerateBeamElementsAlongLine
from exudyn.itemInterface import (
    CoordinateSpringDamper,
    Force,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    ObjectBeamGeometricallyExact2D,
    ObjectRigidBody2D,
    RevoluteJoint2D,
    SensorBody,
)

LENGTH_M, WIDTH_M, HEIGHT_M = 0.15, 0.05, 0.002
YOUNG_PA, DENSITY_KG_M3, POISSON = 2.83e9, 1425.0, 0.3
AREA_M2 = WIDTH_M * HEIGHT_M
BENDING_N_M2 = YOUNG_PA * WIDTH_M * HEIGHT_M**3 / 12
MASS_KG_M = DENSITY_KG_M3 * AREA_M2
ACTUATOR_KG = 0.0203
STIFFNESS_N_M_RAD, DAMPING_N_M_S_RAD, TORQUE_N_M = 0.026, 0.0008, 0.043
LATCH_RATIO = 1e4
MASS_DAMPING_1_S = 2.5
GRAVITY_M_S2 = [-9.8, 0.0, 0.0]
START_RAD = np.radians(170.0)
GAUGE_M = 0.02
END_S = 0.4
SOLVERS = {"dense": exu.LinearSolverType.EXUdense, "sparse": exu.LinearSolverType.EigenSparse}


class Wing:
    """The machine in Exudyn, with its sensors and latch."""

    def __init__(self, elements, most_steps):
        self.elements, self.steps_left = elements, most_steps
        self.container = exu.SystemContainer()
        self.system = self.container.AddSystem()
        template = ObjectBeamGeometricallyExact2D(
            massPerLength=MASS_KG_M,
            crossSectionInertia=DENSITY_KG_M3 * WIDTH_M * HEIGHT_M**3 / 12,
            bendingStiffness=BENDING_N_M2,
            axialStiffness=YOUNG_PA * AREA_M2,
            shearStiffness=5 / 6 * AREA_M2 * YOUNG_PA / (2 * (1 + POISSON)),
            nodeNumbers=[0, 0, 0],
        )
        hinge = np.array([LENGTH_M, 0, 0])
        tip = hinge + LENGTH_M * np.array([np.cos(START_RAD), np.sin(START_RAD), 0])
        self.inner = GenerateBeamElementsAlongLine(
            self.system, [0, 0, 0], list(hinge), elements, template, gravity=GRAVITY_M_S2, groundConstraintsStart=[1, 1, 1]
        )
        self.outer = GenerateBeamElementsAlongLine(
            self.system, list(hinge), list(tip), elements, template, gravity=GRAVITY_M_S2
        )
        self.ground = self.coordinate(self.system.AddNode(NodePointGround(referenceCoordinates=[0, 0, 0])), 0)
        self.before, self.after = self.inner["nodes"][-1], self.outer["nodes"][0]
        self.latch_s, self.previous, self.end_s = None, (0.0, START_RAD), 0.0
        self.add_hinge()
        self.add_damping()
        self.gauges = self.add_gauges()
        self.system.SetPreStepUserFunction(self.before_step)
        self.system.Assemble()

    def coordinate(self, node, index):
        """Marker on a coordinate of a node."""
        return self.system.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=index))

    def place(self, node):
        """Marker on a node's position."""
        return self.system.AddMarker(MarkerNodePosition(nodeNumber=node))

    def add_hinge(self):
        """Hinge, drive and the actuator's mass."""
        self.system.AddObject(RevoluteJoint2D(markerNumbers=[self.place(self.before), self.place(self.after)]))
        self.system.AddObject(ObjectRigidBody2D(mass=ACTUATOR_KG, inertia=0.0, nodeNumber=self.before))
        weight = [ACTUATOR_KG * component for component in GRAVITY_M_S2]
        self.system.AddLoad(Force(markerNumber=self.place(self.before), loadVector=weight))
        self.drive = self.system.AddObject(
            CoordinateSpringDamper(
                markerNumbers=[self.coordinate(self.before, 2), self.coordinate(self.after, 2)],
                stiffness=STIFFNESS_N_M_RAD,
                damping=DAMPING_N_M_S_RAD,
                offset=-(START_RAD + TORQUE_N_M / STIFFNESS_N_M_RAD),
            )
        )

    def add_damping(self):
        """Mass-proportional damping, lumped at the nodes by Simpson's rule."""
        for body in (self.inner, self.outer):
            weights = np.zeros(len(body["nodes"]))
            for element in range(self.elements):
                weights[2 * element : 2 * element + 3] += MASS_KG_M * LENGTH_M / self.elements * np.array([1, 4, 1]) / 6
            for node, mass_kg in zip(body["nodes"], weights):
                for index in (0, 1):
                    markers = [self.ground, self.coordinate(node, index)]
                    self.system.AddObject(
                        CoordinateSpringDamper(markerNumbers=markers, damping=MASS_DAMPING_1_S * mass_kg)
                    )

    def add_gauges(self):
        """Sensors of the bending moment at the gauge; two if it lies between elements."""
        length_m = LENGTH_M / self.elements
        first = int(GAUGE_M / length_m - 1e-9)
        places = [(first, GAUGE_M - (first + 0.5) * length_m)]
        if abs(GAUGE_M / length_m - round(GAUGE_M / length_m)) < 1e-9 and first + 1 < self.elements:
            places.append((first + 1, -0.5 * length_m))
        kind = exu.OutputVariableType.TorqueLocal
        return [
            self.system.AddSensor(
                SensorBody(
                    bodyNumber=self.inner["elements"][element],
                    localPosition=[place, 0, 0],
                    storeInternal=True,
                    outputVariableType=kind,
                )
            )
            for element, place in places
        ]

    def before_step(self, system, time_s):
        """Closes the latch at the first step that starts beyond the latch angle; stops a run whose steps shrink without limit.

        `time_s` is the end of the next step; the coordinates belong to the end of the last accepted step. If they have not
        changed, the last step was rejected and a shorter one is tried.
        """
        self.steps_left -= 1
        if self.latch_s is None:
            kind = exu.OutputVariableType.Coordinates
            angle = START_RAD + system.GetNodeOutput(self.after, kind)[2] - system.GetNodeOutput(self.before, kind)[2]
            last_s, last = self.previous
            if angle != last:
                self.previous = (self.end_s, angle)
            if angle <= 0:
                self.latch_s = last_s + (self.end_s - last_s) * last / (last - angle)
                stiffness = LATCH_RATIO * STIFFNESS_N_M_RAD
                system.SetObjectParameter(self.drive, "stiffness", stiffness)
                system.SetObjectParameter(self.drive, "offset", -(START_RAD + TORQUE_N_M / stiffness))
            self.end_s = time_s
        return self.steps_left > 0

    def strain(self):
        """Strain of the upper face at the gauge, at the output times."""
        moments = [self.system.GetSensorStoredData(gauge)[:, -1] for gauge in self.gauges]
        return 0.5 * HEIGHT_M * np.mean(moments, axis=0) / BENDING_N_M2


def solve(elements, output_s=4e-4, step_s=1e-4, tolerance=1e-6, solver="sparse", spectral_radius=0.8):
    """Times in s, latch time in s (None if the latch stays open) and peak strain; raises `exudyn.SolverError` if the solver fails."""
    wing = Wing(elements, most_steps=int(4 * END_S / step_s))
    chosen = exu.SimulationSettings()
    integration = chosen.timeIntegration
    integration.numberOfSteps, integration.endTime = int(round(END_S / step_s)), END_S
    integration.generalizedAlpha.spectralRadius = spectral_radius
    integration.newton.useModifiedNewton = True
    integration.newton.relativeTolerance, integration.newton.absoluteTolerance = tolerance, 1e-10
    integration.adaptiveStep = True
    integration.minimumStepSize = 1e-9
    integration.adaptiveStepRecoverySteps = 3
    integration.verboseMode = 0
    chosen.solution.file.write = False
    chosen.solution.sensors.writePeriod = output_s
    chosen.linearSolver.solverType = SOLVERS[solver]
    chosen.parallel.numberOfThreads = 1

    wall_s, processor_s = time.perf_counter(), time.process_time()
    wing.system.SolveDynamic(chosen)
    processor_s, wall_s = time.process_time() - processor_s, time.perf_counter() - wall_s
    if wing.steps_left <= 0:
        raise exu.SolverError(f"more than four times as many steps as of {step_s} s")
    return {
        "processor_s": processor_s,
        "wall_s": wall_s,
        "steps": int(integration.numberOfSteps),
        "coordinates": len(wing.system.systemData.GetODE2Coordinates()),
        "latch_s": wing.latch_s,
        "peak_strain": float(np.abs(wing.strain()).max()),
    }


def main():
    """Solves once and prints time, latch time and peak strain."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--elements", type=int, default=15, help="elements per body")
    parser.add_argument("--step", type=float, default=5e-5, help="s")
    parser.add_argument("--tolerance", type=float, default=1e-6, help="relative, of Newton's iteration")
    parser.add_argument("--solver", choices=sorted(SOLVERS), default="sparse")
    given = parser.parse_args()
    result = solve(given.elements, step_s=given.step, tolerance=given.tolerance, solver=given.solver)
    print(
        f"{given.elements} elements, {result['coordinates']} coordinates: {result['processor_s']:.3f} s of processor time, "
        f"latch at {result['latch_s']:.6f} s, peak strain {result['peak_strain']:.4e}"
    )


if __name__ == "__main__":
    main()
