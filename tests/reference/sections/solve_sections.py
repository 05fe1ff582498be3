#!/usr/bin/env python3
"""Cross-sections by finite elements: the reference of the sections by shape.

Isotropic sections by sectionproperties (six-node triangles, Saint-Venant torsion and flexure); laminated strips by the solution below for
anisotropic sections (8-node quadrilaterals, Giavotto et al., Computers & Structures 16 (1983) 403), which shares no code with it and is
compared with it for an isotropic rectangle. Writes sections.json and prints the change of every value from the next coarser mesh.

    python3 -m venv venv && venv/bin/pip install sectionproperties==3.10.2 scipy==1.17.1
    venv/bin/python solve_sections.py
"""

import json
import math
import sys
from pathlib import Path

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spl
from sectionproperties.analysis import Section
from sectionproperties.pre import Geometry, Material
from shapely.geometry import Point, Polygon, box
from shapely.ops import unary_union

E, NU, RHO = 70e9, 0.3, 2700.0
G = E / (2 * (1 + NU))


def material(name="alu", e=E, nu=NU, rho=RHO):
    return Material(name, e, nu, 1.0, rho, "grey")


def solve(parts, sizes):
    """Properties of polygons with materials `(polygon, material)` on a mesh of triangles of the given areas."""
    geometry = None
    for polygon, mat in parts:
        piece = Geometry(polygon, mat)
        geometry = piece if geometry is None else geometry + piece
    geometry.create_mesh(mesh_sizes=sizes)
    section = Section(geometry)
    section.calculate_geometric_properties()
    section.calculate_warping_properties()
    # x of sectionproperties is y of the section frame, its y is z; composite results are weighted with Young's modulus, and all materials
    # here have one Poisson's ratio
    shear_ratio = 0.5 / (1 + section.get_nu_eff())
    about_x, about_y, mixed = section.get_eic()
    return {
        "axial_stiffness_N": section.get_ea(),
        "torsional_rigidity_N_m2": section.get_ej() * shear_ratio,
        "flap_stiffness_N_m2": about_x,
        "edge_stiffness_N_m2": about_y,
        "coupling_flap_edge_N_m2": -mixed,
        "shear_stiffnesses_N": [area * shear_ratio for area in section.get_eas()],
        "tension_centre_m": list(section.get_c()),
        # Trefftz's definition: independent of Poisson's ratio, like that of thin walls
        "shear_centre_m": list(section.get_sc_t()),
        "mass_kg_m": section.get_mass(),
        "warping_stiffness_N_m4": section.get_egamma(),
    }


