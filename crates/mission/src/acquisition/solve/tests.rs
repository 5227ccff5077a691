//! The synthesis leaves out only candidates that predictions of all candidates would leave out, too.

use super::*;
use apex_model::quantity::Dimension;
use apex_model::value::Value;
use apex_planning::random::Generator;
use std::path::Path;

fn stand_off() -> Mission {
    Mission::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/stand-off")).unwrap()
}

fn goal_of(mission: &Mission, target: Value, resolution_m: f64) -> AcquisitionGoal {
    let resolution = Value::measured(resolution_m, Dimension::LENGTH);
    let form = Value::list([Value::symbol("acquire"), target, Value::symbol(":resolution"), resolution]);
    AcquisitionGoal::read(mission, &form).unwrap()
}

fn start_of(mission: &Mission, endurance_s: f64) -> Start {
    Start { here: mission.start, at_s: 60.0, endurance_s }
}

/// Returns the answer by the definition of the front: all candidates that no other one beats, the first of equal ones.
fn answer_of_all(meeting: &[Predicted]) -> Vec<Predicted> {
    let all: Vec<[f64; 5]> = meeting.iter().map(figures).collect();
    let is_on_front = |number: usize| {
        let twin = |other: usize| beats(&all[other], &all[number]) || other < number && all[other] == all[number];
        !(0..all.len()).any(twin)
    };
    answer((0..all.len()).filter(|number| is_on_front(*number)).map(|number| meeting[number].clone()).collect())
}

/// Returns the figures of an answer; those of equal times in a fixed order.
fn compared(answer: Vec<Predicted>) -> Vec<[f64; 5]> {
    let mut all: Vec<[f64; 5]> = answer.iter().map(figures).collect();
    all.sort_by(|a, b| {
        let orders = a.iter().zip(b).map(|(a, b)| a.total_cmp(b));
        orders.into_iter().find(|order| order.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
    });
    all
}

/// Goals of the mission's area and of places, with several resolutions and endurances.
#[test]
fn the_front_is_that_of_all_predictions() {
    let mission = stand_off();
    let place = |north_deg: f64| Value::list([37.41 + north_deg, -121.12, 9.0].map(Value::Real));
    let (mut left_out, mut met) = (0, 0);
    for target in [Value::symbol("plume"), place(0.0), place(0.004)] {
        for (resolution_m, endurance_s) in [(0.05, 3_000.0), (0.1, 3_000.0), (0.4, 3_000.0), (0.1, 300.0)] {
            let (goal, start) = (goal_of(&mission, target.clone(), resolution_m), start_of(&mission, endurance_s));
            let candidates = all_candidates(&mission, &goal, start, &mut Vec::new()).unwrap();
            let requirements = PathRequirements::of(&mission);
            let timed: Vec<TimedCandidate> =
                by_time(&mission, &goal, candidates.clone(), start).into_iter().filter_map(Result::ok).collect();
            let count = timed.len();
            let judge = |one| judged(&mission, (&goal, &requirements), one, start).ok();
            let every: Vec<Predicted> = timed.into_iter().filter_map(judge).collect();
            let (front, predictions) = predicted(&mission, &goal, candidates, start, &mut Vec::new());
            left_out += count - predictions;
            met += usize::from(!every.is_empty());
            assert_eq!(
                compared(answer(front)),
                compared(answer_of_all(&every)),
                "{target} {resolution_m} {endurance_s}"
            );
        }
    }
    assert!(left_out >= 50 && met >= 6, "{left_out} left out, {met} goals met");
}

/// A manoeuvre that is as good as another one and takes longer is in the answer if it is farther from the ground, and only then.
#[test]
fn risk_is_an_axis_of_the_front() {
    let mission = stand_off();
    let (goal, start) = (goal_of(&mission, Value::symbol("plume"), 0.1), start_of(&mission, 3_000.0));
    let synthesis = synthesise(&mission, &goal, start).unwrap();
    let chosen = &synthesis.front[0];
    let at = |share: f64, later_s: f64| Predicted {
        risk: Risk { share, ..chosen.risk },
        travel_s: chosen.travel_s + later_s,
        ..chosen.clone()
    };
    let ends_s = |meeting: Vec<Predicted>| {
        let mut front = Vec::new();
        meeting.into_iter().for_each(|one| add(&mut front, one));
        answer(front).iter().map(|one| one.travel_s).collect::<Vec<f64>>()
    };
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
    let mission = stand_off();
    let (goal, start) = (goal_of(&mission, Value::symbol("plume"), 0.1), start_of(&mission, 3_000.0));
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
        let (mut front, mut before): (Vec<Predicted>, Vec<Predicted>) = (Vec::new(), Vec::new());
        for one in &all {
            if full_at_s(&front).is_some_and(|full_s| end_s(one) > full_s) {
                ended_early += 1;
                break;
            }
            before.clone_from(&front);
            add(&mut front, one.clone());
        }
        let whole = compared(answer_of_all(&all));
        changed_by_the_last += usize::from(compared(answer(before)) != whole);
        assert_eq!(compared(answer(front)), whole, "round {round}");
    }
    assert!(
        ended_early >= 100 && changed_by_the_last >= 20,
        "{ended_early} ended early, {changed_by_the_last} changed"
    );
}

/// Returns a goal at the plume with pixels, and with look angles in degrees unless both are 0.
fn at_angles(mission: &Mission, resolution_m: f64, (low_deg, high_deg): (f64, f64)) -> AcquisitionGoal {
    let word = Value::symbol;
    let mut form = vec![word("acquire"), word("plume"), word(":resolution")];
    form.push(Value::measured(resolution_m, Dimension::LENGTH));
    if high_deg > 0.0 {
        form.extend([word(":look-angle"), Value::list([low_deg, high_deg].map(Value::Real))]);
    }
    AcquisitionGoal::read(mission, &Value::list(form)).unwrap()
}

/// Pixels at a look angle are larger than those straight below, so the size that is said to work is tried before it is stated.
#[test]
fn pixels_that_are_said_to_work_do() {
    let mission = stand_off();
    let start = start_of(&mission, 3_000.0);
    let mut stated = 0;
    for angles_deg in [(0.0, 0.0), (0.0, 20.0), (30.0, 45.0), (40.0, 45.0), (50.0, 60.0)] {
        for resolution_m in [0.002, 0.004, 0.008] {
            let Err(why) = synthesise(&mission, &at_angles(&mission, resolution_m, angles_deg), start) else {
                continue;
            };
            let Some((before, _)) = why.split_once(" m works") else { continue };
            let pixel_m: f64 = before.rsplit(' ').next().unwrap().parse().unwrap();
            let goal = at_angles(&mission, pixel_m, angles_deg);
            assert!(synthesise(&mission, &goal, start).is_ok(), "{angles_deg:?} {resolution_m}: {why}");
            stated += 1;
        }
    }
    assert!(stated >= 10, "{stated}");
}

#[test]
fn a_manoeuvre_for_which_the_mission_has_no_time_left_is_a_miss() {
    let mission = stand_off();
    let goal = at_angles(&mission, 0.1, (0.0, 0.0));
    let duration_s = mission.settings.duration.seconds();
    let at = |at_s: f64| synthesise(&mission, &goal, Start { at_s, ..start_of(&mission, 30_000.0) });
    assert!(at(60.0).is_ok());
    let why = at(duration_s - 30.0).unwrap_err();
    assert!(why.contains(&format!("and the mission ends at {duration_s:.0} s")), "{why}");
}
