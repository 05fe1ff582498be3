"""A live simulation from Python: the page starts from the state of the simulation, in a process that ends with the block."""

import json
import re
import socket
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
