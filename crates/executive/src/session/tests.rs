//! Streams of results: each result once and at its instant, in whatever portions the stimuli arrive.

mod absent_orders;
mod combinations;
mod conjunctions;
mod derived;
mod point_orders;

use super::*;
use crate::state::monitors::monitor::Verdict;
use apex_model::source::Place;
use apex_pdl::{CheckOptions, SourceText, check_conditions};
use proptest::prelude::*;

const DECLARATIONS: &str = "(state-variable (roll-angle ?a) :unit deg) (state-variable (slow ?a) :lateness 5s)";

fn session(condition: &str, created_at: f64) -> (MonitorSession, MonitorId) {
    let (library, condition) = read(condition);
    let mut session = MonitorSession::new(library, HostFunctions::default()).unwrap();
    let id = session.watch(condition, Time::from_seconds(created_at)).unwrap();
    (session, id)
}

fn read(text: &str) -> (Arc<Library>, Condition) {
    let source = |name: &str, text: &str| SourceText { name: name.to_string(), text: text.to_string() };
    let mut resolve = |_| Err("nothing is required".into());
    let options = CheckOptions { fragment: false, host: &[], resolve: &mut resolve };
    let mut read =
        check_conditions(vec![source("declarations", DECLARATIONS)], vec![source("condition", text)], options);
    assert!(!read.checked.has_errors(), "{:?}", read.checked.diagnostics);
    (Arc::new(read.checked.library), read.conditions.remove(0))
}

fn roll(object: &str) -> StateVariable {
    StateVariable::new(Symbol::new("roll-angle"), Value::symbol(object))
}

fn of(attribute: &str) -> StateVariable {
    StateVariable::new(Symbol::new(attribute), Value::symbol("uav"))
}

fn at(seconds: f64) -> Time {
    Time::from_seconds(seconds)
}

/// Returns `kind start..end @recognised` of all results so far.
fn told(session: &mut MonitorSession) -> Vec<String> {
    let text = |result: MonitorResult| {
        let kind = match result.telling {
            ResultEvent::Recognised { open: true } => "open",
            ResultEvent::Recognised { open: false } => "found",
            ResultEvent::Closed => "closed",
        };
        let ((start, end), known) = (result.result.interval, result.result.recognised_at);
        let bound = result.result.bindings.iter().map(|(name, value)| format!(" {name}={value}")).collect::<String>();
        format!("{kind} {}..{} @{}{bound}", start.seconds(), end.seconds(), known.seconds())
    };
    session.take_results().into_iter().map(text).collect()
}

#[test]
fn a_session_pursues_nothing_and_judges_as_without_probing() {
    let plain = "(:episode (roll-angle uav) :quality :no-constraints :value (> 15) :timing (:duration (>= 2s))";
    let streams = [format!("{plain})"), format!("{plain} :probing ((look at uav) 1s :count-limit 1))")].map(|text| {
        let (mut session, _) = session(&text, 0.0);
        for (second, value) in [20.0, 20.0, 20.0, 0.0, 20.0, 30.0, 30.0].into_iter().enumerate() {
            session.sample(&roll("uav"), Value::Real(value), at(second as f64));
            session.advance(at(second as f64 + 0.5));
        }
        told(&mut session)
    });
    let [without, with] = streams;
    assert_eq!(without, with);
    assert_eq!(with.len(), 3, "{with:?}");
}

#[test]
fn the_largest_gap_of_a_run_is_reported_when_asked_for() {
    let plain = "(:episode (roll-angle uav) :quality :no-constraints :value (> 15))";
    let long = "(:episode (roll-angle uav) :quality (:max-gap 5s) :value (> 15) :timing (:duration (>= 4s)))";
    for condition in [plain, long] {
        // Watched from the first sample on, as `apex monitor` does.
        let (session, _) = session(condition, 1.0);
        let mut session = session.with_gaps();
        for (second, value) in [(1.0, 20.0), (2.0, 21.0), (6.0, 22.0), (6.5, 23.0), (7.0, f64::NAN), (16.0, 3.0)] {
            session.sample(&roll("uav"), Value::Real(value), at(second));
            session.sample(&roll("other"), Value::Real(value), at(second));
        }
        session.finish();
        let results = session.take_results();
        let gaps = |result: &MonitorResult| {
            let told = result.gaps.iter().map(|gap| (gap.variable.clone(), gap.start.seconds(), gap.end.seconds()));
            told.collect::<Vec<_>>()
        };
        // The gap of 9.5 s behind it, where a sample is not a number, is not within the run.
        assert_eq!(gaps(results.last().unwrap()), [(roll("uav"), 2.0, 6.0)], "{condition}: {results:?}");
        let mut silent = session_over(condition);
        assert!(silent.take_results().iter().all(|result| result.gaps.is_empty()));
    }
}

