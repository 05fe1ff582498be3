"""The libraries for ARM64 Linux and macOS that `make fmu-all` builds on request: results under emulation, headers, exports, signatures.

`make test-platforms FMU_PLATFORMS="linux64 win64 aarch64-linux darwin64 aarch64-darwin"` builds them and runs this; the tests of a
library that was not built are skipped. Those for macOS are not run: there is no emulator.
"""

import os
import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import mach_o
import pytest
from driving import Fmu
from test_platforms import FUNCTIONS, MODEL, ROOT, compare, need, package, tool, unpack

ROOT_OF_ARM64 = Path("/usr/aarch64-linux-gnu")  # of Debian's libc6-arm64-cross
MACOS = {"darwin64": ("x86_64", (10, 12), "x86_64-darwin"), "aarch64-darwin": ("arm64", (11, 0), "aarch64-darwin")}
STEPS, STEP_S = 400, 1e-3


@pytest.fixture(scope="module")
def built():
    """Path of a platform's library; skips the test if it was not built."""
    platforms = Path(os.environ.get("FOLDWING_PLATFORMS", ROOT / "target/platforms"))

    def path(platform):
        name = "libfoldwing_fmu.dylib" if "darwin" in platform else "libfoldwing_fmu.so"
        found = platforms / platform / name
        if not found.is_file():
            pytest.skip(f"{found}: not built; `make fmu-all FMU_PLATFORMS={platform}` builds it")
        return found

    path.platforms = platforms
    return path


@pytest.fixture(scope="module")
def drivers(built, tmp_path_factory):
    """Commands that start the importer of run_library.c on this computer and on an emulated ARM64 processor; skips if there is no library."""
    built("aarch64-linux")
    emulator = need(shutil.which("qemu-aarch64") or shutil.which("qemu-aarch64-static"), "qemu-aarch64 (Debian: qemu-user)")
    need((ROOT_OF_ARM64 / "lib/ld-linux-aarch64.so.1").is_file(), f"{ROOT_OF_ARM64}/lib/ld-linux-aarch64.so.1 (Debian: libc6-arm64-cross)")
    zig = need(shutil.which("python-zig", path=built.platforms / "venv/bin"), "Zig in the environment of `make fmu-all`")
    folder = tmp_path_factory.mktemp("drivers")
    for name, target in [("here", "x86_64-linux-gnu.2.17"), ("there", "aarch64-linux-gnu.2.17")]:
        source = Path(__file__).with_name("run_library.c")
        subprocess.run([zig, "cc", "-target", target, "-O1", source, "-o", folder / name, "-ldl"], check=True)
    return {"linux64": [folder / "here"], "aarch64-linux": [emulator, "-L", ROOT_OF_ARM64, folder / "there"]}


def run(drivers, platform, fmu, references, mode, steps=STEPS):
    """Rows of values of a run on one platform, and what the importer prints besides."""
    library, uri = f"{fmu.folder}/binaries/{platform}/foldwing.so", (Path(fmu.folder) / "resources").as_uri()
    command = [*drivers[platform], library, uri, fmu.description.guid, str(STEP_S), str(steps), mode]
    outcome = subprocess.run(command, input="\n".join(map(str, references)), capture_output=True, text=True)
    assert outcome.returncode == 0, outcome.stderr
    return unpack(outcome.stdout), outcome.stderr.strip()


