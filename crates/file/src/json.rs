//! Constant JSON tree, which `build.rs` writes: the schema, which is needed whenever a model file is read.

use std::ops::Index;

/// JSON value; tables keep the order of the text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Json {
    /// `null`, or a missing key of a table.
    Null,
    /// `true` or `false`.
    Flag(bool),
    /// Any number.
    Number(f64),
    /// String.
    Text(&'static str),
    /// An array.
    List(&'static [Self]),
    /// Keys and values.
    Table(&'static [(&'static str, Self)]),
}

impl Json {
    /// Value of a key; `None` if the key is missing or this is not a table.
    pub fn get(&self, key: &str) -> Option<&'static Self> {
        self.entries().iter().find(|(known, _)| *known == key).map(|(_, value)| value)
    }

    /// Keys and values of a table; empty for other types.
    pub fn entries(&self) -> &'static [(&'static str, Self)] {
        match self {
            Self::Table(entries) => entries,
            Self::Null | Self::Flag(_) | Self::Number(_) | Self::Text(_) | Self::List(_) => &[],
        }
    }

    /// Items, if this is an array.
    pub fn as_list(&self) -> Option<&'static [Self]> {
        match self {
            Self::List(items) => Some(items),
            Self::Null | Self::Flag(_) | Self::Number(_) | Self::Text(_) | Self::Table(_) => None,
        }
    }

    /// Text, if this is a string.
    pub fn as_str(&self) -> Option<&'static str> {
        match self {
            Self::Text(text) => Some(text),
            Self::Null | Self::Flag(_) | Self::Number(_) | Self::List(_) | Self::Table(_) => None,
        }
    }

    /// Value, if this is a number.
    pub fn as_f64(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Null | Self::Flag(_) | Self::Text(_) | Self::List(_) | Self::Table(_) => None,
        }
    }

    /// Value, if this is a non-negative whole number.
    pub fn as_count(&self) -> Option<usize> {
        self.as_f64().filter(|number| *number >= 0.0 && number.fract() == 0.0).map(|number| number as usize)
    }

    /// Returns whether this is a table.
    pub fn is_table(&self) -> bool {
        matches!(self, Self::Table(_))
    }

    /// Returns whether this is an array.
    pub fn is_list(&self) -> bool {
        matches!(self, Self::List(_))
    }
}

impl Index<&str> for Json {
    type Output = Self;

    /// Value of a key; null if there is none.
    fn index(&self, key: &str) -> &Self {
        self.get(key).unwrap_or(&Json::Null)
    }
}

impl PartialEq<str> for Json {
    fn eq(&self, text: &str) -> bool {
        self.as_str() == Some(text)
    }
}

impl PartialEq<&str> for Json {
    fn eq(&self, text: &&str) -> bool {
        *self == **text
    }
}
