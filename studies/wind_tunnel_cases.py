"""Single points of the wings of examples/wind_tunnel: model text with a few changed keys, one call of the command.

Every point uses the default settings of solver and coupling. Equilibria come from `foldwing static` with aerodynamics, always starting
from a fold angle of 0; flutter and gusts come from runs. Nothing here uses a measurement.
"""

import csv
import io
import json
import math
import re
import resource
import subprocess
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
MODELS = ROOT / "examples/wind_tunnel"
VISCOSITY_M2_S = 1.46e-5  # of air at 15 deg C
DATA = ROOT / "tests/reference/folding_wingtips"
AIR = "aerodynamics"
WITHOUT = None  # as a value: the key is removed
# changes of the file for each aerodynamic model
AIRS = {
    "none": (),
    "lattice": (),
    "strips": ((AIR, "model", '"strip"'), (AIR, "mirror_normal", WITHOUT)),
    "line": ((AIR, "model", '"strip"'), (AIR, "tip_loss", '"lifting_line"')),
}
COMPARED = ("lattice", "line", "strips")  # aerodynamic models in the tables


def with_polar(side):
    """Changes that give all surfaces the polar of a symmetric profile, of which one side is given."""
    rest = [[-angle, -lift, drag, -moment] for angle, lift, drag, moment in reversed(side) if angle > 0.0]
    return ((AIR, "leading_edge_suction", "true"), (r"surface\.\w+", "polar", str(rest + side)))


def published_polar():
    """The measured polar of NACA 0015 at a Reynolds number of 160 000, without moment coefficients."""
    with open(DATA / "naca0015_re160000.csv") as file:
        return [[float(row[key]) for key in ("angle_deg", "lift", "drag")] + [0.0] for row in csv.DictReader(file)]


def computed_polar(n_crit, reynolds):
    """The computed polar of NACA 0015 for an amplification exponent, interpolated linearly over the Reynolds number."""
    found = {}
    for row in rows("naca0015_computed.csv", n_crit=n_crit):
        found.setdefault(float(row["reynolds"]), []).append([float(row[key]) for key in ("angle_deg", "lift", "drag", "moment")])
    sizes = sorted(found)
    reynolds = min(max(reynolds, sizes[0]), sizes[-1])
    below = max(i for i, size in enumerate(sizes[:-1]) if size <= reynolds)
    share = (reynolds - sizes[below]) / (sizes[below + 1] - sizes[below])
    both = zip(found[sizes[below]], found[sizes[below + 1]])
    return [[round(a + share * (b - a), 6) for a, b in zip(*pair)] for pair in both]


AIRS["polar"] = with_polar(published_polar())


@dataclass
class Point:
    """A model at one operating point."""

    model: str
    changes: tuple = ()
    air: str = "lattice"
    outputs: tuple = ()
    replaced: tuple = field(default=())


@dataclass
class Result:
    """Result of a call: the JSON of `static` or the columns of a run, CPU seconds, or its error."""

    data: dict
    cpu_s: float
    error: str = ""


def change(text, table, key, value):
    """Model text with one key of a table set or removed."""
    begin = text.index(f"[{table}]\n") + len(f"[{table}]\n")
    end = text.find("\n[", begin)
    end = len(text) if end < 0 else end + 1
    body = re.sub(rf"(?m)^{key} = .*\n?", "", text[begin:end])
    line = "" if value is WITHOUT else f"{key} = {value}\n"
    return text[:begin] + line + body + text[end:]


def text_of(point):
    """The model file of a point."""
    text = (MODELS / f"{point.model}.toml").read_text()
    changes = AIRS[point.air] + tuple(point.changes)
    for table, key, value in changes:
        tables = re.findall(rf"(?m)^\[({table})\]$", text)
        if not tables:
            raise ValueError(f"{point.model}: no table {table}")
        for name in tables:
            text = change(text, name, key, value)
    for old, new in point.replaced:
        if old not in text:
            raise ValueError(f"{point.model}: {old!r} is not in it")
        text = text.replace(old, new)
    return text


