//! Finds the range of text at a place. The library stores only where things begin; messages also need to know where they end.

use crate::diagnostic::Span;
use crate::fix::Fix;
use crate::read::{Datum, DatumKind, read_file};
use apex_model::source::{Place, SourceFile};
use apex_model::symbol::Symbol;
use std::collections::BTreeMap;

/// Finds the text of places.
pub(crate) struct Locator<'l> {
    sources: &'l [SourceFile],
    /// Byte offsets of the lines of each requested file.
    lines: BTreeMap<u32, Vec<usize>>,
}

impl<'l> Locator<'l> {
    /// Returns a locator over the texts of a library.
    pub(crate) fn new(sources: &'l [SourceFile]) -> Locator<'l> {
        Locator { sources, lines: BTreeMap::new() }
    }

    /// Returns the datum that begins at `place`, with its spans.
    pub(crate) fn datum(&mut self, place: Place) -> Option<Datum> {
        let source = self.sources.get(usize::try_from(place.file).ok()?)?;
        let text: &str = &source.text;
        let lines = self.lines.entry(place.file).or_insert_with(|| {
            std::iter::once(0).chain(text.match_indices('\n').map(|(offset, _)| offset + 1)).collect()
        });
        let start = *lines.get(usize::try_from(place.line).ok()?.checked_sub(1)?)?;
        let column = usize::try_from(place.column).ok()?.checked_sub(1)?;
        let (within, _) = text.get(start..)?.char_indices().nth(column)?;
        let offset = start + within;
        let rest = text.get(offset..)?;
        let data = read_file(place.file, rest.get(..datum_length(rest))?).data;
        let mut datum = data.into_iter().next()?;
        shift(&mut datum, u32::try_from(offset).ok()?, place);
        Some(datum)
    }

    /// Returns the text of a span.
    pub(crate) fn text(&self, span: Span) -> Option<&'l str> {
        let source = self.sources.get(usize::try_from(span.file).ok()?)?;
        source.text.get(usize::try_from(span.start).ok()?..usize::try_from(span.end).ok()?)
    }

    /// Returns the range of the datum at `place`; an empty one there if the text is not available.
    pub(crate) fn span(&mut self, place: Place) -> Span {
        let nowhere = Span { file: place.file, start: 0, end: 0, line: place.line, column: place.column };
        self.datum(place).map_or(nowhere, |datum| datum.span)
    }

    /// Returns the clause `name` of the form at `place`, else the whole form.
    pub(crate) fn clause(&mut self, place: Place, name: &str) -> Span {
        let datum = self.datum(place);
        let clause = datum.as_ref().and_then(|form| form.tail().iter().find(|part| part.head_name() == name));
        clause.map_or_else(|| self.span(place), |clause| clause.span)
    }

    /// Returns the text to remove so that the step at `place` no longer waits for the condition at `condition`: the condition, or the
    /// whole clause if it is the only one. `None` for a part of another condition.
    pub(crate) fn wait(&mut self, place: Place, condition: Span) -> Option<Span> {
        let datum = self.datum(place)?;
        let clause = datum.tail().iter().find(|part| part.head_name() == "waitfor")?;
        clause.tail().iter().any(|part| part.span == condition).then_some(())?;
        Some(if clause.tail().len() == 1 { clause.span } else { condition })
    }

    /// Returns a wait for the end of `tag`, added to the step at `place`.
    pub(crate) fn add_wait(&mut self, place: Place, tag: &Symbol) -> Option<Fix> {
        let datum = self.datum(place)?;
        let clause = datum.tail().iter().find(|part| part.head_name() == "waitfor");
        let (form, text) = match clause {
            Some(clause) => (clause.span, format!(" (end ?{tag})")),
            None => (datum.span, format!(" (waitfor (end ?{tag}))")),
        };
        Some(Fix::look(format!("let the step wait for `{tag}`")).insert_before(closing(form), text))
    }

    /// Returns the `=> ?name` of the step at `place`, if the result is this variable alone.
    pub(crate) fn result(&mut self, place: Place, name: &Symbol) -> Option<Span> {
        let datum = self.datum(place)?;
        let activity = datum.tail().iter().find(|part| part.as_list().is_some())?;
        [&datum, activity].into_iter().find_map(|form| {
            let items = form.as_list()?;
            let mark = items.iter().position(|item| item.is("=>"))?;
            let variable = items.get(mark + 1).filter(|item| item.as_variable() == Some(name))?;
            Some(items.get(mark)?.span.to(variable.span))
        })
    }

    /// Returns the tag of the step at `place`, else its activity.
    pub(crate) fn tag(&mut self, place: Place) -> Span {
        let datum = self.datum(place);
        datum.as_ref().and_then(|step| step.tail().first()).map_or_else(|| self.span(place), |tag| tag.span)
    }

