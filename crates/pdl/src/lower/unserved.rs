//! Messages about goals that no method serves. Most are misspelt: in the goal or, if several goals agree against it, in the index.

use super::Lowering;
use super::apart;
use super::goals::{Goal, GoalIndex, Served};
use super::nearly::{Difference, difference, words};
use super::shipped::{Offer, Shipped};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity};
use crate::fix::Fix;
use crate::locate::Locator;
use crate::print::{pattern_text, template_text};
use crate::read::{Datum, DatumKind};
use crate::suggest::{are_distinct, is_certain, near, renames};
use crate::vocabulary::ACTIVITIES;
use apex_model::library::Library;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use std::collections::BTreeMap;

/// Maximum number of reported unserved goals, because each needs a search for suggestions.
const UNSERVED_MAX: usize = 100;
/// Maximum number of indexes that are compared with an unserved goal.
const CANDIDATES_MAX: usize = 2_000;
/// Words that authors write for `terminate`.
const ENDINGS: &[&str] = &["end", "finish", "stop", "done", "exit", "return", "quit", "complete"];

/// An index that nearly serves a goal.
struct Nearest<'s> {
    served: &'s Served,
    index: Datum,
    difference: Difference,
    /// True if no other index is as near.
    is_only: bool,
}

/// Input of the search for nearly serving indexes.
struct SuggestionSearch<'s, 'l> {
    library: &'l Library,
    locator: Locator<'l>,
    served: &'s [Served],
    indexes: Vec<Option<Datum>>,
    /// Number of occurrences of each word in goals and indexes.
    counts: BTreeMap<Symbol, usize>,
    /// The shapes of the goals, with their places.
    shapes: Vec<(Place, Shape)>,
    severity: Severity,
    /// Words of indexes that were reported: the index and the number of the word.
    odd: Vec<(Place, usize)>,
    shipped: Shipped,
}

/// Common shape of goals that one missing procedure would serve: their first words and their length.
#[derive(PartialEq, Eq)]
struct Shape {
    head: Option<Symbol>,
    second: Option<Symbol>,
    length: usize,
}

impl Shape {
    fn of(goal: &Datum) -> Shape {
        let items = goal.as_list().unwrap_or_default();
        let second = items.get(1).and_then(Datum::as_symbol).cloned();
        Shape { head: goal.head().cloned(), second, length: items.len() }
    }
}

impl Lowering {
    /// Reports goals that nothing serves.
    pub(crate) fn report_unserved_goals(&mut self, library: &Library) {
        let goals = std::mem::take(&mut self.goals);
        let served = std::mem::take(&mut self.served);
        let index = GoalIndex::new(&served);
        let unserved: Vec<&Goal> = goals.iter().filter(|goal| !index.serves(&goal.template)).collect();
        if !unserved.is_empty() {
            let mut search = SuggestionSearch::new(library, &goals, &served, self.undefined());
            let mut reported: Vec<(Place, Diagnostic)> = Vec::new();
            let mut full = false;
            for goal in unserved {
                let Some((cause, diagnostic)) = search.message(goal, &goals, &index) else { continue };
                match reported.iter_mut().find(|(other, _)| *other == cause) {
                    Some((_, known)) if known.labels.len() < 3 => {
                        known
                            .labels
                            .push(crate::diagnostic::Label { span: goal.span, text: "pursued here, too".into() });
                    }
                    Some(_) => {}
                    None if full => break,
                    None => reported.push((cause, diagnostic)),
                }
                full = reported.len() >= UNSERVED_MAX;
            }
            reported.into_iter().for_each(|(_, diagnostic)| self.report(diagnostic));
        }
        self.served = served;
    }
}