def call(foldwing, point, arguments):
    """Runs the command on a point; returns its output and CPU seconds."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{point.model}.toml"
        path.write_text(text_of(point))
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run([str(foldwing), *arguments(path)], capture_output=True, text=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    error = "" if done.returncode == 0 else (done.stderr.strip().splitlines() or ["?"])[-1]
    return done.stdout, cpu_s, error


def rest(foldwing, point):
    """Static equilibrium of the point with aerodynamics."""
    out, cpu_s, error = call(foldwing, point, lambda path: ["static", path, "--json"])
    return Result({} if error else json.loads(out), cpu_s, error)


def march(foldwing, point, stop_s):
    """A run from the equilibrium; columns by name."""
    chosen = [part for name in point.outputs for part in ("--variables", name)]
    out, cpu_s, error = call(
        foldwing, point, lambda path: ["simulate", path, "--csv", "-", "--stop", str(stop_s), *chosen]
    )
    rows = list(csv.DictReader(io.StringIO(out)))
    columns = {name: [float(row[name]) for row in rows] for name in (rows[0] if rows else {})}
    return Result(columns, cpu_s, error)


def flutter(foldwing, point, speeds_m_s):
    """Modes over the speed (from, to, step) with the speeds at which they become unstable or stable: the JSON of `flutter`."""
    first, last, step = speeds_m_s
    span = f"{first!r}:{last!r}:{round((last - first) / step) + 1}"
    out, cpu_s, error = call(foldwing, point, lambda path: ["flutter", path, "--wind-m-s", span, "--json"])
    return Result({} if error else json.loads(out)["results"][0], cpu_s, error)


def trim(foldwing, point, free, balance):
    """The value of `free` at which an output has the target in `balance`: the JSON of `trim`."""
    out, cpu_s, error = call(foldwing, point, lambda path: ["trim", path, "--solve-for", free, "--target", balance, "--json"])
    return Result({} if error else json.loads(out), cpu_s, error)


def vector(*entries):
    """Text of a TOML array."""
    return "[" + ", ".join(repr(float(entry)) for entry in entries) + "]"


def tunnel(pitch_deg, speed_m_s, flare_deg=None, sideslip_deg=0.0):
    """Changes of a folding wing: root pitch, flare, wind; the fold starts at 0."""
    sideslip_rad = math.radians(sideslip_deg)
    wind = vector(-speed_m_s * math.sin(sideslip_rad), -speed_m_s * math.cos(sideslip_rad), 0.0)
    changes = [("joint.mount", "mount_rotation_deg", vector(pitch_deg, 0, 0)), (AIR, "wind_m_s", wind)]
    changes.append(("joint.fold", "start_angle_deg", "0.0"))
    if flare_deg is not None:
        flare_rad = math.radians(flare_deg)
        changes.append(("joint.fold", "axis", vector(math.sin(flare_rad), math.cos(flare_rad), 0.0)))
    if sideslip_deg:
        changes.append((AIR, "mirror_normal", WITHOUT))
    return tuple(changes)


# bodies on both sides of the hinge, their lengths in m and strips
BESIDE_THE_HINGE = {
    "lco_wing": ({"stub": 0.125, "tip": 0.345}, {"inner": 12, "stub": 3, "tip": 6}, 10),
    "sideslip_wing": ({"inner": 0.365, "tip": 0.135}, {"inner": 12, "tip": 5}, 20),
    "baseline_wing": ({"inner": 0.805895, "tip": 0.194105}, {"inner": 14, "tip": 5}, 15),
}


def finer(model, times):
    """Changes that multiply the number of strips of every surface."""
    return tuple((f"surface.{body}", "strips", str(times * count)) for body, count in BESIDE_THE_HINGE[model][1].items())


def along_the_hinge(model, flare_deg=None):
    """Changes that align the edges of both surfaces at the hinge with the hinge axis; the lines of the lattice are again perpendicular to
    the bodies at a distance of the length of the shorter one."""
    lengths_m, _, usual_deg = BESIDE_THE_HINGE[model]
    flare_deg, over_m = float(usual_deg if flare_deg is None else flare_deg), min(lengths_m.values())
    changes = []
    for body, length_m in lengths_m.items():
        if body == "tip":
            table = [[0.0, flare_deg], [over_m, 0.0]] + ([[length_m, 0.0]] if length_m > over_m else [])
        else:
            table = ([[0.0, 0.0]] if length_m > over_m else []) + [[length_m - over_m, 0.0], [length_m, flare_deg]]
        changes.append((f"surface.{body}", "flare_deg", f"{{ table = {table!r} }}"))
    return tuple(changes)


def fold_up_deg(result, joint="fold"):
    """Fold angle in degrees, positive with the tip up; NaN if the point failed."""
    for entry in result.data.get("joints", ()):
        if entry["name"] == joint:
            return -math.degrees(entry["angle_rad"])
    return math.nan


def tip_pose(result, body):
    """Position in m and rotation vector in rad of the outer end of a body in equilibrium."""
    for entry in result.data.get("bodies", ()):
        if entry["name"] == body:
            last = entry["sections"][-1]
            return last["position_m"], last["rotation_rad"]
    return [math.nan] * 3, [math.nan] * 3


def turned(rotation_rad, arm):
    """An arm rotated by a rotation vector."""
    angle = math.sqrt(sum(value * value for value in rotation_rad))
    if angle < 1e-12:
        return list(arm)
    n = [value / angle for value in rotation_rad]
    dot = sum(a * b for a, b in zip(n, arm))
    cross = [n[1] * arm[2] - n[2] * arm[1], n[2] * arm[0] - n[0] * arm[2], n[0] * arm[1] - n[1] * arm[0]]
    cosine, sine = math.cos(angle), math.sin(angle)
    return [cosine * a + sine * c + (1 - cosine) * dot * b for a, b, c in zip(arm, n, cross)]


def both_turns(second, first):
    """The rotation vector in rad of two successive rotations about fixed axes."""
    def quaternion(vector):
        angle = math.sqrt(sum(v * v for v in vector))
        share = math.sin(angle / 2) / angle if angle > 0.0 else 0.5
        return math.cos(angle / 2), [share * v for v in vector]

    (a, u), (b, v) = quaternion(second), quaternion(first)
    real = a * b - sum(x * y for x, y in zip(u, v))
    cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    imaginary = [a * y + b * x + c for x, y, c in zip(u, v, cross)]
    sine = math.sqrt(sum(x * x for x in imaginary))
    return [2.0 * math.atan2(sine, real) / sine * x if sine > 0.0 else 0.0 for x in imaginary]


def at(curve, x):
    """Linear interpolation between points (x, y); NaN outside."""
    for (a, u), (b, v) in zip(curve, curve[1:]):
        if a <= x <= b:
            return u + (v - u) * (x - a) / (b - a) if b > a else u
    return math.nan


def rms(differences):
    """Root mean square without NaN."""
    known = [value * value for value in differences if not math.isnan(value)]
    return math.sqrt(sum(known) / len(known)) if known else math.nan


@dataclass
class Series:
    """One of our curves and a reference curve: `x` and `theirs` are the reference's points, `ours` our values there."""

    case: str
    quantity: str
    source: str  # source of the reference points
    air: str
    variant: str
    x: list
    theirs: list
    ours: list = field(default_factory=list)
    cpu_s: list = field(default_factory=list)
    errors: list = field(default_factory=list)

    def rms(self):
        return rms([a - b for a, b in zip(self.ours, self.theirs)])


