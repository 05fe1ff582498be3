#!/usr/bin/env python3
"""Optimal control with CasADi and IPOPT: the folding wing from folded to latched at rest in the least time, its root strain bounded.

Usage: fastest_unfolding.py --foldwing target/release/foldwing [--picture OUT.png] [--twice] [--intervals 60]

The Model Exchange FMU of the wing provides the equations and, with its directional derivatives, their exact Jacobian; CasADi
(`pip install casadi`, 3.8.2) collocates them in time (Radau, three points per interval), IPOPT finds times, states and torque. The torque
at the hinge is linear between the ends of the intervals, limited in magnitude and slope; its initial value holds the folded wing against its
motor. It is then replayed in co-simulation: on the wing of the optimisation, with one element per body, and on the shipped one with four. `--twice` solves with twice as many intervals too.
"""

import argparse
import contextlib
import io
import subprocess
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import casadi
import numpy as np
from fmpy import simulate_fmu

MODEL = Path(__file__).resolve().parent / "models/folding_wing.toml"
TORQUE, GAUGE, ANGLE = "fold.external_torque", "gauge.root.strain", "fold.angle"
FOLDED_RAD = np.radians(170.0)
BOUND = 2.5e-3  # largest root strain; without the torque it is 4.2e-3 until the latch, 5.3e-3 afterwards
TORQUE_LIMIT_N_M, SLOPE_LIMIT_N_M_S = 0.15, 2.0
ARRIVAL_RAD_S = -0.05  # rate at the latch, which needs a crossing to close
REST_1_M, REST_RATE_1_M_S = 0.1, 10.0  # curvatures and their rates at the latch: 1e-4 of strain, 3 % of the bound
POINTS = 3  # collocation points per interval
GUESS_S = 0.3  # duration of the first guess
COARSE = 30  # more intervals start from the optimum of half as many
# motor of the model file, and inertia of the outer wing about the hinge, for the first guess only
STIFFNESS_N_M_RAD, CONSTANT_TORQUE_N_M, DAMPING_N_M_S_RAD, INERTIA_KG_M2 = 0.026, 0.043, 0.0008, 1.6e-4


class Wing(NamedTuple):
    """The equations in scaled numbers: states in the plane of the motion over `scale`, torque over its limit."""

    rates: casadi.Function  # of states and torque, below each other: scaled rates of the states per s, strain over the bound
    start: np.ndarray
    scale: np.ndarray
    names: list
    hold: float  # torque that holds the folded wing


class Optimum(NamedTuple):
    """The fastest unfolding: its duration, the torque at the ends of the intervals, strains at the collocation points; all unknowns, scaled."""

    duration_s: float
    torque_n_m: np.ndarray
    strain_time_s: np.ndarray
    strain: np.ndarray
    iterations: int
    converged: bool
    processor_s: float
    unknowns: np.ndarray


def package(foldwing, folder, elements, interface):
    """FMU of the wing with this number of elements per body."""
    model, fmu = Path(folder) / f"wing{elements}.toml", Path(folder) / f"wing{elements}_{interface}.fmu"
    model.write_text(MODEL.read_text().replace("elements = 4", f"elements = {elements}"))
    command = [str(foldwing), "package", str(model), "-o", str(fmu), "--interface", interface, "--no-reference", "--quiet"]
    subprocess.run(command, check=True)
    return fmu


def equations(fmu):
    """The wing of a Model Exchange FMU. Twist, edgewise bending and their rates remain zero, and are no unknowns."""
    dae = casadi.DaeBuilder("wing", str(fmu))
    dae.set_y([GAUGE])
    function = dae.create("f", ["x", "u", "p"], ["ode", "y"])
    start, inputs, parameters = (np.array([dae.start(name) for name in names]).ravel() for names in (dae.x(), dae.u(), dae.p()))
    plane = [i for i, name in enumerate(dae.x()) if name.endswith(("epsilon_x", "kappa_y", ANGLE))]
    names = [dae.x()[i] for i in plane]
    scale = np.array([(1e-4 if "epsilon" in name else 1.0) * (30.0 if name.startswith("state_rate") else 1.0) for name in names])
    z = casadi.MX.sym("z", len(plane) + 1)
    x = casadi.MX(casadi.DM(start))
    x[plane] = z[:-1] * scale
    u = casadi.vertcat(*[z[-1] * TORQUE_LIMIT_N_M if name == TORQUE else value for name, value in zip(dae.u(), inputs)])
    ode, strain = function(x, u, parameters)
    rates = casadi.Function("rates", [z], [ode[plane] / scale, strain / BOUND])
    row = names.index(f"state_rate.{ANGLE}")
    free, pulled = (float(rates(np.r_[start[plane] / scale, torque])[0][row]) for torque in (0.0, 1.0))
    return Wing(rates, start[plane] / scale, scale, names, free / (free - pulled))


