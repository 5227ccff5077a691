//! The synthesis leaves out only candidates that predictions of all candidates would leave out, too.

use super::*;
use apex_model::quantity::Dimension;
use apex_model::value::Value;
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
            let every: Vec<Predicted> =
                candidates.iter().filter_map(|one| judged(&mission, &goal, one.clone(), start).ok()).collect();
            let some = predicted(&mission, &goal, candidates, start, &mut Vec::new());
            left_out += every.len() - some.len();
            let sorted = |meeting: Vec<Predicted>| {
                let mut all: Vec<[f64; 4]> = front(meeting).iter().map(figures).collect();
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
