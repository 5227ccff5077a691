//! Reads one live source: its lines become inputs, passed in groups if several arrive together.

use super::class::SourceClass;
use super::fault_messages::FaultMessages;
use super::introduction::Introduction;
use super::queue::LiveInput;
use super::sources::{LiveSource, LiveSources};
use crate::limits::INPUT_LINE_BYTES_MAX;
use crate::live_lines::OpenQuestions;
use crate::run_settings::Control;
use apex_model::event::EventKind;
use apex_model::value::Value;
use serde_json::json;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Maximum number of simultaneous connections, including those that are not admitted yet: each has a thread.
const CONNECTIONS_MAX: usize = 96;
/// Maximum number of inputs that are passed to the run at once.
const GROUP_MAX: usize = 256;
/// Maximum number of remembered texts of state variables that a source repeats.
const KNOWN_TEXTS_MAX: usize = 4_096;
/// Maximum length of such a text in bytes.
const KNOWN_TEXT_BYTES_MAX: usize = 200;
/// Maximum number of bytes that are read at once.
const READ_BYTES: usize = 64 << 10;
/// Time limit for an answer to a source; a source that does not read gets none.
const ANSWER_PATIENCE: Duration = Duration::from_millis(20);

/// The means to read lines of sources, and the destination of messages about them.
#[derive(Clone)]
pub struct LineReader {
    /// The questions that an answer may be to.
    pub open: OpenQuestions,
    /// Reads a value in PDL.
    pub read_value: fn(&str) -> Result<Value, String>,
    /// Prints a message about lines that are not understood.
    pub note: fn(&str),
}

/// A source with its answers.
struct Hearing<'a> {
    source: &'a LiveSource,
    reader: &'a LineReader,
    /// The connection, for answers to a source that has introduced itself.
    answers: Option<&'a TcpStream>,
}

/// Reads lines without a connection, such as those of standard input, from a source that gets no answers.
pub fn hear_lines(lines: impl Read, source: &LiveSource, reader: &LineReader) {
    hear(None, lines, &Hearing { source, reader, answers: None });
}

/// Connections that have not sent a line yet, by number. They have no class, so they may not keep out an operator.
type SilentConnections = Arc<Mutex<BTreeMap<u64, TcpStream>>>;

/// Hears every connection to `listener` on a separate thread, up to the limit. At the limit, the connection that has been silent longest
/// since its beginning gives its place to a new one.
pub fn hear_connections(listener: TcpListener, sources: &LiveSources, reader: &LineReader) {
    let (sources, reader, connections) = (sources.clone(), reader.clone(), Arc::new(AtomicUsize::new(0)));
    let silent = SilentConnections::default();
    std::thread::spawn(move || {
        for (number, stream) in (0..).zip(listener.incoming().flatten()) {
            let (sources, reader, connections) = (sources.clone(), reader.clone(), Arc::clone(&connections));
            let all = format!("{CONNECTIONS_MAX} connections are open, which is the limit");
            if connections.load(Ordering::Acquire) >= CONNECTIONS_MAX && !end_oldest(&silent, &all) {
                refuse(&stream, &all);
                continue;
            }
            connections.fetch_add(1, Ordering::AcqRel);
            let silent = Arc::clone(&silent);
            if let Ok(handle) = stream.try_clone() {
                silent.lock().unwrap_or_else(PoisonError::into_inner).insert(number, handle);
            }
            std::thread::spawn(move || {
                hear_connection(&stream, &sources, &reader, || {
                    silent.lock().unwrap_or_else(PoisonError::into_inner).remove(&number);
                });
                connections.fetch_sub(1, Ordering::AcqRel);
            });
        }
    });
}

/// Ends the oldest connection without a line; returns false if there is none.
fn end_oldest(silent: &SilentConnections, reason: &str) -> bool {
    let Some((_, stream)) = silent.lock().unwrap_or_else(PoisonError::into_inner).pop_first() else { return false };
    refuse(&stream, reason);
    stream.shutdown(Shutdown::Both).is_ok()
}

/// Hears a connection to the port; calls `heard` after its first line or its end.
fn hear_connection(stream: &TcpStream, sources: &LiveSources, reader: &LineReader, heard: impl FnOnce()) {
    stream.set_write_timeout(Some(ANSWER_PATIENCE)).unwrap_or_default();
    let reading = stream.try_clone();
    let mut lines = reading.map(|reading| BufReader::with_capacity(READ_BYTES, reading));
    // The first line may introduce the source: operators and safing programs are always admitted.
    let first = lines.as_mut().ok().and_then(first_line);
    heard();
    let (Some(first), Ok(lines)) = (first, lines) else { return };
    let class = match first.as_deref().ok().and_then(Introduction::read) {
        Some(Ok(introduction)) => introduction.class,
        _ => SourceClass::Feed,
    };
    match sources.admit(class) {
        Ok(source) => {
            let hearing = Hearing { source: &source, reader, answers: Some(stream) };
            hear(Some(first), lines, &hearing);
        }
        Err(fault) => refuse(stream, &fault),
    }
}

/// Informs a connection why it is refused.
fn refuse(stream: &TcpStream, fault: &str) {
    stream.set_write_timeout(Some(ANSWER_PATIENCE)).unwrap_or_default();
    // The result does not depend on whether the peer reads it.
    let mut stream = stream;
    writeln!(stream, "{}", json!({"error": fault})).unwrap_or_default();
}

/// A line of a source, or the reason for which it is refused.
type SourceLine = Result<String, String>;

/// Returns the first line with content.
fn first_line(lines: &mut impl BufRead) -> Option<SourceLine> {
    loop {
        let line = next_line(lines)?;
        if !is_without_content(&line) {
            return Some(line);
        }
    }
}

