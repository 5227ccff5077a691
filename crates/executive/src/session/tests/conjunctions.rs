//! Conjunctions of which only the first result for each set of bindings is needed: they keep few results, and agree with the definition.

use super::absent_orders::windows;
use super::point_orders::{results_over, stories};
use super::*;
use crate::state::monitors::monitor::PartKind;

/// Samples every 100 ms that satisfy each part, up to `end_s`.
fn waiting(condition: &str, end_s: i64) -> (MonitorSession, MonitorId) {
    let (plain, id) = session(condition, 0.0);
    let mut session = plain.over_a_log();
    for number in 0..end_s * 10 {
        session.sample(&of("speed"), Value::Real(5.0), Time(number * 100_000_000));
        session.sample(&of("height"), Value::Integer(number), Time(number * 100_000_000));
    }
    session.advance(at(end_s as f64));
    (session, id)
}

/// Returns the number of results that the whole monitor keeps.
pub(super) fn kept_anywhere(session: &MonitorSession, id: MonitorId) -> usize {
    let root = &session.watches.get(id.0).unwrap().monitor.as_ref().unwrap().root;
    format!("{root:?}").matches("recognised_at").count()
}

/// Returns the number of results that the samples of the parts keep.
fn kept(session: &MonitorSession, id: MonitorId) -> usize {
    let root = &session.watches.get(id.0).unwrap().monitor.as_ref().unwrap().root;
    let (PartKind::And(composite) | PartKind::InOrder(composite)) = &root.kind else { panic!("{root:?}") };
    let of_part = |part: &crate::state::monitors::monitor::Part| match &part.kind {
        PartKind::Measurement(leaf) => leaf.seen.as_ref().map_or(0, |seen| seen.settled.len()),
        _ => 0,
    };
    composite.parts.iter().map(of_part).sum()
}

#[test]
fn waiting_for_a_delay_keeps_one_sample_of_each_part() {
    for condition in [
        "(:and (speed uav > 4) (height uav >= 0) (:delay 300s))",
        "(:and (:delay 200s) (speed uav > 4) (height uav >= 0) (:delay 300s))",
        "(:in-order (speed uav > 4) (height uav >= 0) (:delay 300s))",
    ] {
        let (mut session, id) = waiting(condition, 290);
        assert!(kept(&session, id) <= 16, "{condition} keeps {}", kept(&session, id));
        session.advance(at(301.0));
        let found = told(&mut session);
        assert_eq!(found.len(), 1, "{condition}: {found:?}");
        assert!(found[0].ends_with("@300") || found[0].ends_with("@300.1"), "{condition}: {found:?}");
        assert!(session.take_troubles().is_empty(), "{condition}");
    }
}

#[test]
fn after_the_delay_no_sample_is_kept_for_a_result_that_cannot_come_again() {
    let (session, id) = waiting("(:and (speed uav > 4) (:delay 5s))", 100);
    assert!(kept(&session, id) <= 16, "{}", kept(&session, id));
}

/// A late sample may withdraw the newest results only.
#[test]
fn a_variable_with_lateness_keeps_the_results_that_may_be_withdrawn() {
    let (plain, id) = session("(:and (slow uav > 4) (height uav >= 0) (:delay 300s))", 0.0);
    let mut session = plain.over_a_log();
    let sample = |session: &mut MonitorSession, number: i64, value: f64| {
        session.sample(&of("slow"), Value::Real(value), Time(number * 100_000_000));
        session.sample(&of("height"), Value::Integer(number), Time(number * 100_000_000));
    };
    (1_000..2_000).for_each(|number| sample(&mut session, number, 5.0));
    // One sample of each part, and for some time twice as many as lie within the lateness of 5 s.
    assert!(kept_anywhere(&session, id) <= 120, "{}", kept_anywhere(&session, id));
    sample(&mut session, 1_950, 3.0);
    session.advance(at(301.0));
    let found = told(&mut session);
    assert_eq!(found, ["found 100..300 @300"]);
}

#[test]
fn an_absence_of_parts_together_with_a_delay_keeps_few_results() {
    for condition in [
        "(:absent (:and (speed uav > 4) (height uav >= 0) (:delay 300s)) :for 10s)",
        "(:absent (:and (speed uav > 4) (height uav >= 0) (:delay 20s)) :for 10s)",
        "(:absent (:and (speed uav > 4) (:timestamp (+ +mission-start+ 50s))) :for 10s)",
    ] {
        let (session, id) = waiting(condition, 200);
        assert!(kept_anywhere(&session, id) <= 40, "{condition} keeps {}", kept_anywhere(&session, id));
    }
}

