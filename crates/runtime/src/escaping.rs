//! Escapes control characters, and those that reverse the direction of text, in output to a terminal as `\\u{1b}`; line ends and tabs
//! remain.

use std::borrow::Cow;
use std::io::{self, Write};

/// Maximum number of characters of a message that quotes input.
const MESSAGE_CHARS_MAX: usize = 300;

/// Returns a message that quotes input in a length that an operator reads.
pub(crate) fn shortened(message: &str) -> Cow<'_, str> {
    match message.char_indices().nth(MESSAGE_CHARS_MAX).and_then(|(end, _)| message.get(..end)) {
        Some(part) => Cow::Owned(format!("{part} ..")),
        None => Cow::Borrowed(message),
    }
}

/// Beginnings of escaped characters in UTF-8: the second set of control characters (U+0080 to U+009F), and the characters that set the
/// direction of text (U+202A to U+202E, U+2066 to U+2069), with the range of their last byte.
const ESCAPED: [(&[u8], std::ops::RangeInclusive<u8>); 3] =
    [(&[0xC2], 0x80..=0x9F), (&[0xE2, 0x80], 0xAA..=0xAE), (&[0xE2, 0x81], 0xA6..=0xA9)];

/// A writer that escapes control characters of UTF-8 text.
pub struct Escaped<W> {
    out: W,
    /// The last bytes, if they begin an escaped character: they are not written yet.
    held: Vec<u8>,
}

impl<W: Write> Escaped<W> {
    /// Returns a writer that escapes everything on its way to `out`.
    pub fn new(out: W) -> Escaped<W> {
        Escaped { out, held: Vec::new() }
    }

    fn put(&mut self, byte: u8, text: &mut Vec<u8>) {
        if !self.held.is_empty() {
            let ends = ESCAPED.iter().any(|(begin, last)| *begin == self.held && last.contains(&byte));
            self.held.push(byte);
            if ends {
                let escaped = String::from_utf8_lossy(&self.held).escape_unicode().to_string();
                self.held.clear();
                return text.extend_from_slice(escaped.as_bytes());
            }
            if ESCAPED.iter().any(|(begin, _)| begin.starts_with(&self.held)) {
                return;
            }
            self.held.pop();
            text.append(&mut self.held);
        }
        match byte {
            b'\n' | b'\t' => text.push(byte),
            0..=0x1F | 0x7F => text.extend_from_slice(format!("\\u{{{byte:x}}}").as_bytes()),
            _ if ESCAPED.iter().any(|(begin, _)| begin.starts_with(&[byte])) => self.held.push(byte),
            _ => text.push(byte),
        }
    }
}

impl<W: Write> Write for Escaped<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut text = Vec::with_capacity(bytes.len());
        bytes.iter().for_each(|byte| self.put(*byte, &mut text));
        self.out.write_all(&text)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Returns a text as one line of a log: line ends as `\
/// `, other control characters as `\\u{1b}`; tabs remain.
pub(crate) fn one_line(text: &str) -> String {
    if !text.contains(|each: char| each.is_control() && each != '\t') {
        return text.to_owned();
    }
    let mut line = String::with_capacity(text.len() + 16);
    for each in text.chars() {
        match each {
            '\n' => line.push_str("\\n"),
            '\t' => line.push(each),
            control if control.is_control() => line.extend(control.escape_unicode()),
            other => line.push(other),
        }
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    fn escaped(parts: &[&[u8]]) -> String {
        let mut out = Vec::new();
        let mut escaped = Escaped::new(&mut out);
        parts.iter().for_each(|part| escaped.write_all(part).unwrap());
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn a_line_of_a_log_holds_no_control_characters() {
        assert_eq!(one_line("für 20 °C\tÅ"), "für 20 °C\tÅ");
        assert_eq!(one_line("a\nb\u{1b}]0;x\u{7}\u{9b}2J\u{7f}"), "a\\nb\\u{1b}]0;x\\u{7}\\u{9b}2J\\u{7f}");
    }

    #[test]
    fn only_control_characters_change() {
        assert_eq!(escaped(&[b"a\tb\n"]), "a\tb\n");
        assert_eq!(escaped(&["für 20 °C, Å".as_bytes()]), "für 20 °C, Å");
        assert_eq!(escaped(&[b"\x1b]0;title\x07\r\x7f"]), "\\u{1b}]0;title\\u{7}\\u{d}\\u{7f}");
        assert_eq!(escaped(&["\u{9b}2J \u{a0}".as_bytes()]), "\\u{9b}2J \u{a0}");
        assert_eq!(escaped(&[b"\xC2", b"\x9B", b"\xC2", b"\xB0"]), "\\u{9b}°", "across writes");
        assert_eq!(escaped(&["fire \u{202e}x\u{2069} – “a” €".as_bytes()]), "fire \\u{202e}x\\u{2069} – “a” €");
    }
}
