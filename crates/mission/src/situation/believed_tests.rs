//! Assumptions of a mission after updates, in the numbers that planners receive.

use super::{MissionEvent, MissionUpdate, MissionUpdates, Situation};
use crate::problem::pose;
use crate::{Fire, Mission, Site, TargetKind};
use apex_metrics::eci::cost_at;
use apex_model::problem::{CostFunction, EventRate, Problem, SurveillanceProblem, WindField};
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::target_state::TargetState;

fn mission(name: &str) -> Mission {
    Mission::load(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions").join(name)).unwrap()
}

fn updates(said: &[(&str, &str, Option<f64>)]) -> MissionUpdates {
    let mut updates = MissionUpdates::default();
    for (head, subject, number) in said {
        let items: Vec<Value> = [Value::symbol(subject)].into_iter().chain(number.map(Value::Real)).collect();
        updates.apply(MissionUpdate::read(head, &items).expect("it is an update"));
    }
    updates
}

fn site<'m>(mission: &'m Mission, id: &str) -> &'m Site {
    match &mission.targets.iter().find(|target| target.id == id).unwrap().kind {
        TargetKind::Site(site) => site,
        _ => panic!("{id} is not a site"),
    }
}

fn site_of<'m>(mission: &'m mut Mission, id: &str) -> &'m mut Site {
    match &mut mission.targets.iter_mut().find(|target| target.id == id).unwrap().kind {
        TargetKind::Site(site) => site,
        _ => panic!("{id} is not a site"),
    }
}

fn fire<'m>(mission: &'m Mission, id: &str) -> Option<&'m Fire> {
    mission.targets.iter().find(|target| target.id == id).map(|target| match &target.kind {
        TargetKind::Fire(fire) => fire,
        _ => panic!("{id} is not a fire"),
    })
}

fn posed(mission: &Mission, updates: MissionUpdates) -> SurveillanceProblem {
    let situation = Situation { updates, ..Situation::default() };
    match pose(&situation.updates.believed(mission), &situation, None, Time::from_seconds(60.0)).unwrap() {
        Problem::Surveillance(problem) => problem,
        Problem::SingleVisit(_) => panic!("of another kind"),
    }
}

#[test]
fn a_visit_that_continues_after_a_plan_is_observed_again() {
    let mission = mission("structure-watch");
    let mut situation = Situation::default();
    let observing = MissionEvent::Observing("barn".into());
    let form = Value::list([Value::symbol("observing"), Value::symbol("barn")]);
    assert_eq!(MissionEvent::read(&form), Some(observing));
    let at = Time::from_seconds;
    situation.take_message(&mission, at(10.0), &form);
    situation.take_message(&mission, at(11.0), &form);
    situation.change("barn".into(), at(20.0), TargetState::Planned, String::new());
    situation.take_message(&mission, at(30.0), &form);
    let states: Vec<_> = situation.target_changes.iter().map(|change| (change.at.seconds(), change.state)).collect();
    let wanted = [(10.0, TargetState::Observing), (20.0, TargetState::Planned), (30.0, TargetState::Observing)];
    assert_eq!(states, wanted);
    assert_eq!(situation.visits.len(), 1, "it is one visit");
}

#[test]
fn a_likelihood_is_one_of_an_hour_and_of_one_target() {
    let mission = mission("structure-watch");
    let before = posed(&mission, MissionUpdates::default());
    let after =
        posed(&mission, updates(&[("new-likelihood", "barn", Some(9.0)), ("new-likelihood", "barn", Some(50.0))]));
    assert_eq!(before.targets.len(), after.targets.len());
    for (before, after) in before.targets.iter().zip(&after.targets) {
        let rate = if before.name == "barn" { EventRate::constant(50.0 / 3600.0) } else { before.rate.clone() };
        assert_eq!((&after.rate, &after.cost), (&rate, &before.cost), "{}", before.name);
    }
}

