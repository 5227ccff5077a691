//! The mission loop with test doubles for executive, vehicle, solver and operator.

use super::*;
use crate::commands::{Command, CommandEnd, Order, Ticket};
use crate::pacing::{Clock, ManualClock};
use crate::ports::{CancelToken, Input, Posed, SolverAnswer, SolverJob};
use crate::samples;
use apex_model::because::{Because, Cause};
use apex_model::effect::{CommandId, Effect, QuestionId, SolveRequest, SolveRequestId};
use apex_model::event::{Batch, EventKind, SolverReport};
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;

/// Test double of the executive: obeys the messages `(go)`, `(plan)`, `(forget)`, `(loop)`, `(stop)`.
fn obey(agent: &mut Agent, batch: &Batch) -> Vec<Effect> {
    agent.started = true;
    let mut effects = Vec::new();
    for event in &batch.events {
        match &event.kind {
            EventKind::Occurrence(form) => effects.extend(effect_of(&form.to_string())),
            EventKind::CommandAcknowledged(command, _) if command.0 == 9 => effects.extend(effect_of("(loop)")),
            _ => {}
        }
    }
    effects
}

fn ran() -> Because {
    Because::new(Cause::FormRan { clause: "on-start".into() }, None)
}

fn effect_of(form: &str) -> Option<Effect> {
    let task = TaskId(1);
    match form {
        "(go)" => Some(Effect::Command { command: CommandId(1), task, form: samples::goal(&["go"]), because: ran() }),
        "(loop)" => {
            Some(Effect::Command { command: CommandId(9), task, form: samples::goal(&["loop"]), because: ran() })
        }
        "(forget)" => Some(Effect::CancelSolve(SolveRequestId(1))),
        "(stop)" => Some(Effect::EndApplication { reason: "asked to".into() }),
        "(plan)" => Some(Effect::Solve(SolveRequest {
            request: SolveRequestId(1),
            task,
            goal: samples::goal(&["plan"]),
            solver: Symbol::new("auto"),
            budget: None,
            is_failure_handled: false,
        })),
        _ => None,
    }
}

/// Reports its altitude every 10 s, at most `reports` times, and acknowledges command 1 two seconds late, 9 at once.
#[derive(Default)]
struct Balloon {
    reports: u32,
    reported: u32,
    acknowledgements: Vec<Input>,
}

impl Vehicle for Balloon {
    fn next_report(&self) -> Option<Time> {
        let report = (self.reported < self.reports).then(|| Time::from_seconds(f64::from(self.reported) * 10.0));
        report.into_iter().chain(self.acknowledgements.iter().map(|input| input.at)).min()
    }

    fn advance(&mut self, to: Time, inputs: &mut Vec<Input>) -> Result<(), String> {
        if to > Time::from_seconds(1000.0) {
            return Err("the balloon burst".into());
        }
        while self.reported < self.reports && Time::from_seconds(f64::from(self.reported) * 10.0) <= to {
            let at = Time::from_seconds(f64::from(self.reported) * 10.0);
            inputs.push(Input::new(at, samples::sample("altitude", Value::Integer(i64::from(self.reported)))));
            self.reported += 1;
        }
        let (due, later) = std::mem::take(&mut self.acknowledgements).into_iter().partition(|input| input.at <= to);
        self.acknowledgements = later;
        inputs.extend::<Vec<Input>>(due);
        Ok(())
    }

    fn command(&mut self, command: CommandId, _: &Value, at: Time) {
        let delay = Duration::from_seconds(if command.0 == 9 { 0.0 } else { 2.0 });
        self.acknowledgements.push(Input::new(at + delay, EventKind::CommandAcknowledged(command, Ok(Value::nil()))));
    }

    fn withdraw(&mut self, _: CommandId, _: Time) {}
}

/// Needs half a minute for a plan.
struct Slow;

