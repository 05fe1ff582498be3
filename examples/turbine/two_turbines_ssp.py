#!/usr/bin/env python3
"""Two turbines in a row as one SSP system: two instances of one FMU and a farm controller that shares a power between them and computes the
wake of the front turbine, run by FMPy and, if installed, libcosim, Ecos and FMU Manipulation Toolbox.

    python examples/turbine/two_turbines_ssp.py --foldwing target/release/foldwing --output two_turbines.ssp [--stop 60] [--demand 8e6]

The turbine is nrel_5mw_wind.toml without the torque table of its generator. Structure (SSD), parameters (SSV) and mapping (SSM) of `foldwing
package --ssp` serve both turbines, each with an SSV file of its own; wind_farm.py is made into an FMU by PythonFMU (`pip install pythonfmu`).
Importers with fixed steps give each component the values of the last communication point. Connected inputs are 0 in the first step of FMPy 0.3: both
turbines are without wind for 20 ms.
"""

import argparse
import copy
import math
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import controlled_wing_ssp as ssp  # noqa: E402, in the folder above

MODEL = FOLDER / "nrel_5mw_wind.toml"
STEP_S = 0.02
START_SPEED_RAD_S = math.radians(72.6)  # of the shaft in the model file
START_AZIMUTH_DEG = {"front": 0.0, "back": 40.0}
WIRES = [("farm", "wind_{}", "{}", "wind.velocity.x"), ("farm", "torque_{}", "{}", "shaft.external_torque"),
         *(("farm", "pitch_{}", "{}", f"pitch{blade}.angle_command") for blade in (1, 2, 3)), ("{}", "shaft.angular_velocity", "farm", "speed_{}")]
RESULTS = [*((name, output) for name in START_AZIMUTH_DEG for output in ("shaft.angular_velocity", "rotor.power", "pitch1.angle", "body.tower.deflection.z")),
           ("front", "rotor.thrust_coefficient"), ("farm", "wind_back"), ("farm", "torque_front"), ("farm", "torque_back")]


def model_text():
    """The turbine with paths of its polars that hold in any folder, without the torque table of its generator."""
    text = MODEL.read_text(encoding="utf-8").replace('"polars/', f'"{FOLDER.as_posix()}/polars/')
    return re.sub(r"(?ms)^\[joint\.shaft\.generator\]\n.*?(?=^\[)", "", text)


def turbine(foldwing, folder):
    """Members of the SSP archive of one turbine; the FMU is in the folder, too."""
    model, archive = Path(folder) / "turbine.toml", Path(folder) / "turbine.ssp"
    model.write_text(model_text(), encoding="utf-8")
    command = [str(foldwing), "package", str(model), "-o", str(Path(folder) / "turbine.fmu"), "--ssp", str(archive), "--no-reference", "--quiet"]
    subprocess.run(command, check=True)
    return ssp.read(archive)


def farm_fmu(folder):
    """The FMU of wind_farm.py."""
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", str(FOLDER / "wind_farm.py"), "-d", str(folder), "--no-external-tool",
               str(FOLDER / "nrel_controller.py")]
    subprocess.run(command, check=True, capture_output=True)
    return Path(folder) / "WindFarm.fmu"


def farm_parameters(values=None):
    """Parameters of the farm: those of the start follow from the turbines."""
    found = {"wind": 11.4, "demand": 8e6, "spacing": 378.0, "expansion": 0.075}
    found.update({f"start_speed_{name}": START_SPEED_RAD_S for name in START_AZIMUTH_DEG})
    return {**found, **(values or {})}


def wires():
    """Component and connector of start and end of each connection."""
    found = [tuple(word.format(name) for word in wire) for name in START_AZIMUTH_DEG for wire in WIRES]
    return [*found, ("front", "rotor.thrust_coefficient", "farm", "thrust_coefficient_front")]


