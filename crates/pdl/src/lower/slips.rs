//! Forgotten marks: the colon of a keyword, the question mark of a variable or a step.

use super::Lowering;
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity, Span};
use crate::fix::Fix;
use crate::read::{Datum, DatumKind};
use crate::suggest::near;
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::collections::BTreeSet;

/// Names of conditions that are unlikely names of events.
const CONDITIONS: &[&str] =
    &["episode", "atomic-episode", "measurement", "in-order", "cyclic", "timestamp", "and", "or", "not"];
/// Words by which authors mean that a task has ended.
const ENDED: &[&str] = &["ended", "finished", "done", "complete", "completed", "over", "stopped", "finish"];
/// Relations of other languages, with their names in PDL.
const FOREIGN_RELATIONS: &[(&str, &str)] = &[
    ("==", "="),
    ("!=", "/="),
    ("<>", "/="),
    ("=<", "<="),
    ("=>", ">="),
    (">>", ">"),
    ("<<", "<"),
    ("≤", "<="),
    ("≥", ">="),
    ("≠", "/="),
];
/// Returns true for a relation of another language.
pub(crate) fn foreign_relation(datum: &Datum) -> bool {
    datum.as_symbol().is_some_and(|symbol| FOREIGN_RELATIONS.iter().any(|(foreign, _)| symbol.is(foreign)))
}

/// Relations written as words in other languages: they count as relations before a number, a duration or a variable.
const RELATION_WORDS: &[(&str, &str)] = &[
    ("gt", ">"),
    ("lt", "<"),
    ("ge", ">="),
    ("gte", ">="),
    ("le", "<="),
    ("lte", "<="),
    ("eq", "="),
    ("eql", "="),
    ("equal", "="),
    ("equals", "="),
    ("ne", "/="),
    ("neq", "/="),
    ("exceeds", ">"),
    ("greater-than", ">"),
    ("more-than", ">"),
    ("less-than", "<"),
    ("at-least", ">="),
    ("at-most", "<="),
];
/// Signs of relations, the longer ones first, with the relations of PDL that they mean.
pub(super) const RELATION_SIGNS: &[(&str, &str)] = &[
    ("<=", "<="),
    (">=", ">="),
    ("/=", "/="),
    ("==", "="),
    ("!=", "/="),
    ("=>", ">="),
    ("=<", "<="),
    (">>", ">"),
    ("<<", "<"),
    ("<", "<"),
    (">", ">"),
    ("=", "="),
];
/// Words that say how a task ended, in a condition `(WORD ?step)`.
pub(super) const OUTCOME_WORDS: &[&str] =
    &["succeeded", "failed", "skipped", "exited", "precondition-failed", "invariant-violated"];
/// Words that conditions use about tasks.
const OF_TASKS: &[&str] = &["end", "start", "terminated", "end-of"];

impl Lowering {
    /// Reports the first of `items` that is the name of an option of `of` without its colon; returns true if it did. An item directly after
    /// a keyword is its value and never reported.
    pub(crate) fn report_missing_colon(&mut self, items: &[Datum], known: &[&str], of: &str) -> bool {
        let mut after_keyword = true;
        for item in items {
            let name = item.as_symbol().map(|name| name.folded()).filter(|name| known.contains(name));
            if let Some(name) = name.filter(|_| !after_keyword) {
                let message = format!("option `{name}` of {of} lacks its colon");
                let diagnostic = Diagnostic::error(codes::UNKNOWN_OPTION, item.span, message);
                self.report(diagnostic.fix(colon(name, item.span)));
                return true;
            }
            after_keyword = item.keyword().is_some();
        }
        false
    }

    /// Reports a condition whose name lacks its colon or whose task lacks its question mark; returns true if it did.
    pub(crate) fn report_slipped_condition(&mut self, datum: &Datum) -> bool {
        let (name, items) = (datum.head_name(), datum.tail());
        if CONDITIONS.contains(&name) && items.iter().any(|item| item.as_list().is_some()) {
            let message = format!("condition `{name}` lacks its colon");
            let diagnostic = Diagnostic::error(codes::UNKNOWN_CONDITION, datum.head_span(), message);
            self.report(diagnostic.fix(colon(name, datum.head_span())));
            return true;
        }
        let is_task = |item: &Datum| {
            let tag = item.as_variable().is_some_and(|tag| self.scope.tags.contains(tag));
            tag || matches!(&item.kind, DatumKind::Indexical(name) if name.is("this-task"))
        };
        if let [task, relation, _] = items
            && relation.is("=")
            && is_task(task)
            && !matches!(name, "state" | "task-state")
            && let Some(first) = near(name, ["task-state"]).first()
        {
            let fix = Fix::safe(format!("replace `{name}` by `{}`", first.name)).replace(datum.head_span(), first.name);
            let message = format!("a task has no `{name}`");
            self.report(Diagnostic::error(codes::UNKNOWN_CONDITION, datum.head_span(), message).fix(fix));
            return true;
        }
        if self.report_foreign_relation(datum) {
            return true;
        }
        let [task] = items else { return false };
        if let Some(tag) = task.as_symbol()
            && OF_TASKS.contains(&name)
            && self.scope.tags.contains(tag)
        {
            let message = format!("`{tag}` is a word here, not the step");
            let fix = Fix::safe(format!("write `?{tag}`")).insert_before(task.span, "?");
            let diagnostic = Diagnostic::error(codes::MALFORMED_CONDITION, task.span, message)
                .reason("the task of a step is a variable")
                .fix(fix);
            self.report(diagnostic);
            return true;
        }
        let is_tag = task.as_variable().is_some_and(|tag| self.scope.tags.contains(tag));
        let head = datum.head().filter(|head| is_tag && !OF_TASKS.contains(&head.folded()));
        let Some((head, meant)) = head.and_then(|head| {
            let found = near(head.printed(), OF_TASKS.iter().chain(OUTCOME_WORDS).copied());
            let meant =
                if ENDED.contains(&head.folded()) { Some("end") } else { found.first().map(|first| first.name) };
            meant.map(|meant| (head, meant))
        }) else {
            return false;
        };
        let message = format!("a step has no `{head}`");
        let fix = Fix::safe(format!("replace `{head}` by `{meant}`")).replace(datum.head_span(), meant);
        self.report(Diagnostic::error(codes::UNKNOWN_CONDITION, datum.head_span(), message).fix(fix));
        true
    }
}

