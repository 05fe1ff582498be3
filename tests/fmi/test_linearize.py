"""The linear model written by `foldwing linearize` for NumPy, as read by NumPy."""

import json
import subprocess

import numpy as np
import pytest
from conftest import ROOT


@pytest.mark.parametrize("model", ["folding_wing", "four_bar"])
def test_f08_npz_holds_what_the_json_holds(foldwing, tmp_path, model):
    """F-08. `numpy.load` reads the archive without pickles: matrices, values, names and units are those of the JSON file.

    Equality is exact: JSON contains the shortest digits that give the same bits. Inputs and outputs differ in number, so that transposed
    matrices would be noticed.
    """
    written = {}
    for extension in ("json", "npz"):
        written[extension] = tmp_path / f"linear.{extension}"
        command = [foldwing, "linearize", ROOT / f"examples/models/{model}.toml", "--state", "start"]
        subprocess.run([*command, "-o", written[extension]], check=True, capture_output=True)
    stated = json.loads(written["json"].read_text(encoding="utf-8"))
    with np.load(written["npz"], allow_pickle=False) as loaded:
        count = {what: len(stated[what]) for what in ("states", "inputs", "outputs")}
        assert count["inputs"] != count["outputs"] and all(count.values()), count
        for name, rows, columns in [("A", "states", "states"), ("B", "states", "inputs"),
                                    ("C", "outputs", "states"), ("D", "outputs", "inputs")]:
            assert loaded[name].dtype == np.float64 and loaded[name].shape == (count[rows], count[columns])
            assert np.array_equal(loaded[name], np.array(stated[name])), name
            assert np.any(loaded[name] != 0.0), name
        for what, values in [("state", "x0"), ("input", "u0"), ("output", "y0")]:
            signals = stated[f"{what}s"]
            assert loaded[f"{what}_names"].tolist() == [signal["name"] for signal in signals]
            assert loaded[f"{what}_units"].tolist() == [signal["unit"] for signal in signals]
            assert loaded[values].tolist() == [signal["value"] for signal in signals]
        assert loaded["time_s"].shape == () and loaded["time_s"] == stated["time_s"]
