#!/usr/bin/env python3
"""Measures the cost of the vortex lattice as a function of its number of panels: the wing in the tunnel with increasingly fine lattices.

  python studies/lattice_cost.py --foldwing COMMAND [--compare OTHER_COMMAND] [--runs 3] [--stop 0.05]

Prints processor seconds per simulated second, the smallest of several alternating runs. `--compare` names a second command, of another
version, whose runs alternate with those of the first.
"""
import argparse
import json
import pathlib
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
MODEL = ROOT / "examples" / "models" / "folding_wing_in_tunnel.toml"
CASES = [(10, 4, False), (25, 4, False), (25, 8, False), (50, 6, False), (50, 10, False), (10, 4, True)]  # strips, chord panels, free wake


def seconds(command: str, model: pathlib.Path, stop_s: float) -> float:
    """Processor seconds per simulated second."""
    timing = model.with_suffix(".json")
    run = [command, "simulate", str(model), "--stop", str(stop_s), "--variables", "fold.angle", "--csv", str(model.with_suffix(".csv"))]
    subprocess.run([*run, "--profile", str(timing), "--force", "--quiet"], check=True, capture_output=True)
    return json.loads(timing.read_text())["processor_s"] / stop_s


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--foldwing", required=True)
    parser.add_argument("--compare")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--stop", type=float, default=0.05)
    arguments = parser.parse_args()
    commands = [arguments.foldwing] + ([arguments.compare] if arguments.compare else [])
    print("panels  wake        s/s" + ("  beside  ratio" if arguments.compare else ""))
    with tempfile.TemporaryDirectory() as folder:
        for strips, chord, free in CASES:
            text = MODEL.read_text().replace("strips = 10", f"strips = {strips}").replace("chord_panels = 4", f"chord_panels = {chord}")
            if free:
                text = text.replace("wake_rows = 30", "wake_rows = 300\nfree_wake = true")
            model = pathlib.Path(folder) / f"panels_{2 * strips * chord}.toml"
            model.write_text(text)
            least = [min(times) for times in zip(*([seconds(c, model, arguments.stop) for c in commands] for _ in range(arguments.runs)))]
            wake = "300, free" if free else "30"
            line = f"{2 * strips * chord:6d}  {wake:9s} {least[0]:6.2f}"
            print(line + (f"  {least[1]:6.2f}  {least[1] / least[0]:5.2f}" if arguments.compare else ""), flush=True)


if __name__ == "__main__":
    main()
