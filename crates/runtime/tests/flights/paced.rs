//! Flights by wall time with misbehaving solvers: the executive is never late, and the record states what the solvers did. The test's own
//! clock advances by sleeping only, so a flight that waited for its solver would stop.

use super::support::{CAMERA, altitude, event, load, record_with};
use apex_model::effect::SolveRequest;
use apex_model::event::{Batch, EventKind};
use apex_model::planned::{PlannedActivity, PlannedProcedure, PlannedStep};
use apex_model::problem::{Plan, Problem, SingleVisitPlan, SingleVisitProblem};
use apex_model::source::SourceFile;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_planning::solver::{Environment, Solver, time_of};
use apex_runtime::invocation::{Invocations, SolverLimits};
use apex_runtime::limits::STEPS_PER_INSTANT_MAX;
use apex_runtime::mission_loop::{Control, EndReason, RunSettings};
use apex_runtime::pacing::{Clock, ManualClock};
use apex_runtime::ports::{Deliberator, Observer, Posed, SolverAnswer};
use apex_runtime::program::NoDeliberator;
use apex_runtime::record::RecordReader;
use apex_runtime::replay::replay;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;

/// Circles until the plan has arrived, or takes photographs without one.
const TOUR: &str = r#"
(solver bad (index (tour)) :budget 5s :meanwhile (circle))
(procedure (index (do-domain))
  (step t (tour) (on-failure (inform (no-plan))))
  (step high (inform (high)) (waitfor (altitude ac-1 > 95))))
(primitive (index (circle)) (duration 10min))
(primitive (index (visit ?site)) (duration 10s))
"#;

