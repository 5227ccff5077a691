//! Short sequences of samples and messages: one rule of the language each.

use super::*;
use crate::state::monitors::monitor::Interest;
use apex_model::condition::Estimation;
use apex_model::library::StateVariableDeclaration;
use apex_model::quantity::unit_named;

const SECOND: i64 = 1_000_000_000;

fn equals(attribute: &str, value: i64) -> MeasurementCondition {
    measurement(uav(attribute), vec![compare(Relation::Equal, int(value))])
}

#[test]
fn delays_inside_order_give_the_manuals_instants() {
    let is = |value: i64| condition(ConditionKind::Measurement(equals("t", value).into()));
    let lasting = |value: i64| {
        let duration = vec![compare(Relation::GreaterOrEqual, span(10 * SECOND))];
        let value = vec![compare(Relation::Equal, int(value))];
        condition(ConditionKind::Episode(Arc::new(episode(uav("t"), value, Some(10 * SECOND), duration))))
    };
    let delay = |least: i64, most: Option<i64>| {
        condition(ConditionKind::Delay(span(least * SECOND), most.map(|most| span(most * SECOND))))
    };
    let order = |parts: Vec<Condition>| condition(ConditionKind::InOrder(parts, vec![]));
    let cases = [
        (order(vec![is(33), delay(25, None), is(35)]), 35),
        (order(vec![is(33), delay(25, Some(35)), is(35)]), 35),
        (lasting(33), 20),
        (lasting(35), 40),
        (order(vec![lasting(33), delay(15, Some(30)), lasting(35)]), 45),
    ];
    for (case, (whole, expected)) in cases.into_iter().enumerate() {
        let mut world = World::new(&whole);
        let mut satisfied = None;
        for at in (10..=45).step_by(5) {
            let value = if at <= 25 { 33 } else { 35 };
            world.sample("t", "uav", Value::Integer(value), at * SECOND);
            if world.answer(at * SECOND).is_some() {
                satisfied = satisfied.or(Some(at));
            }
        }
        assert_eq!(satisfied, Some(expected), "case {case}");
    }
}

#[test]
fn one_tick_divides_more_than_from_at_least() {
    for (relation, expected) in [(Relation::GreaterOrEqual, 5 * SECOND), (Relation::Greater, 5 * SECOND + 1)] {
        let value = vec![compare(Relation::Greater, int(10))];
        let wanted = episode(uav("roll"), value, Some(6 * SECOND), vec![compare(relation, span(5 * SECOND))]);
        let mut world = World::new(&condition(ConditionKind::Episode(Arc::new(wanted))));
        world.sample("roll", "uav", Value::Integer(12), 0);
        assert_eq!(world.ask(0), Verdict::Unknown);
        world.stand_up();
        let (wake, why) = next_wake(&world.monitor).unwrap();
        assert_eq!(wake, Time(expected));
        assert!(why.to_string().contains(":duration"));
        assert_eq!(world.answer(expected - 1), None);
        assert_eq!(world.answer(expected), Some((0, 0, expected)));
    }
}

#[test]
fn evidence_of_the_instant_of_creation_counts_but_not_what_was_answered_before() {
    let wanted = condition(event(vec![word("ready"), free("who")]));
    let mut world = World::new(&wanted);
    world.event(list(&[Value::symbol("ready"), Value::symbol("camera")]), 7);
    world.watch(&wanted, Window::from(Time(7)));
    let Verdict::Satisfied(result) = world.ask(7) else { panic!() };
    assert_eq!(result.bindings.get(&Symbol::new("who")), Some(&Value::symbol("camera")));
    let repeated = Window { start: Time(7), after_sequence: Some(world.sequence) };
    world.watch(&wanted, repeated);
    assert_eq!(world.ask(7), Verdict::NotSatisfied);
    world.event(list(&[Value::symbol("ready"), Value::symbol("radio")]), 7);
    assert!(world.answer(7).is_some());
}

