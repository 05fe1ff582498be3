#!/usr/bin/env python3
"""The wings of examples/wind_tunnel compared with measurements and other programs.

Usage: wind_tunnel_study.py --foldwing COMMAND --output target/wind_tunnel --table docs/tables/wind_tunnel.md [--only TEXT]

Writes points.json (every point with its cost) and the table of deviations. Points are run one at a time. plot_wind_tunnel.py draws the
pictures from points.json. Nothing is fitted: the measurements are compared with our results and are not used in any run.
"""

import argparse
import datetime
import json
import math
import sys
from dataclasses import asdict, replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import wind_tunnel_cases as w  # noqa: E402
import wind_tunnel_flutter as f  # noqa: E402
from wind_tunnel_cases import COMPARED, Series, Study, columns, rows  # noqa: E402

TWIST = "{{ table = [[0.0, 0.0], [0.06, 0.0], [0.085, {0!r}], [0.135, {0!r}]] }}"
NOSE_DOWN = (("surface.tip", "incidence_deg", "-2.0"),)
LCO_CHORD_M = 0.15
POLAR = "published polar"  # variant of the lattice
SPEEDS = ((20, 0), (20, 10), (10, 5), (30, 5))  # flare and root pitch of the test series over speed
SIDESLIPS = ((0, 3, 16.5), (9, 6, 10.5), (-6, 3, 16.5))  # twist of the tip, root pitch, sideslip below the jump


def sideslip_over_speed(study):
    """Fold angle of the sideslip wing over the speed for four flares and pitches, and also with the tip twisted 2 deg nose down."""
    for flare, pitch in SPEEDS:
        where = {"flare_deg": flare, "root_pitch_deg": pitch}
        x, y = columns(rows("sideslip_wing_fold_vs_airspeed.csv", source="experiment", **where), "airspeed_m_s", "fold_up_deg")
        other = list(zip(*columns(rows("sideslip_wing_fold_vs_airspeed.csv", source="healy_vlm", **where), "airspeed_m_s", "fold_up_deg")))
        lattice = [w.at(other, at) for at in x]
        case = f"sideslip wing over speed, flare {flare}, pitch {pitch}"
        for variant, more in (("", ()), ("tip 2 deg nose down", NOSE_DOWN)):
            point = lambda at, air, more=more: w.Point("sideslip_wing", w.tunnel(pitch, at, flare) + more, air)  # noqa: E731
            study.add(case, "fold up, deg", "experiment", x, y, point, w.fold_up_deg, variant=variant)
            study.add(case, "fold up, deg", "Healy's lattice", x, lattice, point, w.fold_up_deg, variant=variant)
        study.series.append(Series(case, "fold up, deg", "experiment", "Healy's lattice", "", x, y, lattice))


def sideslip_over_pitch(study):
    """Fold angle of the sideslip wing over the root pitch, flare 10 at 22 m/s."""
    x, y = columns(rows("sideslip_wing_fold_vs_root_pitch.csv"), "root_pitch_deg", "fold_up_deg")
    for variant, more in (("", ()), ("tip 2 deg nose down", NOSE_DOWN)):
        point = lambda at, air, more=more: w.Point("sideslip_wing", w.tunnel(at, 22.0, 10) + more, air)  # noqa: E731
        study.add("sideslip wing over root pitch, flare 10", "fold up, deg", "experiment", x, y, point, w.fold_up_deg, variant=variant)


def sideslip_over_sideslip(study):
    """Fold angle of the sideslip wing over sideslip for three twists of the tip, below the jump in the measurement."""
    for twist, pitch, jump in SIDESLIPS:
        where = {"tip_twist_deg": twist, "root_pitch_deg": pitch}
        name = "sideslip_wing_fold_vs_sideslip.csv"
        x, y = columns(rows(name, source="experiment", **where), "sideslip_deg", "fold_up_deg")
        x, y = (list(values) for values in zip(*[(a, b) for a, b in zip(x, y) if a < jump]))
        other = list(zip(*columns(rows(name, source="healy_vlm", **where), "sideslip_deg", "fold_up_deg")))
        case = f"sideslip wing over sideslip, twist {twist}"
        more = (("surface.tip", "incidence_deg", TWIST.format(float(twist))),) if twist else ()
        point = lambda at, air, more=more: w.Point("sideslip_wing", w.tunnel(pitch, 22.0, 20, at or 1e-9) + more, air)  # noqa: E731
        study.add(case, "fold up, deg", "experiment", x, y, point, w.fold_up_deg)
        stalling = lambda at, air, point=point: replace(point(at, air), air="polar")  # noqa: E731
        study.add(case, "fold up, deg", "experiment", x, y, stalling, w.fold_up_deg, airs=("lattice",), variant=POLAR)
        study.series.append(Series(case, "fold up, deg", "experiment", "Healy's lattice", "", x, y, [w.at(other, at) for at in x]))


