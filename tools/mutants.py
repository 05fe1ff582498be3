#!/usr/bin/env python3
"""Plants small faults in a copy of the sources and checks that the tests find them: `make mutants`.

`tests/mutants/faults.toml` lists the faults as edits of the text, each with the test that finds it. All edits are made in one
copy of the tree, in `target/mutants/tree`, each behind a switch that is turned on by a number in an environment variable, so
that the tests are compiled only once. The sources in git and the shipped libraries have no such switch.

Each finder must pass without a fault and fail with its fault. A fault without a finder fails the target unless it has a
`reason`. `--find` determines finders: every test is run once without a fault to record which faults it reaches, then each fault
is turned on for the tests that reach it, the fastest first.
"""

import argparse
import concurrent.futures
import datetime
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

try:
    import tomllib
except ModuleNotFoundError:  # before Python 3.11
    try:
        import tomli as tomllib
    except ModuleNotFoundError:
        sys.exit("tools/mutants.py: reading tests/mutants/faults.toml needs Python 3.11, or the package tomli")

ROOT = Path(__file__).resolve().parent.parent
LIST = ROOT / "tests/mutants/faults.toml"
ENGINE = "crates/engine/src/"
PACKAGES = ["foldwing", "foldwing-engine", "foldwing-file", "foldwing-fmi", "foldwing-fmu", "foldwing-study", "foldwing-recording", "foldwing-web",
            "foldwing-command", "foldwing-import"]
PROGRAMS = ["verification", "random", "robustness", "documents", "command"]
LIBRARIES = ["foldwing_engine", "foldwing_file", "foldwing_fmi", "foldwing_fmu", "foldwing_study", "foldwing_recording", "foldwing_web", "foldwing_command",
             "foldwing_import"]
# Tests of random calls and of endurance take minutes, and the rules of the repository detect the edits themselves.
SKIPPED = re.compile(r"robustness (random_|mutated_inputs|endurance|watchdog)|documents (architecture|faults)|.*valgrind")
NUMBER, REACHED = "FOLDWING_FAULT", "FOLDWING_FAULTS_REACHED"
SWITCH = '''
/// Planted faults: this copy of the sources is for `tools/mutants.py` only.
pub mod faults {
    use std::io::Write as _;
    use std::sync::OnceLock;
    use std::sync::atomic::{AtomicBool, Ordering};

    static SEEN: [AtomicBool; 4096] = [const { AtomicBool::new(false) }; 4096];

    /// Whether the fault of this number is on. The environment is read once.
    #[inline]
    pub fn on(number: u32) -> bool {
        static SETTING: OnceLock<(u32, Option<std::path::PathBuf>)> = OnceLock::new();
        let setting = SETTING.get_or_init(|| {
            let number = std::env::var("FOLDWING_FAULT").ok().and_then(|text| text.parse().ok()).unwrap_or(0);
            (number, std::env::var_os("FOLDWING_FAULTS_REACHED").map(Into::into))
        });
        if let Some(path) = &setting.1 && !SEEN[number as usize].swap(true, Ordering::Relaxed) {
            let file = std::fs::OpenOptions::new().create(true).append(true).open(path);
            file.and_then(|mut file| file.write_all(format!("{number}\\n").as_bytes())).unwrap();
        }
        setting.0 == number
    }
}
'''


class Trouble(Exception):
    """An error that the reader of the list can resolve."""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("numbers", nargs="*", type=int, help="faults; all without any")
    parser.add_argument("--cargo", default="cargo")
    parser.add_argument("--features", default="", help="features of the test programs, as in `make unit`")
    parser.add_argument("--target", type=Path, default=ROOT / "target", help="folder of cargo; ours is `mutants` in it")
    parser.add_argument("--jobs", type=int, default=2, help="tests at a time")
    parser.add_argument("--as-built", action="store_true", help="take the test programs that the last call compiled, whatever changed since")
    parser.add_argument("--check", action="store_true", help="check the list and the edits, build nothing")
    parser.add_argument("--find", action="store_true", help="look for finders of faults without any (or of those given)")
    parser.add_argument("--reach", action="store_true", help="record again which test reaches which fault")
    parser.add_argument("--only", default="", help="regular expression of `program test`: what --find and --matrix may run")
    parser.add_argument("--budget", type=float, default=300.0, help="--find: seconds of tests for each fault")
    parser.add_argument("--longest", type=float, default=20.0, help="seconds after which a test is left out of --find")
    parser.add_argument("--matrix", action="store_true", help="count for each fault the tests that reach and find it")
    parser.add_argument("--draw", type=int, metavar="COUNT", help="only COUNT faults of those chosen, drawn by --seed")
    parser.add_argument("--seed", type=int, default=datetime.date.today().toordinal(), help="of --draw; today's number without it")
    given = parser.parse_args()
    try:
        run(given)
    except Trouble as trouble:
        sys.exit(f"mutants: {trouble}")


