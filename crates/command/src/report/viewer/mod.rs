//! HTML page with an animation of a run, and a comparison with others: one file with its data and its libraries, no network.
//!
//! three.js draws, uPlot plots; both are in `vendor`, created by `tools/vendor_viewer.py`.

mod beside;
mod live;
mod modal;

pub use beside::{Companion, Table, run_of_page};
pub use foldwing_recording::packed::PackedRun;
pub use live::{LiveMachine, numbers_of_frame, page_of_live};
pub use modal::PackedModes;

use foldwing_recording::packed::in_script;
use serde_json::json;

const PAGE: &str = include_str!("page.html");
const STYLES: [&str; 2] = [include_str!("vendor/uplot.css"), include_str!("page.css")];
const LIBRARIES: [&str; 2] = [include_str!("vendor/three.js"), include_str!("vendor/uplot.js")];
const SCRIPTS: [&str; 19] = [
    include_str!("run.js"),
    include_str!("modes.js"),
    include_str!("colours.js"),
    include_str!("stage.js"),
    include_str!("camera.js"),
    include_str!("bodies.js"),
    include_str!("lift.js"),
    include_str!("air.js"),
    include_str!("marks.js"),
    include_str!("pick.js"),
    include_str!("fan.js"),
    include_str!("plots.js"),
    include_str!("along.js"),
    include_str!("mode_list.js"),
    include_str!("live.js"),
    include_str!("controls.js"),
    include_str!("export.js"),
    include_str!("address.js"),
    include_str!("page.js"),
];

/// Script at the end of a page whose viewer is started again for each run.
const AGAIN: &str = include_str!("again.js");

/// Beginning of the element with the description of a run.
const RUN_BEGINS: &str = "<script type=\"application/json\" class=\"run\">";
/// Beginning of the element with the numbers of a run.
const NUMBERS_BEGIN: &str = "<script type=\"text/plain\" class=\"numbers\">";

/// Beginning of the element with the description of modes.
const MODES_BEGIN: &str = "<script type=\"application/json\" class=\"modes\">";
/// Beginning of the element with the description of the runs of a sweep.
const FAN_BEGINS: &str = "<script type=\"application/json\" class=\"fan\">";
/// Beginning of the element with the numbers of the runs of a sweep.
const SPREAD_BEGINS: &str = "<script type=\"text/plain\" class=\"spread\">";

/// Beginning of the element with the numbers of modes.
const MOTIONS_BEGIN: &str = "<script type=\"text/plain\" class=\"motions\">";

/// The page as HTML: a run and the data to compare.
pub fn page(name: &str, run: &PackedRun, companions: &[Companion]) -> String {
    filled(name, elements(run), companions)
}

/// The page as HTML with mode shapes: the scene is that of a run, and its frames are a cycle of the mode that is selected.
pub fn page_of_modes(name: &str, modes: &PackedModes) -> String {
    let motions = element(MODES_BEGIN, &modes.description) + &element(MOTIONS_BEGIN, &modes.numbers);
    filled(name, elements(&modes.states) + &motions, &[])
}

/// The page as HTML with the other runs of a sweep.
pub fn page_of_fan(name: &str, run: &PackedRun, fan: &PackedRun) -> String {
    let others = element(FAN_BEGINS, &fan.description) + &element(SPREAD_BEGINS, &fan.numbers);
    filled(name, elements(run) + &others, &[])
}

fn elements(run: &PackedRun) -> String {
    element(RUN_BEGINS, &run.description) + &element(NUMBERS_BEGIN, &run.numbers)
}

/// A page that shows one run after another: scripts call `startViewer({ about, numbers, … })` for each, as `again.js` explains.
/// `styles`, `libraries` and `scripts` come after those of the viewer, `elements` before all scripts.
pub fn page_of_runs(name: &str, styles: &str, libraries: &str, scripts: &str, elements: &str) -> String {
    let script = format!("\"use strict\";\nfunction startViewer(again) {{\n{}{AGAIN}}}\n{scripts}", SCRIPTS.concat());
    let none = json!({ "runs": [], "tables": [] });
    assembled(
        name,
        [&(STYLES.concat() + styles), &(LIBRARIES.concat() + libraries), &script, elements, &in_script(&none)],
    )
}

