//! Allen relations and absence against their definitions: over all runs, with all possible continuations of open runs.

use super::*;
use crate::monitoring::combination::allen::SWEEP_AT_LEAST;
use apex_model::condition::AllenRelation;
use apex_model::library::StateVariableDeclaration;
use apex_model::quantity::Dimension;
use proptest::prelude::*;

pub(super) const RELATIONS: [AllenRelation; 13] = [
    AllenRelation::Before,
    AllenRelation::After,
    AllenRelation::Meets,
    AllenRelation::MetBy,
    AllenRelation::Overlaps,
    AllenRelation::OverlappedBy,
    AllenRelation::Starts,
    AllenRelation::StartedBy,
    AllenRelation::Finishes,
    AllenRelation::FinishedBy,
    AllenRelation::During,
    AllenRelation::Contains,
    AllenRelation::Cotemporal,
];

pub(super) type Interval = (i64, i64);

/// Returns true if the relation holds as defined in textbooks, with end points equal within `near`.
fn stands(relation: AllenRelation, a: Interval, b: Interval, near: i64) -> bool {
    let less = |x: i64, y: i64| y - x > near;
    let same = |x: i64, y: i64| (x - y).abs() <= near;
    match relation {
        AllenRelation::Before => less(a.1, b.0),
        AllenRelation::Meets => same(a.1, b.0),
        AllenRelation::Overlaps => less(a.0, b.0) && less(b.0, a.1) && less(a.1, b.1),
        AllenRelation::Starts => same(a.0, b.0) && less(a.1, b.1),
        AllenRelation::Finishes => less(b.0, a.0) && same(a.1, b.1),
        AllenRelation::During => less(b.0, a.0) && less(a.1, b.1),
        AllenRelation::Cotemporal => same(a.0, b.0) && same(a.1, b.1),
        AllenRelation::After => stands(AllenRelation::Before, b, a, near),
        AllenRelation::MetBy => stands(AllenRelation::Meets, b, a, near),
        AllenRelation::OverlappedBy => stands(AllenRelation::Overlaps, b, a, near),
        AllenRelation::StartedBy => stands(AllenRelation::Starts, b, a, near),
        AllenRelation::FinishedBy => stands(AllenRelation::Finishes, b, a, near),
        AllenRelation::Contains => stands(AllenRelation::During, b, a, near),
    }
}

/// Constraint of one part on its variable.
#[derive(Clone, Copy, Debug)]
pub(super) enum Side {
    /// Each sample of at least 5 is a point.
    Points,
    /// Whole runs of at least 5, without larger gaps, that last at least this duration.
    Runs { gap: Option<i64>, least: i64 },
}

impl Side {
    pub(super) fn condition(self, attribute: &str) -> Condition {
        let value = vec![compare(Relation::GreaterOrEqual, int(5))];
        tagged(
            attribute,
            match self {
                Side::Points => ConditionKind::Measurement(Arc::new(measurement(uav(attribute), value))),
                Side::Runs { gap, least } => {
                    let duration = vec![compare(Relation::GreaterOrEqual, span(least))];
                    ConditionKind::Episode(Arc::new(episode(uav(attribute), value, gap, duration)))
                }
            },
        )
    }

