//! JSON tree that borrows its texts, so that the schema, which is needed whenever a model file is read, is parsed without
//! copying.

use serde::de::{Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use std::borrow::Cow;
use std::fmt;
use std::ops::Index;

/// JSON value; tables keep the order of the text.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Json<'t> {
    /// `null`, or a missing key of a table.
    Null,
    /// `true` or `false`.
    Flag(bool),
    /// Any number.
    Number(f64),
    /// String.
    Text(Cow<'t, str>),
    /// An array.
    List(Vec<Self>),
    /// Keys and values.
    Table(Vec<(Cow<'t, str>, Self)>),
}

impl Json<'_> {
    /// Value of a key; `None` if the key is missing or this is not a table.
    pub fn get(&self, key: &str) -> Option<&Self> {
        self.entries().iter().find(|(known, _)| known == key).map(|(_, value)| value)
    }

    /// Keys and values of a table; empty for other types.
    pub fn entries(&self) -> &[(Cow<'_, str>, Self)] {
        match self {
            Self::Table(entries) => entries,
            Self::Null | Self::Flag(_) | Self::Number(_) | Self::Text(_) | Self::List(_) => &[],
        }
    }

    /// Items, if this is an array.
    pub fn as_list(&self) -> Option<&[Self]> {
        match self {
            Self::List(items) => Some(items),
            Self::Null | Self::Flag(_) | Self::Number(_) | Self::Text(_) | Self::Table(_) => None,
        }
    }

    /// Text, if this is a string.
    pub fn as_str(&self) -> Option<&str> {
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

impl Index<&str> for Json<'_> {
    type Output = Self;

    /// Value of a key; null if there is none.
    fn index(&self, key: &str) -> &Self {
        self.get(key).unwrap_or(&Json::Null)
    }
}

impl PartialEq<str> for Json<'_> {
    fn eq(&self, text: &str) -> bool {
        self.as_str() == Some(text)
    }
}

impl PartialEq<&str> for Json<'_> {
    fn eq(&self, text: &&str) -> bool {
        *self == **text
    }
}

impl<'de: 't, 't> Deserialize<'de> for Json<'t> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Reader)
    }
}

/// Deserializer visitor for any JSON value.
struct Reader;

impl<'de> Visitor<'de> for Reader {
    type Value = Json<'de>;

    fn expecting(&self, to: &mut fmt::Formatter) -> fmt::Result {
        to.write_str("JSON")
    }

    fn visit_unit<E>(self) -> Result<Json<'de>, E> {
        Ok(Json::Null)
    }

    fn visit_bool<E>(self, flag: bool) -> Result<Json<'de>, E> {
        Ok(Json::Flag(flag))
    }

    fn visit_i64<E>(self, number: i64) -> Result<Json<'de>, E> {
        Ok(Json::Number(number as f64))
    }

    fn visit_u64<E>(self, number: u64) -> Result<Json<'de>, E> {
        Ok(Json::Number(number as f64))
    }

    fn visit_f64<E>(self, number: f64) -> Result<Json<'de>, E> {
        Ok(Json::Number(number))
    }

    fn visit_borrowed_str<E>(self, text: &'de str) -> Result<Json<'de>, E> {
        Ok(Json::Text(Cow::Borrowed(text)))
    }

    fn visit_str<E>(self, text: &str) -> Result<Json<'de>, E> {
        Ok(Json::Text(Cow::Owned(text.to_owned())))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Json<'de>, A::Error> {
        let mut list = Vec::new();
        while let Some(item) = items.next_element()? {
            list.push(item);
        }
        Ok(Json::List(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Json<'de>, A::Error> {
        let mut table = Vec::new();
        while let Some(Key(key)) = entries.next_key()? {
            table.push((key, entries.next_value()?));
        }
        Ok(Json::Table(table))
    }
}

/// Key, borrowed if the text contains it without escapes.
struct Key<'t>(Cow<'t, str>);

impl<'de: 't, 't> Deserialize<'de> for Key<'t> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match deserializer.deserialize_str(Reader)? {
            Json::Text(text) => Ok(Self(text)),
            Json::Null | Json::Flag(_) | Json::Number(_) | Json::List(_) | Json::Table(_) => {
                Ok(Self(Cow::Borrowed("")))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All types of values are read in order; texts without escapes are borrowed from the source.
    #[test]
    fn json_is_read_without_copying() {
        let text = r#"{"z": [1, -2.5, true, null], "a": {"escaped": "\"x\"", "plain": "y"}}"#;
        let read: Json = serde_json::from_str(text).unwrap();
        let keys: Vec<&str> = read.entries().iter().map(|(key, _)| key.as_ref()).collect();
        assert_eq!(keys, ["z", "a"]);
        assert_eq!(read["z"].as_list().unwrap(), [Json::Number(1.0), Json::Number(-2.5), Json::Flag(true), Json::Null]);
        assert_eq!((&read["a"]["escaped"], &read["a"]["nothing"]), (&Json::Text("\"x\"".into()), &Json::Null));
        assert!(matches!(read["a"]["plain"], Json::Text(Cow::Borrowed("y"))));
        assert_eq!((read["z"].as_list().unwrap()[1].as_count(), Json::Number(3.0).as_count()), (None, Some(3)));
    }

    /// A tree that owns its texts is read in the same way.
    #[test]
    fn a_tree_that_owns_its_texts_is_the_same() {
        let text = r#"{"a": {"b": ["c", 2]}}"#;
        let owned: serde_json::Value = serde_json::from_str(text).unwrap();
        assert_eq!(Json::deserialize(owned).unwrap(), serde_json::from_str::<Json>(text).unwrap());
    }
}
