//! Intervals between looks of the same target in plans whose order of visits is given.

use crate::deliberation::solve::{Deliberation, SolveOptions, solve};
use crate::problem::{NoPlan, is_bound_to_seen};
use crate::{Mission, TargetKind};
use apex_model::problem::{Plan, PlannedVisit, Problem, SingleVisitPlan, SingleVisitProblem, SingleVisitTarget};
use apex_observation::target::IntervalNeed;
use apex_runtime::invocation::Invocations;
use apex_runtime::ports::CancelToken;

/// Number of times that a plan is timed again: the timing of a look can move it, and with it the looks after it.
const ROUNDS_MAX: usize = 4;
/// Width of the side of an interval without a ramp, s.
const EDGE_S: f64 = 1.0;

/// Plans visits in their given order, with the factors of the intervals that they keep or miss.
///
/// # Errors
/// Like [`solve`].
pub(super) fn solve_in_order(
    mission: &Mission,
    whole: SingleVisitProblem,
    wish: SolveOptions<'_>,
    invocations: &mut Invocations,
    cancel: &CancelToken,
) -> Result<Deliberation, NoPlan> {
    let SolveOptions { means, solver, budget, seed, .. } = &wish;
    let (means, solver, budget, seed) = (*means, *solver, *budget, *seed);
    let mut posed = whole.clone();
    let mut solved = solve(Problem::SingleVisit(whole.clone()), wish, invocations, cancel)?;
    for _ in 0..ROUNDS_MAX {
        let Plan::SingleVisit(plan) = &solved.plan else { break };
        let timed = timed(mission, &whole, plan);
        if timed == posed {
            break;
        }
        posed = timed;
        let again = SolveOptions { means, solver, budget, seed, previous: None };
        let work = solved.work;
        solved = solve(Problem::SingleVisit(posed.clone()), again, invocations, cancel)?;
        solved.work += work;
    }
    Ok(solved)
}

/// Returns the problem in which the timing of each look with an interval states the factor by the time since the look before it.
fn timed(mission: &Mission, whole: &SingleVisitProblem, plan: &SingleVisitPlan) -> SingleVisitProblem {
    let mut problem = whole.clone();
    for target in &mission.targets {
        let TargetKind::Fire(fire) = &target.kind else { continue };
        let looks: Vec<_> = fire.looks().collect();
        let of_target = |visit: &&PlannedVisit| looks.iter().any(|(name, _)| *name == visit.target);
        let mut last: Option<&PlannedVisit> = None;
        for visit in plan.visits.iter().filter(of_target) {
            let before = last;
            // A look that is worth nothing, as in the wrong light, does not count as a look.
            if visit.worth > 0.0 {
                last = Some(visit);
            }
            let Some(before) = before else { continue };
            let look = looks.iter().find(|(name, _)| *name == visit.target).map(|(_, look)| look);
            let Some(posed) = problem.targets.iter_mut().find(|posed| posed.name == visit.target) else { continue };
            let open = look.filter(|look| !is_bound_to_seen(look, &posed.windows));
            let Some(need) = open.and_then(|look| look.interval) else { continue };
            let middle_s = 0.5 * (before.begin_s + before.end_s);
            // The time between both looks is that between their middles.
            let since_s = middle_s - 0.5 * (visit.end_s - visit.begin_s);
            posed.timing = combined(posed, &interval_table(&need, since_s));
        }
    }
    problem
}

/// Returns the factor of an interval by the beginning of a look; the interval begins at `from_s`.
fn interval_table(need: &IntervalNeed, from_s: f64) -> Vec<(f64, f64)> {
    let ramp_s = need.ramp_s.max(EDGE_S);
    let mut table = Vec::new();
    if need.min_s > 0.0 {
        table.extend([(from_s + need.min_s - ramp_s, 0.0), (from_s + need.min_s, 1.0)]);
    } else {
        table.push((from_s, 1.0));
    }
    if need.max_s.is_finite() {
        table.extend([(from_s + need.max_s, 1.0), (from_s + need.max_s + ramp_s, 0.0)]);
    }
    table
}

/// Returns the product of a target's timing and a table, at the corners of both.
fn combined(target: &SingleVisitTarget, table: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let by_table = SingleVisitTarget { timing: table.to_vec(), ..SingleVisitTarget::default() };
    let mut times_s: Vec<f64> = target.timing.iter().chain(table).map(|(time_s, _)| *time_s).collect();
    times_s.sort_by(f64::total_cmp);
    times_s.dedup();
    times_s.into_iter().map(|time_s| (time_s, target.timing_at(time_s) * by_table.timing_at(time_s))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factor_falls_outside_of_the_interval() {
        let need = IntervalNeed { min_s: 360.0, max_s: 1_080.0, ramp_s: 3_600.0 };
        let timing = combined(&SingleVisitTarget::default(), &interval_table(&need, 7_000.0));
        let target = SingleVisitTarget { timing, ..SingleVisitTarget::default() };
        let factors = [7_360.0, 8_080.0, 8_080.0 + 900.0, 8_080.0 + 3_600.0, 20_000.0];
        assert_eq!(factors.map(|at_s| target.timing_at(at_s)), [1.0, 1.0, 0.75, 0.0, 0.0]);
        assert_eq!(target.timing_at(7_180.0), 0.95);
        // Without a ramp, and with a timing that falls to a half.
        let need = IntervalNeed { min_s: 0.0, max_s: 100.0, ramp_s: 0.0 };
        let falls = SingleVisitTarget { timing: vec![(0.0, 1.0), (50.0, 0.5)], ..SingleVisitTarget::default() };
        let timing = combined(&falls, &interval_table(&need, 0.0));
        let target = SingleVisitTarget { timing, ..falls };
        assert_eq!([50.0, 100.0, 101.0].map(|at_s| target.timing_at(at_s)), [0.5, 0.5, 0.0]);
    }
}
