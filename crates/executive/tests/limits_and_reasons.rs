//! A program that never comes to rest is stopped and reported; a waiting task states its reasons.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test stops at an unexpected result")]

mod support;

use apex_executive::explanation::{ReasonKind, agenda, describe_task, waiting};
use apex_model::event::{Event, EventKind, SolverReport};
use apex_model::task::{Outcome, TaskId, TaskState};
use support::{agent, answer, lines, message, printed, run, run_from, sample, seconds, story};

fn ends_with_limit(pdl: &str, limit: &str) {
    let mut agent = agent(pdl);
    let effects = run(&mut agent, &[message(1.0, "(go)")], 5.0);
    let told = effects.iter().any(|(_, effect)| match effect {
        apex_model::effect::Effect::Decided(decision) => decision.because.cause.text().contains(limit),
        _ => false,
    });
    assert!(told, "{:#?}", story(&effects).iter().rev().take(5).collect::<Vec<_>>());
}

#[test]
fn a_procedure_that_calls_itself_ends_with_a_cause() {
    let pdl = "(procedure (index (do-domain)) (step go (again 0)))
      (procedure (index (again ?n)) (step deeper (again ,(+ ?n 1))))
      (procedure (index (again -1)))";
    ends_with_limit(pdl, "TASK_DEPTH_MAX");
}

#[test]
fn a_loop_that_takes_no_time_ends_with_a_cause() {
    let pdl = "(procedure (index (do-domain)) (step a (tick) (waitfor (go)) (repeating :enabled)))
      (primitive (index (tick)))";
    ends_with_limit(pdl, "REPETITIONS_PER_INSTANT_MAX");
}

#[test]
fn two_tasks_that_wake_each_other_at_one_instant_are_stopped() {
    let pdl = "(procedure (index (do-domain))
      (step a (inform (pong)) (waitfor (ping)) (responding :until (> +met+ 1h)))
      (step b (inform (ping)) (waitfor (pong)) (responding :until (> +met+ 1h)))
      (step c (inform (ping)) (waitfor (go)))
      (step d (terminate) (waitfor (bye))))";
    ends_with_limit(pdl, "REPETITIONS_PER_INSTANT_MAX");
}

/// Each turn of the loop sends a message, so that the message that keeps the loop going is dropped before any other limit is reached.
#[test]
fn a_loop_without_time_that_ends_by_forgetting_reports_it() {
    let pdl =
        "(procedure (index (do-domain)) (step a (talk) (repeating :enabled)) (step d (terminate) (waitfor (bye))))
      (procedure (index (talk)) (step a (inform (tick)) (waitfor (go))) (step b (inform (tock)) (waitfor (go))))";
    ends_with_limit(pdl, "EVENT_HISTORY_MAX");
    let mut agent = agent(pdl);
    let few: Vec<_> = (0..900).map(|_| message(1.0, "(other)")).collect();
    let told = story(&run(&mut agent, &few, 5.0));
    assert!(told.iter().all(|line| !line.contains("forgotten")), "{:?}", told.last());
}

#[test]
fn a_chain_of_steps_without_time_is_as_long_as_it_is_written() {
    let steps: String = (0..12_000).map(|number| format!("(step (work {number}))\n")).collect();
    let pdl = format!("(procedure :sequential (index (do-domain)) {steps}) (primitive (index (work ?n)))");
    let mut agent = agent(&pdl);
    let effects = run(&mut agent, &[], 1.0);
    assert!(agent.is_finished());
    let told = story(&effects);
    assert!(told.iter().all(|line| !line.contains("CASCADE_ROUNDS_MAX")), "{:?}", told.last());
    // The steps, the end that every sequence has, and the root.
    assert_eq!(told.iter().filter(|line| line.ends_with("terminated")).count(), 12_002);
}

#[test]
fn suspending_and_resuming_without_end_is_stopped() {
    let pdl = "(procedure (index (do-domain)) (step a (work)) (step stop (terminate) (waitfor (bye))))
      (procedure (index (work)) (step p (pause))
        (suspend-when (task-state +this-task+ = ongoing) until (task-state +this-task+ = interrupted)))
      (primitive (index (pause)) (duration 100s))";
    let mut agent = agent(pdl);
    let effects = run(&mut agent, &[message(1.0, "(bye)")], 5.0);
    assert!(story(&effects).len() < 200_000, "the instant came to rest");
}

#[test]
fn a_rising_urgency_takes_the_resource_at_its_crossing() {
    let pdl = "(procedure (index (do-domain))
      (step calm (use) (priority 4)) (step urgent (use) (priority :urgency 2 :importance 8)))
      (primitive (index (use)) (profile tool) (duration 1000s))";
    let mut agent = agent(pdl);
    let effects = run(&mut agent, &[], 0.0);
    assert_eq!(lines(&effects, &["calm", "urgent"]).last().unwrap(), "0s calm ongoing");
    let (at, why) = agent.next_wake().unwrap();
    assert!(why.contains("rising priority of T2 (urgent)"), "{why}");
    assert!(at > seconds(0.0) && at < seconds(128.0));
    let effects = run_from(&mut agent, &[], at, at.seconds());
    let states: Vec<_> = agenda(&agent).iter().map(|task| (task.tag.clone(), task.state)).collect();
    assert!(states.contains(&("urgent".into(), TaskState::Ongoing)), "{states:?} {:?}", story(&effects));
    assert!(states.contains(&("calm".into(), TaskState::Interrupted)));
}