#[test]
fn constraints_between_the_parts_need_every_sample() {
    let (session, id) =
        waiting("(:and (:measurement a (speed uav) :value (> 4)) (:delay 50s) :constraint (< 1 2))", 20);
    assert_eq!(kept(&session, id), 199);
}

/// Samples of both parts come every 0.1 s.
#[test]
fn limits_between_two_parts_need_few_samples() {
    let pair = "(:measurement a (speed uav) :value (> 4)) (:measurement b (height uav) :value (>= 0))";
    for (condition, most) in [
        (format!("{pair} (:delay 300s) :constraint (< (- (start-of ?b) (start-of ?a)) 5s)"), 20),
        (format!("{pair} (:delay 300s) :constraint (> (- (start-of ?b) (start-of ?a)) 5s)"), 120),
        (format!("{pair} (:delay 300s) :constraint (> (start-of ?b) (start-of ?a))"), 20),
        (format!("(:delay 300s) {pair} (landed) :constraint (<= -5s (- (start-of ?a) (end-of ?b)) )"), 20),
        (
            "(:measurement a (speed uav) :value (> 4)) (:measurement b (height uav) :value (< 0))
              :constraint (< (- (start-of ?b) (start-of ?a)) 5s)"
                .to_string(),
            120,
        ),
    ] {
        let condition = format!("(:and {condition})");
        let (mut session, id) = waiting(&condition, 200);
        assert!(kept(&session, id) <= most, "{condition} keeps {}", kept(&session, id));
        assert!(session.take_troubles().is_empty(), "{condition}");
    }
}

/// 600 results of each part would be 360,000 combinations at each evaluation, more than the limit.
#[test]
fn no_combination_is_tried_while_a_part_or_the_last_delay_is_to_come() {
    let parts = "(:measurement a (speed uav) :value (> 4)) (:measurement b (height uav) :value (>= 0)) (:delay 300s)";
    for form in [":and", ":in-order"] {
        let condition = format!("({form} {parts} :constraint (> (start-of ?b) (start-of ?a)))");
        let (mut session, _) = waiting(&condition, 60);
        let troubles = session.take_troubles();
        assert!(troubles.is_empty(), "{condition}: {troubles:?}");
    }
}

/// Results of a relation that rest on a delay are final: they are not computed again with each sample.
#[test]
fn a_relation_with_a_fixed_delay_has_only_final_results() {
    // Samples of the last seconds before the delay are kept for it.
    for (condition, count) in [
        ("(:before (speed uav > 4) (:delay 20s))", 200),
        ("(:after (:delay 20s) (stop))", 0),
        ("(:cotemporal (speed uav > 4) (:delay 20s) :tolerance 3s)", 61),
    ] {
        let (mut session, id) = waiting(condition, 40);
        assert_eq!(told(&mut session).len(), count, "{condition}");
        let root = &session.watches.get(id.0).unwrap().monitor.as_ref().unwrap().root;
        let PartKind::Allen(relation) = &root.kind else { panic!("{root:?}") };
        assert!(relation.passing.is_empty(), "{condition}: {}", relation.passing.len());
    }
}

const CONJUNCTIONS: [&str; 12] = [
    "(:and (a uav > 4) (b uav < 4) (:delay 9s)",
    "(:and (a ?who > 4) (b ?who > 4)",
    "(:and (a ?who > 4) (b ?else < 3) (:delay 5s)",
    "(:and (a uav = ?x) (b uav = ?x) (:delay 4s)",
    "(:and (:or (a uav > 5) (b uav < 2)) (a other > 3) (:delay 6s)",
    "(:and (:and (a uav > 4) (b uav > 2)) (:delay 9s) (go)",
    "(:and (:and (a ?who > 4) (b ?else > 2)) (a ?else < 4)",
    "(:and (a uav > 4) (:not (b uav > 6)) (:delay 7s)",
    "(:and (a ?who > 4) (:not (b ?who > 3)) (:delay 4s)",
    "(:and (:measurement first (a uav) :value (> 4)) (stop) (:delay 3s) (:delay 8s)",
    "(:and (:in-order (a ?who > 4) (b uav > 3) (:delay 3s)) (b ?who > 4)",
    "(:and (go) (a ?who > 2) (:or (b ?who < 3) (stop))",
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// A constraint that is always true keeps every result of the parts: every combination is tried at every evaluation.
    #[test]
    fn first_results_are_those_of_all_combinations(
        story in stories(), number in 0..CONJUNCTIONS.len(), late: bool, log: bool,
    ) {
        let swept = results_over(&format!("{})", CONJUNCTIONS[number]), &story, late, log);
        let tried = results_over(&format!("{} :constraint (< 1 2))", CONJUNCTIONS[number]), &story, late, true);
        prop_assert_eq!(swept, tried, "{}", CONJUNCTIONS[number]);
    }
}

