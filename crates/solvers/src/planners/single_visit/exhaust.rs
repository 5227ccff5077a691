//! All orders of few targets, by labels: a plan of up to seven targets is the best one, also where a detour is shorter than a direct way.
//!
//! A label is the end of a sequence of visits: the visited targets, the last visit, its end, and the value so far. Labels with
//! the same targets and the same last visit compete: a label is dropped if another one is as early or earlier and has at least its value. This is valid
//! because a vehicle that departs later does not arrive earlier, and costs grow with time. A sequence counts as a plan where its end permits the way to the
//! base; where it does not, it may still lead to targets from which there is a way.
//! Bound: [`EXHAUSTED_TARGETS_MAX`] targets, the given number of labels, and the budget.

use crate::routing::schedule::{Choice, Schedule, UNITS_PER_LEG};
use crate::routing::travel::PointKey;
use apex_model::problem::SingleVisitProblem;
use apex_planning::solver::Budget;
use std::collections::BTreeMap;

/// Largest number of targets whose orders are enumerated.
pub(super) const EXHAUSTED_TARGETS_MAX: usize = 7;

/// Limits of the enumeration.
pub(super) struct Effort<'b> {
    /// Largest number of examined visits.
    pub(super) visits_max: u32,
    /// Work allowed in all.
    pub(super) budget: &'b mut dyn Budget,
    /// A score: sequences that cannot reach it even with the full value of all other targets are not continued. Benefits are then not
    /// compared.
    pub(super) score_min: Option<f64>,
}

/// Result of an enumeration.
pub(super) struct Exhausted {
    /// True if the effort sufficed for all sequences.
    pub(super) is_complete: bool,
    /// The order with the highest score, if one ends in time.
    pub(super) best: Option<Vec<Choice>>,
    /// Highest sum of the visits' values, of the sequences that were continued.
    pub(super) benefits_max: f64,
}

/// A sequence of visits, by its end.
#[derive(Clone, Copy)]
struct VisitSequence {
    /// The visited targets, a bit for each place among the usable ones.
    visited: u32,
    last: Choice,
    end_s: f64,
    worth: f64,
    before: Option<usize>,
}

/// Enumerates all orders of the `usable` targets; `choices` gives the ways to observe a target. `None` if there are too many
/// targets.
pub(super) fn exhaust(
    schedule: &mut Schedule<'_>,
    usable: &[usize],
    choices: &dyn Fn(usize) -> Vec<Choice>,
    effort: Effort<'_>,
) -> Option<Exhausted> {
    if usable.len() > EXHAUSTED_TARGETS_MAX {
        return None;
    }
    let ways: Vec<Vec<Choice>> = usable.iter().map(|target| choices(*target)).collect();
    let mut labels: Vec<VisitSequence> = Vec::new();
    let mut best: Option<(f64, f64, usize)> = None;
    let (mut benefits_max, mut examined) = (0.0_f64, 0);
    let Effort { visits_max, budget, score_min } = effort;
    let most: Vec<f64> = usable.iter().map(|target| worth_max(schedule.problem, *target)).collect();
    let mut open: Vec<Option<usize>> = vec![None];
    let mut is_complete = true;
    'layers: while !open.is_empty() {
        let mut next: BTreeMap<(u32, usize, usize), Vec<usize>> = BTreeMap::new();
        for before in open {
            let visited = before.and_then(|at| labels.get(at)).map_or(0, |label| label.visited);
            for (place, ways) in ways.iter().enumerate() {
                if visited & (1 << place) != 0 || !is_led(schedule, usable, place, visited) {
                    continue;
                }
                for choice in ways {
                    examined += 1;
                    budget.charge(UNITS_PER_LEG + schedule.travel.take_work());
                    if examined > visits_max || budget.exhausted() {
                        is_complete = false;
                        break 'layers;
                    }
                    let Some(label) = after(schedule, before.map(|at| (at, labels.as_slice())), *choice, place) else {
                        continue;
                    };
                    let same = next.entry((label.visited, choice.target, choice.manoeuvre)).or_default();
                    if keep(&mut labels, same, label)
                        && let Some((score, end_s)) = as_plan(schedule, &label)
                    {
                        benefits_max = benefits_max.max(label.worth);
                        let close = 1e-9 * (1.0 + score.abs());
                        let is_better = |(known, known_end_s, _)| {
                            score > known + close || (score > known - close && end_s < known_end_s - 1e-6)
                        };
                        if best.is_none_or(is_better) {
                            best = Some((score, end_s, labels.len() - 1));
                        }
                    }
                }
            }
        }
        let may_reach = |at: &usize| {
            let Some(label) = labels.get(*at) else { return false };
            let missing = most.iter().enumerate().filter(|(place, _)| label.visited & (1 << place) == 0);
            let hoped: f64 = missing.map(|(_, worth)| worth).sum();
            score_min.is_none_or(|least| label.worth + hoped - schedule.flight_cost(label.end_s) >= least)
        };
        open = next.into_values().flatten().filter(may_reach).map(Some).collect();
    }
    Some(Exhausted { is_complete, best: best.map(|(_, _, last)| order_to(&labels, last)), benefits_max })
}

