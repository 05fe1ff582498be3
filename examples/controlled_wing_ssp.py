#!/usr/bin/env python3
"""A wing with a controller in one SSP system, with the parameters of both in SSV files, run by FMPy and, if installed, libcosim, Ecos and
FMU Manipulation Toolbox.

    python examples/controlled_wing_ssp.py --foldwing target/release/foldwing --output controlled_wing.ssp

`foldwing package --ssp` writes a system of the wing alone: structure (SSD), parameters (SSV, angles in degrees) and their mapping onto the
variables of the FMU (SSM). This script adds a controller, made by PythonFMU (`pip install pythonfmu`), that acts on the hinge like a spring
of the motor, and a start angle of 120 degrees and a tolerance in the SSV. Features of SSP 1.0 that importers do not support:

- FMPy 0.3 ignores parameters, and sets input connectors without a connection to 0: `for_fmpy` removes these, and `start_values` reads
  SSV and SSM.
- FMU Manipulation Toolbox 2.0 ignores parameters: `run_container` writes the system as its CSV.
- libcosim 0.13 and Ecos 0.7 read parameters only where the SSD contains them, and no SSM: `inlined` writes them there.
"""

import argparse
import ctypes
import math
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

EXAMPLES = Path(__file__).resolve().parent
MODEL = EXAMPLES / "models/folding_wing.toml"
SPACES = {prefix: f"http://ssp-standard.org/SSP1/SystemStructure{name}"
          for prefix, name in [("ssd", "Description"), ("ssc", "Common"), ("ssv", "ParameterValues"), ("ssm", "ParameterMapping")]}
for _prefix, _space in SPACES.items():
    ET.register_namespace(_prefix, _space)
SSD = "SystemStructure.ssd"
ANGLE = (("model", "fold.angle"),)
WIRES = [("controller", "torque", "model", "fold.external_torque"), ("model", "fold.angle", "controller", "angle"),
         ("model", "fold.angular_velocity", "controller", "rate")]
# without damping: with 0.002 N·m·s/rad the fold angle did not converge to that of the single model at steps of 0.5 to 0.125 ms (80 to 83°
# instead of 78.0°); the cause was not examined
CONTROLLER = {"target": 0.0, "stiffness": 0.02, "damping": 0.0, "limit": 0.15}


def tag(name):
    """`ssd:System` as ElementTree writes it."""
    prefix, word = name.split(":")
    return f"{{{SPACES[prefix]}}}{word}"


def child(parent, element, **attributes):
    return ET.SubElement(parent, tag(element), attributes)