impl<'s, 'l> SuggestionSearch<'s, 'l> {
    fn new(library: &'l Library, goals: &[Goal], served: &'s [Served], severity: Severity) -> SuggestionSearch<'s, 'l> {
        let mut locator = Locator::new(&library.sources);
        let indexes: Vec<Option<Datum>> =
            served.iter().take(CANDIDATES_MAX).map(|each| locator.datum(each.span.place())).collect();
        let mut counts: BTreeMap<Symbol, usize> = BTreeMap::new();
        let sources: Vec<Datum> =
            goals.iter().take(CANDIDATES_MAX).filter_map(|goal| locator.datum(goal.span.place())).collect();
        let shapes = sources.iter().map(|source| (source.span.place(), Shape::of(source))).collect();
        for word in sources.iter().chain(indexes.iter().flatten()).flat_map(words) {
            *counts.entry(word.clone()).or_default() += 1;
        }
        SuggestionSearch {
            library,
            locator,
            served,
            indexes,
            counts,
            shapes,
            severity,
            odd: Vec::new(),
            shipped: Shipped::default(),
        }
    }

    fn count(&self, word: Option<&Symbol>) -> usize {
        word.and_then(|word| self.counts.get(word)).copied().unwrap_or(0)
    }

    /// Returns the diagnostic of an unserved goal, and the place of the error: goals with the same cause share a diagnostic.
    fn message(&mut self, goal: &Goal, goals: &[Goal], index: &GoalIndex<'_>) -> Option<(Place, Diagnostic)> {
        let source = self.locator.datum(goal.span.place())?;
        let text = template_text(&goal.template);
        let message = format!("no procedure, primitive or solver serves `{text}`");
        let diagnostic = Diagnostic::new(self.severity, codes::UNSERVED_GOAL, goal.span, message);
        if let Some(fix) = apart::joined(&source, &goal.template, index, |datum| self.text(datum)) {
            let diagnostic = diagnostic.reason("a number and its unit are one word");
            return Some((self.cause(goal, &source), diagnostic.fix(fix)));
        }
        let offer = self.shipped.offer(&source);
        if let Some(offer @ Offer::Serves { library, index }) = &offer {
            let reason = format!("`{index}` is served by the library `{library}`, which this program does not require");
            return Some((self.cause(goal, &source), diagnostic.reason(reason).fix(offer.fix(&source))));
        }
        let Some(nearest) = self.nearest(&source) else {
            let diagnostic = self.without_nearest(diagnostic, goal, &source, index);
            // The program may have its own methods for goals with this first word: then the library is probably not meant.
            let is_own = source.head().is_some_and(|head| index.by_head.contains_key(head));
            let diagnostic = match &offer {
                Some(Offer::OtherShape { library, index }) if !is_own => {
                    diagnostic.reason(format!("the library `{library}` serves `{index}`"))
                }
                _ => diagnostic,
            };
            return Some((self.cause(goal, &source), diagnostic));
        };
        if let Difference::Word(at) = nearest.difference {
            let word = (nearest.served.span.place(), at);
            // A word of an index that is suspect for one goal is suspect for all goals that differ from it there.
            if self.odd.contains(&word) || self.is_odd(&nearest, at, &source, goals) {
                self.odd.push(word);
                return self.about_index(&nearest, at, &source, goal);
            }
        }
        let fixes = self.fix(&nearest, &source);
        let place = self.cause(goal, &source);
        let diagnostic = diagnostic.label(nearest.served.span, "this index differs in one part only");
        Some((place, diagnostic.fixes(fixes)))
    }

    /// Returns the place of the first goal of the same shape: goals of one shape lack the same procedure and share a message.
    fn cause(&self, goal: &Goal, source: &Datum) -> Place {
        let shape = Shape::of(source);
        let first = self.shapes.iter().find(|(_, other)| *other == shape);
        first.map_or(goal.span.place(), |(place, _)| *place)
    }

    fn without_nearest(
        &self,
        diagnostic: Diagnostic,
        goal: &Goal,
        source: &Datum,
        index: &GoalIndex<'_>,
    ) -> Diagnostic {
        if let Some(same) = index.likest(&goal.template) {
            return diagnostic.help(format!(
                "`{}` is defined at {}, but has another shape",
                pattern_text(&same.pattern),
                self.library.describe_place(same.span.place())
            ));
        }
        if let Some(explained) = super::misplaced::explained(&diagnostic, source) {
            return explained;
        }
        let text = template_text(&goal.template);
        let heads = index.by_head.keys().map(|head| head.printed()).chain(ACTIVITIES.iter().copied());
        let fixes = renames(source.head_span(), source.head().map_or("", Symbol::printed), heads);
        if fixes.is_empty()
            && let Some(skeleton) = self.skeleton(source)
        {
            let is_end = |items: &[Datum]| matches!(items, [word] if ENDINGS.iter().any(|ending| word.is(ending)));
            let terminate = source.as_list().filter(|items| is_end(items));
            let terminate = terminate.map(|_| {
                Fix::look("replace it by `terminate`, which ends the procedure")
                    .replace(source.head_span(), "terminate")
            });
            return diagnostic.fixes(terminate).fix(skeleton);
        }
        diagnostic.fixes_or_help(fixes, || format!("write a procedure for it: `(procedure (index {text}) ..)`"))
    }

