#!/usr/bin/env python3
"""Creates the Python environment in which the deployment example and the FMI tests run.

Everything is pinned: packages by `python/requirements.txt` with hashes, and, if this Python lacks `ensurepip`
(a separate package on Debian and Ubuntu), pip itself by the hash below. Only the standard library is used
here.

An environment that is up to date is not changed; an incomplete one is never accepted as complete.
"""

import argparse
import configparser
import hashlib
import html.parser
import json
import os
import shutil
import ssl
import subprocess
import sys
import tempfile
import urllib.parse
import urllib.request
import venv
from pathlib import Path

PIP_WHEEL = "pip-25.3-py3-none-any.whl"
PIP_SHA256 = "9655943313a94722b7774661c21049070f6bbb0a1516bf02f7c8d5d9201514cd"
DEFAULT_INDEX = "https://pypi.org/simple"
TIMEOUT_S = 60
OLDEST_PYTHON = (3, 9)


class SetupError(Exception):
    """An error that the user can resolve."""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("venv", type=Path, help="folder of the environment")
    parser.add_argument("--requirements", type=Path, required=True, help="pinned requirements with hashes")
    parser.add_argument("--without-ensurepip", action="store_true", help="fetch the pinned pip even if ensurepip exists")
    arguments = parser.parse_args()
    try:
        create(arguments.venv.resolve(), arguments.requirements, arguments.without_ensurepip)
    except SetupError as error:
        sys.exit(f"create_venv: {error}")


def create(folder, requirements, without_ensurepip):
    """Creates the environment unless its stamp is that of the requirements."""
    if sys.version_info < OLDEST_PYTHON:
        raise SetupError(f"Python {'.'.join(map(str, OLDEST_PYTHON))} or newer is needed, this is {sys.version.split()[0]}")
    stamp = folder / "foldwing-stamp"
    wanted = fingerprint(requirements)
    if stamp.is_file() and stamp.read_text() == wanted and interpreter(folder).exists():
        return
    if folder.exists():
        if not (folder / "pyvenv.cfg").is_file() and any(folder.iterdir()):
            raise SetupError(f"{folder} exists and is not a Python environment; remove it or choose another folder")
        shutil.rmtree(folder)
    print(f"creating the Python environment in {folder}", flush=True)
    if without_ensurepip or not has_ensurepip():
        venv.create(folder, with_pip=False, symlinks=os.name != "nt")
        install_with_pinned_pip(folder, requirements)
    else:
        venv.create(folder, with_pip=True, symlinks=os.name != "nt")
        install(folder, ["-m", "pip"], requirements)
    stamp.write_text(wanted)


def fingerprint(requirements):
    """Hash of the pins and the interpreter, on which the environment depends."""
    digest = hashlib.sha256(requirements.read_bytes()).hexdigest()
    return f"{digest} {sys.version} {sys.executable}\n"


def interpreter(folder):
    """Path of Python in an environment."""
    return folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def has_ensurepip():
    """Whether this Python can install pip into an environment by itself."""
    try:
        import ensurepip

        return bool(ensurepip.version())
    except (ImportError, OSError):
        return False


def install(folder, pip, requirements):
    """Runs pip inside the environment; hashes are compulsory."""
    command = [str(interpreter(folder)), *pip, "install", "--quiet", "--disable-pip-version-check", "--require-hashes"]
    outcome = subprocess.run([*command, "--requirement", str(requirements)])
    if outcome.returncode:
        raise SetupError(f"pip could not install {requirements}; its message stands above")


def install_with_pinned_pip(folder, requirements):
    """Fetches the pinned wheel of pip, checks it, and installs with it from inside the wheel."""
    with tempfile.TemporaryDirectory() as scratch:
        wheel = Path(scratch) / PIP_WHEEL
        wheel.write_bytes(checked(fetch_pip()))
        install(folder, [f"{wheel}/pip"], requirements)


def checked(wheel):
    """Returns the wheel if it is the pinned one."""
    found = hashlib.sha256(wheel).hexdigest()
    if found != PIP_SHA256:
        raise SetupError(f"{PIP_WHEEL}: SHA-256 is {found}, expected {PIP_SHA256}")
    return wheel


