"""CasADi on the Model Exchange FMU of the folding wing: Jacobian, products with it, sensitivities by CVODES, forward and adjoint.

    python3 -m venv casadi && casadi/bin/pip install casadi==3.8.2
    casadi/bin/python studies/casadi_model_exchange.py --foldwing target/release/foldwing

FMI 2.0 and FMI 3.0 in scalars. Printed, for CA-01: the difference of the Jacobian from central differences of the importer over its largest entry, of
forward and adjoint products from products with the Jacobian, and of the sensitivities of the fold angle from central differences of CVODES
at a tolerance of 1e-11. For CA-02: adjoint sensitivities of the fold angle by CVODES and by IDAS over forward ones, of the wing with one
element per body; a backward step costs a Jacobian.
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
# Step of the central differences, in the units of the states: their error is 1e-10 of the largest entry.
STEP = 1e-5
TORQUE, STIFFNESS = "fold.external_torque", "fold.motor_stiffness"


def flat(matrix):
    """A vector of CasADi as one of NumPy."""
    return np.array(matrix).ravel()


def load(path):
    """The builder with the function of states, inputs and tunable parameters, and their start values."""
    builder = casadi.DaeBuilder("wing", str(path))
    function = builder.create("f", ["x", "u", "p"], ["ode", "y"])
    starts = [flat([builder.start(name) for name in names]) for names in (builder.x(), builder.u(), builder.p())]
    return builder, function, starts


def differentiate(function, starts):
    """Largest differences of the Jacobian and of the products with it."""
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


def problem_of(builder, function, starts):
    """Problem of an integrator with a torque and the motor's stiffness as parameters, their values, and the place of the fold angle."""
    x0, u0, p0 = starts
    angle, torque, stiffness = builder.x().index("state.fold.angle"), builder.u().index(TORQUE), builder.p().index(STIFFNESS)
    x, q = casadi.MX.sym("x", len(x0)), casadi.MX.sym("q", 2)
    u = casadi.vertcat(*[q[0] if i == torque else value for i, value in enumerate(u0)])
    p = casadi.vertcat(*[q[1] if i == stiffness else value for i, value in enumerate(p0)])
    return {"x": x, "p": q, "ode": function(x, u, p)[0]}, np.array([0.0, p0[stiffness]]), angle


def sensitivities(builder, function, starts, stop_s):
    """Sensitivities of the fold angle at the end to a torque and to the motor's stiffness, by CVODES and by differences of it."""
    x0 = starts[0]
    problem, about, angle = problem_of(builder, function, starts)

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


def adjoint(builder, function, starts, stop_s):
    """The same sensitivities by integration backwards, by CVODES and IDAS, over those forwards."""
    x0 = starts[0]
    problem, about, angle = problem_of(builder, function, starts)
    q = casadi.MX.sym("q", 2)
    for plugin in ("cvodes", "idas"):
        march = casadi.integrator("march", plugin, problem, 0, stop_s, {"reltol": 1e-8, "abstol": 1e-10, "max_num_steps": 1_000_000})
        end = march(x0=x0, p=about)["xf"]
        forward = np.array(march.forward(2)(x0=x0, p=about, fwd_p=np.eye(2), out_xf=end)["fwd_xf"])[angle]
        # `march.reverse(1)` has its seeds under the names adj2_xf, and an empty adj_xf
        gradient = casadi.Function("gradient", [q], [casadi.gradient(march(x0=x0, p=q)["xf"][angle], q)])
        began = time.process_time()
        backward = flat(gradient(about))
        print(f"{plugin}: adjoint {backward}, off the forward ones by {np.abs(backward / forward - 1).max():.1e}, {time.process_time() - began:.0f} s")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--foldwing", type=Path, required=True, help="the command")
    parser.add_argument("--stop", type=float, default=0.01, help="end of the sensitivities in s")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for version, options in (("2.0", []), ("3.0 in scalars", ["--fmi", "3", "--scalars"])):
            path = Path(folder) / f"wing{version[0]}.fmu"
            command = [arguments.foldwing, "package", MODEL, "-o", path, "--interface", "me", "--no-reference", "--real-outputs-only", *options]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            print(f"FMI {version}")
            builder, function, starts = load(path)
            differentiate(function, starts)
            if version == "2.0":
                sensitivities(builder, function, starts, arguments.stop)
        model, path = Path(folder) / "small.toml", Path(folder) / "small.fmu"
        model.write_text(MODEL.read_text().replace("elements = 4", "elements = 1"))
        subprocess.run([arguments.foldwing, "package", model, "-o", path, "--interface", "me", "--no-reference", "--real-outputs-only", "-q"], check=True)
        adjoint(*load(path), arguments.stop)


if __name__ == "__main__":
    main()
