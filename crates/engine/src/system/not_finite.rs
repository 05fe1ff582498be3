//! First number of a value that is not finite, with its path: visits everything that is serialised, so that new fields of a state are
//! checked automatically.

use serde::Serialize;
use serde::ser::{
    Error, SerializeMap, SerializeSeq, SerializeStruct, SerializeStructVariant, SerializeTuple, SerializeTupleStruct,
    SerializeTupleVariant, Serializer,
};
use std::fmt::{self, Display, Formatter, Write as _};

/// Path and value of the first number in `value` that is NaN or infinite, for example `air.before.lags[3] is NaN`. Fields with a name in
/// `left_out` are skipped, with all their contents.
pub(crate) fn not_finite(value: &impl Serialize, left_out: &[&str]) -> Option<String> {
    value.serialize(&mut Walk { path: Vec::new(), left_out }).err().map(|found| found.0)
}

/// One element of the path to a number.
enum Step {
    Field(&'static str),
    Entry(usize),
}

/// Current path of the walk.
struct Walk<'a> {
    path: Vec<Step>,
    left_out: &'a [&'a str],
}

/// Marks that a number that is not finite has been found, which ends the walk.
#[derive(Debug)]
struct Found(String);

impl Display for Found {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Found {}

impl Error for Found {
    fn custom<T: Display>(message: T) -> Self {
        Self(message.to_string())
    }
}

impl Walk<'_> {
    fn number(&self, value: f64) -> Result<(), Found> {
        if value.is_finite() {
            return Ok(());
        }
        let mut place = String::new();
        for step in &self.path {
            let _ = match step {
                Step::Field(name) if place.is_empty() => write!(place, "{name}"),
                Step::Field(name) => write!(place, ".{name}"),
                Step::Entry(index) => write!(place, "[{index}]"),
            };
        }
        Err(Found(format!("{place} is {value}")))
    }

    fn enter_field<T: Serialize + ?Sized>(&mut self, name: &'static str, value: &T) -> Result<(), Found> {
        if self.left_out.contains(&name) {
            return Ok(());
        }
        self.enter(Step::Field(name), value)
    }

    fn enter<T: Serialize + ?Sized>(&mut self, step: Step, value: &T) -> Result<(), Found> {
        self.path.push(step);
        value.serialize(&mut *self)?;
        self.path.pop();
        Ok(())
    }
}

/// Entries of a sequence, counted from 0, or fields of a struct.
struct Inside<'w, 'a> {
    walk: &'w mut Walk<'a>,
    index: usize,
}

impl Inside<'_, '_> {
    fn entry<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Found> {
        self.index += 1;
        self.walk.enter(Step::Entry(self.index - 1), value)
    }
}

/// Values that contain no numbers.
macro_rules! no_number {
    ($($name:ident($type:ty)),*) => { $(fn $name(self, _: $type) -> Result<(), Found> { Ok(()) })* };
}

impl<'w, 'a> Serializer for &'w mut Walk<'a> {
    type Ok = ();
    type Error = Found;
    type SerializeSeq = Inside<'w, 'a>;
    type SerializeTuple = Inside<'w, 'a>;
    type SerializeTupleStruct = Inside<'w, 'a>;
    type SerializeTupleVariant = Inside<'w, 'a>;
    type SerializeMap = Inside<'w, 'a>;
    type SerializeStruct = Inside<'w, 'a>;
    type SerializeStructVariant = Inside<'w, 'a>;

