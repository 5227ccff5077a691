//! Messages as text for a terminal: file, line, column, the source line, reason and help.

use crate::diagnostic::{Diagnostic, Severity, Span};
use crate::fix::Applicability;
use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use apex_model::source::SourceFile;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;

/// A marked span with the text shown at it.
type Mark<'d> = (Span, AnnotationKind, Option<&'d str>);

/// Maximum number of characters of one part of a message.
const PART_CHARS_MAX: usize = 2_000;

/// Renders `diagnostics` over the `sources` that their spans index, in order; with terminal colours if `color`.
pub fn render(diagnostics: &[Diagnostic], sources: &[SourceFile], color: bool) -> String {
    let renderer = if color { Renderer::styled() } else { Renderer::plain() };
    let mut text = String::new();
    for diagnostic in diagnostics {
        text.push_str(&render_one(diagnostic, sources, &renderer));
        text.push_str("\n\n");
    }
    text
}

fn render_one(diagnostic: &Diagnostic, sources: &[SourceFile], renderer: &Renderer) -> String {
    let level = match diagnostic.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
        Severity::Note => Level::NOTE,
    };
    let mut by_file: BTreeMap<u32, Vec<Mark<'_>>> = BTreeMap::new();
    by_file.entry(diagnostic.span.file).or_default().push((diagnostic.span, AnnotationKind::Primary, None));
    for label in &diagnostic.labels {
        by_file.entry(label.span.file).or_default().push((label.span, AnnotationKind::Context, Some(&label.text)));
    }
    let mut group = level
        .primary_title(printable(&diagnostic.message))
        .id(diagnostic.code)
        .elements(Vec::<Snippet<'_, annotate_snippets::Annotation<'_>>>::new());
    let first = by_file.remove(&diagnostic.span.file).map(|spans| (diagnostic.span.file, spans));
    for (file, spans) in first.into_iter().chain(by_file) {
        let Some(source) = usize::try_from(file).ok().and_then(|index| sources.get(index)) else { continue };
        group = group.element(snippet(source, &spans));
    }
    if let Some(reason) = &diagnostic.reason {
        group = group.element(Level::NOTE.with_name("reason").message(printable(reason)));
    }
    for help in &diagnostic.help {
        group = group.element(Level::HELP.message(printable(help)));
    }
    for fix in &diagnostic.fixes {
        let name = match fix.applicability {
            Applicability::Safe => "fix",
            Applicability::NeedsLook => "possible fix",
        };
        group = group.element(Level::HELP.with_name(name).message(printable(&fix.title)));
    }
    renderer.render(&[group])
}

/// Returns a part of a message as it is printed: words of the program in it may be of any length and may have control characters, which are
/// commands to a terminal, or marks that change the direction of writing.
fn printable(text: &str) -> Cow<'_, str> {
    let is_plain = |each: char| {
        each == '\n' || !(each.is_control() || matches!(each, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}'))
    };
    let end = text.char_indices().nth(PART_CHARS_MAX).map(|(end, _)| end);
    let part = end.and_then(|end| text.get(..end)).unwrap_or(text);
    if end.is_none() && part.chars().all(is_plain) {
        return Cow::Borrowed(text);
    }
    let mut printed = String::with_capacity(part.len());
    for each in part.chars() {
        if is_plain(each) {
            printed.push(each);
        } else {
            printed.extend(each.escape_unicode());
        }
    }
    if end.is_some() {
        printed.push_str(" ..");
    }
    Cow::Owned(printed)
}

/// Returns the lines of the spans, with the spans marked. Long spans are cut after their first line, so that a message about a form does
/// not print the whole form.
fn snippet<'s>(source: &'s SourceFile, spans: &[Mark<'s>]) -> Snippet<'s, annotate_snippets::Annotation<'s>> {
    let ranges: Vec<Range<usize>> = spans.iter().map(|(span, ..)| first_line(&source.text, span)).collect();
    let start = ranges.iter().map(|range| range.start).min().unwrap_or(0);
    let end = ranges.iter().map(|range| range.end).max().unwrap_or(0);
    let line = spans.iter().map(|(span, ..)| span.line).min().unwrap_or(1);
    let from = source.text.get(..start).and_then(|before| before.rfind('\n')).map_or(0, |at| at + 1);
    let rest = source.text.get(end..).unwrap_or("");
    let to = end + rest.find('\n').unwrap_or(rest.len());
    let text = source.text.get(from..to).unwrap_or("");
    let annotations = spans.iter().zip(ranges).map(|((_, kind, label), range)| {
        let annotation = kind.span(range.start.saturating_sub(from)..range.end.saturating_sub(from));
        match label {
            Some(label) => annotation.label(printable(label)),
            None => annotation,
        }
    });
    let line = usize::try_from(line).unwrap_or(1);
    Snippet::source(text).path(&*source.name).line_start(line).annotations(annotations)
}

/// Returns the part of a span on its first line; byte offsets that are always inside of the text.
fn first_line(text: &str, span: &Span) -> Range<usize> {
    let bound = |offset: u32| usize::try_from(offset).unwrap_or(usize::MAX).min(text.len());
    let (start, end) = (bound(span.start), bound(span.end));
    let end = match text.get(start..end).and_then(|inside| inside.find('\n')) {
        Some(length) => start + text.get(start..start + length).map_or(length, |line| line.trim_end().len()),
        None => end,
    };
    start..end.max(start)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codes;
    use crate::fix::Fix;
    use std::sync::Arc;

    #[test]
    fn words_of_the_program_neither_command_the_terminal_nor_flood_it() {
        let sources = [SourceFile { name: Arc::from("a.pdl"), text: Arc::from("(st\u{1b}ep)") }];
        let span = Span { file: 0, start: 1, end: 6, line: 1, column: 2 };
        let word = format!("st\u{1b}ep\u{202e}{}", "x".repeat(5_000_000));
        let diagnostic = Diagnostic::error(codes::MALFORMED_CONDITION, span, word.clone())
            .label(span, word.clone())
            .reason(word.clone())
            .help(word.clone())
            .fix(Fix::look(word.clone()));
        let text = render(&[diagnostic], &sources, false);
        assert!(text.contains("= reason: st\\u{1b}ep\\u{202e}xxx"), "{text}");
        assert!(!text.contains('\u{1b}') && !text.contains('\u{202e}'), "{text}");
        assert!(text.len() < 40_000, "{}", text.len());
    }
}
