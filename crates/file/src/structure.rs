//! Second pass: comparison of the tree with the schema. Unknown and missing keys, types, ranges of individual values.

use crate::document::{Document, key_text};
use crate::error::{Fault, Problem};
use crate::meant::{did_you_mean, nearest};
use crate::renamed;
use crate::schema::{IDENTIFIER, Node, allowed, homes, in_range, is_required, options, properties, tagged};
use foldwing_engine::machine::UNLIMITED;
use foldwing_engine::machine::units::same_quantity;
use foldwing_engine::machine::validate::{IDENTIFIER_ALLOWED, is_identifier};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Maximum number of errors that are listed individually.
pub(super) const MAXIMUM_PROBLEMS: usize = 200;

/// Maximum length in bytes of a name for which a suggestion is sought.
const LONGEST_NAME: usize = 80;

/// Compares the model file with the schema.
///
/// # Errors
/// All problems, in the order of the file.
pub(super) fn check(document: &Document) -> Result<(), Vec<Problem>> {
    let mut check = Check { document, path: Vec::new(), problems: Vec::new(), further: 0 };
    check.table(Node::root(), document.root(), 0);
    let Check { mut problems, further: count, .. } = check;
    problems.sort_by_key(|problem| problem.line);
    if let Some(line) = problems.last().map(|problem| problem.line).filter(|_| count > 0) {
        problems.push(Problem { line, span: 0..0, key: String::new(), fault: Fault::Further { count } });
    }
    if problems.is_empty() { Ok(()) } else { Err(problems) }
}

struct Check<'d, 'a> {
    document: &'d Document<'a>,
    path: Vec<String>,
    problems: Vec<Problem>,
    /// Number of problems beyond [`MAXIMUM_PROBLEMS`].
    further: usize,
}

