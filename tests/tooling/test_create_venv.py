"""Creation of the Python environment: with pip fetched by its hash, from every kind of index, and failures."""

import hashlib
import http.server
import importlib.util
import json
import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "tools/create_venv.py"
WHEEL = b"stands for the wheel of pip"

# The smallest requirement that proves an installation: pure Python, no dependencies, pinned like the real ones.
SMALL = "iniconfig==2.1.0 --hash=sha256:9deba5723312380e77435581c6bf4935c94cbfab9b1ed33ef8d238ea168eb760\n"


@pytest.fixture
def bootstrap(monkeypatch):
    """The script as a module, without pip settings of this computer."""
    spec = importlib.util.spec_from_file_location("create_venv", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "PIP_SHA256", hashlib.sha256(WHEEL).hexdigest())
    monkeypatch.setattr(Path, "home", lambda: Path("/nonexistent"))
    for name in ("FIND_LINKS", "INDEX_URL", "CONFIG_FILE"):
        monkeypatch.delenv(f"PIP_{name}", raising=False)
    return module


@pytest.fixture
def index(tmp_path, monkeypatch):
    """A package index on this computer that answers in HTML or JSON; returns the function that selects the answer."""

    class Handler(http.server.BaseHTTPRequestHandler):
        pages = {}

        def do_GET(self):
            content_type, body = self.pages.get(self.path, (None, b""))
            self.send_response(200 if content_type else 404)
            self.send_header("Content-Type", content_type or "text/plain")
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *_):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    monkeypatch.setenv("PIP_INDEX_URL", f"http://127.0.0.1:{server.server_port}/simple/")

    def offer(content_type, page):
        Handler.pages["/simple/pip/"] = (content_type, page.encode())
        Handler.pages["/files/wheel"] = ("application/octet-stream", WHEEL)

    yield offer
    server.shutdown()
    server.server_close()


def run(*arguments, **environment):
    """Runs the script with the pip settings of this computer unchanged."""
    return subprocess.run(
        [sys.executable, SCRIPT, *arguments], env={**os.environ, **environment}, capture_output=True, text=True
    )


def test_t01_pinned_pip_installs_where_ensurepip_is_missing(tmp_path):
    """T-01. Without ensurepip the pinned wheel of pip is fetched and installs hash-checked requirements.

    This is the case of Debian and Ubuntu without python3-venv, with the package index configured on this computer. A second call finds the
    environment up to date and does not change it.
    """
    requirements = tmp_path / "requirements.txt"
    requirements.write_text(SMALL)
    folder = tmp_path / "venv"
    outcome = run(folder, "--requirements", requirements, "--without-ensurepip")
    assert outcome.returncode == 0, outcome.stderr
    python = folder / "bin/python"
    assert subprocess.run([python, "-c", "import iniconfig"]).returncode == 0
    assert subprocess.run([python, "-c", "import pip"], capture_output=True).returncode != 0, "pip must stay outside"

    again = run(folder, "--requirements", requirements, "--without-ensurepip")
    assert again.returncode == 0 and again.stdout == ""


def test_t02_wrong_hash_of_a_requirement_is_refused_and_leaves_no_stamp(tmp_path):
    """T-02. A requirement whose hash does not match is rejected; the next call starts again instead of using the incomplete environment.
    With the fetched pip: the slower ensurepip, seconds per environment, was used for the environment of these tests."""
    requirements = tmp_path / "requirements.txt"
    requirements.write_text(SMALL.replace("sha256:9", "sha256:0"))
    folder = tmp_path / "venv"
    outcome = run(folder, "--requirements", requirements, "--without-ensurepip")
    assert outcome.returncode != 0 and "pip could not install" in outcome.stderr
    assert not (folder / "foldwing-stamp").exists()
    requirements.write_text(SMALL)
    assert run(folder, "--requirements", requirements, "--without-ensurepip").returncode == 0


def test_t03_foreign_folder_is_not_removed(tmp_path):
    """T-03. An existing folder that is not a Python environment is not changed, and the message gives this reason."""
    (tmp_path / "thesis.txt").write_text("years of work")
    outcome = run(tmp_path, "--requirements", ROOT / "python/requirements.txt")
    assert outcome.returncode != 0 and "is not a Python environment" in outcome.stderr
    assert (tmp_path / "thesis.txt").exists()


@pytest.mark.parametrize("kind", ["html", "json"])
def test_t04_index_pages_are_understood(bootstrap, index, kind):
    """T-04. Both forms of index page (PEP 503 and PEP 691) lead to the wheel, by relative and absolute links."""
    name = bootstrap.PIP_WHEEL
    if kind == "html":
        index("text/html", f'<a href="/files/old">pip-1.0.whl</a>\n<a href="../../files/wheel#sha256=0">{name}</a>')
    else:
        files = [{"filename": name, "url": f"{os.environ['PIP_INDEX_URL'].replace('/simple/', '')}/files/wheel"}]
        index("application/vnd.pypi.simple.v1+json", json.dumps({"files": files}))
    assert bootstrap.checked(bootstrap.fetch_pip()) == WHEEL


def test_t05_wheel_with_another_hash_is_refused(bootstrap):
    """T-05. Any other file than the pinned wheel is rejected before it runs, and the message gives both hashes."""
    with pytest.raises(bootstrap.SetupError, match="SHA-256 is"):
        bootstrap.checked(WHEEL + b"!")


def test_t06_unreachable_index_says_what_to_do(bootstrap, monkeypatch):
    """T-06. For an index that cannot be reached the message gives both remedies and no password."""
    monkeypatch.setenv("PIP_INDEX_URL", "http://user:secret@127.0.0.1:9/simple")
    with pytest.raises(bootstrap.SetupError) as failure:
        bootstrap.fetch_pip()
    text = str(failure.value)
    assert "python3-venv" in text and "PIP_INDEX_URL" in text and "127.0.0.1:9" in text
    assert "secret" not in text


def test_t07_index_without_the_wheel_is_an_error(bootstrap, index):
    """T-07. An index that does not list the pinned wheel is an error that states this."""
    index("text/html", "<a href='/files/old'>pip-1.0.whl</a>")
    with pytest.raises(bootstrap.SetupError, match="does not list it"):
        bootstrap.fetch_pip()


def test_t08_folder_of_wheels_and_configuration_file_are_respected(bootstrap, monkeypatch, tmp_path):
    """T-08. A folder of wheels configured for pip provides the wheel; settings are also read from a configuration file."""
    (tmp_path / bootstrap.PIP_WHEEL).write_bytes(WHEEL)
    configuration = tmp_path / "pip.conf"
    configuration.write_text(f"[global]\nfind-links = {tmp_path}\nindex-url = https://packages.example/simple\n")
    monkeypatch.setenv("PIP_CONFIG_FILE", str(configuration))
    assert bootstrap.fetch_pip() == WHEEL
    assert bootstrap.pip_setting("index-url", "") == "https://packages.example/simple"
    monkeypatch.setenv("PIP_INDEX_URL", "https://other.example/simple")
    assert bootstrap.pip_setting("index-url", "") == "https://other.example/simple"


def test_t09_broken_interpreter_versions_are_told(bootstrap, monkeypatch, tmp_path):
    """T-09. A Python that is too old is rejected, with its version, before anything is written."""
    monkeypatch.setattr(bootstrap, "OLDEST_PYTHON", (99, 0))
    with pytest.raises(bootstrap.SetupError, match="Python 99.0 or newer is needed"):
        bootstrap.create(tmp_path / "venv", ROOT / "python/requirements.txt", False)
    assert not (tmp_path / "venv").exists()
