//! The synthesis leaves out only candidates that predictions of all candidates would leave out, too.

use super::*;
use apex_model::quantity::Dimension;
use apex_model::value::Value;
use apex_planning::random::Generator;
use std::path::Path;

/// Goals of the mission's area and of places, with several resolutions and endurances.
#[test]
fn the_front_is_that_of_all_predictions() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/stand-off");
    let mission = Mission::load(&folder).unwrap();
    let place = |north_deg: f64| Value::list([37.41 + north_deg, -121.12, 9.0].map(Value::Real));
    let (mut left_out, mut compared) = (0, 0);
    for target in [Value::symbol("plume"), place(0.0), place(0.004)] {
        for (resolution_m, endurance_s) in [(0.05, 3_000.0), (0.1, 3_000.0), (0.4, 3_000.0), (0.1, 300.0)] {
            let resolution = Value::measured(resolution_m, Dimension::LENGTH);
            let form =
                Value::list([Value::symbol("acquire"), target.clone(), Value::symbol(":resolution"), resolution]);
            let goal = AcquisitionGoal::read(&mission, &form).unwrap();
            let start = Start { here: mission.start, at_s: 60.0, endurance_s };
            let candidates = all_candidates(&mission, &goal, start, &mut Vec::new()).unwrap();
            let requirements = PathRequirements::of(&mission);
            let every: Vec<Predicted> = by_time(&mission, &goal, candidates.clone(), start)
                .into_iter()
                .filter_map(|one| judged(&mission, (&goal, &requirements), one.ok()?, start).ok())
                .collect();
            let some = predicted(&mission, &goal, candidates, start, &mut Vec::new());
            left_out += every.len() - some.len();
            let sorted = |meeting: Vec<Predicted>| {
                let mut all: Vec<[f64; 5]> = front(meeting).iter().map(figures).collect();
                all.sort_by(|a, b| {
                    a.iter()
                        .zip(b)
                        .map(|(a, b)| a.total_cmp(b))
                        .find(|order| order.is_ne())
                        .unwrap_or(std::cmp::Ordering::Equal)
                });
                all
            };
            compared += usize::from(!every.is_empty());
            assert_eq!(sorted(some), sorted(every), "{form}");
        }
    }
    assert!(left_out >= 50 && compared >= 6, "{left_out} left out, {compared} goals met");
}

/// A manoeuvre that is as good as another one and takes longer is in the answer if it is farther from the ground, and only then.
#[test]
fn risk_is_an_axis_of_the_front() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/stand-off");
    let mission = Mission::load(&folder).unwrap();
    let resolution = Value::measured(0.1, Dimension::LENGTH);
    let form =
        Value::list([Value::symbol("acquire"), Value::symbol("plume"), Value::symbol(":resolution"), resolution]);
    let goal = AcquisitionGoal::read(&mission, &form).unwrap();
    let start = Start { here: mission.start, at_s: 60.0, endurance_s: 3_000.0 };
    let synthesis = synthesise(&mission, &goal, start).unwrap();
    let chosen = &synthesis.front[0];
    let at = |share: f64, later_s: f64| Predicted {
        risk: Risk { share, ..chosen.risk },
        travel_s: chosen.travel_s + later_s,
        ..chosen.clone()
    };
    let ends_s = |meeting: Vec<Predicted>| front(meeting).iter().map(|one| one.travel_s).collect::<Vec<f64>>();
    let (soon_s, late_s) = (chosen.travel_s, chosen.travel_s + 10.0);
    assert_eq!(ends_s(vec![at(0.8, 0.0), at(0.0, 10.0)]), [soon_s, late_s]);
    assert_eq!(ends_s(vec![at(0.8, 0.0), at(0.8, 10.0)]), [soon_s]);
    assert_eq!(ends_s(vec![at(0.0, 0.0), at(0.8, 10.0)]), [soon_s]);
    let texts: Vec<String> = synthesis.front.iter().map(told).collect();
    assert!(texts.iter().all(|text| text.contains(", risk 0.")), "{texts:#?}");
    // The required clearance over ground is a part of the height that shrinks with it; at twice the clearance there is no risk.
    let risks = [5.0, 22.0, 25.0, 37.0, 45.0, 1_000.0].map(|m| RiskLimits::of(&mission, &goal).over_ground(m).share);
    assert!(risks.is_sorted_by(|a, b| a >= b) && risks[0] == 1.0 && risks[5] == 0.0, "{risks:?}");
}

/// Random candidates in the order of their ends, with many that are as good as the best one: the answer of those up to the end of a full
/// answer is that of all.
#[test]
fn candidates_after_a_full_answer_do_not_change_it() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/stand-off");
    let mission = Mission::load(&folder).unwrap();
    let resolution = Value::measured(0.1, Dimension::LENGTH);
    let form =
        Value::list([Value::symbol("acquire"), Value::symbol("plume"), Value::symbol(":resolution"), resolution]);
    let goal = AcquisitionGoal::read(&mission, &form).unwrap();
    let start = Start { here: mission.start, at_s: 60.0, endurance_s: 3_000.0 };
    let mut model = synthesise(&mission, &goal, start).unwrap().front[0].clone();
    model.forecast.flown.poses.clear();
    let mut random = Generator::new(11);
    let (mut ended_early, mut changed_by_the_last) = (0, 0);
    for round in 0..400 {
        let mut all: Vec<Predicted> = (0..8 + random.below(40))
            .map(|_| {
                let mut one = model.clone();
                one.forecast.flown.energy = [1.0, 2.0, 3.0, 4.0][random.below(4)];
                one.forecast.flown.turns = random.below(4);
                one.risk.share = [0.0, 0.6, 0.8, 1.0][random.below(4)];
                one.travel_s = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0][random.below(8)];
                // In every second round the best candidates come last, so that others are as good as the best one for a time only.
                let is_late = round % 2 == 0 || one.travel_s >= 60.0;
                let points: &[f64] =
                    if is_late { &[100.0, 99.97, 99.5, 99.0, 98.95, 95.0] } else { &[99.5, 99.3, 99.2, 99.0, 98.7] };
                one.forecast.points = points[random.below(points.len())];
                one
            })
            .collect();
        all.sort_by(|a, b| a.travel_s.total_cmp(&b.travel_s));
        let end_s = |one: &Predicted| one.travel_s + one.forecast.time_s;
        let mut some: Vec<Predicted> = Vec::new();
        for one in &all {
            if full_at_s(&some).is_some_and(|full_s| end_s(one) > full_s) {
                ended_early += 1;
                break;
            }
            some.push(one.clone());
        }
        let answer = |meeting: &[Predicted]| front(meeting.to_vec()).iter().map(figures).collect::<Vec<_>>();
        assert_eq!(answer(&some), answer(&all), "round {round}");
        changed_by_the_last += usize::from(answer(&some[..some.len() - 1]) != answer(&some));
    }
    assert!(
        ended_early >= 100 && changed_by_the_last >= 20,
        "{ended_early} ended early, {changed_by_the_last} changed"
    );
}