#[test]
fn a_question_about_a_forgotten_past_is_unknown_never_false() {
    let mut view = TestView::default();
    let variable = StateVariable::new(Symbol::new("a"), Value::symbol("uav"));
    for at in 0..5 {
        record_sample(
            &mut view.histories,
            &VariableIndex::new(&view.library),
            variable.clone(),
            Value::Integer(1),
            Time(at),
            0,
        );
    }
    view.now = Time(9);
    let mut past = equals("a", 3);
    past.timestamp = vec![compare(Relation::Less, call("start-of", vec![constant(Value::Time(Time(9)))]))];
    let mut world = World::in_view(&condition(ConditionKind::Measurement(past.clone().into())), view);
    assert_eq!(world.ask(9), Verdict::Unknown);
    past.value = vec![compare(Relation::Equal, int(1))];
    world.watch(&condition(ConditionKind::Measurement(past.into())), Window::from(Time(9)));
    assert_eq!(world.answer(9), Some((3, 3, 9)));
}

#[test]
fn an_unbound_value_binds_and_a_bound_one_compares() {
    let wanted = condition(ConditionKind::Measurement(Arc::new(measurement(
        uav("location"),
        vec![Constraint::Matches(free("loc"))],
    ))));
    let mut world = World::new(&wanted);
    world.sample("location", "uav", Value::symbol("fuel-bay"), 1);
    let Verdict::Satisfied(result) = world.ask(1) else { panic!() };
    assert_eq!(result.bindings.get(&Symbol::new("loc")), Some(&Value::symbol("fuel-bay")));
    let mut view = TestView::default();
    view.variables.set(Symbol::new("loc"), Value::symbol("fuel-bay"));
    let mut world = World::in_view(&wanted, view);
    world.sample("location", "uav", Value::symbol("runway"), 1);
    assert_eq!(world.ask(1), Verdict::NotSatisfied);
    world.sample("location", "uav", Value::symbol("fuel-bay"), 2);
    assert!(world.answer(2).is_some());
}

#[test]
fn an_object_variable_follows_each_object_on_its_own() {
    let duration = vec![compare(Relation::GreaterOrEqual, span(4))];
    let value = vec![compare(Relation::Greater, int(5))];
    let wanted = episode(of("temperature", free("engine")), value, None, duration);
    let mut world = World::new(&condition(ConditionKind::Episode(Arc::new(wanted))));
    assert_eq!(interests(&world.monitor), [Interest::Attribute(Symbol::new("temperature"))]);
    for (at, engine, value) in [(0, "left", 9), (1, "right", 9), (3, "left", 1), (4, "left", 9), (5, "right", 9)] {
        world.sample("temperature", engine, Value::Integer(value), at);
        world.sample("pressure", engine, Value::Integer(value), at);
    }
    let Verdict::Satisfied(result) = world.ask(5) else { panic!() };
    assert_eq!(result.bindings.get(&Symbol::new("engine")), Some(&Value::symbol("right")));
    assert_eq!(result.interval, (Time(1), Time(5)));
}

#[test]
fn values_bound_within_an_episode_stay_the_same_or_begin_a_new_run() {
    let duration = vec![compare(Relation::GreaterOrEqual, span(4))];
    let wanted = episode(uav("location"), vec![Constraint::Matches(free("place"))], None, duration);
    let mut world = World::new(&condition(ConditionKind::Episode(Arc::new(wanted))));
    for (at, place) in [(0, "a"), (3, "a"), (5, "b"), (8, "b"), (9, "b")] {
        world.sample("location", "uav", Value::symbol(place), at);
    }
    let Verdict::Satisfied(result) = world.ask(9) else { panic!() };
    assert_eq!(result.bindings.get(&Symbol::new("place")), Some(&Value::symbol("b")));
    assert_eq!(result.interval, (Time(5), Time(9)));
}

#[test]
fn persistence_carries_the_last_value_into_the_window_for_its_timeout() {
    let mut wanted = equals("a", 3);
    wanted.estimation = Some(Estimation::Persist(Some(span(10))));
    let wanted = condition(ConditionKind::Measurement(wanted.into()));
    for (now, expected) in [(12, Some((2, 2, 12))), (13, None)] {
        let mut view = TestView { now: Time(now), ..TestView::default() };
        let variable = StateVariable::new(Symbol::new("a"), Value::symbol("uav"));
        record_sample(&mut view.histories, &VariableIndex::new(&view.library), variable, Value::Integer(3), Time(2), 0);
        let mut world = World::in_view(&wanted, view);
        assert_eq!(world.answer(now), expected);
        // A sample of the same instant replaces the carried value.
        world.sample("a", "uav", Value::Integer(4), now);
        assert_eq!(world.answer(now), None);
    }
}

