//! Looks that are wanted some time after, or before, another look of the same target.
//!
//! Planners know windows, not intervals. The looks without an interval are planned first; then the others, round by round, with windows
//! that follow from the looks planned so far, which keep their instants within a tolerance. If a look is missing then, its target is
//! planned from this look on, and the others follow in its windows: the earliest look of a target may leave no time for a valuable later
//! one. Operators state the order of their visits: for them the timing of each look states the factor of its interval.

mod imposed_timing;

use super::operator_plan::HUMAN;
use super::solve::{Deliberation, SolveOptions, solve};
use crate::problem::{NoPlan, interval_windows, is_bound_to_seen};
use crate::{Mission, TargetKind};
use apex_model::problem::{
    LeftOut, Plan, PlannedVisit, Problem, SingleVisitPlan, SingleVisitProblem, SingleVisitTarget, TimeWindow,
};
use apex_observation::target::IntervalNeed;
use apex_planning::obstacle::LeftOutReason;
use apex_runtime::invocation::Invocations;
use apex_runtime::ports::CancelToken;

/// Greatest tolerance for looks that are planned already, s.
const TOLERANCE_S: f64 = 600.0;
/// The tolerance as a share of the width of the interval.
const TOLERANCE_SHARE: f64 = 0.25;
/// Begin of the planner's reason for a look whose windows follow from other looks.
const AT_INTERVAL: &str = "at the wanted interval to the other looks of its target";
/// Reason of a look for which no plan has time.
const NO_TIME: &str = "no time is left at the wanted interval to the other looks of its target";
/// Reason of a look that a plan could contain, but not with a higher score.
const NO_GAIN: &str =
    "a visit at the wanted interval to the other looks of its target does not raise the score of the plan";

/// A look that is planned after other looks of its target.
#[derive(Clone)]
struct LaterLook {
    name: String,
    siblings: Vec<String>,
    need: IntervalNeed,
}

/// Like [`solve`], with the intervals between looks of the mission.
///
/// # Errors
/// Like [`solve`].
pub(super) fn solve_with_intervals(
    mission: Option<&Mission>,
    problem: Problem,
    wish: SolveOptions<'_>,
    invocations: &mut Invocations,
    cancel: &CancelToken,
) -> Result<Deliberation, NoPlan> {
    let rounds = match (mission, &problem) {
        (Some(mission), Problem::SingleVisit(problem)) => later_looks(mission, problem),
        _ => Vec::new(),
    };
    let Problem::SingleVisit(whole) = &problem else { return solve(problem, wish, invocations, cancel) };
    if rounds.is_empty() {
        return solve(problem, wish, invocations, cancel);
    }
    let whole = whole.clone();
    if let Some(mission) = mission.filter(|_| wish.solver == Some(HUMAN)) {
        return imposed_timing::solve_in_order(mission, whole, wish, invocations, cancel);
    }
    let SolveOptions { means, solver, budget, seed, .. } = &wish;
    let again = SolveOptions { means, solver: *solver, budget: *budget, seed: *seed, previous: None };
    let mut best = solve_in_rounds(&whole, &rounds, wish, invocations, cancel)?;
    if let Some(rounds) = from_missing_looks(&rounds, &best.plan)
        && let Ok(second) = solve_in_rounds(&whole, &rounds, again, invocations, cancel)
    {
        let work = best.work + second.work;
        if score(&second.plan) > score(&best.plan) {
            best = second;
        }
        best.work = work;
    }
    Ok(best)
}