impl Deliberator for Slow {
    fn pose(&mut self, _: &SolveRequest, _: Time) -> Posed {
        Posed::new("{}".into(), |_: &CancelToken| slow_answer())
    }
}

fn slow_answer() -> SolverAnswer {
    SolverAnswer { result: Ok(samples::plan()), charged: Duration::from_seconds(33.0) }
}

/// Observer that writes down the steps: `0s Woken, Measurement(..)`.
#[derive(Default)]
struct EventLog(Vec<String>);

impl Observer for EventLog {
    fn begin(&mut self, batch: &Batch) -> Result<(), String> {
        let kind = |kind: &EventKind| match kind {
            EventKind::SolverReported(request, SolverReport::Plan(_)) => format!("plan {}", request.0),
            EventKind::CommandAcknowledged(command, _) => format!("done {}", command.0),
            EventKind::Measurement(_, value) => format!("altitude {value}"),
            EventKind::Occurrence(form) => form.to_string(),
            other => format!("{other:?}"),
        };
        let kinds: Vec<String> = batch.events.iter().map(|event| kind(&event.kind)).collect();
        self.0.push(format!("{} {}", batch.now, kinds.join(", ")));
        Ok(())
    }
    fn observe(&mut self, _: &Batch, _: &[Effect]) -> Result<(), String> {
        if self.0.iter().any(|line| line.ends_with("(break)")) { Err("the pencil broke".into()) } else { Ok(()) }
    }
    fn note(&mut self, _: Time, text: &str) -> Result<(), String> {
        self.0.push(format!("note: {text}"));
        Ok(())
    }
}

fn said(seconds: f64, form: &str) -> Input {
    Input::new(Time::from_seconds(seconds), EventKind::Occurrence(samples::goal(&[form])))
}

fn fly_balloon(reports: u32, options: RunSettings) -> (Result<RunEnd, RunError>, Vec<String>) {
    let (mut agent, mut event_log) = (Agent::default(), EventLog::default());
    let mut balloon = Balloon { reports, ..Balloon::default() };
    let end = {
        let queue = Box::new(SolverThread::new(options.solver_timeout));
        let agents = std::slice::from_mut(&mut agent);
        fly_by((obey, queue), agents, &mut balloon, &mut Slow, &mut [&mut event_log], options)
    };
    (end, event_log.0)
}

#[test]
fn instants_come_from_vehicle_schedule_solver_and_commands() {
    let inputs = vec![said(12.0, "go"), said(10.0, "hello"), said(3.0, "plan")];
    let (end, lines) = fly_balloon(2, RunSettings { inputs, ..RunSettings::default() });
    assert_eq!(
        lines,
        ["0s altitude 0, Woken", "3s (plan)", "10s altitude 1, (hello)", "12s (go)", "14s done 1", "36s plan 1"]
    );
    let end = end.unwrap();
    assert_eq!((end.at, end.reason), (Time::from_seconds(36.0), EndReason::Quiescent));
    assert_eq!((end.steps, end.events, end.effects), (6, 8, 2));
}

#[test]
fn the_time_limit_is_the_last_instant() {
    let options = RunSettings { until: Time::from_seconds(20.0), ..RunSettings::default() };
    let (end, lines) = fly_balloon(9, options);
    assert_eq!(lines.last().unwrap(), "20s altitude 2");
    let end = end.unwrap();
    assert_eq!((end.at, end.reason), (Time::from_seconds(20.0), EndReason::Until));
}

#[test]
fn the_end_of_the_application_ends_the_run_and_late_answers_are_named() {
    let inputs = vec![said(1.0, "plan"), said(2.0, "stop"), said(3.0, "go")];
    let (end, lines) = fly_balloon(0, RunSettings { inputs, ..RunSettings::default() });
    assert_eq!(end.unwrap().reason, EndReason::Application { reason: "asked to".into(), failed: false, cut: true });
    assert_eq!(lines[3..], ["note: the answer of auto to request 1, due at 34s, came too late: the run ended at 2s"]);
    let inputs = vec![said(1.0, "plan"), said(2.0, "forget")];
    let (_, lines) = fly_balloon(0, RunSettings { inputs, ..RunSettings::default() });
    assert!(lines[3].starts_with("note: the answer of auto to request 1, due at 34s, was dropped"), "{lines:?}");
    assert_eq!(lines.len(), 4, "a cancelled answer never comes");
}

