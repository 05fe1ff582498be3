"""CasADi on the Model Exchange FMU of the folding wing: Jacobian, products with it, and forward sensitivities by CVODES.

    python3 -m venv casadi && casadi/bin/pip install casadi==3.8.2
    casadi/bin/python studies/casadi_model_exchange.py --foldwing target/release/foldwing

Uses FMI 2.0 and FMI 3.0 with scalars. Prints, for CA-01, the difference between the Jacobian and central differences of the importer
relative to its largest entry, between forward and adjoint products and products with the Jacobian, and between the sensitivities of the
fold angle and central differences of CVODES at a tolerance of 1e-11.
"""

import argparse
import subprocess
import tempfile
import time
from pathlib import Path

import casadi
import numpy as np

ROOT = Path(__file__).resolve().parents[1]
MODEL = ROOT / "examples/models/folding_wing.toml"
# Step of the central differences, in the units of the states: their error is 1e-10 relative to the largest entry.
STEP = 1e-5
TORQUE, STIFFNESS = "fold.external_torque", "fold.motor_stiffness"


def flat(matrix):
    """Converts a CasADi vector to a NumPy vector."""
    return np.array(matrix).ravel()


def load(path):
    """The builder, the function of states, inputs and tunable parameters, and their start values."""
    builder = casadi.DaeBuilder("wing", str(path))
    # CasADi reads Boolean and Integer outputs as Real
    builder.set_y([name for name in builder.y() if builder.type(name) in ("Real", "Float64")])
    function = builder.create("f", ["x", "u", "p"], ["ode", "y"])
    starts = [flat([builder.start(name) for name in names]) for names in (builder.x(), builder.u(), builder.p())]
    return builder, function, starts


def differentiate(function, starts):
    """Largest errors of the Jacobian and of the products with it."""
    x, u, p = starts
    x = x + 1e-3
    jacobian = function.factory("jacobian", ["x", "u", "p"], ["jac:ode:x"])
    began = time.perf_counter()
    exact = np.array(jacobian(x, u, p))
    print(f"Jacobian of {exact.shape[0]} x {exact.shape[1]} in {1e3 * (time.perf_counter() - began):.1f} ms")
    unit = np.eye(len(x)) * STEP
    columns = [(flat(function(x + along, u, p)[0]) - flat(function(x - along, u, p)[0])) / (2 * STEP) for along in unit]
    rng = np.random.default_rng(0)
    along, over = rng.standard_normal(len(x)), rng.standard_normal(len(x))
    bare = casadi.Function("bare", symbols := [casadi.MX.sym(n, len(v)) for n, v in zip("xup", starts)], [function(*symbols)[0]])
    forward = flat(bare.forward(1)(x, u, p, 0, along, 0 * u, 0 * p))
    adjoint = flat(bare.reverse(1)(x, u, p, 0, over)[0])
    off = lambda found, expected: np.abs(found - expected).max() / np.abs(expected).max()
    print(f"Jacobian {off(exact, np.array(columns).T):.1e}, forward {off(forward, exact @ along):.1e}, adjoint {off(adjoint, over @ exact):.1e}")


def sensitivities(builder, function, starts, stop_s):
    """Sensitivities of the final fold angle to a torque and to the motor's stiffness, from CVODES and from differences of CVODES
    solutions."""
    x0, u0, p0 = starts
    angle, torque, stiffness = builder.x().index("state.fold.angle"), builder.u().index(TORQUE), builder.p().index(STIFFNESS)
    x, q = casadi.MX.sym("x", len(x0)), casadi.MX.sym("q", 2)
    u = casadi.vertcat(*[q[0] if i == torque else value for i, value in enumerate(u0)])
    p = casadi.vertcat(*[q[1] if i == stiffness else value for i, value in enumerate(p0)])
    problem = {"x": x, "p": q, "ode": function(x, u, p)[0]}
    about = np.array([0.0, p0[stiffness]])

    def integrator(relative, absolute):
        options = {"reltol": relative, "abstol": absolute, "max_num_steps": 1_000_000}
        return casadi.integrator("march", "cvodes", problem, 0, stop_s, options)

    march, fine = integrator(1e-7, 1e-9), integrator(1e-11, 1e-13)
    end = march(x0=x0, p=about)["xf"]
    forward = march.forward(1)
    for k, (name, step) in enumerate(((TORQUE, 1e-3), (STIFFNESS, 1e-4))):
        unit = np.eye(2)[k]
        found = float(forward(x0=x0, p=about, fwd_p=unit, out_xf=end)["fwd_xf"][angle])
        above, below = (flat(fine(x0=x0, p=about + sign * step * unit)["xf"])[angle] for sign in (1, -1))
        expected = (above - below) / (2 * step)
        print(f"fold angle by {name}: {found:.9g}, by differences {expected:.9g}, off by {abs(found / expected - 1):.1e}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--foldwing", type=Path, required=True, help="the command")
    parser.add_argument("--stop", type=float, default=0.01, help="end of the sensitivities in s")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for version, options in (("2.0", []), ("3.0 in scalars", ["--fmi", "3", "--scalars"])):
            path = Path(folder) / f"wing{version[0]}.fmu"
            command = [arguments.foldwing, "package", MODEL, "-o", path, "--interface", "me", "--no-reference", *options]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            print(f"FMI {version}")
            builder, function, starts = load(path)
            differentiate(function, starts)
            if version == "2.0":
                sensitivities(builder, function, starts, arguments.stop)


if __name__ == "__main__":
    main()
