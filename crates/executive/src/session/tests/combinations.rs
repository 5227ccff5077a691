//! A combination whose leaves are watched by episode indexes reports what it would report if its monitor received every sample.

use super::{at, of, read};
use crate::session::{Judgement, MonitorResult, MonitorSession};
use apex_model::host::HostFunctions;
use apex_model::value::Value;
use proptest::prelude::*;

const VARIABLES: [&str; 3] = ["x", "y", "slow"];

/// Generates an episode of one of the variables. Its duration and its greatest gap are multiples of half a second; a gap of 0 is not
/// constrained.
fn episode() -> impl Strategy<Value = String> {
    (0usize..16, 0i64..3, 0i64..5, 0i64..5).prop_map(|(which, bound, duration, gap)| {
        let variable = VARIABLES[if which == 15 { 2 } else { which % 2 }];
        let quality =
            if gap == 0 { ":no-constraints".to_string() } else { format!("(:max-gap {}s)", gap as f64 / 2.0) };
        let duration = duration as f64 / 2.0;
        format!(
            "(:episode ({variable} uav) :quality {quality} :value (> {bound}) :timing (:duration (>= {duration}s)))"
        )
    })
}

/// Generates trees of episodes. Orders have two parts and no `:not`, because a naive search would have too many combinations.
fn condition() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        3 => episode(),
        1 => episode().prop_map(|text| format!("(:not {text})")),
        1 => (episode(), episode()).prop_map(|(first, second)| format!("(:in-order {first} {second})")),
    ];
    leaf.prop_recursive(2, 5, 3, |inner| {
        (0usize..4, prop::collection::vec(inner, 1..3)).prop_map(|(kind, parts)| {
            let parts = parts.join(" ");
            match kind {
                0 | 1 => format!("(:and {parts})"),
                2 => format!("(:or {parts})"),
                _ => format!("(:and #whole {parts})"),
            }
        })
    })
}

/// Returns all results of `conditions` over samples of three variables, and the verdicts after each sample for which `asked` is true, and
/// at the end. Without `banks` each monitor receives every sample.
fn run(
    samples: &[(u8, i64, i64)],
    conditions: &[String],
    asked: &[bool],
    banks: bool,
) -> (Vec<MonitorResult>, Vec<Judgement>) {
    let (library, _) = read("(x uav = 1)");
    let mut session = MonitorSession::new(library, HostFunctions::default()).unwrap();
    session.without_banks = !banks;
    let watch = |text: &String| session.watch(read(text).1, at(1.0)).unwrap();
    let ids: Vec<_> = conditions.iter().map(watch).collect();
    let mut judgements = Vec::new();
    for (index, (which, value, half_seconds)) in samples.iter().enumerate() {
        let (variable, instant) = (of(VARIABLES[usize::from(*which) % 3]), at(*half_seconds as f64 / 2.0));
        if which % 2 == 0 {
            session.samples(&variable, &[instant], &[*value as f64]);
        } else {
            session.sample(&variable, Value::Integer(*value), instant);
        }
        if asked.get(index).copied().unwrap_or(false) {
            judgements.extend(ids.iter().filter_map(|id| session.verdict(*id)));
        }
    }
    session.advance(at(100.0));
    session.finish();
    judgements.extend(ids.iter().filter_map(|id| session.verdict(*id)));
    (session.take_results(), judgements)
}

/// Generates samples in order of time, except for the variable with lateness, whose samples may lie in the past.
fn samples() -> impl Strategy<Value = Vec<(u8, i64, i64)>> {
    (prop::collection::vec((0u8..6, -1i64..4, 0i64..60), 0..50), any::<bool>()).prop_map(|(mut samples, late)| {
        samples.sort_by_key(|(which, value, at)| if late && which % 3 == 2 { at + 2 * value } else { *at });
        samples
    })
}

#[test]
fn a_sample_from_before_the_present_takes_back_what_time_decided() {
    let text = "(:episode (x uav) :quality (:max-gap 2s) :value (> 0) :timing (:duration (>= 2s)))".to_string();
    let samples = [(0, 3, 43), (1, 0, 48), (0, 0, 47)];
    let (told, _) = run(&samples, std::slice::from_ref(&text), &[], true);
    assert_eq!(told.len(), 1, "{told:?}");
    assert_eq!(told, run(&samples, &[text], &[], false).0);
}

#[test]
fn an_end_that_was_reported_and_withdrawn_is_not_reported_again() {
    let text = "(:episode (x uav) :quality (:max-gap 1s) :value (> 0))".to_string();
    let samples = [(3, 1, 24), (0, 1, 26), (3, 0, 28), (2, -1, 30), (0, 1, 28), (0, 0, 32)];
    let (told, _) = run(&samples, std::slice::from_ref(&text), &[], true);
    assert_eq!(told.len(), 2, "{told:?}");
    assert_eq!(told, run(&samples, &[text], &[], false).0);
}

#[test]
fn what_another_alternative_left_over_is_reported_at_the_next_sample() {
    let text = "(:and (:or (:episode (x uav) :quality (:max-gap 1s) :value (> 0) :timing (:duration (>= 1s))) \
                (:not (:episode (y uav) :quality :no-constraints :value (> 0) :timing (:duration (>= 0s))))))";
    let samples = [(3, 1, 25), (1, 0, 27), (3, 0, 28)];
    let (told, _) = run(&samples, &[text.to_string()], &[], true);
    assert_eq!(told, run(&samples, &[text.to_string()], &[], false).0);
}

proptest! {
    #[test]
    fn banks_report_of_combinations_what_monitors_would_tell(
        samples in samples(),
        conditions in prop::collection::vec(condition(), 1..4),
        asked in prop::collection::vec(prop::bool::weighted(0.1), 50),
    ) {
        let (banked, judged) = run(&samples, &conditions, &asked, true);
        let (told, expected) = run(&samples, &conditions, &asked, false);
        prop_assert_eq!(banked, told);
        prop_assert_eq!(judged, expected);
    }
}
