"""Gradient of a run through a rigid latch: Foldwing, diffrax with an event, and the closed form, by the same eight numbers.

    python3 -m venv diffrax && diffrax/bin/pip install jax==0.10.2 diffrax==0.7.2
    diffrax/bin/python studies/rigid_latch_gradient.py --foldwing target/release/foldwing

Two arms without torque: a rigid latch joins them, and angular momentum is kept. Closed form: one quadrature, differentiated by JAX. diffrax
integrates the equations that this script writes down to an event, the jump is the script's too. Printed, for GR-41: values, largest
differences of the derivatives from the closed form over the largest of their row, and processor time of a gradient.
"""

import argparse
import json
import subprocess
import tempfile
import time
from pathlib import Path

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import optimistix

jax.config.update("jax_enable_x64", True)
NAMES = ["inertia of the inner arm", "inertia of the outer arm", "mass", "distance of the hinge", "distance of the mass", "rate of the inner arm", "rate of the fold", "edge of the latch"]
NUMBERS = np.array([0.05, 0.004, 0.6, 0.3, 0.25, 0.7, 2.0, 0.9])
RESULTS = ["fold.latch_time", "shoulder.angle", "shoulder.angular_velocity", "energy.kinetic"]
START_RAD, END_S, CAPTURE_RAD = -0.8, 1.2, 0.01
KEYS = [
    "rigid_body.inner.inertia_kg_m2.2",
    "rigid_body.outer.inertia_kg_m2.2",
    "rigid_body.outer.mass_kg",
    "joint.fold.parent_offset_m.0",
    "rigid_body.outer.centre_of_mass_m.0",
    "joint.shoulder.start_rate_deg_s",
    "joint.fold.start_rate_deg_s",
    "joint.fold.latch.angle_deg",
]
IN_DEGREES = np.array([1, 1, 1, 1, 1, 180 / np.pi, 180 / np.pi, 180 / np.pi])


def masses(numbers, angle):
    """The three entries of the mass matrix, for the rates of the inner arm and of the fold."""
    inner, outer, mass, arm, reach = numbers[:5]
    across = mass * arm * reach * jnp.cos(angle)
    about = outer + mass * reach**2
    return inner + about + mass * arm**2 + 2 * across, about + across, about


def closed_form(numbers):
    """Results by the constancy of momentum and energy and one Gauss quadrature."""
    spin, rate, edge = numbers[5:]
    whole, mixed, own = masses(numbers, START_RAD)
    momentum = whole * spin + mixed * rate
    twice = whole * spin**2 + 2 * mixed * spin * rate + own * rate**2
    places, weights = np.polynomial.legendre.leggauss(60)
    angle = START_RAD + (edge - START_RAD) * 0.5 * (1 + places)
    whole, mixed, own = masses(numbers, angle)
    fold = jnp.sqrt((twice - momentum**2 / whole) / (own - mixed**2 / whole))
    share = 0.5 * (edge - START_RAD) * weights
    latch_s, turn = jnp.sum(share / fold), jnp.sum(share * (momentum - mixed * fold) / whole / fold)
    behind = momentum / masses(numbers, edge)[0]
    return jnp.array([latch_s, turn + behind * (END_S - latch_s), behind, 0.5 * momentum * behind])


def by_diffrax(numbers):
    """The same by integration to an event, with the jump of the latch written by hand."""

    def slope(t, y, numbers):
        angle, spin, rate = y[1], y[2], y[3]
        mass, arm, reach = numbers[2:5]
        whole, mixed, own = masses(numbers, angle)
        across = mass * arm * reach * jnp.sin(angle)
        right = jnp.array([across * (2 * spin * rate + rate**2), -across * spin**2])
        return jnp.concatenate([y[2:], jnp.linalg.solve(jnp.array([[whole, mixed], [mixed, own]]), right)])

    event = diffrax.Event(lambda t, y, args, **_: y[1] - args[7], root_finder=optimistix.Newton(1e-12, 1e-12))
    start = jnp.array([0.0, START_RAD, numbers[5], numbers[6]])
    run = diffrax.diffeqsolve(
        diffrax.ODETerm(slope), diffrax.Dopri8(), 0.0, 5.0, 1e-2, start, numbers, event=event, stepsize_controller=diffrax.PIDController(rtol=1e-11, atol=1e-13)
    )
    latch_s, (turn, angle, spin, rate) = run.ts[-1], run.ys[-1]
    whole, mixed, _ = masses(numbers, angle)
    momentum = whole * spin + mixed * rate
    behind = momentum / whole
    return jnp.array([latch_s, turn + behind * (END_S - latch_s), behind, 0.5 * momentum * behind])


