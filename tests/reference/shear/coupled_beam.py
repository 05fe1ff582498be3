#!/usr/bin/env python3
"""Large motion of a composite box beam with a full 6x6 stiffness, by a program that shares nothing with Foldwing.

  python tests/reference/shear/coupled_beam.py [--exudyn]

Simo-Reissner beam as one spectral element: positions and total rotation vectors at Gauss-Lobatto points, Lagrange polynomials of degree p,
Gauss quadrature, momenta of the sections from their 6x6 mass matrix, in a frame with prescribed rotation. The equations are integrated by
DOP853. Writes `coupled_spin.csv` and `coupled_free.csv` to its folder; prints the differences between degrees and the errors of the conserved
energy and momenta. Needs numpy and scipy. With `--exudyn` it compares the results without couplings, with the mass centre on the axis, with
those of Exudyn, whose beams have diagonal stiffnesses only.
"""
import pathlib
import sys
from math import factorial

import numpy as np
from scipy.integrate import solve_ivp

HERE = pathlib.Path(__file__).parent
LENGTH_M = 1.0
# strains (ex, gy, gz, kx, ky, kz): stretch coupled with twist, shear with bending, as in a box with the same ply angle in all walls
STIFFNESS = np.diag([8000.0, 2400.0, 1600.0, 2.0, 2.5, 5.0])
for _i, _j, _value in ((0, 3, -50.0), (1, 4, 30.0), (2, 5, -36.0), (3, 4, 0.5), (0, 5, 40.0)):
    STIFFNESS[_i, _j] = STIFFNESS[_j, _i] = _value
MASS_KG_M = 1.0
CENTRE_M = (0.012, -0.008)
# about the centre of mass: yy, yz, zz
SECOND_KG_M = (1.2e-3, 1.0e-4, 5.0e-4)
SPIN_RAD_S, RISE_S = 8.0, 1.0
TUMBLE_RAD_S = np.array([1.5, 3.0, 4.0])


def cross_matrix(v):
    """Matrices of the cross product, (n, 3) to (n, 3, 3)."""
    matrix = np.zeros((len(v), 3, 3))
    matrix[:, 2, 1], matrix[:, 0, 2], matrix[:, 1, 0] = v[:, 0], v[:, 1], v[:, 2]
    return matrix - matrix.swapaxes(1, 2)


def cross(a, b):
    """Cross products along the last axis, without numpy's overhead."""
    a, b = np.broadcast_arrays(a, b)
    out = np.empty(a.shape)
    out[..., 0] = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
    out[..., 1] = a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]
    out[..., 2] = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return out


def series(x):
    """sin a / a, (1 - cos a)/x, (a - sin a)/a**3 for x = a**2, and the derivatives of the last two with respect to x."""
    small = x < 1e-2
    if small.all():
        return near(x)
    if not small.any():
        return far(x)
    return tuple(np.where(small, low, high) for low, high in zip(near(np.where(small, x, 0)), far(np.where(small, 1, x))))


def far(x):
    """The same for x away from zero."""
    a = np.sqrt(x)
    s, b = np.sin(a) / a, (1 - np.cos(a)) / x
    c = (1 - s) / x
    return s, b, c, (s - 2 * b) / (2 * x), (b - 3 * c) / (2 * x)


def near(x):
    """The same by power series, six terms: 1e-16 for x < 0.01."""
    sums = []
    for first in (1, 2, 3):
        sums.append(sum((-x) ** k / factorial(2 * k + first) for k in range(6)))
    for first in (2, 3):
        sums.append(sum(-(k + 1) * (-x) ** k / factorial(2 * k + 2 + first) for k in range(6)))
    return tuple(sums)


