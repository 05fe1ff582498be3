//! Many instances at once, many steps, and importers that end without freeing instances.
//!
//! Tests of whole processes start this program again with one of the ignored tests `child_…`.

use crate::fmu::{Fmu, Resources, WING, guid_of, table};
use foldwing_fmu::functions::*;
use foldwing_fmu::states::*;
use foldwing_fmu::types::*;
use std::ffi::CString;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::ptr;
use std::time::Duration;

/// The model in the tunnel with few panels, and a pool of two threads.
fn tunnel() -> String {
    include_str!("../../examples/models/folding_wing_in_tunnel.toml")
        .replace("strips = 10", "strips = 3")
        .replace("chord_panels = 4", "chord_panels = 2")
        .replace("wake_rows = 30", "wake_rows = 4\nthreads = 2")
}

fn number(name: &str) -> Option<usize> {
    std::env::var(name).ok().map(|text| text.parse().unwrap_or_else(|_| panic!("{name}={text} is no number")))
}

/// An instance after its initialisation.
fn running(text: &str) -> Fmu {
    let fmu = Fmu::new(text);
    fmu.setup(0.0, None);
    unsafe {
        fmu.ok(fmi2EnterInitializationMode(fmu.component));
        fmu.ok(fmi2ExitInitializationMode(fmu.component));
    }
    fmu
}

/// One of 30 steps through the latch, with an input that jumps.
fn step(fmu: &Fmu, i: u32) {
    fmu.set("fold.external_torque", if i.is_multiple_of(4) { 0.01 } else { 0.0 });
    fmu.step(5e-3 * f64::from(i), 5e-3);
}

/// Every Real after those steps.
fn unfold(fmu: &Fmu) -> Vec<u64> {
    (0..30).for_each(|i| step(fmu, i));
    fmu.bits()
}

/// D-01. 64 instances in 8 threads, eight of them with a lattice and a separate pool, stepped alternately: results are bit-identical to
/// those of a single instance.
#[test]
fn d01_sixty_four_instances_in_eight_threads() {
    let models = [WING.to_owned(), tunnel()];
    let expected = models.clone().map(|model| unfold(&running(&model)));
    std::thread::scope(|scope| {
        for thread in 0..8 {
            let (models, expected) = (&models, &expected);
            scope.spawn(move || {
                let kinds: Vec<usize> = (0..8).map(|i| usize::from(i == thread)).collect();
                let fmus: Vec<Fmu> = kinds.iter().map(|&kind| running(&models[kind])).collect();
                (0..30).for_each(|i| fmus.iter().for_each(|fmu| step(fmu, i)));
                for (fmu, kind) in fmus.iter().zip(kinds) {
                    assert!(fmu.bits() == expected[kind], "thread {thread}, model {kind}");
                }
            });
        }
    });
}