impl<'a> Check<'_, 'a> {
    /// Returns whether further errors are only counted.
    fn is_full(&self) -> bool {
        self.problems.len() >= MAXIMUM_PROBLEMS
    }

    fn problem(&mut self, offset: usize, key: String, fault: Fault) {
        self.problem_at(offset, self.document.key_span(offset), key, fault);
    }

    fn problem_at(&mut self, offset: usize, span: Range<usize>, key: String, fault: Fault) {
        if self.is_full() {
            self.further += 1;
            return;
        }
        self.problems.push(Problem { line: self.document.line(offset), span, key, fault });
    }

    fn refuse(&mut self, offset: usize, value: &Spanned<DeValue<'a>>, allowed: String) {
        let span = self.document.value_span(offset, value);
        let value = self.document.value_text(value);
        self.problem_at(offset, span, key_text(&self.path), Fault::NotAllowed { value, allowed });
    }

    /// Checks a table; `offset` is the position of its key, at which missing keys are reported.
    fn table(&mut self, schema: Node, table: &DeTable<'a>, offset: usize) {
        let Some((tag, variants)) = tagged(schema) else {
            return self.keys(schema, table, offset);
        };
        let shape = table.iter().find(|(key, _)| key.get_ref() == tag).and_then(|(_, value)| value.get_ref().as_str());
        let chosen = variants.iter().find(|(name, _)| shape == Some(name));
        match chosen {
            Some((_, variant)) => self.keys(*variant, table, offset),
            None => self.no_variant(schema, tag, table, offset),
        }
    }

    fn no_variant(&mut self, schema: Node, tag: &str, table: &DeTable<'a>, offset: usize) {
        let mut allowed = allowed(tag, schema);
        self.path.push(tag.to_owned());
        match table.iter().find(|(key, _)| key.get_ref() == tag) {
            Some((key, value)) => {
                allowed += &hint(value.get_ref(), schema);
                self.refuse(key.span().start, value, allowed);
            }
            None => {
                // the tag itself may be misspelt: then there is a similar key that no variant has
                let variants = || schema.children("oneOf").into_iter().flatten();
                let stranger = |name: &str| !variants().any(|variant| properties(variant).any(|(key, _)| key == name));
                let mut strangers = table.iter().filter(|(key, _)| stranger(key.get_ref()));
                if let Some((key, _)) = strangers.find(|(key, _)| nearest(key.get_ref(), [tag]).is_some()) {
                    allowed += &format!("; perhaps {} is {tag} misspelt", key_text(&[key.get_ref()]));
                }
                self.problem(offset, key_text(&self.path), Fault::MissingKey { allowed });
            }
        }
        self.path.pop();
    }

    fn keys(&mut self, schema: Node, table: &DeTable<'a>, offset: usize) {
        let mut meant = Vec::new();
        for (key, value) in table {
            let name = key.get_ref();
            self.path.push(name.to_string());
            match properties(schema).find(|(known, _)| known == name) {
                Some((known, schema)) => self.value(known, schema, value, key.span().start),
                // a table with keys and named tables: any other table is one of the latter
                None if schema["additionalProperties"].is_table()
                    && (value.get_ref().is_table() || properties(schema).next().is_none()) =>
                {
                    self.named(schema.child("additionalProperties"), name, value, key.span().start);
                }
                None => match renamed(schema, &self.path) {
                    Some((new, schema)) => {
                        self.problem(key.span().start, key_text(&self.path), Fault::RenamedKey { new: new.to_owned() });
                        // keys and values in this table may have old names, too
                        self.value(new, schema, value, key.span().start);
                        meant.push(new);
                    }
                    None => {
                        let names_table = value.get_ref().is_table();
                        meant.extend(self.unknown(schema, name, names_table, key.span().start));
                    }
                },
            }
            self.path.pop();
        }
        for (known, property) in properties(schema) {
            // a misspelt key is reported only once
            let needed = is_required(&schema, known)
                // models with beams need both; a machine of rigid bodies needs neither
                || self.path.is_empty()
                    && ["section", "body"].contains(&known)
                    && !table.iter().any(|(key, _)| ["rigid_body", "modal_body"].contains(&key.get_ref().as_ref()));
            let required = needed && !meant.contains(&known);
            if required && !table.iter().any(|(key, _)| key.get_ref() == known) {
                self.path.push(known.to_owned());
                let fault = Fault::MissingKey { allowed: allowed(known, property) };
                self.problem(offset, key_text(&self.path), fault);
                self.path.pop();
            }
        }
    }

    /// Checks a table whose name is chosen in the file, such as `[body.inner]`.
    fn named(&mut self, schema: Node, name: &str, value: &Spanned<DeValue<'a>>, offset: usize) {
        if !is_identifier(name) {
            let value = format!("the name {name:?}");
            self.problem(
                offset,
                key_text(&self.path),
                Fault::NotAllowed { value, allowed: IDENTIFIER_ALLOWED.to_owned() + &as_identifier(name) },
            );
        }
        self.value(name, schema, value, offset);
    }

    /// Returns the key that is probably meant. For a key of another table, that table is suggested; for a table, similar tables have
    /// priority.
    fn unknown(&mut self, schema: Node, name: &str, is_table: bool, offset: usize) -> Option<&'static str> {
        if self.is_full() {
            self.further += 1; // without further suggestions
            return None;
        }
        let known = || properties(schema).map(|(key, _)| key);
        let near = || nearest(name, known());
        let homes = homes(name);
        let (meant, suggestion) = match same_quantity(name, known()) {
            Some((key, unit)) => (Some(key), Some(format!("write {key} ({})", unit.symbol))),
            None if homes.is_empty() || is_table && near().is_some() => {
                (near(), near().map(|key| format!("perhaps {key} is meant")))
            }
            None => (None, Some(format!("it belongs to {}", homes.join(" or ")))),
        };
        let fault = Fault::UnknownKey { suggestion, allowed: known().map(str::to_owned).collect() };
        self.problem(offset, key_text(&self.path), fault);
        meant
    }

    fn value(&mut self, key: &str, property: Node, value: &Spanned<DeValue<'a>>, offset: usize) {
        let schema = alternative(property.resolve(), value.get_ref());
        let fits = match (value.get_ref(), schema["type"].as_str()) {
            (DeValue::Table(table), _) if is_table(schema) => {
                let too_few = schema["minProperties"].as_count().is_some_and(|least| table.len() < least);
                if !too_few {
                    return self.table(schema, table, offset);
                }
                false
            }
            (DeValue::Array(_), Some("array")) => return self.array(key, property, value, offset),
            (single, _) => fits(single, schema),
        };
        if !fits {
            let too_large = matches!(value.get_ref(), DeValue::Float(number)
                if number.as_str().parse::<f64>().is_ok_and(|value| value.is_finite() && value.abs() > UNLIMITED));
            let allowed = if is_table(schema) && property.get("x-allowed").is_none() {
                "a table".to_owned()
            } else if too_large {
                format!("{}, at most {UNLIMITED:e} in magnitude", allowed(key, property))
            } else {
                let old = value.get_ref().as_str().and_then(|text| renamed::value(key, text));
                allowed(key, property)
                    + &old.map_or_else(|| hint(value.get_ref(), schema), |new| format!("; it is now called {new:?}"))
            };
            self.refuse(offset, value, allowed);
        }
    }

    fn array(&mut self, key: &str, property: Node, value: &Spanned<DeValue<'a>>, offset: usize) {
        let schema = property.resolve();
        if let Some(at) = first_misfit(value, schema) {
            self.refuse(at.max(offset), value, allowed(key, property));
        }
    }
}