def ring(d, t, n=256):
    return Point(0, 0).buffer(d / 2, n // 4).difference(Point(0, 0).buffer(d / 2 - t, n // 4))


def isotropic_cases():
    m = material()
    cases = {}

    def add(name, shape, parts, sizes, **keys):
        cases[name] = (shape, parts, sizes, keys)

    for d, t in [(0.025, 0.0015), (0.1, 0.02)]:
        add(f"tube_{d}_{t}", "tube", [(ring(d, t, 720), m)], t * t / 12, diameter_m=d, wall_m=t)
    for b, h in [(0.1, 0.05), (0.05, 0.1), (0.1, 0.01)]:
        add(f"rectangle_{b}_{h}", "rectangle", [(box(-b / 2, -h / 2, b / 2, h / 2), m)], b * h / 1500, width_m=b, height_m=h)
    for b, h in [(0.1, 0.05), (0.1, 0.02)]:
        angle = np.linspace(0, 2 * np.pi, 721)[:-1]
        ellipse = Polygon(np.c_[b / 2 * np.cos(angle), h / 2 * np.sin(angle)])
        add(f"ellipse_{b}_{h}", "ellipse", [(ellipse, m)], b * h / 1500, width_m=b, height_m=h)
    for b, h, t, w in [(0.06, 0.04, 0.0005, 0.0005), (0.06, 0.04, 0.002, 0.002), (0.06, 0.04, 0.001, 0.003), (0.05, 0.05, 0.005, 0.005), (0.05, 0.05, 0.01, 0.01)]:
        hollow = box(-b / 2, -h / 2, b / 2, h / 2).difference(box(w - b / 2, t - h / 2, b / 2 - w, h / 2 - t))
        add(f"box_{b}_{h}_{t}_{w}", "box", [(hollow, m)], min(t, w) ** 2 / 20, width_m=b, height_m=h, wall_m=t, web_wall_m=w)
    for b, h, t, w in [(0.05, 0.08, 0.004, 0.003), (0.05, 0.05, 0.002, 0.002), (0.05, 0.1, 0.01, 0.006)]:
        flanges = [box(-b / 2, h / 2 - t, b / 2, h / 2), box(-b / 2, -h / 2, b / 2, t - h / 2), box(-w / 2, -h / 2, w / 2, h / 2)]
        add(f"I_{b}_{h}_{t}_{w}", "I", [(unary_union(flanges), m)], min(t, w) ** 2 / 20, width_m=b, height_m=h, wall_m=t, web_wall_m=w)
    for b, h, t, w in [(0.04, 0.08, 0.003, 0.003), (0.05, 0.05, 0.002, 0.002), (0.04, 0.08, 0.006, 0.004)]:
        walls = [box(0, h / 2 - t, b, h / 2), box(0, -h / 2, b, t - h / 2), box(0, -h / 2, w, h / 2)]
        add(f"C_{b}_{h}_{t}_{w}", "C", [(unary_union(walls), m)], min(t, w) ** 2 / 20, width_m=b, height_m=h, wall_m=t, web_wall_m=w)
    for b, h, t in [(0.04, 0.06, 0.003), (0.05, 0.05, 0.002), (0.04, 0.06, 0.006)]:
        legs = unary_union([box(0, 0, b, t), box(0, 0, t, h)])
        add(f"angle_{b}_{h}_{t}", "angle", [(legs, m)], t ** 2 / 20, width_m=b, height_m=h, wall_m=t)
    return cases


def naca(digits, n=60):
    """Outline of a four-digit aerofoil with a sharp trailing edge, x aft from the leading edge."""
    m, p, t = int(digits[0]) / 100, int(digits[1]) / 10, int(digits[2:]) / 100
    x = 0.5 * (1 - np.cos(np.pi * np.arange(n + 1) / n))
    yt = 5 * t * (0.2969 * np.sqrt(x) - 0.1260 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
    if m:
        front = x < p
        yc = np.where(front, m / p**2 * (2 * p * x - x**2), m / (1 - p) ** 2 * (1 - 2 * p + 2 * p * x - x**2))
        dy = np.where(front, 2 * m / p**2 * (p - x), 2 * m / (1 - p) ** 2 * (p - x))
    else:
        yc = dy = np.zeros_like(x)
    a = np.arctan(dy)
    upper = np.c_[x - yt * np.sin(a), yc + yt * np.cos(a)]
    lower = np.c_[x + yt * np.sin(a), yc - yt * np.cos(a)]
    return np.vstack([upper[::-1], lower[1:]])


def outline_of(polygon):
    return list(polygon.exterior.coords[:-1])


def line(ring, x):
    """Middle of the heights of a ring at x."""
    heights = [a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0]) for a, b in zip(ring, ring[1:] + ring[:1]) if (a[0] - x) * (b[0] - x) <= 0 and a[0] != b[0]]
    return 0.5 * (min(heights) + max(heights))


def profile_cases():
    cases = {}
    skin_material = material()
    web_material = material("steel", 200e9, 0.3, 7800.0)
    # (aerofoil, chord, skin, spars as (position, wall, is steel))
    data = [
        ("naca0012", 0.3, 0.0008, []),
        ("naca0012", 0.3, 0.0008, [(0.3, 0.0012, False)]),
        ("naca2412", 0.3, 0.0008, [(0.25, 0.0015, True), (0.65, 0.001, False)]),
        ("naca2412", 0.3, 0.0004, [(0.25, 0.00075, True), (0.65, 0.0005, False)]),
        ("naca4415", 0.2, 0.002, [(0.35, 0.003, False)]),
    ]
    for aerofoil, chord, skin, spars in data:
        outline = naca(aerofoil[4:])[:-1] * chord  # the last point is the first
        # y of the section frame points to the leading edge
        outer = Polygon(np.c_[-outline[:, 0], outline[:, 1]])
        inner = outer.buffer(-skin, join_style="mitre", mitre_limit=10)
        # webs share vertices with the inner side of the skin exactly
        ring = [tuple(point) for point in inner.exterior.coords[:-1]]
        sides = [-p * chord + sign * w / 2 for p, w, _ in spars for sign in (-1, 1)]
        for x in sides:
            cut = []
            for a, b in zip(ring, ring[1:] + ring[:1]):
                cut.append(a)
                if (a[0] - x) * (b[0] - x) < 0:
                    cut.append((x, a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0])))
            ring = cut
        parts = [(Polygon(outline_of(outer), [ring]), skin_material)]
        for (position, wall, steel), left, right in zip(spars, sides[::2], sides[1::2]):
            within = sorted(point for point in ring if left <= point[0] <= right)
            upper = [point for point in within if point[1] > line(ring, point[0])]
            lower = [point for point in within if point[1] <= line(ring, point[0])]
            parts.append((Polygon(lower + upper[::-1]), web_material if steel else skin_material))
        name = "_".join([aerofoil, str(skin)] + [f"{p}_{w}_{'steel' if s else 'alu'}" for p, w, s in spars])
        keys = {"aerofoil": aerofoil, "chord_m": chord, "skin_wall_m": skin, "spars": [[p, w, s] for p, w, s in spars]}
        cases["profile_" + name] = ("profile", parts, skin * skin / 8, keys)
    return cases


