import sys

from fmpy import read_model_description, simulate_fmu

fmu = sys.argv[1]
reference = {variable.name: [variable.valueReference] for variable in read_model_description(fmu).modelVariables}


def release_then_load(time, recorder):  # called after every step: release at 0.1 s, pull the tip down from 0.3 s
    recorder.fmu.setBoolean(reference["fold.release"], [time >= 0.1])
    recorder.fmu.setReal(reference["load.outer[4].force.z"], [-0.1 if time >= 0.3 else 0.0])
    return True


result = simulate_fmu(fmu, stop_time=0.8, output_interval=1e-3, start_values={"fold.release": False},
                      output=["fold.latch_time", "gauge.root.strain", "tip.position.z"], step_finished=release_then_load)
print(f"latched at {result['fold.latch_time'][-1]:.4f} s, largest strain {abs(result['gauge.root.strain']).max():.2e}, "
      f"tip between z = {result['tip.position.z'].min():.3f} and {result['tip.position.z'].max():.3f} m")
