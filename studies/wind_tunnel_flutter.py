"""Flutter and trim of the wings of examples/wind_tunnel, with `foldwing flutter` and `foldwing trim`, compared with simulations and
`static`.

Eigenvalues describe small motions about the equilibrium at each speed. Simulations start from the same equilibrium with a small
disturbance; the growth rate of the response is fitted at two speeds between which it changes sign. For wind_tunnel_study.py.
"""

import math

import wind_tunnel_cases as w
from wind_tunnel_cases import COMPARED, Series, columns, rows

NEAR = 0.005  # relative distance of the simulated speeds from the flutter speed; small, as the growth is nonlinear in the speed
PAZY_STEP_S = "1e-3"
DAMPINGS_S = (0.0, 5e-5, 2e-4)  # stiffness-proportional damping of the Pazy wing, in addition to the 1e-4 of its file
HUMP_HZ = (16.0, 40.0)  # the torsion mode and the second bending mode of the Pazy wing, which cause the hump
APART = ("Pazy wing, hump",)  # cases with a separate table
KICKS_M_S = (0.3, 8.0)  # gusts that cause small and large motions


def crossing(growth, near_m_s, rising):
    """Speed and frequency at which the growth rate changes sign, from two speeds around a given one, with the CPU seconds of all
    simulations."""
    low_m_s, high_m_s = (1.0 - NEAR) * near_m_s, (1.0 + NEAR) * near_m_s
    (low, low_hz, a), (high, high_hz, b) = growth(low_m_s), growth(high_m_s)
    cost, error = [a.cpu_s, b.cpu_s], a.error or b.error
    if not (low <= 0.0 < high if rising else high <= 0.0 < low):
        return math.nan, math.nan, cost, error
    share = low / (low - high)
    return low_m_s + share * (high_m_s - low_m_s), low_hz + share * (high_hz - low_hz), cost, error


def hump(found):
    """Speeds with frequencies at which the hump mode becomes unstable and stable, from the JSON of `flutter`."""
    in_hump = [one for one in found.get("flutter", ()) if HUMP_HZ[0] < one["frequency_Hz"] < HUMP_HZ[1]]
    begins = [one for one in in_hump if one["begins"]]
    ends = [one for one in in_hump if not one["begins"]]
    pair = (begins[:1] or [None])[0], (ends[-1:] or [None])[0]
    return [(one["speed_m_s"], one["frequency_Hz"]) if one else (math.nan, math.nan) for one in pair]


def least_damped(place):
    """Damping ratio and frequency in Hz of the least damped hump mode at a speed."""
    near = []
    for entry in place["eigenvalues_1_s"]:
        if entry is not None:
            size = math.hypot(*entry)
            if HUMP_HZ[0] < size / math.tau < HUMP_HZ[1]:
                near.append((-entry[0] / size, size / math.tau))
    return min(near, default=(math.nan, math.nan))


def pazy_point(air, speed_m_s, damping_s=1e-4, more=(), outputs=(), replaced=()):
    """The Pazy wing at pitch 5 at a wind speed."""
    changes = ((w.AIR, "wind_m_s", w.vector(0, -speed_m_s, 0)), ("simulation", "step_s", PAZY_STEP_S), *more)
    damping = (("stiffness_damping_s = 1e-4", f"stiffness_damping_s = {damping_s!r}"),) if damping_s != 1e-4 else ()
    return w.Point("pazy_wing", changes, air, tuple(outputs), (*damping, *replaced))


def pazy_growth(study, air, speed_m_s, kick_m_s=KICKS_M_S[0]):
    """Growth rate in 1/s and frequency in Hz of the response to a gust, and the run."""
    kick = (f'\n[gust.kick]\nshape = "one_minus_cosine"\nvelocity_m_s = [0.0, 0.0, {kick_m_s!r}]\n'
            f"length_m = {0.03 * speed_m_s!r}\norigin_m = [0.0, 0.0, 0.0]\nstart_s = 0.02\n\n[simulation]")
    point = pazy_point(air, speed_m_s, outputs=("tip.velocity.z",), replaced=(("\n[simulation]", kick),))
    result = w.march(study.foldwing, point, 2.0)
    time_s, found = result.data.get("time", []), result.data.get("tip.velocity.z", [])
    windows = [[v for t, v in zip(time_s, found) if at < t <= at + 0.4] for at in (0.8, 1.6)]
    if not all(windows):
        return math.nan, math.nan, result
    early, late = (math.sqrt(sum((v - sum(part) / len(part)) ** 2 for v in part) / len(part)) for part in windows)
    crossings = sum(a <= 0.0 < b for a, b in zip(windows[1], windows[1][1:]))
    return math.log(late / early) / 0.8, crossings / 0.4, result