# ---- Anisotropic sections -------------------------------------------------------------------------------------------------------------


def ply_stiffness(ply, angle):
    """6x6 stiffness in Pa of (xx, yy, zz, yz, xz, xy), fibres at `angle` from x towards y; transverse isotropy (2-3 plane)."""
    e1, e2, g12, nu12, g23 = ply
    nu23 = e2 / (2 * g23) - 1
    s = np.zeros((6, 6))
    s[:3, :3] = [[1 / e1, -nu12 / e1, -nu12 / e1], [-nu12 / e1, 1 / e2, -nu23 / e2], [-nu12 / e1, -nu23 / e2, 1 / e2]]
    s[3, 3], s[4, 4], s[5, 5] = 1 / g23, 1 / g12, 1 / g12
    c = np.linalg.inv(s)
    a = math.radians(angle)
    r = np.array([[math.cos(a), math.sin(a), 0], [-math.sin(a), math.cos(a), 0], [0, 0, 1]])  # ply from section
    pairs = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
    t = np.zeros((6, 6))
    for i, (p, q) in enumerate(pairs):
        for j, (k, l) in enumerate(pairs):
            t[i, j] = r[p, k] * r[q, l] if k == l else r[p, k] * r[q, l] + r[p, l] * r[q, k]
            if i >= 3:
                t[i, j] = (r[p, k] * r[q, l] + r[q, k] * r[p, l]) if k != l else 2 * r[p, k] * r[q, l]
            elif k != l:
                t[i, j] = r[p, k] * r[q, l]
    return t.T @ c @ t


def strip(width, plies, across, per_ply):
    """6x6 stiffness (gy, gz, ex with forces first: Fx, Fy, Fz, Mx, My, Mz) of a strip with plies as (thickness, 6x6 stiffness)."""
    thickness = sum(t for t, _ in plies)
    # graded towards the edges, where stress gradients are large
    u = np.linspace(-1, 1, 2 * across + 1)
    ys = width / 2 * np.sin(np.pi / 2 * u) if across > 1 else width / 2 * u
    ys = np.interp(np.arange(2 * across + 1), np.arange(0, 2 * across + 1, 2), ys[::2])
    zs, stiffness = [-thickness / 2], []
    for t, c in plies:
        for k in range(per_ply):
            z0 = zs[-1]
            zs += [z0 + t / per_ply / 2, z0 + t / per_ply]
            stiffness.append(c)
    zs = np.array(zs)
    ny, nz = across, len(stiffness)
    index = {}
    nodes = []

    def node(i, j):
        if (i, j) not in index:
            index[(i, j)] = len(nodes)
            nodes.append((ys[i], zs[j]))
        return index[(i, j)]

    elements = []
    for e in range(ny):
        for f in range(nz):
            i, j = 2 * e, 2 * f
            elements.append(([node(i, j), node(i + 2, j), node(i + 2, j + 2), node(i, j + 2),
                              node(i + 1, j), node(i + 2, j + 1), node(i + 1, j + 2), node(i, j + 1)], stiffness[f]))
    return section_stiffness(np.array(nodes), elements)


def shape8(r, s):
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    n = np.zeros(8)
    d = np.zeros((2, 8))
    for k, (a, b) in enumerate(corners):
        n[k] = 0.25 * (1 + a * r) * (1 + b * s) * (a * r + b * s - 1)
        d[0, k] = 0.25 * a * (1 + b * s) * (2 * a * r + b * s)
        d[1, k] = 0.25 * b * (1 + a * r) * (a * r + 2 * b * s)
    for k, b in ((4, -1), (6, 1)):
        n[k] = 0.5 * (1 - r * r) * (1 + b * s)
        d[0, k], d[1, k] = -r * (1 + b * s), 0.5 * b * (1 - r * r)
    for k, a in ((5, 1), (7, -1)):
        n[k] = 0.5 * (1 + a * r) * (1 - s * s)
        d[0, k], d[1, k] = 0.5 * a * (1 - s * s), -s * (1 + a * r)
    return n, d