@pytest.mark.parametrize("model", ["folding_wing", "folding_wing_constant", "three_bodies", "folding_wing_in_tunnel"])
def test_n12_arm64_library_computes_what_the_x86_library_computes(model, foldwing, built, drivers, tmp_path):
    """N-12. The ARM64 library on an emulated processor against the x86-64 library, 0.4 s in steps of 1 ms, past the latch, with the same
    importer: limits as in N-07. The lattice of the last model uses the vectors of each processor, with other orders of its sums. On both, the
    second half repeated from a state saved as bytes is the same bit for bit."""
    libraries = {platform: built(platform) for platform in ("linux64", "aarch64-linux")}
    fmu = Fmu(package(foldwing, libraries, tmp_path / "both.fmu", model), tmp_path / "unpacked")
    reals = [variable for variable in fmu.outputs if variable.type == "Real"]
    found = {}
    for platform in libraries:
        rows, remark = run(drivers, platform, fmu, [variable.valueReference for variable in reals], "again")
        assert [len(row) for row in rows] == [len(reals)] * (STEPS + 1 + STEPS // 2)
        assert rows[STEPS // 2 + 1 : STEPS + 1] == rows[STEPS + 1 :], f"{platform}: a restored state continues otherwise"
        assert rows[STEPS // 2] != rows[STEPS], "the machine moves in the second half"
        found[platform] = rows[: STEPS + 1]
    latches = [i for i, variable in enumerate(reals) if variable.name.endswith(".latch_time")]
    for i in latches:
        times = [found[platform][-1][i] for platform in libraries]
        print(f"{model}: {reals[i].name} {times[0]:.9f} s, difference {times[1] - times[0]:.1e} s")
    if model == MODEL:
        assert latches and all(0.0 < found[platform][-1][i] < STEPS * STEP_S for platform in libraries for i in latches), "it latches"
    compare(model, found["linux64"], found["aarch64-linux"], reals, remark)


@pytest.mark.parametrize("model", ["folding_wing", "three_bodies", "flared_wing_tip"])
def test_n13_arm64_library_has_the_derivatives_of_the_x86_library(model, foldwing, built, drivers, tmp_path):
    """N-13. Model Exchange: derivatives of all states at the start and at 20 states beside it agree to 1e-9 of the largest derivative of
    the same quantity in the same row: the solution for the accelerations multiplies round-off by the condition of the mass matrix."""
    libraries = {platform: built(platform) for platform in ("linux64", "aarch64-linux")}
    options = ["--interface", "cs,me", "--no-reference"]
    fmu = Fmu(package(foldwing, libraries, tmp_path / "both.fmu", model, options), tmp_path / "unpacked")
    derivatives = [variable.variable for variable in fmu.description.derivatives]
    references = [variable.valueReference for variable in derivatives]
    here, there = (run(drivers, platform, fmu, references, "rates", 20)[0] for platform in libraries)
    assert [len(row) for row in here] == [len(row) for row in there] == [len(references)] * 21
    assert all(left != here[0] for left in here[1:]), "other states have other derivatives"
    worst = (0.0, "")
    for left, right in zip(here, there):
        scale = {}
        for value, variable in zip(left, derivatives):
            kind = variable.declaredType.name if variable.declaredType else variable.unit
            scale[kind] = max(scale.get(kind, 0.0), abs(value))
        for a, b, variable in zip(left, right, derivatives):
            kind = variable.declaredType.name if variable.declaredType else variable.unit
            worst = max(worst, (abs(a - b) / max(scale[kind], 1e-9), variable.name))
    equal = sum(a == b for left, right in zip(here, there) for a, b in zip(left, right))
    print(f"{model}: {equal} of {21 * len(references)} derivatives equal bit for bit; largest difference {worst[0]:.1e} ({worst[1]})")
    assert worst[0] <= 1e-9, worst


def test_n11_arm64_library_needs_glibc_of_2012_and_exports_the_standard(built):
    """N-11. The ARM64 library: its processor, the symbols of glibc (2.17 is the first with ARM64), the exported functions."""
    readelf, library = tool("readelf"), built("aarch64-linux")
    header = subprocess.run([readelf, "-h", library], check=True, capture_output=True, text=True).stdout
    assert re.search(r"Machine:\s+AArch64", header) and re.search(r"Type:\s+DYN", header)
    symbols = subprocess.run([readelf, "--dyn-syms", "-W", library], check=True, capture_output=True, text=True).stdout
    versions = {tuple(map(int, found.split("."))) for found in re.findall(r"@GLIBC_([\d.]+)", symbols)}
    print("newest symbol of glibc:", ".".join(map(str, max(versions))))
    assert max(versions) <= (2, 17)
    defined = {line.split()[7] for line in symbols.splitlines() if re.search(r"FUNC +GLOBAL +DEFAULT +\d+ ", line)}
    assert defined == FUNCTIONS
    needed = re.findall(r"\(NEEDED\).*\[(.*)\]", subprocess.run([readelf, "-dW", library], check=True, capture_output=True, text=True).stdout)
    print("needs", " ".join(needed))
    assert set(needed) <= {f"lib{name}.so.{n}" for name, n in [("c", 6), ("m", 6), ("dl", 2), ("pthread", 0), ("rt", 1)]} | {"ld-linux-aarch64.so.1"}


@pytest.mark.parametrize("platform", MACOS)
def test_n14_macos_library_is_one_that_macos_can_load_by_its_header(platform, built):
    """N-14. Libraries for macOS, not run: the processor, the oldest system, a relative install name, libraries of the system only, exactly
    the functions of the standard in the table and in the tree of exports, and an ad-hoc signature whose hashes fit (ARM64 needs one)."""
    content = built(platform).read_bytes()
    library, (processor, oldest, _) = mach_o.read(content), MACOS[platform]
    print(f"{platform}: {len(content)} bytes, macOS {library.oldest_macos}, name {library.name}, needs {library.needed}, paths {library.run_paths}")
    assert (library.processor, library.kind) == (processor, mach_o.DYLIB)
    assert library.oldest_macos == oldest
    assert library.name == "@rpath/libfoldwing_fmu.dylib"
    assert library.needed == ["/usr/lib/libSystem.B.dylib"] and library.run_paths == []
    assert library.exported == {f"_{name}" for name in FUNCTIONS}
    assert library.defined == library.exported
    assert mach_o.signature_faults(content, library) == []
    changed = bytearray(content)
    changed[5000] ^= 1  # pages have 4096 bytes
    assert mach_o.signature_faults(bytes(changed), library) == ["page 1 differs from its hash"]


@pytest.mark.parametrize("platform", ["aarch64-linux", *MACOS])
def test_n15_archive_holds_the_library_in_its_folder(platform, foldwing, built, tmp_path):
    """N-15. `package` accepts the library by its header, and puts it unchanged into the platform's folder of FMI 2.0 and of FMI 3.0; it
    contains no path of this computer and is rejected for another platform."""
    library = built(platform)
    extension = library.suffix
    for version, folder in [("2", platform), ("3", MACOS[platform][2] if platform in MACOS else platform)]:
        path = package(foldwing, {platform: library}, tmp_path / f"{version}.fmu", options=["--fmi", version, "--no-reference"])
        with zipfile.ZipFile(path) as archive:
            assert [name for name in archive.namelist() if name.startswith("binaries/") and not name.endswith("/")] == [f"binaries/{folder}/foldwing{extension}"]
            assert archive.read(f"binaries/{folder}/foldwing{extension}") == library.read_bytes()
        print(f"{platform}, FMI {version}: {path.stat().st_size} bytes")
    command = [foldwing, "package", ROOT / f"examples/models/{MODEL}.toml", "-o", tmp_path / "x.fmu", f"--library=linux64={library}"]
    outcome = subprocess.run(command, capture_output=True, text=True)
    assert outcome.returncode == 1 and f"the library is for {platform}, not for linux64" in outcome.stderr
    cargo = Path(os.environ.get("CARGO_HOME", Path.home() / ".cargo"))
    paths = [ROOT, cargo, *({Path.home()} - {Path("/")}), "/usr/lib/rustlib", "/usr/src/rustc"]
    content = library.read_bytes()
    assert b"crates/fmi/src/fmi2" in content or b"crates/engine/src/run" in content, "messages name the sources, so the search can find"
    assert [str(path) for path in paths if os.fsencode(f"{path}/") in content] == []
