//! Inputs that are read when they are needed: a file of any length needs the memory of one line.
//!
//! The file is read twice: first completely, to check it before the run begins, then line by line. This requires order of time and no
//! acknowledgements; other files are held in memory.

use crate::input_lines::{InputErrors, ReadValue, read_numbered};
use crate::limits::{INPUT_LINE_BYTES_MAX, INPUT_MESSAGES_MAX};
use crate::ports::Input;
use apex_model::event::EventKind;
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use std::collections::BTreeSet;
use std::fmt;
use std::io::{self, BufRead, Read};

/// Reads one PDL datum from text, for as long as the inputs last.
pub type OwnReadValue = Box<dyn Fn(&str) -> Result<apex_model::value::Value, String> + Send>;

/// Inputs in order of time.
pub struct InputStream {
    lines: Lines<Box<dyn BufRead + Send>>,
    read_value: OwnReadValue,
    /// The next one.
    next: Option<Input>,
    /// The agents that lines are for by name.
    agents: BTreeSet<Symbol>,
    last: Time,
    failure: Option<String>,
}

impl fmt::Debug for InputStream {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("InputStream").field("file", &self.lines.name).field("next", &self.next).finish_non_exhaustive()
    }
}

impl InputStream {
    /// Returns the inputs of a file that [`survey`] has found fit to be streamed. `name` is for messages.
    pub fn new(
        name: &str,
        file: Box<dyn BufRead + Send>,
        agents: BTreeSet<Symbol>,
        read_value: OwnReadValue,
    ) -> InputStream {
        let lines = Lines { name: name.to_string(), file, number: 0 };
        let mut stream = InputStream { lines, read_value, next: None, agents, last: Time::ZERO, failure: None };
        stream.advance();
        stream
    }

    /// Returns the agents that lines are for by name.
    pub fn agents(&self) -> &BTreeSet<Symbol> {
        &self.agents
    }

    /// Returns the instant of the next input.
    pub(crate) fn next_at(&self) -> Option<Time> {
        // A fault of the file is reported at once.
        if self.failure.is_some() { Some(self.last) } else { self.next.as_ref().map(|input| input.at) }
    }

    /// Returns the next input if it is due.
    ///
    /// # Errors
    /// The file has changed since it was checked, or can no longer be read.
    pub(crate) fn take_due(&mut self, now: Time) -> Result<Option<Input>, String> {
        if let Some(failure) = self.failure.take() {
            return Err(failure);
        }
        if self.next.as_ref().is_none_or(|input| input.at > now) {
            return Ok(None);
        }
        let taken = self.next.take();
        self.advance();
        Ok(taken)
    }

    fn advance(&mut self) {
        match self.lines.next(&*self.read_value) {
            Ok(Some(input)) if input.at >= self.last => {
                self.last = input.at;
                self.next = Some(input);
            }
            Ok(None) => self.next = None,
            Ok(Some(_)) => self.failure = Some(format!("{} was changed while it was read", self.lines.name)),
            Err(fault) => self.failure = Some(fault),
        }
    }
}

/// Properties of a file of inputs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Survey {
    /// True if lines are in order of time and none is an acknowledgement.
    pub can_be_streamed: bool,
    /// The agents that lines are for by name.
    pub agents: BTreeSet<Symbol>,
}

/// Checks all lines of a file of inputs.
///
/// # Errors
/// Every bad line with `name:line` and the error, up to a limit.
pub fn survey(name: &str, file: impl BufRead, read_value: ReadValue<'_>) -> Result<Survey, InputErrors> {
    let mut lines = Lines { name: name.to_string(), file, number: 0 };
    let mut survey = Survey { can_be_streamed: true, agents: BTreeSet::new() };
    let (mut faults, mut last) = (Vec::new(), Time::ZERO);
    loop {
        match lines.next(read_value) {
            Ok(None) => break,
            Ok(Some(input)) => {
                let acknowledges = matches!(input.kind, EventKind::CommandAcknowledged(..));
                survey.can_be_streamed &= input.at >= last && !acknowledges && input.command_form.is_none();
                last = input.at;
                survey.agents.extend(input.agent);
            }
            Err(fault) => {
                faults.push(fault);
                if faults.len() == INPUT_MESSAGES_MAX {
                    faults.push(format!("{name}: further faults are not shown"));
                    break;
                }
            }
        }
    }
    if faults.is_empty() { Ok(survey) } else { Err(InputErrors(faults)) }
}

/// The lines of a file, of bounded length.
struct Lines<R> {
    name: String,
    file: R,
    /// Number of the last line that was read, from 1.
    number: usize,
}

