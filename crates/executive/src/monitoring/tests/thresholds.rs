//! Monitors that receive only samples on their side of a bound give the verdicts of monitors that receive all.

use super::*;
use crate::state::clause::MonitorId;
use crate::state::interests::{Interests, Narrowed};
use crate::state::monitor_set::MonitorIds;
use apex_model::library::{Library, StateVariableDeclaration};
use apex_model::quantity::{Dimension, Quantity};
use proptest::prelude::*;

/// Attributes with samples in order only, and with samples that may be three late.
const ATTRIBUTES: [&str; 2] = ["prompt", "tardy"];

fn library() -> Library {
    let mut library = Library::default();
    let tardy = StateVariableDeclaration {
        unit: None,
        dimension: Dimension::NONE,
        value_type: None,
        lateness: Some(Value::Duration(Duration(3))),
        rate_per_s: None,
        place: Place::default(),
    };
    library.state_variables.insert(Symbol::new("tardy"), tardy);
    library
}

fn values() -> impl Strategy<Value = Value> {
    prop_oneof![
        4 => (-3..4_i64).prop_map(Value::Integer),
        3 => (-6..7_i64).prop_map(|halves| Value::Real(halves as f64 / 2.0)),
        1 => Just(Value::Real(-0.0)),
        1 => Just(Value::Real(f64::NAN)),
        1 => prop_oneof![Just(f64::INFINITY), Just(f64::NEG_INFINITY)].prop_map(Value::Real),
        1 => (-2..3_i64).prop_map(|seconds| Value::Duration(Duration(seconds))),
        1 => (0..3_i64).prop_map(|metres| Value::Quantity(Quantity::si(metres as f64, Dimension::LENGTH))),
        1 => Just(Value::symbol("idle")),
    ]
}

fn relations() -> impl Strategy<Value = Relation> {
    prop_oneof![
        Just(Relation::Greater),
        Just(Relation::GreaterOrEqual),
        Just(Relation::Less),
        Just(Relation::LessOrEqual),
        Just(Relation::Equal),
        Just(Relation::Different),
    ]
}

fn conditions() -> impl Strategy<Value = Condition> {
    let test = (relations(), values()).prop_map(|(relation, right)| compare(relation, constant(right)));
    let object = prop_oneof![4 => Just(word("uav")), 1 => Just(Pattern::Anonymous), 1 => Just(free("who"))];
    let late = proptest::option::weighted(
        0.1,
        (1..9_i64).prop_map(|at| compare(Relation::Less, constant(Value::Time(Time(at))))),
    );
    let persist = proptest::bool::weighted(0.1);
    let parts = (0..2_usize, object, proptest::collection::vec(test, 1..3), late, persist, proptest::bool::ANY);
    parts.prop_map(|(attribute, object, value, timestamp, persist, tag)| {
        let mut wanted = measurement(of(ATTRIBUTES[attribute], object), value);
        wanted.timestamp = timestamp.into_iter().collect();
        wanted.estimation = persist.then_some(apex_model::condition::Estimation::Persist(Some(span(2))));
        let kind = ConditionKind::Measurement(Arc::new(wanted));
        if tag { tagged("seen", kind) } else { condition(kind) }
    })
}

/// Generates samples: age now, attribute, value, and whether time advances after it.
fn samples() -> impl Strategy<Value = Vec<(i64, usize, Value, bool)>> {
    let late = prop_oneof![5 => Just(0_i64), 1 => 1..5_i64];
    proptest::collection::vec((late, 0..2_usize, values(), proptest::bool::weighted(0.7)), 1..14)
}

/// The same monitor twice: `routed` receives only the stimuli of the table of interests, the other one receives all.
struct Pair {
    routed: Monitor,
    told: Monitor,
}

fn tell(pairs: &mut [Pair], interests: &Interests, stimulus: &Stimulus, view: &TestView) {
    let Stimulus::Sample { variable, value, newest, .. } = stimulus else { return };
    let mut found = MonitorIds::new();
    interests.of_sample(variable, value, *newest, &mut found);
    for (number, pair) in pairs.iter_mut().enumerate() {
        notice(&mut pair.told, stimulus, view);
        if found.contains(&MonitorId(number as u64)) {
            notice(&mut pair.routed, stimulus, view);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]
    #[test]
    fn a_monitor_misses_nothing_that_matters(
        wanted in proptest::collection::vec((conditions(), 0..3_i64, proptest::option::weighted(0.3, 0..4_u64)), 1..9),
        samples in samples(),
    ) {
        let mut view = TestView { now: Time(3), library: library(), ..TestView::default() };
        prepare(&mut view.histories, &view.library, None);
        let mut interests = Interests::default();
        let mut pairs = Vec::new();
        for (condition, start, after_sequence) in &wanted {
            let window = Window { start: Time(2 + start), after_sequence: *after_sequence };
            let Ok(monitor) = create(condition, window, &view) else { continue };
            let narrowed = Narrowed { second: None, threshold: threshold(&monitor) };
            let interest = lasting_interest(&monitor).unwrap();
            interests.insert(&interest, narrowed, MonitorId(pairs.len() as u64));
            pairs.push(Pair { routed: monitor.clone(), told: monitor });
        }
        for (sequence, (late, attribute, value, over)) in (1..).zip(&samples) {
            let variable = StateVariable::new(Symbol::new(ATTRIBUTES[*attribute]), Value::symbol("uav"));
            let at = Time(view.now.0 - late);
            let recording = record_sample(&mut view.histories, &VariableIndex::new(&view.library), variable, value.clone(), at, sequence);
            if let Some(stimulus) = recording.stimulus {
                tell(&mut pairs, &interests, &stimulus, &view);
            }
            if !over {
                continue;
            }
            for (number, pair) in pairs.iter_mut().enumerate() {
                let (routed, told) = (verdict(&mut pair.routed, &view), verdict(&mut pair.told, &view));
                prop_assert_eq!(&routed, &told, "monitor {} at {}", number, view.now);
                prop_assert_eq!(take_troubles(&mut pair.routed), take_troubles(&mut pair.told));
                prop_assert_eq!(unmet(&pair.routed, &view), unmet(&pair.told, &view));
                if matches!(told, Verdict::Satisfied(_)) {
                    // A satisfied monitor is no longer watched.
                    let narrowed = Narrowed { second: None, threshold: threshold(&pair.routed) };
                    interests.remove(&lasting_interest(&pair.routed).unwrap(), narrowed, MonitorId(number as u64));
                    let (again, window) = (&wanted[number.min(wanted.len() - 1)].0, Window::from(Time(view.now.0 + 1)));
                    if let Ok(monitor) = create(again, window, &view) {
                        let narrowed = Narrowed { second: None, threshold: threshold(&monitor) };
                        interests.insert(&lasting_interest(&monitor).unwrap(), narrowed, MonitorId(number as u64));
                        *pair = Pair { routed: monitor.clone(), told: monitor };
                    }
                }
            }
            view.now = Time(view.now.0 + 1);
        }
    }
}