def pazy_flutter(study):
    """Flutter of the Pazy wing at pitch 5, a hump mode: onset and end from eigenvalues and from simulations; damping over the speed."""
    edges = {"onset": 43.0, "end": 51.0}  # measured with rising speed, pazy_wing_bench.csv
    case = "Pazy wing, flutter at pitch 5"
    for air in COMPARED:
        result = w.flutter(study.foldwing, pazy_point(air, 44.0), (36.0, 56.0, 2.0) if air == "lattice" else (30.0, 60.0, 2.0))
        found = hump(result.data)
        keep_hump(study, air, 1e-4, result)
        for rising, (edge, theirs), (speed_m_s, frequency_hz) in zip((True, False), edges.items(), found):
            study.series.append(Series(case, f"{edge}, m/s", "experiment", air, "eigenvalues", [0.0], [theirs], [speed_m_s], [result.cpu_s], [result.error]))
            if math.isnan(speed_m_s):
                print(f"Pazy flutter, {air}: no {edge}, {result.cpu_s:.1f} s {result.error[:160]}", flush=True)
                continue
            marched = crossing(lambda speed, air=air: pazy_growth(study, air, speed), speed_m_s, rising)
            study.series.append(Series(case, f"{edge}, m/s", "experiment", air, "simulations", [0.0], [theirs], [marched[0]], marched[2], [marched[3]]))
            print(f"Pazy flutter, {air}: {edge} {speed_m_s:.3f} m/s, {frequency_hz:.2f} Hz, {result.cpu_s:.1f} s; by simulations "
                  f"{marched[0]:.3f} m/s, {sum(marched[2]):.1f} s {marched[3][:120]}", flush=True)
    # over the structural damping, which is assumed
    for damping_s in DAMPINGS_S:
        result = w.flutter(study.foldwing, pazy_point("line", 44.0, damping_s), (30.0, 60.0, 2.0))
        keep_hump(study, "line", damping_s, result)


def keep_hump(study, air, damping_s, result):
    """Adds series of the damping ratio of the hump mode over the speed, and of its ends."""
    places = result.data.get("modes", ())
    speeds = [place["speed_m_s"] for place in places]
    ratios, edges_m_s = [least_damped(place)[0] for place in places], [speed for speed, _ in hump(result.data)]
    nothing = [math.nan] * len(speeds)
    study.series.append(Series("Pazy wing, hump", "damping ratio", "none", air, repr(damping_s), speeds, nothing, ratios, [result.cpu_s], [result.error]))
    study.series.append(Series("Pazy wing, hump", "onset and end, m/s", "none", air, repr(damping_s), [0.0, 1.0], [43.0, 51.0], edges_m_s))
    print(f"Pazy hump, {air}, {damping_s} s: {edges_m_s}, least damping {min(ratios, default=math.nan):+.4f}, {result.error[:120]}", flush=True)


def baseline_point(air, speed_m_s, more=(), outputs=()):
    """The baseline wing at pitch 0 without gravity and with less damping, as in the source."""
    weightless = ("gravity_m_s2 = [0.0, 0.0, -9.80665]", "gravity_m_s2 = [0.0, 0.0, 0.0]")
    undamped = ("stiffness_damping_s = 1e-4", "stiffness_damping_s = 2e-5")
    return w.Point("baseline_wing", (*w.tunnel(0.0, speed_m_s, 15), *more), air, tuple(outputs), (weightless, undamped))


def baseline_growth(foldwing, air, speed_m_s):
    """Growth rate in 1/s and frequency in Hz of the fold angle after a small start rate, and the run."""
    result = w.march(foldwing, baseline_point(air, speed_m_s, (("joint.fold", "start_rate_deg_s", "10.0"),), ("fold.angle",)), 4.0)
    found = [(t, v) for t, v in zip(result.data.get("time", ()), result.data.get("fold.angle", ())) if t > 1.5]
    peaks = [b for a, b, c in zip(found, found[1:], found[2:]) if a[1] < b[1] >= c[1] and b[1] > 0]
    if len(peaks) < 3:
        return math.nan, math.nan, result
    span_s = peaks[-1][0] - peaks[0][0]
    return math.log(peaks[-1][1] / peaks[0][1]) / span_s, (len(peaks) - 1) / span_s, result


def baseline_both(foldwing, air):
    """Flutter of the baseline wing from eigenvalues and from simulations: speed, frequency, CPU seconds and error of each."""
    result = w.flutter(foldwing, baseline_point(air, 24.0), (16.0, 28.0, 2.0))
    begins = [one for one in result.data.get("flutter", ()) if one["begins"]]
    if not begins:
        return (math.nan, math.nan, [result.cpu_s], result.error), (math.nan, math.nan, [], "")
    speed_m_s, frequency_hz = begins[0]["speed_m_s"], begins[0]["frequency_Hz"]
    marched = crossing(lambda speed: baseline_growth(foldwing, air, speed), speed_m_s, True)
    return (speed_m_s, frequency_hz, [result.cpu_s], result.error), marched