impl<R: BufRead> Lines<R> {
    /// Returns the next input; `None` at the end.
    fn next(&mut self, read_value: ReadValue<'_>) -> Result<Option<Input>, String> {
        loop {
            let Some(line) = self.line()? else { return Ok(None) };
            let text = std::str::from_utf8(&line)
                .map_err(|error| format!("{}:{}: this is not UTF-8 text: {error}", self.name, self.number))?;
            let text = if self.number == 1 { text.strip_prefix('\u{feff}').unwrap_or(text) } else { text };
            if let Some(input) = read_numbered(&self.name, self.number, text, read_value)? {
                return Ok(Some(input));
            }
        }
    }

    fn line(&mut self) -> Result<Option<Vec<u8>>, String> {
        let unreadable = |name: &str, error: io::Error| format!("{name} cannot be read: {error}");
        let mut line = Vec::new();
        let most = INPUT_LINE_BYTES_MAX as u64 + 1;
        let read = self.file.by_ref().take(most).read_until(b'\n', &mut line);
        let read = read.map_err(|error| unreadable(&self.name, error))?;
        if read == 0 {
            return Ok(None);
        }
        self.number += 1;
        if line.len() > INPUT_LINE_BYTES_MAX && line.last() != Some(&b'\n') {
            // The rest belongs to the same line.
            self.skip().map_err(|error| unreadable(&self.name, error))?;
            return Err(format!("{}:{}: the line is longer than {INPUT_LINE_BYTES_MAX} bytes", self.name, self.number));
        }
        Ok(Some(line))
    }

    /// Reads to the end of the line.
    fn skip(&mut self) -> io::Result<()> {
        loop {
            let chunk = self.file.fill_buf()?;
            let end = chunk.iter().position(|byte| *byte == b'\n');
            let (length, is_over) = (end.map_or(chunk.len(), |end| end + 1), end.is_some() || chunk.is_empty());
            self.file.consume(length);
            if is_over {
                return Ok(());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::value::Value;

    fn read_value(text: &str) -> Result<Value, String> {
        let inside = text.strip_prefix('(').and_then(|text| text.strip_suffix(')'));
        inside.map(|words| Value::list(words.split(' ').map(Value::symbol))).ok_or_else(|| "expected a form".into())
    }

    fn surveyed(text: &str) -> Result<Survey, String> {
        survey("in.jsonl", text.as_bytes(), &read_value).map_err(|errors| errors.to_string())
    }

    #[test]
    fn lines_in_order_are_streamed_and_others_are_not() {
        let text =
            "\u{feff}# inputs\n\n{\"t\": 1, \"event\": \"(a)\", \"agent\": \"pilot\"}\n{\"t\": 1, \"event\": \"(b)\"}";
        let found = surveyed(text).unwrap();
        assert!(found.can_be_streamed && found.agents.contains(&Symbol::new("pilot")), "{found:?}");
        for text in [
            "{\"t\": 2, \"event\": \"(a)\"}\n{\"t\": 1, \"event\": \"(b)\"}",
            "{\"t\": 2, \"acknowledge\": 3}",
            "{\"t\": 2, \"acknowledge\": \"(fly)\"}",
        ] {
            assert!(!surveyed(text).unwrap().can_be_streamed, "{text}");
        }
        let mut stream = InputStream::new("in.jsonl", Box::new(text.as_bytes()), found.agents, Box::new(read_value));
        assert_eq!(stream.next_at(), Some(Time::from_seconds(1.0)));
        assert_eq!(stream.take_due(Time::ZERO), Ok(None));
        let mut taken = Vec::new();
        while let Some(input) = stream.take_due(Time::END).unwrap() {
            taken.push(input.kind);
        }
        assert_eq!((taken.len(), stream.next_at()), (2, None));
    }

    #[test]
    fn bad_lines_are_named_before_the_run() {
        let long = "x".repeat(INPUT_LINE_BYTES_MAX + 5);
        let faults = surveyed(&format!("{{\"t\": 1}}\n{long}\n{{\"t\": 1, \"event\": \"x\"}}\n")).unwrap_err();
        for part in ["in.jsonl:1", "in.jsonl:2: the line is longer", "in.jsonl:3"] {
            assert!(faults.contains(part), "{part}: {faults}");
        }
        assert!(surveyed(&"nonsense\n".repeat(100)).unwrap_err().contains("further faults are not shown"));
    }

    #[test]
    fn a_file_that_changed_is_a_fault() {
        let text = "{\"t\": 2, \"event\": \"(a)\"}\n{\"t\": 1, \"event\": \"(b)\"}\n";
        let mut stream = InputStream::new("in.jsonl", Box::new(text.as_bytes()), BTreeSet::new(), Box::new(read_value));
        assert!(stream.take_due(Time::END).unwrap().is_some());
        assert!(stream.take_due(Time::END).unwrap_err().contains("was changed"));
    }
}
