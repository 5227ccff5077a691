//! Explanations: the reasons for which a task waits, is interrupted, or ended.

use crate::support::{camera, load, record};
use apex_model::time::Time;
use apex_runtime::explain::{Answer, Explainer, Question, Why};
use apex_runtime::program::NoDeliberator;
use apex_runtime::record::RecordReader;

fn why(reader: &RecordReader, name: &str, seconds: f64) -> Why {
    let question = Question::new(name, Time::from_seconds(seconds));
    match Explainer::new(reader, &load).why(&question).unwrap() {
        Answer::Task(why) => *why,
        other => panic!("{name} is not a task: {other}"),
    }
}

#[test]
fn why_a_task_waits_and_since_when() {
    let reader = camera().reader_kept();
    let waiting = why(&reader.0, "high", 2.0);
    assert_eq!(waiting.state, "pending");
    assert_eq!(waiting.waiting.len(), 1, "{waiting:?}");
    assert!(waiting.waiting[0].now.contains("(altitude ac-1) = 6500"), "{waiting:?}");
    assert_eq!(waiting.waiting[0].since, Some(1.0), "{waiting:?}");
    let text = waiting.to_string();
    assert!(text.contains("is pending at 2s") && text.contains("since 1s"), "{text}");
}

#[test]
fn why_a_task_is_interrupted_and_by_which_task() {
    let reader = camera().reader_kept();
    let interrupted = why(&reader.0, "patrol", 5.0);
    assert_eq!(interrupted.state, "interrupted");
    let blocked = interrupted.blocked.clone().unwrap();
    assert_eq!((blocked.goal.as_str(), blocked.resource.as_str()), ("(look-at fire)", "flight-path"));
    assert!((blocked.since - 3.5).abs() < 1e-9 && blocked.winner_priority > blocked.loser_priority);
    assert!(
        interrupted.to_string().contains("It lost the conflict over flight-path to T2 (look-at fire) at 3.5s"),
        "{interrupted}"
    );
    let later = why(&reader.0, "patrol", 10.0);
    assert_eq!((later.state.as_str(), later.blocked), ("ongoing", None));
}

#[test]
fn why_a_task_ended_and_what_an_ongoing_one_works_through() {
    let reader = camera().reader_kept();
    let ended = why(&reader.0, "look-at fire", 19.0);
    assert_eq!((ended.state.as_str(), ended.waiting.len()), ("terminated", 0));
    let last = ended.history.last().unwrap();
    assert!(last.because.contains("its duration of P5S is over"), "{ended}");
    let root = why(&reader.0, "T0", 2.0);
    assert_eq!(root.goal, "(do-domain)");
    assert!(root.subtasks.iter().any(|task| task.goal == "(patrol)" && task.state == "ongoing"), "{root}");
    let json = serde_json::to_value(&root).unwrap();
    assert_eq!(json["state"], "ongoing");
}

/// The goal after a failure exists only once the step has failed.
#[test]
fn why_not_states_that_a_goal_is_pursued_only_after_a_failure() {
    let program = r#"
(procedure
  (index (do-domain))
  (step d (fails soon) (on-failure (repair it)))
  (step done (end-application "repaired") (waitfor (end ?d))))
(procedure :sequential (index (fails soon)) (step one (idle)) (step two (terminate failure)))
(primitive (index (idle)) (duration 12s))
(primitive (index (repair it)) (duration 5s))
"#;
    let reader = record(program, Vec::new(), &mut NoDeliberator, &mut []).reader_kept();
    let why_not = |seconds: f64| {
        let question = Question::new("(repair ?x)", Time::from_seconds(seconds));
        Explainer::new(&reader.0, &load).why_not(&question).unwrap().to_string()
    };
    let before = why_not(5.0);
    assert!(before.starts_with("No task pursues (repair it) at 5s: T"), "{before}");
    assert!(before.contains("(fails soon) is ongoing, and leads to it only if it fails."), "{before}");
    let meanwhile = why_not(14.0);
    assert!(meanwhile.contains("(repair it) has started: it is ongoing since"), "{meanwhile}");
}