def lco(study):
    """Fold angle of the LCO wing over the speed at two root pitches."""
    for pitch in (5, 10):
        name = "lco_wing_fold_vs_airspeed.csv"
        x, y = columns(rows(name, source="experiment", root_pitch_deg=pitch), "airspeed_m_s", "fold_up_deg")
        other = list(zip(*columns(rows(name, source="healy_numerical", root_pitch_deg=pitch), "airspeed_m_s", "fold_up_deg")))
        case = f"LCO wing over speed, pitch {pitch}"
        point = lambda at, air: w.Point("lco_wing", w.tunnel(pitch, at), air)  # noqa: E731
        study.add(case, "fold up, deg", "experiment", x, y, point, w.fold_up_deg)
        stalling = lambda at, air, point=point: replace(point(at, air), air="polar")  # noqa: E731
        study.add(case, "fold up, deg", "experiment", x, y, stalling, w.fold_up_deg, airs=("lattice",), variant=POLAR)
        for n_crit in (5, 9):
            def computed(at, air, n_crit=n_crit, point=point):
                polar = w.with_polar(w.computed_polar(n_crit, at * LCO_CHORD_M / w.VISCOSITY_M2_S))
                return replace(point(at, air), changes=point(at, air).changes + polar)
            study.add(case, "fold up, deg", "experiment", x, y, computed, w.fold_up_deg, airs=("lattice",), variant=f"computed polar, n = {n_crit}")
        study.series.append(Series(case, "fold up, deg", "experiment", "Healy's computation", "", x, y, [w.at(other, at) for at in x]))


def baseline_steady(study):
    """The baseline wing in equilibrium over the speed: fold, deflection and twist at the hinge, moment and force at the root."""
    def hinge(result):
        return w.tip_pose(result, "inner")

    def root(kind, entry, sign):
        return lambda result: sign * result.data["root"][kind][entry] if result.data else math.nan

    values = {
        "fold_up_deg": w.fold_up_deg,
        "hinge_deflection_percent_of_span": lambda r: 100.0 * hinge(r)[0][2],
        "hinge_twist_deg": lambda r: math.degrees(hinge(r)[1][0]) - 5.0,
        "root_bending_moment_N_m": root("moment_N_m", 1, -1.0),
        "root_vertical_force_N": root("force_N", 2, 1.0),
    }
    point = lambda at, air: w.Point("baseline_wing", w.tunnel(5, at, 15), air)  # noqa: E731
    speeds, middle = [9.0, 10.0, 12.0, 15.0, 18.0, 22.0, 26.0, 30.0], 18.0
    for quantity, value in values.items():
        x, y = columns(rows("baseline_wing_steady.csv", quantity=quantity), "airspeed_m_s", "value")
        curve = list(zip(x, y))
        if quantity != "fold_up_deg":
            # masses of the source are not consistent with its curves without wind: changes from the middle speed are compared
            study.add("baseline wing over speed, pitch 5", f"{quantity}, less that at 18 m/s", "Healy's computation", speeds,
                      [w.at(curve, at) - w.at(curve, middle) for at in speeds], point, value, less=middle)
            continue
        for case, chosen in (("from 12 m/s", speeds[2:]), ("9 and 10 m/s", speeds[:2])):
            study.add(f"baseline wing over speed, pitch 5, {case}", quantity, "Healy's computation", chosen,
                      [w.at(curve, at) for at in chosen], point, value)