#[test]
fn gaps_are_the_same_for_samples_that_come_as_arrays() {
    let condition = "(:episode (roll-angle uav) :quality :no-constraints :value (> 15))";
    let seconds = [1.0, 2.0, 6.0, 6.5, 7.0, 8.0, 9.0];
    let values = [20.0, 21.0, 22.0, 23.0, 3.0, 3.0, 3.0];
    let (session, _) = session(condition, 1.0);
    let mut session = session.with_gaps();
    session.samples(&roll("uav"), &seconds.map(at), &values);
    session.finish();
    let results = session.take_results();
    let lengths: Vec<_> = results.last().unwrap().gaps.iter().map(|gap| gap.length().seconds()).collect();
    assert_eq!(lengths, [4.0]);
}

fn session_over(condition: &str) -> MonitorSession {
    let (mut session, _) = session(condition, 0.0);
    for second in [1.0, 2.0, 6.0, 8.0] {
        session.sample(&roll("uav"), Value::Real(20.0), at(second));
    }
    session.finish();
    session
}

#[test]
fn each_run_is_reported_when_recognised_and_again_when_over() {
    let condition = "(:episode (roll-angle uav) :quality (:max-gap 2s) :value (> 15) :timing (:duration (>= 2s)))";
    let (mut session, id) = session(condition, 0.0);
    for (second, value) in [20.0, 20.0, 20.0, 20.0, 0.0, 20.0, 20.0, 0.0, 30.0, 30.0].into_iter().enumerate() {
        session.sample(&roll("uav"), Value::Real(value), at(second as f64));
    }
    session.advance(at(9.5));
    assert_eq!(told(&mut session), ["open 0..2 @2", "closed 0..3 @2"]);
    // Until the gap is too long the last value holds: the duration is reached without a sample.
    session.advance(at(60.0));
    assert_eq!(told(&mut session), ["open 8..9 @10"]);
    session.finish();
    assert_eq!(told(&mut session), ["closed 8..9 @10"]);
    assert_eq!(session.verdict(id).unwrap().results, 2);
}

#[test]
fn a_measurement_is_reported_for_each_sample_and_object() {
    let (mut session, _) = session("(roll-angle ?who > 15)", 1.0);
    for (object, value, instant) in
        [("a", 90.0, 0.5), ("a", 20.0, 1.0), ("b", 30.0, 1.0), ("a", 3.0, 2.0), ("a", 40.0, 3.0)]
    {
        session.sample(&roll(object), Value::Real(value), at(instant));
    }
    session.advance(at(3.0));
    // The same instant is over twice; samples that arrive for it afterwards are reported nevertheless.
    session.sample(&roll("b"), Value::Real(50.0), at(3.0));
    session.advance(at(3.0));
    let expected = ["found 1..1 @1 who=a", "found 1..1 @1 who=b", "found 3..3 @3 who=a", "found 3..3 @3 who=b"];
    assert_eq!(told(&mut session), expected);
}

#[test]
fn a_combination_begins_again_after_each_result() {
    let (mut session, _) = session("(:in-order (go ?n) (stop))", 0.0);
    for (second, form) in ["(go 1)", "(go 2)", "(stop)", "(stop)", "(go 3)", "(stop)"].into_iter().enumerate() {
        session.event(apex_pdl::read_value(form).unwrap(), at(second as f64));
    }
    session.advance(at(10.0));
    assert_eq!(told(&mut session), ["found 0..2 @2 n=1", "found 1..2 @2 n=2", "found 4..5 @5 n=3"]);
}

#[test]
fn alternatives_are_distinguished_and_absence_once() {
    let (mut session, _) = session("(:or (:and (x uav = 1) (y uav = 1)) (x uav = 1) (:not (z uav = 1)))", 0.0);
    session.sample(&of("z"), Value::Integer(0), at(0.0));
    session.sample(&of("x"), Value::Integer(1), at(1.0));
    session.sample(&of("y"), Value::Integer(1), at(2.0));
    session.sample(&of("y"), Value::Integer(1), at(3.0));
    session.advance(at(4.0));
    assert_eq!(told(&mut session), ["found 0..0 @0", "found 1..1 @1", "found 1..2 @2"]);
}