impl Lowering {
    /// Reports `((go) :and (stop))` and `(go :or stop)`: the connective is written between its parts, so that the form would be a message.
    /// Returns true if it did.
    pub(super) fn report_infix(&mut self, items: &[Datum]) -> bool {
        let of_lists = items.first().is_some_and(|first| first.as_list().is_some());
        let connective = |item: &Datum| {
            let (name, is_marked) = match item.keyword() {
                Some(name) => (name, true),
                None => (item.as_symbol()?.folded(), false),
            };
            (["and", "or", "not"].contains(&name) && (is_marked || of_lists)).then(|| name.to_string())
        };
        let Some((span, name)) = items.iter().skip(1).find_map(|item| Some((item.span, connective(item)?))) else {
            return false;
        };
        let message = format!("`:{name}` is written between conditions");
        let mut diagnostic = Diagnostic::error(codes::MALFORMED_CONDITION, span, message)
            .reason("as written, this is an event with these words, which never occurs")
            .help(format!("a connective comes first: `(:{name} CONDITION ..)`"));
        let (parts, between): (Vec<_>, Vec<_>) = items.iter().enumerate().partition(|(at, _)| at % 2 == 0);
        let is_regular = name != "not"
            && parts.len() == between.len() + 1
            && parts.iter().all(|(_, part)| part.as_list().is_some())
            && between.iter().all(|(_, item)| connective(item).as_deref() == Some(name.as_str()));
        if let Some((_, first)) = parts.first().filter(|_| is_regular) {
            let start = Span { end: first.span.start, ..first.span };
            let fix = Fix::safe(format!("write `(:{name} ..)`")).insert_before(start, format!(":{name} "));
            diagnostic = diagnostic.fix(between.iter().fold(fix, |fix, (_, item)| fix.replace(item.span, "")));
        }
        self.report(diagnostic);
        true
    }
}

impl Lowering {
    /// Reports a comparison in the notation of another language: PDL would read it as an event that never occurs. Returns true if it did.
    fn report_foreign_relation(&mut self, datum: &Datum) -> bool {
        let items = datum.as_list().unwrap_or_default();
        if let [relation, Datum { kind: DatumKind::List(variable), span }, _] = items
            && super::constraint::relation_named(relation).is_some()
            && let Some(first) = variable.first()
        {
            let name = relation.as_symbol().map_or("=", Symbol::printed);
            let opening = Span { end: first.span.start, ..relation.span };
            let closing = Span { start: span.end.saturating_sub(1), ..*span };
            let fix = Fix::safe(format!("write `(VARIABLE {name} VALUE)`"));
            let message = "a comparison begins with the state variable";
            let diagnostic = Diagnostic::error(codes::MALFORMED_CONDITION, relation.span, message)
                .reason("as written, it is an event with these words, which never occurs")
                .fix(fix.replace(opening, "").replace(closing, format!(" {name}")));
            self.report(diagnostic);
            return true;
        }
        let foreign = items.iter().skip(1).find_map(|item| {
            let name = item.as_symbol()?;
            let (_, own) = FOREIGN_RELATIONS.iter().find(|(foreign, _)| name.is(foreign))?;
            Some((item.span, name, *own))
        });
        let Some((span, name, own)) = foreign.or_else(|| relation_word(items)) else {
            return self.report_glued_relation(items);
        };
        let fix = Fix::safe(format!("replace `{name}` by `{own}`")).replace(span, own);
        self.report(
            Diagnostic::error(codes::MALFORMED_CONDITION, span, format!("no relation is called `{name}`"))
                .reason("as written, this is an event with these words, which never occurs")
                .fix(fix),
        );
        true
    }
}