def pazy(study):
    """The Pazy wing: bench tests, and deflection and twist of the tip in the wind."""
    half = (0.44096 - 0.5) * 0.0989  # mid-chord, where deflections are measured
    length_m = 0.549843728

    def deflection(result):
        position_m, rotation = w.tip_pose(result, "e15")
        arm = w.turned(rotation, (0.0, half, 0.0))
        return 100.0 * (position_m[2] + arm[2]) / length_m

    def twist(result):
        _, rotation = w.tip_pose(result, "e15")
        chord = w.turned(rotation, (0.0, 1.0, 0.0))
        return math.degrees(math.asin(max(-1.0, min(1.0, chord[2]))))

    def bench(arm_m):
        def point(mass_kg, _air):
            extra = f'[mass.tip]\nbody = "e15"\nposition_m = 0.0191249994\nmass_kg = {mass_kg!r}\noffset_m = [0.0, {arm_m!r}, 0.0]\n\n[aerodynamics]'
            changes = (("joint.c1", "mount_rotation_deg", w.vector(0, 0, 0)), (w.AIR, "model", '"none"'), (w.AIR, "mirror_normal", w.WITHOUT))
            level = ("gravity_m_s2 = [-9.80665, 0.0, 0.0]", "gravity_m_s2 = [0.0, 0.0, -9.80665]")
            return w.Point("pazy_wing", changes, "lattice", (), (level, ("[aerodynamics]", extra)))
        return point

    def none(value, point):
        empty = value(study.rest(point(1e-6, "lattice")))
        return lambda result: value(result) - empty

    for test, arm_m, value in (("bending", half, deflection), ("torsion", (0.44096 - 1.0) * 0.0989 - 0.08, twist)):
        point = bench(arm_m)
        offset = none(value, point)
        unit = "deflection of the tip, % of the length" if test == "bending" else "twist of the tip, deg"
        case = f"Pazy wing, {test} test"
        found = {
            source: [row for row in rows("pazy_wing_bench.csv", source=source) if row["test"].startswith(test)]
            for source in ("experiment", "umnast")
        }
        x, y = columns(found["experiment"], "x", "value")
        other = list(zip(*columns(found["umnast"], "x", "value")))
        study.add(case, unit, "experiment", x, y, point, offset, airs=("lattice",))
        study.add(case, unit, "UM/NAST", x, [w.at(other, at) for at in x], point, offset, airs=("lattice",))
        study.series.append(Series(case, unit, "experiment", "UM/NAST", "", x, y, [w.at(other, at) for at in x]))
    for quantity, value in (("tip_deflection_percent_of_span", deflection), ("tip_twist_deg", twist)):
        x, y = columns(rows("pazy_wing_tip_pitch5.csv", source="experiment", quantity=quantity), "airspeed_m_s", "value")
        few = [(a, b) for a, b in zip(x, y) if a >= 10][::5]
        pitch = 5.0 if quantity.startswith("tip_twist") else 0.0
        point = lambda at, air: w.Point("pazy_wing", ((w.AIR, "wind_m_s", w.vector(0, -at, 0)),), air)  # noqa: E731
        study.add("Pazy wing in the wind, pitch 5", quantity, "experiment", [a for a, _ in few], [b for _, b in few], point,
                  lambda result, value=value, pitch=pitch: value(result) - pitch)
        x, y = columns(rows("pazy_wing_tip_pitch5.csv", source="umnast", quantity=quantity), "airspeed_m_s", "value")
        if x:
            study.add("Pazy wing in the wind, pitch 5", quantity, "UM/NAST", x, y, point, lambda result, value=value, pitch=pitch: value(result) - pitch)


def pazy_swept(study):
    """The Pazy wing swept back by 20 deg at pitch 5: deflection of the tip over the speed, minus that at nearly zero wind. The sections are
    those of the straight wing."""
    name = "pazy_swept20_pitch5.csv"
    x, y = (list(values[1:]) for values in columns(rows(name, quantity="tip_deflection_m"), "airspeed_m_s", "value"))  # without zero wind
    swept = w.vector(*map(math.degrees, w.both_turns((math.radians(5.0), 0.0, 0.0), (0.0, 0.0, math.radians(-20.0)))))

    def point(at, air):
        return w.Point("pazy_wing", (("joint.c1", "mount_rotation_deg", swept), (w.AIR, "wind_m_s", w.vector(0, -at, 0))), air)

    half = (0.44096 - 0.5) * 0.0989

    def deflection(result):
        position_m, rotation = w.tip_pose(result, "e15")
        return position_m[2] + w.turned(rotation, (0.0, half, 0.0))[2]

    study.add("Pazy wing swept by 20 deg, pitch 5", "tip deflection, m", "experiment", x, y, point, deflection, less=0.5)