def model():
    """The model file of the two arms."""
    inner, outer, mass, arm, reach, spin, rate, edge = (float(number) for number in NUMBERS)
    return f"""
name = "Arms"
gravity_m_s2 = [0.0, 0.0, 0.0]

[rigid_body.inner]
mass_kg = 1.0
inertia_kg_m2 = [{inner}, {inner}, {inner}, 0.0, 0.0, 0.0]

[rigid_body.outer]
mass_kg = {mass}
centre_of_mass_m = [{reach}, 0.0, 0.0]
inertia_kg_m2 = [{outer}, {outer}, {outer}, 0.0, 0.0, 0.0]

[joint.shoulder]
type = "revolute"
parent = "root"
child = "inner"
axis = [0.0, 0.0, 1.0]
start_rate_deg_s = {np.degrees(spin)!r}

[joint.fold]
type = "revolute"
parent = "inner"
child = "outer"
axis = [0.0, 0.0, 1.0]
parent_offset_m = [{arm}, 0.0, 0.0]
start_angle_deg = {np.degrees(START_RAD)!r}
start_rate_deg_s = {np.degrees(rate)!r}

[joint.fold.latch]
kind = "rigid"
angle_deg = {np.degrees(edge + CAPTURE_RAD)!r}
capture_deg = {np.degrees(CAPTURE_RAD)!r}

[solver]
tolerance = 1e-10
""".replace("np.float64(", "").replace(")", "")


def by_foldwing(command, mode):
    """Values and derivatives by the command."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "arms.toml"
        path.write_text(model(), encoding="utf-8")
        by = ",".join(f"file:{key}" for key in KEYS)
        words = [command, "gradient", str(path), "--of", ",".join(RESULTS), "--by", by, "--stop", str(END_S), "--mode", mode, "--json"]
        found = json.loads(subprocess.run(words, capture_output=True, text=True, check=True).stdout)
    values = np.array([row["value"] for row in found["of"]])
    return values, np.array([row["derivatives"] for row in found["of"]]) * IN_DEGREES


def timed(function):
    """Result and processor time in ms, the least of five."""
    spent = []
    for _ in range(5):
        began = time.process_time()
        found = function()
        spent.append(1e3 * (time.process_time() - began))
    return found, min(spent)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", required=True)
    command = parser.parse_args().foldwing
    numbers = jnp.array(NUMBERS)
    exact, slopes = closed_form(numbers), np.array(jax.jacrev(closed_form)(numbers))
    tables = {f"Foldwing, {mode}": by_foldwing(command, mode) for mode in ("forward", "adjoint")}
    for name, jacobian in (("diffrax, reverse", jax.jacrev(by_diffrax)), ):
        jacobian = jax.jit(jacobian)
        jacobian(numbers)
        table, spent = timed(lambda: np.array(jacobian(numbers)))
        print(f"{name}: {spent:.1f} ms a Jacobian, compiled")
        tables[name] = by_diffrax(numbers), table
    sizes = np.abs(slopes * NUMBERS).max(axis=1, keepdims=True)
    for name, (values, table) in tables.items():
        off = np.abs(table - slopes) * NUMBERS / sizes
        print(f"{name}: values {np.abs(np.array(values) / np.array(exact) - 1).max():.1e}, derivatives {', '.join(f'{row:.1e}' for row in off.max(axis=1))}")
    print(f"\n| number | {' | '.join(f'd {RESULTS[0]}, {name}' for name in ['closed form', *tables])} |")
    for column, name in enumerate(NAMES):
        print(f"| {name} | {' | '.join(f'{table[0][column]:.10f}' for table in [slopes, *(own[1] for own in tables.values())])} |")


if __name__ == "__main__":
    main()