impl Lowering {
    /// Reports `(roll ac1 >15)` and `(roll ac1>15)`: the relation is part of a word, so that the form would be a message. Returns true if
    /// it did.
    fn report_glued_relation(&mut self, items: &[Datum]) -> bool {
        for item in items.iter().skip(1) {
            let Some(name) = item.as_symbol() else { continue };
            let Some((before, sign, own, after)) = glued(name.printed()) else { continue };
            let apart = [before, own, after].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ");
            let fix = Fix::safe(format!("write `{apart}`")).replace(item.span, apart);
            let message = format!("`{sign}` is part of the word `{name}`");
            self.report(
                Diagnostic::error(codes::MALFORMED_CONDITION, item.span, message)
                    .reason("words end at spaces: as written, this is an event with these words, which never occurs")
                    .fix(fix),
            );
            return true;
        }
        false
    }
}

/// Returns a relation written as a word before a comparable item.
fn relation_word(items: &[Datum]) -> Option<(Span, &Symbol, &'static str)> {
    items.windows(2).skip(1).find_map(|pair| {
        let [word, next] = pair else { return None };
        let name = word.as_symbol()?;
        let (_, own) = RELATION_WORDS.iter().find(|(foreign, _)| name.is(foreign))?;
        let compared = matches!(
            next.kind,
            DatumKind::Integer(_)
                | DatumKind::Real(_)
                | DatumKind::Quantity(_)
                | DatumKind::Duration(_)
                | DatumKind::Variable(_)
                | DatumKind::Bound(_)
        );
        compared.then_some((word.span, name, *own))
    })
}

/// Splits a word at a relation in it, if a number or a variable follows the relation.
fn glued(name: &str) -> Option<(&str, &'static str, &'static str, &str)> {
    let at = name.find(['<', '>', '=', '/', '!'])?;
    let (before, rest) = name.split_at_checked(at)?;
    let (sign, own) = RELATION_SIGNS.iter().find(|(sign, _)| rest.starts_with(sign))?;
    let after = rest.strip_prefix(sign)?;
    let number = after.strip_prefix(['-', '+']).unwrap_or(after);
    let compared = number.starts_with(|first: char| first.is_ascii_digit()) || after.starts_with('?');
    (compared && !before.ends_with('-')).then_some((before, *sign, *own, after))
}

/// Returns the message about a word of an index that was meant as the variable used at `used`.
pub(super) fn variable_without_mark(name: &Symbol, word: Span, used: Span) -> Diagnostic {
    let fix = Fix::safe(format!("write `?{name}`")).insert_before(Span { end: word.start, ..word }, "?");
    Diagnostic::error(codes::UNBOUND_VARIABLE, word, format!("`{name}` is a word here, and nothing binds `?{name}`"))
        .label(used, "used here")
        .fix(fix)
}

impl Lowering {
    /// Records the words of a goal or of a value, which may turn out to be names of variables.
    pub(crate) fn note_words(&mut self, datum: &Datum) {
        if !self.scope.has_variables {
            return;
        }
        let items = datum.as_list().and_then(|items| items.get(1..)).unwrap_or(std::slice::from_ref(datum));
        for item in items {
            if let Some(name) = item.as_symbol() {
                self.scope.words.push((name.clone(), self.scope.step, item.span));
            }
        }
    }

    /// Warns of words with the name of a variable, unless an index contains them as words.
    pub(crate) fn report_words_like_variables(&mut self) {
        let suspects = std::mem::take(&mut self.suspects);
        if suspects.is_empty() {
            return;
        }
        let mut words = BTreeSet::new();
        self.served.iter().for_each(|served| words_of(&served.pattern, &mut words));
        for (name, span) in suspects.iter().filter(|(name, _)| !words.contains(name)).take(SUSPECTS_MAX) {
            let message = format!("`{name}` is a word here; `?{name}` is a variable");
            let fix = Fix::safe(format!("write `?{name}`")).insert_before(Span { end: span.start, ..*span }, "?");
            let diagnostic = Diagnostic::new(Severity::Warning, codes::WORD_LIKE_VARIABLE, *span, message)
                .reason("no index has this word, and a variable of this procedure has its name")
                .fix(fix);
            self.report(diagnostic);
        }
    }
}

/// Maximum number of reported words; if there are more, the words are intended.
const SUSPECTS_MAX: usize = 50;

fn words_of(pattern: &Pattern, words: &mut BTreeSet<Symbol>) {
    match pattern {
        Pattern::Literal(Value::Symbol(name)) => drop(words.insert(name.clone())),
        Pattern::Literal(Value::List(items)) => words.extend(items.iter().filter_map(Value::as_symbol).cloned()),
        Pattern::List(parts) | Pattern::And(parts) | Pattern::Or(parts) => {
            parts.iter().for_each(|part| words_of(part, words));
        }
        _ => {}
    }
}

/// Puts a colon before a word.
pub(crate) fn colon(name: &str, span: Span) -> Fix {
    Fix::safe(format!("write `:{name}`")).insert_before(Span { end: span.start, ..span }, ":")
}
