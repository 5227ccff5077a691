//! Splits an effect into its shape and its values.
//!
//! The shape is the postcard encoding of the effect without its numbers and texts: the variants, lengths and flags, with a mark for each
//! value. Effects of one form of PDL have one shape, so a shape is stored once, and an effect is stored as the shape's number and its
//! values. [`join`] combines both again, to the same bytes as postcard's.

use crate::record::numbers::{put_signed, put_unsigned};
use apex_model::effect::Effect;
use apex_model::time::Time;
use serde::ser::{self, Serialize};
use std::fmt;
use std::sync::Arc;

/// Maximum number of bytes of a shape; longer effects are stored as they are.
const SHAPE_BYTES_MAX: usize = 4_000;

/// A literal byte follows.
const LITERAL: u8 = 1;

/// The type of a value that a shape leaves out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Hole {
    /// Number of a task.
    Task = 2,
    /// An instant, as its distance to the instant of the step.
    Instant = 3,
    Unsigned = 4,
    Signed = 5,
    Real = 6,
    Text = 7,
}

impl Hole {
    fn of(mark: u8) -> Option<Hole> {
        [Hole::Task, Hole::Instant, Hole::Unsigned, Hole::Signed, Hole::Real, Hole::Text]
            .into_iter()
            .find(|hole| *hole as u8 == mark)
    }
}

/// The parts of one effect; reused for the next.
#[derive(Default)]
pub(super) struct Parts {
    pub(super) shape: Vec<u8>,
    /// By hole: a number as 64 bits, or the end of a text in `texts`.
    pub(super) values: Vec<u64>,
    pub(super) texts: String,
    /// The instant of the step.
    now: i64,
    /// Type of the next number, if its struct states one.
    next: Option<Hole>,
}

impl Parts {
    /// Splits `effect`; returns false if it cannot be split and must be stored whole.
    pub(super) fn split(&mut self, now: Time, effect: &Effect) -> bool {
        self.shape.clear();
        self.values.clear();
        self.texts.clear();
        (self.now, self.next) = (now.0, None);
        effect.serialize(self).is_ok()
    }

    fn literal(&mut self, byte: u8) {
        self.shape.extend_from_slice(&[LITERAL, byte]);
    }

    fn hole(&mut self, hole: Hole, value: u64) -> Result<(), Unsplit> {
        self.shape.push(hole as u8);
        self.values.push(value);
        if self.shape.len() > SHAPE_BYTES_MAX { Err(Unsplit) } else { Ok(()) }
    }

    fn length(&mut self, mut number: u64) -> Result<(), Unsplit> {
        while number >= 0x80 {
            self.literal((number as u8) | 0x80);
            number >>= 7;
        }
        self.literal(number as u8);
        if self.shape.len() > SHAPE_BYTES_MAX { Err(Unsplit) } else { Ok(()) }
    }

    fn counted(&mut self, length: Option<usize>) -> Result<&mut Parts, Unsplit> {
        self.length(length.ok_or(Unsplit)? as u64)?;
        Ok(self)
    }

    fn variant(&mut self, variant: u32) -> Result<&mut Parts, Unsplit> {
        self.length(u64::from(variant))?;
        Ok(self)
    }
}

/// Error: the effect contains something that a shape cannot represent.
#[derive(Debug)]
pub(super) struct Unsplit;

impl fmt::Display for Unsplit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("it cannot be split")
    }
}

impl std::error::Error for Unsplit {}

impl ser::Error for Unsplit {
    fn custom<T: fmt::Display>(_: T) -> Unsplit {
        Unsplit
    }
}

type Done = Result<(), Unsplit>;

impl<'p> ser::Serializer for &'p mut Parts {
    type Ok = ();
    type Error = Unsplit;
    type SerializeSeq = &'p mut Parts;
    type SerializeTuple = &'p mut Parts;
    type SerializeTupleStruct = &'p mut Parts;
    type SerializeTupleVariant = &'p mut Parts;
    type SerializeMap = &'p mut Parts;
    type SerializeStruct = &'p mut Parts;
    type SerializeStructVariant = &'p mut Parts;

    fn is_human_readable(&self) -> bool {
        false
    }

    fn serialize_bool(self, value: bool) -> Done {
        self.literal(u8::from(value));
        Ok(())
    }

    fn serialize_i8(self, value: i8) -> Done {
        self.literal(value.cast_unsigned());
        Ok(())
    }

    fn serialize_i16(self, value: i16) -> Done {
        self.serialize_i64(i64::from(value))
    }

    fn serialize_i32(self, value: i32) -> Done {
        self.serialize_i64(i64::from(value))
    }

    fn serialize_i64(self, value: i64) -> Done {
        match self.next.take() {
            Some(Hole::Instant) => self.hole(Hole::Instant, self.now.wrapping_sub(value).cast_unsigned()),
            _ => self.hole(Hole::Signed, value.cast_unsigned()),
        }
    }

    fn serialize_u8(self, value: u8) -> Done {
        self.literal(value);
        Ok(())
    }

    fn serialize_u16(self, value: u16) -> Done {
        self.serialize_u64(u64::from(value))
    }

    fn serialize_u32(self, value: u32) -> Done {
        self.serialize_u64(u64::from(value))
    }

    fn serialize_u64(self, value: u64) -> Done {
        match self.next.take() {
            Some(Hole::Task) => self.hole(Hole::Task, value),
            _ => self.hole(Hole::Unsigned, value),
        }
    }

