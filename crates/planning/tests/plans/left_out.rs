//! Reasons of targets that a surveillance plan leaves out, against all places at which one more visit could be inserted.

use apex_metrics::eci;
use apex_model::problem::{Obstacle, SurveillanceProblem, SurveillanceVisit};
use apex_planning::examples::surveillance as examples;
use apex_planning::surveillance::scenario::Scenario;

/// Flies a word in order until a visit would end after the horizon; a naive second witness of the planners' arithmetic.
fn flown(problem: &SurveillanceProblem, word: &[usize]) -> Vec<SurveillanceVisit> {
    let (mut visits, mut time_s, mut place) = (Vec::new(), 0.0, None);
    for target in word {
        let travel_s = match place {
            None => problem.travel.from_start_s[*target],
            Some(from) => {
                let row: &Vec<f64> = &problem.travel.between_s[from];
                row[*target]
            }
        };
        let arrive_s = time_s + travel_s;
        let end_s = arrive_s + problem.targets[*target].dwell_s;
        if end_s > problem.horizon_s {
            break;
        }
        visits.push(SurveillanceVisit { target: problem.targets[*target].name.clone(), arrive_s, end_s });
        (time_s, place) = (end_s, Some(*target));
    }
    visits
}

fn cheapest(problem: &SurveillanceProblem, word: &[usize], target: usize) -> f64 {
    let name = &problem.targets[target].name;
    let with = (0..=word.len()).filter_map(|at| {
        let mut longer = word.to_vec();
        longer.insert(at, target);
        let visits = flown(problem, &longer);
        let is_visited = visits.iter().any(|visit| visit.target == *name);
        is_visited.then(|| eci::expected_cost(problem, &visits).total)
    });
    with.fold(f64::INFINITY, f64::min)
}

#[test]
fn the_stated_cost_is_that_of_the_cheapest_visit_on_the_way() {
    let mut compared = 0;
    for seed in 0..60 {
        let mut problem = examples::random(6, seed);
        problem.horizon_s = 1_200.0;
        // Targets 4 and 5 matter little, so that a visit of them raises the cost; the others are visited in changing order.
        for target in &mut problem.targets[4..] {
            target.rate.steps[0].1 = 0.02;
        }
        let word = [0, 1, 0, 2, 3, 1, 0, 2, 0, 3, 1, 2];
        let scenario = Scenario::new(&problem).unwrap();
        let plan = scenario.plan("test", word);
        let kept: Vec<usize> = word[..plan.visits.len()].to_vec();
        for left_out in plan.left_out {
            let Some(Obstacle::ExpectedCost { without, with }) = left_out.obstacle else { continue };
            let index = problem.targets.iter().position(|target| target.name == left_out.target).unwrap();
            let least = cheapest(&problem, &kept, index);
            assert!((without - plan.expected_cost).abs() < 1e-9, "{without}");
            let figures = format!("from {without:.4} to {with:.4}");
            assert!(left_out.reason.contains(&figures), "{} states other figures than {figures}", left_out.reason);
            assert!(
                (with - least).abs() < 1e-9,
                "seed {seed}: {} states {with}, the cheapest costs {least}",
                left_out.target
            );
            compared += 1;
        }
    }
    assert!(compared > 20, "{compared}");
}
