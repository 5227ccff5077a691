//! WAM (paper, section V.C): best-first search with replacement that builds the full plan visit by visit.
//!
//! From the vehicle's position a window of time is searched. Open nodes are partial tours, each expanded to the targets with the highest
//! `importance x obsolescence / transit`. A node's cost is the change that its visits make to the expected cost of ignorance up to the end
//! of the window, so that all nodes are compared over the same span. The list of open nodes is bounded, and better nodes replace worse
//! ones. The first visit of the best tour is committed, and the search starts again from there. Windows and list sizes are tried from small
//! to large while the budget lasts; the best full plan wins.
//! Bound: O(visits x depth x open x children) per pass.

use apex_metrics::eci;
use apex_model::problem::{Plan, Problem};
use apex_planning::solver::{Budget, Environment, Solver};
use apex_planning::surveillance::previous;
use apex_planning::surveillance::scenario::{Scenario, Stop};

/// Window in mean transit times, size of the open list, children per node: from greedy to thorough.
const PASSES: &[(f64, usize, usize)] =
    &[(2.0, 1, 4), (4.0, 8, 4), (8.0, 8, 4), (16.0, 8, 4), (8.0, 32, 6), (16.0, 32, 6), (32.0, 32, 6), (24.0, 128, 8)];
/// Maximum number of visits in one window.
const DEPTH_MAX: usize = 64;
/// Work, in nanoseconds, of computing the priority of a visit, and of copying a state into a node of the search.
const PRIORITY_NS: u64 = 30;
const CHILD_NS: u64 = 230;

/// The planner.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wam;

impl Solver for Wam {
    fn name(&self) -> &'static str {
        "wam"
    }

    fn serves(&self, problem: &Problem) -> bool {
        matches!(problem, Problem::Surveillance(_))
    }

    fn solve(&self, problem: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String> {
        let Problem::Surveillance(problem) = problem else {
            return Err("the solver `wam` accepts surveillance problems only".to_string());
        };
        let scenario = Scenario::new(problem)?;
        let report = &mut *environment.report;
        let mut tell = |tour: &[usize]| report(&Plan::Surveillance(scenario.plan("wam", tour.iter().copied())));
        let left = previous::better(&scenario, environment.previous, f64::INFINITY, environment.budget);
        let least = left.as_ref().map_or(f64::INFINITY, |(cost, tour)| {
            tell(tour);
            *cost
        });
        let (cost, mut tour) = best_of_passes(&scenario, environment.budget, &mut |cost, tour| {
            if cost < least {
                tell(tour);
            }
        });
        if let Some((_, before)) = left.filter(|(least, _)| *least < cost) {
            tour = before;
        }
        Ok(Plan::Surveillance(scenario.plan(self.name(), tour)))
    }
}

/// Returns the best tour found within the budget; `report` receives each better one. The greedy pass is always completed.
pub fn best_word(scenario: &Scenario<'_>, budget: &mut dyn Budget, report: &mut dyn FnMut(&[usize])) -> Vec<usize> {
    best_of_passes(scenario, budget, &mut |_, tour| report(tour)).1
}

/// Returns the number of passes.
pub fn passes() -> usize {
    PASSES.len()
}

/// Returns the work of the pass of this number in comparison with others.
pub fn weight(number: usize) -> f64 {
    PASSES.get(number).map_or(0.0, |(window, open, children)| window * (open * children) as f64)
}

/// Returns the tour of one pass; `None` if the budget ran out or there is no such pass.
pub fn pass(scenario: &Scenario<'_>, number: usize, budget: &mut dyn Budget) -> Option<Vec<usize>> {
    build(scenario, *PASSES.get(number)?, false, budget)
}

/// Returns the best tour of all passes with its cost, which `report` receives too.
fn best_of_passes(
    scenario: &Scenario<'_>,
    budget: &mut dyn Budget,
    report: &mut dyn FnMut(f64, &[usize]),
) -> (f64, Vec<usize>) {
    let mut best: (f64, Vec<usize>) = (f64::INFINITY, Vec::new());
    for (number, pass) in PASSES.iter().enumerate() {
        let Some(tour) = build(scenario, *pass, number == 0, budget) else { break };
        let cost = scenario.cost(tour.iter().copied(), budget);
        if best.1.is_empty() || cost < best.0 {
            best = (cost, tour);
            report(best.0, &best.1);
        }
    }
    best
}

/// State between two visits: the last visited target, the time, and the end of the last observation of each target.
#[derive(Clone, Debug)]
struct TourState {
    place: Option<usize>,
    time_s: f64,
    last_s: Vec<f64>,
}

#[derive(Clone, Debug)]
struct SearchNode {
    state: TourState,
    first: Option<Stop>,
    cost: f64,
}

/// Builds one tour from start to horizon; `None` if the budget ran out (a `certain` pass ignores the budget).
fn build(
    scenario: &Scenario<'_>,
    pass: (f64, usize, usize),
    certain: bool,
    budget: &mut dyn Budget,
) -> Option<Vec<usize>> {
    let problem = scenario.problem();
    let window_s = pass.0 * scenario.mean_transit_s();
    let ages = problem.targets.iter().map(|target| -target.initial_age_s).collect();
    let mut state = TourState { place: None, time_s: 0.0, last_s: ages };
    let mut tour = Vec::new();
    while tour.len() < apex_planning::surveillance::scenario::VISITS_MAX {
        if budget.exhausted() && !certain {
            return None;
        }
        let until_s = (state.time_s + window_s).min(problem.horizon_s);
        let Some(stop) = best_first(scenario, &state, until_s, (pass.1, pass.2), budget) else { break };
        visit(&mut state, stop);
        tour.push(stop.target);
    }
    Some(tour)
}

