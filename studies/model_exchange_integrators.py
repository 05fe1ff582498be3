"""Integrators of importers on the Model Exchange FMUs of the shipped models: errors and processor times as a table, row ME-20.

    python3 -m venv casadi && casadi/bin/pip install casadi==3.8.2 fmpy scipy
    casadi/bin/python studies/model_exchange_integrators.py --foldwing target/release/foldwing [--table OUT.md] [--models NAME ...]

Every model without a lattice is integrated from its start over 20 ms by FMPy's CVode, SciPy's Radau, BDF and LSODA, CasADi's CVODES and
IDAS, and by explicit methods with `solver.frequency_limit`. The error is the largest difference of fold angles in rad and of places of
tips in m at the end from the reference, relative to the largest motion: still air, co-simulation at a tolerance of 1e-9; strips, whose
co-simulation takes aerodynamic steps, SciPy's Radau at 1e-9 in Model Exchange. The limit changes the equations: the column of explicit
methods is compared with a reference without the limit. `!` is a failure, whose message follows the table.
"""

import argparse
import contextlib
import io
import subprocess
import tempfile
import time
from pathlib import Path

import casadi
import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Model
from scipy.integrate import solve_ivp

ROOT = Path(__file__).resolve().parents[1]
STOP_S = 0.02
TOLERANCE = 1e-6
LIMIT_RAD_S, EULER_LIMIT_RAD_S, EULER_STEP_S = 3000.0, 1000.0, 1e-5
STRIPS = ("flared_wing_tip", "goland_wing")
AIR_IN_STEPS = ("folding_wing_in_tunnel",)
# starts in equilibrium and meets its gust at 0.5 s: the motion of 20 ms, by which errors are divided, is round-off (1.9e-12 of the states
# after 1 ms), and a tolerance of 1e-9 resolves this round-off
AT_REST = ("slender_wing",)


HEAD = """\
# Integrators of importers on the Model Exchange FMUs

The shipped models without a lattice over 20 ms from their start at a tolerance of 1e-6: largest difference of fold angles and tip positions at the end from
the reference, relative to the largest motion, and processor time. Reference: co-simulation at 1e-9; for strips (`flared_wing_tip`, `goland_wing`) SciPy's Radau at 1e-9. The
explicit methods have `solver.frequency_limit` at the number in their column, which changes the equations, and Euler steps of 1e-5 s. `!`: rejected by the FMU with the message below the table.
`python studies/model_exchange_integrators.py --foldwing COMMAND --table docs/tables/model_exchange.md` (`make validate`).

"""


REST = """\
`slender_wing` is left out: it starts in equilibrium and meets its gust after 0.5 s, so that its motion within 20 ms is round-off (states change by 1.9e-12
at most in 1 ms, by Radau at 1e-6), and errors relative to this motion are meaningless."""


class Equations:
    """The instance of a Model Exchange FMU in Continuous-Time Mode: states, their derivatives and outputs."""

    def __init__(self, path, limit_rad_s=0.0):
        description = fmpy.read_model_description(str(path))
        self.folder = fmpy.extract(str(path))
        self.fmu = FMU2Model(guid=description.guid, unzipDirectory=self.folder, instanceName="wing",
                             modelIdentifier=description.modelExchange.modelIdentifier)
        self.fmu.instantiate()
        references = {row.name: row.valueReference for row in description.modelVariables}
        if limit_rad_s:
            self.fmu.setReal([references["solver.frequency_limit"]], [limit_rad_s])
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.fmu.newDiscreteStates()
        self.fmu.enterContinuousTimeMode()
        self.n = description.numberOfContinuousStates
        self.names = [row.name for row in description.modelVariables
                      if row.causality == "output" and row.type == "Real" and row.name.endswith((".angle", ".position.z", ".position.x"))]
        self.rows = [references[name] for name in self.names]
        self.x, self.slope = np.zeros(self.n), np.zeros(self.n)
        self.pointers = [values.ctypes.data_as(fmpy.fmi2.POINTER(fmpy.fmi2.fmi2Real)) for values in (self.x, self.slope)]
        self.fmu.getContinuousStates(self.pointers[0], self.n)
        self.start = self.x.copy()
        self.nominal = np.zeros(self.n)
        self.fmu.getNominalsOfContinuousStates(self.nominal.ctypes.data_as(fmpy.fmi2.POINTER(fmpy.fmi2.fmi2Real)), self.n)
        self.calls = 0

    def __call__(self, time_s, states):
        self.calls += 1
        self.x[:] = states
        self.fmu.setTime(time_s)
        self.fmu.setContinuousStates(self.pointers[0], self.n)
        self.fmu.getDerivatives(self.pointers[1], self.n)
        return self.slope.copy()

    def outputs(self, time_s, states):
        self(time_s, states)
        return np.array(self.fmu.getReal(self.rows))

    def close(self):
        self.fmu.freeInstance()


def scipy_method(method, **options):
    def run(path, limit_rad_s):
        equations = Equations(path, limit_rad_s)
        tolerance = options.get("rtol", TOLERANCE)
        found = solve_ivp(equations, (0.0, STOP_S), equations.start, method=method, rtol=tolerance, atol=tolerance * equations.nominal)
        if not found.success:
            raise RuntimeError(found.message)
        values = equations.outputs(STOP_S, found.y[:, -1])
        equations.close()
        return values

    return run