#[test]
fn a_value_is_what_an_event_costs_that_is_never_found() {
    let importance = 40.0;
    let families = [
        CostFunction::Linear { cost_per_s: importance / 900.0 },
        CostFunction::Saturating { maximum: importance, rate_per_s: 1e-3 },
        CostFunction::Step { deadline_s: 300.0, maximum: importance },
        CostFunction::Logistic { maximum: importance, rate_per_s: 1e-2, midpoint_s: 600.0 },
        CostFunction::Table { points: vec![(0.0, 1.0), (600.0, 20.0), (3600.0, importance)] },
    ];
    let delayed = |cost: &CostFunction| CostFunction::Delayed { response_s: 120.0, cost: Box::new(cost.clone()) };
    for cost in families.iter().flat_map(|cost| [cost.clone(), delayed(cost)]) {
        let mut mission = mission("structure-watch");
        let barn = site_of(&mut mission, "barn");
        // A table states the final cost of an event itself.
        let is_table = format!("{cost:?}").contains("Table");
        (barn.cost, barn.importance) = (cost.clone(), if is_table { 7.0 } else { importance });
        let believed =
            updates(&[("new-value", "barn", Some(3.0)), ("new-value", "barn", Some(10.0))]).believed(&mission);
        let barn = site(&believed, "barn");
        assert_eq!(barn.importance, 10.0, "{cost:?}");
        for age_s in [0.0, 100.0, 500.0, 900.0, 5000.0] {
            let (now, wanted) = (cost_at(&barn.cost, age_s), 0.25 * cost_at(&cost, age_s));
            assert!((now - wanted).abs() < 1e-9, "{now} {wanted} {cost:?} at {age_s} s");
        }
        assert_eq!(site(&believed, "winery").cost, site(&mission, "winery").cost);
        let nothing = updates(&[("new-value", "barn", Some(0.0))]).believed(&mission);
        assert_eq!(cost_at(&site(&nothing, "barn").cost, 5000.0), 0.0, "{cost:?}");
    }
}

#[test]
fn fires_are_worth_what_was_said_and_appear_when_they_are_announced() {
    let mission = mission("western-states");
    let before = MissionUpdates::default().believed(&mission);
    assert!(fire(&before, "castle-rock").is_none() && fire(&before, "lick").is_some());
    let said = [("new-value", "lick", Some(1.5)), ("new-target", "castle-rock", None), ("target-gone", "zaca", None)];
    let after = updates(&said).believed(&mission);
    assert!(fire(&after, "castle-rock").is_some() && fire(&after, "domke-lake").is_none());
    assert_eq!(fire(&after, "lick").unwrap().value(), 1.5);
    assert_eq!(after.targets.len(), before.targets.len(), "one came, one went");
    assert!(fire(&before, "zaca").is_some() && fire(&after, "zaca").is_none());
    assert_eq!(
        updates(&said).valued(&mission).targets.len(),
        mission.targets.len(),
        "nothing is hidden from the report"
    );
}

#[test]
fn the_forecast_that_was_named_is_used() {
    let mut mission = mission("structure-watch");
    assert_ne!(mission.forecast, WindField::default());
    mission.forecasts.push(("calm.csv".into(), WindField::default()));
    let said = |name: &str| {
        let mut updates = MissionUpdates::default();
        updates.apply(MissionUpdate::NewForecast(name.to_string()));
        updates
    };
    assert_eq!(said("calm.csv").believed(&mission).forecast, WindField::default());
    assert_eq!(said("storm.csv").believed(&mission).forecast, mission.forecast);
    let times = |updates: MissionUpdates| posed(&mission, updates).travel;
    assert_ne!(times(said("calm.csv")), times(said("storm.csv")), "ways take other times");
}

#[test]
fn input_that_names_nothing_is_reported() {
    let mission = mission("structure-watch");
    let heads = [("new-target", None), ("target-gone", None), ("new-value", Some(1.0)), ("new-likelihood", Some(1.0))];
    for (head, number) in heads {
        assert_eq!(updates(&[(head, "castle", number)]).unknown(&mission).len(), 1, "{head}");
        assert_eq!(updates(&[(head, "barn", number)]).unknown(&mission).len(), 0, "{head}");
    }
    assert_eq!(updates(&[("new-forecast", "storm.csv", None)]).unknown(&mission).len(), 1);
}

#[test]
fn visits_of_operators_are_repeated_if_the_message_requests_it() {
    for (words, repeat) in [(["repeat", "barn", "school"].as_slice(), true), (&["barn", "school"], false)] {
        let mut updates = MissionUpdates::default();
        let words = Value::list(words.iter().map(|word| Value::symbol(word)));
        updates.apply(MissionUpdate::read("planned-by-people", &[words]).unwrap());
        let visits = updates.operator_plan().unwrap();
        assert_eq!((visits.visits.join(" ").as_str(), visits.repeat), ("barn school", repeat));
    }
}