def bands(study):
    """Influence of single choices: each case at its measured points with one choice changed."""
    name = "lco_wing_fold_vs_airspeed.csv"
    cases = []
    for pitch in (5, 10):
        x, y = columns(rows(name, source="experiment", root_pitch_deg=pitch), "airspeed_m_s", "fold_up_deg")
        cases.append((f"LCO wing over speed, pitch {pitch}", "lco_wing", lambda at, p=pitch: w.tunnel(p, at), x[1::2], y[1::2]))
    x, y = columns(rows("sideslip_wing_fold_vs_airspeed.csv", source="experiment", flare_deg=20, root_pitch_deg=10), "airspeed_m_s", "fold_up_deg")
    cases.append(("sideslip wing over speed, flare 20, pitch 10", "sideslip_wing", lambda at: w.tunnel(10, at, 20), x[1::2], y[1::2]))
    for case, model, tunnel, x, y in cases:
        heavy = {"lco_wing": ("mass.point10", 0.52), "sideslip_wing": ("mass.tip1", 61e-3)}[model]
        flap = {"lco_wing": ("section.stub", 12.4866), "sideslip_wing": ("section.spar", 14.096)}[model]
        strips = {"lco_wing": {"inner": 12, "stub": 3, "tip": 6}, "sideslip_wing": {"inner": 12, "tip": 5}}[model]
        choices = {
            "tip 1 deg nose down": (("surface.tip", "incidence_deg", "-1.0"),),
            "tip 1 deg nose up": (("surface.tip", "incidence_deg", "1.0"),),
            "mass of the tip +5 %": ((heavy[0], "mass_kg", repr(1.05 * heavy[1])),),
            "mass of the tip -5 %": ((heavy[0], "mass_kg", repr(0.95 * heavy[1])),),
            "flap stiffness +15 %": ((flap[0], "flap_stiffness_N_m2", repr(1.15 * flap[1])),),
            "flap stiffness -15 %": ((flap[0], "flap_stiffness_N_m2", repr(0.85 * flap[1])),),
            "root 0.5 deg nose up": None,
            "leading-edge suction": ((w.AIR, "leading_edge_suction", "true"),),
            "8 panels along the chord": (("surface.*", "chord_panels", "8"),),
            "free wake, 30 rows": ((w.AIR, "free_wake", "true"), (w.AIR, "wake_rows", "30")),
            "wake of 30 rows": ((w.AIR, "wake_rows", "30"),),
            "wake of 300 rows": ((w.AIR, "wake_rows", "300"),),
            "half the tip inset, twice the strips": tuple((f"surface.{body}", "strips", str(2 * count)) for body, count in strips.items()),
            "mirror at the root left out": ((w.AIR, "mirror_normal", w.WITHOUT),),
        }
        for label, more in choices.items():
            def point(at, air, more=more):
                changes = tunnel(at)
                if more is None:
                    pitch = float(changes[0][2].strip("[]").split(",")[0]) + 0.5
                    return w.Point(model, (("joint.mount", "mount_rotation_deg", w.vector(pitch, 0, 0)), *changes[1:]), air)
                return w.Point(model, changes + more, air)
            study.add(case, "fold up, deg", "experiment", x, y, point, w.fold_up_deg, airs=("lattice",), variant=label)