class Beam:
    """One spectral element of degree p; `clamped` fixes the first point to the rotating frame."""

    def __init__(self, degree, centre_m, clamped, spin):
        from numpy.polynomial import legendre
        basis = legendre.Legendre.basis(degree)
        nodes = np.sort(np.concatenate([[-1.0], basis.deriv().roots().real, [1.0]]))
        points, weights = legendre.leggauss(degree + 8)
        inverse = np.linalg.inv(legendre.legvander(nodes, degree))
        self.value = legendre.legvander(points, degree) @ inverse
        slopes = np.column_stack([legendre.Legendre.basis(k).deriv()(points) for k in range(degree + 1)])
        self.slope = slopes @ inverse * 2 / LENGTH_M
        self.weight = weights * LENGTH_M / 2
        self.nodes_m = (nodes + 1) * LENGTH_M / 2
        self.products = np.einsum("q,qi,qj->ijq", self.weight, self.value, self.value).reshape(-1, len(points))
        self.count, self.clamped, self.spin = degree + 1, clamped, spin
        y, z = centre_m
        c = np.array([0.0, y, z])
        yy, yz, zz = SECOND_KG_M
        centred = np.array([[yy + zz, 0, 0], [0, zz, -yz], [0, -yz, yy]])
        first = MASS_KG_M * cross_matrix(c[None])[0]
        about = centred + MASS_KG_M * (c @ c * np.eye(3) - np.outer(c, c))
        self.inertia = np.block([[MASS_KG_M * np.eye(3), -first], [first, about]])

    def sections(self, t, q, v):
        """Kinematics at the quadrature points."""
        q, v = q.reshape(self.count, 6), v.reshape(self.count, 6)
        at, slope, rate = self.value @ q, self.slope @ q, self.value @ v
        turn = at[:, 3:]
        s, b, c, db, dc = series((turn ** 2).sum(1))
        k = cross_matrix(turn)
        kk = k @ k
        eye = np.eye(3)
        col = lambda x: x[:, None, None]
        rotation = eye + col(s) * k + col(b) * kk
        tangent = eye - col(b) * k + col(c) * kk

        def tangent_along(u):
            up = cross_matrix(u)
            twice = 2 * (turn * u).sum(1)
            return -col(b) * up - col(db * twice) * k + col(c) * (up @ k + k @ up) + col(dc * twice) * kk

        return at, slope, rate, rotation, tangent, tangent_along

    def forces(self, t, q, v):
        """Mass matrix, and forces at zero accelerations; energy, momentum and angular momentum about the origin."""
        at, slope, rate, rotation, tangent, tangent_along = self.sections(t, q, v)
        _, omega, omega_dot = self.spin(t)
        back = np.swapaxes(rotation, 1, 2)
        act = lambda matrix, vector: np.einsum("qij,qj->qi", matrix, vector)
        drawn = act(back, slope[:, :3])
        curvature = act(tangent, slope[:, 3:])
        strain = np.concatenate([drawn - [1, 0, 0], curvature], 1)
        stress = strain @ STIFFNESS
        n, m = stress[:, :3], stress[:, 3:]
        place = at[:, :3]
        velocity = rate[:, :3] + cross(omega, place)
        acceleration = (2 * cross(omega, rate[:, :3]) + cross(omega_dot, place)
                        + cross(omega, cross(omega, place)))
        relative = act(tangent, rate[:, 3:])
        frame = np.einsum("qij,j->qi", back, omega)
        w = relative + frame
        w_dot = (act(tangent_along(rate[:, 3:]), rate[:, 3:]) + np.einsum("qij,j->qi", back, omega_dot)
                 - cross(relative, frame))
        body = act(back, velocity)
        body_dot = act(back, acceleration) - cross(w, body)
        momenta = np.concatenate([body, w], 1) @ self.inertia.T
        changes = np.concatenate([body_dot, w_dot], 1) @ self.inertia.T
        p, l = momenta[:, :3], momenta[:, 3:]
        force = changes[:, :3] + cross(w, p)
        moment = changes[:, 3:] + cross(w, l) + cross(body, p)
        tangent_t = np.swapaxes(tangent, 1, 2)
        f0 = np.concatenate([
            act(rotation, force),
            act(tangent_t, moment + cross(n, drawn) + cross(m, curvature))
            + act(np.swapaxes(tangent_along(slope[:, 3:]), 1, 2), m)], 1)
        f1 = np.concatenate([act(rotation, n), act(tangent_t, m)], 1)
        residual = self.value.T @ (self.weight[:, None] * f0) + self.slope.T @ (self.weight[:, None] * f1)
        both = np.zeros((len(at), 6, 6))
        both[:, :3, :3], both[:, 3:, 3:] = back, tangent
        block = np.swapaxes(both, 1, 2) @ self.inertia @ both
        n = self.count
        mass = (self.products @ block.reshape(-1, 36)).reshape(n, n, 6, 6).swapaxes(1, 2).reshape(6 * n, 6 * n)
        energy = 0.5 * self.weight @ ((strain * stress).sum(1) + (np.concatenate([body, w], 1) * momenta).sum(1))
        linear = self.weight @ act(rotation, p)
        angular = self.weight @ (act(rotation, l) + cross(place, act(rotation, p)))
        return mass, residual.ravel(), energy, linear, angular

    def derivative(self, t, state):
        half = len(state) // 2
        free = slice(6 * self.clamped, None)
        q, v = self.start(), np.zeros(6 * self.count)
        q[free], v[free] = state[:half], state[half:]
        mass, residual, *_ = self.forces(t, q, v)
        return np.concatenate([v[free], np.linalg.solve(mass[free, free], -residual[free])])

    def start(self):
        q = np.zeros((self.count, 6))
        q[:, 0] = self.nodes_m
        return q.ravel()

    def solve(self, times_s, rates, tolerance=1e-9):
        free = slice(6 * self.clamped, None)
        state = np.concatenate([self.start()[free], rates.ravel()[free]])
        done = solve_ivp(self.derivative, (0, times_s[-1]), state, method="DOP853", t_eval=times_s, rtol=tolerance,
                         atol=tolerance, max_step=2e-3)
        assert done.success, done.message
        return done.y.T

    def tip(self, times_s, states):
        """Position of the tip and unit vectors e_x, e_y of its section, in the inertial frame."""
        half = states.shape[1] // 2
        last = states[:, half - 6:half]
        s, b, *_ = series((last[:, 3:] ** 2).sum(1))
        k = cross_matrix(last[:, 3:])
        rotation = np.eye(3) + s[:, None, None] * k + b[:, None, None] * (k @ k)
        angle = np.array([self.spin(t)[0] for t in times_s])
        frame = np.zeros((len(angle), 3, 3))
        frame[:, 0, 0] = frame[:, 1, 1] = np.cos(angle)
        frame[:, 1, 0], frame[:, 0, 1], frame[:, 2, 2] = np.sin(angle), -np.sin(angle), 1
        rotation = frame @ rotation
        return np.concatenate([np.einsum("tij,tj->ti", frame, last[:, :3]), rotation[:, :, 0], rotation[:, :, 1]], 1)