/// Conjunctions with limits of the time between two parts.
const PAIRS: [&str; 12] = [
    "(:and (:measurement x (a uav) :value (> 4)) (:measurement y (b uav) :value (< 4)) :constraint (< (- (start-of ?y) (start-of ?x)) 3s)",
    "(:and (:measurement x (a uav) :value (> 4)) (:measurement y (b uav) :value (< 4)) (:delay 20s)
      :constraint (< (- (start-of ?y) (start-of ?x)) 3s) (> (- (start-of ?y) (start-of ?x)) -3s)",
    "(:and (:measurement x (a uav) :value (> 4)) (:delay 9s) (:measurement y (b uav) :value (< 4)) (go)
      :constraint (> (- (start-of ?y) (end-of ?x)) 4s)",
    "(:and (:measurement x (a uav) :value (> 4)) (:measurement y (b uav) :value (< 4)) (stop)
      :constraint (> (- (start-of ?x) (end-of ?y)) 4s)",
    "(:and (:measurement x (a ?who) :value (> 4)) (:measurement y (b ?who) :value (< 4)) (:delay 20s)
      :constraint (and (<= (- (start-of ?y) (start-of ?x)) 4s) (>= (- (start-of ?y) (start-of ?x)) 2s))",
    "(:and (:measurement x (a ?who) :value (> 4)) (:measurement y (a ?who) :value (< 3)) (b ?who > 4)
      :constraint (> (start-of ?y) (start-of ?x))",
    "(:and (:measurement x (a ?who) :value (> 4)) (:measurement y (a ?who) :value (< 3)) (b ?else > 4) (:delay 9s)
      :constraint (< (- (start-of ?y) (start-of ?x)) 9s) (> (start-of ?y) (start-of ?x))",
    "(:and (:measurement x (a uav) :value (= ?v)) (:measurement y (b uav) :value (= ?v)) (stop)
      :constraint (<= (- (start-of ?y) (start-of ?x)) 5s) (>= (- (start-of ?y) (start-of ?x)) -5s)",
    "(:and (:measurement x (a uav) :value (> 4)) (:measurement y (b uav) :value (< 4)) (:delay 12s)
      (:measurement v (a other) :value (> 4)) (:measurement w (b other) :value (< 4))
      :constraint (< (- (start-of ?y) (start-of ?x)) -2s) (= (- (start-of ?v) (start-of ?w)) 3s)",
    "(:and (:measurement x (a uav) :value (> 4)) (:measurement y (b uav) :value (< 4)) (:not (a other > 6)) (:delay 20s)
      :constraint (> -3s (- (start-of ?x) (start-of ?y)))",
    "(:and (:measurement x (a uav) :value (> 5)) (:measurement y (b uav) :value (> 5)) (:or (go) (b other > 6))
      :constraint (< (start-of ?y) (start-of ?x))",
    "(:and whole (:measurement x (a uav) :value (> 5)) (:measurement y (b uav) :value (> 5)) (:delay 9s)
      :constraint (<= (- (end-of ?y) (end-of ?x)) 0s)",
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(250))]

    /// Another constraint that is always true keeps every result of the parts.
    #[test]
    fn limits_between_parts_are_constraints(story in stories(), number in 0..PAIRS.len(), late: bool, log: bool) {
        let swept = results_over(&format!("{})", PAIRS[number]), &story, late, log);
        let tried = results_over(&format!("{} (< 1 2))", PAIRS[number]), &story, late, true);
        prop_assert_eq!(swept, tried, "{}", PAIRS[number]);
    }
}

