"""A headless Chromium, controlled through its pipe: it needs no package and no network port."""

import base64
import fcntl
import itertools
import json
import os
import select
import shutil
import signal
import subprocess
import tempfile
import time

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
FLAGS = ["--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-background-networking", "--disable-component-update",
         "--disable-sync", "--no-first-run", "--hide-scrollbars", "--disable-dev-shm-usage", "--remote-debugging-pipe"]
PATIENCE_S = 300.0  # wall-clock time: other programs may use most of the processors


def chromium():
    """Path of a Chromium; the test is skipped if there is none, except in continuous integration."""
    found = next(filter(None, map(shutil.which, NAMES)), None)
    if found is None:
        reason = f"none of {', '.join(NAMES)} is installed (Debian: apt-get install chromium)"
        if os.environ.get("CI") == "true":
            pytest.fail(reason)
        pytest.skip(reason)
    return found


class Browser:
    """One browser with one page; events are stored in the order of arrival."""

    def __init__(self):
        self.profile = tempfile.mkdtemp(prefix="foldwing-browser-")
        command = [chromium(), *FLAGS, f"--user-data-dir={self.profile}", "about:blank"]
        their_in, self.out = os.pipe()
        self.inp, their_out = os.pipe()

        def take_their_ends():
            """The protocol needs descriptors 3 and 4; the pipe ends are moved first, because they may have these numbers."""
            ends = [fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in (their_in, their_out)]
            for number, end in zip((3, 4), ends):
                os.dup2(end, number)

        self.process = subprocess.Popen(command, preexec_fn=take_their_ends, pass_fds=(3, 4), stdout=subprocess.DEVNULL,
                                        stderr=subprocess.DEVNULL, start_new_session=True)
        os.close(their_in)
        os.close(their_out)
        self.numbers, self.rest, self.events, self.session = itertools.count(1), b"", [], None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        os.killpg(self.process.pid, signal.SIGTERM)
        self.process.wait(PATIENCE_S)
        os.close(self.inp)
        os.close(self.out)
        shutil.rmtree(self.profile, ignore_errors=True)

    def call(self, method, **parameters):
        """A command of the DevTools protocol and its result."""
        number = next(self.numbers)
        message = {"id": number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.out, json.dumps(message).encode() + b"\0")
        answer = self.until(lambda message: message.get("id") == number, method)
        assert "error" not in answer, (method, answer["error"])
        return answer["result"]

    def until(self, wanted, what):
        """The first message that matches; earlier messages are stored among the events."""
        stop = time.monotonic() + PATIENCE_S
        while True:
            while b"\0" in self.rest:
                text, self.rest = self.rest.split(b"\0", 1)
                message = json.loads(text)
                if wanted(message):
                    return message
                self.events.append(message)
            ready, _, _ = select.select([self.inp], [], [], max(0.0, stop - time.monotonic()))
            assert ready, f"{what}: no answer within {PATIENCE_S:.0f} s"
            data = os.read(self.inp, 1 << 16)
            assert data, f"{what}: the browser has ended"
            self.rest += data

    def open(self, path, width=1280, height=900, dark=False):
        """Loads a file, or an address given as text, with a window size and a colour scheme; the events of the load replace the earlier
        ones."""
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.call("Emulation.setEmulatedMedia", features=[scheme])
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 600)
        self.events.clear()
        self.call("Page.navigate", url=path if isinstance(path, str) else path.resolve().as_uri())
        self.until(lambda message: message.get("method") == "Page.loadEventFired", "load")

    def value(self, expression):
        """Value of a JavaScript expression; `None` if it has none."""
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True)
        assert "exceptionDetails" not in result, result
        return result["result"].get("value")

    def await_value(self, expression, wanted):
        """Waits until a JavaScript expression has a value: on a busy computer the page may need several frames."""
        stop = time.monotonic() + PATIENCE_S
        while (value := self.value(expression)) != wanted:
            assert time.monotonic() < stop, f"{expression} is {value!r}, not {wanted!r}, after {PATIENCE_S:.0f} s"
            time.sleep(0.02)

    def complaints(self):
        """Console messages, log entries and exceptions since the page was opened."""
        kinds = {"Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded"}
        return [event for event in self.events if event.get("method") in kinds]

    def requests(self):
        """Addresses requested since the page was opened."""
        return [event["params"]["request"]["url"] for event in self.events
                if event.get("method") == "Network.requestWillBeSent"]

    def screenshot(self, path, whole=False):
        """Writes a PNG of the window, or of the whole page."""
        data = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)["data"]
        path.write_bytes(base64.b64decode(data))