# angular velocity SPIN (1 - (1 - t/RISE)**4)**2: up, a plateau, and down again after twice the rise
RATE = np.polynomial.Polynomial([1.0, 0.0, 0.0]) - np.polynomial.Polynomial([1.0, -1.0 / RISE_S]) ** 4
RATE = SPIN_RAD_S * RATE ** 2
ANGLE = RATE.integ()


def spinning(t):
    """Angle, angular velocity and acceleration of the clamped case."""
    return ANGLE(t), np.array([0, 0, RATE(t)]), np.array([0, 0, RATE.deriv()(t)])


def at_rest(_):
    """A frame at rest."""
    return 0.0, np.zeros(3), np.zeros(3)


def spin_case(degree, centre_m, times_s, tolerance=1e-9):
    beam = Beam(degree, centre_m, True, spinning)
    return beam.tip(times_s, beam.solve(times_s, np.zeros((beam.count, 6)), tolerance))


def free_case(degree, centre_m, times_s, tolerance=1e-9):
    beam = Beam(degree, centre_m, False, at_rest)
    rates = np.zeros((beam.count, 6))
    rates[:, :3] = cross(TUMBLE_RAD_S, beam.start().reshape(-1, 6)[:, :3])
    rates[:, 3:] = TUMBLE_RAD_S
    states = beam.solve(times_s, rates, tolerance)
    half = states.shape[1] // 2
    kept = [beam.forces(t, x[:half], x[half:])[2:] for t, x in zip(times_s, states)]
    for name, which in (("energy", 0), ("momentum", 1), ("angular momentum", 2)):
        values = np.array([k[which] for k in kept])
        print(f"  p {degree}: {name} kept to {np.abs(values - values[0]).max() / np.abs(values[0]).max():.1e}")
    return beam.tip(times_s, states)


def write(name, times_s, tips):
    header = "time_s," + ",".join(f"{what}_{axis}{unit}" for what, unit in
                                  (("tip", "_m"), ("ex", ""), ("ey", "")) for axis in "xyz")
    rows = [",".join([f"{t:.3f}"] + [f"{x:.9f}" for x in tip]) for t, tip in zip(times_s, tips)]
    (HERE / name).write_text("\n".join([header] + rows) + "\n")


