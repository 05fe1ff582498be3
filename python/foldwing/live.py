"""Live simulations in the browser: the server of the command as a separate process."""

from __future__ import annotations

import contextlib
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import webbrowser
from pathlib import Path
from types import TracebackType
from typing import IO, List, Optional, Sequence, Tuple, Type

from .errors import FilesError, UsageError

Machine = Tuple[str, bytes]
"""Text of a model, and the bytes of a state of this model."""


class Live:
    """A live simulation shown in a browser page; created by `Simulation.view`. It ends when its page is closed, by `close`, at the end of a
    `with` block, and with this process.

    Attributes:
        address: address of the page, with its token. Only this computer can open it, and only with the token.
    """

    address: str

    def __init__(self, machines: Sequence[Machine], port: int, speed: float) -> None:
        """Start the server with the models, each given by the text of its model and the bytes of a state."""
        self._folder = Path(tempfile.mkdtemp(prefix="foldwing-live-"))
        self._notes: List[str] = []
        command = [sys.executable, "-m", "foldwing", "live", "--no-browser", "--port", str(port), "--speed", repr(speed)]
        for number, (text, state) in enumerate(machines, 1):
            # all files have the same name, so that the legend numbers models with equal names
            model, start = self._folder / str(number) / "model.toml", self._folder / str(number) / "state"
            model.parent.mkdir()
            model.write_bytes(text.encode())
            start.write_bytes(state)
            command += [*(["--compare"] if number > 1 else []), str(model), "--state", str(start)]
        # Ctrl-C at the prompt interrupts the code that runs there, not the server
        self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
        assert self._process.stdout is not None and self._process.stderr is not None
        self._reader = threading.Thread(target=self._read, args=(self._process.stderr,), daemon=True)
        self._reader.start()
        self.address = self._process.stdout.readline().strip()
        if not self.address:
            self.close()
            raise FilesError(f"view: the server did not start: {' '.join(self._notes)}")

    def _read(self, errors: IO[str]) -> None:
        for line in errors:
            self._notes.append(line.strip())

    @property
    def running(self) -> bool:
        """Whether the simulation is still running: false after its page was closed."""
        return self._process.poll() is None

    @property
    def note(self) -> str:
        """Last message of the server; after the end, how much time was simulated and whether the wall clock was kept."""
        return self._notes[-1] if self._notes else ""

    def wait(self, timeout: Optional[float] = None) -> bool:
        """Wait until the page is closed.

        Args:
            timeout: longest time to wait in s; default: without limit.

        Returns:
            Whether it has ended.
        """
        try:
            self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            return False
        self.close()
        return True

    def close(self) -> None:
        """End the simulation; the page keeps the run shown so far. May be called twice."""
        if self.running:
            self._process.send_signal(signal.SIGINT if sys.platform != "win32" else signal.SIGTERM)
            try:
                self._process.wait(5.0)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        self._reader.join()
        for stream in (self._process.stdout, self._process.stderr):
            if stream is not None:
                stream.close()
        shutil.rmtree(self._folder, ignore_errors=True)

    def __enter__(self) -> Live:
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]) -> None:
        self.close()

    def __del__(self) -> None:
        # missing if the constructor failed early
        if hasattr(self, "_reader"):
            with contextlib.suppress(Exception):
                self.close()

    def __repr__(self) -> str:
        return f"<foldwing.Live at {self.address}{'' if self.running else ', ended'}>"


def start(machines: Sequence[Machine], port: int, speed: float, show: bool) -> Live:
    """Start a live simulation of several models in step and show its page, unless `show` is false."""
    if not 0 <= port <= 65535:
        raise UsageError(f"port={port}: must be from 0 to 65535; 0 selects any free port")
    if not 1e-3 <= speed <= 100.0:
        raise UsageError(f"speed={speed}: must be from 0.001 to 100 simulated seconds per second")
    live = Live(machines, port, speed)
    if show and not webbrowser.open(live.address):
        print(f"open {live.address} in a browser of this computer", file=sys.stderr)
    return live