#[test]
fn a_short_task_uses_a_gap_that_is_provably_long_enough() {
    let pdl = |expected: &str| {
        format!(
            "(procedure (index (do-domain))
              (step holder (hold) (priority 9)) (step both (both) (priority 5)) (step short (short)))
            (procedure (index (hold)) (profile a) {expected} (step s (sleep)))
            (primitive (index (sleep)) (duration 20s))
            (primitive (index (both)) (profile a b) (duration 1s))
            (primitive (index (short)) (profile b) (duration 5s))"
        )
    };
    let started = |pdl: &str| lines(&run(&mut agent(pdl), &[], 60.0), &["short"]).contains(&"0s short ongoing".into());
    assert!(!started(&pdl("")));
    assert!(started(&pdl("(expected-duration 10s)")));
    assert!(!started(&pdl("(expected-duration 4s)")));
}

#[test]
fn commands_fail_when_they_are_refused_or_unanswered() {
    let pdl = "(procedure (index (do-domain)) (step fly (fly) (on-failure (print \"lost it\"))))
      (primitive (index (fly)) (on-start (command (fly north) :timeout 5s)))";
    let refused = run(&mut agent(pdl), &[answer(2.0, 0, Err("too windy"))], 60.0);
    assert!(story(&refused).contains(&"2s print lost it".to_string()));
    let unanswered = story(&run(&mut agent(pdl), &[], 60.0));
    assert!(unanswered.contains(&"5s withdraw 0".to_string()) && unanswered.contains(&"5s print lost it".to_string()));
}

#[test]
fn a_solver_that_finds_nothing_fails_the_goal() {
    let pdl = "(procedure (index (do-domain)) (step tour (visit all)))
      (solver auto (index (visit ?what)))";
    let kind = EventKind::SolverReported(
        apex_model::effect::SolveRequestId(0),
        SolverReport::Failed("no target can be reached".into()),
    );
    let mut agent = agent(pdl);
    let effects = story(&run(&mut agent, &[Event { sequence: 0, at: seconds(3.0), kind }], 60.0));
    assert_eq!(effects.last().unwrap(), "3s end");
    assert!(effects.contains(&"3s tour terminated failure".to_string()));
    assert_eq!(describe_task(&agent, TaskId(0)).unwrap().outcome, Some(Outcome::Failure));
}