    no_number!(
        serialize_bool(bool),
        serialize_i8(i8),
        serialize_i16(i16),
        serialize_i32(i32),
        serialize_i64(i64),
        serialize_u8(u8),
        serialize_u16(u16),
        serialize_u32(u32),
        serialize_u64(u64),
        serialize_char(char),
        serialize_str(&str),
        serialize_bytes(&[u8]),
        serialize_unit_struct(&'static str)
    );

    fn serialize_f32(self, value: f32) -> Result<(), Found> {
        self.number(f64::from(value))
    }

    fn serialize_f64(self, value: f64) -> Result<(), Found> {
        self.number(value)
    }

    fn serialize_none(self) -> Result<(), Found> {
        Ok(())
    }

    fn serialize_unit(self) -> Result<(), Found> {
        Ok(())
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<(), Found> {
        value.serialize(self)
    }

    fn serialize_unit_variant(self, _: &'static str, _: u32, _: &'static str) -> Result<(), Found> {
        Ok(())
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, _: &'static str, value: &T) -> Result<(), Found> {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        value: &T,
    ) -> Result<(), Found> {
        value.serialize(self)
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<Inside<'w, 'a>, Found> {
        Ok(Inside { walk: self, index: 0 })
    }

    fn serialize_tuple(self, _: usize) -> Result<Inside<'w, 'a>, Found> {
        Ok(Inside { walk: self, index: 0 })
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Inside<'w, 'a>, Found> {
        Ok(Inside { walk: self, index: 0 })
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Inside<'w, 'a>, Found> {
        Ok(Inside { walk: self, index: 0 })
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Inside<'w, 'a>, Found> {
        Ok(Inside { walk: self, index: 0 })
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Inside<'w, 'a>, Found> {
        Ok(Inside { walk: self, index: 0 })
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Inside<'w, 'a>, Found> {
        Ok(Inside { walk: self, index: 0 })
    }
}

/// Serializers of sequences and tuples.
macro_rules! entries {
    ($($trait:ident::$method:ident),*) => { $(
        impl $trait for Inside<'_, '_> {
            type Ok = ();
            type Error = Found;

            fn $method<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Found> {
                self.entry(value)
            }

            fn end(self) -> Result<(), Found> {
                Ok(())
            }
        }
    )* };
}
entries!(
    SerializeSeq::serialize_element,
    SerializeTuple::serialize_element,
    SerializeTupleStruct::serialize_field,
    SerializeTupleVariant::serialize_field
);

/// Serializers of structs and maps.
macro_rules! fields {
    ($($trait:ident),*) => { $(
        impl $trait for Inside<'_, '_> {
            type Ok = ();
            type Error = Found;

            fn serialize_field<T: Serialize + ?Sized>(&mut self, name: &'static str, value: &T) -> Result<(), Found> {
                self.walk.enter_field(name, value)
            }

            fn end(self) -> Result<(), Found> {
                Ok(())
            }
        }
    )* };
}
fields!(SerializeStruct, SerializeStructVariant);

impl SerializeMap for Inside<'_, '_> {
    type Ok = ();
    type Error = Found;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Result<(), Found> {
        key.serialize(&mut *self.walk)
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Found> {
        self.entry(value)
    }

    fn end(self) -> Result<(), Found> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DVector, Vector3};

    #[derive(Serialize)]
    enum Kind {
        Plain,
        Holding { time_s: f64 },
        Of(f64, Vec<f64>),
    }

    #[derive(Serialize)]
    struct Inner {
        position_m: Vector3<f64>,
        list: Vec<Option<DVector<f64>>>,
        kinds: Vec<Kind>,
        limit: f64,
    }

    #[derive(Serialize)]
    struct Outer {
        count: u64,
        inner: Inner,
    }

    fn sound() -> Outer {
        let kinds = vec![Kind::Plain, Kind::Holding { time_s: 1.0 }, Kind::Of(2.0, vec![3.0, 4.0])];
        let list = vec![None, Some(DVector::from_vec(vec![1.0, 2.0]))];
        Outer { count: 3, inner: Inner { position_m: Vector3::zeros(), list, kinds, limit: 5.0 } }
    }

    /// All numbers in vectors, options and enum variants are found, with their paths.
    #[test]
    fn finds_every_number() {
        assert_eq!(not_finite(&sound(), &[]), None);
        let found = |spoil: &dyn Fn(&mut Outer)| {
            let mut value = sound();
            spoil(&mut value);
            not_finite(&value, &["limit"])
        };
        let is = |found: Option<String>, expected: &str| assert!(found.as_deref() == Some(expected), "{found:?}");
        is(found(&|value| value.inner.position_m.y = f64::NAN), "inner.position_m[1] is NaN");
        is(
            found(&|value| value.inner.kinds[1] = Kind::Holding { time_s: f64::INFINITY }),
            "inner.kinds[1].time_s is inf",
        );
        is(
            found(&|value| value.inner.kinds[2] = Kind::Of(0.0, vec![0.0, -f64::INFINITY])),
            "inner.kinds[2][1][1] is -inf",
        );
        is(found(&|value| value.inner.kinds[2] = Kind::Of(f64::NAN, vec![])), "inner.kinds[2][0] is NaN");
        assert!(
            found(&|value| value.inner.list[1] = Some(DVector::repeat(2, f64::NAN)))
                .is_some_and(|found| { found.starts_with("inner.list[1]") && found.ends_with("is NaN") })
        );
        assert_eq!(found(&|value| value.inner.limit = f64::INFINITY), None, "left out");
    }
}
