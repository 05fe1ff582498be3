"""Adds the WebAssembly component of FMI-LS-WASM to an FMU of FMI 3.0: `make wasm-fmu`.

    wasm_fmu.py MODEL.toml -o OUTPUT.fmu --foldwing COMMAND [--interface cs|me] [--draft current|fmi-rs] [-- OPTIONS OF package]

The FMU is that of `foldwing package --fmi 3`, with the component in `binaries/wasm32-wasip2`. The interface of the standard (WIT) is not in
this repository: it is read from the package fmi-rs on crates.io, whose draft has an argument `resource-path` that the current one does not
have; the two drafts have the same version. Needs a Rust compiler with the target wasm32-unknown-unknown (`tools/live_site.py`).
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from xml.etree import ElementTree

from live_site import TARGET, compiler

ROOT = Path(__file__).resolve().parents[1]
WORKSPACE = ROOT / "tools/wasm_fmu"
WORLDS = {"cs": "co-simulation", "me": "model-exchange"}
PLATFORM = "wasm32-wasip2"
STANDARD = "org.modelica.fmi-ls-wasm"
# the argument that the current draft does not have, in the interfaces of three types
OLD_ARGUMENT = re.compile(r"^ *resource-path: *string,\n", re.MULTILINE)
MANIFEST = f"""\
<?xml version="1.0" encoding="UTF-8"?>
<fmiLayeredStandardManifest xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest" fmi-ls:fmi-ls-name="{STANDARD}" \
fmi-ls:fmi-ls-version="0.1.0" fmi-ls:fmi-ls-description="FMI Layered Standard for WebAssembly"/>
"""


def interface(cargo, draft):
    """Writes the WIT files of a draft into the workspace, unless they are there."""
    command = [cargo, "metadata", "--locked", "--format-version", "1", "--manifest-path", ROOT / "tools/second_importer/Cargo.toml"]
    packages = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)["packages"]
    source = next(Path(row["manifest_path"]).parent / "wit" for row in packages if row["name"] == "fmi-rs")
    texts = {path.name: path.read_text(encoding="utf-8") for path in source.glob("*.wit")}
    if sum(len(OLD_ARGUMENT.findall(text)) for text in texts.values()) != 3:
        sys.exit(f"wasm_fmu: {source} has not the draft that this tool knows: three arguments resource-path")
    if draft == "current":
        texts = {name: OLD_ARGUMENT.sub("", text) for name, text in texts.items()}
    folder = WORKSPACE / "wit"
    folder.mkdir(exist_ok=True)
    for name, text in texts.items():
        path = folder / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def core_module(cargo, kind, draft, target):
    """Path of the component's core module, without a model."""
    interface(cargo, draft)
    flags = os.environ.get("RUSTFLAGS", "") + " -C target-feature=+simd128"
    environment = {**os.environ, "RUSTC": compiler(), "RUSTFLAGS": flags.strip()}
    features = WORLDS[kind] + (",resource-path" if draft == "fmi-rs" else "")
    subprocess.run([cargo, "build", "--profile", "component", "--locked", "--package", "foldwing-component", "--features", features,
                    "--target", TARGET, "--target-dir", target], cwd=WORKSPACE, env=environment, check=True)
    module = target / f"{kind}-{draft}.wasm"
    shutil.copy(target / TARGET / "component/foldwing_component.wasm", module)
    return module


def encoder(cargo, target):
    """Path of the program that puts a model into the module and makes a component of it."""
    subprocess.run([cargo, "build", "--locked", "--package", "encoder", "--target-dir", target], cwd=WORKSPACE, check=True)
    return target / "debug/encoder"


def add_component(archive, core, encode):
    """Adds the component of the model to an FMU; returns its size in bytes."""
    with zipfile.ZipFile(archive) as fmu, tempfile.TemporaryDirectory() as folder:
        description = ElementTree.fromstring(fmu.read("modelDescription.xml"))
        kinds = [element for element in description if element.tag in ("CoSimulation", "ModelExchange")]
        if len(kinds) != 1:
            sys.exit(f"wasm_fmu: {archive} is for both interface types, but a component implements one: --interface cs, or me")
        fmu.extract("resources/model.toml", folder)
        component = Path(folder) / "component.wasm"
        subprocess.run([encode, core, Path(folder) / "resources/model.toml", component], check=True)
        size = component.stat().st_size
        name = f"binaries/{PLATFORM}/{kinds[0].get('modelIdentifier')}.wasm"
        with zipfile.ZipFile(archive, "a", zipfile.ZIP_DEFLATED) as more:
            more.write(component, name)
            # the draft's name of the file, and that of FMI 3.0.2, section 2.5.2
            for manifest in ("manifest.xml", "fmi-ls-manifest.xml"):
                more.writestr(f"extra/{STANDARD}/{manifest}", MANIFEST)
    return size


def main():
    """Runs the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model", type=Path, help="the model file")
    parser.add_argument("-o", "--output", type=Path, required=True, help="the FMU")
    parser.add_argument("--foldwing", required=True, help="the command")
    parser.add_argument("--interface", choices=WORLDS, default="cs", help="interface type [default: cs]")
    parser.add_argument("--draft", choices=("current", "fmi-rs"), default="current", help="draft of the standard [default: current]")
    parser.add_argument("--target", type=Path, default=ROOT / "target/wasm_fmu", help="folder of the compilation")
    parser.add_argument("--cargo", default=os.environ.get("CARGO", "cargo"), help="the cargo to call")
    parser.add_argument("more", nargs="*", help="further options of `package`, after --")
    arguments = parser.parse_args()
    target = arguments.target.resolve()
    core = core_module(arguments.cargo, arguments.interface, arguments.draft, target)
    encode = encoder(arguments.cargo, target)
    subprocess.run([arguments.foldwing, "package", arguments.model, "--fmi", "3", "--interface", arguments.interface, "-q", "-o", arguments.output,
                    *arguments.more], check=True)
    size = add_component(arguments.output, core, encode)
    print(f"{arguments.output}: with a component of {size} bytes")


if __name__ == "__main__":
    main()