#[test]
fn of_relations_known_at_one_instant_the_earlier_parts_go_first() {
    let (mut session, id) =
        session("(:after (:measurement (x a) :value (< 1)) (:episode e (x ?o) :quality (:max-gap 2.5s)))", 0.0);
    let x = |object: &str| StateVariable::new(Symbol::new("x"), Value::symbol(object));
    // Time alone ends the run of b; the next sample ends those of a.
    for (object, value, instant) in [("b", 1, 0.5), ("a", 5, 2.0), ("a", 2, 7.0), ("a", 0, 11.0)] {
        session.sample(&x(object), Value::Integer(value), at(instant));
    }
    session.advance(at(11.0));
    let Some(Verdict::Satisfied(first)) = session.verdict(id).map(|judgement| judgement.verdict) else {
        panic!("it has been satisfied")
    };
    assert_eq!((first.interval, first.recognised_at), ((at(0.5), at(11.0)), at(11.0)));
}

#[test]
fn a_late_sample_makes_a_result_known_now() {
    let (mut session, _) = session("(slow uav > 10)", 0.0);
    for (value, instant) in [(20, 1.0), (0, 4.0), (30, 2.0), (0, 5.0), (20, 3.0), (40, 6.0)] {
        session.sample(&of("slow"), Value::Integer(value), at(instant));
    }
    session.advance(at(7.0));
    assert_eq!(told(&mut session), ["found 1..1 @1", "found 2..2 @4", "found 3..3 @5", "found 6..6 @6"]);
}

#[test]
fn a_late_sample_that_is_valid_at_the_beginning_counts() {
    let (mut session, _) =
        session("(:measurement (slow uav) :value (> 10) :estimation (:persist :with-timeout 3s))", 2.0);
    session.advance(at(4.0));
    session.sample(&of("slow"), Value::Integer(20), at(1.0));
    session.advance(at(5.0));
    assert_eq!(told(&mut session), ["found 1..1 @4"]);
}

#[test]
fn absence_counts_a_value_from_before_its_window_also_when_a_sample_comes_late() {
    let level = "(:measurement (level uav) :value (> 5) :estimation (:persist :with-timeout 3.5s))";
    let (mut session, _) = session(&format!("(:absent {level} :for 4s)"), 3.0);
    session.sample(&of("level"), Value::Integer(8), at(2.0));
    session.sample(&of("level"), Value::Integer(1), at(6.0));
    session.event(Value::list([Value::symbol("tick")]), at(12.0));
    // At 9.5 s the level was unknown; now it is known that it was low. The sample of value 8 is no longer kept.
    session.sample(&of("level"), Value::Integer(2), at(8.0));
    session.advance(at(13.0));
    assert_eq!(told(&mut session), ["found 5.500000001..9.500000001 @12"]);
}

#[test]
fn a_late_duplicate_counts_also_when_nothing_older_is_kept() {
    let (mut session, _) = session("(x uav < 5)", 0.0);
    for (value, instant) in [(5, 5.0), (5, 5.5), (5, 7.0)] {
        session.sample(&of("x"), Value::Integer(value), at(instant));
    }
    session.event(Value::list([Value::symbol("tick")]), at(7.5));
    session.sample(&of("x"), Value::Integer(4), at(7.0));
    session.sample(&of("x"), Value::Integer(3), at(7.5));
    session.advance(at(8.0));
    assert_eq!(told(&mut session), ["found 7..7 @7.5", "found 7.5..7.5 @7.5"]);
}

#[test]
fn a_watch_that_begins_later_looks_back_to_its_beginning() {
    let (library, condition) = read("(roll-angle uav > 15)");
    let mut session = MonitorSession::new(library, HostFunctions::default()).unwrap();
    for (value, instant) in [(20.0, 0.0), (21.0, 1.0), (22.0, 2.0)] {
        session.sample(&roll("uav"), Value::Real(value), at(instant));
    }
    session.advance(at(3.0));
    let id = session.watch(condition, at(1.0)).unwrap();
    assert_eq!(told(&mut session), ["found 1..1 @3", "found 2..2 @3"]);
    session.unwatch(id);
    session.sample(&roll("uav"), Value::Real(30.0), at(4.0));
    session.advance(at(5.0));
    assert_eq!(told(&mut session), Vec::<String>::new());
    assert_eq!(session.verdict(id), None);
}

