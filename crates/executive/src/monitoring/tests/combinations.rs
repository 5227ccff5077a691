//! Conditions whose parts depend on each other (shared variables, constraints over tags, order), against all combinations.

use super::*;
use proptest::prelude::*;

/// An event `(name number)`.
type Happened = (i64, u8, i64);

fn tell(world: &mut World, events: &[Happened]) {
    for (at, name, number) in events {
        let name = if *name == 0 { "a" } else { "b" };
        world.event(list(&[Value::symbol(name), Value::Integer(*number)]), *at);
    }
}

fn named(tag: &str, name: &str, variable: &str) -> Condition {
    tagged(tag, event(vec![word(name), free(variable)]))
}

fn histories() -> impl Strategy<Value = Vec<Happened>> {
    proptest::collection::vec((0..4_i64, 0..2_u8, 0..3_i64), 0..14).prop_map(|steps| {
        let mut at = 0;
        steps
            .into_iter()
            .map(|(pause, name, number)| {
                at += pause;
                (at, name, number)
            })
            .collect()
    })
}

/// Returns the earliest instant at which a pair of an `a` and a `b` that satisfies `agree` is complete.
fn earliest(events: &[Happened], agree: impl Fn(&Happened, &Happened) -> bool) -> Option<i64> {
    let of = |name: u8| events.iter().filter(move |event| event.1 == name);
    of(0).flat_map(|a| of(1).map(move |b| (a, b))).filter(|(a, b)| agree(a, b)).map(|(a, b)| a.0.max(b.0)).min()
}

fn check(
    whole: &Condition,
    events: &[Happened],
    agree: impl Fn(&Happened, &Happened) -> bool + Copy,
) -> Result<(), TestCaseError> {
    let mut world = World::new(whole);
    for until in 0..events.len() {
        tell(&mut world, &events[until..=until]);
        let known = world.answer(events[until].0).map(|(_, _, known)| known);
        prop_assert_eq!(known, earliest(&events[..=until], agree));
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1_000))]

    #[test]
    fn a_shared_variable_has_one_value(events in histories()) {
        let whole = condition(ConditionKind::And(vec![named("p", "a", "x"), named("q", "b", "x")], vec![]));
        check(&whole, &events, |a, b| a.2 == b.2)?;
    }

    #[test]
    fn parts_without_shared_variables_are_independent(events in histories()) {
        let whole = condition(ConditionKind::And(vec![named("p", "a", "x"), named("q", "b", "y")], vec![]));
        check(&whole, &events, |_, _| true)?;
    }

    #[test]
    fn constraints_choose_among_all_results(events in histories(), most in 0..5_i64) {
        let between = call("-", vec![call("start-of", vec![variable("q")]), call("end-of", vec![variable("p")])]);
        let near = call("<", vec![between.clone(), span(most)]);
        let after = call(">=", vec![between, span(0)]);
        let whole = condition(ConditionKind::And(vec![named("p", "a", "x"), named("q", "b", "y")], vec![near, after]));
        check(&whole, &events, |a, b| b.0 >= a.0 && b.0 - a.0 < most)?;
    }

    #[test]
    fn order_is_strict_and_delays_bound_it(events in histories(), least in 0..3_i64, more in 0..4_i64) {
        let parts = || vec![named("p", "a", "x"), named("q", "b", "y")];
        let ordered = condition(ConditionKind::InOrder(parts(), vec![]));
        check(&ordered, &events, |a, b| a.0 < b.0)?;
        let mut delayed = parts();
        delayed.insert(1, condition(ConditionKind::Delay(span(least), Some(span(least + more)))));
        let delayed = condition(ConditionKind::InOrder(delayed, vec![]));
        check(&delayed, &events, |a, b| b.0 - a.0 >= least && b.0 - a.0 <= least + more)?;
    }

    #[test]
    fn what_must_not_be_is_looked_for_with_the_same_value(events in histories()) {
        let absent = condition(ConditionKind::Not(Box::new(named("q", "b", "x"))));
        let whole = condition(ConditionKind::And(vec![named("p", "a", "x"), absent], vec![]));
        let mut world = World::new(&whole);
        for until in 0..events.len() {
            tell(&mut world, &events[until..=until]);
            let so_far = &events[..=until];
            let expected = so_far.iter().any(|a| a.1 == 0 && !so_far.iter().any(|b| b.1 == 1 && b.2 == a.2));
            prop_assert_eq!(world.answer(events[until].0).is_some(), expected);
        }
    }
}

#[test]
fn the_result_binds_tags_and_variables() {
    let whole = tagged("both", ConditionKind::And(vec![named("p", "a", "x"), named("q", "b", "x")], vec![]));
    let mut world = World::new(&whole);
    tell(&mut world, &[(1, 0, 1), (2, 0, 2), (5, 1, 2)]);
    let Verdict::Satisfied(result) = world.ask(5) else { panic!() };
    let bound = |name: &str| result.bindings.get(&Symbol::new(name)).cloned();
    assert_eq!(bound("x"), Some(Value::Integer(2)));
    assert_eq!(bound("p"), Some(Value::Interval(Time(2), Time(2))));
    assert_eq!(bound("both"), Some(Value::Interval(Time(2), Time(5))));
    assert_eq!(result.evidence.len(), 2);
}

#[test]
fn a_delay_after_the_last_part_wakes_when_it_is_over() {
    let parts = vec![named("p", "a", "x"), condition(ConditionKind::Delay(span(10), None))];
    let mut world = World::new(&condition(ConditionKind::InOrder(parts, vec![])));
    tell(&mut world, &[(4, 0, 1)]);
    assert_eq!(world.answer(4), None);
    assert_eq!(next_wake(&world.monitor).map(|(at, _)| at), Some(Time(14)));
    assert_eq!(world.answer(14), Some((4, 4, 14)));
}