def section_stiffness(nodes, elements):
    """Stiffness of (ex, gy, gz, kx, ky, kz) by Giavotto's equations: warping u(y, z) and its derivative along x, equilibrium of the slice."""
    count = len(nodes)
    rows = {k: [] for k in "EGM"}
    a = np.zeros((6, 6))
    l = np.zeros((3 * count, 6))
    r_matrix = np.zeros((3 * count, 6))
    gauss = [(-math.sqrt(0.6), 5 / 9), (0.0, 8 / 9), (math.sqrt(0.6), 5 / 9)]
    for corner, c in elements:
        xy = nodes[corner]
        dofs = np.array([[3 * n, 3 * n + 1, 3 * n + 2] for n in corner]).ravel()
        ee, gg, mm = np.zeros((24, 24)), np.zeros((24, 24)), np.zeros((24, 24))
        for r, wr in gauss:
            for s, ws in gauss:
                n, d = shape8(r, s)
                jac = d @ xy
                det = np.linalg.det(jac)
                dyz = np.linalg.solve(jac, d)
                w = wr * ws * det
                y, z = n @ xy
                b = np.zeros((6, 24))  # strains (xx, yy, zz, yz, xz, xy) of warping
                nn = np.zeros((6, 24))  # and of its derivative along x
                for k in range(8):
                    b[1, 3 * k + 1] = dyz[0, k]
                    b[2, 3 * k + 2] = dyz[1, k]
                    b[3, 3 * k + 1], b[3, 3 * k + 2] = dyz[1, k], dyz[0, k]
                    b[4, 3 * k] = dyz[1, k]
                    b[5, 3 * k] = dyz[0, k]
                    nn[0, 3 * k] = n[k]
                    nn[4, 3 * k + 2] = n[k]
                    nn[5, 3 * k + 1] = n[k]
                zz = np.zeros((6, 6))  # and of the section's strains (ex, gy, gz, kx, ky, kz)
                zz[0] = [1, 0, 0, 0, z, -y]
                zz[4] = [0, 0, 1, y, 0, 0]
                zz[5] = [0, 1, 0, -z, 0, 0]
                ee += w * b.T @ c @ b
                gg += w * nn.T @ c @ b
                mm += w * nn.T @ c @ nn
                a += w * zz.T @ c @ zz
                r_matrix[dofs] += w * b.T @ c @ zz
                l[dofs] += w * nn.T @ c @ zz
        for key, block in (("E", ee), ("G", gg), ("M", mm)):
            i, j = np.meshgrid(dofs, dofs, indexing="ij")
            rows[key].append((i.ravel(), j.ravel(), block.ravel()))
    e_m, g_m, m_m = (
        sp.csr_matrix((np.concatenate([v[2] for v in rows[k]]), (np.concatenate([v[0] for v in rows[k]]), np.concatenate([v[1] for v in rows[k]]))),
                      shape=(3 * count, 3 * count)) for k in "EGM")
    # rigid displacements of a section are not warping
    d = np.zeros((3 * count, 6))
    for k, (y, z) in enumerate(nodes):
        d[3 * k : 3 * k + 3, :3] = np.eye(3)
        d[3 * k : 3 * k + 3, 3:] = [[0, z, -y], [-z, 0, 0], [y, 0, 0]]
    # warping u and strain p per unit force; first their derivatives along x (forces differentiate to moments), then their values
    tr = np.zeros((6, 6))
    tr[4, 2] = 1.0   # My' = Fz
    tr[5, 1] = -1.0  # Mz' = -Fy
    top = sp.bmat([[e_m, sp.csr_matrix(r_matrix), sp.csr_matrix(d)],
                   [sp.csr_matrix(r_matrix.T), sp.csr_matrix(a), None],
                   [sp.csr_matrix(d.T), None, None]], format="csc")
    lu = spl.splu(top)
    rhs = np.zeros((top.shape[0], 6))
    rhs[3 * count : 3 * count + 6] = tr
    first = lu.solve(rhs)
    ux, px = first[: 3 * count], first[3 * count : 3 * count + 6]
    rhs = np.zeros((top.shape[0], 6))
    # E u + R p = (G' ... ) of the derivatives: (C - C^T) u' + L p'
    rhs[: 3 * count] = (g_m - g_m.T) @ ux + l @ px
    rhs[3 * count : 3 * count + 6] = np.eye(6) - l.T @ ux
    second = lu.solve(rhs)
    u, p = second[: 3 * count], second[3 * count : 3 * count + 6]
    k1 = np.vstack([u, ux, p])
    # complementary energy: 2 W = forcesᵀ F forces
    f = (u.T @ (e_m @ u) + u.T @ (g_m.T @ ux) + ux.T @ (g_m @ u) + ux.T @ (m_m @ ux)
         + u.T @ (r_matrix @ p) + p.T @ (r_matrix.T @ u) + ux.T @ (l @ p) + p.T @ (l.T @ ux) + p.T @ a @ p)
    return np.linalg.inv(0.5 * (f + f.T))