#[test]
fn first_and_last_values_are_of_the_run() {
    let mut wanted = episode(uav("a"), vec![compare(Relation::Greater, int(0))], None, vec![]);
    wanted.first_value = vec![compare(Relation::Equal, int(1))];
    wanted.last_value = vec![compare(Relation::GreaterOrEqual, int(3))];
    let mut world = World::new(&condition(ConditionKind::Episode(Arc::new(wanted))));
    for (at, value, expected) in
        [(0, 2, None), (1, 5, None), (2, 0, None), (3, 1, None), (4, 2, None), (5, 3, Some((3, 5, 5)))]
    {
        world.sample("a", "uav", Value::Integer(value), at);
        assert_eq!(world.answer(at), expected, "at {at}");
    }
}

#[test]
fn bare_numbers_are_in_the_declared_unit_and_other_dimensions_are_reported() {
    let mut view = TestView::default();
    let declaration = StateVariableDeclaration {
        unit: Some(Symbol::new("ft")),
        dimension: unit_named("ft").unwrap().dimension,
        value_type: None,
        lateness: None,
        rate_per_s: None,
        place: Place::default(),
    };
    view.library.state_variables.insert(Symbol::new("altitude"), declaration);
    let above = |right: Expr| {
        condition(ConditionKind::Measurement(Arc::new(measurement(
            uav("altitude"),
            vec![compare(Relation::Greater, right)],
        ))))
    };
    let mut world = World::in_view(&above(call("+", vec![int(100), int(200)])), view);
    world.sample("altitude", "uav", Value::Integer(299), 1);
    assert_eq!(world.ask(1), Verdict::NotSatisfied);
    world.sample("altitude", "uav", Value::Integer(301), 2);
    assert!(world.answer(2).is_some());
    world.watch(&above(span(5)), Window::from(Time(2)));
    let faults = take_troubles(&mut world.monitor);
    assert_eq!(faults.len(), 1);
    assert!(faults[0].message.contains("cannot compare 301ft (length) with P0.000000005S (time)"));
    world.sample("altitude", "uav", Value::Integer(301), 3);
    assert!(take_troubles(&mut world.monitor).is_empty(), "the same fault is reported once");
}

#[test]
fn tasks_that_have_ended_satisfy_at_once_unless_only_changes_count() {
    let mut view = TestView::default();
    view.variables.set(Symbol::new("s1"), Value::Task(TaskId(4)));
    let ended =
        crate::test_support::TestTask { end: Some(Time(3)), state: TaskState::Terminated, ..Default::default() };
    view.tasks.insert(TaskId(4), ended);
    view.now = Time(5);
    let wanted = condition(ConditionKind::TaskEnded(Symbol::new("s1")));
    let mut world = World::in_view(&wanted, view);
    assert_eq!(world.answer(5), Some((3, 3, 5)));
    assert_eq!(interests(&world.monitor), [Interest::Task(TaskId(4))]);
    world.monitor = create_for_changes(&wanted, Window::from(Time(5)), &world.view).unwrap();
    assert_eq!(world.ask(5), Verdict::NotSatisfied);
    notice(
        &mut world.monitor,
        &Stimulus::TaskEnded { task: TaskId(4), outcome: &[], at: Time(6), before: MonitorId(9) },
        &world.view,
    );
    assert_eq!(world.answer(6), Some((6, 6, 6)));
}

#[test]
fn resumed_is_the_change_from_interrupted_to_ongoing() {
    let this_task = Expr { kind: ExprKind::Indexical(Symbol::new("this-task")), place: Place::default() };
    let wanted = condition(ConditionKind::TaskState { task: this_task, state: word("resumed") });
    let mut view = TestView::default();
    view.tasks.insert(TaskId(1), crate::test_support::TestTask { state: TaskState::Ongoing, ..Default::default() });
    let mut world = World::in_view(&wanted, view);
    let change =
        |from, state, at| Stimulus::TaskState { task: TaskId(1), from, state, at: Time(at), before: MonitorId(9) };
    notice(&mut world.monitor, &change(TaskState::Ongoing, TaskState::Interrupted, 1), &world.view);
    assert_eq!(world.ask(1), Verdict::NotSatisfied);
    notice(&mut world.monitor, &change(TaskState::Interrupted, TaskState::Ongoing, 2), &world.view);
    assert_eq!(world.answer(2), Some((2, 2, 2)));
}

