"""Parameter sweep of the folding wing's start angle on a Dask cluster: the same FMU on every worker, with FMPy.

    python examples/sweep_dask.py --fmu target/fmu/FoldingWing.fmu --foldwing target/release/foldwing

Without `--scheduler` a local cluster of two processes is started; `--scheduler tcp://host:8786` uses a running cluster
whose workers can access the FMU's path. With `--foldwing` the same sweep is also run by the command, and the results are
compared. Needs FMPy and python/requirements-dask.txt.
"""

import argparse
import csv
import os
import platform
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy
from dask.distributed import Client, LocalCluster

MODEL = Path(__file__).resolve().parent / "models" / "folding_wing.toml"
STOP_S, STEP_S = 0.4, 1e-3
OUTPUTS = ["fold.angle", "fold.latch_time", "gauge.root.strain"]


def simulate(fmu: str, start_angle: float) -> dict:
    """Simulate one variant on a worker: final angle in rad, latch time in s, peak strain at the root."""
    from fmpy import simulate_fmu

    result = simulate_fmu(
        fmu,
        stop_time=STOP_S,
        output_interval=STEP_S,
        start_values={"fold.start_angle": start_angle},
        output=OUTPUTS,
    )
    return {
        "fold.start_angle": start_angle,
        "fold.angle": float(result["fold.angle"][-1]),
        "fold.first_latch_time": float(result["fold.latch_time"][-1]),
        "gauge.root.strain.peak": float(numpy.abs(result["gauge.root.strain"]).max()),
    }


def by_command(foldwing: str, start_angles: list, folder: Path) -> list:
    """Run the same sweep with `foldwing sweep`."""
    out, samples = folder / "results.csv", folder / "samples.csv"
    samples.write_text("fold.start_angle\n" + "\n".join(map(repr, start_angles)) + "\n")
    subprocess.run(
        [foldwing, "sweep", MODEL, "--samples", samples, "--output", out, "--variables", "fold.angle"]
        + ["--stop", str(STOP_S), "--step", str(STEP_S)],
        check=True,
    )
    with open(out, newline="") as file:
        return list(csv.DictReader(file))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmu", default="target/fmu/FoldingWing.fmu")
    parser.add_argument("--foldwing", help="compare with this command")
    parser.add_argument("--scheduler", help="address of a running cluster")
    parser.add_argument("--workers", type=int, default=2, help="processes of the local cluster")
    parser.add_argument("--variants", type=int, default=12)
    parser.add_argument("--csv", help="output file of the results")
    arguments = parser.parse_args()
    start_angles = numpy.linspace(0.5, 2.9, arguments.variants).tolist()

    local = None
    if arguments.scheduler is None:
        # single-threaded processes: an FMU's library is loaded once per process
        local = LocalCluster(n_workers=arguments.workers, threads_per_worker=1, dashboard_address=None)
    with Client(arguments.scheduler or local) as client:
        fmu = os.path.abspath(arguments.fmu)
        # pure=False: do not reuse cached results if the file has changed under the same name
        rows = client.gather([client.submit(simulate, fmu, angle, pure=False) for angle in start_angles])
    if local is not None:
        local.close()

    for row in rows:
        print("  ".join(f"{name} {value:.6g}" for name, value in row.items()))
    if arguments.csv:
        with open(arguments.csv, "w", newline="") as file:
            writer = csv.DictWriter(file, rows[0])
            writer.writeheader()
            writer.writerows(rows)
    if arguments.foldwing:
        folder = Path(tempfile.mkdtemp())
        try:
            expected = by_command(arguments.foldwing, start_angles, folder)
        finally:
            shutil.rmtree(folder)
        largest = max(abs(row[name] - float(other[name])) for row, other in zip(rows, expected) for name in row)
        print(f"{len(rows)} variants on Dask and by `foldwing sweep`: largest difference {largest:.1e} ({platform.system()})")
        # communication points of FMPy are accumulated sums of steps and differ in the last bits
        if len(expected) != len(rows) or not largest < 1e-9:
            raise SystemExit("the two sweeps differ")


if __name__ == "__main__":
    main()
