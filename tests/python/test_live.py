"""A live simulation from Python: the page starts from the state of the simulation, in a process that ends with the block."""

import base64
import json
import math
import re
import socket
import struct
import urllib.error
import urllib.request

import pytest

import foldwing as fw


def page(address):
    """The page as text, without a proxy."""
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    with opener.open(address, timeout=60) as answer:
        return answer.read().decode()


def test_a_view_begins_at_the_present_state(wing):
    """Inputs, parameters and time of the page are those of the simulation, which is unaffected; the process ends with the block."""
    sim = wing.start()
    sim["fold.motor_damping"] = 0.002
    sim["load.outer[4].force.z"] = -0.1
    sim.step(0.05)
    before = sim["fold.angle"]
    with sim.view(show=False, speed=0.5) as shown:
        assert re.fullmatch(r"http://127\.0\.0\.1:[0-9]+/[0-9a-f]{32}/", shown.address) and shown.running
        text = page(shown.address)
        live = json.loads(re.search(r'class="live">(.*?)</script', text)[1])
        assert live["speed"] == 0.5
        # the range of a slider is twice the magnitude of the value
        sliders = {one["name"]: one["slider"] for one in live["controls"]}
        assert sliders["load.outer[4].force.z"] == [-0.2, 0.2]
        assert sliders["fold.motor_damping"][1] == 0.004
        run = json.loads(re.search(r'class="run">(.*?)</script', text)[1])
        assert [name for name, _ in run["signals"]][:1] == [name for name in wing.variables if wing.variables[name].causality == "output"][:1]
        with pytest.raises(urllib.error.HTTPError, match="403"):
            page(shown.address[:-33] + 32 * "0" + "/")
        assert not shown.wait(0.05)
        folder = shown._folder
    assert not shown.running and not folder.exists() and "interrupted: 0.000 s simulated" in shown.note
    assert (sim["fold.angle"], sim.time) == (before, 0.05)
    shown.close()


def test_wrong_arguments_are_refused(wing):
    """An occupied port, and numbers out of range: the error names the argument."""
    sim = wing.start()
    for arguments, message in [({"port": 70000}, "port=70000: must be from 0 to 65535"), ({"speed": 0.0}, "speed=0.0: must be from 0.001 to 100"),
                               ({"speed": float("nan")}, "speed=nan: must be from 0.001")]:
        with pytest.raises(fw.UsageError, match=message):
            sim.view(show=False, **arguments)
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(fw.FilesError, match=f"--port {port}: cannot be opened on 127.0.0.1"):
            sim.view(show=False, port=port)


def test_simulations_are_shown_in_step(wing):
    """Two simulations of one model start from their current states on one page, numbered in the legend; different times are an error."""
    one, two = wing.start(), wing.start()
    two["fold.external_torque"] = 0.02
    one.step(0.05)
    with pytest.raises(fw.UsageError, match=r"compare\[0\]: is at 0.0 s and this simulation at 0.05 s, but they have one clock"):
        one.view(compare=two, show=False)
    with pytest.raises(fw.UsageError, match="compare: 4 simulations; at most 3"):
        one.view(compare=[one] * 4, show=False)
    two.step(0.05)
    with one.view(compare=two, show=False) as shown:
        text = page(shown.address)
    live = json.loads(re.search(r'class="live">(.*?)</script', text)[1])
    assert live["machines"] == [f"{wing.name} 1", f"{wing.name} 2"]
    assert [name["name"] for name in live["controls"]] == [name["name"] for name in live["others"][0]]
    # the numbers of a page: time, then the angle in degrees
    starts = [struct.unpack("<2f", base64.b64decode(numbers)[:8]) for numbers in re.findall(r'class="numbers">(.*?)</script', text)]
    for (time, angle), sim in zip(starts, (one, two), strict=True):
        assert abs(time - 0.05) < 1e-8 and abs(angle - math.degrees(sim["fold.angle"])) < 1e-4
    assert abs(starts[0][1] - starts[1][1]) > 0.1
