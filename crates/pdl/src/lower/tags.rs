//! Wrong tags: of no step, or of two steps.

use super::Lowering;
use super::step::StepSource;
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::fix::Fix;
use crate::lookup::Lookup;
use crate::read::{Datum, DatumKind};
use crate::suggest::{is_certain, near, renames_marked};
use apex_model::symbol::Symbol;
use std::collections::{BTreeMap, BTreeSet};

/// Maximum number of steps offered in place of an unknown one.
const OFFERED_MAX: usize = 3;

impl Lowering {
    /// Returns fixes for `?name`, which is the tag of no step: a misspelt tag, or a step that no condition waits for, the nearest
    /// preceding one first.
    pub(crate) fn tags_for(&self, name: &Symbol, span: Span) -> Vec<Fix> {
        let tags = self.scope.tags.keys_in_order().into_iter().map(Symbol::printed);
        let renames = renames_marked(span, name.printed(), tags, |tag| format!("?{tag}"));
        if !renames.is_empty() {
            return renames;
        }
        let own = self.scope.step.unwrap_or(usize::MAX);
        let before = self.scope.tag_order.iter().enumerate().rev().filter(|(number, _)| *number < own);
        let free = before.map(|(_, tag)| tag).filter(|tag| !self.scope.times_named.contains(tag));
        free.take(OFFERED_MAX)
            .map(|tag| {
                Fix::look(format!("wait for `?{tag}`, for which no step waits")).replace(span, format!("?{tag}"))
            })
            .collect()
    }

    /// Reports a misspelt tag: several conditions agree on a tag that no step has, and one step that no condition names has a similar
    /// tag. Returns true if it was reported.
    pub(crate) fn report_odd_tag(&mut self, name: &Symbol, used: Span) -> bool {
        if self.scope.times_named.get(name).is_none_or(|count| *count < 2) {
            return false;
        }
        let free = self.scope.tags.keys_in_order().into_iter().filter(|tag| !self.scope.times_named.contains(tag));
        let found = near(name.printed(), free.map(Symbol::printed));
        let Some(tag) =
            found.first().filter(|_| is_certain(name.printed(), &found)).map(|first| Symbol::new(first.name))
        else {
            return false;
        };
        let Some(span) = self.scope.tags.get(&tag).copied() else { return false };
        let message = format!("nothing names the step `{tag}`, but `?{name}` is named");
        let fix = Fix::safe(format!("replace `{tag}` by `{name}`")).replace(span, name.printed());
        self.report(Diagnostic::error(codes::UNKNOWN_TAG, span, message).label(used, "named here").fix(fix));
        true
    }

    /// Reports steps with the tag of another one. Returns true if there are none.
    pub(crate) fn report_same_tags(&mut self, steps: &[StepSource<'_>]) -> bool {
        let mut taken: Lookup<&Symbol, &StepSource<'_>> = Lookup::default();
        let mut unique = true;
        for step in steps.iter().filter(|step| !step.tag.is("")) {
            let Some(first) = taken.insert(&step.tag, step) else { continue };
            unique = false;
            let message = format!("two steps are tagged `{}`", step.tag);
            let diagnostic = Diagnostic::error(codes::DUPLICATE_TAG, step.tag_span, message)
                .label(first.tag_span, "first used here")
                .fixes(other_tag(steps, first, step));
            self.report(diagnostic);
        }
        unique
    }
}

/// Returns another tag for one of two steps with the same tag: the tag of no step for which other steps wait, or a new one.
fn other_tag(steps: &[StepSource<'_>], first: &StepSource<'_>, second: &StepSource<'_>) -> Option<Fix> {
    let tags: BTreeSet<&Symbol> = steps.iter().map(|step| &step.tag).collect();
    let mut missed: BTreeMap<&Symbol, Vec<usize>> = BTreeMap::new();
    for (number, step) in steps.iter().enumerate() {
        for clause in step.clauses.iter().filter(|clause| clause.head_name() == "waitfor") {
            ended_tasks(clause, &mut |name| missed.entry(name).or_default().push(number));
        }
    }
    missed.retain(|name, _| !tags.contains(*name));
    let number = |of: &StepSource<'_>| steps.iter().position(|step| step.span == of.span).unwrap_or(0);
    if let (Some((name, by)), 1) = (missed.first_key_value(), missed.len()) {
        // The step that gets the tag must not be one that waits for it.
        let renamed = if by.contains(&number(second)) || !by.contains(&number(first)) { first } else { second };
        let fix = Fix::look(format!("tag this step `{name}`, which others wait for"));
        return Some(fix.replace(renamed.tag_span, name.printed()));
    }
    let fresh =
        (2..).map(|count: u32| format!("{}-{count}", second.tag)).find(|tag| !tags.iter().any(|each| each.is(tag)))?;
    Some(Fix::look(format!("tag the second step `{fresh}`")).replace(second.tag_span, fresh))
}

/// Collects the variables of `(end ?x)` and the like in a condition.
fn ended_tasks<'d>(condition: &'d Datum, found: &mut dyn FnMut(&'d Symbol)) {
    let Some(items) = condition.as_list() else { return };
    match (condition.head_name(), items) {
        ("end" | "end-of" | "terminated", [_, Datum { kind: DatumKind::Variable(name), .. }]) => found(name),
        _ => items.iter().for_each(|item| ended_tasks(item, found)),
    }
}
