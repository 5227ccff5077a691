//! The timetable against a naive twin; the search finds the optimum of small problems.

use super::*;
use crate::planners::single_visit::explain;
use crate::routing::network::{END, FIRST, NO_WAY, START, ceil_ticks};
use apex_model::problem::{CrewMember, Plan, Problem, SingleVisitPlan, SingleVisitProblem};
use apex_planning::examples::single_visit as examples;
use apex_planning::random::Generator;
use apex_planning::solver::{Solver, WorkBudget};
use apex_portfolio::formats;
use apex_portfolio::formats::generate::{self, Day, Family, Places};
use proptest::prelude::*;

pub(super) fn small(seed: u64, count: usize) -> SingleVisitProblem {
    let family = if seed.is_multiple_of(2) {
        Family::Solomon(Places::Random, if seed.is_multiple_of(4) { Day::Short } else { Day::Long })
    } else {
        Family::Cordeau { targets: 48, wide: seed.is_multiple_of(3) }
    };
    let mut problem = formats::read("s", &generate::windows(family, 1 + seed % 11)).unwrap().problem;
    let mut rng = Generator::new(seed);
    while problem.targets.len() > count {
        let out = rng.below(problem.targets.len());
        problem.targets.remove(out);
        let travel = problem.travel.as_mut().unwrap();
        travel.from_start_s.remove(out);
        travel.to_base_s.remove(out);
        travel.between_s.remove(out);
        for row in &mut travel.between_s {
            row.remove(out);
        }
    }
    problem
}

pub(super) fn network(problem: &SingleVisitProblem) -> Network {
    let usable: Vec<usize> = (0..problem.targets.len()).collect();
    Network::new(&mut Schedule::new(problem).unwrap(), &usable, &mut WorkBudget::new(u64::MAX)).unwrap()
}

/// Returns the end of the route in ticks, computed by visiting the nodes one by one; `None` if a visit begins too late.
fn naive_end(network: &Network, visits: &[u32]) -> Option<i32> {
    let (mut here, mut time) = (START, 0);
    for next in visits.iter().copied().chain([END]) {
        time = (time + network.leg(here, next)).max(network.node(next).open);
        if time > network.node(next).close {
            return None;
        }
        here = next;
    }
    Some(time)
}

#[test]
fn legs_are_those_of_all_targets_in_all_their_ways() {
    let mut problem = small(3, 8);
    let whole = network(&problem);
    problem.targets[2].value = 0.0;
    let again = problem.targets[5].manoeuvres[0].clone();
    problem.targets[5].manoeuvres.push(again);
    // A target without value stays in the network: it may be a companion that another target needs.
    for network in [whole, network(&problem)] {
        let travel = problem.travel.as_ref().unwrap();
        let targets: std::collections::BTreeSet<u32> = network.visits().map(|node| network.node(node).target).collect();
        assert_eq!(targets.len(), 8);
        for (from, to) in network.visits().flat_map(|from| network.visits().map(move |to| (from, to))) {
            let (here, there) = (network.node(from), network.node(to));
            let (target, next) = (here.target as usize, there.target as usize);
            let stay_s = problem.targets[target].manoeuvres[here.manoeuvre as usize].duration_s;
            let ticks = ceil_ticks(stay_s + travel.between_s[target][next], network.tick_s);
            let own = target == next;
            assert_eq!(network.leg(from, to), if own { NO_WAY } else { ticks }, "{target} {next}");
        }
    }
}

/// Rounds up as `f64::ceil` does; a leg that cannot be flown keeps its maximum.
fn ceiling(ticks: f64) -> i32 {
    libm::ceil(ticks.min(f64::from(NO_WAY)) - 1e-6) as i32
}

#[test]
fn a_tick_that_is_begun_counts_whole() {
    for ticks in
        [0.0, 5e-7, 1.5e-6, 0.5, 0.999_998, 1.0, 1.000_002, 2.5, 3.5, 134_217_728.0, 6e8, f64::INFINITY, f64::NAN]
    {
        assert_eq!(ceil_ticks(ticks, 1.0), ceiling(ticks), "{ticks}");
    }
}