def exudyn_spin(elements, step_s, times_s):
    """Tip positions of the spinning beam with uncoupled strains and the mass centre on the axis, by Exudyn's elements of two nodes."""
    import exudyn
    from exudyn import itemInterface, utilities
    yy, yz, zz = SECOND_KG_M
    section = exudyn.BeamSection()
    section.massPerLength = MASS_KG_M
    section.inertia = np.array([[yy + zz, 0, 0], [0, zz, -yz], [0, -yz, yy]])
    section.stiffnessMatrix = np.diag(np.diag(STIFFNESS))
    mbs = exudyn.SystemContainer().AddSystem()
    along = np.linspace(0, LENGTH_M, elements + 1)
    nodes = [mbs.AddNode(itemInterface.NodeRigidBodyEP(referenceCoordinates=[x, 0, 0, 1, 0, 0, 0])) for x in along]
    for pair in zip(nodes, nodes[1:]):
        mbs.AddObject(itemInterface.ObjectBeamGeometricallyExact(nodeNumbers=list(pair), length=LENGTH_M / elements, sectionData=section))
    ground = mbs.AddMarker(itemInterface.MarkerBodyRigid(bodyNumber=mbs.AddObject(itemInterface.ObjectGround())))
    inner = mbs.AddMarker(itemInterface.MarkerNodeRigid(nodeNumber=nodes[0]))
    mbs.AddObject(itemInterface.GenericJoint(
        markerNumbers=[ground, inner], constrainedAxes=[1] * 6,
        offsetUserFunction=lambda mbs, t, item, offsets: [0] * 5 + [float(ANGLE(t))],
        offsetUserFunction_t=lambda mbs, t, item, offsets: [0] * 5 + [float(RATE(t))]))
    tip = mbs.AddSensor(itemInterface.SensorNode(nodeNumber=nodes[-1], storeInternal=True,
                                                 outputVariableType=exudyn.OutputVariableType.Position))
    mbs.Assemble()
    settings = exudyn.SimulationSettings()
    settings.timeIntegration.endTime = times_s[-1]
    settings.timeIntegration.numberOfSteps = round(times_s[-1] / step_s)
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.9
    settings.timeIntegration.newton.relativeTolerance = 1e-8
    settings.timeIntegration.newton.absoluteTolerance = 1e-10
    settings.solutionSettings.sensorsWritePeriod = times_s[1] - times_s[0]
    settings.solutionSettings.writeSolutionToFile = False
    settings.linearSolverType = exudyn.LinearSolverType.EigenSparse
    mbs.SolveDynamic(settings)
    return mbs.GetSensorStoredData(tip)[:, 1:]


def compare_with_exudyn():
    """Prints the distances of Exudyn's tips, extrapolated in element size and step, from those of the spectral element."""
    times_s = np.linspace(0, 2 * RISE_S, 81)
    coarse, fine = (exudyn_spin(n, 5e-4, times_s) for n in (16, 32))
    step = (coarse - exudyn_spin(16, 1e-3, times_s)) / 3
    STIFFNESS[:] = np.diag(np.diag(STIFFNESS))
    own = spin_case(8, (0.0, 0.0), times_s)[:, :3]
    far = lambda tips: np.linalg.norm(tips - own, axis=1).max()
    print(f"Exudyn, m: 16 elements {far(coarse):.1e}, 32 {far(fine):.1e}, extrapolated {far(fine + (fine - coarse) / 3 + step):.1e}")


def main():
    """Runs both cases with increasing degree and writes the finest; some minutes."""
    print("polynomial of the angle, rad:", ANGLE.coef.tolist())
    for name, case, times_s in (("spin", spin_case, np.linspace(0, 2 * RISE_S, 81)), ("free", free_case, np.linspace(0, 1, 41))):
        last = None
        for degree in (8, 12, 16):
            tips = case(degree, CENTRE_M, times_s)
            if last is not None:
                apart = np.abs(tips - last)
                print(f"{name}, p {degree}: {apart[:, :3].max():.1e} m, {apart[:, 3:].max():.1e} from the degree before", flush=True)
            last = tips
        write(f"coupled_{name}.csv", times_s, last)


if __name__ == "__main__":
    compare_with_exudyn() if "--exudyn" in sys.argv else main()