def run(given):
    faults = read_list(LIST)
    texts = edited(faults)
    if given.check:
        print(f"{len(faults)} faults, every edit matches once")
        return
    chosen = [fault for fault in faults if not given.numbers or fault["number"] in given.numbers]
    if given.draw:
        chosen = sorted(random.Random(given.seed).sample(chosen, min(given.draw, len(chosen))), key=lambda fault: fault["number"])
        print(f"seed {given.seed}: faults {' '.join(str(fault['number']) for fault in chosen)}")
    folder = given.target.resolve() / "mutants"
    if not given.as_built:
        copy_tree(folder / "tree", texts)
        reuse_third_party(given.target.resolve(), folder / "build")
        build(given, folder)
    programs = json.loads((folder / "programs.json").read_text(encoding="utf-8"))
    if given.find or given.matrix or given.reach:
        reached = reach(given, faults, programs, folder)
        if given.find:
            find(given, [f for f in chosen if given.numbers or not (f.get("finder") or f.get("reason"))], programs, reached)
        if given.matrix:
            matrix(given, chosen, programs, reached, folder)
    else:
        judge(given, chosen, programs)


def read_list(path):
    """The checked faults of the list: numbers, keys, and at most one of finder and reason."""
    faults = tomllib.loads(path.read_text(encoding="utf-8"))["fault"]
    seen = set()
    for fault in faults:
        number = fault.get("number")
        missing = [key for key in ("number", "file", "old", "new", "what", "equation") if key not in fault]
        if missing:
            raise Trouble(f"fault {number} has no {', '.join(missing)}")
        if number in seen or not 0 < number < 4096:
            raise Trouble(f"fault {number}: the number has to be from 1 to 4095 and no other fault's")
        seen.add(number)
        if f"fault({number})" not in fault["new"]:
            raise Trouble(f"fault {number}: its new text lacks the switch `fault({number})`")
        if fault.get("finder") and fault.get("reason"):
            raise Trouble(f"fault {number} has a finder and a reason why there is none")
    return faults


def edited(faults):
    """The texts, by file, with all faults behind their switches."""
    places = {}
    for fault in faults:
        text = (ROOT / fault["file"]).read_text(encoding="utf-8")
        count = text.count(fault["old"])
        if count != 1:
            raise Trouble(f"fault {fault['number']}: its old text is {count} times in {fault['file']}, not once:\n{fault['old']}")
        begin = text.index(fault["old"])
        places.setdefault(fault["file"], []).append((begin, begin + len(fault["old"]), fault))
    texts = {}
    for file, edits in places.items():
        text = (ROOT / file).read_text(encoding="utf-8")
        edits.sort(key=lambda edit: edit[0])
        for (_, end, one), (begin, _, other) in zip(edits, edits[1:]):
            if begin < end:
                raise Trouble(f"faults {one['number']} and {other['number']} edit the same text of {file}")
        switch = "crate::faults::on" if file.startswith(ENGINE) else "foldwing_engine::faults::on"
        for begin, end, fault in reversed(edits):
            new = re.sub(r"\bfault\((\d+)\)", lambda match: f"{switch}({match[1]})", fault["new"])
            text = text[:begin] + new + text[end:]
        texts[file] = text
    library = ENGINE + "lib.rs"
    texts[library] = texts.get(library, (ROOT / library).read_text(encoding="utf-8")) + SWITCH
    return texts


def copy_tree(tree, texts):
    """Copies the files tracked by git, with the edits. Unchanged files keep their times, so that cargo does not rebuild them."""
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=ROOT,
                            check=True, capture_output=True).stdout
    every = [name for name in listed.decode().split("\0") if name]
    names = {name for name in every if (ROOT / name).is_file()}
    for name in every:
        # a link to a folder, such as that of the examples in the command; links to files are copied as files
        link = tree / name
        if (ROOT / name).is_symlink() and (ROOT / name).is_dir() and not link.is_symlink():
            link.parent.mkdir(parents=True, exist_ok=True)
            link.symlink_to(os.readlink(ROOT / name))
    for name in names:
        content = texts[name].encode() if name in texts else (ROOT / name).read_bytes()
        target = tree / name
        if not target.exists() or target.read_bytes() != content:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)
            shutil.copymode(ROOT / name, target)
    for path in tree.rglob("*"):
        if path.is_file() and str(path.relative_to(tree)) not in names:
            path.unlink()