def edges(study):
    """Influence of the edges at the hinge, perpendicular to the bodies, where a gap opens as the wing folds, or along the hinge; and of
    more strips."""
    cases = []
    name = "lco_wing_fold_vs_airspeed.csv"
    for pitch in (5, 10):
        x, y = columns(rows(name, source="experiment", root_pitch_deg=pitch), "airspeed_m_s", "fold_up_deg")
        for air in ("lattice", "polar"):
            cases.append((f"LCO wing over speed, pitch {pitch}", "lco_wing", 10, "experiment", x, y, lambda at, p=pitch: w.tunnel(p, at), air))
    for twist, pitch, jump in SIDESLIPS:
        where = {"tip_twist_deg": twist, "root_pitch_deg": pitch}
        x, y = columns(rows("sideslip_wing_fold_vs_sideslip.csv", source="experiment", **where), "sideslip_deg", "fold_up_deg")
        x, y = (list(values) for values in zip(*[(a, b) for a, b in zip(x, y) if a < jump]))
        more = (("surface.tip", "incidence_deg", TWIST.format(float(twist))),) if twist else ()
        tunnel = lambda at, p=pitch, more=more: w.tunnel(p, 22.0, 20, at or 1e-9) + more  # noqa: E731
        cases.append((f"sideslip wing over sideslip, twist {twist}", "sideslip_wing", 20, "experiment", x, y, tunnel, "lattice"))
    for flare, pitch in SPEEDS:
        where = {"flare_deg": flare, "root_pitch_deg": pitch}
        name = "sideslip_wing_fold_vs_airspeed.csv"
        x, _ = columns(rows(name, source="experiment", **where), "airspeed_m_s", "fold_up_deg")
        other = list(zip(*columns(rows(name, source="healy_vlm", **where), "airspeed_m_s", "fold_up_deg")))
        tunnel = lambda at, p=pitch, f=flare: w.tunnel(p, at, f) + NOSE_DOWN  # noqa: E731
        case = f"sideslip wing over speed, flare {flare}, pitch {pitch}, tip 2 deg nose down"
        cases.append((case, "sideslip_wing", flare, "Healy's lattice", x, [w.at(other, at) for at in x], tunnel, "lattice"))
    x, y = columns(rows("baseline_wing_steady.csv", quantity="fold_up_deg"), "airspeed_m_s", "value")
    speeds = [12.0, 15.0, 18.0, 22.0, 26.0, 30.0]
    theirs = [w.at(list(zip(x, y)), at) for at in speeds]
    case = "baseline wing over speed, pitch 5, from 12 m/s"
    cases.append((case, "baseline_wing", 15, "Healy's computation", speeds, theirs, lambda at: w.tunnel(5, at, 15), "lattice"))
    for case, model, flare, source, x, y, tunnel, air in cases:
        for times in (1, 2, 4):
            for lie, more in (("across the bodies", ()), ("along the hinge", w.along_the_hinge(model, flare))):
                if times == 1 and not more:
                    continue  # this is the case itself
                changes = w.finer(model, times) + more
                point = lambda at, _, changes=changes, tunnel=tunnel, model=model, air=air: w.Point(model, tunnel(at) + changes, air)  # noqa: E731
                strips = "" if times == 1 else f", {times} times the strips"
                variant = f"{'published polar, ' if air == 'polar' else ''}edges {lie}{strips}"
                study.add(case, "fold up, deg", source, x, y, point, w.fold_up_deg, airs=("lattice",), variant=variant)


def pendulum(study):
    """The slanted double pendulum: position of its end over 2 s."""
    result = w.march(study.foldwing, w.Point("slanted_double_pendulum", (), "none", tuple(f"tip.position.{k}" for k in "xyz")), 2.0)
    for component in "xyz":
        x, y = columns(rows("slanted_double_pendulum_45.csv", component=component), "time_s", "tip_position_m")
        curve = list(zip(result.data["time"], result.data[f"tip.position.{component}"]))
        ours = [1e3 * w.at(curve, at) for at in x]
        study.series.append(Series("slanted double pendulum", f"{component}, mm", "Cheng", "lattice", "", x, [1e3 * v for v in y], ours,
                                   [result.cpu_s], [result.error]))
        print(f"pendulum {component}: rms {study.series[-1].rms():.1f} mm", flush=True)