    /// Returns a fix that adds an empty procedure for the goal at the end of its file.
    fn skeleton(&self, goal: &Datum) -> Option<Fix> {
        let text = &self.library.sources.get(usize::try_from(goal.span.file).ok()?)?.text;
        let all = goal.as_list()?;
        // `=> ?x` binds the result of the step: it is not a part of the goal.
        let is_result = |number: usize| {
            let marks = [Some(number), number.checked_sub(1)].into_iter().flatten();
            marks.filter_map(|at| all.get(at)).any(|item| item.is("=>"))
        };
        let items = all.iter().enumerate().filter(|(number, _)| !is_result(*number));
        let words: Option<Vec<String>> = items.map(|(number, item)| self.index_part(item, number)).collect();
        let index = format!("({})", words?.join(" "));
        let end = u32::try_from(text.len()).ok()?;
        let span = crate::diagnostic::Span { start: end, end, ..goal.span };
        let line_end = if text.ends_with('\n') { "" } else { "\n" };
        let body = format!("(step todo (print \"{} is still to be written\"))", index.replace(['"', '\\'], "'"));
        let form = format!("{line_end}\n(procedure :sequential (index {index})\n  {body})\n");
        Some(Fix::look(format!("write a procedure for it: `(procedure (index {index}) ..)`")).insert_before(span, form))
    }

    /// Returns the part of an index for this item of a goal: the same word, or a variable for a part that the goal fills in.
    fn index_part(&self, item: &Datum, number: usize) -> Option<String> {
        match &item.kind {
            DatumKind::Variable(name) | DatumKind::Bound(name) | DatumKind::Indexical(name) => Some(format!("?{name}")),
            DatumKind::Symbol(_) | DatumKind::Integer(_) | DatumKind::Text(_) => self.text(item),
            _ => Some(format!("?part-{number}")),
        }
    }

    fn nearest(&self, source: &Datum) -> Option<Nearest<'s>> {
        let known = self.served.iter().zip(&self.indexes).filter_map(|(served, index)| Some((served, index.as_ref()?)));
        let mut found: Vec<(u32, Difference, &'s Served, &Datum)> = known
            .filter_map(|(served, index)| difference(source, index).map(|(cost, what)| (cost, what, served, index)))
            .collect();
        found.sort_by_key(|(cost, ..)| *cost);
        let (cost, difference, served, index) = *found.first()?;
        let is_only = found.get(1).is_none_or(|(second, ..)| *second > cost + 4);
        Some(Nearest { served, index: index.clone(), difference, is_only })
    }

    /// Returns true if the index is probably misspelt: it serves no goal, its word occurs nowhere else, and the goal's word does.
    fn is_odd(&self, nearest: &Nearest<'_>, at: usize, source: &Datum, goals: &[Goal]) -> bool {
        let word = |datum: &Datum| datum.as_list().and_then(|items| items.get(at)).and_then(Datum::as_symbol).cloned();
        let alone = GoalIndex::new(std::slice::from_ref(nearest.served));
        self.count(word(&nearest.index).as_ref()) == 1
            && self.count(word(source).as_ref()) >= 2
            && !goals.iter().any(|goal| alone.serves(&goal.template))
    }