#[test]
fn what_was_forgotten_makes_the_verdict_unknown() {
    let (library, condition) = read("(roll-angle uav > 15)");
    let mut session = MonitorSession::new(library, HostFunctions::default()).unwrap();
    for second in 0..10 {
        session.sample(&roll("uav"), Value::Real(0.0), at(f64::from(second)));
    }
    let id = session.watch(condition, at(1.0)).unwrap();
    let judgement = session.verdict(id).unwrap();
    assert_eq!(judgement.verdict, Verdict::Unknown);
    assert!(judgement.because[0].now.contains("older samples are no longer kept"), "{judgement:?}");
}

#[test]
fn a_gap_is_the_reason_of_an_unknown_verdict() {
    let (mut session, id) =
        session("(:episode (roll-angle uav) :quality (:max-gap 1s) :value (> 15) :timing (:duration (>= 5s)))", 0.0);
    for instant in [0.0, 1.0, 3.4, 4.0] {
        session.sample(&roll("uav"), Value::Real(20.0), at(instant));
    }
    session.advance(at(4.0));
    let judgement = session.verdict(id).unwrap();
    assert_eq!(judgement.verdict, Verdict::Unknown);
    assert!(judgement.because[0].now.contains("a gap of P2.4S > P1S cut it before"), "{judgement:?}");
}

#[test]
fn tasks_are_watched_when_their_tag_is_bound() {
    let (library, _) = read("(x uav = 1)");
    let condition = Condition {
        tag: None,
        kind: apex_model::condition::ConditionKind::TaskEnded(Symbol::new("s1")),
        place: Place::default(),
    };
    let mut session = MonitorSession::new(library, HostFunctions::default()).unwrap();
    let id = session.watch(condition, at(0.0)).unwrap();
    session.bind(Symbol::new("s1"), Value::Task(TaskId(7)));
    session.task_state(TaskId(8), TaskState::Terminated, at(1.0));
    session.task_state(TaskId(7), TaskState::Ongoing, at(2.0));
    session.advance(at(2.5));
    assert_eq!(session.verdict(id).unwrap().verdict, Verdict::NotSatisfied);
    session.task_state(TaskId(7), TaskState::Terminated, at(3.0));
    session.advance(at(4.0));
    assert_eq!(told(&mut session), ["found 3..3 @3"]);
}

#[test]
fn samples_that_no_condition_watches_are_instants_for_a_function_of_the_time() {
    let instants: Vec<Time> = [1.0, 5.0, 8.0, 9.0].map(at).into();
    for in_one_slice in [true, false] {
        let (mut session, _) = session("(:function (and (> +met+ 5s) (< +met+ 9s)))", 0.0);
        if in_one_slice {
            session.samples(&of("x"), &instants, &[0.0; 4]);
        } else {
            instants.iter().for_each(|at| assert!(session.sample(&of("x"), Value::Real(0.0), *at).is_some()));
        }
        session.advance(at(20.0));
        assert_eq!(told(&mut session), ["found 8..8 @8"]);
    }
}

#[test]
fn refused_samples_are_faults() {
    let (mut session, _) = session("(roll-angle uav > 15)", 0.0);
    session.sample(&roll("uav"), Value::symbol("steep"), at(1.0));
    assert!(session.take_troubles()[0].message.contains("was refused"));
}

const CONDITIONS: &[&str] = &[
    "(x uav > 1)",
    "(:episode (x uav) :quality (:max-gap 2s) :value (> 0) :timing (:duration (>= 3s)))",
    "(:episode (x uav) :quality (:max-gap 2s) :value (> 0) :timing (:duration (<= 2s)))",
    "(:episode (x ?o) :quality (:no-constraints) :value (> 1) :timing (:duration (> 1s)))",
    "(:in-order (x uav = 2) (:delay 2s) (y uav = 2))",
    "(:and (x ?o > 1) (y ?o > 1))",
    "(:and (x uav = 2) (:not (y uav = 2)))",
    "(:or (:delay 4s) (:measurement (y uav) :value (= 2) :estimation (:persist :with-timeout 2s)))",
];

