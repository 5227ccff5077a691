//! Messages about text that is not a sequence of data: unmatched parentheses, strings and comments.

use super::quotes::{Forgotten, forgotten};
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::fix::Fix;
use crate::syntax::{Bracketed, Flaw, FlawKind, Repair, Repaired, repairs};
use apex_model::limits::READ_DEPTH_MAX;

/// Returns one diagnostic for each flaw; for the forgotten or superfluous parenthesis itself, if it can be determined.
pub(super) fn describe(file: u32, text: &str, flaws: &[Flaw]) -> Vec<Diagnostic> {
    if flaws.iter().any(|flaw| flaw.kind == FlawKind::UnclosedText)
        && let Some(quote) = forgotten(text)
    {
        // All other flaws may be consequences of this one.
        return vec![about_quote(file, text, quote)];
    }
    let is_parenthesis = |flaw: &Flaw| matches!(flaw.kind, FlawKind::UnmatchedClose | FlawKind::UnclosedList { .. });
    let only_parentheses = flaws.iter().all(is_parenthesis);
    let repaired = if flaws.is_empty() || !only_parentheses { Vec::new() } else { repairs(text) };
    let is_repaired = |flaw: &Flaw| repaired.iter().any(|form| (form.start..form.end).contains(&flaw.start));
    let others = flaws.iter().filter(|flaw| !is_repaired(flaw)).map(|flaw| plain(file, text, flaw));
    repaired.iter().map(|form| about(file, text, form)).chain(others).collect()
}

/// Returns one diagnostic for each pair of brackets.
pub(super) fn brackets(file: u32, text: &str, found: &[Bracketed]) -> Vec<Diagnostic> {
    let about = |pair: &Bracketed| {
        let place = |at: usize| locate(file, text, at, at + 1);
        let first = place(pair.open.or(pair.close)?);
        let (message, title) = match (pair.open, pair.close) {
            (Some(_), Some(_)) => ("this list is written with brackets", "write `(` and `)`"),
            (Some(_), None) => ("this list begins with a bracket", "write `(`"),
            _ => ("this list ends with a bracket", "write `)`"),
        };
        let mut diagnostic = Diagnostic::error(codes::BRACKET, first, message);
        let mut fix = Fix::safe(title);
        if let Some(open) = pair.open {
            fix = fix.replace(place(open), "(");
        }
        if let Some(close) = pair.close {
            fix = fix.replace(place(close), ")");
        }
        if pair.open.is_some()
            && let Some(close) = pair.close
        {
            diagnostic = diagnostic.label(place(close), "to here");
        }
        Some(diagnostic.reason("lists are written in parentheses only").fix(fix))
    };
    found.iter().filter_map(about).collect()
}

/// Double and single quotation marks of typography: an editor for prose writes them in place of `"` and `'`.
const TYPOGRAPHIC: &[(char, &str)] = &[
    ('\u{201c}', "\""),
    ('\u{201d}', "\""),
    ('\u{201e}', "\""),
    ('\u{201f}', "\""),
    ('\u{ab}', "\""),
    ('\u{bb}', "\""),
    ('\u{2018}', "'"),
    ('\u{2019}', "'"),
];

/// Returns the message about a word with typographic quotation marks: double ones anywhere, single ones at its beginning, since names may
/// contain an apostrophe.
pub(super) fn typographic_quote(word: &str, span: Span) -> Option<Diagnostic> {
    let plain = |mark: char| TYPOGRAPHIC.iter().find(|(own, _)| *own == mark).map(|(_, plain)| *plain);
    let at_start = word.chars().next().and_then(plain);
    let is_double = word.chars().any(|mark| plain(mark) == Some("\""));
    if !is_double && at_start.is_none() {
        return None;
    }
    let written: String =
        word.chars().map(|mark| plain(mark).map_or_else(|| mark.to_string(), str::to_string)).collect();
    let message = match is_double {
        true => "a string is written between two `\"`, not between typographic quotation marks",
        false => "a quote is written `'`, not as a typographic quotation mark",
    };
    let diagnostic = Diagnostic::error(codes::TYPOGRAPHIC_QUOTE, span, message);
    Some(
        diagnostic
            .reason("as written, the marks are letters of a word")
            .fix(Fix::safe(format!("write `{written}`")).replace(span, written)),
    )
}

/// Returns the message about a quotation mark.
fn about_quote(file: u32, text: &str, quote: Forgotten) -> Diagnostic {
    let fix = if quote.is_certain { Fix::safe("add `\"` here") } else { Fix::look("add `\"` here") };
    let last = text.get(..quote.at).and_then(|before| before.char_indices().next_back());
    let span = locate(file, text, last.map_or(quote.at, |(last, _)| last), quote.at);
    let next = text.get(quote.at..).and_then(|after| after.chars().next());
    let opens = next.is_some_and(|next| !next.is_whitespace() && next != ')');
    let span = if opens { locate(file, text, quote.at, quote.at + next.map_or(0, char::len_utf8)) } else { span };
    let message = if opens { "this string has no opening `\"`" } else { "this string is never closed" };
    let diagnostic = Diagnostic::error(codes::UNCLOSED_STRING, span, message);
    let fix = if opens { fix.insert_before(span, "\"") } else { fix.insert_after(span, "\"") };
    diagnostic.fix(fix).help("a `\"` inside a string is written `\\\"`")
}

