//! The examples embedded in the command: their files, summaries, and the files that they need.

use foldwing_file as config;
use std::borrow::Cow;

/// Paths below `examples/`, with `/`, and contents, sorted by path.
const FILES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/examples.rs"));

/// Scripts without a comment that could serve as summary, and their summaries.
const WITHOUT_WORDS: [(&str, &str); 2] = [
    ("fmpy_ten_lines.py", "First script with an FMU, in FMPy: an input and a load set after every step"),
    ("python_ten_lines.py", "First script with the Python package: simulation, linear model, sweep"),
];

/// Name of the schema, which the command writes itself.
const SCHEMA: &str = "models/foldwing.schema.json";

/// An example.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct Example {
    /// Path below `examples/`, with `/`.
    pub name: &'static str,
    text: Option<&'static str>,
}

impl Example {
    /// All examples, sorted by path.
    pub fn all() -> impl Iterator<Item = Self> {
        FILES.iter().map(|&(name, text)| Self { name, text: Some(text) })
    }

    /// The example with this path, or another file that examples need.
    pub fn named(name: &str) -> Option<Self> {
        let schema = (name == SCHEMA).then_some(Self { name: SCHEMA, text: None });
        schema.or_else(|| Self::all().find(|example| example.name == name))
    }

    /// Contents.
    pub fn text(&self) -> Cow<'static, str> {
        self.text.map_or_else(|| Cow::Owned(config::schema()), Cow::Borrowed)
    }

    /// Returns whether the file is useful by itself: a model, a script or a program, and not a table or a part of a script.
    pub fn is_listed(&self) -> bool {
        let main = self.name.ends_with(".toml") || self.name.ends_with(".rs");
        main || self.name.ends_with(".py") && self.text().contains("__main__") || self.is_without_words()
    }

    fn is_without_words(&self) -> bool {
        WITHOUT_WORDS.iter().any(|(name, _)| *name == self.name)
    }

    /// Summary: the description of a model, or the first line of the comment of a script.
    pub fn summary(&self) -> String {
        if let Some((_, summary)) = WITHOUT_WORDS.iter().find(|(name, _)| *name == self.name) {
            return (*summary).to_owned();
        }
        let text = self.text();
        let of_model = || text.lines().find_map(|line| line.strip_prefix("description = \"")?.split('"').next());
        let beginning = || {
            let line = text.lines().find_map(|line| {
                line.strip_prefix("\"\"\"").or_else(|| line.strip_prefix("//! ")).or_else(|| line.strip_prefix("# "))
            })?;
            let line = line.trim_end_matches("\"\"\"");
            Some(line.split_once(". ").map_or(line, |(sentence, _)| sentence).trim_end_matches(['.', ',', ';']))
        };
        of_model().or_else(beginning).unwrap_or_default().to_owned()
    }

    /// Other examples that this one needs: files that it names relative to its folder, tables in the commands of its comments, and scripts that
    /// it imports.
    pub fn needed(&self) -> Vec<Self> {
        let mut found = vec![*self];
        let mut next = 0;
        while let Some(example) = found.get(next).copied() {
            for other in example.names() {
                if !found.contains(&other) {
                    found.push(other);
                }
            }
            next += 1;
        }
        found.split_off(1)
    }

    fn names(&self) -> Vec<Self> {
        let text = self.text();
        let folder: Vec<&str> = self.name.split('/').collect();
        let folder = &folder[..folder.len() - 1];
        let quoted = text.split('"').skip(1).step_by(2);
        let schema = text.lines().filter_map(|line| line.strip_prefix("#:schema "));
        let imported = text.lines().filter(|_| self.name.ends_with(".py")).filter_map(|line| {
            let line = line.trim_start();
            let module = line.strip_prefix("import ").or_else(|| line.strip_prefix("from "))?;
            Some(format!("{}.py", module.split([' ', ',']).next()?))
        });
        let paths = quoted.chain(schema).map(str::to_owned).chain(imported);
        // tables of inputs, in the commands at the top of a model
        let comments = text.lines().filter_map(|line| line.strip_prefix('#')).flat_map(str::split_whitespace);
        let tables = comments.filter(|word| word.ends_with(".csv")).filter_map(|word| word.strip_prefix("examples/"));
        paths.filter_map(|path| Self::named(&joined(folder, &path)?)).chain(tables.filter_map(Self::named)).collect()
    }
}

/// Joins a folder and a relative path, resolving `.` and `..`; `None` if the result is outside the examples.
fn joined(folder: &[&str], path: &str) -> Option<String> {
    let mut parts = folder.to_vec();
    for part in path.trim().split('/') {
        match part {
            "" => return None,
            "." => {}
            ".." => drop(parts.pop()?),
            part => parts.push(part),
        }
    }
    Some(parts.join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every listed example has a one-line summary, and the files that models and scripts need are found.
    #[test]
    fn examples_have_summaries_and_needs() {
        let listed: Vec<Example> = Example::all().filter(Example::is_listed).collect();
        assert!(listed.len() > 30);
        for example in &listed {
            let summary = example.summary();
            assert!(summary.len() > 10 && !summary.contains('\n'), "{}: {summary:?}", example.name);
        }
        let needs = |name: &str| -> Vec<&str> {
            Example::named(name).expect(name).needed().iter().map(|example| example.name).collect()
        };
        let turbine = needs("turbine/nrel_5mw_wind.toml");
        assert!(turbine.contains(&"models/foldwing.schema.json"), "{turbine:?}");
        assert_eq!(turbine.iter().filter(|name| name.starts_with("turbine/polars/")).count(), 8, "{turbine:?}");
        assert!(needs("turbine/closed_loop.py").contains(&"turbine/nrel_controller.py"));
        assert!(needs("sliding/jib_crane.toml").contains(&"sliding/jib_crane_commands.csv"));
        assert!(needs("soft_fold.py").contains(&"house_style.py"));
        assert_eq!(joined(&["a"], "../../b"), None);
    }
}
