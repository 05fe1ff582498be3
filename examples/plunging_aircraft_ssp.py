#!/usr/bin/env python3
"""An aircraft as one SSP system: a fuselage that moves vertically and two instances of a wing FMU, run by libcosim, Ecos and a container of
FMU Manipulation Toolbox, compared with the same aircraft as a single model.

    python examples/plunging_aircraft_ssp.py --foldwing target/release/foldwing --output aircraft.ssp [--stop 0.05] [--step 5e-4]

The fuselage prescribes the acceleration of the wing roots, and the wings return their forces: an algebraic loop, which importers with fixed
steps solve with the values of the last communication point. This converges as the step decreases if the fuselage is heavier than the wings
(0.13 kg), and diverges otherwise; `flying_aircraft.py` iterates. The wings start at different angles, 170 and 120 degrees.
"""

import argparse
import csv
import ctypes
import math
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

EXAMPLES = Path(__file__).resolve().parent
WING = EXAMPLES / "models/folding_wing.toml"
FUSELAGE_KG = 3.0
START_RAD = {"right": math.radians(170.0), "left": math.radians(120.0)}
# as in examples/flying_aircraft.toml, except that the beam elements are those of the wing
DAMPING = {"body.inner.mass_damping": 0.0, "body.inner.stiffness_damping": 2e-4, "body.outer.mass_damping": 0.0, "body.outer.stiffness_damping": 2e-4}
# the wing's own model file has gravity along its span
GRAVITY = {"gravity.x": 0.0, "gravity.z": -9.81}
RESULTS = {"fuselage": "height", "right": "fold.angle", "left": "fold.angle"}
WIRES = [("fuselage", "acceleration", side, "root.acceleration.z") for side in START_RAD]
WIRES += [(side, "root.force.z", "fuselage", f"{side}_force") for side in START_RAD]


def single_model():
    """The aircraft as one model file: the wing of `WING` on both sides of a rigid body on a vertical prismatic joint."""
    text = WING.read_text(encoding="utf-8")
    machine = (EXAMPLES / "flying_aircraft.toml").read_text(encoding="utf-8")
    begin, end = machine.index("[joint.flight]"), machine.index("[joint.mount_right]")
    slide = '[joint.flight]\ntype = "prismatic"\nparent = "root"\nchild = "fuselage"\naxis = [0.0, 0.0, 1.0]\n\n'
    machine = machine[:begin] + slide + machine[end:]
    assert text and machine.count("mass_kg = 0.3\n") == 1
    return machine.replace("mass_kg = 0.3\n", f"mass_kg = {FUSELAGE_KG}\n")


def run_single(foldwing, folder, stop_s):
    """Height in m and both fold angles in rad at the end."""
    model, table = Path(folder) / "aircraft.toml", Path(folder) / "single.csv"
    model.write_text(single_model(), encoding="utf-8")
    settings = [f"fold_{side}.start_angle={angle!r}" for side, angle in START_RAD.items()] + ["fold_left.release=true", "solver.tolerance=1e-9"]
    command = [str(foldwing), "simulate", str(model), "--stop", repr(stop_s), "--step", repr(stop_s), "--csv", str(table), "-q"]
    subprocess.run(command + [word for setting in settings for word in ("--set", setting)], check=True)
    with table.open(encoding="utf-8") as stream:
        row = list(csv.DictReader(line for line in stream if not line.startswith("#")))[-1]
    return [float(row[name]) for name in ("flight.position", "fold_right.angle", "fold_left.angle")]


def parameters():
    """Start values by component and variable."""
    wing = {**DAMPING, **GRAVITY, "solver.tolerance": 1e-8}
    found = {f"fuselage.{name}": value for name, value in (("mass", FUSELAGE_KG), ("gravity", 9.81))}
    for side, angle in START_RAD.items():
        found.update({f"{side}.{name}": value for name, value in {**wing, "fold.start_angle": angle}.items()})
    return found


def structure():
    """The SSD with its parameters."""
    outputs = {(start, output) for start, output, _, _ in WIRES} | set(RESULTS.items())
    inputs = {(end, put) for _, _, end, put in WIRES}
    parts = []
    for component, source in (("fuselage", "fuselage"), ("right", "wing"), ("left", "wing")):
        rows = [(name, "output") for owner, name in sorted(outputs) if owner == component]
        rows += [(name, "input") for owner, name in sorted(inputs) if owner == component]
        values = {name.partition(".")[2]: value for name, value in parameters().items() if name.startswith(component + ".")}
        rows += [(name, "input" if name in GRAVITY else "parameter") for name in values]
        connectors = "".join(f'<ssd:Connector name="{name}" kind="{kind}"><ssc:Real/></ssd:Connector>' for name, kind in rows)
        listed = "".join(f'<ssv:Parameter name="{name}"><ssv:Real value="{value!r}"/></ssv:Parameter>' for name, value in values.items())
        parts.append(f'<ssd:Component name="{component}" type="application/x-fmu-sharedlibrary" source="resources/{source}.fmu" '
                     f'implementation="CoSimulation"><ssd:Connectors>{connectors}</ssd:Connectors><ssd:ParameterBindings><ssd:ParameterBinding>'
                     f'<ssd:ParameterValues><ssv:ParameterSet name="parameters" version="1.0"><ssv:Parameters>{listed}</ssv:Parameters>'
                     f"</ssv:ParameterSet></ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings></ssd:Component>")
    wires = "".join(f'<ssd:Connection startElement="{start}" startConnector="{output}" endElement="{end}" endConnector="{put}"/>'
                    for start, output, end, put in WIRES)
    spaces = " ".join(f'xmlns:{prefix}="http://ssp-standard.org/SSP1/SystemStructure{name}"'
                      for prefix, name in (("ssd", "Description"), ("ssc", "Common"), ("ssv", "ParameterValues")))
    return (f'<?xml version="1.0" encoding="UTF-8"?>\n<ssd:SystemStructureDescription {spaces} name="Aircraft" version="1.0">'
            f'<ssd:System name="aircraft"><ssd:Elements>{"".join(parts)}</ssd:Elements><ssd:Connections>{wires}</ssd:Connections></ssd:System>'
            f'<ssd:DefaultExperiment startTime="0" stopTime="0.1"/></ssd:SystemStructureDescription>\n')


