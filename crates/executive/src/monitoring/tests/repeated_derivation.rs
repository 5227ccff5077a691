//! Deriving once more from samples of an instant, against the count that replaces it.

use super::*;
use crate::monitoring::derivation::{Changed, Surroundings, derive, due_by_every_input, repetition};
use crate::state::histories::history::{Histories, OpenLog};
use apex_model::agent_limits::Limits;
use apex_model::host::HostFunctions;
use apex_model::library::Library;
use proptest::prelude::*;

/// `(b ?o)` reads two variables, `(c ?o)` reads `(b ?o)`, and `(e ?o)` has no value where `(y ?o)` is zero.
const DECLARATIONS: &str = "(state-variable (x ?o) :lateness 3s) (state-variable (y ?o) :lateness 3s)
    (state-variable (b ?o) :derived (- (x ?o) (y ?o)) :join JOIN :lateness 3s)
    (state-variable (c ?o) :derived (+ (b ?o) (rate-of (b ?o))))
    (state-variable (e ?o) :derived (/ 1 (y ?o)))
    (state-variable (w ?o) :derived (list (x ?o) (x base)) :join :hold)";

fn library(join: &str) -> Library {
    let text = DECLARATIONS.replace("JOIN", join);
    let text = apex_pdl::SourceText { name: "derived".to_string(), text };
    let mut resolve = |_| Err("nothing is required".into());
    let options = apex_pdl::CheckOptions { fragment: false, host: &[], resolve: &mut resolve };
    let checked = apex_pdl::check(vec![text], options);
    assert!(!checked.has_errors(), "{:?}", checked.diagnostics);
    checked.library
}

/// Samples of an instant: input, object, instant, value; the value 9 is not a number.
type Samples = Vec<(usize, usize, i64, i64)>;

fn samples() -> impl Strategy<Value = Vec<Samples>> {
    let sample = (0..2_usize, 0..2_usize, 0..4_i64, -1..10_i64);
    proptest::collection::vec(proptest::collection::vec(sample, 1..5), 1..14)
}

/// Records the samples instant by instant; returns the number of instants at which a repetition is counted, and at which it is not.
fn compare(library: &Library, instants: &[Samples], is_logged: bool) -> (usize, usize) {
    let (index, host, limits, name) =
        (VariableIndex::new(library), HostFunctions::default(), Limits::default(), Symbol::new("agent"));
    let surroundings = Surroundings { library, index: &index, host: &host, agent: &name, limits: &limits };
    let object = |number: usize| Value::symbol(["uav", "base"][number]);
    let mut histories = Histories::default();
    if is_logged {
        for attribute in ["b", "c", "w"] {
            let variable = StateVariable::new(Symbol::new(attribute), object(0));
            let (spacing, time) = (Duration::from_seconds(3.0), Duration::MAX);
            histories.open_log(OpenLog { variable, spacing, time, count: 100 });
        }
    }
    let (mut arrivals, mut counts) = (0, (0, 0));
    for (second, samples) in (0..).zip(instants) {
        let mut changed = Vec::new();
        for (input, number, back, value) in samples {
            let variable = StateVariable::new(Symbol::new(["x", "y"][*input]), object(*number));
            let value = if *value == 9 { Value::Real(f64::NAN) } else { Value::Integer(*value) };
            let at = Time::from_seconds(f64::from(second)) - Duration::from_seconds(*back as f64);
            arrivals += 1;
            let recording = record_sample(&mut histories, &index, variable.clone(), value, at, arrivals);
            changed.extend(recording.stimulus.map(|_| Changed { variable, at }));
        }
        let mut next = || {
            arrivals += 1;
            arrivals
        };
        let derived = derive(changed.clone(), &mut histories, &surroundings, &mut next);
        let Some(count) = repetition(&derived, &histories) else {
            counts.1 += 1;
            continue;
        };
        counts.0 += 1;
        let noticed = derived.iter().filter(|each| each.recording.stimulus.is_some());
        changed.extend(noticed.map(|each| Changed { variable: each.variable.clone(), at: each.at }));
        let (mut twin, mut counted) = (histories.clone(), 0);
        let again = derive(changed, &mut twin, &surroundings, &mut || {
            counted += 1;
            arrivals + counted
        });
        assert_eq!((counted, &twin), (count, &histories), "{derived:?}");
        let silent = |recording: &crate::monitoring::memory::histories::Recording| {
            recording.stimulus.is_none() && recording.trouble.is_none() && !recording.overflows
        };
        assert!(again.iter().all(|each| silent(&each.recording)), "{again:?}");
    }
    counts
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn a_counted_repetition_changes_nothing_else(instants in samples(), join in 0..3_usize, is_logged: bool) {
        let library = library([":hold", "(:hold 2s)", "(:interpolate 3s)"][join]);
        compare(&library, &instants, is_logged);
    }
}

#[test]
fn samples_in_order_are_counted_and_late_ones_are_derived_again() {
    let library = library(":hold");
    let in_order: Vec<Samples> = (1..6).map(|value| vec![(0, 0, 0, value), (1, 0, 0, value)]).collect();
    assert_eq!(compare(&library, &in_order, false), (5, 0));
    assert_eq!(compare(&library, &in_order, true), (0, 5), "a log may thin its samples meanwhile");
    let mut late = in_order;
    late.push(vec![(0, 0, 2, 7)]);
    assert_eq!(compare(&library, &late, false), (5, 1));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn inputs_that_add_nothing_are_skipped(instants in samples(), join in 0..3_usize) {
        let library = library([":hold", "(:hold 2s)", "(:interpolate 3s)"][join]);
        let index = VariableIndex::new(&library);
        let mut histories = Histories::default();
        for (second, samples) in (0..).zip(&instants) {
            let mut changed = Vec::new();
            for (sequence, (input, number, back, value)) in (0..).zip(samples) {
                let object = Value::symbol(["uav", "base"][*number]);
                let variable = StateVariable::new(Symbol::new(["x", "y"][*input]), object);
                let at = Time::from_seconds(f64::from(second)) - Duration::from_seconds(*back as f64);
                let value = Value::Integer(*value);
                record_sample(&mut histories, &index, variable.clone(), value, at, sequence);
                changed.push(Changed { variable, at });
            }
            for derivation in library.derivations.values() {
                let reads = |changed: &Changed| -> Vec<(usize, Changed)> {
                    let inputs = derivation.inputs.iter().enumerate();
                    let own = inputs.filter(|(_, input)| input.attribute == changed.variable.attribute);
                    own.map(|(number, _)| (number, changed.clone())).collect()
                };
                let changes: Vec<_> = changed.iter().flat_map(reads).collect();
                let [all, due] = due_by_every_input(derivation, &changes, &histories);
                prop_assert_eq!(all, due);
            }
        }
    }
}
