//! `foldwing render`: films of models and of pages.

use std::path::Path;
use std::process::{Command, Output};

const WING: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/models/folding_wing.toml");

fn foldwing(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_foldwing")).args(arguments).current_dir(folder).output().unwrap()
}

fn succeeds(output: &Output) -> serde_json::Value {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap_or_default()
}

/// Content of the box of this kind, after boxes that contain others.
fn box_of<'f>(file: &'f [u8], kinds: &[&[u8; 4]]) -> &'f [u8] {
    let Some((kind, rest)) = kinds.split_first() else { return file };
    let mut at = 0;
    while at + 8 <= file.len() {
        let length = u32::from_be_bytes(file[at..at + 4].try_into().unwrap()) as usize;
        assert!(length >= 8 && at + length <= file.len(), "a box of {length} bytes at {at}");
        if &file[at + 4..at + 8] == *kind {
            return box_of(&file[at + 8..at + length], rest);
        }
        at += length;
    }
    panic!("no box {}", String::from_utf8_lossy(*kind));
}

fn word(bytes: &[u8], index: usize) -> u32 {
    u32::from_be_bytes(bytes[4 * index..4 * index + 4].try_into().unwrap())
}

/// A film of a model and one of its page have the same bytes: same frames, same length; the summary gives the settings chosen.
#[test]
fn films_of_models_and_pages_agree() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| succeeds(&foldwing(folder.path(), arguments));
    let common = ["--size", "320x180", "--fps", "15", "--json"];
    let told = run(&[&["render", WING, "--video", "model.mp4"], &common[..]].concat());
    run(&["simulate", WING, "--view", "run.html", "-q"]);
    run(&[&["render", "run.html", "--video", "page.mp4"], &common[..]].concat());
    let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    let file = read("model.mp4");
    assert!(file == read("page.mp4"), "the film of the page differs");
    assert_eq!((told["frames"].as_u64(), told["speed"].as_f64()), (Some(121), Some(0.05)));
    assert_eq!((told["camera"].as_str(), &told["files"][0]), (Some("fixed"), &"model.mp4".into()));
    let track: [&[u8; 4]; 4] = [b"moov", b"trak", b"mdia", b"mdhd"];
    let head = box_of(&file, &track);
    assert_eq!(f64::from(word(head, 4)) / f64::from(word(head, 3)), 121.0 / 15.0);
    let table = |kind: &'static [u8; 4]| box_of(&file, &[b"moov", b"trak", b"mdia", b"minf", b"stbl", kind]);
    let sizes = table(b"stsz");
    assert_eq!(word(sizes, 2), 121);
    // the frames fill the data, each preceded by its length
    let (data, first) = (box_of(&file, &[b"mdat"]), word(table(b"stco"), 2) as usize);
    let mut at = file.len() - data.len();
    assert_eq!(at, first);
    for frame in 0..121 {
        let size = word(sizes, 3 + frame) as usize;
        assert_eq!(u32::from_be_bytes(file[at..at + 4].try_into().unwrap()) as usize + 4, size);
        at += size;
    }
    assert_eq!(at, file.len());
}

/// Numbered files start at 1, one per frame; files of other origin stop the command before the run. A film of a part of the run shows
/// its times.
#[test]
fn frames_are_numbered() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["render", WING, "--video", "p/wing.png", "--size", "160x90", "--fps", "10"];
    let part = ["--from", "0.1", "--to", "0.2", "--speed", "0.1", "--json"];
    let told = succeeds(&foldwing(folder.path(), &[&arguments[..], &part[..]].concat()));
    assert_eq!([&told["from_s"], &told["to_s"]].map(|time_s| time_s.as_f64().unwrap()), [0.1, 0.2]);
    let name = |number: usize| folder.path().join(format!("p/wing_{number:05}.png"));
    assert!((1..=11).all(|number| name(number).exists()) && !name(12).exists() && !name(0).exists());
    std::fs::write(name(1), "mine").unwrap();
    let refused = foldwing(folder.path(), &arguments);
    assert_eq!(refused.status.code(), Some(4));
    let said = String::from_utf8_lossy(&refused.stderr);
    assert!(said.contains("wing_00001.png") && said.contains("--force overwrites it"), "{said}");
}

/// A run that fails leaves the film up to the failure, and returns the exit code of the failure.
#[test]
fn a_failed_run_leaves_its_film() {
    let folder = tempfile::tempdir().unwrap();
    let settings = ["solver.min_step=0.01", "solver.max_step=0.02", "solver.tolerance=1e-9"];
    let sets = settings.iter().flat_map(|setting| ["--set", *setting]);
    let common = ["render", WING, "--video", "x.gif", "--size", "160x90"];
    let failed = foldwing(folder.path(), &common.into_iter().chain(sets).collect::<Vec<_>>());
    assert_eq!(failed.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&failed.stderr).contains("no convergence at t = "));
    let film = std::fs::read(folder.path().join("x.gif")).unwrap();
    assert!(film.starts_with(b"GIF89a") && film.ends_with(b";"));
}

/// Settings of a simulation are rejected for a page; other kinds of page are rejected.
#[test]
fn pages_are_films_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let refuses = |arguments: &[&str], code: i32, needed: &str| {
        let refused = foldwing(folder.path(), arguments);
        let said = String::from_utf8_lossy(&refused.stderr);
        assert!(refused.status.code() == Some(code) && said.contains(needed), "{said}");
    };
    succeeds(&foldwing(folder.path(), &["simulate", WING, "--stop", "0.01", "--view", "run.html", "-q"]));
    refuses(&["render", "run.html", "--video", "x.mp4", "--stop", "0.1"], 2, "a page is not simulated again");
    refuses(&["render", "run.html", "--video", "x.mp4", "--to", "0.1"], 2, "--to 0.1: the run is from 0 to 0.01 s");
    std::fs::write(folder.path().join("other.html"), "<!doctype html>").unwrap();
    refuses(&["render", "other.html", "--video", "x.mp4"], 1, "other.html: is not a page written by");
}