def write(foldwing, folder, path):
    """Writes the SSP archive, and its FMUs into the folder."""
    folder = Path(folder)
    subprocess.run([str(foldwing), "package", str(WING), "-o", str(folder / "wing.fmu"), "--no-reference", "-q"], check=True)
    build = [sys.executable, "-m", "pythonfmu", "build", "-f", str(EXAMPLES / "plunging_fuselage.py"), "-d", str(folder), "--no-external-tool"]
    subprocess.run(build, check=True, capture_output=True)
    (folder / "Fuselage.fmu").rename(folder / "fuselage.fmu")
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("SystemStructure.ssd", structure())
        for name in ("wing", "fuselage"):
            archive.write(folder / f"{name}.fmu", f"resources/{name}.fmu")


def run_libcosim(ssp, folder, stop_s, step_s):
    """Results at the end, in libcosim's fixed-step algorithm."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver

    with zipfile.ZipFile(ssp) as archive:
        archive.extractall(Path(folder) / "libcosim")
    execution = CosimExecution.from_ssp_file(str(Path(folder) / "libcosim"), round(step_s * 1e9))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    for _ in range(round(stop_s / step_s)):
        if not execution.step():
            raise RuntimeError("cosim_execution_step failed")
    found = []
    for component, variable in RESULTS.items():
        slave = execution.slave_index_from_instance_name(component)
        reference = next(row.reference for row in execution.slave_variables(slave) if row.name.decode() == variable)
        found.append(observer.last_real_values(slave, [reference])[0])
    return found


def run_ecos(ssp, folder, stop_s, step_s):
    """Results at the end, in Ecos; it needs Intel's TBB (`pip install tbb`), which its package does not name."""
    tbb = Path(sys.prefix) / "lib/libtbb.so.12"
    if tbb.exists():
        ctypes.CDLL(str(tbb), mode=ctypes.RTLD_GLOBAL)
    from ecospy.EcosSimulation import EcosSimulation

    with EcosSimulation(ssp_path=str(ssp), step_size=step_s) as simulation:
        simulation.init(parameter_set="parameters")
        for _ in range(round(stop_s / step_s)):
            simulation.step(1)
        found = [simulation.get_real(f"{component}::{variable}") for component, variable in RESULTS.items()]
        simulation.terminate()
    return found


def run_container(_ssp, folder, stop_s, step_s):
    """Results at the end, in a container FMU of FMU Manipulation Toolbox, which ignores parameters of SSP: the system as its CSV."""
    import fmu_manipulation_toolbox  # noqa: F401, the program comes with it
    from fmpy import simulate_fmu

    folder = Path(folder)
    for side in START_RAD:
        (folder / f"{side}.fmu").write_bytes((folder / "wing.fmu").read_bytes())
    rows = ["rule;from_fmu;from_port;to_fmu;to_port", *(f"FMU;{name}.fmu;;;" for name in RESULTS)]
    rows += [f"LINK;{start}.fmu;{output};{end}.fmu;{put}" for start, output, end, put in WIRES]
    rows += [f"START;{component}.fmu;{variable};{value!r};" for (component, _, variable), value in
             ((name.partition("."), value) for name, value in parameters().items())]
    rows += [f"OUTPUT;{component}.fmu;{variable};;{component}" for component, variable in RESULTS.items()]
    (folder / "aircraft.csv").write_text("\n".join([*rows, ""]), encoding="utf-8")
    command = [str(Path(sys.executable).parent / "fmucontainer"), "-fmu-directory", str(folder), "-container", f"aircraft.csv:{step_s!r}",
               "-no-auto-input", "-no-auto-output", "-no-auto-link"]
    subprocess.run(command, check=True, capture_output=True)
    found = simulate_fmu(str(folder / "aircraft.fmu"), stop_time=stop_s, output_interval=stop_s, output=list(RESULTS), record_events=False)
    return [float(found[name][-1]) for name in RESULTS]


RUNS = {"libcosim": run_libcosim, "Ecos": run_ecos, "FMU container": run_container}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--foldwing", type=Path, required=True, help="the command")
    parser.add_argument("--output", type=Path, required=True, help="output file (SSP)")
    parser.add_argument("--stop", type=float, default=0.05, help="s")
    parser.add_argument("--step", type=float, default=5e-4, help="s")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        write(arguments.foldwing, folder, arguments.output)
        expected = run_single(arguments.foldwing, folder, arguments.stop)
        print(f"one model     height, m: {expected[0]:.9f}; fold angles, rad: {expected[1]:.9f}, {expected[2]:.9f}")
        for name, run in RUNS.items():
            try:
                found = run(arguments.output, folder, arguments.stop, arguments.step)
            except ImportError as error:
                print(f"{name:13} not run: {error}")
                continue
            off = " ".join(f"{a - b:.3e}" for a, b in zip(found, expected))
            print(f"{name:13} height, m: {found[0]:.9f}; fold angles, rad: {found[1]:.9f}, {found[2]:.9f}; off: {off}")


if __name__ == "__main__":
    main()