CFRP = (147e9, 10.3e9, 7.0e9, 0.27, 3.7e9)
ALU = (70e9, 70e9, 70e9 / 2.6, 0.3, 70e9 / 2.6)


def laminates():
    """Name, width, ply thickness, angles from the lowest ply, ply."""
    t = 0.000125
    return [
        ("isotropic", 0.02, 0.0005, [0, 0, 0, 0], ALU),
        ("unidirectional", 0.03, t, [0] * 8, CFRP),
        ("cross_ply", 0.03, t, [0, 90, 0, 90, 90, 0, 90, 0], CFRP),
        ("quasi_isotropic", 0.03, t, [0, 45, -45, 90, 90, -45, 45, 0], CFRP),
        ("angle_ply", 0.03, t, [45, -45, -45, 45], CFRP),
        ("bend_twist", 0.03, t, [30, 30, -30, -30, -30, -30, 30, 30], CFRP),
        ("unsymmetric_cross_ply", 0.03, t, [0, 0, 90, 90], CFRP),
    ]


def laminate_results(scale):
    results = {}
    for name, width, t, angles, ply in laminates():
        plies = [(t, ply_stiffness(ply, angle)) for angle in angles]
        k = strip(width, plies, 20 * scale, scale)
        f = np.linalg.inv(k)
        # stiffness of the four strains with free shear, and the shear stiffnesses for shear forces alone
        keep = [0, 3, 4, 5]
        free = np.linalg.inv(f[np.ix_(keep, keep)])
        results[name] = {
            "width_m": width, "ply_thickness_m": t, "layup_deg": angles, "material": "alu" if ply is ALU else "cfrp",
            "stiffness_SI": free.tolist(), "shear_stiffnesses_N": [1 / f[1, 1], 1 / f[2, 2]],
        }
    return results


def change(coarse, fine):
    if isinstance(fine, list):
        return max((change(a, b) for a, b in zip(coarse, fine)), default=0.0)
    return abs(coarse - fine)


def main():
    out = {}
    worst = {}
    for name, (shape, parts, size, keys) in {**isotropic_cases(), **profile_cases()}.items():
        coarse, fine = (solve(parts, size * factor) for factor in (4.0, 1.0))
        fine["shape"], fine["keys"] = shape, keys
        out[name] = fine
        for key in ("torsional_rigidity_N_m2", "shear_stiffnesses_N"):
            a, b = np.array(coarse[key]), np.array(fine[key])
            worst[key] = max(worst.get(key, 0.0), float(np.max(np.abs(a / b - 1))))
        print(name, {k: v for k, v in fine.items() if k != "keys"}, flush=True)
    print("largest change from a mesh of four times the area of triangles:", worst)
    coarse, fine = laminate_results(1), laminate_results(2)
    for name, case in fine.items():
        k = np.array(case["stiffness_SI"])
        d = np.sqrt(np.diag(k))
        print(name, "change", np.max(np.abs((np.array(coarse[name]["stiffness_SI"]) - k) / np.outer(d, d))), "stiffness\n", k, case["shear_stiffnesses_N"])
    target = Path(__file__).with_name("sections.json")

    def rounded(tree):
        if isinstance(tree, dict):
            return {k: rounded(v) for k, v in tree.items()}
        if isinstance(tree, (list, tuple)):
            return [rounded(v) for v in tree]
        if isinstance(tree, (float, np.floating)):
            return float(f"{tree:.8g}")
        return tree

    target.write_text(json.dumps(rounded({"sections": out, "laminates": fine}), indent=1) + "\n")


if __name__ == "__main__":
    sys.exit(main())