fn solve_in_rounds(
    whole: &SingleVisitProblem,
    rounds: &[Vec<LaterLook>],
    wish: SolveOptions<'_>,
    invocations: &mut Invocations,
    cancel: &CancelToken,
) -> Result<Deliberation, NoPlan> {
    let SolveOptions { means, solver, budget, seed, .. } = &wish;
    let (means, solver, budget, seed) = (*means, *solver, *budget, *seed);
    let is_later = |name: &str| rounds.iter().flatten().any(|look| look.name == name);
    let first = without(whole, &is_later);
    let mut best = solve(Problem::SingleVisit(first), wish, invocations, cancel)?;
    let mut reasons: Vec<LeftOut> = Vec::new();
    for looks in rounds {
        let (Problem::SingleVisit(problem), Plan::SingleVisit(plan)) = (&best.problem, &best.plan) else { break };
        let Some(next) = with_looks(whole, problem, plan, looks) else { continue };
        let wish = SolveOptions { means, solver, budget, seed, previous: Some(best.plan.clone()) };
        if let Ok(found) = solve(Problem::SingleVisit(next), wish, invocations, cancel) {
            let work = best.work + found.work;
            // The plan without these looks misses those of them that must be made.
            let added = whole.targets.iter().filter(|target| looks.iter().any(|look| look.name == target.name));
            let missed = added.map(SingleVisitTarget::miss_cost).sum::<f64>();
            if score(&found.plan) > score(&best.plan) - missed {
                best = found;
            } else {
                reasons.extend(looks.iter().map(|look| without_gain(&look.name, &found.plan)));
            }
            best.work = work;
        }
    }
    name_missing(rounds, &reasons, &mut best);
    Ok(best)
}

/// Returns the looks with intervals that are planned after others of their target, by rounds. A look for which another one was already
/// observed has its window, and is planned with the rest; so is the first of a target whose looks all have intervals.
fn later_looks(mission: &Mission, problem: &SingleVisitProblem) -> Vec<Vec<LaterLook>> {
    let mut rounds: Vec<Vec<LaterLook>> = Vec::new();
    for target in &mission.targets {
        let TargetKind::Fire(fire) = &target.kind else { continue };
        let posed = |name: &str| problem.targets.iter().find(|posed| posed.name == name);
        let open: Vec<_> = fire.looks().filter_map(|(name, look)| Some((posed(&name)?, name, look))).collect();
        let (mut later, mut now) = (Vec::new(), 0);
        for (posed, name, look) in &open {
            match look.interval.filter(|_| !is_bound_to_seen(look, &posed.windows)) {
                Some(need) => later.push((name, need)),
                None => now += 1,
            }
        }
        let first = usize::from(now == 0);
        for (round, (name, need)) in later.into_iter().skip(first).enumerate() {
            let siblings = open.iter().map(|(_, other, _)| other.clone()).filter(|other| other != name).collect();
            if rounds.len() <= round {
                rounds.push(Vec::new());
            }
            if let Some(looks) = rounds.get_mut(round) {
                looks.push(LaterLook { name: name.clone(), siblings, need });
            }
        }
    }
    rounds
}

/// Returns the rounds in which targets with a missing look are planned from this look on; `None` if no look is missing.
fn from_missing_looks(rounds: &[Vec<LaterLook>], plan: &Plan) -> Option<Vec<Vec<LaterLook>>> {
    let visited = plan.targets();
    let is_missing = |look: &&LaterLook| !visited.contains(&look.name.as_str());
    let mut firsts: Vec<&LaterLook> = Vec::new();
    for look in rounds.iter().flatten().filter(is_missing) {
        // One look of each target.
        if !firsts.iter().any(|first| first.siblings.contains(&look.name)) {
            firsts.push(look);
        }
    }
    let is_first = |name: &str| firsts.iter().any(|first| first.name == name);
    let is_later = |name: &str| rounds.iter().flatten().any(|look| look.name == name);
    let of_first = |first: &&LaterLook| -> Vec<LaterLook> {
        let siblings = first.siblings.iter().filter(|name| !is_later(name));
        let follow =
            |name: &String| LaterLook { name: name.clone(), siblings: vec![first.name.clone()], need: first.need };
        siblings.map(follow).collect()
    };
    let mut reversed: Vec<Vec<LaterLook>> = vec![firsts.iter().flat_map(of_first).collect()];
    reversed.extend(rounds.iter().map(|looks| looks.iter().filter(|look| !is_first(&look.name)).cloned().collect()));
    reversed.retain(|looks| !looks.is_empty());
    (!firsts.is_empty()).then_some(reversed)
}

/// Returns the problem without some targets.
fn without(problem: &SingleVisitProblem, is_left_out: &dyn Fn(&str) -> bool) -> SingleVisitProblem {
    let mut problem = problem.clone();
    problem.targets.retain(|target| !is_left_out(&target.name));
    problem.precedence.retain(|(earlier, later)| !is_left_out(earlier) && !is_left_out(later));
    problem
}