    /// Returns the activity of the step at `place`.
    pub(crate) fn activity(&mut self, place: Place) -> Span {
        let datum = self.datum(place);
        let activity = datum.as_ref().and_then(|step| step.tail().iter().find(|part| part.as_list().is_some()));
        activity.map_or_else(|| self.span(place), |activity| activity.span)
    }

    /// Returns the index of the procedure, primitive or solver at `place`.
    pub(crate) fn index(&mut self, place: Place) -> Span {
        let datum = self.datum(place);
        let clause = datum.as_ref().and_then(|form| form.tail().iter().find(|part| part.head_name() == "index"));
        let pattern = match clause {
            Some(clause) => clause.tail().first(),
            None => datum.as_ref().and_then(|form| form.tail().iter().find(|part| part.as_list().is_some())),
        };
        pattern.map_or_else(|| self.span(place), |pattern| pattern.span)
    }

    /// Returns the first `?name` in the form at `place`, else the whole form.
    pub(crate) fn variable(&mut self, place: Place, name: &Symbol) -> Span {
        let datum = self.datum(place);
        let found = datum.as_ref().and_then(|form| find(form, &|part| part.as_variable() == Some(name)));
        found.unwrap_or_else(|| self.span(place))
    }

    /// Returns the goal of the `:probing` in the condition at `place`, else the whole condition.
    pub(crate) fn probe(&mut self, place: Place) -> Span {
        self.datum(place).as_ref().and_then(probe).map_or_else(|| self.span(place), |goal| goal.span)
    }

    /// Returns the first `?name` in the goal of the `:probing` in the condition at `place`, else the whole goal.
    pub(crate) fn variable_of_probe(&mut self, place: Place, name: &Symbol) -> Span {
        let datum = self.datum(place);
        let found =
            datum.as_ref().and_then(probe).and_then(|goal| find(goal, &|part| part.as_variable() == Some(name)));
        found.unwrap_or_else(|| self.probe(place))
    }

    /// Returns the head of the definition at `place`, without its body.
    pub(crate) fn head_line(&mut self, place: Place) -> Span {
        let datum = self.datum(place);
        let part = datum.as_ref().and_then(|form| {
            let items = form.tail();
            items.iter().find(|part| part.head_name() == "index").or(items.first())
        });
        part.map_or_else(|| self.span(place), |part| part.span)
    }

    /// Returns the first `?name` of the step's activity, else the last one in the form at `place`, else the whole form.
    pub(crate) fn use_of_variable(&mut self, place: Place, name: &Symbol) -> Span {
        let datum = self.datum(place);
        let is_it = |part: &Datum| part.as_variable() == Some(name);
        let activity = datum.as_ref().and_then(|form| form.tail().iter().find(|part| part.as_list().is_some()));
        let mut last = activity.and_then(|activity| find(activity, &is_it));
        if let Some(form) = datum.as_ref().filter(|_| last.is_none()) {
            each(form, &mut |part| {
                if is_it(part) {
                    last = Some(part.span);
                }
            });
        }
        last.unwrap_or_else(|| self.span(place))
    }

    /// Returns the first use of the word `name` in a clause `clause` of the form at `place`, else the whole clause.
    pub(crate) fn word_in_clause(&mut self, place: Place, clause: &str, name: &Symbol) -> Span {
        let datum = self.datum(place);
        let found = datum.as_ref().and_then(|form| {
            let mut clauses = form.tail().iter().filter(|part| part.head_name() == clause);
            clauses.find_map(|part| find(part, &|word| word.as_symbol() == Some(name)))
        });
        found.unwrap_or_else(|| self.clause(place, clause))
    }

    /// Returns the first `?name` in the clause `clause` of the form at `place`, else the whole clause.
    pub(crate) fn variable_in_clause(&mut self, place: Place, clause: &str, name: &Symbol) -> Span {
        let datum = self.datum(place);
        let part = datum.as_ref().and_then(|form| form.tail().iter().find(|part| part.head_name() == clause));
        let found = part.and_then(|part| find(part, &|part| part.as_variable() == Some(name)));
        found.unwrap_or_else(|| self.clause(place, clause))
    }

    /// Returns the first use of the word `name` in the form at `place`, else the whole form.
    pub(crate) fn word(&mut self, place: Place, name: &Symbol) -> Span {
        let datum = self.datum(place);
        let found = datum.as_ref().and_then(|form| find(form, &|part| part.as_symbol() == Some(name)));
        found.unwrap_or_else(|| self.span(place))
    }
}

/// Returns the goal after the option `:probing` of a condition.
fn probe(condition: &Datum) -> Option<&Datum> {
    let mut items = condition.tail().iter();
    items.find(|item| item.is(":probing"))?;
    items.next()?.as_list()?.first()
}