/// A solver that behaves as its name says; the flag ends a solver that hangs.
struct Bad(&'static str, Arc<AtomicBool>);

impl Solver for Bad {
    fn name(&self) -> &str {
        self.0
    }
    fn serves(&self, _: &Problem) -> bool {
        true
    }
    fn solve(&self, _: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String> {
        let mut hoard: Vec<Vec<u8>> = Vec::new();
        let pause = || std::thread::sleep(std::time::Duration::from_millis(1));
        match self.0 {
            "panics" => panic!("no idea left"),
            "loops" => loop {
                environment.budget.charge(1);
            },
            "hoards" => loop {
                hoard.push(vec![7; 1 << 20]);
                environment.budget.charge(1);
                assert!(hoard.len() < 2_000, "it was not stopped");
                pause();
            },
            "obeys" => {
                while !environment.budget.exhausted() {
                    environment.budget.charge(1);
                    pause();
                }
            }
            "hangs" => {
                while !self.1.load(Ordering::SeqCst) {
                    pause();
                }
            }
            _ => {}
        }
        let nothing = SingleVisitPlan {
            solver: self.0.into(),
            visits: Vec::new(),
            return_route: Vec::new(),
            return_path: Vec::new(),
            return_depart_s: 0.0,
            end_s: 0.0,
            fuel_used_kg: 0.0,
            benefits: 0.0,
            costs: 0.0,
            score: 0.0,
            benefits_bound: None,
            left_out: Vec::new(),
            summary: "a plan".into(),
        };
        Ok(Plan::SingleVisit(nothing))
    }
}

/// Invokes its solver with the limits of a flight; the solver's misbehaviour is part of the answer.
struct Asks {
    solver: Arc<dyn Solver>,
    limits: SolverLimits,
}

impl Deliberator for Asks {
    fn pose(&mut self, request: &SolveRequest, _: Time) -> Posed {
        let problem = Arc::new(Problem::SingleVisit(SingleVisitProblem::default()));
        let (solver, limits, goal) = (Arc::clone(&self.solver), self.limits, request.goal.clone());
        Posed::new("{}".into(), move |cancel| {
            let answer = Invocations::new().solve(&solver, &problem, None, 1, limits, cancel);
            let result = match answer.violation {
                Some(violation) => Err(violation),
                None => answer.plan.map(|_| one_site(&goal)),
            };
            SolverAnswer { result, charged: time_of(answer.used).min(Duration::from_seconds(5.0)) }
        })
    }
}

fn one_site(goal: &Value) -> PlannedProcedure {
    let visit = PlannedActivity::Goal(apex_pdl::read_value("(visit a)").unwrap());
    let text = format!("(procedure\n  (index {goal})\n  (step s1 (visit a)))");
    PlannedProcedure {
        solver: Symbol::new("bad"),
        summary: "1 site".into(),
        steps: vec![PlannedStep { tag: Symbol::new("s1"), activity: visit, line: 3 }],
        repeat: false,
        plan: None,
        source: SourceFile { name: Arc::from("<plan 1>"), text: Arc::from(text) },
    }
}

/// A clock that gives solvers real time where the test requires an answer, and opens the gate for solvers that hang.
#[derive(Debug, Default)]
struct GateClock {
    clock: ManualClock,
    answered: Arc<AtomicBool>,
    answer_comes: bool,
    gate: Arc<AtomicBool>,
    pace: f64,
}

impl Clock for GateClock {
    fn elapsed(&self) -> std::time::Duration {
        self.clock.elapsed()
    }
    fn sleep(&self, span: std::time::Duration) {
        self.clock.sleep(span);
        // Of mission time.
        let elapsed_s = self.elapsed().as_secs_f64() * self.pace;
        if self.answer_comes && elapsed_s > 20.0 && !self.answered.load(Ordering::SeqCst) {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        if elapsed_s > 80.0 {
            self.gate.store(true, Ordering::SeqCst);
        }
    }
}

/// Records that an answer has arrived, and checks that no input is processed later than it was sent.
struct Listener(Arc<AtomicBool>, usize);

impl Observer for Listener {
    fn begin(&mut self, batch: &Batch) -> Result<(), String> {
        if batch.events.iter().any(|event| matches!(event.kind, EventKind::SolverReported(..))) {
            self.0.store(true, Ordering::SeqCst);
        }
        let is_altitude =
            |kind: &EventKind| matches!(kind, EventKind::Measurement(variable, _) if variable.attribute.is("altitude"));
        let samples = batch.events.iter().filter(|event| is_altitude(&event.kind));
        for sample in samples {
            assert_eq!(sample.at, batch.now);
            self.1 += 1;
        }
        Ok(())
    }
    fn observe(&mut self, _: &Batch, _: &[apex_model::effect::Effect]) -> Result<(), String> {
        Ok(())
    }
}

/// Returns the effects and notes of the record after 100 s with this solver, at the pace of the wall clock.
fn fly(name: &'static str, answer_comes: bool) -> String {
    fly_at(1.0, name, answer_comes)
}

fn fly_at(pace: f64, name: &'static str, answer_comes: bool) -> String {
    let clock = GateClock { answer_comes, pace, ..GateClock::default() };
    let (answered, gate) = (Arc::clone(&clock.answered), Arc::clone(&clock.gate));
    let solver: Arc<dyn Solver> = Arc::new(Bad(name, Arc::clone(&gate)));
    let timeout = std::time::Duration::from_secs(120);
    let units = if name == "loops" { 1_000 } else { u64::MAX / 4 };
    let limits = SolverLimits { units, timeout, memory_bytes: if name == "hoards" { 64 << 20 } else { 1 << 40 } };
    let mut deliberator = Asks { solver, limits };
    let inputs = (1..10_u8).map(|tens| altitude(f64::from(tens) * 10.0, 10 * i64::from(tens) + 6)).collect();
    let until = Time::from_seconds(100.0);
    let options = RunSettings { until, pace: Some(pace), clock: Arc::new(clock), inputs, ..RunSettings::default() };
    let mut listener = Listener(answered, 0);
    let flight = record_with(TOUR, &mut deliberator, &mut [&mut listener], options);
    gate.store(true, Ordering::SeqCst);
    assert_eq!((listener.1, flight.end.late.steps), (9, 0), "{name}: every report is heard at its instant");
    let reader = flight.reader();
    let report = replay(&reader, &load).unwrap();
    assert_eq!(report.difference, None, "{name}: {report}");
    told(&reader)
}

fn told(reader: &RecordReader) -> String {
    let mut all = String::new();
    for step in reader.steps_of_all(Time::END).unwrap() {
        let step = step.unwrap();
        for event in &step.batch.events {
            if let EventKind::SolverReported(_, report) = &event.kind {
                all.push_str(&format!("{report:?}\n"));
            }
        }
        for effect in &step.effects {
            all.push_str(&format!("{} {:?}\n", step.batch.now, effect.effect().unwrap()));
        }
    }
    for (at, text) in reader.notes().unwrap() {
        all.push_str(&format!("{at} note: {text}\n"));
    }
    all
}

#[test]
fn solvers_that_break_down_overrun_or_hoard_are_named_and_nothing_waits_for_them() {
    for (name, named) in [
        ("panics", "the solver panics failed: no idea left"),
        ("loops", "the solver loops continued after its 1000 units of work"),
        ("hoards", "the solver hoards took more than 64 MiB of memory"),
    ] {
        let told = fly(name, true);
        assert!(told.contains(named) && told.contains("no-plan") && told.contains("(high)"), "{name}\n{told}");
    }
}

#[test]
fn a_good_plan_is_flown_as_soon_as_it_is_there() {
    let told = fly("answers", true);
    assert!(told.contains("1 site") && !told.contains("no-plan"), "{told}");
}

#[test]
fn a_solver_that_hangs_does_not_stop_the_executive() {
    let told = fly("hangs", false);
    assert!(told.contains("SolverTimedOut") && told.contains("0:01:05 CancelSolve"), "{told}");
    assert!(told.contains("no-plan") && told.contains("(high)"), "{told}");
    assert!(told.contains("the answer of bad to request 0"), "the outcome of its answer is reported\n{told}");
}

#[test]
fn a_solver_has_the_same_wall_time_at_every_pace() {
    // 100 s of mission time are 1.6 s of wall time, in which no planner is late.
    let told = fly_at(64.0, "hangs", false);
    assert!(!told.contains("SolverTimedOut") && !told.contains("no-plan"), "{told}");
    // Slower than the wall clock a planner has its mission time, which is more wall time than it needs.
    assert!(fly_at(0.5, "hangs", false).contains("0:01:05 CancelSolve"));
}

#[test]
fn a_solver_whose_plan_is_no_longer_needed_is_asked_to_stop() {
    // It never ends, because its budget is endless.
    let told = fly("obeys", false);
    assert!(told.contains("0:01:05 CancelSolve") && told.contains("the answer of bad to request 0"), "{told}");
}

#[test]
fn any_number_of_messages_reaches_a_paused_flight() {
    let (people, controls) = channel();
    let count = 2 * STEPS_PER_INSTANT_MAX;
    people.send(Control::Pace(Some(0.0))).unwrap();
    for _ in 0..count {
        people.send(Control::Input(event(0.0, "(hello)").kind)).unwrap();
    }
    people.send(Control::Stop).unwrap();
    let options = RunSettings { pace: Some(1.0), controls: Some(controls), ..RunSettings::default() };
    let flight = record_with(CAMERA, &mut NoDeliberator, &mut [], options);
    assert_eq!(flight.end.reason, EndReason::Stopped);
    assert!(flight.end.at < Time::from_seconds(1.0) && flight.end.steps > count, "{:?}", flight.end);
    assert_eq!(replay(&flight.reader(), &load).unwrap().difference, None);
}
