//! The lines of the documents and of `--help` that call the command. Shared by the tests that parse them and those that run them.

use std::path::{Path, PathBuf};

/// A call of the command shown in a text.
pub struct CommandLine {
    /// Page and line, for messages.
    pub place: String,
    /// Words after `foldwing`.
    pub words: Vec<String>,
    /// The call is on a separate line, to be typed unchanged; otherwise it is in a sentence and may lack arguments.
    pub whole: bool,
}

/// The pages whose command lines must be valid: the front page, everything in `docs/`, and the guide.
pub fn pages() -> Vec<PathBuf> {
    let mut folders = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors(); // for the command's unit tests: crates/command
    let root = folders.find(|folder| folder.join("docs/guide").is_dir()).expect("a folder of the repository");
    let mut pages = vec![root.join("README.md")];
    for folder in ["docs", "docs/guide", "docs/validation"] {
        let files = std::fs::read_dir(root.join(folder)).expect("the folder is part of the repository");
        pages.extend(files.map(|file| file.unwrap().path()).filter(|path| path.extension().is_some_and(|e| e == "md")));
    }
    pages.sort();
    pages
}

/// Calls in a page: lines of code blocks, and code in sentences.
pub fn of_page(page: &Path) -> Vec<CommandLine> {
    let text = std::fs::read_to_string(page).expect("the page is part of the repository");
    let name = page.file_name().unwrap().to_string_lossy();
    // even parts are prose, odd ones code blocks
    text.split("```")
        .enumerate()
        .flat_map(|(i, part)| {
            if i % 2 == 1 {
                return of_lines(&name, part);
            }
            let spans = part.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>();
            spans.iter().filter_map(|span| call(&name, &span.replace('\n', " "), false)).collect()
        })
        .collect()
}

/// Calls in lines of text, each on a separate line.
pub fn of_lines(place: &str, text: &str) -> Vec<CommandLine> {
    let joined = text.replace("\\\n", " ");
    joined.lines().filter_map(|line| call(place, line.trim(), true)).collect()
}

fn call(place: &str, line: &str, whole: bool) -> Option<CommandLine> {
    let (program, rest) = line.split_once(' ')?;
    let is_command = program.rsplit('/').next() == Some("foldwing");
    let words = words(rest);
    // `foldwing COMMAND` represents all commands
    let named = words.first().is_some_and(|word| !word.starts_with(|c: char| c.is_ascii_uppercase()));
    (is_command && named).then(|| CommandLine { place: format!("{place}: {line}"), words, whole })
}

/// Words of a shell line up to a comment, a redirection, a pipe or an explanation after a gap.
fn words(line: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let (mut quote, mut spaces) = (false, 0);
    for letter in line.chars() {
        let begins = words.last().is_some_and(String::is_empty);
        match letter {
            '"' => quote = !quote,
            '#' | '>' | '|' if !quote && begins => break,
            ' ' if !quote => {
                spaces += 1;
                if spaces > 2 {
                    break;
                }
                if !begins {
                    words.push(String::new());
                }
                continue;
            }
            _ => words.last_mut().expect("there is always one").push(letter),
        }
        spaces = 0;
    }
    words.retain(|word| !word.is_empty() && word != "…");
    words
}