def system(foldwing, folder, values=None):
    """Members of the SSP archive of both turbines and the farm with these parameters."""
    members = turbine(foldwing, folder)
    root = ET.fromstring(members[ssp.SSD])
    inner = root.find("ssd:System", ssp.SPACES)
    elements = inner.find("ssd:Elements", ssp.SPACES)
    single = elements[0]
    elements.remove(single)
    one = members.pop("resources/parameters.ssv")
    for name, azimuth_deg in START_AZIMUTH_DEG.items():
        part = copy.deepcopy(single)
        part.set("name", name)
        part.find(".//ssd:ParameterBinding", ssp.SPACES).set("source", f"resources/{name}.ssv")
        elements.append(part)
        members[f"resources/{name}.ssv"] = one
        ssp.set_parameter(members, f"resources/{name}.ssv", "shaft.start_angle_deg", azimuth_deg)
    farm = ssp.child(elements, "ssd:Component", name="farm", type="application/x-fmu-sharedlibrary", source="resources/farm.fmu",
                     implementation="CoSimulation")
    connectors = ssp.child(farm, "ssd:Connectors")
    wired, parameters = wires(), farm_parameters(values)
    outputs = dict.fromkeys([output for start, output, _, _ in wired if start == "farm"] + [name for owner, name in RESULTS if owner == "farm"])
    kinds = [(name, "output") for name in outputs] + [(put, "input") for _, _, end, put in wired if end == "farm"]
    for name, kind in [*kinds, *((name, "parameter") for name in parameters)]:
        ssp.child(ssp.child(connectors, "ssd:Connector", name=name, kind=kind), "ssc:Real")
    ssp.child(ssp.child(farm, "ssd:ParameterBindings"), "ssd:ParameterBinding", source="resources/farm.ssv")
    connections = ssp.child(inner, "ssd:Connections")
    for start, output, end, put in wired:
        ssp.child(connections, "ssd:Connection", startElement=start, startConnector=output, endElement=end, endConnector=put)
    listed = ET.Element(ssp.tag("ssv:ParameterSet"), {"name": "farm", "version": "1.0"})
    rows = ssp.child(listed, "ssv:Parameters")
    for name, value in parameters.items():
        ssp.child(ssp.child(rows, "ssv:Parameter", name=name), "ssv:Real", value=repr(value))
    members.update({ssp.SSD: ET.tostring(root), "resources/farm.ssv": ET.tostring(listed), "resources/farm.fmu": farm_fmu(folder).read_bytes()})
    return members