    /// Returns the intervals known at `now`, and whether each can continue. A run counts once its duration is reached, by a sample or
    /// while the gap allows the last value to hold.
    pub(super) fn intervals(self, samples: &[(i64, i64)], now: i64) -> Vec<(Interval, bool)> {
        let Side::Runs { gap, least } = self else {
            return samples.iter().filter(|(_, value)| *value >= 5).map(|(at, _)| ((*at, *at), false)).collect();
        };
        let mut runs: Vec<(Interval, bool)> = Vec::new();
        let mut licensed = Vec::new();
        let mut open = false;
        for (index, (at, value)) in samples.iter().enumerate() {
            match runs.last_mut().filter(|_| open) {
                Some((run, _)) if *value >= 5 && gap.is_none_or(|gap| at - run.1 <= gap) => run.1 = *at,
                _ if *value >= 5 => {
                    runs.push(((*at, *at), false));
                    licensed.push(false);
                }
                _ => {}
            }
            open = *value >= 5;
            if let (Some((run, _)), Some(licensed), true) = (runs.last(), licensed.last_mut(), open) {
                // Until the next sample, or as long as the gap lasts, the last value holds.
                let until = samples.get(index + 1).map_or(now, |(next, _)| (next - 1).min(now));
                let holds = gap.map_or(run.1, |gap| until.min(run.1 + gap).max(run.1));
                *licensed |= holds - run.0 >= least;
            }
        }
        if let Some((run, goes_on)) = runs.last_mut() {
            *goes_on = open && gap.is_none_or(|gap| now - run.1 <= gap);
        }
        runs.into_iter().zip(licensed).filter(|(_, licensed)| *licensed).map(|(run, _)| run).collect()
    }
}

/// Returns all ends that a run could have.
fn ends((interval, open): (Interval, bool), now: i64) -> Vec<Interval> {
    let later = [now + 1, now + 2, now + 3, now + 7, now + 1_000].map(|end| (interval.0, end));
    std::iter::once(interval).chain(later.into_iter().filter(|_| open)).collect()
}

/// Pairs that are in the relation however runs continue, in order.
pub(super) fn decided(
    relation: AllenRelation,
    near: i64,
    left: &[(Interval, bool)],
    right: &[(Interval, bool)],
    now: i64,
) -> Vec<Interval> {
    let mut pairs: Vec<(Interval, Interval)> = Vec::new();
    for a in left {
        for b in right {
            let ends_b = ends(*b, now);
            if ends(*a, now).iter().all(|a| ends_b.iter().all(|b| stands(relation, *a, *b, near))) {
                pairs.push((a.0, b.0));
            }
        }
    }
    pairs.sort_unstable();
    pairs.into_iter().map(|(a, b)| (a.0.min(b.0), a.1.max(b.1))).collect()
}

/// Generates samples: the variable, the instant, the value. Both variables often have samples at the same instant.
pub(super) fn traces() -> impl Strategy<Value = Vec<(bool, i64, i64)>> {
    proptest::collection::vec((0..4_i64, 0..3_u8, 3..7_i64, 3..7_i64), 1..16).prop_map(|steps| {
        let mut at = 0;
        let mut trace = Vec::new();
        for (pause, which, a, b) in steps {
            at += pause.max(1);
            if which != 1 {
                trace.push((true, at, a));
            }
            if which != 2 {
                trace.push((false, at, b));
            }
        }
        trace
    })
}

fn sides() -> impl Strategy<Value = Side> {
    prop_oneof![
        1 => Just(Side::Points),
        3 => (proptest::option::of(1..5_i64), 0..5_i64).prop_map(|(gap, least)| Side::Runs { gap, least }),
    ]
}

fn samples_of(trace: &[(bool, i64, i64)], first: bool) -> Vec<(i64, i64)> {
    trace.iter().filter(|(which, ..)| *which == first).map(|(_, at, value)| (*at, *value)).collect()
}

fn tell(world: &mut World, trace: &[(bool, i64, i64)]) {
    for (first, at, value) in trace {
        world.sample(if *first { "a" } else { "b" }, "uav", Value::Integer(*value), *at);
    }
}

pub(super) fn related(relation: AllenRelation, near: i64, parts: Vec<Condition>) -> Condition {
    let tolerance = (near > 0).then(|| span(near));
    tagged("both", ConditionKind::Allen { relation, parts, tolerance, constraints: vec![] })
}

