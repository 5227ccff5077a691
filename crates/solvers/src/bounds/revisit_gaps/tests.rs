//! Flown plans satisfy every row of the program: each statement of the bound about plans is true of each of them.

use super::*;
use apex_model::problem::CostFunction;
use apex_planning::examples::surveillance as examples;
use apex_planning::surveillance::scenario::{Scenario, Stop};
use proptest::prelude::*;

/// Returns the intervals without an observation in the group, apart from legs within it.
fn absences_of(group: &[usize], flown: &[Stop], horizon_s: f64) -> Vec<(f64, f64)> {
    let inside = |stop: &Stop| group.contains(&stop.target);
    let mut found = Vec::new();
    let mut away_since = Some(0.0);
    for (index, stop) in flown.iter().enumerate() {
        if !inside(stop) {
            if index > 0 && inside(&flown[index - 1]) {
                away_since = Some(flown[index - 1].end_s);
            }
        } else if let Some(since) = away_since.take() {
            found.push((since, stop.end_s));
        }
    }
    found.extend(away_since.map(|since| (since, horizon_s)));
    found
}

/// Returns the gaps between observations of a target; the first one begins when it was observed before the flight.
fn gaps_of(target: usize, age_s: f64, flown: &[Stop], horizon_s: f64) -> Vec<(f64, f64)> {
    let ends = flown.iter().filter(|stop| stop.target == target).map(|stop| stop.end_s);
    let bounds: Vec<f64> = [-age_s].into_iter().chain(ends).chain([horizon_s]).collect();
    bounds.windows(2).map(|pair| (pair[0], pair[1])).collect()
}

/// Returns the columns that represent a flown tour.
fn columns(model: &Model<'_>, flown: &[Stop], count: usize) -> Vec<f64> {
    let (problem, horizon_s) = (model.problem, model.problem.horizon_s);
    let mut columns = vec![0.0; count];
    if let (Some(first), Some(last)) = (flown.first(), flown.last()) {
        let leg = model.first_legs.iter().find(|leg| leg.0 == first.target).unwrap();
        columns[leg.1] = 1.0;
        columns[model.ends[last.target]] = 1.0;
        columns[model.waits[last.target]] = 1.0 - last.end_s / horizon_s;
    }
    for pair in flown.windows(2) {
        let flies = |leg: &&(usize, usize, usize, f64)| (leg.0, leg.1) == (pair[0].target, pair[1].target);
        columns[model.legs.iter().find(flies).unwrap().2] += 1.0;
    }
    flown.iter().for_each(|stop| columns[model.visits[stop.target]] += 1.0);
    let chains = groups::chains(problem.targets.len(), |a, b| problem.travel.between(a, b), UNREACHABLE_S);
    let mut levels = model.levels.iter().skip(problem.targets.len());
    for (target, chain) in chains.iter().enumerate() {
        let of = &problem.targets[target];
        let mut level_of = vec![0; gaps_of(target, of.initial_age_s, flown, horizon_s).len()];
        for (above, group) in chain.iter().enumerate() {
            for (since, until) in absences_of(group, flown, horizon_s) {
                for (gap, level) in gaps_of(target, of.initial_age_s, flown, horizon_s).iter().zip(&mut level_of) {
                    if gap.0 <= since && until <= gap.1 {
                        *level = above + 1;
                    }
                }
            }
        }
        for number in 0..=chain.len() {
            let level = levels.next().unwrap();
            assert_eq!(level.target, target);
            for (gap, _) in gaps_of(target, of.initial_age_s, flown, horizon_s)
                .iter()
                .zip(&level_of)
                .filter(|(_, each)| **each == number)
            {
                let cost = gathered(of, gap.1 - gap.0) / model.cost_unit;
                columns[level.count.0] += 1.0;
                columns[level.length.unwrap()] += (gap.1 - gap.0) / horizon_s;
                columns[level.cost] += cost;
                columns[model.levels[target].cost] += cost;
            }
        }
    }
    columns
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn flown_words_keep_every_row(
        seed in 0..1000_u64, count in 1..9_usize, apart in 0.0..3.0f64, home: bool, age in 0.0..300.0f64,
        word in prop::collection::vec(0..9_usize, 0..60), stays in 1..6_usize, horizon in 300.0..6000.0f64,
    ) {
        let mut problem = examples::sized(count, seed, 2_000.0);
        problem.horizon_s = horizon;
        problem.return_to_base = home;
        problem.targets[0].initial_age_s = age;
        problem.targets[count - 1].cost = CostFunction::Step { deadline_s: 100.0, maximum: 2.0 };
        // Two groups: the ways between even and odd targets are longer.
        for from in 0..count {
            for to in (0..count).filter(|to| (from + to) % 2 == 1) {
                problem.travel.between_s[from][to] += apart * 300.0;
            }
        }
        prop_assume!(Scenario::new(&problem).is_ok());
        let scenario = Scenario::new(&problem).unwrap();
        // A vehicle makes several visits within a group, as good plans do.
        let word = word.iter().enumerate().map(|(index, place)| (place - (place + index / stays) % 2.min(*place + 1)) % count);
        let mut flown = Vec::new();
        scenario.fly(word, |stop| flown.push(stop));
        let model = Model::new(&problem, usize::MAX).unwrap();
        let columns = columns(&model, &flown, model.program.width());
        let worst = model.program.worst_break(&columns);
        prop_assert!(worst <= 1e-9, "a row is broken by {worst}\n{flown:?}");
    }
}
