"""A rigid blade of the NREL 5 MW turbine whose pitch link opens at 0 s: azimuth and pitch, blade elements, momentum theory with a lag,
polars over the full circle in quasi-steady flow or with dynamic stall. Numpy, classical Runge-Kutta; shares no code with Foldwing.

    python rigid_blade.py [step [folder]]      writes static.csv and stall.csv

Equations: (J psi')' = Q, (I + Jp) theta'' = M + psi'^2/2 dJ/dtheta; J(theta) contains the sections' second moments rotated by pitch minus
twist. Dynamic stall: Hansen, Gaunaa and Madsen, Riso-R-1354 (2004), four states per section, integrated with everything else.
"""
import csv
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
WIND, DENSITY, BLADES, LAG = 11.4, 1.225, 3, 3.0
HUB, LENGTH = 1.5, 61.5
ROTOR, GENERATOR, BRAKE, DELAY, RAMP, SLIP = 1713807.8, 1393358.1, 909090.5, 0.5, 0.6, 0.01
START = np.radians(72.6)  # 12.1 rpm
GEARS = 3000.0
PLACES = np.array([1.3667, 4.1, 6.8333, 10.25, 14.35, 18.45, 22.55, 26.65, 30.75, 34.85, 38.95, 43.05, 47.15, 51.25, 54.6667, 57.4, 60.1333])
CHORDS = np.array([3.542, 3.854, 4.167, 4.557, 4.652, 4.458, 4.249, 4.007, 3.748, 3.502, 3.256, 3.01, 2.764, 2.518, 2.313, 2.086, 1.419])
SECTIONS = ("cylinder1 cylinder1 cylinder2 du40_a17 du35_a17 du35_a17 du30_a17 du25_a17 du25_a17 du21_a17 du21_a17 naca64_a17 naca64_a17 "
            "naca64_a17 naca64_a17 naca64_a17 naca64_a17").split()


def columns(path):
    with path.open(encoding="utf-8") as lines:
        rows = list(csv.reader(line for line in lines if not line.startswith("#")))
    return {name: np.array([float(row[i]) for row in rows[1:]]) for i, name in enumerate(rows[0])}


BLADE = columns(HERE / "blade.csv")  # share, mass_kg_m, edge_kg_m, flap_kg_m, twist_deg


class Polar:
    """Static polar, and its split into attached and separated flow."""

    def __init__(self, name):
        rows = columns(HERE.parent / "turbine" / "polars" / f"{name}.csv")
        self.angle, self.rows = np.radians(rows["alpha_deg"]), [rows[key] for key in ("cl", "cd", "cm")]
        lift, self.slope = self.rows[0], 0.0
        rises = [i for i in range(len(lift) - 1) if lift[i] <= 0.0 < lift[i + 1]]
        if not rises:
            return
        zeros = [self.angle[i] - lift[i] * (self.angle[i + 1] - self.angle[i]) / (lift[i + 1] - lift[i]) for i in rises]
        place = int(np.argmin(np.abs(zeros)))
        self.zero, i = zeros[place], rises[place] + 1
        while lift[i] > 0.0 and self.angle[i] - self.zero < np.radians(45.0):  # the steepest line to a row with lift
            self.slope = max(self.slope, lift[i] / (self.angle[i] - self.zero))
            i += 1
        self.zero_drag = self.at(self.zero)[1]

    def at(self, angle):
        return [np.interp(angle, self.angle, row) for row in self.rows]

    def split(self, angle):
        """Degree of attachment in steady flow, lift of attached and of separated flow."""
        lift, line = self.at(angle)[0], self.slope * (angle - self.zero)
        ratio = lift / line if line else 1.0
        if ratio >= 1.0:
            return 1.0, lift, 0.5 * lift
        f = (2.0 * np.sqrt(max(ratio, 0.25)) - 1.0) ** 2
        return f, line, (lift - line * f) / (1.0 - f) if f < 1.0 - 1e-9 else 0.5 * lift