def flutter(study):
    """Onset of flutter of the baseline wing at pitch 0 without gravity, from eigenvalues and from simulations."""
    for air in COMPARED:
        for way, (speed, frequency, cost, error) in zip(("eigenvalues", "simulations"), baseline_both(study.foldwing, air)):
            for quantity, theirs, ours in (("speed, m/s", 24.37, speed), ("frequency, Hz", 2.93, frequency)):
                study.series.append(Series("baseline wing, flutter", quantity, "Healy's computation", air, way, [0.0], [theirs], [ours], cost, [error]))
            print(f"flutter, {air}, {way}: {speed:.3f} m/s, {frequency:.4f} Hz, {sum(cost):.1f} s {error[:120]}", flush=True)


def lco_pitch(foldwing, air, start_deg, speed_m_s, fold_deg):
    """Root pitch of the LCO wing in degrees at which its tip is in equilibrium at a given angle, searched from another pitch, and the
    result."""
    point = w.Point("lco_wing", w.tunnel(start_deg, speed_m_s), air)
    result = w.trim(foldwing, point, "attitude.pitch", f"fold.angle={-math.radians(fold_deg)!r}")
    turn = result.data["free"]["attitude.pitch"] if result.data else math.nan
    return start_deg + math.degrees(turn), result


def trim(study):
    """Root pitch of the LCO wing from `trim`: for the fold angle that `static` finds at a pitch, and for the measured one."""
    name = "lco_wing_fold_vs_airspeed.csv"
    for pitch in (5, 10):
        x, y = columns(rows(name, source="experiment", root_pitch_deg=pitch), "airspeed_m_s", "fold_up_deg")
        x, y = x[1::4], y[1::4]
        for air in COMPARED:
            own, measured = ([], [], []), ([], [], [])
            for speed_m_s, fold_deg in zip(x, y):
                rest = study.rest(w.Point("lco_wing", w.tunnel(pitch, speed_m_s), air))
                for target_deg, into in ((w.fold_up_deg(rest), own), (fold_deg, measured)):
                    found_deg, result = lco_pitch(study.foldwing, air, pitch - 2, speed_m_s, target_deg)
                    for part, value in zip(into, (found_deg, result.cpu_s, result.error)):
                        part.append(value)
            for source, into in (("static", own), ("experiment", measured)):
                series = Series(f"LCO wing over speed, pitch {pitch}", "root pitch at the same fold, deg", source, air, "trim", x, [float(pitch)] * len(x), *into)
                study.series.append(series)
                print(f"trim, LCO wing, pitch {pitch}, {air}, fold of {source}: {[round(v, 4) for v in series.ours]}, {sum(into[1]) / len(x):.2f} s "
                      f"per point {max(into[2])[:160]}", flush=True)


def table(series):
    """Markdown: flutter from eigenvalues compared with simulations, and the hump over the structural damping."""
    lines = ["", "## Flutter by eigenvalues and by simulations", "",
             "CPU seconds: of the sweep over all speeds with the search for the flutter speeds, and of the two simulations around one of these.", "",
             "| case | quantity | air | `flutter` | simulations | difference | CPU s, `flutter` | CPU s, simulations |", "|---|---|---|---|---|---|---|---|"]
    for one in series:
        if one["variant"] != "eigenvalues":
            continue
        same = ("case", "quantity", "air")
        other = next((s for s in series if s["variant"] == "simulations" and all(s[key] == one[key] for key in same)), None)
        ours, theirs = one["ours"][0], other["ours"][0] if other else math.nan
        shown = [f"{value:.3f}" if not math.isnan(value) else "none" for value in (ours, theirs)]
        difference = f"{100.0 * (ours / theirs - 1.0):+.2f} %" if not math.isnan(ours / theirs) else "–"
        spent = f"{sum(other['cpu_s']):.1f}" if other and other["cpu_s"] else "–"
        lines.append(f"| {one['case']} | {one['quantity']} | {one['air']} | {shown[0]} | {shown[1]} | {difference} | {sum(one['cpu_s']):.1f} | {spent} |")
    lines += ["", "## The hump of the Pazy wing", "",
              "Damping of the structure on its stiffness in s, damping of the least damped mode from 16 to 40 Hz in %, measured onset 43 and end 51 m/s.", "",
              "| air | damping, s | onset, m/s | end, m/s | least damping, % | at, m/s |", "|---|---|---|---|---|---|"]
    for one in series:
        if one["case"] in APART and one["quantity"] == "damping ratio":
            ends = next(s["ours"] for s in series if s["case"] in APART and s["quantity"] != "damping ratio" and (s["air"], s["variant"]) == (one["air"], one["variant"]))
            known = [(value, at) for value, at in zip(one["ours"], one["x"]) if not math.isnan(value)]
            least, at = min(known, default=(math.nan, math.nan))
            shown = [f"{value:.2f}" if not math.isnan(value) else "none" for value in ends]
            lines.append(f"| {one['air']} | {float(one['variant']):g} | {shown[0]} | {shown[1]} | {100.0 * least:+.2f} | {at:g} |")
    return lines