#[test]
fn a_loop_without_time_is_stopped_with_its_cause() {
    let (end, _) = fly_balloon(0, RunSettings { inputs: vec![said(5.0, "loop")], ..RunSettings::default() });
    let message = end.unwrap_err().to_string();
    assert!(message.contains("time stands still at 5s") && message.contains("a report of the vehicle"), "{message}");
}

#[test]
fn broken_vehicles_and_observers_stop_the_run_with_their_sentences() {
    let (end, _) = fly_balloon(0, RunSettings { inputs: vec![said(2000.0, "hello")], ..RunSettings::default() });
    assert_eq!(end.unwrap_err().to_string(), "the vehicle failed at 0:33:20: the balloon burst");
    let (end, _) = fly_balloon(0, RunSettings { inputs: vec![said(1.0, "break")], ..RunSettings::default() });
    assert_eq!(end.unwrap_err().to_string(), "the run stopped at 1s: the pencil broke");
}

#[test]
fn pace_changes_the_clock_on_the_wall_and_the_sample_of_it() {
    let inputs = || vec![said(12.0, "go"), said(3.0, "plan")];
    let (_, fast) = fly_balloon(2, RunSettings { inputs: inputs(), ..RunSettings::default() });
    let began = std::time::Instant::now();
    let (_, paced) = fly_balloon(2, RunSettings { inputs: inputs(), pace: Some(200.0), ..RunSettings::default() });
    assert_eq!(fast.join(" "), paced.join(" ").replace("altitude 200.0, ", ""));
    let spent_s = began.elapsed().as_secs_f64();
    assert!(spent_s > 0.17, "36 s at 200 times real time take 0.18 s, not {spent_s}");
    let (end, _) = fly_balloon(2, RunSettings { pace: Some(-1.0), ..RunSettings::default() });
    assert!(end.unwrap_err().to_string().starts_with("a pace of -1 is invalid"));
}

#[test]
fn operators_are_served_while_a_paced_run_sleeps() {
    let (people, controls) = channel();
    let speaker = std::thread::spawn(move || {
        let pause = || std::thread::sleep(std::time::Duration::from_millis(30));
        pause();
        people.send(Control::Input(said(0.0, "hello").kind)).unwrap();
        pause();
        people.send(Control::Pace(Some(0.0))).unwrap();
        pause();
        people.send(Control::Pace(None)).unwrap();
    });
    let options = RunSettings { pace: Some(1.0), controls: Some(controls), ..RunSettings::default() };
    let (end, lines) = fly_balloon(3, options);
    speaker.join().unwrap();
    // The next event of the flight is 10 s away. How soon the run wakes depends on the machine.
    let heard_s: f64 = lines[1].split_once('s').unwrap().0.parse().unwrap();
    assert!((0.03..10.0).contains(&heard_s) && lines[1].ends_with("(hello)"), "{lines:?}");
    assert_eq!(lines[2..], ["10s altitude 1", "20s altitude 2"]);
    assert_eq!(end.unwrap().reason, EndReason::Quiescent);
}

#[test]
fn stop_ends_cleanly_and_a_paced_run_waits_for_operators() {
    let (people, controls) = channel();
    let options = RunSettings { pace: Some(1000.0), controls: Some(controls), ..RunSettings::default() };
    let speaker = std::thread::spawn(move || {
        std::thread::sleep(std::time::Duration::from_millis(50));
        people.send(Control::Stop).unwrap();
    });
    let (end, _) = fly_balloon(0, options);
    speaker.join().unwrap();
    assert_eq!(end.unwrap().reason, EndReason::Stopped);
    let (gone, controls) = channel::<Control>();
    drop(gone);
    let options = RunSettings { pace: Some(1000.0), controls: Some(controls), ..RunSettings::default() };
    assert_eq!(fly_balloon(0, options).0.unwrap().reason, EndReason::Quiescent);
}