def guess(wing, intervals, times, slopes):
    """States and torque of a feedback on a smooth course, marched by the collocation itself."""
    n = len(wing.start)
    angle, rate = wing.names.index(f"state.{ANGLE}"), wing.names.index(f"state_rate.{ANGLE}")
    stages, begin, ends, step = (casadi.MX.sym(name, size) for name, size in (("z", n * POINTS), ("x", n), ("u", 2), ("h", 1)))
    states = [begin, *(stages[k * n : (k + 1) * n] for k in range(POINTS))]
    residual = [
        sum(slopes[i, k] * states[i] for i in range(POINTS + 1))
        - step * wing.rates(casadi.vertcat(states[k + 1], ends[0] * (1 - times[k + 1]) + ends[1] * times[k + 1]))[0]
        for k in range(POINTS)
    ]
    problem = {"x": stages, "p": casadi.vertcat(begin, ends, step), "g": casadi.vertcat(*residual)}
    march = casadi.rootfinder("march", "newton", problem, {"abstol": 1e-8, "error_on_fail": False})
    torque, columns, present = [wing.hold], [], wing.start
    for k in range(intervals):
        s, duration_s = min((k + 1) / intervals / 0.7, 1.0), 0.7 * GUESS_S
        course = FOLDED_RAD * np.array([1 - 10 * s**3 + 15 * s**4 - 6 * s**5, -30 * s**2 + 60 * s**3 - 30 * s**4, -60 * s + 180 * s**2 - 120 * s**3])
        course /= duration_s ** np.arange(3)
        needed = STIFFNESS_N_M_RAD * course[0] + CONSTANT_TORQUE_N_M + DAMPING_N_M_S_RAD * course[1] + INERTIA_KG_M2 * course[2]
        off = course[:2] - present[[angle, rate]] * wing.scale[[angle, rate]]
        torque.append(np.clip((needed + 0.05 * off[0] + 0.004 * off[1]) / TORQUE_LIMIT_N_M, -1.0, 1.0))
        found = march(x0=np.tile(present, POINTS), p=np.r_[present, torque[-2:], GUESS_S / intervals])["x"]
        columns.append(np.array(found).ravel())
        present = columns[-1][-n:]
    return np.r_[GUESS_S, torque, np.concatenate(columns)]


def refine(wing, unknowns, times):
    """The same motion on twice as many intervals: states on the polynomials of the collocation, torque on its lines."""
    n = len(wing.start)
    intervals = (len(unknowns) - 2) // (n * POINTS + 1)
    torque, columns = unknowns[1 : intervals + 2], unknowns[intervals + 2 :].reshape(intervals, POINTS, n)
    begins = np.concatenate([wing.start[None], columns[:-1, -1]])
    nodes = np.concatenate([begins[:, None], columns], axis=1)
    halves = []
    for half in (0, 1):
        at = (half + times[1:]) / 2
        weights = np.array([[np.prod([(s - other) / (own - other) for other in times if other != own]) for own in times] for s in at])
        halves.append(np.einsum("jp,kpn->kjn", weights, nodes))
    fine = np.stack(halves, axis=1).ravel()
    return np.r_[unknowns[0], np.interp(np.arange(2 * intervals + 1) / 2, np.arange(intervals + 1), torque), fine]


