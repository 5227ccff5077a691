//! Variables that may have no value where they are used: bound in one branch only, results of steps that need not have
//! ended, values that come later than their use.

use super::bound::{Bound, by_all, by_pattern};
use super::{FindingCollector, Program, walk};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity};
use crate::lookup::Lookup;
use apex_forms::variables;
use apex_model::condition::{Condition, ConditionKind};
use apex_model::expression::{Expr, ExprKind};
use apex_model::pattern::Pattern;
use apex_model::procedure::{Procedure, ProcedureKind, Step};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use std::collections::{BTreeMap, BTreeSet};

pub(super) fn check(program: &Program<'_>, report: &mut FindingCollector<'_>) {
    for procedure in &program.library.procedures {
        if is_simple(procedure) {
            continue;
        }
        let known = VariableFacts::new(procedure);
        for (number, step) in procedure.steps.iter().enumerate() {
            known.step(number, step, report);
            nothing_new(step, report);
        }
        known.clauses(report);
    }
}

/// Returns true if every part certainly has a value: no branch, no result, nothing selected.
fn is_simple(procedure: &Procedure) -> bool {
    let binds = |step: &Step| {
        step.binds.is_some() || !step.waitfor.is_empty() || !step.select.is_empty() || step.forall.is_some()
    };
    let plain = |part: &Pattern| matches!(part, Pattern::Literal(_) | Pattern::Variable(_) | Pattern::Anonymous);
    let plain_index = match &procedure.index {
        Pattern::List(parts) => parts.iter().all(plain),
        index => plain(index),
    };
    plain_index && !procedure.steps.iter().any(binds)
}

/// Known facts about the variables of a procedure.
struct VariableFacts<'l> {
    procedure: &'l Procedure,
    index: Bound<'l>,
    /// Tags, and variables that a form assigns; the time of the assignment is not analysed.
    given: Lookup<&'l Symbol, ()>,
    /// Results with the steps that have them.
    results: BTreeMap<&'l Symbol, Vec<usize>>,
}

/// Moment of a step's clause in the life of its task.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Moment {
    /// Before or while its waitfor is judged.
    Waiting,
    /// The instant at which the task becomes enabled, or a later one; the results that the activity uses exist then.
    Later,
    /// After its own result is bound.
    End,
}