def euler(path, limit_rad_s):
    equations = Equations(path, limit_rad_s)
    states = equations.start.copy()
    for k in range(round(STOP_S / EULER_STEP_S)):
        states += EULER_STEP_S * equations(k * EULER_STEP_S, states)
    values = equations.outputs(STOP_S, states)
    equations.close()
    return values


def fmpy_cvode(path, limit_rad_s):
    names = Equations(path).names
    settings = {"solver.frequency_limit": limit_rad_s} if limit_rad_s else {}
    found = fmpy.simulate_fmu(str(path), fmi_type="ModelExchange", stop_time=STOP_S, output_interval=5e-5, relative_tolerance=TOLERANCE,
                              output=names, start_values=settings, record_events=False)
    return np.array([found[name][-1] for name in names])


def casadi_method(plugin):
    def run(path, limit_rad_s):
        builder = casadi.DaeBuilder("wing", str(path))
        if limit_rad_s:
            builder.set("solver.frequency_limit", limit_rad_s)
        names = Equations(path).names
        builder.set_y(names)
        function = builder.create("f", ["t", "x", "u", "p"], ["ode", "y"])
        x0, u, p = (np.array([builder.start(name) for name in names]).ravel() for names in (builder.x(), builder.u(), builder.p()))
        nominal = np.array([builder.nominal(name) for name in builder.x()]).ravel()
        x, t = casadi.MX.sym("x", len(x0)), casadi.MX.sym("t")
        # CasADi has one absolute tolerance for all states: they are scaled
        problem = {"x": x, "t": t, "ode": function(t, x * nominal, u, p)[0] / nominal}
        options = {"reltol": TOLERANCE, "abstol": TOLERANCE, "max_num_steps": 1_000_000}
        march = casadi.integrator("march", plugin, problem, 0.0, STOP_S, options)
        end = np.array(march(x0=x0 / nominal)["xf"]).ravel() * nominal
        return np.array(function(STOP_S, end, u, p)[1]).ravel()

    return run


IMPLICIT = {"FMPy CVode": fmpy_cvode, "Radau": scipy_method("Radau"), "BDF": scipy_method("BDF"), "LSODA": scipy_method("LSODA"),
            "CVODES": casadi_method("cvodes"), "IDAS": casadi_method("idas")}
EXPLICIT = {"RK45": (scipy_method("RK45"), LIMIT_RAD_S), "DOP853": (scipy_method("DOP853"), LIMIT_RAD_S), "Euler": (euler, EULER_LIMIT_RAD_S)}


def reference(model, path, both):
    """Outputs at the end; still air by co-simulation."""
    if model in STRIPS:
        return scipy_method("Radau", rtol=1e-9)(path, 0.0)
    names = Equations(path).names
    with contextlib.redirect_stdout(io.StringIO()):
        found = fmpy.simulate_fmu(str(both), fmi_type="CoSimulation", stop_time=STOP_S, output_interval=STOP_S / 10, output=names,
                                  start_values={"solver.tolerance": 1e-9}, record_events=False)
    return np.array([found[name][-1] for name in names])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--foldwing", type=Path, required=True, help="the command")
    parser.add_argument("--table", type=Path, help="file for the table")
    parser.add_argument("--models", nargs="*", help="names of model files [default: all]")
    arguments = parser.parse_args()
    models = arguments.models or sorted(path.stem for path in (ROOT / "examples/models").glob("*.toml"))
    columns = [*IMPLICIT, *(f"{name}, {limit:.0f} rad/s" for name, (_, limit) in EXPLICIT.items())]
    lines = ["| model | states | " + " | ".join(columns) + " |", "|---" * (len(columns) + 2) + "|"]
    print("\n".join(lines), flush=True)
    failures = []
    with tempfile.TemporaryDirectory() as folder:
        for model in (name for name in models if name not in AIR_IN_STEPS + AT_REST):
            paths = [Path(folder) / f"{model}_{kind}.fmu" for kind in ("me", "cs")]
            for path, kind in zip(paths, ("me", "cs")):
                file = ROOT / f"examples/models/{model}.toml"
                subprocess.run([arguments.foldwing, "package", file, "-o", path, "--interface", kind, "--no-reference", "-q"], check=True)
            equations = Equations(paths[0])
            first = equations.outputs(0.0, equations.start)
            expected = reference(model, *paths)
            moved = np.abs(expected - first).max()
            cells = []
            runs = [(name, run, 0.0) for name, run in IMPLICIT.items()] + [(name, *pair) for name, pair in EXPLICIT.items()]
            for name, run, limit in runs:
                begin_s = time.process_time()
                try:
                    found = run(paths[0], limit)
                    cells.append(f"{np.abs(found - expected).max() / moved:.0e}, {time.process_time() - begin_s:.1f} s")
                except Exception as error:  # an importer's failure is a result
                    cells.append("!")
                    failures.append(f"{model}, {name}: {str(error).strip().splitlines()[-1][:300]}")
            lines.append(f"| `{model}` | {equations.n} | " + " | ".join(cells) + " |")
            print(lines[-1], flush=True)
    print("\n".join(failures))
    if arguments.table:
        arguments.table.write_text(HEAD + "\n".join([*lines, "", *failures, "", REST]) + "\n")


if __name__ == "__main__":
    main()