def reuse_third_party(target, output):
    """Reuses third-party libraries that the tests of the sources have compiled. Cargo recompiles those that do not match."""
    if output.exists() or not (target / "debug/deps").is_dir():
        return
    for part in (".fingerprint", "build", "deps"):
        (output / "debug" / part).mkdir(parents=True)
        for entry in (target / "debug" / part).iterdir():
            ours = re.match(r"(lib)?foldwing", entry.name)
            if entry.is_dir() and not ours:
                shutil.copytree(entry, output / "debug" / part / entry.name, symlinks=True)
            elif not ours and entry.suffix in {".rlib", ".rmeta", ".so", ".d"}:
                shutil.copy2(entry, output / "debug" / part / entry.name)


def build(given, folder):
    """Compiles the test programs with all faults behind their switches, and records their paths and the folder in which each runs."""
    begin = time.monotonic()
    command = [given.cargo, "test", "--locked", "--no-run", "--message-format", "json-render-diagnostics", "--lib"]
    command += [word for package in PACKAGES for word in ("--package", package)]
    command += [word for program in PROGRAMS for word in ("--test", program)]
    command += ["--features", given.features] if given.features else []
    environment = {**os.environ, "CARGO_TARGET_DIR": str(folder / "build")}
    done = subprocess.run(command, cwd=folder / "tree", env=environment, stdout=subprocess.PIPE, text=True)
    if done.returncode:
        raise Trouble("the copy with the faults does not compile")
    programs = {}
    for line in done.stdout.splitlines():
        message = json.loads(line)
        if message.get("reason") == "compiler-artifact" and message.get("executable") and message["profile"]["test"]:
            programs[message["target"]["name"]] = [message["executable"], str(Path(message["manifest_path"]).parent)]
    print(f"compiled in {time.monotonic() - begin:.0f} s", flush=True)
    found = {name: programs[name] for name in LIBRARIES + PROGRAMS}
    (folder / "programs.json").write_text(json.dumps(found, indent=1), encoding="utf-8")


def try_test(programs, test, environment, limit_s):
    """Runs `program test` alone; returns "passed", "failed", "late" or "missing", and its time in s."""
    program, name = test.split(" ", 1)
    executable, folder = programs[program]
    begin = time.monotonic()
    kept = {key: value for key, value in os.environ.items() if key not in (NUMBER, REACHED)}
    with tempfile.TemporaryFile() as output:
        process = subprocess.Popen([executable, "--exact", name, "--test-threads", "1"], cwd=folder, stdin=subprocess.DEVNULL,
                                   stdout=output, stderr=subprocess.STDOUT, env={**kept, **environment}, start_new_session=True)
        try:
            process.wait(limit_s)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, 9)
            process.wait()
            return "late", time.monotonic() - begin
        seconds = time.monotonic() - begin
        output.seek(0)
        if process.returncode == 0:
            return ("passed" if b" 1 passed" in output.read() else "missing"), seconds
        return "failed", seconds


def all_tests(given, programs):
    for program, (executable, folder) in programs.items():
        listed = subprocess.run([executable, "--list", "--format", "terse"], cwd=folder, check=True, capture_output=True, text=True)
        for line in listed.stdout.splitlines():
            test = f"{program} {line.removesuffix(': test')}"
            if line.endswith(": test") and not SKIPPED.match(test):
                yield test


def reach(given, faults, programs, folder):
    """For every test, its time in s without a fault and the numbers of the faults that it reaches."""
    record = folder / "reached.json"
    numbers = {fault["number"] for fault in faults}
    known = json.loads(record.read_text(encoding="utf-8")) if record.exists() and not given.reach else {"faults": [], "tests": {}}
    if not numbers <= set(known["faults"]):
        known = {"faults": sorted(numbers), "tests": {}}
    new = [test for test in all_tests(given, programs) if known["tests"].get(test, {}).get("verdict") not in ("passed", "late", "missing")]
    wanted = [test for test in new if re.search(given.only, test)]

    def one(test):
        with tempfile.TemporaryDirectory() as scratch:
            path = Path(scratch, "reached")
            path.touch()
            verdict, seconds = try_test(programs, test, {REACHED: str(path)}, given.longest)
            return test, verdict, seconds, sorted({int(line) for line in path.read_text(encoding="utf-8").split()})

    with concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
        for count, (test, verdict, seconds, reached) in enumerate(pool.map(one, wanted), 1):
            known["tests"][test] = {"verdict": verdict, "seconds": round(seconds, 3), "reached": reached}
            if count % 50 == 0 or count == len(wanted):
                record.write_text(json.dumps(known, indent=0), encoding="utf-8")
                print(f"{count} of {len(wanted)} tests: what they reach", flush=True)
    for test, found in known["tests"].items():
        if found["verdict"] in ("failed", "late"):
            print(f"left out, {found['verdict']} without a fault: {test}")
    return {test: found for test, found in known["tests"].items() if found["verdict"] == "passed" and re.search(given.only, test)}