POLARS = {name: Polar(name) for name in set(SECTIONS)}
ENDS = np.concatenate([[0.0], 0.5 * (PLACES[1:] + PLACES[:-1]), [LENGTH]])
WIDTHS, RADII = np.diff(ENDS), HUB + PLACES
TWIST = np.radians(np.interp(PLACES / LENGTH, BLADE["share"], BLADE["twist_deg"]))

# inertia: 6000 midpoints of a blade with linear properties between its stations
CELLS = (np.arange(6000) + 0.5) / 6000.0
STEP = LENGTH / 6000.0
MASS, EDGE, FLAP, TURN = (np.interp(CELLS, BLADE["share"], BLADE[key]) for key in ("mass_kg_m", "edge_kg_m", "flap_kg_m", "twist_deg"))
TURN = np.radians(TURN)
OUT = float(np.sum(MASS * (HUB + CELLS * LENGTH) ** 2) * STEP)
POLAR_INERTIA = float(np.sum(EDGE + FLAP) * STEP)
# (1/2 of the difference) times cosine and sine of twice the twist
HALF = [float(np.sum(0.5 * (EDGE - FLAP) * function(2.0 * TURN)) * STEP) for function in (np.cos, np.sin)]


def inertia(theta):
    """J of rotor and blade about the shaft, and its derivative with respect to the pitch."""
    swing = HALF[0] * np.cos(2.0 * theta) + HALF[1] * np.sin(2.0 * theta)  # mean of cos(2 (theta - twist))
    slope = 2.0 * (HALF[1] * np.cos(2.0 * theta) - HALF[0] * np.sin(2.0 * theta))
    return ROTOR + OUT + 0.5 * POLAR_INERTIA + swing, slope


def momentum(load):
    """Induced velocity by momentum theory for loads K in m^2/s^2."""
    ratio = load / WIND**2
    return np.where(ratio <= 0.96, 0.5 * WIND * (1.0 - np.sqrt(1.0 - np.minimum(ratio, 0.96))),
                    np.where(ratio <= 2.0, WIND * (0.4 + 0.5 * (ratio - 0.96)),
                             0.5 * np.sqrt(np.maximum(load, 0.0)) + (0.92 - np.sqrt(0.5)) * WIND))


def flow(state):
    psi, theta, speed, rate = state[:4]
    along, across = RADII * speed, WIND - state[4:21]
    met = np.hypot(along, across)
    inflow = np.arctan2(across, along)
    attack = theta - TWIST + inflow
    return met, inflow, (attack + np.pi) % (2.0 * np.pi) - np.pi, rate


def stall_slopes(state, first=None):
    """Rates of the four states per section, and the coefficients."""
    met, _, attack, rate = flow(state)
    x = state[21:].reshape(17, 4)
    rates, rows = np.zeros((17, 4)), np.zeros((17, 3))
    for i, name in enumerate(SECTIONS):
        polar = POLARS[name]
        static = polar.at(attack[i])
        rows[i] = static
        if polar.slope == 0.0:
            continue
        passing = 0.5 * CHORDS[i] / max(met[i], 0.01)
        rear = np.arctan2(met[i] * np.sin(attack[i]) + 0.5 * CHORDS[i] * rate, met[i] * np.cos(attack[i]))
        if first is not None:
            x[i, :2] = 0.3 * rear, 0.7 * rear
        effective = x[i, 0] + x[i, 1]  # 1 - A1 - A2 = 0
        lift = polar.slope * (effective - polar.zero) + np.pi * passing * rate
        if first is not None:
            x[i, 2] = lift
            x[i, 3] = polar.split(lift / polar.slope + polar.zero)[0]
        rates[i] = (0.14 * (0.3 * rear - x[i, 0]) / passing, 0.53 * (0.7 * rear - x[i, 1]) / passing, (lift - x[i, 2]) / (1.7 * passing),
                    (polar.split(x[i, 2] / polar.slope + polar.zero)[0] - x[i, 3]) / (3.0 * passing))
        weight = 0.5 * (1.0 + np.cos(np.pi * np.clip((np.degrees(abs(attack[i])) - 40.0) / 10.0, 0.0, 1.0)))
        _, drag, moment = polar.at(effective)
        share, attached, separated = polar.split(effective)
        circulatory = x[i, 3] * attached + (1.0 - x[i, 3]) * separated
        lost = 0.5 * (np.sqrt(share) - np.sqrt(x[i, 3])) - 0.25 * (share - x[i, 3])
        dynamic = np.array([circulatory + np.pi * passing * rate,
                            drag + (rear - effective + passing * rate) * circulatory + (drag - polar.zero_drag) * lost,
                            moment - 0.5 * np.pi * passing * rate])
        rows[i] += weight * (dynamic - rows[i])
    return rates.ravel(), rows


