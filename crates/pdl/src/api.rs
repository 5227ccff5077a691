//! Small entry points of the front end: one value, one condition, the table of codes.

use crate::check::CheckOptions;
use crate::codes::{self, ErrorCode, TABLE};
use crate::diagnostic::{Diagnostic, Severity, Span};
use crate::host::host_names;
use crate::lower::{Lowering, Scope};
use crate::read::read_file;
use apex_model::condition::Condition;
use apex_model::value::Value;

/// Returns all codes of messages, in order.
pub fn error_codes() -> &'static [ErrorCode] {
    TABLE
}

/// Returns the code written as `text`, in any case and also without its zeros: `E0203`, `e203`.
pub fn error_code(text: &str) -> Option<&'static ErrorCode> {
    let key = |code: &str| {
        let digits = code.trim_start_matches(|letter: char| letter.is_ascii_alphabetic());
        let letters = code.get(..code.len() - digits.len()).unwrap_or_default();
        (letters.to_ascii_uppercase(), digits.trim_start_matches('0').to_string())
    };
    TABLE.iter().find(|known| key(known.code) == key(text.trim()))
}

/// Reads one datum, for example `(altitude ac-1)`, `35kt` or `(stop)`. Nothing is evaluated.
///
/// # Errors
/// A message if the text is not PDL or holds no datum or several.
#[expect(clippy::result_large_err, reason = "the message is made once and shown at once")]
pub fn read_value(text: &str) -> Result<Value, Diagnostic> {
    let read = read_file(0, text);
    if let Some(diagnostic) = read.diagnostics.into_iter().next() {
        return Err(diagnostic);
    }
    match read.data.as_slice() {
        [one] => Ok(one.to_value()),
        [] => {
            let span = Span { line: 1, column: 1, ..Span::default() };
            Err(Diagnostic::error(codes::NOT_ONE_DATUM, span, "expected a value, found none"))
        }
        [_, second, ..] => Err(Diagnostic::error(codes::NOT_ONE_DATUM, second.span, "a second value follows")
            .reason("exactly one value is expected")
            .help("to hand over several values, put them into one list")),
    }
}

/// A condition alone, with the messages about it.
#[derive(Clone, Debug)]
pub struct ParsedCondition {
    /// The condition; `None` if it could not be read.
    pub condition: Option<Condition>,
    /// Messages; their spans are in source 0.
    pub diagnostics: Vec<Diagnostic>,
}

/// Parses a single condition. State variables are undeclared and steps unknown, so this is for pieces of text: with `fragment`, undefined
/// names and a stray `)` are tolerated.
pub fn parse_condition(text: &str, options: CheckOptions<'_>) -> ParsedCondition {
    let read = read_file(0, text);
    let mut diagnostics = read.diagnostics;
    for diagnostic in diagnostics.iter_mut().filter(|each| options.fragment && each.code == codes::UNMATCHED_CLOSE) {
        diagnostic.severity = Severity::Warning;
    }
    if diagnostics.iter().any(|each| each.severity == Severity::Error) {
        return ParsedCondition { condition: None, diagnostics };
    }
    let mut lowering = Lowering::new(host_names(options.host), options.fragment);
    lowering.scope = Scope::of_tasks();
    let conditions = lowering.conditions(&read.data);
    let condition = match conditions.map(|mut all| (all.pop(), all.is_empty())) {
        Some((Some(condition), true)) => Some(condition),
        Some(_) => {
            let span = read.data.get(1).map_or(Span { line: 1, column: 1, ..Span::default() }, |datum| datum.span);
            lowering.report(Diagnostic::error(codes::NOT_ONE_DATUM, span, "exactly one condition is expected"));
            None
        }
        None => None,
    };
    if !options.fragment {
        lowering.finish_scope(condition.is_some());
    }
    lowering.report_unknown_names();
    diagnostics.append(&mut lowering.diagnostics);
    diagnostics.sort_by_key(|each| (each.span.line, each.span.column, each.severity));
    ParsedCondition { condition, diagnostics }
}
