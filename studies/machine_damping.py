"""Damping ratios of the modes of an assembled machine at other fold angles: the table of decision 0082.

Mass and stiffness of the folding wing at one fold angle follow from its linear model, with forces and moments at 24 stations as inputs and
the velocities there as outputs; the damping of its six lowest modes is then kept at other angles. Needs the Python package and SciPy:

    python studies/machine_damping.py
"""

import foldwing as fw
import numpy as np
from scipy.linalg import eigh

ANGLES_DEG, STARTS_DEG = (0.0, 45.0, 90.0, 150.0), (0.0, 150.0)
RATIO, MODES, STATIONS = 0.02, 6, 12
# modes of a free fold have round-off in place of a frequency
STILL_RAD_S = 1.0


def model(angle_deg, stiffness_n_m_rad, ratios=()):
    """The wing of `examples/models/folding_wing.toml` without latch and gravity; a spring of the fold is at rest at the angle."""
    wing = fw.Builder("Wing")
    wing.section("plate", shape="rectangle", width_m=0.05, height_m=0.002, density_kg_m3=1425.0, youngs_modulus_Pa=2.83e9,
                 torsional_rigidity_N_m2=0.18)
    for name in ("inner", "outer"):
        wing.body(name, length_m=0.15, section="plate", elements=2, load_stations=STATIONS, modal_damping_ratios=list(ratios))
    wing.clamped("mount", "inner")
    spring = {"motor": {"stiffness_N_m_rad": stiffness_n_m_rad, "command_deg": angle_deg}} if stiffness_n_m_rad else {}
    wing.revolute("fold", "outer", parent="inner", axis=[0.0, 1.0, 0.0], start_angle_deg=angle_deg, **spring)
    return wing.table("mass", "actuator", body="inner", position_m=0.15, mass_kg=0.0203).build()


def linear(machine):
    """State matrix, and mass and stiffness matrices over the coordinates."""
    places = [f"{body}[{i}]" for body in ("inner", "outer") for i in range(1, STATIONS + 1)]
    loads = [f"load.{place}.{kind}.{axis}" for place in places for kind in ("force", "moment") for axis in "xyz"]
    rates = [f"station.{place}.{kind}.{axis}" for place in places for kind in ("velocity", "angular_velocity") for axis in "xyz"]
    found = machine.linearize("start", inputs=loads, outputs=rates)
    a, b, c = (np.asarray(matrix) for matrix in (found.A, found.B, found.C))
    n = len(a) // 2
    # velocities are G v, accelerations due to loads M⁻¹Gᵀ
    inverse = b[n:] @ np.linalg.pinv(c[:, n:].T)
    mass = np.linalg.inv(0.5 * (inverse + inverse.T))
    stiffness = -mass @ a[n:, :n]
    assert np.abs(stiffness - stiffness.T).max() < 1e-9 * np.abs(stiffness).max()
    return a, mass, 0.5 * (stiffness + stiffness.T)


def damping(mass, stiffness):
    """The damping matrix of the lowest modes."""
    squares, shapes = eigh(stiffness, mass)
    chosen = [i for i, square in enumerate(squares) if square > STILL_RAD_S**2][:MODES]
    return sum(2 * RATIO * squares[i] ** 0.5 * np.outer(mass @ shapes[:, i], mass @ shapes[:, i]) for i in chosen)


def ratios(state_matrix):
    """Frequencies in Hz and damping ratios in per cent."""
    values = np.linalg.eigvals(state_matrix)
    values = sorted(values[values.imag > STILL_RAD_S], key=abs)[:MODES]
    return " ".join(f"{abs(value) / 2 / np.pi:.1f} Hz {-100 * value.real / abs(value):.2f} %," for value in values)


def main():
    for stiffness_n_m_rad in (0.0, 0.5):
        for start_deg in STARTS_DEG:
            of_start = damping(*linear(model(start_deg, stiffness_n_m_rad))[1:])
            for angle_deg in ANGLES_DEG:
                a, mass, _ = linear(model(angle_deg, stiffness_n_m_rad))
                n = len(mass)
                a[n:, n:] -= np.linalg.solve(mass, of_start)
                print(f"spring {stiffness_n_m_rad} N·m/rad, ratios of {start_deg} deg, at {angle_deg} deg: {ratios(a)}")
    for angle_deg in ANGLES_DEG:
        print(f"ratios of bodies, at {angle_deg} deg: {ratios(linear(model(angle_deg, 0.0, [RATIO] * MODES))[0])}")


if __name__ == "__main__":
    main()