fn visit(state: &mut TourState, stop: Stop) {
    if let Some(last_s) = state.last_s.get_mut(stop.target) {
        *last_s = stop.end_s;
    }
    (state.place, state.time_s) = (Some(stop.target), stop.end_s);
}

/// Returns the first visit of the tour with the least expected cost over the window; `None` if no visit is possible.
fn best_first(
    scenario: &Scenario<'_>,
    state: &TourState,
    until_s: f64,
    (open_max, children_max): (usize, usize),
    budget: &mut dyn Budget,
) -> Option<Stop> {
    let mut open = vec![SearchNode { state: state.clone(), first: None, cost: 0.0 }];
    let mut best: Option<(f64, Stop)> = None;
    for _ in 0..DEPTH_MAX {
        let mut next: Vec<SearchNode> = Vec::new();
        for node in &open {
            for stop in children(scenario, &node.state, children_max, budget) {
                scenario.spend(CHILD_NS + scenario.problem().targets.len() as u64 / 2);
                let mut child = node.clone();
                child.cost += change(scenario, &node.state, stop, until_s.max(stop.end_s));
                let first = *child.first.get_or_insert(stop);
                visit(&mut child.state, stop);
                if best.as_ref().is_none_or(|(least, _)| child.cost < *least) {
                    best = Some((child.cost, first));
                }
                if stop.end_s < until_s {
                    next.push(child);
                }
            }
        }
        if next.is_empty() {
            break;
        }
        next.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        next.truncate(open_max);
        open = next;
    }
    best.map(|(_, stop)| stop)
}

/// Returns the change of the expected cost until `until_s` by a visit: zero or less.
fn change(scenario: &Scenario<'_>, state: &TourState, stop: Stop, until_s: f64) -> f64 {
    let (Some(target), Some(last_s)) = (scenario.problem().targets.get(stop.target), state.last_s.get(stop.target))
    else {
        return 0.0;
    };
    eci::interval_cost(target, *last_s, stop.end_s) + eci::interval_cost(target, stop.end_s, until_s)
        - eci::interval_cost(target, *last_s, until_s)
}

/// Returns the possible visits with the highest priority.
fn children(scenario: &Scenario<'_>, state: &TourState, most: usize, budget: &mut dyn Budget) -> Vec<Stop> {
    scenario.charge(scenario.usable().len() as u64 * (PRIORITY_NS + scenario.departure_ns()), budget);
    // The best candidates so far, best first; of equal ones the earlier first.
    let mut ranked: Vec<(f64, Stop)> = Vec::with_capacity(most + 1);
    for target in scenario.usable() {
        let Some(found) = priority(scenario, state, *target) else { continue };
        let place = ranked.partition_point(|(before, _)| before.total_cmp(&found.0).is_ge());
        if place < most {
            ranked.insert(place, found);
            ranked.truncate(most);
        }
    }
    ranked.into_iter().map(|(_, stop)| stop).collect()
}

/// Returns `importance x obsolescence / transit` of a visit; `None` if it would end too late.
fn priority(scenario: &Scenario<'_>, state: &TourState, target: usize) -> Option<(f64, Stop)> {
    let stop = scenario.next_stop(state.place, state.time_s, target)?;
    let data = scenario.problem().targets.get(target)?;
    let obsolescence_s = stop.end_s - *state.last_s.get(target)?;
    let importance = data.rate.at(stop.end_s) * eci::cost_at(&data.cost, obsolescence_s);
    let transit_s = (stop.end_s - state.time_s).max(1e-3);
    Some((importance * obsolescence_s / transit_s, stop))
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_planning::examples::surveillance as examples;
    use apex_planning::solver::WorkBudget;

    #[test]
    fn more_work_is_never_worse_and_beats_greedy() {
        let (mut better, mut sum) = (0, 0.0);
        for seed in 0..12 {
            let problem = examples::random(10, seed);
            let scenario = Scenario::new(&problem).unwrap();
            let cost = |units| {
                let tour = best_word(&scenario, &mut WorkBudget::new(units), &mut |_| {});
                scenario.cost(tour, &mut WorkBudget::new(u64::MAX))
            };
            let (greedy, thorough) = (cost(0), cost(30_000));
            assert!(thorough <= greedy);
            better += u32::from(thorough < greedy);
            sum += thorough / greedy;
        }
        assert!(better >= 8 && sum / 12.0 < 0.99, "{better} {sum}");
    }

    #[test]
    fn the_urgent_target_comes_first() {
        let mut problem = examples::random(4, 9);
        problem.targets[2].initial_age_s = 5000.0;
        problem.targets[2].rate = apex_model::problem::EventRate::constant(20.0);
        let scenario = Scenario::new(&problem).unwrap();
        let tour = best_word(&scenario, &mut WorkBudget::new(2_000), &mut |_| {});
        assert_eq!(tour[0], 2);
    }
}