/// Returns the problem of a plan with further looks in their windows; `None` if no look can be added.
fn with_looks(
    whole: &SingleVisitProblem,
    problem: &SingleVisitProblem,
    plan: &SingleVisitPlan,
    looks: &[LaterLook],
) -> Option<SingleVisitProblem> {
    let mut next = problem.clone();
    let mut is_any = false;
    for look in looks {
        let is_sibling = |visit: &&PlannedVisit| look.siblings.contains(&visit.target);
        let siblings: Vec<&PlannedVisit> = plan.visits.iter().filter(is_sibling).collect();
        let Some(mut target) = whole.targets.iter().find(|target| target.name == look.name).cloned() else { continue };
        if !siblings.is_empty() {
            let tolerance_s = (TOLERANCE_SHARE * (look.need.max_s - look.need.min_s)).min(TOLERANCE_S);
            let times_s: Vec<(f64, f64)> =
                siblings.iter().map(|visit| (visit.begin_s - tolerance_s, visit.end_s + tolerance_s)).collect();
            let duration_s = target.manoeuvres.iter().map(|way| way.duration_s).fold(0.0, f64::max);
            target.windows = clipped(&target.windows, &interval_windows(&times_s, &look.need, duration_s));
            if target.windows.is_empty() {
                continue;
            }
            for visit in siblings {
                let Some(sibling) = next.targets.iter_mut().find(|target| target.name == visit.target) else {
                    continue;
                };
                let (from_s, until_s) = (visit.begin_s - tolerance_s, visit.begin_s + tolerance_s);
                sibling.windows = clipped(&sibling.windows, &[TimeWindow { from_s, until_s }]);
            }
        }
        is_any = true;
        next.targets.push(target);
    }
    let is_in = |name: &str| next.targets.iter().any(|target| target.name == name);
    let pairs = whole.precedence.iter().filter(|(earlier, later)| is_in(earlier) && is_in(later));
    next.precedence = pairs.cloned().collect();
    is_any.then_some(next)
}

/// Returns the times that lie in one of `windows` (none: any time) and in one of `others`.
fn clipped(windows: &[TimeWindow], others: &[TimeWindow]) -> Vec<TimeWindow> {
    if windows.is_empty() {
        return others.to_vec();
    }
    let both = windows.iter().flat_map(|one| {
        others.iter().map(move |other| TimeWindow {
            from_s: one.from_s.max(other.from_s),
            until_s: one.until_s.min(other.until_s),
        })
    });
    both.filter(|window| window.from_s <= window.until_s).collect()
}

fn score(plan: &Plan) -> f64 {
    match plan {
        Plan::SingleVisit(plan) => plan.score,
        Plan::Surveillance(_) => 0.0,
    }
}

/// Returns why a look is left out of the plan that `found` would replace: its planner's reason, or no gain.
fn without_gain(look: &str, found: &Plan) -> LeftOut {
    let reason = match found {
        Plan::SingleVisit(found) => found.left_out.iter().find(|left_out| left_out.target == look).cloned(),
        Plan::Surveillance(_) => None,
    };
    match reason {
        Some(known) => LeftOut { reason: format!("{AT_INTERVAL}, {}", known.reason), ..known },
        None => LeftOutReason::from(NO_GAIN).of(look.to_string()),
    }
}

/// Lists the looks that the last problem does not contain, with the reasons that are known.
fn name_missing(rounds: &[Vec<LaterLook>], reasons: &[LeftOut], solved: &mut Deliberation) {
    let (Problem::SingleVisit(problem), Plan::SingleVisit(plan)) = (&solved.problem, &mut solved.plan) else { return };
    for look in rounds.iter().flatten() {
        if !problem.targets.iter().any(|target| target.name == look.name) {
            let known = reasons.iter().find(|left_out| left_out.target == look.name).cloned();
            let no_time = || LeftOutReason::from(NO_TIME).of(look.name.clone());
            plan.left_out.push(known.unwrap_or_else(no_time));
        }
    }
}
