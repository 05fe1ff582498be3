"""The command on a terminal: progress with the remaining time, which is not written elsewhere."""

import os
import re
import subprocess
import sys

import pytest
from conftest import ROOT

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals")
GOLAND = str(ROOT / "examples/models/goland_wing.toml")


def on_terminal(*command, width=100):
    """Exit code and lines that a command draws or prints on a terminal of this width, without control sequences."""
    import fcntl
    import pty
    import struct
    import termios

    leader, follower = pty.openpty()
    fcntl.ioctl(follower, termios.TIOCSWINSZ, struct.pack("HHHH", 40, width, 0, 0))
    environment = {**os.environ, "TERM": "xterm"}
    process = subprocess.Popen([str(word) for word in command], stdin=follower, stdout=follower, stderr=follower, env=environment, close_fds=True)
    os.close(follower)
    text = b""
    while True:
        try:
            part = os.read(leader, 65536)
        except OSError:  # Linux reports the end of a terminal in this way
            break
        if not part:
            break
        text += part
    os.close(leader)
    plain = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", text.decode("utf-8"))
    return process.wait(), [line.strip() for line in re.split(r"[\r\n]", plain) if line.strip()]


@pytest.mark.parametrize(
    ("words", "drawn"),
    [
        (["flutter", GOLAND, "--wind-m-s", "50:130:100", "--count", "4"], r"\d+ % of the wind speeds, \d+ s left"),
        (["flutter", GOLAND, "--wind-m-s", "50:130:20", "--vary", "aero.density=1,1.1,1.2,1.3"], r"\d+ % of the wind speeds, \d+ s left"),
        (["modes", GOLAND, "--vary", "aero.density=0.5:1.5:120", "--count", "4"], r"\d+ % of the values, \d+ s left"),
        (["simulate", GOLAND, "--stop", "30"], r"\d+ % of the time, \d+ s left"),
        (["periodic", ROOT / "examples/turbine/nrel_5mw_wind.toml", "--speed-rpm", "12.1", "--count", "0"], r"(search for the periodic state|outputs over a revolution), \d+ s so far"),
    ],
)
def test_long_work_shows_its_progress(foldwing, words, drawn):
    """Each of these takes 1.2 to 2.8 s of processor time; a progress line appears after 0.5 s."""
    code, lines = on_terminal(foldwing, *words)
    assert code == 0, lines[-5:]
    shown = [line for line in lines if re.search(drawn, line)]
    assert shown, lines[:5]
    shares = [int(match[1]) for line in shown if (match := re.search(r"(\d+) % of", line))]
    assert shares == sorted(shares) and all(share <= 100 for share in shares)


def test_a_pipe_gets_no_progress(foldwing):
    """The first of the commands above, with streams that are not a terminal."""
    words = ["flutter", GOLAND, "--wind-m-s", "50:130:100", "--count", "4"]
    done = subprocess.run([foldwing, *words], capture_output=True, text=True, check=True)
    assert done.stderr == "" and "% of" not in done.stdout


def test_short_work_shows_none(foldwing):
    code, lines = on_terminal(foldwing, "simulate", ROOT / "examples/models/folding_wing.toml", "--stop", "0.001")
    assert code == 0 and not any("% of the" in line or "so far" in line for line in lines), lines


def test_an_error_leaves_no_bar(foldwing):
    """The progress line is cleared before an error is printed."""
    code, lines = on_terminal(foldwing, "flutter", GOLAND, "--wind-m-s", "50:130:60", "--csv", "/proc/none/x.csv")
    assert code == 4 and lines[-1].startswith("error: /proc/none/x.csv: cannot be written"), lines[-3:]