fn filled(name: &str, mut runs: String, companions: &[Companion]) -> String {
    let (mut labels, mut tables) = (Vec::new(), Vec::new());
    for companion in companions {
        match companion {
            Companion::Run { label, run } => {
                labels.push(label);
                runs += &elements(run);
            }
            Companion::Table { label, table } => {
                tables.push(
                    json!({ "label": label, "names": table.names, "rows": table.kept(), "recorded": table.count }),
                );
                runs += &element("<script type=\"text/plain\" class=\"table\">", &table.numbers());
            }
        }
    }
    let beside = in_script(&json!({ "runs": labels, "tables": tables }));
    let script = format!("\"use strict\";\nconst again = null;\n{}", SCRIPTS.concat());
    assembled(name, [&STYLES.concat(), &LIBRARIES.concat(), &script, &runs, &beside])
}

/// The page with styles, libraries, scripts, elements of runs, and the list of the runs to compare with the first.
fn assembled(name: &str, [style, libraries, script, runs, beside]: [&str; 5]) -> String {
    let title = name.replace('&', "&amp;").replace('<', "&lt;").replace("{{", "{&#123;");
    // the longest text last: inserted text is not searched for placeholders
    PAGE.replace("{{title}}", &title)
        .replace("{{beside}}", beside)
        .replace("{{style}}", style)
        .replace("{{libraries}}", libraries)
        .replace("{{script}}", script)
        .replace("{{runs}}", runs)
}

fn element(begin: &str, content: &str) -> String {
    format!("{begin}{content}</script>\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample_tests::{recorded, shipped};
    use crate::report::signals::Signals;

    fn packed(machine: foldwing_engine::machine::Machine, runs: usize) -> PackedRun {
        let mut signals = Signals::new([("a".to_owned(), "m".to_owned())], 3);
        (0..4).for_each(|i| signals.include(f64::from(i), [1.0].into_iter()));
        PackedRun::new(&recorded(machine, 3), &signals, runs)
    }

    #[test]
    fn page_has_every_placeholder_once() {
        for name in ["title", "style", "libraries", "script", "runs", "beside"] {
            assert_eq!(PAGE.matches(&format!("{{{{{name}}}}}")).count(), 1, "{name}");
        }
        for script in SCRIPTS.iter().chain(&LIBRARIES).chain([&AGAIN]) {
            assert!(!script.contains("{{") && !script.contains("</script"), "a script would be torn");
        }
    }

    /// A description cannot end its element, nor contain the placeholder of the data.
    #[test]
    fn texts_of_the_model_stay_texts() {
        let mut machine = shipped("folding_wing");
        let hostile = "</script><script>alert(1)</script>{{runs}} & \"quoted\"";
        machine.description = hostile.to_owned();
        let page = page(hostile, &packed(machine, 1), &[]);
        assert_eq!(page.matches("</script").count(), PAGE.matches("</script").count() + 2);
        let begin = page.find(RUN_BEGINS).unwrap() + RUN_BEGINS.len();
        let end = begin + page[begin..].find("</script").unwrap();
        let read: serde_json::Value = serde_json::from_str(&page[begin..end]).unwrap();
        assert_eq!(read["description"], hostile);
        assert_eq!(read["begins"].as_array().unwrap().len(), 4);
    }

    /// The run of a page is read back as it was written; any other page is an error.
    #[test]
    fn runs_are_read_back_from_pages() {
        let run = packed(shipped("folding_wing"), 1);
        let other = Companion::Run { label: "other".to_owned(), run: packed(shipped("roll_fold"), 2) };
        let written = page("wing", &run, &[other]);
        assert_eq!(run_of_page(&written).unwrap(), run);
        assert!(run_of_page("<!doctype html><html></html>").unwrap_err().contains("is not a page"));
        let older = written.replacen("\"format\":4", "\"format\":1", 1);
        assert!(run_of_page(&older).unwrap_err().contains("another version"));
        // text that would not remain text in the page of both runs is rejected
        for (from, to) in [("\"name\":\"inner\"", "\"name\":\"<b>\""), ("\"name\":\"inner\"", "\"name\":\"{{runs}}\"")]
        {
            assert!(run_of_page(&written.replacen(from, to, 1)).unwrap_err().contains("is not a page"), "{to}");
        }
    }
}