/// Starts this program again with one of its ignored tests, in an empty folder and with a separate folder for temporary files.
fn child(name: &str, place: &Resources, settings: &[(&str, &str)]) -> Command {
    let [here, temporary] = folders(place);
    for folder in [&here, &temporary] {
        std::fs::create_dir_all(folder).expect("writable");
    }
    let mut command = Command::new(std::env::current_exe().expect("a path"));
    command
        .args(["--exact", &format!("endurance::{name}"), "--ignored", "--nocapture", "--test-threads=1"])
        .current_dir(here)
        .env("TMPDIR", &temporary)
        .env("FOLDWING_RESOURCES", place.folder.join("resources"))
        .envs(settings.iter().copied())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

fn folders(place: &Resources) -> [PathBuf; 2] {
    ["here", "temporary"].map(|name| place.folder.join(name))
}

/// Folders of a child process, and the resources of a model.
fn place(model: &str) -> Resources {
    let place = Resources::empty("child");
    let resources = place.folder.join("resources");
    std::fs::create_dir_all(&resources).expect("writable");
    std::fs::write(resources.join("model.toml"), model).expect("writable");
    place
}

/// Output of a child after the word `result`, at its end.
fn result(mut command: Command) -> String {
    let output = command.output().expect("starts");
    let told = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{}\n{told}\n{}", output.status, String::from_utf8_lossy(&output.stderr));
    let line = told.lines().find_map(|line| line.split_once("result ")).unwrap_or_else(|| panic!("no result: {told}"));
    line.1.to_owned()
}

/// The model of a child process; `None` if this process is not one.
fn model_of_child() -> Option<String> {
    let folder = std::env::var("FOLDWING_RESOURCES").ok()?;
    Some(std::fs::read_to_string(Path::new(&folder).join("model.toml")).expect("readable"))
}

/// Resident anonymous memory of this process in kilobytes: heap and stacks. Counted page by page, because `VmRSS` of `status` can lag by
/// some hundred kilobytes on many processors, and also counts pages of the program itself, which are loaded when a line runs for the first
/// time.
fn anonymous_kb() -> i64 {
    let memory = std::fs::read_to_string("/proc/self/smaps").expect("Linux");
    let lines = memory.lines().filter_map(|line| line.strip_prefix("Anonymous:"));
    lines.map(|text| text.trim_end_matches("kB").trim().parse::<i64>().expect("a number")).sum()
}

/// D-02. A latched wing for `FOLDWING_STEPS` steps, with inputs set and outputs read in each, states saved, serialised, restored and freed,
/// and rejected calls in between: memory use after all steps equals that after a tenth of them.
#[test]
#[cfg_attr(not(target_os = "linux"), ignore = "memory is read from /proc")]
fn d02_flat_memory() {
    let steps = number("FOLDWING_STEPS").unwrap_or(20_000).to_string();
    let told = result(child("child_steps_for_long", &place(WING), &[("FOLDWING_STEPS", &steps)]));
    let numbers: Vec<i64> = told.split_whitespace().map(|number| number.parse().expect("a number")).collect();
    let [tenth_kb, all_kb] = numbers.as_slice() else { panic!("{told}") };
    println!("{steps} steps: {tenth_kb} kB after a tenth, {all_kb} kB after all");
    // a few pages of the allocator, but no growth with the steps: a leak of 1 byte per step would be 900 kB for 10⁶ steps
    assert!(all_kb - tenth_kb <= 128, "{tenth_kb} kB, then {all_kb} kB");
}

#[test]
#[ignore = "a process of its own, started by d02"]
fn child_steps_for_long() {
    let Some(model) = model_of_child() else { return };
    let steps = number("FOLDWING_STEPS").expect("a number");
    let fmu = running(&model);
    fmu.step(0.0, 0.2);
    assert!(fmu.get_boolean("fold.latched"));
    let (torque, tip) = (fmu.reference("fold.external_torque"), fmu.reference("tip.position.z"));
    let mut tenth_kb = 0;
    let mut value = 0.0;
    for i in 0..steps {
        let time_s = 0.2 + 1e-3 * i as f64;
        unsafe {
            if i.is_multiple_of(50) {
                fmu.ok(fmi2SetReal(fmu.component, &torque, 1, &(1e-3 * (i % 7) as f64)));
            }
            fmu.ok(fmi2DoStep(fmu.component, time_s, 1e-3, fmi2True));
            fmu.ok(fmi2GetReal(fmu.component, &tip, 1, &mut value));
            if i.is_multiple_of(100) {
                let mut state = fmu.save();
                let (status, mut copy) = fmu.deserialize(&fmu.serialize(state));
                fmu.ok(status);
                fmu.ok(fmi2SetFMUstate(fmu.component, copy));
                fmu.ok(fmi2FreeFMUstate(fmu.component, &mut state));
                fmu.ok(fmi2FreeFMUstate(fmu.component, &mut copy));
                assert_eq!(fmi2SetReal(fmu.component, &torque, 1, &f64::NAN), fmi2Discard);
                fmu.messages.borrow_mut().clear();
            }
        }
        if i == steps / 20 {
            anonymous_kb(); // allocates the memory for reading before it counts
        }
        if i == steps / 10 {
            tenth_kb = anonymous_kb();
        }
    }
    assert!(fmu.get_boolean("fold.latched") && value.is_finite());
    println!("result {tenth_kb} {}", anonymous_kb());
}

/// Waits until a child process reports that it is stepping.
fn wait_for_steps(child: &mut Child) {
    let mut told = BufReader::new(child.stdout.take().expect("piped"));
    let mut line = String::new();
    while !line.contains("stepping") {
        line.clear();
        assert!(told.read_line(&mut line).expect("readable") > 0, "the child has ended early");
    }
}

/// D-03. The importer is killed in the middle of a step, at `FOLDWING_KILLS` random moments: no file or lock remains, and the next run with
/// the same resources gives the same results as the first.
#[test]
fn d03_killed_importers() {
    for model in [WING.to_owned(), tunnel()] {
        let place = place(&model);
        let before = result(child("child_unfolds", &place, &[]));
        let seed = number("FOLDWING_SEED").unwrap_or(3) as u64;
        println!("FOLDWING_SEED={seed}");
        let mut rng = fastrand::Rng::with_seed(seed);
        for kill in 0..number("FOLDWING_KILLS").unwrap_or(4) {
            let mut running = child("child_steps_for_ever", &place, &[]).spawn().expect("starts");
            wait_for_steps(&mut running);
            std::thread::sleep(Duration::from_micros(rng.u64(..20_000)));
            running.kill().expect("still there");
            let status = running.wait().expect("ends");
            assert!(!status.success(), "kill {kill} of seed {seed}: {status}");
            for folder in folders(&place) {
                let left: Vec<_> = std::fs::read_dir(&folder).expect("readable").collect();
                assert!(left.is_empty(), "kill {kill} of seed {seed} left {left:?}");
            }
        }
        let resources = place.folder.join("resources");
        let files: Vec<_> =
            std::fs::read_dir(&resources).expect("readable").map(|file| file.expect("readable").file_name()).collect();
        assert_eq!(files, ["model.toml"]);
        assert_eq!(std::fs::read_to_string(resources.join("model.toml")).expect("readable"), model);
        assert_eq!(result(child("child_unfolds", &place, &[])), before, "after the kills");
    }
}

#[test]
#[ignore = "a process of its own, started by d03"]
fn child_steps_for_ever() {
    let Some(model) = model_of_child() else { return };
    let fmu = running(&model);
    println!("stepping");
    std::io::stdout().flush().expect("told");
    for i in 0.. {
        fmu.set("fold.external_torque", 1e-3 * f64::from(i % 7));
        fmu.step(1e-3 * f64::from(i), 1e-3);
    }
}

#[test]
#[ignore = "a process of its own, started by d03"]
fn child_unfolds() {
    let Some(model) = model_of_child() else { return };
    println!("result {:x?}", unfold(&running(&model)));
}

/// D-04. A process that ends without freeing its instances and their states ends with its regular exit code.
#[test]
fn d04_exit_without_freeing() {
    for model in [WING.to_owned(), tunnel()] {
        let output = child("child_exits", &place(&model), &[]).output().expect("starts");
        assert_eq!(output.status.code(), Some(42), "{}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
#[ignore = "a process of its own, started by d04"]
fn child_exits() {
    let Some(model) = model_of_child() else { return };
    let fmus = [running(&model), running(&model)];
    fmus.iter().for_each(|fmu| step(fmu, 0));
    fmus[0].save();
    std::process::exit(42);
}

type Instantiate = unsafe extern "C" fn(
    fmi2String,
    fmi2Type,
    fmi2String,
    fmi2String,
    *const fmi2CallbackFunctions,
    fmi2Boolean,
    fmi2Boolean,
) -> fmi2Component;
type OnInstance = unsafe extern "C" fn(fmi2Component) -> fmi2Status;
type DoStep = unsafe extern "C" fn(fmi2Component, fmi2Real, fmi2Real, fmi2Boolean) -> fmi2Status;
type GetReal = unsafe extern "C" fn(fmi2Component, *const fmi2ValueReference, usize, *mut fmi2Real) -> fmi2Status;
type FreeInstance = unsafe extern "C" fn(fmi2Component);

/// The shared library, loaded as by an importer.
fn load() -> libloading::Library {
    let tests = std::env::current_exe().expect("a path");
    let name = format!("{}foldwing_fmu{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let path = tests.with_file_name(name); // Cargo builds the library next to its tests
    // SAFETY: our own library, without initialisers.
    unsafe { libloading::Library::new(&path) }.unwrap_or_else(|error| panic!("{path:?}: {error}"))
}

/// An instance of the loaded library after a few steps, and bits of its outputs.
fn step_loaded(library: &libloading::Library, model: &str) -> (fmi2Component, Vec<u64>) {
    let folder = CString::new(std::env::var("FOLDWING_RESOURCES").expect("a child")).expect("no zero");
    let guid = CString::new(guid_of(model)).expect("no zero");
    // SAFETY: the functions have these types.
    unsafe {
        let instantiate = library.get::<Instantiate>(b"fmi2Instantiate").expect("exported");
        let c = instantiate(c"wing".as_ptr(), 1, guid.as_ptr(), folder.as_ptr(), ptr::null(), 0, 0);
        assert!(!c.is_null());
        for name in [&b"fmi2EnterInitializationMode"[..], b"fmi2ExitInitializationMode"] {
            assert_eq!(library.get::<OnInstance>(name).expect("exported")(c), fmi2OK);
        }
        let do_step = library.get::<DoStep>(b"fmi2DoStep").expect("exported");
        (0..10).for_each(|i| assert_eq!(do_step(c, 5e-3 * f64::from(i), 5e-3, 1), fmi2OK));
        let known = table(model);
        let references = ["fold.angle", "tip.position.z", "root.moment.y"]
            .map(|name| known.find(name).expect("a variable").value_reference);
        let mut values = [0.0_f64; 3];
        let get = library.get::<GetReal>(b"fmi2GetReal").expect("exported");
        assert_eq!(get(c, references.as_ptr(), 3, values.as_mut_ptr()), fmi2OK);
        assert!(values.iter().all(|value| *value != 0.0), "{values:?}");
        (c, values.map(f64::to_bits).to_vec())
    }
}

/// D-05. The library is unloaded, after its instances were freed or while they still exist with the threads of a lattice, and loaded again:
/// the same results and no crash, also at the end of the process.
#[test]
fn d05_unloading() {
    for model in [WING.to_owned(), tunnel()] {
        for leaves in ["frees", "leaves"] {
            let told = result(child("child_unloads", &place(&model), &[("FOLDWING_UNLOAD", leaves)]));
            assert_eq!(told, "the same three times", "{leaves}");
        }
    }
}

#[test]
#[ignore = "a process of its own, started by d05"]
fn child_unloads() {
    let Some(model) = model_of_child() else { return };
    let frees = std::env::var("FOLDWING_UNLOAD").as_deref() == Ok("frees");
    let mut results = Vec::new();
    for _ in 0..3 {
        let library = load();
        let (component, bits) = step_loaded(&library, &model);
        results.push(bits);
        if frees {
            // SAFETY: alive, freed once.
            unsafe { library.get::<FreeInstance>(b"fmi2FreeInstance").expect("exported")(component) };
        }
        library.close().expect("closes");
        std::thread::sleep(Duration::from_millis(20)); // time for threads that would execute unloaded code
    }
    assert!(results.iter().all(|bits| *bits == results[0]));
    println!("result the same three times");
}

/// D-08. Loading, running, freeing and unloading 200 times leaves nothing behind. The increase of the resident memory over 180 of these
/// cycles is below 2 MiB, 11 KiB each, because allocators return memory in larger pieces; a schema alone took 268 KiB per cycle. A lattice
/// with threads keeps the library loaded once: its threads must end before it is unloaded.
#[test]
#[ignore = "long; `make long` runs it"]
#[cfg(target_os = "linux")]
fn d08_unloaded_libraries_leave_nothing() {
    for (model, threads) in [(WING.to_owned(), false), (tunnel(), true)] {
        let told = result(child("child_loads_and_unloads", &place(&model), &[]));
        let (grown_kb, mapped) = told.split_once(' ').expect("two numbers");
        println!("D-08 {grown_kb} kB after 180 cycles");
        assert!(grown_kb.parse::<i64>().expect("kB") < 2048, "{grown_kb} kB");
        assert!(threads || mapped == "0", "the library is still mapped");
    }
}

#[test]
#[cfg(target_os = "linux")]
#[ignore = "a process of its own, started by d08"]
fn child_loads_and_unloads() {
    let Some(model) = model_of_child() else { return };
    let mut early_kb = 0;
    for cycle in 0..200 {
        let library = load();
        let (component, _) = step_loaded(&library, &model);
        // SAFETY: alive, freed once.
        unsafe { library.get::<FreeInstance>(b"fmi2FreeInstance").expect("exported")(component) };
        library.close().expect("closes");
        if cycle == 20 {
            early_kb = anonymous_kb();
        }
    }
    let maps = std::fs::read_to_string("/proc/self/maps").expect("readable");
    let mapped = maps.lines().filter(|line| line.contains("foldwing_fmu")).count();
    println!("result {} {mapped}", anonymous_kb() - early_kb);
}

/// D-06. An importer that forks between two steps: parent and child both continue, each as if alone. (With `threads` above 1 the child has
/// no thread pool: the importer must avoid this.)
#[test]
#[cfg(unix)]
fn d06_forked_importers() {
    let told = result(child("child_forks", &place(WING), &[]));
    assert_eq!(told, "both");
}

#[cfg(unix)]
unsafe extern "C" {
    fn fork() -> i32;
    fn waitpid(pid: i32, status: *mut i32, options: i32) -> i32;
    fn _exit(code: i32) -> !;
}

#[test]
#[cfg(unix)]
#[ignore = "a process of its own, started by d06"]
fn child_forks() {
    let Some(model) = model_of_child() else { return };
    let expected = unfold(&running(&model));
    let fmu = running(&model);
    (0..15).for_each(|i| step(&fmu, i));
    let go_on = || {
        (15..30).for_each(|i| step(&fmu, i));
        fmu.bits() == expected
    };
    // SAFETY: the child touches nothing but its instance and ends by `_exit`.
    unsafe {
        let pid = fork();
        assert!(pid >= 0);
        if pid == 0 {
            _exit(if go_on() { 7 } else { 1 });
        }
        assert!(go_on(), "the parent");
        let mut status = 0;
        assert_eq!(waitpid(pid, &mut status, 0), pid);
        assert_eq!(status, 7 << 8, "the child");
    }
    println!("result both");
}

/// D-07. Two threads that call one instance at once, which the standard forbids: calls are either rejected or executed completely.
#[test]
fn d07_two_threads_on_one_instance() {
    let fmu = running(WING);
    let component = fmu.component.expose_provenance();
    let state = fmu.save().expose_provenance();
    let barrier = std::sync::Barrier::new(2);
    let taken: usize = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..2)
            .map(|_| {
                let barrier = &barrier;
                scope.spawn(move || {
                    let c: fmi2Component = ptr::with_exposed_provenance_mut(component);
                    let (mut size, mut refused) = (0, 0);
                    barrier.wait();
                    for _ in 0..20_000 {
                        // SAFETY: alive; the gate keeps the threads apart. The size is found by serialising.
                        let state: fmi2FMUstate = ptr::with_exposed_provenance_mut(state);
                        let status = unsafe { fmi2SerializedFMUstateSize(c, state, &mut size) };
                        assert!(status == fmi2OK || status == fmi2Error);
                        refused += usize::from(status != fmi2OK);
                    }
                    refused
                })
            })
            .collect();
        threads.into_iter().map(|thread| thread.join().expect("ends")).sum()
    });
    println!("{taken} of 40000 calls met another one");
    assert!(taken < 40_000);
    assert!(fmu.messages.borrow().is_empty(), "they are refused in silence");
    fmu.step(0.0, 1e-3);
}