/// Answers as [`Slow`] does, after a separate wall time.
struct FakeQueue {
    clock: Arc<ManualClock>,
    takes_s: f64,
    open: Vec<(SolveRequestId, f64)>,
    is_cancelled: Arc<AtomicBool>,
}

impl SolverQueue for FakeQueue {
    fn submit(&mut self, request: SolveRequestId, _: &Symbol, _: Box<dyn SolverJob>) -> Result<(), String> {
        self.open.push((request, self.clock.elapsed().as_secs_f64() + self.takes_s));
        Ok(())
    }
    fn cancel(&mut self, _: SolveRequestId) {
        self.is_cancelled.store(true, Ordering::SeqCst);
    }
    fn try_recv(&mut self) -> Option<(SolveRequestId, SolverAnswer)> {
        let ready = self.open.iter().position(|(_, ready_s)| *ready_s <= self.clock.elapsed().as_secs_f64())?;
        Some((self.open.remove(ready).0, slow_answer()))
    }
    fn recv(&mut self) -> Option<(SolveRequestId, SolverAnswer)> {
        panic!("a paced flight does not wait")
    }
}

/// Flies the balloon in real time, by a clock that only sleeping advances, with a solver that takes `takes_s` seconds.
fn fly_paced(takes_s: f64, reports: u32, options: RunSettings) -> (RunEnd, Vec<String>, bool) {
    let (mut agent, mut event_log, clock) = (Agent::default(), EventLog::default(), Arc::new(ManualClock::default()));
    let mut balloon = Balloon { reports, ..Balloon::default() };
    let is_cancelled = Arc::new(AtomicBool::new(false));
    let open = Vec::new();
    let queue = FakeQueue { clock: Arc::clone(&clock), takes_s, open, is_cancelled: Arc::clone(&is_cancelled) };
    let options = RunSettings { pace: Some(1.0), clock, ..options };
    let agents = std::slice::from_mut(&mut agent);
    let end = fly_by((obey, Box::new(queue)), agents, &mut balloon, &mut Slow, &mut [&mut event_log], options);
    (end.unwrap(), event_log.0, is_cancelled.load(Ordering::SeqCst))
}

#[test]
fn a_paced_flight_whose_solver_is_fast_is_the_fast_flight() {
    let inputs = || vec![said(12.0, "go"), said(3.0, "plan")];
    let (_, fast) = fly_balloon(5, RunSettings { inputs: inputs(), ..RunSettings::default() });
    for takes_s in [0.0, 1.0, 32.9] {
        let (end, paced, _) = fly_paced(takes_s, 5, RunSettings { inputs: inputs(), ..RunSettings::default() });
        assert_eq!((fast.as_slice(), end.late.steps), (paced.as_slice(), 0));
    }
}

#[test]
fn a_paced_flight_continues_while_a_plan_is_late_and_takes_it_when_it_comes() {
    let inputs = vec![said(3.0, "plan")];
    let (end, lines, _) = fly_paced(50.0, 7, RunSettings { inputs, ..RunSettings::default() });
    let before = ["30s altitude 3", "40s altitude 4", "50s altitude 5"];
    assert_eq!(lines[4..7], before, "every report is heard in time");
    let then = ["note: the answer of auto to request 1, due at 36s by its work, came 17.0 s late", "53s plan 1"];
    assert_eq!(lines[7..9], then);
    assert_eq!((lines[9].as_str(), end.late.steps), ("0:01:00 altitude 6", 0));
}

