//! Result report (M&I)
//! What: reports each result of a monitor once, for sessions, which need all results instead of the first one.
//! Runs: at the end of an instant, for the monitors of a session that were touched.
//! Reads: the monitor's tree, evaluation context.
//! Writes: what was reported; results that were reported leave the monitor.
//! Bound: that of the verdict; reported results are not combined again.
//! PDL: all conditions.
//! Paper: section IV, creating monitors from PDL specifications.

use crate::expression::EvalContext;
use crate::monitoring::combination::dispatch::advance;
use crate::monitoring::combination::{conjunction_firsts, dominance, logic, point_sweep};
use crate::monitoring::episodes::episode;
use crate::monitoring::numbers::statistics;
use crate::monitoring::part::{Truth, site};
use crate::monitoring::reported_results::{Branch, Key, ReportedResults, Used};
use crate::monitoring::verdict_query::VerdictQuery;
use crate::state::monitors::monitor::{Monitor, Part, PartKind, Satisfaction};
use apex_model::because::Evidence;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

/// A report of one result.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ResultReport {
    pub(crate) result: Satisfaction,
    pub(crate) kind: ResultReportKind,
}

/// Kind of report about a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ResultReportKind {
    /// A new result; if it is open, its interval may still grow.
    Found { open: bool },
    /// The interval of a reported result is final.
    Closed,
}

/// Returns the reports at `context.now()`, after all stimuli of the instant were noticed. `lateness` is the maximum lateness
/// of samples.
pub(crate) fn report_results(
    monitor: &mut Monitor,
    told: &mut ReportedResults,
    lateness: Duration,
    context: &dyn EvalContext,
) -> Vec<ResultReport> {
    let mut query = VerdictQuery::new(context);
    advance(&mut monitor.root, context, &mut query.troubles);
    let mut tellings = Vec::new();
    let mut number = 0;
    let mut search =
        ResultCollector { told, number: &mut number, lateness, above: Vec::new(), tellings: &mut tellings };
    search.part(&mut monitor.root, &mut query);
    for telling in tellings.iter_mut().filter(|telling| telling.kind != ResultReportKind::Closed) {
        // Time advances in steps small enough that no result is found late, unless its evidence arrived late.
        telling.result.recognised_at = query.now;
    }
    monitor.asked_at = query.now;
    if query.wake.is_some() || monitor.notes.is_some() {
        monitor.notes.get_or_insert_default().delay_over_at = query.wake;
    }
    query.troubles.tell(monitor);
    tellings
}

/// Returns the final state of results that were reported while their interval grew, given that no more input follows.
pub(crate) fn finish(monitor: &Monitor, told: &mut ReportedResults, context: &dyn EvalContext) -> Vec<ResultReport> {
    let mut query = VerdictQuery::new(context);
    let mut branches = Vec::new();
    collect_branches(&monitor.root, &mut branches);
    let mut tellings = Vec::new();
    for (part, branch) in branches.into_iter().zip(&mut told.0) {
        let open = std::mem::take(&mut branch.open);
        let results = if open.is_empty() { Vec::new() } else { logic::results(part, &mut query) };
        let closed = results.into_iter().filter(|result| open.contains(&Key::of(part.place, result)));
        tellings.extend(closed.map(|result| ResultReport { result, kind: ResultReportKind::Closed }));
    }
    tellings
}

fn collect_branches<'a>(part: &'a Part, branches: &mut Vec<&'a Part>) {
    match &part.kind {
        PartKind::Or(composite) => composite.parts.iter().for_each(|part| collect_branches(part, branches)),
        _ => branches.push(part),
    }
}

struct ResultCollector<'a> {
    told: &'a mut ReportedResults,
    number: &'a mut usize,
    lateness: Duration,
    /// Tags and constraints of the enclosing `:or`s.
    above: Vec<(Option<Symbol>, Vec<apex_model::expression::Expr>)>,
    tellings: &'a mut Vec<ResultReport>,
}