/// Returns the message about one parenthesis.
fn about(file: u32, text: &str, form: &Repaired) -> Diagnostic {
    let fix = |title: &str| if form.is_certain { Fix::safe(title) } else { Fix::look(title) };
    match form.repair {
        Repair::Close { at, opened } => {
            // The last character before the place, so that a visible character is marked.
            let last = text.get(..at).and_then(|before| before.char_indices().next_back()).map_or(at, |(last, _)| last);
            let span = locate(file, text, last, at);
            let list = text.get(opened..).unwrap_or_default().lines().next().unwrap_or_default();
            let head: String = list.chars().take_while(|c| !c.is_whitespace() && *c != ')').take(40).collect();
            Diagnostic::error(
                codes::UNCLOSED_LIST,
                span,
                format!("a `)` is missing after this: `{head} ..` is never closed"),
            )
            .label(locate(file, text, opened, opened + 1), "this list")
            .reason("the indentation and the shapes of the forms around it show this")
            .fix(fix("add `)` here").insert_after(span, ")"))
        }
        Repair::Remove { at } => {
            let span = locate(file, text, at, at + 1);
            Diagnostic::error(codes::UNMATCHED_CLOSE, span, "superfluous `)`")
                .reason("it closes a list earlier than the indentation and the shapes of the forms around it show")
                .fix(fix("remove this `)`").replace(span, ""))
        }
        Repair::Open { at } => {
            let word: String =
                text.get(at..).unwrap_or_default().chars().take_while(|c| !c.is_whitespace() && *c != ')').collect();
            let span = locate(file, text, at, at + word.len());
            Diagnostic::error(codes::UNMATCHED_CLOSE, span, format!("a `(` is missing before `{word}`"))
                .reason("there is one `)` too many, and the shapes of the forms around it show that a list begins here")
                .fix(fix("add `(` here").insert_before(span, "("))
        }
    }
}

/// Returns the place of a byte range. Its cost is a walk over the preceding text, so it is used for flaws only, which are few.
fn locate(file: u32, text: &str, start: usize, end: usize) -> Span {
    let before = text.get(..start).unwrap_or(text);
    let line = 1 + before.bytes().filter(|byte| *byte == b'\n').count();
    let column = 1 + before.rsplit('\n').next().map_or(0, |last| last.trim_start_matches('\u{feff}').chars().count());
    let size = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
    Span { file, start: size(start), end: size(end), line: size(line), column: size(column) }
}

fn plain(file: u32, text: &str, flaw: &Flaw) -> Diagnostic {
    let span = locate(file, text, flaw.start, flaw.end);
    match flaw.kind {
        FlawKind::UnmatchedClose => Diagnostic::error(codes::UNMATCHED_CLOSE, span, "unmatched )")
            .reason("every list before it is closed already")
            .help("remove it, or add the `(` that it should close"),
        FlawKind::UnclosedList { suspect, next } => {
            let mut diagnostic = Diagnostic::error(codes::UNCLOSED_LIST, span, "this ( is never closed");
            if let Some(suspect) = suspect {
                let place = locate(file, text, suspect, suspect + 1);
                diagnostic = diagnostic.label(place, "by the indentation, this list lacks its `)`");
            }
            match next {
                Some(next) => {
                    let place = locate(file, text, next, next + 1);
                    diagnostic.label(place, "a new form begins here").help("add `)` before the new form")
                }
                None => diagnostic.reason("the text ends inside this list").help("add the missing `)`"),
            }
        }
        FlawKind::UnclosedText => Diagnostic::error(codes::UNCLOSED_STRING, span, "this string is never closed")
            .help("add the closing `\"`; a `\"` inside a string is written `\\\"`"),
        FlawKind::UnclosedComment => {
            Diagnostic::error(codes::UNCLOSED_COMMENT, span, "this comment is never closed").help("add `|#`")
        }
        FlawKind::DanglingPrefix => {
            let mark = text.get(flaw.start..flaw.end).unwrap_or("'");
            Diagnostic::error(codes::DANGLING_PREFIX, span, format!("nothing follows this {mark}"))
                .help("remove it, or write what it applies to")
        }
        FlawKind::TooDeep => {
            Diagnostic::error(codes::TOO_DEEP, span, format!("lists are nested deeper than {READ_DEPTH_MAX}"))
                .help("split the form into several procedures or functions")
        }
    }
}
