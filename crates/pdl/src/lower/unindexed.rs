//! Forgotten indexes: the index of the only goal that no method serves.

use super::Lowering;
use super::goals::{Goal, GoalIndex};
use super::procedure::variables_in;
use crate::codes;
use crate::diagnostic::Span;
use crate::fix::Fix;
use crate::locate::Locator;
use crate::read::Datum;
use apex_model::library::Library;
use apex_model::symbol::Symbol;

/// A procedure or primitive without an index.
pub(crate) struct Unindexed {
    /// Place of the report.
    reported: Span,
    /// Place before the index.
    before: Span,
    /// Every variable inside.
    variables: Vec<Symbol>,
    /// Variables that probably get their values from the index: they occur in an activity before anything else.
    given: Vec<Symbol>,
}

impl Unindexed {
    /// Returns the diagnosis of a form whose parts after its name and kind are `items`.
    pub(crate) fn new(form: &Datum, items: &[Datum]) -> Unindexed {
        let all = form.as_list().unwrap_or_default();
        let first = items.first().and_then(|first| all.iter().position(|item| item.span == first.span));
        let before = all.get(first.unwrap_or(all.len()).saturating_sub(1)).map_or(form.span, |item| item.span);
        let mut variables = Vec::new();
        variables_in(form, &mut |name| keep(&mut variables, name));
        let given = match form.head_name() {
            "procedure" => given_to_steps(items),
            _ => variables.clone(),
        };
        Unindexed { reported: form.head_span(), before, variables, given }
    }
}

fn keep(names: &mut Vec<Symbol>, name: &Symbol) {
    if !names.contains(name) {
        names.push(name.clone());
    }
}

/// Returns the variables whose first place is in the activity of a step, without those that name steps.
fn given_to_steps(items: &[Datum]) -> Vec<Symbol> {
    let steps = || items.iter().filter(|item| item.head_name() == "step").map(Datum::tail);
    let tags: Vec<&Symbol> = steps().filter_map(|step| step.first()?.as_symbol()).collect();
    let (mut seen, mut given) = (Vec::new(), Vec::new());
    for step in steps() {
        let activity = step.iter().find_map(Datum::as_list).unwrap_or_default();
        let words = activity.split(|item| item.is("=>")).next().unwrap_or_default();
        for item in words {
            variables_in(item, &mut |name| {
                if !seen.contains(name) && !tags.contains(&name) {
                    keep(&mut given, name);
                }
            });
        }
        step.iter().for_each(|clause| variables_in(clause, &mut |name| keep(&mut seen, name)));
    }
    given
}

impl Lowering {
    /// Combines two reports into one if one form lacks its index and one kind of goal is not served.
    pub(crate) fn suggest_index(&mut self, library: &Library) {
        let [form] = self.unindexed.as_slice() else { return };
        let index = GoalIndex::new(&self.served);
        let unserved: Vec<&Goal> = self.goals.iter().filter(|goal| !index.serves(&goal.template)).collect();
        let mut locator = Locator::new(&library.sources);
        let goals: Vec<Datum> =
            unserved.iter().take(GOALS_MAX).filter_map(|goal| locator.datum(goal.span.place())).collect();
        let Some((pattern, is_certain)) = pattern_of(form, &goals) else { return };
        let Some(first) = unserved.first().map(|goal| goal.span) else { return };
        let clause = format!("(index {pattern})");
        let fix = if is_certain { Fix::safe(format!("add `{clause}`")) } else { Fix::look(format!("add `{clause}`")) };
        let fix = fix.insert_after(form.before, format!(" {clause}"));
        let is_it = |code: &str, span: Span| code == codes::MISSING_INDEX && span == form.reported;
        if let Some(told) = self.diagnostics.iter_mut().find(|each| is_it(each.code, each.span)) {
            told.help.clear();
            told.fixes.push(fix);
            told.labels.push(crate::diagnostic::Label { span: first, text: "nothing serves this goal".to_string() });
        }
    }
}

/// Maximum number of unserved goals that are inspected.
const GOALS_MAX: usize = 100;

/// Returns the pattern that serves all these goals, if they are of one kind, and true if it is certain.
fn pattern_of(form: &Unindexed, goals: &[Datum]) -> Option<(String, bool)> {
    let lists: Vec<&[Datum]> = goals
        .iter()
        .map(|goal| goal.as_list().and_then(|all| all.split(|item| item.is("=>")).next()))
        .collect::<Option<_>>()?;
    let (first, others) = lists.split_first()?;
    let head = first.first()?.as_symbol()?;
    let is_same = |other: &&[Datum]| {
        other.len() == first.len() && other.first().is_some_and(|item| item.as_symbol() == Some(head))
    };
    if !others.iter().all(is_same) {
        return None;
    }
    let mut is_certain = true;
    let mut free: Vec<&Symbol> = form.given.iter().collect();
    let mut parts: Vec<Option<String>> = Vec::new();
    for (at, item) in first.iter().enumerate() {
        let same = others.iter().all(|other| other.get(at).is_some_and(|each| each.to_value() == item.to_value()));
        let variable = item.as_variable().filter(|name| form.variables.contains(name));
        if let Some(name) = variable {
            free.retain(|each| *each != name);
        }
        parts.push(match (variable, item.as_symbol()) {
            (Some(name), _) => Some(format!("?{name}")),
            (None, Some(word)) if same => Some(word.printed().to_string()),
            _ => None,
        });
        // A constant word after the first may be the value of a variable, so the pattern is then a guess.
        is_certain &= at == 0 || variable.is_some();
    }
    // Of the procedure's variables some have no binding and no part of the goal: one word of the goal was probably meant as an argument.
    let mut open = parts.iter().filter(|part| part.is_none()).count();
    for part in parts.iter_mut().skip(1).rev() {
        if open < free.len() && part.as_ref().is_some_and(|word| !word.starts_with('?')) {
            *part = None;
            open += 1;
        }
    }
    let mut free = free.into_iter();
    let mut written = Vec::new();
    for (at, part) in parts.into_iter().enumerate() {
        written.push(part.unwrap_or_else(|| free.next().map_or(format!("?part-{at}"), |name| format!("?{name}"))));
    }
    Some((format!("({})", written.join(" ")), is_certain && free.next().is_none()))
}