def solve(wing, intervals, max_iterations=200):
    """The optimum: from that of half as many intervals; on the coarsest from the least torque in a given time."""
    begin_s, n = time.process_time(), len(wing.start)
    before = solve(wing, intervals // 2, max_iterations) if intervals > COARSE and intervals % 2 == 0 else None
    times = np.array([0.0, *casadi.collocation_points(POINTS, "radau")])
    slopes = np.array(casadi.collocation_coeff(list(times[1:]))[0])
    unknowns = casadi.MX.sym("w", intervals + 2 + n * intervals * POINTS)
    duration, torque = unknowns[0], unknowns[1 : intervals + 2]
    states = casadi.reshape(unknowns[intervals + 2 :], n, intervals * POINTS)
    zero = np.r_[wing.start, 0.0]
    symbol = casadi.MX.sym("z", n + 1)
    jacobian = np.array(casadi.Function("j", [symbol], [casadi.jacobian(wing.rates(symbol)[0], symbol)])(zero))[:, :n]
    # residuals in units of states: those of rates would be larger by the square of frequency times step
    condition = np.linalg.inv(np.eye(n) - GUESS_S / intervals / 2 * jacobian)
    defects, strains = [], []
    # not by `map`, whose derivative of functions in FMUs is wrong in CasADi 3.8.2
    for k in range(intervals):
        own = [states[:, k * POINTS + j] for j in range(POINTS)]
        at = [states[:, k * POINTS - 1] if k else casadi.DM(wing.start), *own]
        for j in range(1, POINTS + 1):
            rates, strain = wing.rates(casadi.vertcat(at[j], torque[k] * (1 - times[j]) + torque[k + 1] * times[j]))
            slope = sum(slopes[i, j - 1] * at[i] for i in range(POINTS + 1))
            defects.append(casadi.mtimes(condition, slope - duration / intervals * rates))
            strains.append(strain)
    end, steps = states[:, -1], torque[1:] - torque[:-1]
    ends = {f"state.{ANGLE}": (0.0, 0.0), f"state_rate.{ANGLE}": (ARRIVAL_RAD_S, ARRIVAL_RAD_S)}
    for name in wing.names:
        if "kappa" in name:
            rest = REST_RATE_1_M_S if name.startswith("state_rate") else REST_1_M
            ends[name] = (-rest, rest)
    rows = [wing.names.index(name) for name in ends]
    slope_limit = SLOPE_LIMIT_N_M_S / TORQUE_LIMIT_N_M * duration / intervals
    constraints = [(casadi.vertcat(*defects), 0.0, 0.0), (casadi.vertcat(*strains), -1.0, 1.0)]
    constraints += [(end[row] * wing.scale[row] / allowed, low / allowed, high / allowed)
                    for row, (low, high) in zip(rows, ends.values()) for allowed in [max(abs(low), abs(high)) or 1.0]]
    constraints += [(sign * steps - slope_limit, -np.inf, 0.0) for sign in (1.0, -1.0)]
    bounds = [np.concatenate([np.full(row.numel(), row_[side]) for row_ in constraints for row in row_[:1]]) for side in (1, 2)]
    g = casadi.vertcat(*[row for row, _, _ in constraints])

    def minimise(objective, first, shortest_s, longest_s, iterations, **more):
        # the Hessian matrix of the objective alone (Gauss and Newton): at the optimum bounds hold almost every unknown
        hessian = casadi.triu(casadi.hessian(objective, unknowns)[0])
        nothing, factor, multipliers = casadi.MX.sym("p", 0), casadi.MX.sym("f"), casadi.MX.sym("m", g.numel())
        own = casadi.Function("nlp_hess_l", [unknowns, nothing, factor, multipliers], [factor * hessian],
                              ["x", "p", "lam_f", "lam_g"], ["triu_hess_gamma_x_x"])
        options = {"hess_lag": own, "print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.tol": 1e-5,
                   "ipopt.max_iter": iterations, "ipopt.mu_strategy": "adaptive", **more}
        ipopt = casadi.nlpsol("ipopt", "ipopt", {"x": unknowns, "f": objective, "g": g}, options)
        free = np.full(n * intervals * POINTS, np.inf)
        low, high = (np.r_[limit, wing.hold, np.full(intervals, sign), sign * free] for limit, sign in ((shortest_s, -1.0), (longest_s, 1.0)))
        found = ipopt(x0=first, lbx=low, ubx=high, lbg=bounds[0], ubg=bounds[1])
        return np.array(found["x"]).ravel(), ipopt.stats()

    if before is None:
        small = casadi.sumsqr(torque) / intervals + intervals * casadi.sumsqr(steps)
        found, first = minimise(0.1 * small, guess(wing, intervals, times, slopes), GUESS_S, GUESS_S, 30)
        iterations, close = first["iter_count"], {}
    else:
        found, iterations = refine(wing, before.unknowns, times), before.iterations
        # near the optimum: the start is not pushed off its bounds
        close = {"ipopt.mu_init": 1e-4, "ipopt.bound_push": 1e-6, "ipopt.bound_frac": 1e-6, "ipopt.mu_strategy": "monotone"}
    found, stats = minimise(10.0 * duration + 1e-4 * intervals * casadi.sumsqr(steps), found, 0.05, 0.5, max_iterations, **close)
    strain = np.array(casadi.Function("strain", [unknowns], [casadi.vertcat(*strains)])(found)).ravel() * BOUND
    points_s = (np.arange(intervals)[:, None] + times[1:]).ravel() * found[0] / intervals
    return Optimum(found[0], found[1 : intervals + 2] * TORQUE_LIMIT_N_M, points_s, strain, iterations + stats["iter_count"],
                   stats["success"], time.process_time() - begin_s, found)


def replay(fmu, optimum, stop_s=0.35):
    """Co-simulation with the torque over time; afterwards the motor alone holds the wing in its latch."""
    times_s = np.linspace(0.0, optimum.duration_s, len(optimum.torque_n_m))
    rows = [*zip(times_s, optimum.torque_n_m), (optimum.duration_s + 2e-3, 0.0), (stop_s, 0.0)]
    inputs = np.array(rows, dtype=[("time", float), (TORQUE, float)])
    with contextlib.redirect_stdout(io.StringIO()):  # FMPy lists the inputs that are not in the table
        return simulate_fmu(str(fmu), stop_time=stop_s, output_interval=1e-4, input=inputs, output=[ANGLE, GAUGE, "fold.latch_time"],
                            start_values={"solver.tolerance": 1e-7}, record_events=False)


def compare(optimum, run):
    """Largest difference of the strain until the latch from the predicted one, over the bound; peaks until the latch and after it."""
    strain = np.abs(run[GAUGE])
    there = np.interp(optimum.strain_time_s, run["time"], run[GAUGE])
    until = run["time"] <= optimum.duration_s
    return np.abs(there - optimum.strain).max() / BOUND, strain[until].max(), strain[~until].max()


def draw(optimum, runs, path):
    """Fold angle, torque and strain over time: optimum, replay on the shipped wing, and the wing without torque."""
    import matplotlib.pyplot as plt
    from house_style import BLUE, FAINT, VERMILION, use

    use()
    figure, axes = plt.subplots(3, 1, sharex=True, figsize=(6.8, 6.6), height_ratios=[1, 1, 1.3], layout="constrained")
    own, shipped = runs
    for run, color in ((own, FAINT), (shipped, BLUE)):
        axes[0].plot(1e3 * run["time"], np.degrees(run[ANGLE]), color=color)
        axes[2].plot(1e3 * run["time"], 1e3 * run[GAUGE], color=color)
    times_s = np.linspace(0.0, optimum.duration_s, len(optimum.torque_n_m))
    axes[1].plot(1e3 * times_s, optimum.torque_n_m, color=BLUE)
    axes[2].plot(1e3 * optimum.strain_time_s, 1e3 * optimum.strain, ".", ms=4, color=VERMILION)
    for sign in (1, -1):
        axes[1].axhline(sign * TORQUE_LIMIT_N_M, color=FAINT, lw=0.8, ls=":")
        axes[2].axhline(sign * 1e3 * BOUND, color=FAINT, lw=0.8, ls=":")
    axes[0].set_ylabel("fold angle [°]")
    axes[1].set_ylabel("torque [N·m]")
    axes[2].set_ylabel("root strain [10⁻³]")
    axes[2].set_xlabel("time [ms]")
    axes[0].set_title("Fastest unfolding with a bound on the root strain")
    axes[0].annotate("without torque", (15, 60), color=FAINT)
    axes[0].annotate("fastest", (120, 95), color=BLUE)
    axes[2].annotate("collocation points of the optimum", (0.98, 0.03), xycoords="axes fraction", ha="right", color=VERMILION)
    axes[2].annotate("bound", (0, 1e3 * BOUND), va="bottom", color=FAINT)
    figure.savefig(path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--foldwing", type=Path, required=True, help="the command")
    parser.add_argument("--intervals", type=int, default=60)
    parser.add_argument("--twice", action="store_true", help="solve with twice as many intervals too")
    parser.add_argument("--picture", type=Path, help="picture of torque, angle and strain")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        wing = equations(package(arguments.foldwing, folder, 1, "me"))
        optimum = solve(wing, arguments.intervals)
        print(f"{arguments.intervals} intervals: {1e3 * optimum.duration_s:.2f} ms, largest strain {np.abs(optimum.strain).max():.3e}, "
              f"{optimum.iterations} iterations, {optimum.processor_s:.1f} s of the processor, converged: {optimum.converged}")
        if arguments.twice:
            fine = solve(wing, 2 * arguments.intervals)
            print(f"{2 * arguments.intervals} intervals: {1e3 * fine.duration_s:.2f} ms, {optimum.duration_s / fine.duration_s - 1:+.2%} with half of them, "
                  f"{fine.processor_s:.1f} s of the processor, converged: {fine.converged}")
        for elements in (1, 4):
            run = replay(package(arguments.foldwing, folder, elements, "cs"), optimum)
            off, before, after = compare(optimum, run)
            print(f"replayed with {elements} elements per body: latched at {1e3 * run['fold.latch_time'][-1]:.2f} ms, strain off by {off:.2%} of the "
                  f"bound, largest {before:.3e} until then, {after:.3e} afterwards")
        if arguments.picture:
            none = optimum._replace(torque_n_m=np.zeros(2))
            draw(optimum, (replay(package(arguments.foldwing, folder, 4, "cs"), none), run), arguments.picture)


if __name__ == "__main__":
    main()
