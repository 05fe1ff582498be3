#!/usr/bin/env python3
"""Two wings in one SSP system: the left one unfolds, and its latch releases the right one.

Writes an SSP file (System Structure and Parameterization 1.0), which any tool with SSP support can open, and simulates it
with FMPy:

    python examples/two_wings_ssp.py --fmu target/fmu/FoldingWing.fmu --output two_wings.ssp

FMPy steps the wings one after the other with equal steps and transfers connected values after each step, so the latch
signal reaches the right wing one step late.
"""

import argparse
import zipfile
from pathlib import Path

from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import Parameter, ParameterSet

OUTPUTS = {"fold.angle": "Real", "fold.latch_time": "Real", "gauge.root.strain": "Real", "fold.latched": "Boolean"}
STRUCTURE = """<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
    xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" name="TwoWings" version="1.0">
  <ssd:System name="aircraft">
    <ssd:Elements>
{components}
    </ssd:Elements>
    <ssd:Connections>
      <ssd:Connection startElement="left" startConnector="fold.latched" endElement="right" endConnector="fold.release"/>
    </ssd:Connections>
  </ssd:System>
  <ssd:DefaultExperiment startTime="0" stopTime="{stop_s}"/>
</ssd:SystemStructureDescription>
"""


HELD = """
        <ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>
          <ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues"
              name="held" version="1.0">
            <ssv:Parameters>
              <ssv:Parameter name="fold.release"><ssv:Boolean value="false"/></ssv:Parameter>
            </ssv:Parameters>
          </ssv:ParameterSet>
        </ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>"""


def component(name, inputs, start_values=""):
    """SSD component of a wing with its connectors; inputs that are not listed keep the FMU's start values."""
    kinds = [("output", *output) for output in OUTPUTS.items()] + [("input", *given) for given in inputs.items()]
    connectors = "\n".join(
        f'          <ssd:Connector name="{connector}" kind="{kind}"><ssc:{value}/></ssd:Connector>'
        for kind, connector, value in kinds
    )
    return (
        f'      <ssd:Component name="{name}" type="application/x-fmu-sharedlibrary" source="resources/wing.fmu">\n'
        f"        <ssd:Connectors>\n{connectors}\n        </ssd:Connectors>{start_values}\n      </ssd:Component>"
    )


def write_ssp(fmu, path, stop_s):
    """Write the SSP file; both wings use one FMU file, which the archive contains once."""
    components = "\n".join([component("left", {}), component("right", {"fold.release": "Boolean"}, HELD)])
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("SystemStructure.ssd", STRUCTURE.format(components=components, stop_s=stop_s))
        archive.write(fmu, "resources/wing.fmu")


def simulate(path, stop_s, step_s):
    """Simulate with FMPy, which takes start values as an argument and ignores those in the file."""
    held = ParameterSet(parameters=[Parameter(name="right.fold.release", value=False)])
    return simulate_ssp(str(path), stop_time=stop_s, step_size=step_s, parameter_set=held)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fmu", type=Path, required=True)
    parser.add_argument("--output", type=Path, required=True, help="output file (SSP)")
    parser.add_argument("--stop", type=float, default=0.4, help="s")
    parser.add_argument("--step", type=float, default=5e-4, help="s")
    arguments = parser.parse_args()

    write_ssp(arguments.fmu, arguments.output, arguments.stop)
    rows = simulate(arguments.output, arguments.stop, arguments.step)
    for wing in ["left", "right"]:
        latch_s, strain = rows[f"{wing}.fold.latch_time"][-1], rows[f"{wing}.gauge.root.strain"]
        print(f"{wing:5} latches at {latch_s:.4f} s, peak root strain {abs(strain).max():.3e}")


if __name__ == "__main__":
    main()
