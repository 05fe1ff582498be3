#!/usr/bin/env python3
"""Two-body system of Otsuka et al., Table 4, in Exudyn: Exudyn's part of `studies/compare_exudyn.py`.

Body A is clamped at the origin, a hinge about Y connects body B; both start along +X, gravity is 9.8 m/s² along -Z. Exudyn's planar
beams lie in its x-y plane: the paper's X is its x, the paper's Z its y.

  cable  ObjectANCFCable2D: Euler-Bernoulli, cubic, 2 nodes; no rotary inertia
  ge     ObjectBeamGeometricallyExact2D: Reissner, quadratic, 3 nodes; rotary inertia 0.1 kg·m, GA = 1e7 N

The model is a copy of the script, written for this project, that generated `tests/reference/two_body_exudyn_*.csv`. Differences: it is a
function, and solver and output interval can be chosen. Times are those of `SolveDynamic` alone.

  pip install -r python/requirements-peers.txt
  python benches/peers/exudyn_two_body.py --beam ge --elements 6 --step 0.01
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
    MarkerNodePosition,
    ObjectANCFCable2D,
    ObjectBeamGeometricallyExact2D,
    RevoluteJoint2D,
    SensorNode,
)

LENGTH_M, GRAVITY_M_S2, END_S = 10.0, 9.8, 5.0
SECTION = dict(massPerLength=1.0, bendingStiffness=1e4, axialStiffness=1e7)
SOLVERS = {"dense": exu.LinearSolverType.EXUdense, "sparse": exu.LinearSolverType.EigenSparse}


def settings(elements, beam="ge", step_s=0.01, tolerance=1e-6, solver="sparse", spectral_radius=0.9):
    """Simulation settings and template of a beam element with the constraints of its clamped end."""
    chosen = exu.SimulationSettings()
    integration = chosen.timeIntegration
    integration.numberOfSteps, integration.endTime = int(round(END_S / step_s)), END_S
    integration.generalizedAlpha.spectralRadius = spectral_radius
    integration.newton.useModifiedNewton = True
    integration.newton.relativeTolerance, integration.newton.absoluteTolerance = tolerance, min(1e-8, tolerance)
    integration.adaptiveStep = False
    integration.verboseMode = 0
    chosen.solution.file.write = False
    chosen.linearSolver.solverType = SOLVERS[solver]
    chosen.parallel.numberOfThreads = 1
    if beam == "cable":
        return chosen, ObjectANCFCable2D(nodeNumbers=[0, 0], **SECTION), [1, 1, 0, 1]
    element = ObjectBeamGeometricallyExact2D(
        nodeNumbers=[0, 0, 0], crossSectionInertia=0.1, shearStiffness=1e7, **SECTION
    )
    return chosen, element, [1, 1, 1]


def solve(elements, output_s=0.01, **choices):
    """Times in s and the Z coordinate of the free end in m at multiples of `output_s`; raises `exudyn.SolverError` if the solver fails."""
    chosen, template, clamp = settings(elements, **choices)
    chosen.solution.sensors.writePeriod = output_s
    container = exu.SystemContainer()
    system = container.AddSystem()
    gravity = [0, -GRAVITY_M_S2, 0]
    start, hinge, end = [0, 0, 0], [LENGTH_M, 0, 0], [2 * LENGTH_M, 0, 0]
    inner = GenerateBeamElementsAlongLine(
        system, start, hinge, elements, template, gravity=gravity, groundConstraintsStart=clamp
    )
    outer = GenerateBeamElementsAlongLine(system, hinge, end, elements, template, gravity=gravity)
    held = [system.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in (inner["nodes"][-1], outer["nodes"][0])]
    system.AddObject(RevoluteJoint2D(markerNumbers=held))
    tip = system.AddSensor(
        SensorNode(nodeNumber=outer["nodes"][-1], storeInternal=True, outputVariableType=exu.OutputVariableType.Position)
    )
    system.Assemble()

    wall_s, processor_s = time.perf_counter(), time.process_time()
    system.SolveDynamic(chosen)
    processor_s, wall_s = time.process_time() - processor_s, time.perf_counter() - wall_s
    path = system.GetSensorStoredData(tip)
    return {
        "processor_s": processor_s,
        "wall_s": wall_s,
        "steps": int(chosen.timeIntegration.numberOfSteps),
        "coordinates": len(system.systemData.GetODE2Coordinates()),
        "time_s": path[:, 0],
        "tip_z_m": path[:, 2],
    }


def main():
    """Solves once and prints time, RMS and the end of the path."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--beam", choices=["cable", "ge"], default="ge")
    parser.add_argument("--elements", type=int, default=6, help="elements per body")
    parser.add_argument("--step", type=float, default=0.01, help="s")
    parser.add_argument("--tolerance", type=float, default=1e-6, help="relative, of Newton's iteration")
    parser.add_argument("--solver", choices=sorted(SOLVERS), default="sparse")
    given = parser.parse_args()
    result = solve(given.elements, beam=given.beam, step_s=given.step, tolerance=given.tolerance, solver=given.solver)
    rms_m = np.sqrt(np.mean(result["tip_z_m"][1:] ** 2))
    print(
        f"{given.beam}, {given.elements} elements, {result['coordinates']} coordinates: "
        f"{1e3 * result['processor_s']:.1f} ms of processor time, RMS(Z) {rms_m:.6f} m, Z at 5 s {result['tip_z_m'][-1]:.5f} m"
    )


if __name__ == "__main__":
    main()