class Alone:
    """The turbines as single models, an instance each by direct calls, and the farm in Python: the system without an importer of systems.

    `in_turn`: each component takes the newest values, in the order front, back, farm; otherwise all take those of the last communication point.
    `from_zero`: connected inputs are 0, instead of the outputs before the first step: with `in_turn` during the initialisation, otherwise in
    the first step.
    """

    def __init__(self, fmu, folder, values=None, from_zero=False, in_turn=False):
        from fmpy import extract, read_model_description
        from fmpy.fmi2 import FMU2Slave

        sys.path.insert(0, str(FOLDER))
        from wind_farm import Farm

        self.from_zero, self.in_turn = from_zero, in_turn
        given = farm_parameters(values)
        start = {name: given[f"start_speed_{name}"] for name in START_AZIMUTH_DEG}
        self.farm = Farm(given["wind"], given["demand"], given["spacing"], given["expansion"], start)
        description = read_model_description(str(fmu), validate=False)
        self.references = {row.name: row.valueReference for row in description.modelVariables}
        folder = extract(str(fmu), str(Path(folder) / "alone"))
        self.turbines = {}
        for name, azimuth_deg in START_AZIMUTH_DEG.items():
            slave = FMU2Slave(guid=description.guid, unzipDirectory=folder, modelIdentifier=description.coSimulation.modelIdentifier, instanceName=name)
            self.turbines[name] = slave
            slave.instantiate()
            slave.setupExperiment(startTime=0.0)
            self.put(name, "shaft.start_angle", azimuth_deg * (math.pi / 180.0))
            slave.enterInitializationMode()
            if in_turn or not from_zero:
                for start, output, end, put in wires():
                    if end == name:
                        self.put(name, put, 0.0 if from_zero else self.get(start, output))
            slave.exitInitializationMode()

    def get(self, name, variable):
        """Value of an output of a turbine or of the farm."""
        if name == "farm":
            kind, _, side = variable.partition("_")
            controller = self.farm.controllers[side]
            return {"wind": self.farm.wind[side], "torque": -97.0 * controller.torque_N_m, "pitch": controller.pitch_rad}[kind]
        return self.turbines[name].getReal([self.references[variable]])[0]

    def put(self, name, variable, value):
        """Sets an input or a parameter of a turbine."""
        self.turbines[name].setReal([self.references[variable]], [value])

    def run(self, stop_s, step_s, results):
        """Values of the results after each step."""
        wired = wires()
        seen = {(start, output): 0.0 if self.from_zero else self.get(start, output) for start, output, _, _ in wired}
        rows, time_s = [], 0.0
        for _ in range(round(stop_s / step_s)):
            for name in (*START_AZIMUTH_DEG, "farm"):
                if self.in_turn:
                    seen = {key: self.get(*key) for key in seen}
                if name == "farm":
                    speeds = {side: seen[side, "shaft.angular_velocity"] for side in START_AZIMUTH_DEG}
                    if any(speeds.values()):
                        self.farm.step(speeds, seen["front", "rotor.thrust_coefficient"], step_s)
                    continue
                for start, output, end, put in wired:
                    if end == name:
                        self.put(name, put, seen[start, output])
                self.turbines[name].doStep(time_s, step_s)
            seen = {key: self.get(*key) for key in seen}
            rows.append([self.get(*result) for result in results])
            time_s += step_s
        return rows

    def close(self):
        """Frees both instances."""
        for slave in self.turbines.values():
            slave.terminate()
            slave.freeInstance()


# arguments of Alone for the order of calls in each importer
CALLS = {"FMPy": {"from_zero": True}, "libcosim": {}, "Ecos": {}, "FMU container": {"from_zero": True, "in_turn": True}}


def off(rows, alone):
    """Largest difference of two runs over the largest value of each result."""
    sizes = [max(map(abs, column)) for column in zip(*alone)]
    return max(abs(a - b) / size for row, other in zip(rows, alone) for a, b, size in zip(row, other, sizes))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--foldwing", type=Path, required=True, help="the command")
    parser.add_argument("--output", type=Path, required=True, help="output file (SSP)")
    parser.add_argument("--stop", type=float, default=60.0, help="s")
    parser.add_argument("--demand", type=float, default=8e6, help="power of both generators, W")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        values = {"demand": arguments.demand}
        members = system(arguments.foldwing, folder, values)
        ssp.write(arguments.output, members)
        for name, run in ssp.RUNS.items():
            try:
                rows = run(members, folder, arguments.stop, STEP_S, RESULTS)
            except ImportError as error:
                print(f"{name:13} not run: {error}")
                continue
            single = Alone(Path(folder) / "turbine.fmu", folder, values, **CALLS[name])
            alone = single.run(arguments.stop, STEP_S, RESULTS)
            single.close()
            last = dict(zip(RESULTS, rows[-1]))
            powers = [-last["farm", f"torque_{side}"] * last[side, "shaft.angular_velocity"] / 1e6 for side in START_AZIMUTH_DEG]
            print(f"{name:13} after {arguments.stop:g} s: wind at the back {last['farm', 'wind_back']:.6f} m/s, power {powers[0]:.6f} and {powers[1]:.6f} MW, "
                  f"pitch {math.degrees(last['front', 'pitch1.angle']):.4f} and {math.degrees(last['back', 'pitch1.angle']):.4f} degrees; "
                  f"off the single models: {off(rows, alone):.1e}")


if __name__ == "__main__":
    main()
