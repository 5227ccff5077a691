//! Numbers as bytes: integers as LEB128, signed ones zigzag-encoded before, reals as eight bytes, little-endian.

use serde::Deserialize;

/// Appends a whole number.
pub(super) fn put_unsigned(bytes: &mut Vec<u8>, mut number: u64) {
    while number >= 0x80 {
        bytes.push((number as u8) | 0x80);
        number >>= 7;
    }
    bytes.push(number as u8);
}

/// Appends a signed number.
pub(super) fn put_signed(bytes: &mut Vec<u8>, number: i64) {
    put_unsigned(bytes, ((number << 1) ^ (number >> 63)) as u64);
}

/// Bytes that are read from the front.
pub(super) struct Input<'a> {
    pub(super) bytes: &'a [u8],
}

impl<'a> Input<'a> {
    pub(super) fn byte(&mut self) -> Result<u8, String> {
        let (first, rest) = self.bytes.split_first().ok_or("it is cut off")?;
        self.bytes = rest;
        Ok(*first)
    }

    pub(super) fn unsigned(&mut self) -> Result<u64, String> {
        let mut number = 0_u64;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            number |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Ok(number);
            }
        }
        Err("a number has too many digits".into())
    }

    pub(super) fn signed(&mut self) -> Result<i64, String> {
        let number = self.unsigned()?;
        Ok(((number >> 1) as i64) ^ -((number & 1) as i64))
    }

    pub(super) fn real(&mut self) -> Result<f64, String> {
        let (first, rest) = self.bytes.split_first_chunk::<8>().ok_or("it is cut off")?;
        self.bytes = rest;
        Ok(f64::from_le_bytes(*first))
    }

    /// Returns the next `length` bytes.
    pub(super) fn take(&mut self, length: u64) -> Result<&'a [u8], String> {
        let length = usize::try_from(length).unwrap_or(usize::MAX);
        let (first, rest) = self.bytes.split_at_checked(length).ok_or("it is cut off")?;
        self.bytes = rest;
        Ok(first)
    }

    pub(super) fn postcard<T: for<'de> Deserialize<'de>>(&mut self) -> Result<T, String> {
        let (value, rest) =
            postcard::take_from_bytes(self.bytes).map_err(|error| format!("a value is garbled ({error})"))?;
        self.bytes = rest;
        Ok(value)
    }
}