def gust(study):
    """Change of root moment and fold of the baseline wing in a gust of a third of a second, with free and locked hinge."""
    bump = ('\n[gust.bump]\nshape = "one_minus_cosine"\nvelocity_m_s = [0.0, 0.0, 0.5]\nlength_m = 6.0\n'
            "origin_m = [0.0, 0.0, 0.0]\nstart_s = 0.1\n\n[simulation]")
    for hinge in ("free", "locked"):
        along = w.along_the_hinge("baseline_wing")
        for air, variant, more in (("lattice", "", ()), ("line", "", ()), ("strips", "", ()), ("lattice", "edges along the hinge", along)):
            changes = w.tunnel(7.5, 18.0, 15) + more
            if hinge == "locked":
                changes += (("joint.fold", "release", "false"),)
            else:
                coast = -w.fold_up_deg(study.rest(w.Point("baseline_wing", changes, air)))
                changes += (("joint.fold", "start_angle_deg", repr(coast)),)
            point = w.Point("baseline_wing", changes, air, ("fold.angle", "root.moment.y"), (("\n[simulation]", bump),))
            result = w.march(study.foldwing, point, 1.0)
            time_s = [at - 0.1 for at in result.data.get("time", ())]
            curves = {
                "root_bending_moment_change_N_m": [-value for value in result.data.get("root.moment.y", ())],
                "fold_up_change_deg": [-math.degrees(value) for value in result.data.get("fold.angle", ())],
            }
            for source in ("healy_numerical", "healy_vlm"):
                for quantity, values in curves.items():
                    found = rows("baseline_wing_gust_3Hz.csv", source=source, hinge=hinge, quantity=quantity)
                    if found:
                        x, y = (list(values) for values in zip(*[(a, b) for a, b in zip(*columns(found, "time_s", "value")) if a <= 0.9]))
                        curve = list(zip(time_s, values))
                        ours = [w.at(curve, at) - w.at(curve, 0.0) for at in x]
                        one = Series(f"baseline wing, gust, hinge {hinge}", quantity, source, air, variant, x, y, ours, [result.cpu_s], [result.error])
                        study.series.append(one)
                        print(f"gust, hinge {hinge}, {quantity}, {air} {variant}: rms {one.rms():.3f} against {source}, {result.cpu_s:.1f} s {result.error[:120]}", flush=True)


CASES = (sideslip_over_speed, sideslip_over_pitch, sideslip_over_sideslip, lco, baseline_steady, pazy, pazy_swept, f.pazy_flutter, pendulum, f.flutter, f.trim, gust, bands, edges)


def table(series):
    """Markdown: one row per case and quantity."""
    lines = ["| case | quantity | against | variant | lattice | strips, lifting line | strips | the other program |", "|---|---|---|---|---|---|---|---|"]
    groups = {}
    for one in series:
        if one["case"] in f.APART:
            continue
        groups.setdefault((one["case"], one["quantity"], one["source"], one["variant"]), []).append(one)
    for (case, quantity, source, variant), found in groups.items():
        def show(air, found=found):
            chosen = [one for one in found if one["air"] == air or (air == "other" and one["air"] not in COMPARED)]
            if not chosen:
                return "–"
            one = chosen[0]
            missing = sum(math.isnan(value) for value in one["ours"])
            cost = f", {sum(one['cpu_s']) / len(one['cpu_s']):.2f} s" if one["cpu_s"] else ""
            if math.isnan(one["rms"]) and not any(one["errors"]):
                return f"none found{cost}"
            note = f", {missing} of {len(one['ours'])} outside the curve" if missing and air == "other" else f", {missing} of {len(one['ours'])} failed" if missing else ""
            return f"{one['rms']:.2f}{cost}{note}"
        lines.append(f"| {case} | {quantity} | {source} | {variant or '–'} | " + " | ".join(show(air) for air in ("lattice", "line", "strips", "other")) + " |")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--foldwing", type=Path, required=True)
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--table", type=Path)
    parser.add_argument("--only", default="")
    arguments = parser.parse_args()
    study = Study(arguments.foldwing.resolve())
    series = []
    for case in CASES:
        if arguments.only in case.__name__:
            case(study)
            series = store(study, arguments)  # all cases take hours
    if arguments.table:
        head = [
            "# Wind tunnel: deviations and cost",
            "",
            f"Written by `make wind-tunnel` on {datetime.date.today().isoformat()}. Root mean square of ours less theirs in the unit of the quantity, then CPU",
            "seconds per point. `docs/validation/wind_tunnel.md` says what it means.",
            "",
        ]
        arguments.table.write_text("\n".join(head + table(series) + f.table(series)) + "\n")


def store(study, arguments):
    """Writes the points, and returns them; those of cases that are not computed stay as they are."""
    arguments.output.mkdir(parents=True, exist_ok=True)
    path = arguments.output / "points.json"
    new = [asdict(one) | {"rms": one.rms()} for one in study.series]
    old = json.loads(path.read_text()) if path.exists() else []
    replaced = {one["case"] + one["quantity"] + one["variant"] for one in new}
    series = [one for one in old if one["case"] + one["quantity"] + one["variant"] not in replaced] + new
    path.write_text(json.dumps(series, indent=1))
    return series


if __name__ == "__main__":
    main()