impl ResultCollector<'_> {
    fn part(&mut self, part: &mut Part, query: &mut VerdictQuery<'_>) {
        if let PartKind::Or(composite) = &mut part.kind {
            self.above.push((part.tag.clone(), composite.constraints.clone()));
            composite.parts.iter_mut().for_each(|part| self.part(part, query));
            self.above.pop();
            return;
        }
        if self.told.0.len() <= *self.number {
            self.told.0.push(Branch::default());
        }
        let mut branch = self.told.0.get_mut(*self.number).map(std::mem::take).unwrap_or_default();
        self.branch(part, &mut branch, query);
        if let Some(slot) = self.told.0.get_mut(*self.number) {
            *slot = branch;
        }
        *self.number += 1;
    }

    fn branch(&mut self, part: &mut Part, branch: &mut Branch, query: &mut VerdictQuery<'_>) {
        conjunction_firsts::sweep(part, Some(&branch.used), query.context);
        if logic::truth(part, query) != Truth::True {
            // An open result that is gone was withdrawn by a late sample.
            branch.open.clear();
            return;
        }
        let open_now = open_keys(part, query);
        self.closed(part, branch, &open_now, query);
        query.used = Some(std::mem::take(&mut branch.used));
        let mut fresh = logic::results(part, query);
        branch.used = query.used.take().unwrap_or_default();
        // Each window of an `:absent` is a separate result.
        let once = !matches!(part.kind, PartKind::Absent(_));
        if branch.absence && once {
            fresh.retain(|result| !is_absence(result));
        }
        for (tag, constraints) in self.above.iter().rev() {
            fresh.retain(|result| logic::alternative_holds(tag.as_ref(), constraints, result, query));
            if let Some(tag) = tag {
                let bind =
                    |result: &mut Satisfaction| result.bindings.set(tag.clone(), interval_value(result.interval));
                fresh.iter_mut().for_each(bind);
            }
        }
        if fresh.is_empty() {
            return;
        }
        if is_composite(part) {
            dominance::one_for_each_binding(&mut fresh);
        }
        branch.absence |= fresh.iter().any(is_absence);
        for result in fresh {
            let key = Key::of(part.place, &result);
            let open = open_now.contains(&key);
            if open {
                branch.open.push(key);
            }
            self.tellings.push(ResultReport { result, kind: ResultReportKind::Found { open } });
        }
        self.use_up(part, &mut branch.used, query);
    }

    /// Reports the results whose intervals are final now.
    fn closed(&mut self, part: &Part, branch: &mut Branch, open_now: &[Key], query: &mut VerdictQuery<'_>) {
        if branch.open.iter().all(|key| open_now.contains(key)) {
            return;
        }
        for result in logic::results(part, query) {
            let key = Key::of(part.place, &result);
            if branch.open.contains(&key) && !open_now.contains(&key) {
                self.tellings.push(ResultReport { result, kind: ResultReportKind::Closed });
            }
        }
        branch.open.retain(|key| open_now.contains(key));
    }

    /// Marks the present results of the parts as used, so that they make no further result.
    fn use_up(&self, part: &mut Part, used: &mut Used, query: &mut VerdictQuery<'_>) {
        let horizon = query.now - self.lateness;
        match self.lateness {
            Duration::ZERO => used.keys.clear(),
            _ => {
                used.horizon = Some(horizon);
                used.keys.retain(|key| key.recognised_at >= horizon);
            }
        }
        take_out(part, self.lateness, used, query);
    }
}

fn interval_value(interval: (Time, Time)) -> Value {
    Value::Interval(interval.0, interval.1)
}

fn is_absence(result: &Satisfaction) -> bool {
    result.evidence.iter().next().is_some()
        && result.evidence.iter().all(|each| matches!(each, Evidence::Absence { .. }))
}

fn is_composite(part: &Part) -> bool {
    matches!(part.kind, PartKind::And(_) | PartKind::InOrder(_))
}

/// Returns the results of an open episode.
fn open_keys(part: &Part, query: &mut VerdictQuery<'_>) -> Vec<Key> {
    let open = match &part.kind {
        PartKind::Episode(leaf) => {
            episode::open_results(leaf, site(part), query.now, query.context, &mut query.troubles)
        }
        PartKind::Statistical(leaf) => statistics::open_results(leaf, site(part), query),
        _ => return Vec::new(),
    };
    open.iter().map(|result| Key::of(part.place, result)).collect()
}

/// Marks the results of all parts as used, and drops the settled ones.
fn take_out(part: &mut Part, lateness: Duration, used: &mut Used, query: &mut VerdictQuery<'_>) {
    match &mut part.kind {
        PartKind::And(composite) | PartKind::Or(composite) | PartKind::InOrder(composite) => {
            composite.parts.iter_mut().for_each(|part| take_out(part, lateness, used, query));
            point_sweep::begin_again(composite);
            composite.sweep_at = composite.sweep_at.map(|_| conjunction_firsts::SWEEP_AT_LEAST);
            part.forgotten = composite.parts.iter().any(|part| part.forgotten);
            return;
        }
        // Results of a negated part are kept: they must stay known.
        PartKind::Not(_) => return,
        PartKind::Episode(leaf) if leaf.points.is_some() => {
            leaf.points.iter_mut().for_each(|points| points.use_up());
            part.forgotten = false;
            return;
        }
        PartKind::Measurement(_)
        | PartKind::Episode(_)
        | PartKind::Persisted(_)
        | PartKind::Regression(_)
        | PartKind::Statistical(_)
        | PartKind::Cyclic(_)
        | PartKind::Event(_)
        | PartKind::TaskEnded(_)
        | PartKind::TaskState(_)
        | PartKind::Timestamp(_)
        | PartKind::Delay(_)
        | PartKind::Allen(_)
        | PartKind::Absent(_)
        | PartKind::Function(_) => {}
    }
    if lateness == Duration::ZERO {
        drop_settled(part);
    }
    let present = logic::results(part, query);
    for key in present.iter().map(|result| Key::of(part.place, result)) {
        if !used.keys.contains(&key) {
            used.keys.push(key);
        }
    }
    drop_settled(part);
}

fn drop_settled(part: &mut Part) {
    // Results from now on are complete again.
    part.forgotten = false;
    match &mut part.kind {
        PartKind::Measurement(leaf) => {
            if let Some(seen) = &mut leaf.seen {
                seen.settled.clear();
            }
        }
        PartKind::Episode(leaf) => leaf.settled.clear(),
        PartKind::Persisted(leaf) => leaf.settled.clear(),
        PartKind::Statistical(leaf) => leaf.settled.clear(),
        PartKind::Cyclic(leaf) => leaf.settled.clear(),
        PartKind::Event(leaf) => leaf.settled.clear(),
        PartKind::TaskState(leaf) => leaf.settled.clear(),
        PartKind::Allen(leaf) => leaf.found.clear(),
        PartKind::Absent(leaf) => leaf.found.clear(),
        _ => {}
    }
}
