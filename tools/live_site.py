"""Builds the page in which the models of the documentation run: `make live-site`, into target/live.

    live_site.py --output target/live [--target target/wasm]

The engine becomes WebAssembly, which needs a Rust compiler with the target wasm32-unknown-unknown: the one named by FOLDWING_WASM_RUSTC,
otherwise `rustc`. The output consists of `foldwing.wasm`; `engine.js`, its compressed form for pages that are opened from the disk;
`index.html`, the viewer with an editor; and `models.js`, the gallery. `make site` includes the folder in the documentation.
"""

import argparse
import base64
import gzip
import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TARGET = "wasm32-unknown-unknown"
MOST_BYTES = 2_000_000  # compressed, as loaded by a browser

INSTALL = f"""has no target {TARGET}, for which the engine in pages is compiled. Install it:
    rustup target add {TARGET}
or where rustup has none of it, Debian's packages (version 1.89 or later):
    apt-get install rustc libstd-rust-dev-wasm32 lld
Another compiler than `rustc` is named by FOLDWING_WASM_RUSTC=/path/to/rustc, and its linker, if it does not find rust-lld, by
CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER=/path/to/wasm-ld"""


def compiler():
    """A compiler that supports the target."""
    rustc = os.environ.get("FOLDWING_WASM_RUSTC", "rustc")
    found = shutil.which(rustc)
    if not found:
        sys.exit(f"live_site: there is no {rustc}; FOLDWING_WASM_RUSTC names a compiler")
    asked = subprocess.run([found, "--print", "target-libdir", "--target", TARGET], capture_output=True, text=True)
    folder = Path(asked.stdout.strip() or "/nowhere")
    if asked.returncode or not list(folder.glob("libstd-*")):
        sys.exit(f"live_site: {rustc} {INSTALL}")
    return found


def module(cargo, rustc, target):
    """Bytes of the engine's WebAssembly module."""
    # the lattice's kernels are four times as fast with vector instructions, which all browsers have supported since 2023
    flags = os.environ.get("RUSTFLAGS", "") + " -C target-feature=+simd128"
    environment = {**os.environ, "RUSTC": rustc, "RUSTFLAGS": flags.strip()}
    subprocess.run([cargo, "build", "--profile", "web", "--locked", "--package", "foldwing-web", "--lib", "--target", TARGET,
                    "--target-dir", target], cwd=ROOT, env=environment, check=True)
    return (target / TARGET / "web/foldwing_web.wasm").read_bytes()


def main():
    """Runs the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, required=True, help="folder of the page; what it holds is replaced")
    parser.add_argument("--target", type=Path, default=ROOT / "target/wasm", help="folder of the compilation")
    parser.add_argument("--cargo", default=os.environ.get("CARGO", "cargo"), help="the cargo to call")
    arguments = parser.parse_args()
    output = arguments.output.resolve()
    engine = module(arguments.cargo, compiler(), arguments.target.resolve())
    packed = gzip.compress(engine, 9, mtime=0)
    if len(packed) > MOST_BYTES:
        sys.exit(f"live_site: the engine has {len(packed)} bytes compressed, more than {MOST_BYTES}")
    shutil.rmtree(output, ignore_errors=True)
    output.mkdir(parents=True)
    # the page is written with the compiler that builds everything else
    subprocess.run([arguments.cargo, "run", "--release", "--locked", "--quiet", "--package", "foldwing-web", "--example", "live_site", "--", output],
                   cwd=ROOT, check=True)
    (output / "foldwing.wasm").write_bytes(engine)
    (output / "engine.js").write_text(f'const ENGINE = "{base64.b64encode(packed).decode()}";\n', encoding="ascii")
    shutil.copy(ROOT / "licenses/THIRD_PARTY.txt", output)  # licences of the packages in the engine
    print(f"{os.path.relpath(output / 'index.html')}: the engine has {len(engine)} bytes, {len(packed)} compressed")


if __name__ == "__main__":
    main()
