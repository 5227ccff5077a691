//! Derived state variables against a computation over the whole lists of samples.

use super::*;

const INPUTS: [&str; 2] = ["x", "y"];

/// Samples `(instant, value)` of each input, in order of time, one per instant.
type Series = [Vec<(i64, i64)>; 2];

fn library_of(declarations: &str) -> Arc<Library> {
    let text = SourceText { name: "derived".to_string(), text: declarations.to_string() };
    let mut resolve = |_| Err("nothing is required".into());
    let options = CheckOptions { fragment: false, host: &[], resolve: &mut resolve };
    let checked = apex_pdl::check(vec![text], options);
    assert!(!checked.has_errors(), "{:?}", checked.diagnostics);
    Arc::new(checked.library)
}

/// Returns the derived samples that a session makes; with `advances` it is advanced to every sample's instant.
fn derived(declaration: &str, series: &Series, advances: bool) -> Vec<(i64, f64)> {
    let mut session = MonitorSession::new(library_of(declaration), HostFunctions::default()).unwrap().over_a_log();
    let mut samples: Vec<(i64, usize, i64)> = Vec::new();
    for (input, own) in series.iter().enumerate() {
        samples.extend(own.iter().map(|(at, value)| (*at, input, *value)));
    }
    samples.sort_unstable();
    for (instant, input, value) in samples {
        session.sample(&of(INPUTS[input]), Value::Integer(value), at(instant as f64));
        if advances && !series[1 - input].iter().any(|(other, _)| *other == instant) {
            session.advance(at(instant as f64));
        }
    }
    session.advance(at(1_000.0));
    assert_eq!(session.take_troubles(), []);
    let history = session.histories().get(&of("d"));
    let number = |value: &Value| value.as_number().unwrap().0;
    let pair = |sample: &crate::state::histories::history::Sample| (sample.at.seconds() as i64, number(&sample.value));
    history.map(|history| history.samples().map(pair).collect()).unwrap_or_default()
}

/// Returns the joined values by definition: at each instant of any input, the latest value of each, at most `most` old.
fn held(series: &Series, most: Option<i64>) -> Vec<(i64, f64)> {
    let latest = |own: &[(i64, i64)], at: i64| {
        let before = own.iter().rev().find(|(instant, _)| *instant <= at)?;
        most.is_none_or(|most| at - before.0 <= most).then_some(before.1 as f64)
    };
    joined(series, latest)
}

/// Returns the joined values by definition: at each instant of any input, the point on the line between neighbours at most `most` apart.
fn on_lines(series: &Series, most: i64) -> Vec<(i64, f64)> {
    let point = |own: &[(i64, i64)], at: i64| {
        let before = own.iter().rev().find(|(instant, _)| *instant <= at)?;
        let after = own.iter().find(|(instant, _)| *instant >= at)?;
        if after.0 == before.0 {
            return Some(before.1 as f64);
        }
        let share = (at - before.0) as f64 / (after.0 - before.0) as f64;
        (after.0 - before.0 <= most).then(|| before.1 as f64 + (after.1 - before.1) as f64 * share)
    };
    joined(series, point)
}

fn joined(series: &Series, value: impl Fn(&[(i64, i64)], i64) -> Option<f64>) -> Vec<(i64, f64)> {
    let instants: BTreeSet<i64> = series.iter().flatten().map(|(at, _)| *at).collect();
    let at = |at: i64| Some((at, (value(&series[0], at)? - value(&series[1], at)?).abs()));
    instants.into_iter().filter_map(at).collect()
}

fn series_of(samples: &[(usize, i64, i64)]) -> Series {
    let mut found = [BTreeMap::new(), BTreeMap::new()];
    for (input, at, value) in samples {
        found[*input].insert(*at, *value);
    }
    found.map(|own: BTreeMap<i64, i64>| own.into_iter().collect())
}

fn declaration(join: &str) -> String {
    // With lateness all samples are kept.
    format!("(state-variable (d ?o) :derived (abs (- (x ?o) (y ?o))) :join {join} :lateness 1s)")
}

proptest! {
    #[test]
    fn derived_samples_are_those_of_the_definition(
        samples in prop::collection::vec((0usize..2, 0i64..60, -9i64..10), 0..60),
        most in 1i64..12,
        advances in any::<bool>(),
    ) {
        let series = series_of(&samples);
        let limit = declaration(&format!("(:hold {most}s)"));
        prop_assert_eq!(derived(&limit, &series, advances), held(&series, Some(most)));
        prop_assert_eq!(derived(&declaration(":hold"), &series, advances), held(&series, None));
        let line = declaration(&format!("(:interpolate {most}s)"));
        let (computed, expected) = (derived(&line, &series, advances), on_lines(&series, most));
        prop_assert_eq!(computed.len(), expected.len(), "{:?} {:?}", computed, expected);
        for (one, other) in computed.iter().zip(&expected) {
            prop_assert!(one.0 == other.0 && (one.1 - other.1).abs() < 1e-9, "{:?} {:?}", one, other);
        }
    }
}