/// The late sample lets the instants from 1 s on be evaluated again, after the delay was reached and a message came at 10 s. Up to 3 s
/// the delay, the message or the negated delay decides, whatever the episode is.
#[test]
fn a_late_sample_does_not_let_later_delays_and_messages_count_earlier() {
    let episode = "(:episode (a uav) :quality (:max-gap 2s) :value (> 3) :timing (:duration (>= 5s)))";
    for part in [
        format!("(:and {episode} (:delay 8s))"),
        format!("(:and {episode} (:delay 8s) :constraint (< 1 2))"),
        format!("(:and {episode} (:timestamp (+ +mission-start+ 8s)) :constraint (< 1 2))"),
        format!("(:and {episode} (go) :constraint (< 1 2))"),
        format!("(:and {episode} (:or (:delay 8s) (go)))"),
    ] {
        let (mut session, id) = session(&format!("(:absent {part} :for 3s)"), 0.0);
        session.event(Value::list([Value::symbol("go")]), at(10.0));
        assert_eq!(told(&mut session), ["found 0..3 @3"], "{part}");
        session.sample(&of("a"), Value::Real(5.0), at(1.0));
        session.advance(at(10.0));
        let verdict = session.verdict(id).unwrap().verdict;
        assert!(
            matches!(&verdict, Verdict::Satisfied(window) if window.interval == (at(0.0), at(3.0))),
            "{part}: {verdict:?}"
        );
    }
}

const ABSENCES: [&str; 7] = [
    "(:and (a uav > 4) (b uav < 4) (:delay 9s)",
    "(:and (:delay 4s) (a uav > 5)",
    "(:and (a ?who > 6) (:delay 3s 5s)",
    "(:and (go) (a uav > 6) (:delay 30s)",
    "(:and (:timestamp (+ +mission-start+ 20s)) (b uav < 2)",
    "(:and (:episode (a uav) :quality (:max-gap 2s) :value (> 3)) (:delay 8s)",
    "(:and (:episode (a uav) :quality :no-constraints :value (> 5)) (stop) (:delay 5s) (:delay 20s)",
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    /// A constraint that is always true lets the absence combine all results of the parts.
    #[test]
    fn absences_of_spans_are_those_of_all_combinations(
        story in stories(), number in 0..ABSENCES.len(), length in 1i64..12, late: bool,
    ) {
        let mut spans = results_over(&format!("(:absent {}) :for {length}s)", ABSENCES[number]), &story, late, true);
        let mut tried =
            results_over(&format!("(:absent {} :constraint (< 1 2)) :for {length}s)", ABSENCES[number]), &story, late, true);
        if late {
            [&mut spans.0, &mut tried.0].into_iter().for_each(windows);
        }
        prop_assert_eq!(spans, tried, "{} for {}s", ABSENCES[number], length);
    }

    /// Samples of a variable with `:lateness` arrive up to six seconds late; those of the other one in time.
    #[test]
    fn late_samples_change_first_results_as_they_change_all(
        story in proptest::collection::vec((0i64..3, 0i64..7, any::<bool>(), 0i64..8), 1..120), number in 0..LATE.len(), log: bool,
    ) {
        let run = |condition: &str, log: bool| {
            let (plain, id) = session(condition, 0.0);
            let mut session = if log { plain.over_a_log() } else { plain };
            let mut now = 0;
            for (step, late, slow, value) in &story {
                now += step;
                let at_s = if *slow { (now - late).max(0) } else { now };
                let object = if value % 2 == 0 { "uav" } else { "other" };
                let variable = StateVariable::new(Symbol::new(if *slow { "slow" } else { "a" }), Value::symbol(object));
                session.sample(&variable, Value::Integer(*value), at(at_s as f64));
                session.advance(at(now as f64));
            }
            session.finish();
            let verdict = format!("{:?}", session.verdict(id).unwrap().verdict);
            (told(&mut session), verdict)
        };
        let swept = run(&format!("{})", LATE[number]), log);
        let tried = run(&format!("{} :constraint (< 1 2))", LATE[number]), true);
        prop_assert_eq!(swept, tried, "{}", LATE[number]);
    }
}

const LATE: [&str; 4] = [
    "(:and (slow uav > 4) (:delay 40s)",
    "(:and (slow uav > 3) (a uav > 3) (:delay 20s)",
    "(:and (slow ?who > 3) (a ?who < 5) (:delay 60s)",
    "(:and (slow ?who = ?x) (a ?else = ?x)",
];