#[test]
fn a_result_that_ends_first_does_not_stand_for_one_that_begins_later() {
    let condition = related(
        AllenRelation::During,
        0,
        vec![Side::Points.condition("a"), Side::Runs { gap: None, least: 0 }.condition("b")],
    );
    let mut world = World::new(&condition);
    // The samples of b arrive later than those of a: its run begins with the first point.
    tell(&mut world, &[(false, 2, 3), (true, 3, 5), (true, 7, 5), (true, 8, 3)]);
    assert_eq!(world.answer(8), None);
    tell(&mut world, &[(false, 3, 5)]);
    assert_eq!(world.answer(8), None);
    tell(&mut world, &[(false, 9, 5)]);
    assert_eq!(world.answer(9), Some((3, 9, 9)));
}

#[test]
fn a_run_that_silence_has_ended_continues_with_a_sample_that_was_on_its_way() {
    let runs = Side::Runs { gap: Some(1), least: 0 };
    let mut world =
        World::new(&related(AllenRelation::During, 0, vec![Side::Points.condition("a"), runs.condition("b")]));
    // Enough samples that useless ones are dropped; the last sample of b arrives when b seems to be silent.
    tell(&mut world, &[(false, 6, 3), (false, 7, 5), (true, 8, 5), (false, 8, 5)]);
    assert_eq!(world.answer(8), None);
    for at in 11..=60 {
        tell(&mut world, &[(true, at, 5)]);
        assert_eq!(world.answer(at), None);
    }
    tell(&mut world, &[(false, 9, 5)]);
    assert_eq!(world.answer(60), Some((7, 9, 60)));
}

/// Compares the answers of a relation at all instants with its definition, up to the first answer.
fn follows_the_definition(
    trace: &[(bool, i64, i64)],
    (relation, near): (AllenRelation, i64),
    (left, right): (Side, Side),
    rest: i64,
) -> Result<(), TestCaseError> {
    let mut world = World::new(&related(relation, near, vec![left.condition("a"), right.condition("b")]));
    let end = trace.last().map_or(0, |last| last.1) + rest;
    let mut told = 0;
    for now in 0..=end {
        let arrived = trace.iter().take_while(|(_, at, _)| *at <= now).count();
        tell(&mut world, &trace[told..arrived]);
        told = arrived;
        let known = &trace[..told];
        let (a, b) = (left.intervals(&samples_of(known, true), now), right.intervals(&samples_of(known, false), now));
        let expected = decided(relation, near, &a, &b, now).first().map(|hull| (hull.0, hull.1, now));
        let answer = world.answer(now);
        prop_assert_eq!(answer, expected, "{:?} at {} of {:?} and {:?}", relation, now, a, b);
        if answer.is_some() {
            break;
        }
    }
    Ok(())
}

