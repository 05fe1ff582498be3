import foldwing as fw

wing = fw.load("examples/models/folding_wing.toml")


def release_then_load(time: float, sim: fw.Simulation) -> dict[str, float]:  # release at 0.1 s, pull the tip down from 0.3 s
    return {"fold.release": time >= 0.1, "load.outer[4].force.z": -0.1 if time >= 0.3 else 0.0}


run = wing.simulate(stop=0.8, step=1e-3, inputs=release_then_load, outputs=["fold.*", "gauge.root.strain", "tip.position"])
print(f"latched at {run['fold.latch_time'][-1]:.4f} s, largest strain {abs(run['gauge.root.strain']).max():.2e}, "
      f"tip between z = {run['tip.position'][:, 2].min():.3f} and {run['tip.position'][:, 2].max():.3f} m")
