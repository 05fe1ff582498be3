"""Other contents of the archive: icon, licences, reference results, linear model, and the Cross-Check files."""

import hashlib
import json
import subprocess
import zipfile
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from conftest import MODELS, ROOT
from driving import Fmu, instance
from fmpy import simulate_fmu
from fmpy.cross_check import validate_result
from fmpy.cross_check.validate_vendor_repo import validate_repo
from fmpy.util import read_csv, read_ref_opt_file
from matplotlib.image import imread
from scipy.io import loadmat
from scipy.signal import StateSpace, lsim

REFERENCE = "extra/org.fmi-standard.fmi-ls-ref"
LINEAR = "extra/org.foldwing.linear"
LAYER = "{http://fmi-standard.org/fmi-ls-manifest}"

# The tolerance that documentation/fmi-ls-ref.txt states: relative to a variable's range over the run, and also in its unit, for variables
# that are zero apart from round-off.
TOLERANCE = 1e-6
LEAST = 1e-9


def differences(result, reference):
    """Largest difference of every variable, relative to its tolerance."""
    names = reference.dtype.names[1:]
    assert np.allclose(result["time"], reference["time"], rtol=0.0, atol=1e-9)
    return {name: np.abs(result[name] - reference[name]).max() / max(LEAST, TOLERANCE * np.ptp(reference[name]))
            for name in names}


def test_f153_icon_shows_the_wing(fmus):
    """F-153. `model.png` at the archive's root: 800 × 600, opaque, at most 40 kB, with an empty border, the blue of the wing and dark
    outlines; icons differ between models, except for the same wing.
    """
    seen = {}
    for model in MODELS:
        data = (Path(fmus[model].folder) / "model.png").read_bytes()
        assert len(data) <= 40_000, (model, len(data))
        if model in {"folding_wing", "four_bar"}:
            pixels = np.round(255 * imread(BytesIO(data), format="png")).astype(np.uint8)
            assert pixels.shape == (600, 800, 4) and (pixels[..., 3] == 255).all(), model
            colours = pixels[..., :3].astype(int)
            border = np.concatenate([colours[:8].reshape(-1, 3), colours[-8:].reshape(-1, 3)])
            assert (border == 255).all(), model
            blue = (colours[..., 2] - colours[..., 0] > 60).mean()
            dark = (colours.sum(axis=2) < 250).mean()
            assert blue > 0.005 and dark > 0.002, (model, blue, dark)
        seen.setdefault(hashlib.sha256(data).hexdigest(), set()).add(model)
    same_wing = {"folding_wing", "folding_wing_as_printed", "folding_wing_constant", "folding_wing_in_tunnel"}
    assert all(len(group) == 1 or group <= same_wing for group in seen.values()), seen


def experiments(folder):
    """Experiments of the layered standard, as (attributes, stimuli or None, references)."""
    manifest = ElementTree.parse(folder / "fmi-ls-manifest.xml").getroot()
    assert manifest.tag == "fmiReferences"
    assert manifest.attrib == {
        f"{LAYER}fmi-ls-name": "org.fmi-standard.fmi-ls-ref",
        f"{LAYER}fmi-ls-version": "1.0.0-alpha.1",
        f"{LAYER}fmi-ls-description": "Layered Standard providing information on related files included in an FMU.",
    }
    related = {row.get("role"): row.get("source") for row in manifest.findall("Related")}
    assert all((folder / row.get("source")).is_file() for row in manifest.findall("Related"))
    found = []
    for row in ElementTree.parse(folder / related["experiment/smoke-test"]).getroot().findall("Experiment"):
        stimuli = row.find("Stimuli")
        found.append((row.attrib, stimuli if stimuli is None else folder / stimuli.get("source"),
                      folder / row.find("References").get("source")))
    return found


@pytest.mark.parametrize("model", MODELS)
def test_f154_reference_is_what_the_fmu_does(fmus, model):
    """F-154. FMPy repeats both experiments of the layered standard from their files. With the same library and steps, the digits are the
    same without inputs. FMPy's linear interpolation of the inputs may differ in the last bit, so with inputs the tolerance is the
    documented 1e-6 of each variable's range.

    The results are small (100 kB at most) and differ between the experiments, so that ignored inputs would be noticed.
    """
    folder = Path(fmus[model].folder) / REFERENCE
    results = []
    for attributes, stimuli, file in experiments(folder):
        assert file.stat().st_size <= 100_000
        reference = read_csv(file)
        names = list(reference.dtype.names[1:])
        assert 1 <= len(names) <= 10
        result = simulate_fmu(
            fmus[model].path, validate=False, start_time=float(attributes["startTime"]),
            stop_time=float(attributes["stopTime"]), output_interval=float(attributes["stepSize"]),
            input=None if stimuli is None else read_csv(stimuli), output=names)
        found = differences(result, reference)
        print(f"{model}, {attributes['name']}: at most {max(found.values()):.1e} of what is allowed")
        assert max(found.values()) <= (0.0 if stimuli is None else 1.0), (model, attributes["name"], found)
        results.append(reference)
    default, moved = results
    assert any(name not in default.dtype.names or np.ptp(default[name] - moved[name]) > 1e-3 * np.ptp(default[name])
               for name in moved.dtype.names[1:])
    # the sentence that gives the tolerance
    notes = (Path(fmus[model].folder) / "documentation/fmi-ls-ref.txt").read_text(encoding="utf-8")
    assert f"at most {TOLERANCE:.0e}".replace("e-0", "e-") in notes