/// Returns the trace after `runs` short runs of the first variable that nothing is related to: enough runs that results are dropped.
fn preceded(trace: &[(bool, i64, i64)], runs: i64) -> Vec<(bool, i64, i64)> {
    let before = (0..runs).flat_map(|run| [(true, 2 * run, 5), (true, 2 * run + 1, 4)]);
    before.chain(trace.iter().map(|(first, at, value)| (*first, at + 2 * runs, *value))).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn results_are_dropped_only_when_nothing_can_be_related_to_them(
        trace in traces(), which in 0..13_usize, near in 0..3_i64, left in sides(), right in sides(), rest in 0..8_i64,
        runs in SWEEP_AT_LEAST as i64..2 * SWEEP_AT_LEAST as i64 + 8,
    ) {
        follows_the_definition(&preceded(&trace, runs), (RELATIONS[which], near), (left, right), rest)?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn relations_hold_as_soon_as_nothing_can_change_them(
        trace in traces(), which in 0..13_usize, near in 0..3_i64, left in sides(), right in sides(), rest in 0..8_i64,
    ) {
        follows_the_definition(&trace, (RELATIONS[which], near), (left, right), rest)?;
    }

    #[test]
    fn relations_are_decided_at_the_wakes(
        trace in traces(), which in 0..13_usize, left in sides(), right in sides(), rest in 0..8_i64,
    ) {
        let relation = RELATIONS[which];
        let condition = related(relation, 0, vec![left.condition("a"), right.condition("b")]);
        let end = trace.last().map_or(0, |last| last.1) + rest;
        let (mut every, mut sparse) = (World::new(&condition), World::new(&condition));
        let mut first = None;
        let mut told = 0;
        for now in 0..=end {
            let arrived = trace.iter().take_while(|(_, at, _)| *at <= now).count();
            tell(&mut every, &trace[told..arrived]);
            told = arrived;
            first = first.or(every.answer(now));
        }
        let mut answer = None;
        for group in trace.chunk_by(|a, b| a.1 == b.1) {
            while let Some((at, _)) = next_wake(&sparse.monitor).filter(|(at, _)| at.0 < group[0].1) {
                answer = answer.or(sparse.answer(at.0));
            }
            tell(&mut sparse, group);
            answer = answer.or(sparse.answer(group[0].1));
        }
        while let Some((at, _)) = next_wake(&sparse.monitor).filter(|(at, _)| at.0 <= end) {
            answer = answer.or(sparse.answer(at.0));
        }
        prop_assert_eq!(answer, first, "{:?} {:?} {:?}", relation, left, right);
    }

    #[test]
    fn looking_back_finds_what_watching_found(
        trace in traces(), which in 0..13_usize, near in 0..3_i64, left in sides(), right in sides(), rest in 0..8_i64,
    ) {
        let condition = related(RELATIONS[which], near, vec![left.condition("a"), right.condition("b")]);
        let end = trace.last().map_or(0, |last| last.1) + rest;
        let mut watching = World::new(&condition);
        let mut found = None;
        let mut told = 0;
        for now in 0..=end {
            let arrived = trace.iter().take_while(|(_, at, _)| *at <= now).count();
            tell(&mut watching, &trace[told..arrived]);
            told = arrived;
            found = found.or(watching.answer(now));
        }
        // A monitor that is created at the end looks back over the same window.
        let mut view = TestView::default();
        view.histories.require_lookback_of_all(Duration::MAX);
        let mut late = World::in_view(&condition, view);
        tell(&mut late, &trace);
        late.view.now = Time(end);
        late.watch(&condition, Window::from(Time::ZERO));
        let answer = late.answer(end).map(|(start, last, _)| (start, last));
        prop_assert_eq!(answer, found.map(|(start, last, _)| (start, last)));
    }

    #[test]
    fn late_samples_are_related_as_if_they_had_come_in_time(
        trace in traces(), which in 0..13_usize, left in sides(), right in sides(), late in 0..30_usize, by in 1..6_usize,
    ) {
        let relation = RELATIONS[which];
        let mut world = World::new(&related(relation, 0, vec![left.condition("a"), right.condition("b")]));
        for name in ["a", "b"] {
            let lateness = Some(Value::Duration(Duration(1_000)));
            let (unit, value_type, rate_per_s, dimension, place) = (None, None, None, Dimension::NONE, Place::default());
            let declaration = StateVariableDeclaration { unit, dimension, value_type, lateness, rate_per_s, place };
            world.view.library.state_variables.insert(Symbol::new(name), declaration);
        }
        world.view.histories.require_lookback_of_all(Duration::MAX);
        let mut arrivals = trace.clone();
        let late = arrivals.remove(late % trace.len());
        arrivals.insert((by + trace.iter().take_while(|each| **each != late).count()).min(arrivals.len()), late);
        let mut now = 0;
        for (index, arrival) in arrivals.iter().enumerate() {
            tell(&mut world, &arrivals[index..=index]);
            now = now.max(arrival.1);
            // All arrivals of one instant belong to one step.
            if arrivals.get(index + 1).is_some_and(|next| next.1 <= now) {
                continue;
            }
            let mut known = arrivals[..=index].to_vec();
            known.sort_by_key(|(_, at, _)| *at);
            let (a, b) = (left.intervals(&samples_of(&known, true), now), right.intervals(&samples_of(&known, false), now));
            let expected = !decided(relation, 0, &a, &b, now).is_empty();
            prop_assert_eq!(world.answer(now).is_some(), expected, "{:?} at {} of {:?} and {:?}", relation, now, a, b);
            if expected {
                break;
            }
        }
    }

    #[test]
    fn absence_is_a_whole_window_without(trace in traces(), side in sides(), length in 1..9_i64, rest in 0..12_i64) {
        let absent = ConditionKind::Absent(Box::new(side.condition("a")), span(length));
        let mut world = World::new(&condition(absent));
        let end = trace.last().map_or(0, |last| last.1) + rest;
        let mut told = 0;
        for now in 0..=end {
            let arrived = trace.iter().take_while(|(_, at, _)| *at <= now).count();
            tell(&mut world, &trace[told..arrived]);
            told = arrived;
            let samples = samples_of(&trace[..told], true);
            let intervals = side.intervals(&samples, now);
            let since = intervals.iter().map(|(interval, _)| interval.1).max().unwrap_or(0);
            let goes_on = intervals.iter().any(|(_, open)| *open);
            let quiet = !goes_on && now - since >= length;
            // If the newest sample does not contradict an episode, or expected ones are missing, it may continue.
            let is_current = |at: i64| !matches!(side, Side::Runs { gap: Some(gap), .. } if now - at > gap);
            let contradicted = samples.last().is_some_and(|(at, value)| *value < 5 && is_current(*at));
            let Verdict::Satisfied(result) = world.ask(now) else {
                let known = matches!(side, Side::Points) || contradicted;
                prop_assert!(!quiet || !known, "not absent at {now}: {intervals:?}");
                continue;
            };
            let (from, to) = (result.interval.0.0, result.interval.1.0);
            let begins = from == 0 || intervals.iter().any(|(interval, _)| interval.1 == from);
            let inside = intervals.iter().any(|(interval, _)| interval.1 > from && interval.0 <= to);
            prop_assert!(begins && !inside && to == from + length && to <= now, "absent at {now}: {intervals:?}");
            prop_assert!(quiet || from < since, "absent at {now}: {intervals:?}");
            break;
        }
    }
}

/// Returns the number of results of its parts that an Allen relation keeps.
fn kept(world: &World) -> usize {
    let PartKind::Allen(leaf) = &world.monitor.root.kind else { return 0 };
    leaf.sides.iter().map(|side| side.settled.len()).sum()
}

/// Returns a trace of 2,000 samples of each variable: `a` holds at every third, `b` all the time, but never for long enough.
fn kept_over_a_long_trace(condition: &Condition) -> usize {
    let mut world = World::new(condition);
    let mut most = 0;
    for at in 0..2_000 {
        world.sample("a", "uav", Value::Integer(if at % 3 == 0 { 5 } else { 4 }), at);
        world.sample("b", "uav", Value::Integer(5), at);
        assert_eq!(world.answer(at), None);
        most = most.max(kept(&world));
    }
    most
}

#[test]
fn a_relation_that_never_holds_keeps_little() {
    let never = Side::Runs { gap: None, least: 1_000_000 };
    for relation in RELATIONS {
        for left in [Side::Points, Side::Runs { gap: None, least: 0 }] {
            let first = related(relation, 0, vec![left.condition("a"), never.condition("b")]);
            let second = related(relation, 0, vec![never.condition("b"), left.condition("a")]);
            let most = kept_over_a_long_trace(&first).max(kept_over_a_long_trace(&second));
            assert!(most <= 2 * SWEEP_AT_LEAST, "{relation:?} of {left:?} keeps {most} results");
        }
    }
}

#[test]
fn a_sample_that_comes_later_than_those_of_other_variables_is_related_as_well() {
    let points = |name: &str| Side::Points.condition(name);
    let mut world = World::new(&related(AllenRelation::Meets, 0, vec![points("a"), points("b")]));
    for at in 1..6 {
        world.sample("b", "uav", Value::Integer(5), at);
        assert_eq!(world.answer(at), None);
    }
    world.sample("a", "uav", Value::Integer(5), 1);
    assert_eq!(world.answer(6), Some((1, 1, 6)));
}