def read(path):
    """Members of an archive by name."""
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def write(path, members):
    """Writes the archive, the structure first."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(members, key=lambda name: name != SSD):
            archive.writestr(name, members[name])


def controller_fmu(folder):
    """The FMU of pd_controller.py."""
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", str(EXAMPLES / "pd_controller.py"), "-d", str(folder), "--no-external-tool"]
    subprocess.run(command, check=True, capture_output=True)
    return Path(folder) / "Controller.fmu"


def set_parameter(members, ssv, name, value):
    """Changes a value of an SSV file among the members of an archive; KeyError if it has no such parameter."""
    root = ET.fromstring(members[ssv])
    for parameter in root.iter(tag("ssv:Parameter")):
        if parameter.get("name") == name:
            parameter[0].set("value", repr(value) if not isinstance(value, bool) else str(value).lower())
            members[ssv] = ET.tostring(root)
            return
    raise KeyError(f"{ssv} has no parameter {name}")


def add_controller(members, fmu, values=None):
    """Adds the controller and its connections to the system of a wing."""
    root = ET.fromstring(members[SSD])
    system = root.find("ssd:System", SPACES)
    component = child(system.find("ssd:Elements", SPACES), "ssd:Component", name="controller", type="application/x-fmu-sharedlibrary",
                      source="resources/controller.fmu", implementation="CoSimulation")
    connectors = child(component, "ssd:Connectors")
    values = {**CONTROLLER, **(values or {})}
    for name, kind in [("angle", "input"), ("rate", "input"), ("torque", "output"), *((name, "parameter") for name in values)]:
        child(child(connectors, "ssd:Connector", name=name, kind=kind), "ssc:Real")
    child(child(component, "ssd:ParameterBindings"), "ssd:ParameterBinding", source="resources/controller.ssv")
    connections = child(system, "ssd:Connections")
    for start, output, end, put in WIRES:
        child(connections, "ssd:Connection", startElement=start, startConnector=output, endElement=end, endConnector=put)
    parameters = ET.Element(tag("ssv:ParameterSet"), {"name": "controller", "version": "1.0"})
    listed = child(parameters, "ssv:Parameters")
    for name, value in values.items():
        child(child(listed, "ssv:Parameter", name=name), "ssv:Real", value=repr(value))
    members.update({SSD: ET.tostring(root), "resources/controller.ssv": ET.tostring(parameters), "resources/controller.fmu": Path(fmu).read_bytes()})


def converted(members, binding):
    """Parameters of a binding after its mapping: name in the FMU, element of the type, value."""
    values = {row.get("name"): row[0] for row in ET.fromstring(members[binding.get("source")]).iter(tag("ssv:Parameter"))}
    mapping = binding.find("ssd:ParameterMapping", SPACES)
    if mapping is None:
        return [(name, element.tag, element.get("value")) for name, element in values.items()]
    found = []
    for entry in ET.fromstring(members[mapping.get("source")]).iter(tag("ssm:MappingEntry")):
        element, line = values[entry.get("source")], entry.find("ssc:LinearTransformation", SPACES)
        value = element.get("value")
        if line is not None:
            value = repr(float(value) * float(line.get("factor", "1")) + float(line.get("offset", "0")))
        found.append((entry.get("target"), element.tag, value))
    return found


def start_values(members):
    """Parameters of all components, by component and variable."""
    found = {}
    for component in ET.fromstring(members[SSD]).iter(tag("ssd:Component")):
        for binding in component.iter(tag("ssd:ParameterBinding")):
            for name, kind, value in converted(members, binding):
                typed = value == "true" if kind == tag("ssv:Boolean") else float(value)
                found[f"{component.get('name')}.{name}"] = typed
    return found


def for_fmpy(members):
    """The system without the input connectors that nothing is connected to."""
    root = ET.fromstring(members[SSD])
    wired = {(row.get("endElement"), row.get("endConnector")) for row in root.iter(tag("ssd:Connection"))}
    for component in root.iter(tag("ssd:Component")):
        connectors = component.find("ssd:Connectors", SPACES)
        for connector in list(connectors):
            if connector.get("kind") == "input" and (component.get("name"), connector.get("name")) not in wired:
                connectors.remove(connector)
    return {**members, SSD: ET.tostring(root)}


def inlined(members):
    """The system with its parameters in the SSD, mapped and in SI units."""
    root = ET.fromstring(members[SSD])
    for component in root.iter(tag("ssd:Component")):
        for binding in component.iter(tag("ssd:ParameterBinding")):
            rows = converted(members, binding)
            for part in list(binding):
                binding.remove(part)
            del binding.attrib["source"]
            inline = child(child(binding, "ssd:ParameterValues"), "ssv:ParameterSet", name="parameters", version="1.0")
            listed = child(inline, "ssv:Parameters")
            for name, kind, value in rows:
                ET.SubElement(child(listed, "ssv:Parameter", name=name), kind, {"value": value})
    return {**members, SSD: ET.tostring(root)}


def wires(members):
    """Connections of the structure: component and connector of start and end."""
    rows = ET.fromstring(members[SSD]).iter(tag("ssd:Connection"))
    return [tuple(row.get(key) for key in ("startElement", "startConnector", "endElement", "endConnector")) for row in rows]


def run_fmpy(members, folder, stop_s, step_s, results=ANGLE):
    """Values of the results, pairs of component and variable, after each step: a row per step."""
    from fmpy.ssp.simulation import simulate_ssp
    from fmpy.ssp.ssd import Parameter, ParameterSet

    path = Path(folder) / "fmpy.ssp"
    write(path, for_fmpy(members))
    parameters = ParameterSet(parameters=[Parameter(name=name, value=value) for name, value in start_values(members).items()])
    rows = simulate_ssp(str(path), stop_time=stop_s, step_size=step_s, parameter_set=parameters)
    return [[float(row[f"{component}.{variable}"]) for component, variable in results] for row in rows][: round(stop_s / step_s)]


def run_libcosim(members, folder, stop_s, step_s, results=ANGLE):
    """The same in libcosim's fixed-step algorithm."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver

    path = Path(folder) / "libcosim.ssp"
    write(path, inlined(members))
    with zipfile.ZipFile(path) as archive:
        archive.extractall(Path(folder) / "libcosim")
    execution = CosimExecution.from_ssp_file(str(Path(folder) / "libcosim"), round(step_s * 1e9))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    places = []
    for component, variable in results:
        slave = execution.slave_index_from_instance_name(component)
        places.append((slave, next(row.reference for row in execution.slave_variables(slave) if row.name.decode() == variable)))
    rows = []
    for _ in range(round(stop_s / step_s)):
        if not execution.step():
            raise RuntimeError("cosim_execution_step failed")
        rows.append([observer.last_real_values(slave, [reference])[0] for slave, reference in places])
    return rows


