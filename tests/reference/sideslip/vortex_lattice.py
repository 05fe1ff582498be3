"""Steady flat wings in sideslip by a vortex lattice of horseshoes: an independent program, with numpy only.

Writes `vortex_lattice.json` next to this script: force and moment about the middle of the quarter-chord line, divided by density and speed
squared, by the force on every bound segment (Kutta–Joukowski) and by its part normal to the wing with the velocity at the control point
(pressure), for two meshes; and the rolling moment of the same wing for meshes up to 16 by 48.

Axes: x along the span, y forward, z up. The wind is along -y, rotated down by the incidence and towards +x by the sideslip. Bound vortices
on the quarter chord of a panel, control points at three quarters of it. The legs lie along the chord to the trailing edge and carry forces
there; from the edge on they lie along the wind and carry none. Tips are inset by a quarter of a strip.
"""

import json
import math
import pathlib

import numpy

SPAN_M, CHORD_M = 1.2, 0.2
FAR_M = 1e6


def segments(points, begins, ends):
    """Velocity (n, m, 3) at points (n, 3) of m straight vortices of unit strength, Biot and Savart."""
    one, two = points[:, None] - begins[None], points[:, None] - ends[None]
    cross = numpy.cross(one, two)
    square = numpy.sum(cross * cross, axis=-1)
    unit = one / numpy.linalg.norm(one, axis=-1)[..., None] - two / numpy.linalg.norm(two, axis=-1)[..., None]
    share = numpy.sum((ends - begins)[None] * unit, axis=-1)
    with numpy.errstate(divide="ignore", invalid="ignore"):
        strength = numpy.where(square > 1e-24, share / (4 * math.pi * square), 0.0)
    return cross * strength[..., None]


def solve(rows, strips, incidence, sideslip):
    """Loads for unit density and speed: `pressure` and `segments`, each three forces and three moments."""
    width = SPAN_M / (strips + 0.5)
    place = -0.5 * SPAN_M + width * (0.25 + numpy.arange(strips + 1))
    wind = numpy.array(
        [
            math.sin(sideslip),
            -math.cos(sideslip) * math.cos(incidence),
            math.cos(sideslip) * math.sin(incidence),
        ]
    )
    fractions = [(row + 0.25) / rows for row in range(rows)] + [1.0]
    # nodes by row, the trailing edge last, and column
    nodes = numpy.array([[[x, (0.25 - part) * CHORD_M, 0.0] for x in place] for part in fractions])
    edge = nodes[-1]

    def velocities(points):
        """Velocities of unit horseshoes, by point, row and strip."""
        behind = segments(points, edge, edge + FAR_M * wind)
        result = numpy.empty((len(points), rows, strips, 3))
        for row in range(rows):
            legs = behind + segments(points, nodes[row], edge)
            bound = segments(points, nodes[row, :-1], nodes[row, 1:])
            result[:, row] = bound + legs[:, 1:] - legs[:, :-1]
        return result.reshape(len(points), rows * strips, 3)

    y = [(0.25 - (row + 0.75) / rows) * CHORD_M for row in range(rows)]
    control = numpy.array([[0.5 * (a + b), at, 0.0] for at in y for a, b in zip(place, place[1:])])
    normal = numpy.array([0.0, 0.0, 1.0])
    influence = velocities(control)
    strength = numpy.linalg.solve(influence @ normal, numpy.full(len(control), -wind @ normal))
    legs = numpy.zeros((rows, strips + 1))
    carried = numpy.cumsum(strength.reshape(rows, strips), axis=0)
    legs[:, 1:] += carried
    legs[:, :-1] -= carried

    def wrench(force, at):
        return numpy.concatenate([force.sum(axis=0), numpy.cross(at, force).sum(axis=0)])

    leading = (nodes[:-1, 1:] - nodes[:-1, :-1]).reshape(-1, 3) * strength[:, None]
    leading_at = 0.5 * (nodes[:-1, 1:] + nodes[:-1, :-1]).reshape(-1, 3)
    chordwise = (nodes[1:] - nodes[:-1]) * legs[..., None]
    chordwise_at = 0.5 * (nodes[1:] + nodes[:-1])
    # force on every segment
    points = numpy.concatenate([leading_at, chordwise_at.reshape(-1, 3)])
    vortices = numpy.concatenate([leading, chordwise.reshape(-1, 3)])
    seen = wind + numpy.einsum("pqk,q->pk", velocities(points), strength)
    by_segments = wrench(numpy.cross(seen, vortices), points)
    # pressure: half of each chordwise segment belongs to each adjacent panel
    seen = (wind + numpy.einsum("pqk,q->pk", influence, strength)).reshape(rows, strips, 3)
    share = numpy.full(strips + 1, 0.5)
    share[[0, -1]] = 1.0
    forces, places = [numpy.cross(seen.reshape(-1, 3), leading)], [leading_at]
    for side in (slice(None, -1), slice(1, None)):
        forces.append(numpy.cross(seen, chordwise[:, side] * share[side][None, :, None]).reshape(-1, 3))
        places.append(chordwise_at[:, side].reshape(-1, 3))
    force = numpy.concatenate(forces)
    by_pressure = wrench((force @ normal)[:, None] * normal, numpy.concatenate(places))
    return {"pressure": by_pressure.tolist(), "segments": by_segments.tolist()}


def main():
    cases = []
    for incidence, sideslip in ((3.0, 15.0), (8.0, 50.0)):
        for rows, strips in ((4, 12), (8, 24)):
            found = solve(rows, strips, math.radians(incidence), math.radians(sideslip))
            mesh = {"chord_panels": rows, "strips": strips}
            cases.append({"incidence_deg": incidence, "sideslip_deg": sideslip, **mesh, **found})
    meshes = ((4, 12), (8, 24), (16, 48))
    rolls = [solve(*mesh, math.radians(3.0), math.radians(15.0))["pressure"][4] for mesh in meshes]
    result = {
        "made_with": "numpy " + numpy.__version__,
        "span_m": SPAN_M,
        "chord_m": CHORD_M,
        "cases": cases,
        "roll_over_meshes": rolls,
    }
    path = pathlib.Path(__file__).with_name("vortex_lattice.json")
    path.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