impl<'l> VariableFacts<'l> {
    fn new(procedure: &'l Procedure) -> VariableFacts<'l> {
        let mut given: Lookup<&Symbol, ()> = procedure.steps.iter().map(|step| (&step.tag, ())).collect();
        walk::procedure(procedure, &mut |expr| {
            if let ExprKind::Assign { name, of_task: true, .. } = &expr.kind {
                given.insert(name, ());
            }
        });
        let mut results: BTreeMap<&Symbol, Vec<usize>> = BTreeMap::new();
        for (number, step) in procedure.steps.iter().enumerate() {
            let bound = step.binds.as_deref().map(by_pattern).unwrap_or_default();
            bound.surely.into_iter().chain(bound.perhaps.into_keys()).for_each(|name| {
                results.entry(name).or_default().push(number);
            });
        }
        VariableFacts { procedure, index: by_pattern(&procedure.index), given, results }
    }

    fn is_given(&self, name: &Symbol) -> bool {
        self.index.surely.contains(name) || self.given.contains(&name)
    }

    fn step(&self, number: usize, step: &'l Step, report: &mut FindingCollector<'_>) {
        let waitfor = by_all(&step.waitfor);
        let mut told: BTreeSet<Symbol> = BTreeSet::new();
        // Uses of variables that the step does not certainly know.
        let mut uses: Vec<(Symbol, Moment)> = Vec::new();
        let is_known = |name: &Symbol| self.is_given(name) || waitfor.surely.contains(name);
        for condition in &step.waitfor {
            walk::condition(condition, &mut |expr| {
                if let ExprKind::Variable { name, .. } = &expr.kind
                    && !is_known(name)
                {
                    uses.push((name.clone(), Moment::Waiting));
                }
            });
        }
        let mut later = |name: &Symbol| {
            if !is_known(name) {
                uses.push((name.clone(), Moment::Later));
            }
        };
        variables::of_activity(&step.activity, &mut later);
        step.forall.iter().for_each(|forall| variables::of_expr(&forall.1, &mut later));
        // Before the activity begins, the step waits for the results that the activity uses, but not for the results that only other
        // clauses use.
        let awaited: BTreeSet<Symbol> = uses.iter().map(|(name, _)| name.clone()).collect();
        let mut at = |moment: Moment, exprs: &mut dyn Iterator<Item = &Expr>| {
            exprs.for_each(|expr| {
                variables::of_expr(expr, &mut |name| {
                    if !is_known(name) {
                        uses.push((name.clone(), moment));
                    }
                });
            });
        };
        at(Moment::Later, &mut walk::priorities(&step.priority).chain(step.rank.as_deref()));
        at(
            Moment::Later,
            &mut step.hooks.on_start.iter().chain(step.profile.iter().filter_map(|need| need.amount.as_ref())),
        );
        at(
            Moment::End,
            &mut step.hooks.on_end.iter().chain(step.repeating.iter().flat_map(|clause| walk::repetition(clause))),
        );
        let own: BTreeSet<&Symbol> =
            step.select.iter().map(|(name, _)| name).chain(step.forall.iter().map(|forall| &forall.0)).collect();
        for (name, moment) in &uses {
            if !told.insert(name.clone()) {
                continue;
            }
            if own.contains(name) {
                if *moment == Moment::Waiting && !waitfor.perhaps.contains_key(name) {
                    self.report_selected(step, name, report);
                }
                continue;
            }
            let is_awaited = awaited.contains(name) || step.select.iter().any(|(_, value)| mentions(value, name));
            match self.results.get(name) {
                Some(steps) if steps.as_slice() == [number] => {
                    if *moment != Moment::End && !waitfor.perhaps.contains_key(name) {
                        report_own_result(step, name, report);
                    }
                }
                Some(steps) => {
                    if !is_awaited && !self.has_ended(number, step, steps) {
                        self.report_early(step, name, steps, report);
                    }
                }
                None => report_branch(step.place, name, &waitfor, &self.index, report),
            }
        }
        self.selects(number, step, &waitfor, &mut told, report);
    }

    /// Checks `select` clauses, which are evaluated in order.
    fn selects(
        &self,
        number: usize,
        step: &'l Step,
        waitfor: &Bound<'l>,
        told: &mut BTreeSet<Symbol>,
        report: &mut FindingCollector<'_>,
    ) {
        for (order, (_, value)) in step.select.iter().enumerate() {
            let later: BTreeSet<&Symbol> = step.select.iter().skip(order).map(|(name, _)| name).collect();
            let earlier = |name: &Symbol| step.select.iter().take(order).any(|(known, _)| known == name);
            let mut names = Vec::new();
            variables::of_expr(value, &mut |name| names.push(name.clone()));
            for name in names {
                let known = self.is_given(&name)
                    || waitfor.surely.contains(&name)
                    || earlier(&name)
                    || step.forall.as_ref().is_some_and(|forall| forall.0 == name)
                    || self.results.get(&name).is_some_and(|steps| steps.as_slice() != [number]);
                if known || !told.insert(name.clone()) {
                    continue;
                }
                if later.contains(&name) && !waitfor.perhaps.contains_key(&name) {
                    let message = format!("`?{name}` has no value yet");
                    let span = report.locator.variable(value.place, &name);
                    let diagnostic = Diagnostic::error(codes::UNBOUND_VARIABLE, span, message)
                        .reason("`select` clauses are evaluated in the order in which they are written")
                        .help(format!("move the clause that selects `?{name}` before this one"));
                    report.add(diagnostic);
                } else {
                    report_branch(step.place, &name, waitfor, &self.index, report);
                }
            }
        }
    }

    /// Returns true if one of `producers` has surely ended when the step is enabled.
    fn has_ended(&self, number: usize, step: &Step, producers: &[usize]) -> bool {
        let sequential = self.procedure.kind == ProcedureKind::Sequential;
        let tag = |producer: &usize| self.procedure.steps.get(*producer).map(|step| &step.tag);
        producers.iter().any(|producer| {
            sequential && *producer < number
                || tag(producer).is_some_and(|tag| step.waitfor.iter().any(|each| waits_for_end(each, tag)))
        })
    }

    /// Clauses of the procedure itself.
    fn clauses(&self, report: &mut FindingCollector<'_>) {
        let procedure = self.procedure;
        let amounts = procedure.profile.iter().filter_map(|need| need.amount.as_ref());
        let before = procedure.hooks.on_start.iter().chain(amounts);
        let before = before.chain(&procedure.expected_duration).chain(&procedure.interrupt_cost);
        let after = [&procedure.hooks.on_end, &procedure.hooks.on_suspend, &procedure.hooks.on_resume];
        let after = after.into_iter().flatten();
        let mut told = BTreeSet::new();
        let uses = before.map(|expr| (expr, true)).chain(after.map(|expr| (expr, false)));
        for (expr, is_before) in uses {
            let mut names = Vec::new();
            variables::of_expr(expr, &mut |name| names.push(name.clone()));
            for name in names.into_iter().filter(|name| !self.is_given(name)) {
                if !told.insert(name.clone()) {
                    continue;
                }
                let Some(producer) = self.results.get(&name).and_then(|steps| steps.first()) else {
                    report_branch(procedure.place, &name, &Bound::default(), &self.index, report);
                    continue;
                };
                let span = report.locator.variable(expr.place, &name);
                let producer = self.procedure.steps.get(*producer);
                let label = producer.map(|step| report.locator.span(step.place));
                let diagnostic = if is_before {
                    Diagnostic::error(codes::UNBOUND_VARIABLE, span, format!("`?{name}` has no value yet"))
                        .reason("this is evaluated before any step begins")
                        .help("use it in a clause of a step that waits for this one")
                } else {
                    let message = format!("`?{name}` may have no value here");
                    Diagnostic::new(Severity::Warning, codes::POSSIBLY_UNBOUND, span, message)
                        .reason("the procedure may be suspended or end before this step has a result")
                        .help(format!("give it a value first: `(on-start (setq ?{name} ..))`"))
                };
                report.add(match label {
                    Some(label) => diagnostic.label(label, "its value is the result of this step"),
                    None => diagnostic,
                });
            }
        }
    }

    fn report_selected(&self, step: &Step, name: &Symbol, report: &mut FindingCollector<'_>) {
        let clause = if step.forall.as_ref().is_some_and(|forall| forall.0 == *name) { "forall" } else { "select" };
        let span = step.waitfor.iter().find_map(|each| use_in_condition(each, name));
        let span = report.locator.variable(span.unwrap_or(step.place), name);
        let message = format!("`?{name}` has no value yet while the step waits");
        let diagnostic = Diagnostic::error(codes::UNBOUND_VARIABLE, span, message)
            .label(report.locator.clause(step.place, clause), "this is evaluated when the waitfor holds")
            .help("write its expression here in place of the variable");
        report.add(diagnostic);
    }

    fn report_early(&self, step: &Step, name: &Symbol, producers: &[usize], report: &mut FindingCollector<'_>) {
        let producer = producers.first().and_then(|producer| self.procedure.steps.get(*producer));
        let Some(producer) = producer else { return };
        let span = report.locator.variable(step.place, name);
        let message = format!("`?{name}` may have no value here");
        let diagnostic = Diagnostic::new(Severity::Warning, codes::POSSIBLY_UNBOUND, span, message)
            .label(
                report.locator.span(producer.place),
                "its value is the result of this step, which need not have ended",
            )
            .reason("a step waits implicitly only for results in its waitfor, activity, select and forall")
            .help(format!("add `(waitfor (end ?{}))`", producer.tag));
        let fix = report.locator.add_wait(step.place, &producer.tag);
        report.add(diagnostic.fixes(fix));
    }
}

fn mentions(expr: &Expr, name: &Symbol) -> bool {
    let mut found = false;
    variables::of_expr(expr, &mut |each| found |= each == name);
    found
}

/// Returns the position of an expression inside the condition that uses the variable.
fn use_in_condition(condition: &Condition, name: &Symbol) -> Option<Place> {
    let mut place = None;
    walk::condition(condition, &mut |expr| {
        if matches!(&expr.kind, ExprKind::Variable { name: each, .. } if each == name) {
            place.get_or_insert(expr.place);
        }
    });
    place
}

/// Returns true if the condition holds only after that step has ended.
fn waits_for_end(condition: &Condition, tag: &Symbol) -> bool {
    match &condition.kind {
        ConditionKind::TaskEnded(name) => name == tag,
        ConditionKind::And(parts, _) | ConditionKind::InOrder(parts, _) => {
            parts.iter().any(|part| waits_for_end(part, tag))
        }
        ConditionKind::Or(parts, _) => !parts.is_empty() && parts.iter().all(|part| waits_for_end(part, tag)),
        _ => false,
    }
}

fn report_own_result(step: &Step, name: &Symbol, report: &mut FindingCollector<'_>) {
    let span = report.locator.variable(step.place, name);
    let message = format!("`?{name}` has no value before the step has ended");
    let diagnostic = Diagnostic::error(codes::UNBOUND_VARIABLE, span, message)
        .reason("only the step's own `=>` gives it one")
        .help("use another variable, or give it a first value: `(on-start (setq ?x ..))` in the procedure");
    report.add(diagnostic);
}

/// Reports a variable that only some alternatives bind, or that occurs only below a negation.
fn report_branch(
    place: Place,
    name: &Symbol,
    waitfor: &Bound<'_>,
    index: &Bound<'_>,
    report: &mut FindingCollector<'_>,
) {
    let branch = waitfor.perhaps.get(name).or_else(|| index.perhaps.get(name));
    let negated = waitfor.never.get(name).or_else(|| index.never.get(name));
    let diagnostic = match (branch, negated) {
        (Some(branch), _) => {
            let span = report.locator.use_of_variable(place, name);
            let message = format!("`?{name}` may have no value here");
            let diagnostic = Diagnostic::new(Severity::Warning, codes::POSSIBLY_UNBOUND, span, message)
                .reason("only one of the alternatives gives it a value")
                .help(format!("let each alternative bind `?{name}`, or make a step for each"));
            match branch {
                Some(branch) => diagnostic.label(report.locator.span(*branch), "bound in this alternative only"),
                None => diagnostic,
            }
        }
        (None, Some(negated)) => {
            let span = report.locator.use_of_variable(place, name);
            let diagnostic =
                Diagnostic::error(codes::UNBOUND_VARIABLE, span, format!("`?{name}` never has a value here"))
                    .reason("a negated condition holds if nothing matches, so it binds no variable")
                    .help("bind the variable in the index, a select, or another condition");
            match negated {
                Some(negated) => diagnostic.label(report.locator.span(*negated), "this binds nothing"),
                None => diagnostic,
            }
        }
        (None, None) => return,
    };
    report.add(diagnostic);
}

/// Reports variables of `:for-new` that the waitfor does not bind.
fn nothing_new(step: &Step, report: &mut FindingCollector<'_>) {
    let (name, clause) = match (&step.responding, &step.repeating) {
        (Some(clause), _) => ("responding", clause),
        (None, Some(clause)) => ("repeating", clause),
        (None, None) => return,
    };
    if clause.for_new.is_empty() {
        return;
    }
    let bound = by_all(&step.waitfor);
    let is_bound = |name: &Symbol| bound.surely.contains(name) || bound.perhaps.contains_key(name);
    for variable in clause.for_new.iter().filter(|variable| !is_bound(variable)) {
        let span = report.locator.variable_in_clause(step.place, name, variable);
        let message = format!("`?{variable}` never gets a new value");
        let diagnostic = Diagnostic::new(Severity::Warning, codes::NOTHING_NEW, span, message)
            .reason(
                "`:for-new` compares values that the step's waitfor binds, and the waitfor does not bind this variable",
            )
            .help(format!("name a variable of the waitfor, or let the waitfor bind `?{variable}`"));
        report.add(diagnostic);
    }
}