    fn about_index(
        &self,
        nearest: &Nearest<'_>,
        at: usize,
        source: &Datum,
        goal: &Goal,
    ) -> Option<(Place, Diagnostic)> {
        let (written, wanted) = (nearest.index.as_list()?.get(at)?, source.as_list()?.get(at)?);
        let (name, meant) = (written.as_symbol()?, wanted.as_symbol()?);
        let message = format!("this index says `{name}`, but the goal is `{}`", template_text(&goal.template));
        let title = format!("replace `{name}` by `{meant}`");
        let certain = nearest.is_only && !are_distinct(name.printed(), meant.printed());
        let fix = if certain { Fix::safe(title) } else { Fix::look(title) };
        let diagnostic = Diagnostic::new(self.severity, codes::UNSERVED_GOAL, written.span, message)
            .label(goal.span, "nothing serves this goal")
            .reason("the index serves no goal, and its word occurs nowhere else")
            .fix(fix.replace(written.span, meant.printed()));
        Some((written.span.place(), diagnostic))
    }

    fn fix(&self, nearest: &Nearest<'_>, source: &Datum) -> Option<Fix> {
        let items = source.as_list()?;
        let text = |datum: &Datum| self.text(datum);
        Some(match nearest.difference {
            Difference::Word(at) => {
                let (written, wanted) = (items.get(at)?, nearest.index.as_list()?.get(at)?.as_symbol()?);
                let name = written.as_symbol()?.printed();
                let agreeing = words(source).filter(|word| words(&nearest.index).any(|other| other == *word)).count();
                let found = near(name, [wanted.printed()]);
                // A slip in a word of two letters is weak evidence; two other equal words confirm it.
                let confirmed = agreeing >= 1 && !found.is_empty() && !are_distinct(name, wanted.printed());
                let certain = nearest.is_only && (is_certain(name, &found) || confirmed);
                let title = format!("replace `{name}` by `{wanted}`");
                let fix = if certain { Fix::safe(title) } else { Fix::look(title) };
                fix.replace(written.span, wanted.printed())
            }
            Difference::Swapped(at) => {
                let (one, other) = (items.get(at)?, items.get(at + 1)?);
                let (first, second) = (text(one)?, text(other)?);
                let title = format!("exchange `{first}` and `{second}`");
                let fix = if nearest.is_only { Fix::safe(title) } else { Fix::look(title) };
                fix.replace(one.span, second).replace(other.span, first)
            }
            Difference::Missing(at) => {
                let item = nearest.index.as_list()?.get(at)?;
                let word = match item.as_variable() {
                    Some(_) => text(item).filter(|name| self.is_near(source, name))?,
                    None => item.as_symbol()?.printed().to_string(),
                };
                let before = at.checked_sub(1).and_then(|before| items.get(before))?;
                Fix::look(format!("add `{word}`")).insert_after(before.span, format!(" {word}"))
            }
            Difference::Extra(at) => {
                let (before, item) = (items.get(at.checked_sub(1)?)?, items.get(at)?);
                let from = crate::diagnostic::Span { start: before.span.end, ..item.span };
                Fix::look(format!("remove `{}`", text(item)?)).replace(from, "")
            }
        })
    }

    fn text(&self, datum: &Datum) -> Option<String> {
        let source = self.library.sources.get(usize::try_from(datum.span.file).ok()?)?;
        let range = usize::try_from(datum.span.start).ok()?..usize::try_from(datum.span.end).ok()?;
        source.text.get(range).map(str::to_string)
    }

    /// Returns true if the variable occurs in the top-level form around the goal.
    fn is_near(&self, goal: &Datum, variable: &str) -> bool {
        let Some(source) = usize::try_from(goal.span.file).ok().and_then(|file| self.library.sources.get(file)) else {
            return false;
        };
        let at = usize::try_from(goal.span.start).unwrap_or(0);
        let (before, after) = (source.text.get(..at).unwrap_or_default(), source.text.get(at..).unwrap_or_default());
        let form_before = before.rfind("\n(").and_then(|start| before.get(start..)).unwrap_or(before);
        let form_after = after.find("\n(").and_then(|end| after.get(..end)).unwrap_or(after);
        let ends = |rest: &str| rest.chars().next().is_none_or(|c| c.is_whitespace() || c == ')');
        let stands =
            |text: &str| text.match_indices(variable).any(|(at, _)| text.get(at + variable.len()..).is_some_and(ends));
        stands(form_before) || stands(form_after)
    }
}