/// Present name of the key at the end of a path that has the old name of version 0.1.0, with its schema.
fn renamed(schema: Node, path: &[String]) -> Option<(&'static str, Node)> {
    let new = renamed::key(path)?;
    properties(schema).find(|(known, _)| *known == new)
}

/// For a schema with alternatives, one of them a table, the alternative that fits the type of `value`.
fn alternative(schema: Node, value: &DeValue) -> Node {
    let Some(choices) = schema.children("anyOf") else { return schema };
    let fits = |choice: &Node| is_table(*choice) == matches!(value, DeValue::Table(_));
    choices.map(Node::resolve).find(fits).unwrap_or(schema)
}

/// Suggestion for a word that is not an allowed option, to be appended to the list of options.
fn hint(value: &DeValue, schema: Node) -> String {
    let tags = tagged(schema).map(|(_, variants)| variants.into_iter().map(|(name, _)| name).collect());
    match (value.as_str(), options(schema).or(tags)) {
        (Some(word), Some(options)) => did_you_mean(word, options),
        (Some(word), None) if schema["pattern"] == IDENTIFIER => as_identifier(word),
        (Some(word), None) if schema["maxItems"].as_count() == Some(3) => as_direction(word),
        _ => String::new(),
    }
}

/// Suggests the identifier that is probably meant by a name with invalid characters: `Rover_Wing` for `Rover Wing`.
fn as_identifier(word: &str) -> String {
    let words: Vec<&str> = word
        .split(|letter: char| !letter.is_ascii_alphanumeric() && letter != '_')
        .filter(|part| !part.is_empty())
        .collect();
    let joined = words.join("_");
    let meant = if joined.starts_with(|letter: char| letter.is_ascii_digit()) { format!("_{joined}") } else { joined };
    let short = meant.len() <= LONGEST_NAME && is_identifier(&meant);
    if short { format!("; perhaps {meant:?}") } else { String::new() }
}

/// Suggests the direction vector for the name of an axis.
fn as_direction(word: &str) -> String {
    let (sign, axis) = word.strip_prefix('-').map_or(("", word), |axis| ("-", axis));
    let place = ["x", "y", "z"].iter().position(|name| axis.eq_ignore_ascii_case(name));
    place.map_or(String::new(), |place| {
        let numbers: Vec<String> =
            (0..3).map(|i| if i == place { format!("{sign}1.0") } else { "0.0".to_owned() }).collect();
        format!("; perhaps [{}]", numbers.join(", "))
    })
}

fn is_table(schema: Node) -> bool {
    schema["type"] == "object" || tagged(schema).is_some()
}

/// Byte offset of the first item of an array that does not fit the schema, or of the array if its length does not.
fn first_misfit(value: &Spanned<DeValue>, schema: Node) -> Option<usize> {
    let DeValue::Array(items) = value.get_ref() else {
        return (!fits(value.get_ref(), schema)).then(|| value.span().start);
    };
    let length = items.len();
    let length_fits = schema["minItems"].as_count().is_none_or(|least| length >= least)
        && schema["maxItems"].as_count().is_none_or(|most| length <= most);
    if schema["type"] != "array" || !length_fits {
        return Some(value.span().start);
    }
    items.iter().find_map(|item| first_misfit(item, schema.child("items").resolve()))
}

/// Returns whether a value other than a table or array has the type and range of the schema.
fn fits(value: &DeValue, schema: Node) -> bool {
    match (value, schema["type"].as_str()) {
        (DeValue::String(text), _) if options(schema).is_some() => {
            options(schema).is_some_and(|options| options.contains(&text.as_ref()))
        }
        (DeValue::String(text), Some("string")) => schema["pattern"] != IDENTIFIER || is_identifier(text),
        (DeValue::Boolean(_), Some("boolean")) => true,
        (DeValue::Integer(number), Some("integer" | "number")) => {
            i64::from_str_radix(number.as_str(), number.radix()).is_ok_and(|whole| in_range(whole as f64, &schema))
        }
        (DeValue::Float(number), Some("number")) => {
            number.as_str().parse::<f64>().is_ok_and(|value| in_range(value, &schema))
        }
        _ => false,
    }
}