@pytest.fixture(scope="module")
def repository(foldwing, tmp_path_factory):
    """A Cross-Check repository with the folding wing and the linkage."""
    folder = tmp_path_factory.mktemp("cross-check")
    for model in ["folding_wing", "four_bar"]:
        subprocess.run([foldwing, "package", ROOT / f"examples/models/{model}.toml", "-o", folder / f"{model}.fmu",
                        "--cross-check", folder / "repository"], check=True, capture_output=True)
    return folder / "repository"


def test_f155_cross_check_accepts_the_files(repository):
    """F-155. FMPy's check of Cross-Check repositories finds both FMUs and no problems."""
    fmus, results, problems = validate_repo(str(repository))
    assert (fmus, results, problems) == (2, 0, [])


@pytest.mark.parametrize("model", ["folding_wing", "four_bar"])
def test_f156_cross_check_result_passes(repository, model):
    """F-156. A run with the options and inputs of the Cross-Check files passes FMPy's comparison with the reference, and a run without the
    inputs does not: the reference depends on them.
    """
    (folder,) = [path.parent for path in repository.rglob(f"{model}.fmu")]
    options = read_ref_opt_file(folder / f"{model}_ref.opt")
    reference = read_csv(folder / f"{model}_ref.csv")
    names = list(reference.dtype.names[1:])
    arguments = {"start_time": options["StartTime"], "stop_time": options["StopTime"],
                 "output_interval": options["StepSize"], "output": names, "relative_tolerance": options["RelTol"]}
    result = simulate_fmu(folder / f"{model}.fmu", input=read_csv(folder / f"{model}_in.csv"), **arguments)
    assert validate_result(result, reference, options["StartTime"], options["StopTime"]) is None
    assert max(differences(result, reference).values()) <= 1.0
    without = simulate_fmu(folder / f"{model}.fmu", **arguments)
    assert max(differences(without, reference).values()) > 100.0


def test_f157_linear_model_in_the_archive_answers_like_the_fmu(foldwing, tmp_path):
    """F-157. `foldwing package --linear`: SciPy reads `linear.mat`, JSON holds the same numbers, and its response to a small load step at
    the tip equals that of the FMU of the latched wing, which starts at the same equilibrium.

    The load of 5 mN bends the wing by 0.3 % of its length: nonlinear terms are of the order of the square of that, 1e-5. In strain and
    moment the step excites modes that the integrator damps at its tolerance, 1e-10 here, by about 1e-4 of the range. The limit is 1e-3.
    """
    text = (ROOT / "examples/models/folding_wing.toml").read_text(encoding="utf-8")
    for old, new in [("[simulation]\n", '[solver]\ntolerance = 1e-10\n\n[simulation]\nstart = "equilibrium"\n'),
                     ("start_angle_deg = 170.0", "start_angle_deg = 0.0"),
                     ("stiffness_ratio = 1e4", "stiffness_ratio = 1e4\ninitially_closed = true")]:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    model, fmu = tmp_path / "rest.toml", tmp_path / "rest.fmu"
    model.write_text(text, encoding="utf-8")
    subprocess.run([foldwing, "package", model, "-o", fmu, "--linear", "--no-reference"], check=True)
    with zipfile.ZipFile(fmu) as archive:
        names = archive.namelist()
        archive.extract(f"{LINEAR}/linear.mat", tmp_path)
        stated = json.loads(archive.read(f"{LINEAR}/linear.json"))
    assert not any(name.startswith(REFERENCE) for name in names)
    linear = loadmat(tmp_path / f"{LINEAR}/linear.mat", simplify_cells=True)
    for name in "ABCD":
        assert np.array_equal(linear[name], np.array(stated[name])), name
    for what, values in [("state", "x0"), ("input", "u0"), ("output", "y0")]:
        assert list(linear[f"{what}_names"]) == [signal["name"] for signal in stated[f"{what}s"]]
        assert list(linear[f"{what}_units"]) == [signal["unit"] for signal in stated[f"{what}s"]]
        assert linear[values].tolist() == [signal["value"] for signal in stated[f"{what}s"]]

    load, force_n, step_s = "load.outer[4].force.z", 5e-3, 2.5e-4
    outputs = ["tip.position.z", "gauge.root.strain", "root.moment.y"]
    time = step_s * np.arange(1201)
    column = list(linear["input_names"]).index(load)
    rows = [list(linear["output_names"]).index(name) for name in outputs]
    system = StateSpace(linear["A"], linear["B"][:, [column]], linear["C"][rows], linear["D"][np.ix_(rows, [column])])
    _, predicted, _ = lsim(system, np.full(len(time), force_n), time)

    with instance(Fmu(fmu, tmp_path / "unpacked")) as wing:
        wing.initialize()
        rest = np.array([wing.get(name) for name in outputs])
        assert np.allclose(rest, linear["y0"][rows], rtol=1e-9, atol=1e-12)
        wing.set(load, force_n)
        answer = [np.zeros(len(outputs))]
        for _ in time[1:]:
            wing.step(step_s)
            answer.append([wing.get(name) for name in outputs] - rest)
    # the first row is before the load, to which the linear model responds at once through its feedthrough
    gaps = np.abs(np.array(answer) - predicted)[1:].max(axis=0) / np.ptp(predicted, axis=0)
    for name, gap in zip(outputs, gaps):
        print(f"{name}: largest difference {gap:.1e} of the answer's range")
        assert gap < 1e-3, f"{name}: linear model and FMU differ by {gap:.1e} of the range"