proptest! {
    #[test]
    fn ticks_are_rounded_up(whole in 0..NO_WAY, part in 0.0..1.0f64) {
        let ticks = f64::from(whole) + part;
        prop_assert_eq!(ceil_ticks(ticks, 1.0), ceiling(ticks));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn the_timetable_knows_what_going_along_the_route_shows(seed in 0..10_000u64) {
        let problem = small(seed, 14);
        let network = network(&problem);
        let mut rng = Generator::new(seed);
        let mut route = Route::new(&network);
        for _ in 0..60 {
            let node = FIRST + rng.below(network.visits().len()) as u32;
            if route.sees(&network, node) {
                let at = 1 + rng.below(route.count());
                route.remove(&network, at, at + 1 + rng.below(2));
            } else {
                let visits: Vec<u32> = route.visits().collect();
                let data = network.node(node);
                for after in 0..=visits.len() {
                    let mut with = visits.clone();
                    with.insert(after, node);
                    let place = route.place(&network, node, data.open, data.close, after);
                    prop_assert_eq!(place.map(|place| place.end), naive_end(&network, &with));
                }
                let fits = |after: &usize| route.place(&network, node, data.open, data.close, *after).is_some();
                if let Some(after) = (0..=visits.len()).find(fits) {
                    route.insert(&network, node, after);
                }
            }
            let visits: Vec<u32> = route.visits().collect();
            prop_assert!(route.is_feasible());
            prop_assert_eq!(Some(route.end()), naive_end(&network, &visits));
            prop_assert_eq!(&route.stops, &Route::of(&network, &visits).stops);
        }
    }
}

pub(super) fn solved(problem: &SingleVisitProblem, units: u64, seed: u64) -> SingleVisitPlan {
    let mut budget = WorkBudget::new(units);
    let mut environment = Environment { seed, budget: &mut budget, report: &mut |_| {}, previous: None };
    let problem = Problem::SingleVisit(problem.clone());
    let plan = super::super::SingleVisit.solve(&problem, &mut environment).unwrap();
    assert_eq!(apex_planning::checker::violations(&problem, &plan), Vec::<String>::new());
    match plan {
        Plan::SingleVisit(plan) => plan,
        Plan::Surveillance(_) => panic!("a single-visit problem has a single-visit plan"),
    }
}

/// Returns the highest value of all routes by complete enumeration.
fn highest(network: &Network, visits: &mut Vec<u32>) -> f64 {
    let own: f64 = visits.iter().map(|node| network.node(*node).value).sum();
    let mut best = own;
    for node in network.visits() {
        if !visits.contains(&node) {
            visits.push(node);
            if naive_end(network, visits).is_some() {
                best = best.max(highest(network, visits));
            }
            visits.pop();
        }
    }
    best
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn small_problems_are_solved_to_the_optimum_and_never_claim_a_bound_below_it(seed in 0..10_000u64) {
        let problem = small(seed, 8);
        let network = network(&problem);
        let best = highest(&network, &mut Vec::new());
        prop_assume!(best > 0.0);
        let routes::Proven { bound, better } =
            routes::highest_value(&network, 0.0, 40_000, &mut WorkBudget::new(1 << 40));
        prop_assert!(bound >= best - 1e-9, "{bound} of {best}");
        if let Some(route) = better {
            prop_assert!(naive_end(&network, &route).is_some());
            prop_assert!((Route::of(&network, &route).value - best).abs() < 1e-9 && bound < best + 1e-6);
        }
        let plan = solved(&problem, 3_000, seed);
        prop_assert!((plan.benefits - best).abs() < 1e-9, "{} of {best}", plan.benefits);
        prop_assert!(plan.benefits_bound.unwrap() >= best - 1e-9);
    }
}

/// Returns the highest score of all routes by complete enumeration: their value minus the cost of their flight time.
fn highest_score(network: &Network, visits: &mut Vec<u32>) -> f64 {
    let own: f64 = visits.iter().map(|node| network.node(*node).value).sum();
    let Some(end) = naive_end(network, visits) else { return f64::NEG_INFINITY };
    let mut best = own - network.cost_per_tick * f64::from(end);
    for node in network.visits() {
        if !visits.contains(&node) {
            visits.push(node);
            best = best.max(highest_score(network, visits));
            visits.pop();
        }
    }
    best
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn what_gathers_more_is_not_taken_where_its_flight_costs_more(seed in 0..10_000u64, dear in 1..20u32) {
        let mut problem = small(seed, 6);
        let values: f64 = problem.targets.iter().map(|target| target.value).sum();
        let hours = (problem.end_s.unwrap() - problem.start_s) / 3600.0;
        let wage_per_hour = 0.2 * f64::from(dear) * values / hours;
        problem.crew.push(CrewMember { role: "pilot".into(), wage_per_hour, fixed_hours: 0.0, flight_share: 1.0 });
        let network = network(&problem);
        prop_assert!(network.cost_per_tick > 0.0);
        let best = highest_score(&network, &mut Vec::new());
        prop_assume!(best > 0.0);
        let plan = solved(&problem, 20_000, seed);
        prop_assert!((plan.score - best).abs() < 1e-6 * values, "{} of {best}", plan.score);
        // 9,000 units allow one annealing run from the flown plan and one proof; the proof may find a better route.
        let (flown, mut budget) = (Plan::SingleVisit(plan.clone()), WorkBudget::new(9_000));
        let mut environment = Environment { seed, budget: &mut budget, report: &mut |_| {}, previous: Some(&flown) };
        let again = super::super::SingleVisit.solve(&Problem::SingleVisit(problem), &mut environment).unwrap();
        let Plan::SingleVisit(again) = again else { panic!("the plan is of another kind") };
        prop_assert!(again.score > plan.score - 1e-6 * values, "{} after {}", again.score, plan.score);
    }
}

/// Returns the work units that a solution takes if every hour of flight costs `wage_per_hour`.
fn units_used(problem: &SingleVisitProblem, wage_per_hour: f64) -> u64 {
    let mut problem = problem.clone();
    problem.crew.push(CrewMember { role: "pilot".into(), wage_per_hour, fixed_hours: 0.0, flight_share: 1.0 });
    let mut budget = WorkBudget::new(40_000);
    let mut environment = Environment { seed: 1, budget: &mut budget, report: &mut |_| {}, previous: None };
    super::super::SingleVisit.solve(&Problem::SingleVisit(problem), &mut environment).unwrap();
    budget.used
}

#[test]
fn a_proof_of_benefits_ends_the_search_where_flight_costs_nothing() {
    for seed in 0..6 {
        let problem = small(seed, 10);
        assert!(units_used(&problem, 0.0) < 15_000, "seed {seed}");
        assert!(units_used(&problem, 1.0) >= 20_000, "seed {seed}: a bound on benefits proves nothing about costs");
    }
}

/// Returns the end, in ticks, of the shortest route through all nodes.
fn shortest(network: &Network, visits: &mut Vec<u32>) -> i32 {
    if visits.len() == network.visits().len() {
        return naive_end(network, visits).unwrap_or(i32::MAX);
    }
    let mut least = i32::MAX;
    for node in network.visits() {
        if !visits.contains(&node) {
            visits.push(node);
            least = least.min(shortest(network, visits));
            visits.pop();
        }
    }
    least
}

#[test]
fn of_routes_that_gather_the_same_the_shortest_is_flown() {
    for number in 1..=5 {
        let problem = formats::read("op", &generate::oplib(8, 3.0, number)).unwrap().problem;
        let network = network(&problem);
        let plan = solved(&problem, 20_000, 1);
        assert_eq!(plan.visits.len(), problem.targets.len(), "{}", plan.summary);
        let shortest_s = f64::from(shortest(&network, &mut Vec::new())) * network.tick_s;
        let flown_s = plan.end_s - problem.start_s;
        assert!((flown_s - shortest_s).abs() < 1e-3 * shortest_s, "{number}: {flown_s} s, not {shortest_s}");
    }
}

/// Walks that return to a target have more profit than every route, until the ng-sets of the targets between contain it. The budget
/// suffices for the fine passes.
#[test]
fn few_targets_with_wide_windows_are_proven() {
    for seed in [2, 3, 6, 9, 14, 15, 22, 33] {
        let plan = solved(&small(seed, 14), 1_000_000, seed);
        assert_eq!(plan.benefits_bound, Some(plan.benefits), "seed {seed}: {}", plan.summary);
    }
}

#[test]
fn equal_seed_and_budget_give_an_equal_plan_and_more_budget_no_worse_one() {
    let problem = small(5, 40);
    let short = solved(&problem, 2_000, 9);
    assert_eq!(short, solved(&problem, 2_000, 9));
    assert!(solved(&problem, 20_000, 9).benefits >= short.benefits);
}

#[test]
fn the_checker_refuses_a_leg_that_is_too_fast_and_a_return_too_late() {
    let problem = small(4, 8);
    let asked = Problem::SingleVisit(problem.clone());
    let plan = solved(&problem, 1_000, 1);
    let told = |change: &dyn Fn(&mut SingleVisitPlan)| {
        let mut plan = plan.clone();
        change(&mut plan);
        apex_planning::checker::violations(&asked, &Plan::SingleVisit(plan)).join("; ")
    };
    assert!(told(&|plan| plan.visits[1].depart_s += 1.0).contains("s for the way to"));
    assert!(told(&|plan| plan.visits[1].depart_s -= 1.0).contains("before the previous visit has ended"));
    assert!(told(&|plan| plan.end_s -= 1.0).contains("returns after"));
    assert!(told(&|plan| plan.visits[0].begin_s += 1e4).contains("outside its time windows"));
}

#[test]
fn a_plan_is_repaired_after_a_change_and_reported_before_it_is_improved() {
    let text = generate::oplib(120, 0.4, 3);
    let problem = formats::read("op", &text).unwrap().problem;
    let before = solved(&problem, 30_000, 1);
    let mut changed = problem.clone();
    // The fourth target of the plan loses its value, and the flight must end sooner.
    let gone = changed.targets.iter().position(|target| target.name == before.visits[3].target).unwrap();
    changed.targets[gone].value = 0.0;
    changed.end_s = Some(0.9 * changed.end_s.unwrap());
    let asked = Problem::SingleVisit(changed);
    let (mut told, flown) = (Vec::new(), Plan::SingleVisit(before.clone()));
    let mut budget = WorkBudget::new(20_000);
    let mut report = |plan: &Plan| told.push(plan.clone());
    let mut environment = Environment { seed: 1, budget: &mut budget, report: &mut report, previous: Some(&flown) };
    let after = super::super::SingleVisit.solve(&asked, &mut environment).unwrap();
    for plan in [&told[0], &after] {
        assert_eq!(apex_planning::checker::violations(&asked, plan), Vec::<String>::new());
    }
    let score = |plan: &Plan| match plan {
        Plan::SingleVisit(plan) => plan.score,
        Plan::Surveillance(_) => 0.0,
    };
    assert!(score(&after) >= score(&told[0]) && score(&told[0]) > 0.75 * before.score, "{}", score(&told[0]));
}

#[test]
fn a_bound_proves_the_best_plan_where_windows_are_narrow() {
    let problem =
        formats::read("c", &generate::windows(Family::Solomon(Places::Clustered, Day::Short), 1)).unwrap().problem;
    let plan = solved(&problem, 400_000, 1);
    assert_eq!(plan.benefits_bound, Some(plan.benefits), "{}", plan.summary);
}

/// Returns the maximum benefits over all orders of all subsets of the targets, by complete enumeration.
fn most_benefits(schedule: &mut Schedule<'_>, count: usize) -> f64 {
    let (mut best, mut open) = (0.0_f64, vec![Vec::<Choice>::new()]);
    while let Some(order) = open.pop() {
        for target in (0..count).filter(|target| order.iter().all(|choice| choice.target != *target)) {
            for manoeuvre in 0..schedule.problem.targets[target].manoeuvres.len() {
                let mut longer = order.clone();
                longer.push(Choice { target, manoeuvre, not_before_s: f64::NEG_INFINITY });
                if let Ok(judged) = schedule.judge(&longer, &mut WorkBudget::new(u64::MAX)) {
                    best = best.max(judged.visits.iter().map(|visit| visit.worth).sum());
                    open.push(longer);
                }
            }
        }
    }
    best
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]
    #[test]
    fn no_plan_in_changing_wind_and_airspace_gathers_more_than_the_bound(seed in 0..10_000u64) {
        let problem = examples::random(4, seed);
        let mut schedule = Schedule::new(&problem).unwrap();
        let usable = explain::Troubles::new(&mut schedule).possible();
        let most = most_benefits(&mut schedule, 4);
        let bound = at_best_departures(&mut schedule, &usable, 0.0, &mut Meter::new(&mut WorkBudget::new(u64::MAX)));
        prop_assert!(bound.is_some_and(|bound| bound >= most - 1e-6), "{bound:?} {most}");
    }

    #[test]
    fn a_flight_in_steady_wind_among_steady_zones_is_proven_to_be_the_best(seed in 0..10_000u64) {
        let mut problem = examples::random(4, seed);
        problem.precedence.clear();
        problem.wind.layers.truncate(1);
        problem.zones.truncate(1);
        problem.targets.iter_mut().for_each(|target| target.timing.clear());
        let mut schedule = Schedule::new(&problem).unwrap();
        prop_assert!(network::serves(&schedule));
        let most = most_benefits(&mut schedule, 4);
        prop_assume!(most > 0.0);
        let mut budget = WorkBudget::new(400_000);
        let mut environment = Environment { seed, budget: &mut budget, report: &mut |_| {}, previous: None };
        let given = apex_model::problem::Problem::SingleVisit(problem.clone());
        let plan = crate::planners::single_visit::SingleVisit.solve(&given, &mut environment).unwrap();
        prop_assert_eq!(apex_planning::checker::violations(&given, &plan), Vec::<String>::new());
        let apex_model::problem::Plan::SingleVisit(plan) = plan else { panic!("the plan is of another kind") };
        prop_assert!((plan.benefits - most).abs() < 1e-6, "{} {most}", plan.benefits);
        let bound = plan.benefits_bound.unwrap();
        prop_assert!(bound >= most - 1e-6 && bound <= most + 1e-6 * most, "{bound} {most}");
    }
}