/// Returns the results of a session for `condition` over samples `(variable, value, seconds)`.
fn tells(declarations: &str, condition: &str, samples: &[(&str, Value, f64)]) -> Vec<String> {
    let mut session = MonitorSession::new(library_of(declarations), HostFunctions::default()).unwrap();
    session.watch(read(condition).1, Time::ZERO).unwrap();
    for (name, value, seconds) in samples {
        session.sample(&of(name), value.clone(), at(*seconds));
    }
    session.advance(at(100.0));
    session.finish();
    assert_eq!(session.take_troubles(), []);
    told(&mut session)
}

fn numbers<'a>(name: &'a str, values: &[f64]) -> Vec<(&'a str, Value, f64)> {
    (0..).zip(values).map(|(second, value)| (name, Value::Real(*value), f64::from(second))).collect()
}

#[test]
fn words_that_change_and_rates_are_derived_of_two_samples() {
    let modes = ["climb", "climb", "cruise", "cruise", "land"];
    let samples: Vec<_> =
        (0..).zip(modes).map(|(second, mode)| ("mode", Value::symbol(mode), f64::from(second))).collect();
    let changed = "(state-variable (new-mode ?a) :derived (changed (mode ?a)))";
    assert_eq!(tells(changed, "(new-mode uav = t)", &samples), ["found 2..2 @2", "found 4..4 @4"]);
    let rate =
        "(state-variable (height ?a) :unit m) (state-variable (climb ?a) :unit m/s :derived (rate-of (height ?a)))";
    let heights = numbers("height", &[0.0, 2.0, 8.0, 9.0]);
    assert_eq!(tells(rate, "(climb uav > 5)", &heights), ["found 2..2 @2"]);
}

#[test]
fn derived_variables_are_derived_of_derived_ones_at_the_same_instant() {
    let chain =
        "(state-variable (a ?o) :derived (+ (b ?o) (x ?o)) :join :hold) (state-variable (b ?o) :derived (* 10 (x ?o)))";
    let samples = numbers("x", &[1.0, 2.0]);
    assert_eq!(tells(chain, "(a uav = 22)", &samples), ["found 1..1 @1"]);
    assert_eq!(tells(chain, "(a uav = 12)", &samples), [""; 0]);
}

#[test]
fn a_variable_of_one_thing_is_joined_with_that_of_each_object() {
    let wind = "(state-variable (drift ?a) :derived (- (speed ?a) (wind area)) :join (:hold 9s))";
    let mut session = MonitorSession::new(library_of(wind), HostFunctions::default()).unwrap();
    session.watch(read("(drift ?who > 4)").1, Time::ZERO).unwrap();
    let speed = |object: &str| StateVariable::new(Symbol::new("speed"), Value::symbol(object));
    session.sample(&speed("one"), Value::Integer(9), at(1.0));
    session.sample(&speed("two"), Value::Integer(5), at(2.0));
    session.sample(&StateVariable::new(Symbol::new("wind"), Value::symbol("area")), Value::Integer(1), at(3.0));
    session.advance(at(4.0));
    assert_eq!(told(&mut session), ["found 3..3 @3 who=one"]);
}

#[test]
fn a_value_that_cannot_be_computed_is_named_once_and_counted() {
    let inverse = "(state-variable (inverse ?o) :derived (/ 1 (x ?o)))";
    let mut session = MonitorSession::new(library_of(inverse), HostFunctions::default()).unwrap();
    session.watch(read("(inverse uav > 0)").1, Time::ZERO).unwrap();
    for (name, value, seconds) in numbers("x", &[0.0, 0.0, 4.0]) {
        session.sample(&of(name), value, at(seconds));
    }
    session.advance(at(9.0));
    let troubles = session.take_troubles();
    assert_eq!(troubles.len(), 1, "{troubles:?}");
    assert!(
        troubles[0].message.contains("the derived state variable (inverse uav) has no value at 0s"),
        "{troubles:?}"
    );
    assert_eq!(session.histories().get(&of("inverse")).unwrap().missing_count, 2);
    assert_eq!(told(&mut session), ["found 2..2 @2"]);
}