/// Returns all results of all conditions over `samples`; `advances` are instants at which time is advanced in between.
fn run(samples: &[(u8, i8, i64)], advances: &[i64]) -> Vec<MonitorResult> {
    let mut session = MonitorSession::new(Arc::new(Library::default()), HostFunctions::default()).unwrap();
    for text in CONDITIONS {
        session.watch(read(text).1, at(1.0)).unwrap();
    }
    let mut advances = advances.to_vec();
    advances.sort_unstable();
    let mut advances = advances.into_iter().peekable();
    for (which, value, half_seconds) in samples {
        // Before the instant of the sample, all samples that were passed must count.
        while let Some(half) = advances.next_if(|half| half < half_seconds) {
            session.advance(at(half as f64 / 2.0));
        }
        let variable = of(if *which % 2 == 0 { "x" } else { "y" });
        session.sample(&variable, Value::Integer(i64::from(*value)), at(*half_seconds as f64 / 2.0));
    }
    session.advance(at(100.0));
    session.finish();
    session.take_results()
}

/// Returns all results of plain conditions over samples of one variable, passed in slices that are divided at `cuts`.
fn run_plain(
    samples: &[(i64, i64)],
    wanted: &[(i64, i64, i64)],
    cuts: &[bool],
    banks: bool,
) -> (Vec<MonitorResult>, Vec<Judgement>) {
    let mut session = MonitorSession::new(Arc::new(Library::default()), HostFunctions::default()).unwrap();
    session.without_banks = !banks;
    let mut ids = Vec::new();
    for (bound, duration, gap) in wanted {
        let quality = if *gap == 0 { ":no-constraints".to_string() } else { format!("(:max-gap {gap}s)") };
        let text =
            format!("(:episode (x uav) :quality {quality} :value (> {bound}) :timing (:duration (>= {duration}s)))");
        ids.push(session.watch(read(&text).1, at(0.0)).unwrap());
        ids.push(session.watch(read(&format!("(x uav > {bound})")).1, at(0.0)).unwrap());
    }
    let mut samples: Vec<(i64, i64)> = samples.to_vec();
    samples.sort_by_key(|(instant, _)| *instant);
    let mut judgements = Vec::new();
    let mut slice = (Vec::new(), Vec::new());
    for (index, (instant, value)) in samples.iter().enumerate() {
        slice.0.push(at(*instant as f64));
        slice.1.push(*value as f64);
        if cuts.get(index).copied().unwrap_or(true) {
            session.samples(&of("x"), &slice.0, &slice.1);
            slice = (Vec::new(), Vec::new());
            judgements.extend(ids.iter().filter_map(|id| session.verdict(*id)));
        }
    }
    session.samples(&of("x"), &slice.0, &slice.1);
    session.advance(at(200.0));
    session.finish();
    (session.take_results(), judgements)
}

proptest! {
    #[test]
    fn results_do_not_depend_on_how_often_time_is_advanced(
        mut samples in prop::collection::vec((0u8..2, 0i8..3, 0i64..40), 0..40),
        advances in prop::collection::vec(0i64..45, 0..20),
    ) {
        samples.sort_by_key(|(_, _, at)| *at);
        let told = run(&samples, &[]);
        prop_assert_eq!(&told, &run(&samples, &advances));
        let recognised = |result: &&MonitorResult| result.telling != ResultEvent::Closed;
        let sorted = told.iter().filter(recognised).is_sorted_by_key(|result| result.result.recognised_at);
        prop_assert!(sorted, "out of order: {:?}", told);
        for (index, result) in told.iter().enumerate() {
            prop_assert!(!told[index + 1..].contains(result), "reported twice: {:?}", result);
        }
    }

    #[test]
    fn banks_report_what_monitors_would_tell(
        samples in prop::collection::vec((0i64..60, -1i64..6), 0..60),
        wanted in prop::collection::vec((0i64..5, 0i64..8, 0i64..5), 1..6),
        cuts in prop::collection::vec(any::<bool>(), 60),
    ) {
        let (banked, judged) = run_plain(&samples, &wanted, &cuts, true);
        let (told, expected) = run_plain(&samples, &wanted, &cuts, false);
        prop_assert_eq!(banked, told);
        prop_assert_eq!(judged, expected);
    }
}