/// Returns the most that a target can be worth.
pub(super) fn worth_max(problem: &SingleVisitProblem, target: usize) -> f64 {
    let Some(target) = problem.targets.get(target) else { return 0.0 };
    target.gain(target.manoeuvres.iter().map(|manoeuvre| manoeuvre.quality.product()).fold(0.0, f64::max))
}

/// Returns true if all targets that must precede the one at `place` are visited.
fn is_led(schedule: &Schedule<'_>, usable: &[usize], place: usize, visited: u32) -> bool {
    let Some(target) = usable.get(place) else { return false };
    let is_visited = |earlier: &usize| {
        usable.iter().position(|other| other == earlier).is_some_and(|place| visited & (1 << place) != 0)
    };
    schedule.earlier(*target).iter().all(is_visited)
}

/// Returns the label of `choice` after another one, or as the first visit; `None` if it cannot be flown.
fn after(
    schedule: &mut Schedule<'_>,
    before: Option<(usize, &[VisitSequence])>,
    choice: Choice,
    place: usize,
) -> Option<VisitSequence> {
    let here = before.and_then(|(at, labels)| labels.get(at).copied());
    let (node, ready_s) = here.map_or((PointKey::Start, schedule.problem.start_s), |label| {
        (PointKey::Exit(label.last.target, label.last.manoeuvre), label.end_s)
    });
    let timed = schedule.visit(node, ready_s, choice).ok()?;
    let (visited, worth) = here.map_or((0, 0.0), |label| (label.visited, label.worth));
    Some(VisitSequence {
        visited: visited | (1 << place),
        last: choice,
        end_s: timed.end_s,
        worth: worth + timed.worth,
        before: before.map(|(at, _)| at),
    })
}

/// Adds `label` to `labels` and to the indices `same`, unless one of these is as early and as valuable; removes from `same` those that it
/// replaces.
fn keep(labels: &mut Vec<VisitSequence>, same: &mut Vec<usize>, label: VisitSequence) -> bool {
    let at = |index: &usize| labels.get(*index).copied();
    if same.iter().filter_map(at).any(|other| other.end_s <= label.end_s && other.worth >= label.worth) {
        return false;
    }
    same.retain(|index| at(index).is_some_and(|other| other.end_s < label.end_s || other.worth > label.worth));
    same.push(labels.len());
    labels.push(label);
    true
}

/// Returns score and end of the flight that goes home after a label; `None` if there is no way in time.
fn as_plan(schedule: &mut Schedule<'_>, label: &VisitSequence) -> Option<(f64, f64)> {
    let end_s = schedule.home_at_s(PointKey::Exit(label.last.target, label.last.manoeuvre), label.end_s).ok()?;
    (!schedule.is_late(end_s)).then(|| (label.worth - schedule.flight_cost(end_s), end_s))
}

/// Returns the visits up to a label.
fn order_to(labels: &[VisitSequence], last: usize) -> Vec<Choice> {
    let mut order = Vec::new();
    let mut at = Some(last);
    while let Some(label) = at.and_then(|at| labels.get(at)) {
        order.push(label.last);
        at = label.before;
    }
    order.reverse();
    order
}