const WAITING: &str = "(procedure (index (do-domain))
  (step holder (use) (priority 3))
  (step claimant (use))
  (step ready (work) (waitfor (ready camera-1)))
  (step high (work) (waitfor (altitude pilot > 100)))
  (step after (work) (waitfor (end ?ready)))
  (step asked (ask operator \"Go?\" :by 60s :default 'no))
  (step flown (fly))
  (step result (compute => ?x) (waitfor (never)))
  (step uses (work on ?x))
  (step planned (plan me)))
(primitive (index (use)) (profile tool) (duration 50s))
(primitive (index (work))) (primitive (index (work on ?x))) (primitive (index (compute)))
(primitive (index (fly)) (on-start (command (fly north))))
(solver auto (index (plan ?x)))";

#[test]
fn every_waiting_task_says_for_what() {
    let mut agent = agent(WAITING);
    run(&mut agent, &[sample(1.0, "(altitude pilot)", "40")], 2.0);
    let task = |tag: &str| agenda(&agent).into_iter().find(|task| task.tag == tag).unwrap().id;
    let only = |tag: &str| {
        let reasons = waiting(&agent, task(tag));
        assert_eq!(reasons.len(), 1, "{tag}: {reasons:?}");
        reasons.into_iter().next().unwrap()
    };
    assert_eq!(only("holder").kind, ReasonKind::Time);
    let refused = only("claimant");
    assert_eq!((refused.kind, refused.text.as_str()), (ReasonKind::Resource, "tool"));
    assert!(
        refused
            .now
            .unwrap()
            .contains("T1 (holder) holds it and defends it with priority 3 + interrupt cost 0.1, against 0")
    );
    assert_eq!(only("ready").kind, ReasonKind::Condition);
    let high = only("high");
    assert!(high.text.contains("altitude") && high.now.as_ref().unwrap().contains("40"), "{high:?}");
    assert_eq!(only("after").kind, ReasonKind::Condition);
    assert_eq!(only("asked").kind, ReasonKind::Operator);
    assert!(only("flown").text.contains("command 0 (fly north)"));
    assert!(only("uses").text.contains("?x"));
    assert_eq!(only("planned").kind, ReasonKind::Plan);
    let root = waiting(&agent, TaskId(0));
    assert!(root.len() > 8 && root.iter().all(|reason| reason.kind == ReasonKind::Subtasks));
}

#[test]
fn a_task_is_described_with_what_it_holds_and_needs() {
    let mut agent = agent(WAITING);
    run(&mut agent, &[], 2.0);
    let task = |tag: &str| agenda(&agent).into_iter().find(|task| task.tag == tag).unwrap();
    let holder = task("holder");
    assert_eq!((holder.resources.len(), holder.needs.len(), holder.priority), (1, 1, 3.0));
    assert_eq!((holder.goal.to_string().as_str(), holder.parent), ("(use)", Some(TaskId(0))));
    let claimant = task("claimant");
    assert_eq!((claimant.resources.len(), claimant.needs.len(), claimant.state), (0, 1, TaskState::Enabled));
}

#[test]
fn the_next_wake_says_why() {
    let mut agent = agent(WAITING);
    assert_eq!(agent.next_wake().unwrap().1, "the agent has not begun");
    run(&mut agent, &[], 2.0);
    let (at, why) = agent.next_wake().unwrap();
    assert_eq!((at, why.as_str()), (seconds(50.0), "the duration of T1 (holder) ends"));
}

#[test]
fn what_is_printed_in_a_hook_sees_the_primitives_own_variables() {
    let pdl = "(procedure (index (do-domain)) (step a (count to 3)))
      (primitive (index (count to ?n)) (locals (i 0))
        (update 1s (setq i (+ i 1)) (if (= i ?n) (complete i)))
        (on-completion (print \"counted\" i)) (on-end (print \"over\")))";
    assert_eq!(printed(&run(&mut agent(pdl), &[], 60.0)), ["counted 3", "over"]);
}

#[test]
fn a_sample_that_no_condition_watches_is_an_instant_for_a_function_of_the_time() {
    let pdl = "(procedure (index (do-domain))
      (step near (print near) (waitfor (x v > 100)))
      (step late (print \"seen at\" +now+) (waitfor (:function (> +now+ (+ 5s (start-of +this-task+)))))))";
    for others in ["(x other)", "(y v)"] {
        let events: Vec<_> = [1.0, 5.0, 8.0, 9.0].map(|at| sample(at, others, "1")).into();
        assert_eq!(printed(&run(&mut agent(pdl), &events, 20.0)), ["seen at 8s"], "samples of {others}");
    }
}

/// Returns the reason of the end of the application.
fn end_of(pdl: &str) -> String {
    let effects = run(&mut agent(pdl), &[message(1.0, "(go)")], 5.0);
    let reason = effects.into_iter().find_map(|(_, effect)| match effect {
        apex_model::effect::Effect::EndApplication { reason } => Some(reason),
        _ => None,
    });
    reason.unwrap()
}

#[test]
fn an_end_without_a_text_names_the_procedure_and_what_it_waited_for() {
    let pdl = "(procedure (index (do-domain)) (step home (go home because low)) (step idle (idle)))
      (procedure :sequential (index (go home because ?why)) (step fly (fly)) (step finish (end-application)))
      (procedure (index (idle)) (step wait (terminate) (waitfor (never))))
      (primitive (index (fly)) (duration 2s))";
    assert_eq!(end_of(pdl), "(go home because low) ended the application: (fly) is done");
    let pdl = "(procedure (index (do-domain)) (step finish (end-application) (waitfor (go))))";
    assert_eq!(end_of(pdl), "(do-domain) ended the application: (go) at 1s");
}

#[test]
fn an_end_with_a_text_states_it() {
    let pdl = "(procedure (index (do-domain)) (step up (climb leak)))
      (procedure (index (climb ?why)) (step finish (end-application (format nil \"landed early: ~a\" ?why)) (waitfor (go))))";
    assert_eq!(end_of(pdl), "landed early: leak");
}

/// The failure of a subtask is reported with the first reason and with the goal that handles it, and nothing says that it is unhandled.
#[test]
fn a_handled_failure_states_its_first_reason_and_its_handler() {
    let pdl = "(procedure (index (do-domain)) (step a (inspect 5) (on-failure (stay home))))
      (procedure (index (inspect ?what)) (step circle (circle ?what)))
      (procedure (index (circle ?what)) (step fly (orbit ,(/ 1 (- ?what ?what)))))
      (primitive (index (orbit ?what)) (duration 1s))
      (primitive (index (stay home)) (duration 1s))";
    let told = story(&run(&mut agent(pdl), &[], 5.0));
    let trouble: Vec<_> = told.iter().filter(|line| line.contains("trouble")).collect();
    let expected = "(inspect 5) failed: an expression failed: (/ ..): division of 1 by zero; from test.pdl:3:";
    assert!(trouble.len() == 1 && trouble[0].contains(expected), "{trouble:?}");
    assert!(trouble[0].ends_with("; (stay home) handles it"), "{trouble:?}");
    assert!(told.iter().all(|line| !line.contains("nothing handles")), "{told:?}");
}