#[test]
fn timestamps_and_delays_come_at_their_instant() {
    let at = |kind: ConditionKind| World::new(&condition(kind));
    let mut stamp = at(ConditionKind::Timestamp(constant(Value::Time(Time(9))), None));
    assert_eq!(stamp.ask(3), Verdict::NotSatisfied);
    assert_eq!(next_wake(&stamp.monitor).map(|(at, _)| at), Some(Time(9)));
    assert_eq!(stamp.answer(12), Some((9, 9, 9)));
    let mut delay = at(ConditionKind::Delay(span(4), None));
    delay.ask(3);
    assert_eq!(next_wake(&delay.monitor).map(|(at, _)| at), Some(Time(4)));
    assert_eq!(delay.answer(4), Some((4, 4, 4)));
    let mut past = TestView { now: Time(9), ..TestView::default() };
    past.tasks.insert(TaskId(1), Default::default());
    let gone = condition(ConditionKind::Timestamp(constant(Value::Time(Time(5))), None));
    assert_eq!(World::in_view(&gone, past).ask(9), Verdict::NotSatisfied);
}

#[test]
fn unmet_parts_say_what_is_known_and_since_when() {
    let above = measurement(uav("a"), vec![compare(Relation::Greater, int(5))]);
    let duration = vec![compare(Relation::GreaterOrEqual, span(5 * SECOND))];
    let held = episode(uav("b"), vec![compare(Relation::Greater, int(5))], Some(2 * SECOND), duration);
    let whole = condition(ConditionKind::And(
        vec![
            condition(ConditionKind::Measurement(above.into())),
            condition(ConditionKind::Episode(Arc::new(held))),
            condition(event(vec![word("ready"), free("who")])),
            condition(ConditionKind::TaskEnded(Symbol::new("s1"))),
        ],
        vec![],
    ));
    let mut world = World::new(&whole);
    let told = |world: &World| {
        unmet(&world.monitor, &world.view)
            .into_iter()
            .map(|part| format!("{} | {}", part.what, part.now))
            .collect::<Vec<_>>()
    };
    assert_eq!(told(&world)[0], "(a uav > 5) | no sample yet");
    world.sample("a", "uav", Value::Integer(3), SECOND);
    world.sample("b", "uav", Value::Integer(7), SECOND);
    world.sample("b", "uav", Value::Integer(8), 2 * SECOND);
    world.ask(5 * SECOND);
    assert_eq!(
        told(&world),
        [
            "(a uav > 5) | (a uav) = 3, 2 off",
            "(:episode (b uav) :quality (:max-gap P2S) :value (> 5) :timing (:duration (>= P5S))) | \
         (b uav) = 8, holds for P1S so far; no sample for P3S, more than the gap of P2S allowed",
            "(ready ?who) | no such event yet",
            "(end ?s1) | ?s1 is not known yet",
        ]
    );
    assert_eq!(unmet(&world.monitor, &world.view)[1].since, Some(Time(SECOND)));
}

#[test]
fn interests_route_by_head_variable_and_task() {
    let whole = condition(ConditionKind::Or(
        vec![
            condition(event(vec![word("Ready"), free("who")])),
            condition(event(vec![free("what"), free("who")])),
            condition(ConditionKind::Measurement(equals("a", 1).into())),
            condition(ConditionKind::TaskEnded(Symbol::new("unknown"))),
        ],
        vec![],
    ));
    let world = World::new(&whole);
    let a = StateVariable::new(Symbol::new("a"), Value::symbol("uav"));
    assert_eq!(
        interests(&world.monitor),
        [Interest::Variable(a), Interest::EventHead(Symbol::new("ready")), Interest::AnyEvent, Interest::AnyTask,]
    );
    assert_eq!(crate::monitoring::basic::event::head_of(&Value::symbol("READY")), Some(Symbol::new("ready")));
}