fn is_without_content(line: &SourceLine) -> bool {
    line.as_ref().is_ok_and(|line| line.is_empty() || line.starts_with('#'))
}

/// Returns the next line without its end; `None` if there are no more. A line that is too long is refused with its rest, which must not be
/// taken for another line.
fn next_line(lines: &mut impl BufRead) -> Option<SourceLine> {
    let mut bytes = Vec::new();
    let read = lines.by_ref().take(INPUT_LINE_BYTES_MAX as u64 + 1).read_until(b'\n', &mut bytes);
    if !read.is_ok_and(|count| count > 0) {
        return None;
    }
    if bytes.len() > INPUT_LINE_BYTES_MAX && !bytes.ends_with(b"\n") {
        lines.skip_until(b'\n').ok()?;
        return Some(Err(format!("the line is longer than {INPUT_LINE_BYTES_MAX} bytes")));
    }
    let text = std::str::from_utf8(&bytes).map(|text| text.trim().to_string());
    Some(text.map_err(|error| format!("the line is not UTF-8 text: {error}")))
}

/// Reads a source, whose first line may have been read already, until its lines end or the run is over.
fn hear(mut first: Option<SourceLine>, lines: impl Read, hearing: &Hearing<'_>) {
    let mut lines = BufReader::with_capacity(READ_BYTES, lines);
    let (mut messages, known) = (FaultMessages::new(hearing.reader.note), KnownTexts::new(hearing.reader.read_value));
    let mut group = Vec::new();
    let mut not_understood = 0;
    while let Some(line) = first.take().or_else(|| next_line(&mut lines)) {
        if !is_without_content(&line) {
            match line.and_then(|line| understand(&line, hearing, &known)) {
                Ok(control) => group.extend(control),
                Err(fault) => {
                    not_understood += 1;
                    if messages.admits() {
                        let name = hearing.source.name();
                        messages.print(name.as_deref(), &fault);
                        if name.is_some() {
                            answer(hearing, &json!({"error": fault}));
                        }
                    }
                }
            }
        }
        // Complete lines are read first and printed at once.
        if group.len() >= GROUP_MAX || !lines.buffer().contains(&b'\n') {
            if not_understood > 0 {
                hearing.source.not_understood(std::mem::take(&mut not_understood));
            }
            if !group.is_empty() && !hearing.source.say(group.drain(..)) {
                return;
            }
        }
    }
    messages.print_hidden(hearing.source.name().as_deref());
}

/// Reads a line; returns none for an introduction.
fn understand(line: &str, hearing: &Hearing<'_>, known: &KnownTexts) -> Result<Option<LiveInput>, String> {
    if let Some(introduction) = Introduction::read(line) {
        let introduction = introduction?;
        hearing.source.introduce(&introduction)?;
        answer(hearing, &json!({"source": introduction.name, "class": introduction.class.word()}));
        return Ok(None);
    }
    let control = hearing.reader.open.understand(line, &|text| known.read(text))?;
    check_class(hearing.source.stated_class(), &control)?;
    Ok(match control {
        Control::Input(kind) => Some(LiveInput::Event(None, kind)),
        Control::InputFor(agent, kind) => Some(LiveInput::Event(Some(agent), kind)),
        Control::Stop => Some(LiveInput::Stop),
        // Lines of sources never have these kinds.
        Control::Pace(_) | Control::Command(_) | Control::Look | Control::Quiet => None,
    })
}

/// Checks that a source of this class may send an input. A source without an introduction has no class, and is not limited.
fn check_class(class: Option<SourceClass>, control: &Control) -> Result<(), String> {
    let Some(class) = class else { return Ok(()) };
    let (is_permitted, what, who) = match control {
        Control::Stop => (class.may_stop(), "ends the run", "operator or safing"),
        Control::Input(kind) | Control::InputFor(_, kind) => match kind {
            EventKind::CommandAcknowledged(..) | EventKind::CommandProgressed(..) => {
                (class.may_acknowledge(), "acknowledges commands", "vehicle")
            }
            EventKind::OperatorAnswered(..) => (class.may_answer(), "answers questions", "operator"),
            _ => return Ok(()),
        },
        _ => return Ok(()),
    };
    match is_permitted {
        true => Ok(()),
        false => Err(format!("a source of class {} never {what}; introduce it as {who}", class.word())),
    }
}

fn answer(hearing: &Hearing<'_>, line: &serde_json::Value) {
    if let Some(mut stream) = hearing.answers {
        // A source that does not read its answers is still read.
        writeln!(stream, "{line}").unwrap_or_default();
    }
}

/// Parsed forms of repeated texts: a source measures the same variables again and again.
struct KnownTexts {
    known: RefCell<BTreeMap<String, Value>>,
    read_value: fn(&str) -> Result<Value, String>,
}

impl KnownTexts {
    fn new(read_value: fn(&str) -> Result<Value, String>) -> KnownTexts {
        KnownTexts { known: RefCell::default(), read_value }
    }

    fn read(&self, text: &str) -> Result<Value, String> {
        if let Some(value) = self.known.borrow().get(text) {
            return Ok(value.clone());
        }
        let value = (self.read_value)(text)?;
        let mut known = self.known.borrow_mut();
        if text.len() <= KNOWN_TEXT_BYTES_MAX {
            if known.len() >= KNOWN_TEXTS_MAX {
                known.clear();
            }
            known.insert(text.to_string(), value.clone());
        }
        Ok(value)
    }
}

#[cfg(test)]
#[path = "hearing_tests.rs"]
mod tests;
