//! Orders of samples and messages: dropped points never make an answer false, and the chains agree with the definition.

use super::*;

const DELAYED: &str = "(:in-order (speed uav > 4) (:delay 90s 100s) (speed uav < 4))";

/// Samples at 50 Hz up to `end_s`: 5 before 100 s, 3 from then on.
fn slowing_down(session: &mut MonitorSession, end_s: i64) {
    for number in 0..end_s * 50 {
        let value = if number < 5_000 { 5.0 } else { 3.0 };
        session.sample(&of("speed"), Value::Real(value), Time(number * 20_000_000));
    }
    session.finish();
}

#[test]
fn what_was_forgotten_makes_an_order_unknown_not_false() {
    let (mut session, id) = session(DELAYED, 0.0);
    slowing_down(&mut session, 105);
    assert_eq!(session.verdict(id).unwrap().verdict, Verdict::Unknown);
    assert!(session.take_troubles()[0].message.contains("MONITOR_RESULTS_MAX"));
}

#[test]
fn over_a_log_nothing_is_forgotten() {
    let (plain, id) = session(DELAYED, 0.0);
    let mut session = plain.over_a_log();
    slowing_down(&mut session, 105);
    assert_eq!(told(&mut session), ["found 0..100 @100"]);
    assert_eq!(session.verdict(id).unwrap().results, 1);
    assert!(session.take_troubles().is_empty());
}

#[test]
fn without_a_greatest_delay_one_sample_stands_for_all() {
    // Ten times the kept number of samples, and the answer is still certain.
    let (mut session, id) = session("(:in-order (speed uav > 4) (:delay 90s) (landed))", 0.0);
    for number in 0..40_960 {
        session.sample(&of("speed"), Value::Real(5.0), Time(number * 20_000_000));
    }
    assert_eq!(session.verdict(id).unwrap().verdict, Verdict::NotSatisfied);
    session.event(Value::list([Value::symbol("landed")]), at(900.0));
    session.finish();
    assert_eq!(told(&mut session), ["found 0..900 @900"]);
    assert!(session.take_troubles().is_empty());
}

/// Of a run of n samples, some are kept, not the n (n + 1) / 2 pairs, and few are compared at each sample.
#[test]
fn an_order_with_episodes_and_a_delay_keeps_few_instants() {
    let episode = |timing: &str| format!("(:episode (speed uav) :quality :no-constraints :value (> 4) {timing})");
    let tagged = "(:episode x (speed uav) :quality :no-constraints :value (> 4))";
    let between = |limit: &str, end: &str| {
        let x = "(:measurement x (speed uav) :value (> 4)) (speed uav > 3)";
        format!("{x} (:measurement y (speed uav) :value (> 4)) {end} :constraint {limit}")
    };
    // Samples come every 0.1 s: those within a greatest duration or delay are kept.
    for (order, most) in [
        (format!("{} (:delay 300s) (landed)", episode("")), 20),
        (format!("{} (:delay 300s) (landed)", episode(":timing (:duration (>= 5s))")), 120),
        (format!("{} (:delay 300s) (landed)", episode(":timing (:duration (< 5s))")), 120),
        (format!("{} (:delay 300s) (landed)", episode(":timing (:duration (:range 1s 5s))")), 120),
        (format!("{} (:delay 1s 5s) (landed)", episode(":timing (:duration (< 5s))")), 320),
        (format!("{tagged} (:delay 300s) (landed) :constraint (< (duration-of ?x) 5s)"), 120),
        (
            "(:measurement x (speed uav) :value (> 4)) (:measurement y (speed uav) :value (< 4))
          :constraint (< (- (start-of ?y) (start-of ?x)) 5s)"
                .to_string(),
            120,
        ),
        (between("(< (- (start-of ?y) (start-of ?x)) 5s)", "(landed)"), 240),
        (between("(> (- (start-of ?y) (start-of ?x)) 5s)", "(landed)"), 160),
        (between("(< (- (start-of ?y) (start-of ?x)) 5s)", "(:delay 300s)"), 240),
        // The height has no sample after the first one, so another one may still come before the samples of the speed.
        ("(height uav >= 0) (speed uav > 4) (:delay 300s)".to_string(), 20),
    ] {
        let condition = format!("(:in-order {order})");
        let (plain, id) = session(&condition, 0.0);
        let mut session = plain.over_a_log();
        session.sample(&of("height"), Value::Integer(1), at(0.0));
        let mut greatest = 0;
        for number in 0..2_000 {
            session.sample(&of("speed"), Value::Real(5.0), Time(number * 100_000_000));
            if number % 100 == 0 {
                session.advance(Time(number * 100_000_000));
                greatest = greatest.max(super::conjunctions::kept_anywhere(&session, id));
            }
        }
        assert!(greatest <= most, "{condition} keeps {greatest}");
        assert!(session.take_troubles().is_empty(), "{condition}");
    }
}

