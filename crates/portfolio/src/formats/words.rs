//! Words of a text with their places, and numbers read from them.

use crate::format_error::FormatError;

/// Longer lines and words are cut in messages.
const SHOWN_MAX: usize = 80;
/// Greatest number of a coordinate, time or profit: sums of larger ones would not be exact.
const NUMBER_MAX: f64 = 1e9;
/// Maximum number of digits after the point that are counted.
const DECIMALS_MAX: usize = 6;

/// A word with its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TextToken<'a> {
    pub(super) text: &'a str,
    pub(super) whole_line: &'a str,
    pub(super) line: usize,
    pub(super) column: usize,
}

impl<'a> TextToken<'a> {
    /// Returns the error at this word.
    pub(super) fn trouble(
        &self,
        message: impl Into<String>,
        reason: impl Into<String>,
        help: impl Into<String>,
    ) -> FormatError {
        FormatError {
            line: self.line,
            column: self.column,
            text: cut(self.whole_line),
            message: message.into(),
            reason: reason.into(),
            help: help.into(),
        }
    }

    /// Returns the number in the word; `what` names the number in error messages.
    pub(super) fn number(&self, what: &str) -> Result<f64, FormatError> {
        let number: Option<f64> = self.text.parse().ok();
        match number.filter(|number| number.is_finite()) {
            Some(number) if number.abs() <= NUMBER_MAX => Ok(number),
            Some(_) => Err(self.trouble(
                format!("{} is too large", cut(self.text)),
                format!("{what} is at most {NUMBER_MAX:.0}"),
                "write a smaller number",
            )),
            None => Err(self.trouble(
                format!("{} is not a number", cut(self.text)),
                format!("expected {what}"),
                "write a number such as 12 or 12.5",
            )),
        }
    }

    /// Returns the number in the word; an error if it is negative.
    pub(super) fn amount(&self, what: &str) -> Result<f64, FormatError> {
        let number = self.number(what)?;
        if number < 0.0 {
            return Err(self.trouble(
                format!("{} is negative", cut(self.text)),
                format!("{what} is 0 or more"),
                "leave the minus out",
            ));
        }
        Ok(number)
    }

    /// Returns the integer from 0 to `most` in the word; 12.0 is an integer.
    pub(super) fn count(&self, what: &str, most: usize) -> Result<usize, FormatError> {
        let number = self.amount(what)?;
        if number != libm::floor(number) || number > most as f64 {
            return Err(self.trouble(
                format!("{} cannot be {what}", cut(self.text)),
                format!("{what} is a whole number up to {most}"),
                "correct the number",
            ));
        }
        Ok(number as usize)
    }

    /// Returns the number of digits after its decimal point.
    pub(super) fn decimals(&self) -> usize {
        let digits = self.text.split_once('.').map_or("", |(_, digits)| digits).trim_end_matches('0');
        digits.len().min(DECIMALS_MAX)
    }
}

/// Returns the words of every line; empty lines have none.
pub(super) fn lines(text: &str) -> impl Iterator<Item = Vec<TextToken<'_>>> {
    text.trim_start_matches('\u{feff}').lines().enumerate().map(|(number, line)| words(line, number + 1))
}

/// Returns the words of one line.
pub(super) fn words(line: &str, number: usize) -> Vec<TextToken<'_>> {
    let mut found = Vec::new();
    let mut rest = line;
    let mut column = 1;
    loop {
        let trimmed = rest.trim_start();
        column += rest.chars().count() - trimmed.chars().count();
        if trimmed.is_empty() {
            return found;
        }
        let (word, after) = match trimmed.find(char::is_whitespace) {
            Some(end) => trimmed.split_at(end),
            None => (trimmed, ""),
        };
        found.push(TextToken { text: word, whole_line: line, line: number, column });
        column += word.chars().count();
        rest = after;
    }
}

/// Returns the error for a file that ends too early.
pub(super) fn ends_early(text: &str, message: impl Into<String>, reason: impl Into<String>) -> FormatError {
    let line = text.lines().count();
    let last = text.lines().last().unwrap_or_default();
    FormatError {
        line,
        column: last.chars().count() + 1,
        text: cut(last),
        message: message.into(),
        reason: reason.into(),
        help: "the file seems to be cut off: fetch it again, or add what is missing".to_string(),
    }
}

/// Returns a text shortened for messages.
pub(super) fn cut(text: &str) -> String {
    let mut shown: String = text.chars().filter(|c| !c.is_control()).take(SHOWN_MAX).collect();
    if text.chars().count() > SHOWN_MAX {
        shown.push_str("..");
    }
    shown
}
