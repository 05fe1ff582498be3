"""A live simulation as a process, and a client of its page without a browser: only the WebSocket."""

import base64
import contextlib
import json
import os
import signal
import socket
import struct
import subprocess
from urllib.parse import urlparse

from browser import PATIENCE_S


class Client:
    """The WebSocket of a page."""

    def __init__(self, address):
        parts = urlparse(address)
        self.stream = socket.create_connection((parts.hostname, parts.port), timeout=PATIENCE_S)
        key = base64.b64encode(os.urandom(16)).decode()
        self.stream.sendall((f"GET {parts.path}socket HTTP/1.1\r\nHost: {parts.netloc}\r\nOrigin: http://{parts.netloc}\r\nConnection: Upgrade\r\n"
                             f"Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n\r\n").encode())
        self.rest = b""
        head = self.until(b"\r\n\r\n")
        assert head.startswith(b"HTTP/1.1 101 "), head

    def until(self, end):
        """Bytes up to a terminator."""
        while end not in self.rest:
            self.rest += self.stream.recv(1 << 16)
        head, self.rest = self.rest.split(end, 1)
        return head

    def take(self, count):
        """A number of bytes."""
        while len(self.rest) < count:
            data = self.stream.recv(1 << 20)
            assert data, "the server has ended the connection"
            self.rest += data
        taken, self.rest = self.rest[:count], self.rest[count:]
        return taken

    def ask(self, **order):
        """Sends a command, masked as required for clients by the protocol."""
        text, mask = json.dumps(order).encode(), os.urandom(4)
        size = bytes([0x80 | len(text)]) if len(text) < 126 else bytes([0x80 | 126]) + struct.pack(">H", len(text))
        self.stream.sendall(b"\x81" + size + mask + bytes(byte ^ mask[i % 4] for i, byte in enumerate(text)))

    def message(self):
        """The next message: a text as JSON, or the header of a picture."""
        first, second = self.take(2)
        length = second & 0x7F
        if length > 125:
            length = struct.unpack(*((">H", self.take(2)) if length == 126 else (">Q", self.take(8))))[0]
        data = self.take(length)
        if first & 0xF == 2:
            return json.loads(data[4:4 + struct.unpack("<I", data[:4])[0]])
        return json.loads(data) if first & 0xF == 1 else {}

    def picture(self, wanted=lambda header: True):
        """The header of the next picture that matches."""
        while True:
            message = self.message()
            if "rows" in message and wanted(message):
                return message


@contextlib.contextmanager
def live(foldwing, model, *options):
    """Address and process of a live simulation, which is interrupted at the end unless it has ended."""
    process = subprocess.Popen([foldwing, "live", model, "--no-browser", *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        address = process.stdout.readline().strip()
        assert address.startswith("http://127.0.0.1:"), process.stderr.read()
        yield address, process
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        process.communicate(timeout=PATIENCE_S)


def farewell(process):
    """Values of the final note when a process ends: simulated, ran, lost, late in s, and the slowest step in ms."""
    _, text = process.communicate(timeout=PATIENCE_S)
    last = text.strip().splitlines()[-1]
    words = last.replace(";", "").replace(",", "").split()
    number = lambda before: float(words[words.index(before) - 1])
    return {"simulated": float(words[words.index("simulated") - 2]), "ran": float(words[words.index("in") + 1]), "lost": float(words[words.index("lost") - 2]),
            "late": float(words[words.index("late") - 2]), "slowest": number("ms"), "text": last}