def rows(name, **where):
    """Rows of a reference table with the given entries."""
    with open(DATA / name) as file:
        return [row for row in csv.DictReader(file) if all(row[key] == str(value) for key, value in where.items())]


def columns(found, x, y):
    """Two columns of rows as numbers, in order of increasing x."""
    pairs = sorted((float(row[x]), float(row[y])) for row in found)
    return [pair[0] for pair in pairs], [pair[1] for pair in pairs]


class Study:
    """Computes series and stores them; a point that occurs in several series is run once."""

    def __init__(self, foldwing):
        self.foldwing, self.series, self.known = foldwing, [], {}

    def rest(self, point):
        key = repr(point)
        if key not in self.known:
            self.known[key] = rest(self.foldwing, point)
        return self.known[key]

    def add(self, case, quantity, source, x, theirs, point_at, value, airs=COMPARED, variant="", less=None):
        """Adds a series for each aerodynamic model; our value at `less` is subtracted."""
        for air in airs:
            series = Series(case, quantity, source, air, variant, list(x), list(theirs))
            for at in x:
                result = self.rest(point_at(at, air))
                series.ours.append(value(result) - (0.0 if less is None else value(self.rest(point_at(less, air)))))
                series.cpu_s.append(result.cpu_s)
                series.errors.append(result.error)
            self.series.append(series)
            cost = sum(series.cpu_s) / max(len(series.cpu_s), 1)
            print(f"{case}, {quantity}, {air} {variant}: rms {series.rms():.2f} against {source}, {cost:.2f} s per point", flush=True)
            for error in {error for error in series.errors if error}:
                print("   ", error[:220], flush=True)