    fn serialize_f32(self, value: f32) -> Done {
        value.to_le_bytes().into_iter().for_each(|byte| self.literal(byte));
        Ok(())
    }

    fn serialize_f64(self, value: f64) -> Done {
        self.hole(Hole::Real, value.to_bits())
    }

    fn serialize_char(self, value: char) -> Done {
        self.serialize_str(value.encode_utf8(&mut [0; 4]))
    }

    fn serialize_str(self, value: &str) -> Done {
        self.texts.push_str(value);
        self.hole(Hole::Text, self.texts.len() as u64)
    }

    fn serialize_bytes(self, _: &[u8]) -> Done {
        Err(Unsplit)
    }

    fn serialize_none(self) -> Done {
        self.literal(0);
        Ok(())
    }

    fn serialize_some<T: ?Sized + Serialize>(self, value: &T) -> Done {
        self.literal(1);
        value.serialize(self)
    }

    fn serialize_unit(self) -> Done {
        Ok(())
    }

    fn serialize_unit_struct(self, _: &'static str) -> Done {
        Ok(())
    }

    fn serialize_unit_variant(self, _: &'static str, variant: u32, _: &'static str) -> Done {
        self.variant(variant).map(|_| ())
    }

    fn serialize_newtype_struct<T: ?Sized + Serialize>(self, name: &'static str, value: &T) -> Done {
        self.next = match name {
            "TaskId" => Some(Hole::Task),
            "Time" => Some(Hole::Instant),
            _ => None,
        };
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: ?Sized + Serialize>(
        self,
        _: &'static str,
        variant: u32,
        _: &'static str,
        value: &T,
    ) -> Done {
        value.serialize(self.variant(variant)?)
    }

    fn serialize_seq(self, length: Option<usize>) -> Result<&'p mut Parts, Unsplit> {
        self.counted(length)
    }

    fn serialize_tuple(self, _: usize) -> Result<&'p mut Parts, Unsplit> {
        Ok(self)
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<&'p mut Parts, Unsplit> {
        Ok(self)
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        variant: u32,
        _: &'static str,
        _: usize,
    ) -> Result<&'p mut Parts, Unsplit> {
        self.variant(variant)
    }

    fn serialize_map(self, length: Option<usize>) -> Result<&'p mut Parts, Unsplit> {
        self.counted(length)
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<&'p mut Parts, Unsplit> {
        Ok(self)
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        variant: u32,
        _: &'static str,
        _: usize,
    ) -> Result<&'p mut Parts, Unsplit> {
        self.variant(variant)
    }
}

/// Elements of a compound value are written in sequence.
macro_rules! compound {
    ($kind:ident, $method:ident $(, $name:ty)?) => {
        impl ser::$kind for &mut Parts {
            type Ok = ();
            type Error = Unsplit;

            fn $method<T: ?Sized + Serialize>(&mut self, $(_: $name,)? value: &T) -> Done {
                value.serialize(&mut **self)
            }

            fn end(self) -> Done {
                Ok(())
            }
        }
    };
}

compound!(SerializeSeq, serialize_element);
compound!(SerializeTuple, serialize_element);
compound!(SerializeTupleStruct, serialize_field);
compound!(SerializeTupleVariant, serialize_field);
compound!(SerializeStruct, serialize_field, &'static str);
compound!(SerializeStructVariant, serialize_field, &'static str);

impl ser::SerializeMap for &mut Parts {
    type Ok = ();
    type Error = Unsplit;

    fn serialize_key<T: ?Sized + Serialize>(&mut self, key: &T) -> Done {
        key.serialize(&mut **self)
    }

    fn serialize_value<T: ?Sized + Serialize>(&mut self, value: &T) -> Done {
        value.serialize(&mut **self)
    }

    fn end(self) -> Done {
        Ok(())
    }
}

/// Returns the holes of a shape in order; `None` if the shape is malformed.
pub(super) fn holes_of(shape: &[u8]) -> Option<Vec<Hole>> {
    let mut holes = Vec::new();
    let mut rest = shape.iter();
    while let Some(mark) = rest.next() {
        match Hole::of(*mark) {
            Some(hole) => holes.push(hole),
            None if *mark == LITERAL => {
                rest.next()?;
            }
            None => return None,
        }
    }
    Some(holes)
}

/// A value for a hole.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Filling {
    Number(u64),
    Text(Arc<str>),
}

/// Writes the effect of a shape with these values, in postcard's encoding. A missing value is left out.
pub(super) fn join<'f>(now: Time, shape: &[u8], values: impl Iterator<Item = &'f Filling>, bytes: &mut Vec<u8>) {
    let (mut values, mut rest) = (values, shape.iter());
    while let Some(mark) = rest.next() {
        let Some(hole) = Hole::of(*mark) else {
            bytes.extend(rest.next());
            continue;
        };
        match (hole, values.next()) {
            (Hole::Task | Hole::Unsigned, Some(Filling::Number(number))) => put_unsigned(bytes, *number),
            (Hole::Signed, Some(Filling::Number(number))) => put_signed(bytes, number.cast_signed()),
            (Hole::Instant, Some(Filling::Number(number))) => {
                put_signed(bytes, now.0.wrapping_sub(number.cast_signed()));
            }
            (Hole::Real, Some(Filling::Number(number))) => bytes.extend_from_slice(&number.to_le_bytes()),
            (Hole::Text, Some(Filling::Text(text))) => {
                put_unsigned(bytes, text.len() as u64);
                bytes.extend_from_slice(text.as_bytes());
            }
            _ => return,
        }
    }
}