def fetch_pip():
    """Bytes of the pinned wheel: from a folder of wheels in pip's settings, otherwise from the package index."""
    for folder in pip_setting("find-links", "").split():
        local = Path(urllib.request.url2pathname(urllib.parse.urlparse(folder).path) if "://" in folder else folder)
        if (local / PIP_WHEEL).is_file():
            return (local / PIP_WHEEL).read_bytes()
    index = pip_setting("index-url", DEFAULT_INDEX).rstrip("/")
    page = f"{index}/pip/"
    try:
        link = wheel_link(page, *get(page, "application/vnd.pypi.simple.v1+json, text/html;q=0.5"))
        return get(link, "*/*")[0]
    except (OSError, ValueError) as error:
        raise SetupError(
            f"cannot fetch {PIP_WHEEL} from {without_password(page)}: {error}\n"
            "Either install the package that provides Python's ensurepip (python3-venv on Debian and Ubuntu),\n"
            "or set PIP_INDEX_URL to an index that this machine can reach."
        ) from error


def get(url, accept):
    """Body and content type of a page, with the certificate and credentials that pip would use."""
    parts = urllib.parse.urlsplit(url)
    certificate = pip_setting("cert", "") or None
    handlers = [urllib.request.HTTPSHandler(context=ssl.create_default_context(cafile=certificate))]
    if parts.username:
        passwords = urllib.request.HTTPPasswordMgrWithPriorAuth()
        user, password = (urllib.parse.unquote(text or "") for text in (parts.username, parts.password))
        url = without_password(url)
        passwords.add_password(None, url, user, password, is_authenticated=True)
        handlers.append(urllib.request.HTTPBasicAuthHandler(passwords))
    request = urllib.request.Request(url, headers={"Accept": accept, "User-Agent": "foldwing"})
    with urllib.request.build_opener(*handlers).open(request, timeout=TIMEOUT_S) as answer:
        return answer.read(), answer.headers.get_content_type()


def without_password(url):
    """A URL without user and password, for messages."""
    parts = urllib.parse.urlsplit(url)
    return parts._replace(netloc=parts.netloc.rpartition("@")[2]).geturl()


def wheel_link(page, body, content_type):
    """Address of the pinned wheel on an index page, which is JSON or HTML (PEP 503, PEP 691)."""
    if content_type.endswith("json"):
        links = [(file["filename"], file["url"]) for file in json.loads(body)["files"]]
    else:
        links = Links.of(body.decode("utf-8", "replace"))
    for name, address in links:
        if name == PIP_WHEEL:
            return authenticated_like(page, urllib.parse.urljoin(page, address).partition("#")[0])
    raise ValueError("the index does not list it")


def authenticated_like(page, url):
    """The URL with the page's credentials, if it is on the same host."""
    user, separator, host = urllib.parse.urlsplit(page).netloc.rpartition("@")
    parts = urllib.parse.urlsplit(url)
    return parts._replace(netloc=user + separator + host).geturl() if parts.netloc == host else url


class Links(html.parser.HTMLParser):
    """Anchors of an index page."""

    def __init__(self):
        super().__init__()
        self.found, self._address = [], None

    @classmethod
    def of(cls, text):
        """Pairs of file name and address."""
        parser = cls()
        parser.feed(text)
        return parser.found

    def handle_starttag(self, tag, attributes):
        if tag == "a":
            self._address = dict(attributes).get("href")

    def handle_data(self, data):
        if self._address and data.strip():
            self.found.append((data.strip(), self._address))
            self._address = None


def pip_setting(name, default):
    """A setting of pip, searched in pip's order: environment first, then its configuration files."""
    value = os.environ.get("PIP_" + name.upper().replace("-", "_"))
    if value:
        return value
    home = Path.home()
    candidates = [os.environ.get("PIP_CONFIG_FILE"), home / ".config/pip/pip.conf", home / ".pip/pip.conf", "/etc/pip.conf"]
    if os.name == "nt":
        candidates.insert(1, Path(os.environ.get("APPDATA", home)) / "pip/pip.ini")
    for candidate in filter(None, candidates):
        parser = configparser.RawConfigParser()
        try:
            parser.read(candidate)
        except (configparser.Error, UnicodeDecodeError):
            continue
        for section in ("install", "global"):
            if parser.has_option(section, name):
                return parser.get(section, name)
    return default


if __name__ == "__main__":
    main()
