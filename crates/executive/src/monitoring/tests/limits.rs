//! A condition reports once that it forgets data at its limits.

use super::*;
use apex_model::condition::AllenRelation;

const MOST: i64 = MONITOR_RESULTS_MAX as i64;

fn told(world: &mut World) -> Vec<String> {
    take_troubles(&mut world.monitor).into_iter().map(|trouble| trouble.message).collect()
}

fn results_limit() -> Vec<String> {
    vec![format!("the limit MONITOR_RESULTS_MAX = {MONITOR_RESULTS_MAX} of a condition was reached")]
}

/// Returns an episode of the values from 5 on that lasts at least this duration; with `any`, between any two samples.
fn warm(attribute: &str, least: i64, any: bool) -> Condition {
    let value = vec![compare(Relation::GreaterOrEqual, int(5))];
    let lasting = vec![compare(Relation::GreaterOrEqual, span(least))];
    let episode = EpisodeCondition { any, ..episode(uav(attribute), value, None, lasting) };
    condition(ConditionKind::Episode(Arc::new(episode)))
}

/// Passes samples of `a`, one per instant, and judges after each. Returns the errors reported up to `quiet`, and those after it.
fn over(world: &mut World, values: impl Fn(i64) -> i64, quiet: i64, end: i64) -> (Vec<String>, Vec<String>) {
    let mut before = Vec::new();
    for at in 0..end {
        if at == quiet {
            before = told(world);
        }
        world.sample("a", "uav", Value::Integer(values(at)), at);
        world.ask(at);
    }
    (before, told(world))
}

#[test]
fn that_the_first_sample_of_a_pair_is_forgotten_is_reported_once() {
    let mut world = World::new(&warm("a", 1_000_000, true));
    assert_eq!(over(&mut world, |_| 5, MOST, MOST + 9), (vec![], results_limit()));
}

#[test]
fn that_windows_of_an_absence_are_forgotten_is_reported_once() {
    // Every second sample matches, so that the part is absent for an instant between them. No monitor receives the event.
    let absent = condition(ConditionKind::Absent(Box::new(points("a", false)), span(1)));
    let seen = condition(event(vec![word("seen")]));
    let later = call(">", vec![call("start-of", vec![variable("gone")]), constant(Value::Time(Time(1_000_000)))]);
    let both = ConditionKind::And(vec![tagged("gone", absent.kind), seen], vec![later]);
    let mut world = World::new(&condition(both));
    let values = |at: i64| if at % 3 == 0 { 5 } else { 4 };
    assert_eq!(over(&mut world, values, 3 * MOST - 3, 3 * MOST + 30), (vec![], results_limit()));
}

/// Returns a condition that each sample of 5 or more satisfies, alone or as an alternative: results of alternatives are never final.
fn points(attribute: &str, alternative: bool) -> Condition {
    let value = vec![compare(Relation::GreaterOrEqual, int(5))];
    let point = condition(ConditionKind::Measurement(Arc::new(measurement(uav(attribute), value))));
    if alternative { condition(ConditionKind::Or(vec![point], vec![])) } else { point }
}

#[test]
fn that_related_results_are_forgotten_is_reported_once() {
    for final_ones in [true, false] {
        let parts = vec![points("a", false), points("b", !final_ones)];
        let (relation, tolerance, constraints) = (AllenRelation::Before, None, vec![]);
        let pairs = condition(ConditionKind::Allen { relation, parts, tolerance, constraints });
        let never = call(">", vec![call("start-of", vec![variable("pair")]), constant(Value::Time(Time(1_000_000)))]);
        let seen = condition(event(vec![word("seen")]));
        let both = ConditionKind::And(vec![tagged("pair", pairs.kind), seen], vec![never]);
        let mut world = World::new(&condition(both));
        // 64 samples before 64 others are as many pairs as are remembered.
        for at in 0..64 {
            world.sample("a", "uav", Value::Integer(5), at);
            world.ask(at);
        }
        for at in 64..128 {
            world.sample("b", "uav", Value::Integer(5), at);
            world.ask(at);
        }
        assert_eq!(told(&mut world), Vec::<String>::new());
        for at in 128..131 {
            world.sample("b", "uav", Value::Integer(5), at);
            world.ask(at);
        }
        assert_eq!(told(&mut world), results_limit(), "final: {final_ones}");
    }
}

#[test]
fn that_results_are_forgotten_while_looking_back_is_reported_once() {
    let mut view = TestView::default();
    view.histories.require_lookback_of_all(Duration::MAX);
    let mut world = World::in_view(&condition(event(vec![word("never")])), view);
    for at in 0..2 * MOST + 9 {
        world.sample("a", "uav", Value::Integer(if at % 2 == 0 { 5 } else { 4 }), at);
    }
    let every = create_keeping(&warm("a", 0, false), Window::from(Time::ZERO), Keep::Every, &world.view).unwrap();
    world.monitor = every;
    assert_eq!(told(&mut world), results_limit());
}