def finds(programs, test, number, seconds):
    """Whether the test fails with this fault turned on. A test that does not end in time is not a finder."""
    return try_test(programs, test, {NUMBER: str(number)}, 20.0 + 20.0 * seconds)[0] == "failed"


def find(given, faults, programs, reached):
    """Determines the fastest test that finds each fault, and writes it into the list."""
    def one(fault):
        number, spent = fault["number"], 0.0
        tests = sorted((test for test, found in reached.items() if number in found["reached"]), key=lambda test: reached[test]["seconds"])
        for tried, test in enumerate(tests, 1):
            begin = time.monotonic()
            if finds(programs, test, number, reached[test]["seconds"]):
                return fault, test, tried, len(tests)
            spent += time.monotonic() - begin
            if spent > given.budget:
                return fault, None, tried, len(tests)
        return fault, None, len(tests), len(tests)

    with concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
        for done in concurrent.futures.as_completed([pool.submit(one, fault) for fault in faults]):
            fault, test, tried, count = done.result()
            print(f"fault {fault['number']}: {test or 'survives'} ({tried} of {count} tests that reach it)", flush=True)
            if test:
                record_finder(LIST, fault["number"], test)


def record_finder(path, number, test):
    """Replaces the finder of one fault and leaves the rest of the list unchanged."""
    text = path.read_text(encoding="utf-8")
    begin = re.search(rf"^number = {number}$", text, re.M).end()
    end = text.find("[[fault]]", begin)
    block = text[begin:] if end < 0 else text[begin:end]
    block = re.sub(r"^(finder|pending|reason) = .*\n", "", block, flags=re.M).rstrip("\n")
    text = text[:begin] + block + f'\nfinder = "{test}"\n' + ("" if end < 0 else "\n" + text[end:])
    path.write_text(text, encoding="utf-8")


def matrix(given, faults, programs, reached, folder):
    """Runs each fault with every test that reaches it: target/mutants/matrix.csv."""
    lines = ["fault,reached by,found by,fastest finder,all finders"]
    for fault in faults:
        tests = [test for test, found in reached.items() if fault["number"] in found["reached"]]
        with concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
            verdicts = list(pool.map(lambda test: finds(programs, test, fault["number"], reached[test]["seconds"]), tests))
        found = sorted((t for t, verdict in zip(tests, verdicts) if verdict), key=lambda test: reached[test]["seconds"])
        lines.append(f"{fault['number']},{len(tests)},{len(found)},{found[0] if found else ''},{' | '.join(found)}")
        print(f"fault {fault['number']}: {len(found)} of {len(tests)} tests that reach it find it", flush=True)
        (folder / "matrix.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


def judge(given, faults, programs):
    """Checks that every finder passes without a fault and fails with its fault."""
    begin = time.monotonic()
    with_finder = [fault for fault in faults if fault.get("finder")]
    finders = sorted({fault["finder"] for fault in with_finder})
    wrong = [f"fault {f['number']}: no test finds it, and no reason is given: {f['what']} (missing: {f.get('pending') or 'a test'})"
             for f in faults if not f.get("finder") and not f.get("reason")]
    for finder in finders:
        if finder.split(" ", 1)[0] not in programs:
            raise Trouble(f"finder \"{finder}\": its first word has to be one of {', '.join(programs)}")
    seconds = {}
    with concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
        for finder, (verdict, took) in zip(finders, pool.map(lambda test: try_test(programs, test, {}, 120.0), finders)):
            seconds[finder] = took
            if verdict != "passed":
                wrong.append(f"finder {verdict} without a fault: {finder}")
        outcomes = pool.map(lambda f: try_test(programs, f["finder"], {NUMBER: str(f["number"])}, 20.0 + 20.0 * seconds[f["finder"]]),
                            with_finder)
        for fault, (verdict, _) in zip(with_finder, outcomes):
            if verdict != "failed":
                wrong.append(f"fault {fault['number']} is not found ({fault['finder']} {verdict}): {fault['what']}")
    survivors = [fault for fault in faults if fault.get("reason")]
    print(f"{len(faults)} faults: {len(with_finder)} with a finder, {len(survivors)} survive with a reason; "
          f"tests took {time.monotonic() - begin:.0f} s")
    for fault in survivors:
        print(f"  {fault['number']}: {fault['what']}: {fault['reason']}")
    if wrong:
        raise Trouble("\n".join([f"{len(wrong)} of them wrong"] + wrong))


if __name__ == "__main__":
    main()