def air(state, stall):
    """Torque on shaft and pitch, rates of the induced velocities and of the sections' states."""
    met, inflow, attack, rate = flow(state)
    scale = 0.5 * DENSITY * met**2 * CHORDS
    if stall:
        rates, rows = stall_slopes(state)
        lift, drag, moment = rows.T
        # momentum theory uses the load of the static polar, as in AeroDyn
        still_lift, still_drag, _ = np.array([POLARS[name].at(attack[i]) for i, name in enumerate(SECTIONS)]).T
        loading = scale * (still_lift * np.cos(inflow) + still_drag * np.sin(inflow))
    else:
        rates = np.zeros(0)
        turning = rate * CHORDS / np.maximum(met, 1.0)
        rear = (attack + 0.5 * turning + np.pi) % (2.0 * np.pi) - np.pi
        lift, drag, moment = (np.array(column) for column in zip(*(POLARS[name].at(rear[i]) for i, name in enumerate(SECTIONS))))
        moment = moment - np.pi / 8.0 * turning
    thrust = scale * (lift * np.cos(inflow) + drag * np.sin(inflow))
    drive = scale * (lift * np.sin(inflow) - drag * np.cos(inflow))
    loading = loading if stall else thrust
    induced = (momentum(BLADES * loading / (np.pi * DENSITY * RADII)) - state[4:21]) / LAG
    return float(np.sum(drive * RADII * WIDTHS)), float(np.sum(scale * CHORDS * moment * WIDTHS)), induced, rates


def slopes(time, state, stall, gears):
    theta, speed, rate = state[1], state[2], state[3]
    torque, moment, induced, rates = air(state, stall)
    ramp = min(max((time - DELAY) / RAMP, 0.0), 1.0)
    torque += -GENERATOR - BRAKE * ramp * np.tanh(speed / SLIP)
    total, slope = inertia(theta)
    pitching = (moment + 0.5 * speed**2 * slope) / (POLAR_INERTIA + gears)
    return np.concatenate([[speed, rate, (torque - slope * rate * speed) / total, pitching], induced, rates])


def run(stall, gears=GEARS, end=8.0, step=1e-3):
    state = np.zeros(21 + (68 if stall else 0))
    state[2] = START
    for _ in range(4000):  # steady inflow with the pitch held
        if stall:
            stall_slopes(state, first=True)
        state[4:21] += 0.05 * LAG * air(state, stall)[2]
    if stall:
        stall_slopes(state, first=True)
    rows = []
    for i in range(int(round(end / step)) + 1):
        time = i * step
        if i % int(round(0.05 / step)) == 0:
            rows.append([time, *state[:4]])
        k1 = slopes(time, state, stall, gears)
        k2 = slopes(time + 0.5 * step, state + 0.5 * step * k1, stall, gears)
        k3 = slopes(time + 0.5 * step, state + 0.5 * step * k2, stall, gears)
        k4 = slopes(time + step, state + step * k3, stall, gears)
        state = state + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return np.array(rows)


def main():
    step = float(sys.argv[1]) if len(sys.argv) > 1 else 1e-3
    where = HERE if len(sys.argv) < 3 else Path(sys.argv[2])
    for stall, name in ((False, "static.csv"), (True, "stall.csv")):
        rows = run(stall, step=step)
        print(name, rows[-1])
        np.savetxt(where / name, rows, delimiter=",", fmt="%.9g", comments="", header="t_s,psi_rad,theta_rad,psi_rate,theta_rate")


if __name__ == "__main__":
    main()