/// Returns the closing parenthesis of the form.
pub(crate) fn closing(form: Span) -> Span {
    Span { start: form.end.saturating_sub(1), ..form }
}

/// Visits every part of `datum` in order of writing.
pub(crate) fn each(datum: &Datum, visit: &mut dyn FnMut(&Datum)) {
    visit(datum);
    match &datum.kind {
        DatumKind::List(items) => items.iter().for_each(|item| each(item, visit)),
        DatumKind::Quote(inner)
        | DatumKind::Quasi(inner)
        | DatumKind::Unquote(inner)
        | DatumKind::Splice(inner)
        | DatumKind::Function(inner) => each(inner, visit),
        _ => {}
    }
}

/// Returns the first part of `datum`, in written order, that satisfies `wanted`.
pub(crate) fn find(datum: &Datum, wanted: &dyn Fn(&Datum) -> bool) -> Option<Span> {
    if wanted(datum) {
        return Some(datum.span);
    }
    match &datum.kind {
        DatumKind::List(items) => items.iter().find_map(|item| find(item, wanted)),
        DatumKind::Quote(inner)
        | DatumKind::Quasi(inner)
        | DatumKind::Unquote(inner)
        | DatumKind::Splice(inner)
        | DatumKind::Function(inner) => find(inner, wanted),
        _ => None,
    }
}

/// Moves spans relative to the start of the datum to its place in the file.
fn shift(datum: &mut Datum, offset: u32, place: Place) {
    let span = &mut datum.span;
    span.start = span.start.saturating_add(offset);
    span.end = span.end.saturating_add(offset);
    if span.line == 1 {
        span.column = span.column.saturating_add(place.column.saturating_sub(1));
    }
    span.line = span.line.saturating_add(place.line.saturating_sub(1));
    match &mut datum.kind {
        DatumKind::List(items) => items.iter_mut().for_each(|item| shift(item, offset, place)),
        DatumKind::Quote(inner)
        | DatumKind::Quasi(inner)
        | DatumKind::Unquote(inner)
        | DatumKind::Splice(inner)
        | DatumKind::Function(inner) => shift(inner, offset, place),
        _ => {}
    }
}

/// Returns the length in bytes of the first datum of `text`.
fn datum_length(text: &str) -> usize {
    let mut depth = 0_usize;
    let mut comment = 0_usize;
    let (mut in_text, mut in_line, mut in_atom, mut escaped) = (false, false, false, false);
    let mut previous = ' ';
    for (offset, character) in text.char_indices() {
        let before = std::mem::replace(&mut previous, character);
        if in_text {
            if escaped {
                escaped = false;
            } else if character == '\\' {
                escaped = true;
            } else if character == '"' {
                in_text = false;
                if depth == 0 {
                    return offset + 1;
                }
            }
            continue;
        }
        if in_line {
            in_line = character != '\n';
            continue;
        }
        match (before, character) {
            ('#', '|') => (comment, previous, in_atom) = (comment + 1, ' ', false),
            ('|', '#') if comment > 0 => (comment, previous) = (comment - 1, ' '),
            _ => {}
        }
        if comment > 0 {
            continue;
        }
        let ends_atom = character.is_whitespace() || matches!(character, '(' | ')' | '"' | ';');
        if depth == 0 && in_atom && ends_atom {
            return offset;
        }
        match character {
            '(' => depth += 1,
            ')' if depth <= 1 => return offset + 1,
            ')' => depth -= 1,
            '"' => in_text = true,
            ';' => in_line = true,
            '\'' | '`' | ',' | '@' | '#' | '|' => {}
            other => in_atom = !other.is_whitespace(),
        }
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn the_text_of_a_place_is_found_again() {
        let text = "; (a\n(procedure (a) #| ( |# (step \"(\\\"\" (b)) ; )\n  (step t (é '?x) (rank 1)))\n";
        let sources = [SourceFile { name: Arc::from("a.pdl"), text: Arc::from(text) }];
        let mut locator = Locator::new(&sources);
        let cut = |span: Span| text.get(span.start as usize..span.end as usize).unwrap_or("nothing");
        let at = |line, column| Place { file: 0, line, column };
        assert_eq!(cut(locator.span(at(2, 24))), "(step \"(\\\"\" (b))");
        assert_eq!(cut(locator.clause(at(3, 3), "rank")), "(rank 1)");
        assert_eq!(cut(locator.tag(at(3, 3))), "t");
        assert_eq!(cut(locator.activity(at(3, 3))), "(é '?x)");
        assert_eq!(cut(locator.index(at(2, 1))), "(a)");
        assert_eq!(cut(locator.variable(at(3, 3), &Symbol::new("x"))), "?x");
        let span = locator.clause(at(3, 3), "rank");
        assert_eq!((span.line, span.column), (3, 19));
        assert_eq!(locator.span(at(99, 1)).line, 99);
    }
}