#[test]
fn a_paced_flight_waits_for_nothing_but_the_plan_when_nothing_else_comes() {
    let inputs = vec![said(3.0, "plan")];
    let (end, lines, _) = fly_paced(900.0, 0, RunSettings { inputs, ..RunSettings::default() });
    assert!(lines[3].starts_with("0:15:03") && lines[3].ends_with("plan 1"), "{lines:?}");
    assert_eq!(end.reason, EndReason::Quiescent);
}

#[test]
fn a_late_answer_to_a_cancelled_request_is_reported_and_not_used() {
    let inputs = vec![said(3.0, "plan"), said(20.0, "forget")];
    let (_, lines, withdrawn) = fly_paced(50.0, 7, RunSettings { inputs, ..RunSettings::default() });
    assert!(withdrawn, "the solver is cancelled");
    let note = lines.iter().find(|line| line.starts_with("note")).unwrap();
    assert!(note.contains("request 1 came at 53") && note.contains("cancelled at 20s: a plan, 3 targets"), "{note}");
    assert!(!lines.iter().any(|line| line.ends_with("plan 1")), "{lines:?}");
}

#[test]
fn an_answer_that_has_not_come_by_the_end_is_named() {
    let options =
        RunSettings { inputs: vec![said(3.0, "plan")], until: Time::from_seconds(30.0), ..RunSettings::default() };
    let (end, lines, withdrawn) = fly_paced(50.0, 7, options);
    assert_eq!(
        lines.last().unwrap(),
        "note: the answer of auto to request 1, made at 3s, had not come when the run ended at 30s"
    );
    assert_eq!((end.reason, withdrawn), (EndReason::Until, true));
}

/// Sends commands to the balloon at the beginning; returns how the run ended, its lines, and the ends of the commands.
fn commanded(pace: Option<f64>, orders: Vec<Order>, expired: &[usize]) -> (RunEnd, Vec<String>, Vec<CommandEnd>) {
    let (people, controls) = channel();
    let mut tickets = Vec::new();
    for (index, order) in orders.into_iter().enumerate() {
        let ticket = Ticket::default();
        if expired.contains(&index) {
            assert!(ticket.settle(CommandEnd::Expired { reason: "10 s are over".into() }));
        }
        let words = format!("order {index}");
        let command = Command { number: index as u64 + 1, words, order, author: None, ticket: ticket.clone() };
        people.send(Control::Command(Arc::new(command))).unwrap();
        tickets.push(ticket);
    }
    drop(people);
    let options = RunSettings { pace, controls: Some(controls), ..RunSettings::default() };
    let (end, lines) = fly_balloon(2, options);
    let ends = tickets.iter().map(|ticket| ticket.end().expect("every command has an end")).collect();
    (end.unwrap(), lines, ends)
}

#[test]
fn every_command_has_one_end_and_is_an_input() {
    let input = |form: &str| Order::Input(None, said(0.0, form).kind);
    let stranger = Order::Input(Some(Symbol::new("nobody")), said(0.0, "go").kind);
    let answer = Order::Input(None, EventKind::OperatorAnswered(QuestionId(3), Value::symbol("yes")));
    let orders = vec![input("hello"), input("late"), answer, stranger, Order::Pace(Some(-1.0)), Order::Pace(None)];
    let (_, lines, ends) = commanded(Some(1000.0), orders, &[1]);
    assert!(matches!(ends[0], CommandEnd::Accepted { .. }), "{ends:?}");
    assert_eq!(ends[1], CommandEnd::Expired { reason: "10 s are over".into() });
    let rejected =
        |end: &CommandEnd, part: &str| matches!(end, CommandEnd::Rejected { reason } if reason.contains(part));
    assert!(rejected(&ends[2], "question 3 is not open"), "{ends:?}");
    assert!(rejected(&ends[3], "which does not exist") && rejected(&ends[4], "a pace of -1"), "{ends:?}");
    assert!(matches!(ends[5], CommandEnd::Accepted { .. }), "{ends:?}");
    let all = lines.join("\n");
    for (number, end) in [
        (1, "accepted"),
        (2, "expired \"10 s are over\""),
        (3, "rejected"),
        (4, "rejected"),
        (5, "rejected"),
        (6, "accepted"),
    ] {
        let entry = format!("(operator-command {number} \"order {}\" {end}", number - 1);
        assert_eq!(all.matches(&entry).count(), 1, "{entry} in {all}");
    }
    assert_eq!((all.matches("(hello)").count(), all.matches("(late)").count()), (1, 0), "{all}");
}

