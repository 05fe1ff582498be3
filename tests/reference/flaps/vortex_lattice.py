"""Steady wings with a plain flap by a vortex lattice of horseshoes: an independent program, with numpy only.

Writes `vortex_lattice.json` next to this script: lift, rolling moment and hinge moment per radian of the flap, for flat wings in a flow
along the chord. The flap is rotated in two ways: only its normals, or its panels with all their vortices (a slit opens at its ends), each
at 0.1 and 10 degrees; the normals of the panels in front of the hinge rotate by a quarter of the angle. Also plain lattices, whose panels
in front of the hinge do not rotate, with 20, 40 and 80 panels along the chord, and their limit.

Axes: x aft, y along the span, z up. Horseshoes with the bound vortex on the quarter chord of a panel, the legs along x to far
behind, control points at three quarters of the panel. Tips are inset by a quarter of a strip. Angles move the trailing edge down.
"""

import json
import math
import pathlib

import numpy

FAR_CHORDS = 1e6


def segment(point, begin, end):
    """Velocity of a straight vortex of unit strength at points (n, 3), Biot and Savart."""
    one, two = point - begin, point - end
    cross = numpy.cross(one, two)
    square = numpy.sum(cross * cross, axis=-1)
    along = end - begin
    sizes = numpy.linalg.norm(one, axis=-1), numpy.linalg.norm(two, axis=-1)
    unit = one / sizes[0][..., None] - two / sizes[1][..., None]
    share = numpy.sum(along * unit, axis=-1)
    with numpy.errstate(divide="ignore", invalid="ignore"):
        strength = numpy.where(square > 1e-24, share / (4 * math.pi * square), 0.0)
    return cross * strength[..., None]


def strips(span, parts):
    """Edges of strips: consecutive parts (end, count) from the inner tip, the outermost edges inset."""
    edges, begin = [], 0.0
    for index, (end, count) in enumerate(parts):
        inset = [0.25 if index == 0 else 0.0, 0.25 if index == len(parts) - 1 else 0.0]
        width = (end - begin) / (count + sum(inset))
        edges += [begin + (inset[0] + i) * width for i in range(count)]
        if index == len(parts) - 1:
            edges.append(begin + (inset[0] + count) * width)
        begin = end
    return numpy.array(edges)


def solve(case, angle, turn_vortices, front, rows):
    """Lift, rolling moment about the middle and hinge moment, divided by density and speed squared; unit density and speed.

    `front`: fraction of the angle by which the panels in front of the hinge rotate.
    """
    span, hinge = case["span_m"], case["hinge_fraction"]
    edges = strips(span, case["parts"])
    taper = lambda y: case["root_chord_m"] + (case["tip_chord_m"] - case["root_chord_m"]) * y / span
    # unswept quarter-chord line at x = 0
    place = lambda y, fraction: numpy.array([(fraction - 0.25) * taper(y), y, 0.0])
    first, last = case["flap_m"]
    whole = angle
    bound, control, normal, flapped = [], [], [], []
    hinge_line = lambda y0, y1: (place(y0, hinge), place(y1, hinge))

    def turned(point, line, about=None, share=1.0):
        axis = line[1] - line[0]
        axis = axis / numpy.linalg.norm(axis)
        origin = numpy.zeros(3) if about is None else about
        arm = point - origin
        angle = share * whole
        # trailing edge down: from +x towards -z is a rotation about +y
        return (
            origin
            + arm * math.cos(angle)
            + numpy.cross(axis, arm) * math.sin(angle)
            + axis * axis.dot(arm) * (1 - math.cos(angle))
        )

    for row in range(rows):
        for inner, outer in zip(edges[:-1], edges[1:]):
            middle = 0.5 * (inner + outer)
            on_flap = first < middle < last
            has_flap = on_flap and row >= round(hinge * rows)
            quarter, three = (row + 0.25) / rows, (row + 0.75) / rows
            ends = [place(inner, quarter), place(outer, quarter)]
            point = 0.5 * (place(inner, three) + place(outer, three))
            up = numpy.array([0.0, 0.0, 1.0])
            if has_flap:
                line = hinge_line(inner, outer)
                up = turned(up, line)
                if turn_vortices:
                    ends = [turned(end, line, line[0]) for end in ends]
                    point = turned(point, line, line[0])
            if on_flap and row == round(hinge * rows) - 1:
                up = turned(up, hinge_line(inner, outer), share=front)
            bound.append(ends)
            control.append(point)
            normal.append(up)
            flapped.append(hinge_line(inner, outer) if has_flap else None)
    control, normal = numpy.array(control), numpy.array(normal)
    flow = numpy.array([1.0, 0.0, 0.0])
    far = FAR_CHORDS * case["root_chord_m"] * flow
    matrix = numpy.zeros((len(bound), len(bound)))
    for column, (inner, outer) in enumerate(bound):
        velocity = segment(control, inner, outer)
        velocity += segment(control, inner + far, inner) + segment(control, outer, outer + far)
        matrix[:, column] = numpy.sum(velocity * normal, axis=-1)
    circulation = numpy.linalg.solve(matrix, -normal @ flow)
    lift = roll = moment = 0.0
    for strength, (inner, outer), line in zip(circulation, bound, flapped):
        # pressure with the speed of the undisturbed flow: the normal force of thin wings
        force = numpy.cross(flow, (outer - inner) * strength)
        middle = 0.5 * (inner + outer)
        lift += force[2]
        roll += (middle[1] - 0.5 * span) * force[2]
        if line is not None:
            axis = (line[1] - line[0]) / numpy.linalg.norm(line[1] - line[0])
            moment += axis.dot(numpy.cross(middle - 0.5 * (line[0] + line[1]), force))
    return {"lift": lift / angle, "roll": roll / angle, "hinge_moment": moment / angle}


CASES = [
    {
        "name": "whole span",
        "span_m": 6.0,
        "root_chord_m": 1.0,
        "tip_chord_m": 1.0,
        "chord_panels": 8,
        "hinge_fraction": 0.75,
        "flap_m": [0.0, 6.0],
        "parts": [[6.0, 24]],
    },
    {
        "name": "outer aileron",
        "span_m": 4.0,
        "root_chord_m": 1.2,
        "tip_chord_m": 0.6,
        "chord_panels": 5,
        "hinge_fraction": 0.6,
        "flap_m": [2.5, 3.5],
        "parts": [[2.5, 10], [3.5, 5], [4.0, 3]],
    },
]


def main():
    for case in CASES:
        case["results"] = []
        for degrees in (0.1, 10.0):
            for vortices in (False, True):
                found = solve(case, math.radians(degrees), vortices, 0.25, case["chord_panels"])
                case["results"].append({"angle_deg": degrees, "turned": "panels" if vortices else "normals", **found})
        # plain lattices, first order in the panels: extrapolated to zero panel size by their second differences
        fine = [solve(case, 1e-4, False, 0.0, rows) for rows in (20, 40, 80)]
        case["plain"] = [{"chord_panels": rows, **found} for rows, found in zip((20, 40, 80), fine)]
        twice = [{key: 2 * b[key] - a[key] for key in b} for a, b in zip(fine, fine[1:])]
        case["limit"] = {key: (4 * twice[1][key] - twice[0][key]) / 3 for key in twice[0]}
    path = pathlib.Path(__file__).with_name("vortex_lattice.json")
    path.write_text(json.dumps({"made_with": "numpy " + numpy.__version__, "cases": CASES}, indent=1) + "\n")


if __name__ == "__main__":
    main()
