//! Words with which conditions compare state variables that the program publishes: a word that no step publishes and that resembles a
//! published one.

use super::published::view_of;
use super::walk;
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity};
use crate::locate::Locator;
use crate::matching::View;
use crate::suggest::{meant, renames};
use apex_model::condition::{Condition, ConditionKind, Constraint, Relation};
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::Library;
use apex_model::pattern::Pattern;
use apex_model::procedure::{Activity, BuiltInActivity};
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::collections::{BTreeMap, BTreeSet};

/// The published words of each attribute; `None` where a published value is not a constant word, so that any word may be published.
type PublishedWords<'l> = BTreeMap<&'l Symbol, Option<BTreeSet<&'l Symbol>>>;

/// Returns all findings in the library.
pub(super) fn findings(library: &Library) -> Vec<Diagnostic> {
    let published = published_words(library);
    let mut locator = Locator::new(&library.sources);
    let mut found = Vec::new();
    for procedure in &library.procedures {
        walk::conditions_of(procedure, &mut |condition| {
            let Some(variable) = walk::variable_of(condition) else { return };
            let Some(Some(words)) = published.get(&variable.attribute) else { return };
            for word in compared_words(condition).into_iter().filter(|word| !words.contains(word)) {
                let Some(known) = meant(word, words.iter().map(|word| word.printed())) else { continue };
                let span = locator.word(condition.place, word);
                let message =
                    format!("no step publishes `{word}` as `({} ..)`, but one publishes `{known}`", variable.attribute);
                let diagnostic = Diagnostic::new(Severity::Warning, codes::RESEMBLES, span, message)
                    .reason("if no source outside the program measures it either, this comparison never changes")
                    .fixes(renames(span, word.printed(), [known]));
                found.push(diagnostic);
            }
        });
    }
    found
}

/// Returns the constant words with which a condition compares its state variable.
fn compared_words(condition: &Condition) -> Vec<&Symbol> {
    let constraints = match &condition.kind {
        ConditionKind::Measurement(measurement) => &measurement.value,
        ConditionKind::Episode(episode) => &episode.value,
        _ => return Vec::new(),
    };
    let word = |constraint| match constraint {
        &Constraint::Matches(Pattern::Literal(Value::Symbol(ref word))) => Some(word),
        Constraint::Compare { relation: Relation::Equal | Relation::Different, right, .. } => match &right.kind {
            ExprKind::Constant(Value::Symbol(word)) => Some(word),
            _ => None,
        },
        _ => None,
    };
    constraints.iter().filter_map(word).collect()
}

/// Collects what `(publish (ATTRIBUTE OBJECT) VALUE)` and messages of the form `(ATTRIBUTE OBJECT = VALUE)` publish.
fn published_words(library: &Library) -> PublishedWords<'_> {
    let mut published = PublishedWords::new();
    for step in library.procedures.iter().flat_map(|procedure| &procedure.steps) {
        if let Activity::BuiltIn(BuiltInActivity::Inform | BuiltInActivity::Cogevent, arguments) = &step.activity {
            arguments.first().into_iter().for_each(|form| message(form, &mut published));
        }
    }
    walk::library(library, &mut |expr| {
        let ExprKind::Call { function, arguments } = &expr.kind else { return };
        match (function.folded(), arguments.as_slice()) {
            ("publish", [variable, value, ..]) => {
                let word = match &value.kind {
                    ExprKind::Constant(Value::Symbol(word)) => Some(word),
                    _ => None,
                };
                note(view_of(variable).and_then(View::head), word, &mut published);
            }
            ("inform" | "cogevent" | "publish", [form, ..]) => message(form, &mut published),
            _ => {}
        }
    });
    published
}

/// Notes a message of the form `(ATTRIBUTE OBJECT = VALUE)`.
fn message<'l>(form: &'l Expr, published: &mut PublishedWords<'l>) {
    let Some(items) = view_of(form).and_then(View::items) else { return };
    if let [_, _, equal, value] = items.as_slice()
        && symbol(*equal).is_some_and(|word| word.is("="))
    {
        note(view_of(form).and_then(View::head), symbol(*value), published);
    }
}

fn symbol<'l>(view: View<'l>) -> Option<&'l Symbol> {
    view.value()?.as_symbol()
}

fn note<'l>(attribute: Option<&'l Symbol>, word: Option<&'l Symbol>, published: &mut PublishedWords<'l>) {
    let Some(attribute) = attribute else { return };
    let words = published.entry(attribute).or_insert_with(|| Some(BTreeSet::new()));
    match word {
        Some(word) => words.iter_mut().for_each(|words| {
            words.insert(word);
        }),
        None => *words = None,
    }
}