#[test]
fn a_step_runs_to_the_next_effect_and_pauses() {
    let (people, controls) = channel();
    let send = move |number: u64, order: Order| {
        let ticket = Ticket::default();
        let command = Command { number, words: "x".into(), order, author: None, ticket: ticket.clone() };
        people.send(Control::Command(Arc::new(command))).unwrap();
        ticket
    };
    let step = send(1, Order::Step);
    let speaker = std::thread::spawn(move || {
        std::thread::sleep(std::time::Duration::from_millis(80));
        let stop = send(2, Order::Stop);
        std::thread::sleep(std::time::Duration::from_millis(80));
        stop.end()
    });
    let inputs = vec![said(12.0, "go"), said(15.0, "hello")];
    let options = RunSettings { pace: Some(0.0), inputs, controls: Some(controls), ..RunSettings::default() };
    let (end, lines) = fly_balloon(5, options);
    assert_eq!(step.end(), Some(CommandEnd::Accepted { at: Time::ZERO }));
    assert!(matches!(speaker.join().unwrap(), Some(CommandEnd::Accepted { .. })));
    assert_eq!(end.unwrap().reason, EndReason::Stopped);
    assert!(lines.iter().any(|line| line == "12s (go)"), "{lines:?}");
    assert!(!lines.iter().any(|line| line.contains("(hello)")), "it pauses at 12 s: {lines:?}");
}

#[test]
fn a_flight_that_holds_for_solvers_is_the_fast_flight_at_every_pace() {
    let inputs = || vec![said(12.0, "go"), said(3.0, "plan"), said(4.0, "forget")];
    let (_, fast) = fly_balloon(5, RunSettings { inputs: inputs(), ..RunSettings::default() });
    for takes_s in [0.0, 50.0, 900.0] {
        let (mut agent, mut event_log, clock) =
            (Agent::default(), EventLog::default(), Arc::new(ManualClock::default()));
        let mut balloon = Balloon { reports: 5, ..Balloon::default() };
        let queue = HeldQueue(SolverThread::new(RunSettings::default().solver_timeout), Arc::clone(&clock), takes_s);
        let options =
            RunSettings { pace: Some(1.0), hold_for_solvers: true, clock, inputs: inputs(), ..RunSettings::default() };
        let agents = std::slice::from_mut(&mut agent);
        let end =
            fly_by((obey, Box::new(queue)), agents, &mut balloon, &mut Slow, &mut [&mut event_log], options).unwrap();
        assert_eq!((event_log.0.as_slice(), end.late.steps), (fast.as_slice(), 0), "{takes_s} s on the wall");
    }
}

/// A real queue whose answers take wall time.
struct HeldQueue(SolverThread, Arc<ManualClock>, f64);

impl SolverQueue for HeldQueue {
    fn submit(&mut self, request: SolveRequestId, name: &Symbol, job: Box<dyn SolverJob>) -> Result<(), String> {
        self.0.submit(request, name, job)
    }
    fn cancel(&mut self, request: SolveRequestId) {
        self.0.cancel(request);
    }
    fn try_recv(&mut self) -> Option<(SolveRequestId, SolverAnswer)> {
        self.0.try_recv()
    }
    fn recv(&mut self) -> Option<(SolveRequestId, SolverAnswer)> {
        self.1.sleep(std::time::Duration::from_secs_f64(self.2));
        self.0.recv()
    }
}