/// A sample of `a` or `b` of an object, or a message.
#[derive(Clone, Debug)]
pub(super) enum Told {
    Sample(&'static str, &'static str, i64),
    Message(&'static str),
}

pub(super) fn stories() -> impl Strategy<Value = Vec<(i64, Told)>> {
    let sample = (prop_oneof![Just("a"), Just("b")], prop_oneof![Just("uav"), Just("other")], 0i64..8)
        .prop_map(|(attribute, object, value)| Told::Sample(attribute, object, value));
    let message = prop_oneof![Just("go"), Just("stop")].prop_map(Told::Message);
    let step = (prop_oneof![3 => Just(0i64), 5 => Just(1), 1 => Just(4)], prop_oneof![5 => sample, 1 => message]);
    proptest::collection::vec(step, 1..120).prop_map(|steps| {
        let mut now = 0;
        let later = |(step, told)| {
            now += step;
            (now, told)
        };
        steps.into_iter().map(later).collect()
    })
}

const ORDERS: [&str; 30] = [
    "(:in-order (a uav > 4) (:delay 2s 4s) (a uav < 4)",
    "(:in-order (a uav > 4) (a uav < 4)",
    "(:in-order (a uav > 4) (:delay 0s 3s) (b uav > 4)",
    "(:in-order (:delay 3s 9s) (a uav > 3) (:delay 1s 5s) (b other < 3)",
    "(:in-order (a uav > 4) (:delay 1s 4s) (b uav > 4) (:delay 1s 4s) (a uav < 4)",
    "(:in-order (a ?who > 4) (:delay 1s 4s) (b ?who > 4) (a ?who < 4)",
    "(:in-order (a ?who > 5) (b ?else > 5) (:delay 2s 5s) (a ?who < 3)",
    "(:in-order (go) (:delay 1s 6s) (a ?who < 4) (:delay 1s 6s) (stop)",
    "(:in-order (:measurement first (a uav) :value (> 4)) (:delay 3s) (b uav < 4) (:delay 1s 3s) (go)",
    // Parts without a variable between parts that share one, and parts whose samples may arrive before those of the part that they follow.
    "(:in-order (a ?who > 5) (b uav > 2) (:delay 3s) (a ?who < 3)",
    "(:in-order (go) (a uav > 3) (b uav > 3) (:delay 3s) (stop)",
    "(:in-order (b ?who > 5) (a ?else > 3) (b uav < 5) (:delay 2s) (a ?who < 3)",
    // Delays at the end.
    "(:in-order (a uav > 4) (b uav < 4) (:delay 5s)",
    "(:in-order (a ?who > 4) (:delay 1s 3s) (b ?else > 3) (:delay 4s)",
    "(:in-order (a uav > 4) (:delay 2s 4s) (b other > 2) (:delay 3s) (:delay 3s)",
    "(:in-order (go) (:delay 1s) (a ?who < 4) (:delay 9s 12s)",
    // Episodes of any two samples.
    "(:in-order (:episode (a uav) :quality :no-constraints :value (> 3)) (:delay 2s 4s) (b uav < 4)",
    "(:in-order (:episode (a uav) :quality (:max-gap 2s) :value (> 2) :timing (:duration (> 1s))) (:delay 1s 3s)
      (:episode (b uav) :quality :no-constraints :value (> 2))",
    "(:in-order (:episode first (a uav) :quality :no-constraints :value (> 2) :timing (:duration (>= 2s))) (:delay 1s)
      (:episode then (a uav) :quality :no-constraints :value (< 5) :timing (:duration (>= 1s))) (go)",
    "(:in-order (go) (:delay 0s 3s) (:episode (a uav) :quality :no-constraints :value (> 2) :first-value (> 4)) (:delay 2s)",
    "(:in-order (:episode (a uav) :quality :no-constraints :value (> 2) :last-value (< 5)) (:delay 0s 2s) (a uav > 4)
      (:delay 1s 6s) (:episode (b uav) :quality (:max-gap 3s) :value (> 1) :timing (:duration (>= 2s)))",
    "(:in-order (:delay 3s 9s) (:episode (a uav) :quality :no-constraints :value (> 2) :timing (:duration (>= 3s)))
      (:delay 4s)",
    "(:in-order (:episode (a uav) :quality :no-constraints :value (> 1)) (:delay 1s 4s)
      (:episode (b uav) :quality :no-constraints :value (> 1)) (:delay 1s 4s)
      (:episode (a uav) :quality (:max-gap 2s) :value (< 6))",
    "(:in-order (:episode (a uav) :quality (:max-gap 1s) :value (> 1) :any) (b uav > 3)
      (:episode (a uav) :quality :no-constraints :value (> 1) :timing (:duration (> 2s)) :any)",
    // Greatest durations.
    "(:in-order (:episode (a uav) :quality :no-constraints :value (> 2) :timing (:duration (<= 3s))) (:delay 1s) (b uav < 4)",
    "(:in-order (a uav > 5) (:delay 0s 9s) (:episode (a uav) :quality (:max-gap 4s) :value (> 1) :timing (:duration (:range 2s 4s)))
      (:delay 2s) (go)",
    "(:in-order (:episode (a uav) :quality :no-constraints :value (> 1) :first-value (> 3) :timing (:duration (< 4s) (> 1s)))
      (:delay 1s 5s) (:episode (b uav) :quality :no-constraints :value (> 1) :last-value (< 4) :timing (:duration (= 2s)))",
    "(:in-order (:episode (a uav) :quality :no-constraints :value (> 1) :timing (:duration (<= 5s) (>= 5s))) (:delay 3s)",
    "(:in-order (go) (:delay 0s 4s) (:episode (a uav) :quality :no-constraints :value (> 1) :timing (:duration (< 3s))) (:delay 0s 2s)
      (:episode (a uav) :quality :no-constraints :value (< 7) :timing (:duration (:max 2s)))",
    "(:in-order (:episode (a uav) :quality (:max-gap 2s) :value (> 1) :timing (:duration (< 5s)) :any) (b uav > 3)
      (:episode (a other) :quality :no-constraints :value (> 1) :timing (:duration (< 2s)) :any)",
];

/// Orders with constraints on the time between neighbours.
const CONSTRAINED: [&str; 15] = [
    "(:in-order (:measurement x (a uav) :value (> 4)) (:measurement y (b uav) :value (< 4))
      :constraint (< (- (start-of ?y) (end-of ?x)) 3s)",
    "(:in-order (:measurement x (a uav) :value (> 4)) (:delay 1s) (:measurement y (b uav) :value (< 4)) (go)
      :constraint (>= 4s (- (start-of ?y) (start-of ?x)))",
    "(:in-order (:measurement x (a ?who) :value (> 3)) (:measurement y (b ?who) :value (> 3)) (:measurement z (a ?who) :value (< 4))
      :constraint (<= (- (start-of ?y) (end-of ?x)) 4s) (> (- (start ?z) (end ?y)) 2s)",
    "(:in-order (:episode x (a uav) :quality :no-constraints :value (> 2)) (:delay 1s) (:episode y (b uav) :quality :no-constraints :value (> 2))
      :constraint (and (< (duration-of ?x) 4s) (<= 1s (duration-of ?y))) (<= (- (start-of ?y) (end-of ?x)) 5s)",
    "(:in-order (:episode x (a uav) :quality (:max-gap 3s) :value (> 1)) (:delay 0s 9s) (:measurement y (b uav) :value (> 2)) (:delay 3s)
      :constraint (= (- (end-of ?x) (start-of ?x)) 3s)",
    "(:in-order whole (:measurement x (a uav) :value (> 4)) (:measurement y (b uav) :value (< 4))
      :constraint (< (- (end-of ?whole) (start-of ?whole)) 3s)",
    "(:in-order (:measurement x (a uav) :value (> 4)) (go) (:measurement y (b uav) :value (< 4))
      :constraint (< (- (start-of ?y) (start-of ?x)) 6s)",
    // Limits between parts that are not neighbours.
    "(:in-order (:measurement x (a uav) :value (> 4)) (b uav > 3) (:measurement z (a uav) :value (< 4)) (:delay 9s)
      :constraint (<= (- (start-of ?z) (start-of ?x)) 4s)",
    "(:in-order (:measurement x (a uav) :value (> 5)) (b uav > 5) (:measurement z (a uav) :value (< 3)) (go)
      :constraint (<= (- (start-of ?z) (start-of ?x)) 4s)",
    "(:in-order (:measurement x (a uav) :value (> 4)) (b uav > 4) (:measurement z (b uav) :value (< 4)) (:delay 3s)
      :constraint (> (- (start-of ?z) (start-of ?x)) 9s)",
    "(:in-order (:measurement x (a ?who) :value (> 4)) (b ?who > 3) (:measurement z (a ?who) :value (< 4)) (stop)
      :constraint (< (- (start-of ?z) (start-of ?x)) 5s)",
    "(:in-order (b ?else > 6) (:measurement x (a ?who) :value (> 4)) (b ?else > 4) (:measurement z (b ?who) :value (< 4)) (:delay 5s)
      :constraint (>= (- (start-of ?z) (start-of ?x)) 6s)",
    "(:in-order (go) (:measurement x (a uav) :value (> 4)) (b uav > 5) (:delay 0s 3s) (:measurement z (a uav) :value (< 4)) (stop)
      :constraint (and (< (- (start-of ?z) (start-of ?x)) 7s) (> (- (start-of ?z) (start-of ?x)) 3s))",
    "(:in-order (:measurement w (a uav) :value (> 4)) (:measurement x (b uav) :value (> 4)) (:measurement y (a uav) :value (< 4))
      (:measurement z (b uav) :value (< 4)) (:delay 4s)
      :constraint (< (- (start-of ?y) (start-of ?w)) 6s) (< (- (start-of ?z) (start-of ?x)) 6s)",
    "(:in-order (:measurement w (a uav) :value (> 3)) (:measurement x (b uav) :value (> 3)) (:measurement y (a uav) :value (< 5))
      (:measurement z (b uav) :value (< 5)) (:delay 4s)
      :constraint (> -5s (- (start-of ?w) (start-of ?y))) (< (- (start-of ?z) (start-of ?w)) 9s) (> (start-of ?z) (end-of ?x))",
];

/// Returns the results of `condition` over `story`; with `late`, the samples of each variable arrive after those of the preceding one.
pub(super) fn results_over(condition: &str, story: &[(i64, Told)], late: bool, log: bool) -> (Vec<String>, String) {
    let (plain, id) = session(condition, 0.0);
    let mut session = if log { plain.over_a_log() } else { plain };
    let mut story = story.to_vec();
    if late {
        story.sort_by_key(|(at, told)| match told {
            Told::Sample(attribute, object, _) => (format!("{attribute} {object}"), *at),
            Told::Message(_) => (String::new(), *at),
        });
    }
    for (second, told) in story {
        match told {
            Told::Sample(attribute, object, value) => {
                let variable = StateVariable::new(Symbol::new(attribute), Value::symbol(object));
                session.sample(&variable, Value::Integer(value), at(second as f64));
            }
            Told::Message(word) => session.event(Value::list([Value::symbol(word)]), at(second as f64)),
        }
    }
    session.finish();
    let verdict = session.verdict(id).unwrap();
    let word = match verdict.verdict {
        Verdict::Satisfied(first) => format!("{:?}", first.interval),
        other => format!("{other:?}"),
    };
    (told(&mut session), word)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    /// A constraint that is always true keeps an order from being swept: every combination is tried at every evaluation.
    #[test]
    fn chains_are_those_of_all_combinations(story in stories(), number in 0..ORDERS.len(), late: bool, log: bool) {
        let swept = results_over(&format!("{})", ORDERS[number]), &story, late, log);
        let tried = results_over(&format!("{} :constraint (< 1 2))", ORDERS[number]), &story, late, true);
        prop_assert_eq!(swept, tried, "{}", ORDERS[number]);
    }

    #[test]
    fn limits_between_neighbours_are_constraints(story in stories(), number in 0..CONSTRAINED.len(), late: bool, log: bool) {
        let swept = results_over(&format!("{})", CONSTRAINED[number]), &story, late, log);
        let tried = results_over(&format!("{} (< 1 2))", CONSTRAINED[number]), &story, late, true);
        prop_assert_eq!(swept, tried, "{}", CONSTRAINED[number]);
    }
}