def run_ecos(members, folder, stop_s, step_s, results=ANGLE):
    """The same in Ecos, which needs Intel's TBB (`pip install tbb`); its package does not name it."""
    tbb = Path(sys.prefix) / "lib/libtbb.so.12"
    if tbb.exists():
        ctypes.CDLL(str(tbb), mode=ctypes.RTLD_GLOBAL)
    from ecospy.EcosSimulation import EcosSimulation

    path = Path(folder) / "ecos.ssp"
    write(path, inlined(members))
    with EcosSimulation(ssp_path=str(path), step_size=step_s) as simulation:
        simulation.init(parameter_set="parameters")  # the name of the sets that `inlined` writes; without it Ecos ignores them
        rows = []
        for _ in range(round(stop_s / step_s)):
            simulation.step(1)
            rows.append([simulation.get_real(f"{component}::{variable}") for component, variable in results])
        simulation.terminate()
    return rows


def run_container(members, folder, stop_s, step_s, results=ANGLE):
    """The same in a container FMU of FMU Manipulation Toolbox, which ignores the parameters of an SSP file: the same system as its CSV,
    whose start values are those of SSV and SSM."""
    import fmu_manipulation_toolbox  # noqa: F401, the program comes with it
    from fmpy import simulate_fmu

    root = Path(folder) / "container"
    root.mkdir(exist_ok=True)
    rows = ["rule;from_fmu;from_port;to_fmu;to_port"]
    for component in ET.fromstring(members[SSD]).iter(tag("ssd:Component")):
        name = component.get("name")
        (root / f"{name}.fmu").write_bytes(members[component.get("source")])
        rows.append(f"FMU;{name}.fmu;;;")
    rows += [f"LINK;{start}.fmu;{output};{end}.fmu;{put}" for start, output, end, put in wires(members)]
    for name, value in start_values(members).items():
        component, _, variable = name.partition(".")
        # a Boolean is a number there
        rows.append(f"START;{component}.fmu;{variable};{int(value) if isinstance(value, bool) else value!r};")
    rows += [f"OUTPUT;{component}.fmu;{variable};;result_{k}" for k, (component, variable) in enumerate(results)]
    (root / "system.csv").write_text("\n".join([*rows, ""]), encoding="utf-8")
    command = [str(Path(sys.executable).parent / "fmucontainer"), "-fmu-directory", str(root), "-container", f"system.csv:{step_s!r}", "-no-auto-input",
               "-no-auto-output", "-no-auto-link", "-sequential"]
    subprocess.run(command, check=True, capture_output=True)
    names = [f"result_{k}" for k in range(len(results))]
    found = simulate_fmu(str(root / "system.fmu"), stop_time=stop_s, output_interval=step_s, output=names, record_events=False)
    return [[float(row[name]) for name in names] for row in found[1:]]


RUNS = {"FMPy": run_fmpy, "libcosim": run_libcosim, "Ecos": run_ecos, "FMU container": run_container}


def system(foldwing, folder, start_deg, values=None):
    """Members of the SSP archive of the wing with this start angle and its controller."""
    ssp = Path(folder) / "wing.ssp"
    command = [str(foldwing), "package", str(MODEL), "-o", str(Path(folder) / "wing.fmu"), "--ssp", str(ssp), "--no-reference", "--quiet"]
    subprocess.run(command, check=True)
    members = read(ssp)
    set_parameter(members, "resources/parameters.ssv", "fold.start_angle_deg", start_deg)
    set_parameter(members, "resources/parameters.ssv", "solver.tolerance", 1e-8)
    add_controller(members, controller_fmu(folder), values)
    return members


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--foldwing", type=Path, required=True, help="the command")
    parser.add_argument("--output", type=Path, required=True, help="output file (SSP)")
    parser.add_argument("--start", type=float, default=120.0, help="start angle, degrees")
    parser.add_argument("--stop", type=float, default=0.1, help="s")
    parser.add_argument("--step", type=float, default=5e-4, help="s")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        members = system(arguments.foldwing, folder, arguments.start)
        write(arguments.output, members)
        for name, run in RUNS.items():
            try:
                ((angle,),) = run(members, folder, arguments.stop, arguments.step)[-1:]
            except ImportError as error:
                print(f"{name:13} not run: {error}")
                continue
            print(f"{name:13} fold angle after {arguments.stop} s: {math.degrees(angle):.9f} degrees")


if __name__ == "__main__":
    main()
