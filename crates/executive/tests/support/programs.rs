//! Programs with inputs that together use every service.

use super::{answer, message, sample, seconds, value};
use apex_model::effect::SolveRequestId;
use apex_model::event::{Event, EventKind, SolverReport};
use apex_model::planned::{PlannedActivity, PlannedProcedure, PlannedStep};
use apex_model::source::SourceFile;
use apex_model::symbol::Symbol;

pub const RESOURCES: &str = "
(resource link :capacity 3)
(resource fuel :depletable 20kg)
(procedure (index (do-domain))
  (step survey (survey) (priority 2))
  (step urgent (urgent) (waitfor (alarm)) (priority 5))
  (step talk1 (talk) (priority 1)) (step talk2 (talk) (priority 3)) (step talk3 (talk) (rank 2)) (step talk4 (talk) (rank 1))
  (step rise (rise) (priority :urgency 3 :importance 6))
  (step late (late (30 kg)) (waitfor (end ?urgent)) (on-failure (print \"no fuel\")))
  (step early (hog) (waitfor (alarm)))
  (step eager (hog) (waitfor (urgent done)) (priority 4))
  (step again (reset ?early) (waitfor (end ?late)))
  (step idle (idle)) (step asleep (suspend ?idle) (waitfor (alarm)))
  (step stop (terminate >> done) (waitfor (goodbye))))
(primitive (index (hog)) (profile tool) (duration 100s))
(primitive (index (idle)) (duration 100s))
(procedure :sequential (index (survey)) (profile flight-path)
  (step leg1 (fly 5s)) (step leg2 (fly 7s)) (step leg3 (fly 9s) (repeating :while nil)))
(procedure (index (urgent)) (profile flight-path)
  (step go (fly 3s)) (step say (inform (urgent done)) (waitfor (end ?go))))
(primitive (index (fly ?time)) (duration ?time) (on-start (print fly ?time)) (on-suspend (print paused)) (on-resume (print resumed)))
(primitive (index (talk)) (profile (link 2)) (duration 4s))
(primitive (index (rise)) (profile flight-path) (duration 1s))
(primitive (index (late ?amount)) (profile (fuel ?amount)) (duration 1s))";

pub fn resources_inputs() -> Vec<Event> {
    vec![message(3.0, "(alarm)"), message(40.0, "(goodbye)")]
}

pub const CLAUSES: &str = "
(procedure (index (do-domain))
  (step watch (look ?where) (waitfor (alarm ?where)) (responding :for-new ?where))
  (step beat (beat) (repeating :with-min-interval 2s :until (> +now+ +limit+)))
  (step all (look ?x) (forall ?x in '(a b c)))
  (step none (look ?x) (forall ?x in '()))
  (step pausing (pausing) (suspend-when (pause)) )
  (step blocker (suspend ?pausing) (waitfor (halt)))
  (step opener (resume ?pausing) (waitfor (go on)))
  (step again (reset ?command) (waitfor (again)))
  (step command (drive) (end-when (enough)))
  (step value (compute 4 => ?number))
  (step shown (print ?number))
  (step held (hold-resource arm)) (step free (release-resource arm) (waitfor (go on)))
  (step arm (use arm) (waitfor (alarm north)))
  (step question (ask operator \"Go?\" :options '(yes no) :by 5s :default 'no) => ?answer)
  (step answered (print ?answer))
  (step stop (end-application) (waitfor (goodbye))))
(defindexical +limit+ (+ +beginning-of-mission+ 9s))
(defindexical +beginning-of-mission+ (start-of +this-task+))
(primitive (index (look ?where)) (duration 2s) (on-start (print look ?where)))
(primitive (index (beat)) (on-start (print beat)))
(primitive (index (pausing)) (locals (n 0)) (update 1s (setq n (+ n 1)) (print n) (if (> n 6) (complete n))))
(primitive (index (drive)) (on-start (command (drive north) :timeout 20s)))
(primitive (index (compute ?x)) (return (* ?x ?x)))
(primitive (index (use ?r)) (profile ?r) (duration 1s))";

pub fn clauses_inputs() -> Vec<Event> {
    vec![
        message(1.0, "(alarm north)"),
        message(1.5, "(alarm south)"),
        message(1.5, "(alarm north)"),
        message(2.25, "(halt)"),
        message(4.0, "(again)"),
        sample(4.5, "(altitude pilot)", "100"),
        message(6.75, "(go on)"),
        answer(9.0, 1, Ok(value("done"))),
        message(20.0, "(goodbye)"),
    ]
}

pub const PLANNED: &str = "
(procedure (index (do-domain))
  (step tour (visit all) (restart-when (new plan)))
  (step better (improve) (waitfor (improve)))
  (step stop (terminate) (waitfor (goodbye))))
(procedure :sequential (index (improve)) (step plan (plan (visit all))) (step say (inform (new plan))))
(solver auto (index (visit ?what)) :budget 5s :meanwhile (hover))
(primitive (index (hover)) (on-start (command (hover))))
(primitive (index (go ?where)) (duration 3s) (on-start (print go ?where)))";

/// Returns an answer to solver request `request` that visits `places`.
pub fn plan(at: f64, request: u64, places: &[&str], repeat: bool) -> Event {
    let text: String = places.iter().map(|place| format!("\n  (step {place} (go {place}))")).collect();
    let step = |(place, line): (&&str, u32)| PlannedStep {
        tag: Symbol::new(place),
        activity: PlannedActivity::Goal(value(&format!("(go {place})"))),
        line,
    };
    let planned = PlannedProcedure {
        solver: Symbol::new("two-opt"),
        summary: format!("{} visits", places.len()),
        steps: places.iter().zip(3..).map(step).collect(),
        repeat,
        plan: None,
        source: SourceFile {
            name: "<plan>".into(),
            text: format!("(procedure :sequential\n  (index (visit all)){text})").into(),
        },
    };
    let kind = EventKind::SolverReported(SolveRequestId(request), SolverReport::Plan(planned));
    Event { sequence: 0, at: seconds(at), kind }
}

pub fn planned_inputs() -> Vec<Event> {
    vec![
        plan(2.0, 0, &["a", "b"], true),
        message(6.0, "(improve)"),
        plan(10.0, 1, &["c"], false),
        message(30.0, "(goodbye)"),
    ]
}

/// All of them.
pub fn all() -> Vec<(&'static str, Vec<Event>)> {
    vec![(RESOURCES, resources_inputs()), (CLAUSES, clauses_inputs()), (PLANNED, planned_inputs())]
}
