//! Planners written in Python: problems and plans are passed as the JSON of `docs/reference/planning-problems.md`.
//!
//! A planner works on a separate thread. It sends its requests to the thread of the solver, for which the limits of all solvers hold, and
//! which interrupts a planner that does not stop.

use crate::errors::input;
use apex_model::problem::{Plan, Problem};
use apex_planning::Registry;
use apex_planning::solver::{Environment, Solver};
use apex_planning::surveillance::scenario::Scenario;
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Interval at which a planner that sends no request is checked, and the time allowed for stopping.
const LOOK: Duration = Duration::from_millis(20);
const GRACE: Duration = Duration::from_millis(500);

/// Request of a planner; `Ended` is the last one.
enum PlannerRequest {
    Charge(u64),
    Report(String),
    Ended(Result<String, String>),
}

/// Reply to a planner: whether its budget is exhausted, and the used units of work.
#[derive(Clone, Copy)]
struct PlannerReply {
    exhausted: bool,
    used: u64,
}

/// Resources that a planner may use.
#[pyclass(module = "apex_autonomy", frozen)]
pub(crate) struct PlannerContext {
    seed: u64,
    previous: Option<String>,
    asks: Sender<PlannerRequest>,
    answers: std::sync::Mutex<Receiver<PlannerReply>>,
}

impl PlannerContext {
    fn ask(&self, python: Python<'_>, asked: PlannerRequest) -> PyResult<PlannerReply> {
        python.detach(|| {
            let answers = self.answers.lock().map_err(|_| input("the planner has been stopped"))?;
            self.asks.send(asked).map_err(|_| input("the planner has been stopped"))?;
            answers.recv().map_err(|_| input("the planner has been stopped"))
        })
    }
}

#[pymethods]
impl PlannerContext {
    #[getter]
    fn seed(&self) -> u64 {
        self.seed
    }
    #[getter]
    fn previous_json(&self) -> Option<&str> {
        self.previous.as_deref()
    }
    fn charge(&self, python: Python<'_>, units: u64) -> PyResult<bool> {
        self.ask(python, PlannerRequest::Charge(units)).map(|told| !told.exhausted)
    }
    #[getter]
    fn exhausted(&self, python: Python<'_>) -> PyResult<bool> {
        self.ask(python, PlannerRequest::Charge(0)).map(|told| told.exhausted)
    }
    #[getter]
    fn used(&self, python: Python<'_>) -> PyResult<u64> {
        self.ask(python, PlannerRequest::Charge(0)).map(|told| told.used)
    }
    fn report_json(&self, python: Python<'_>, plan: String) -> PyResult<()> {
        self.ask(python, PlannerRequest::Report(plan)).map(|_| ())
    }
}

/// A planner whose work is done by Python: `call(problem_json, context) -> plan_json`, `serves(kind) -> bool`.
struct PythonSolver {
    name: String,
    kinds: Vec<String>,
    call: Arc<Py<PyAny>>,
    interrupt: Arc<Py<PyAny>>,
}

impl Solver for PythonSolver {
    fn name(&self) -> &str {
        &self.name
    }

    fn serves(&self, problem: &Problem) -> bool {
        let kind = match problem {
            Problem::Surveillance(_) => "Surveillance",
            Problem::SingleVisit(_) => "SingleVisit",
        };
        self.kinds.iter().any(|served| served == kind)
    }

    fn solve(&self, problem: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String> {
        let json = |what: serde_json::Result<String>| what.map_err(|error| error.to_string());
        let text = json(serde_json::to_string(problem))?;
        let previous = environment.previous.map(|plan| json(serde_json::to_string(plan))).transpose()?;
        let (asks, asked) = channel();
        let (tell, answers) = channel();
        let surroundings = PlannerContext {
            seed: environment.seed,
            previous,
            asks: asks.clone(),
            answers: std::sync::Mutex::new(answers),
        };
        let call = Arc::clone(&self.call);
        let (started, identity) = channel();
        let work = move || {
            let answer = Python::attach(|python| {
                // If the send fails, the planner has been stopped and no thread receives.
                let _ = started.send(thread_identity(python));
                let answer = call.bind(python).call1((text, surroundings))?;
                answer.extract::<String>()
            });
            let _ = asks.send(PlannerRequest::Ended(answer.map_err(|error| error.to_string())));
        };
        let builder = thread::Builder::new().name(format!("planner {}", self.name));
        builder.spawn(work).map_err(|error| format!("no thread could be started for the planner: {error}"))?;
        let guard = Interrupt { identity, interrupt: Arc::clone(&self.interrupt), armed: true };
        serve(self, problem, environment, &asked, &tell, guard)
    }
}

/// Serves a planner until it ends, or fails to end when it should.
fn serve(
    solver: &PythonSolver,
    problem: &Problem,
    environment: &mut Environment<'_>,
    asked: &Receiver<PlannerRequest>,
    tell: &Sender<PlannerReply>,
    mut guard: Interrupt,
) -> Result<Plan, String> {
    let mut exhausted_at: Option<Instant> = None;
    loop {
        match asked.recv_timeout(LOOK) {
            Ok(PlannerRequest::Charge(units)) => environment.budget.charge(units),
            Ok(PlannerRequest::Report(text)) => {
                // A report that is not a plan ends the request with this error. The planner's call raises that the planner was stopped.
                let plan = read(&solver.name, problem, &text)?;
                (environment.report)(&plan);
            }
            Ok(PlannerRequest::Ended(answer)) => {
                guard.armed = false;
                return read(&solver.name, problem, &answer?);
            }
            Err(RecvTimeoutError::Timeout) => {
                if environment.budget.exhausted() && exhausted_at.get_or_insert_with(Instant::now).elapsed() > GRACE {
                    return Err(format!("the planner {} did not stop after its budget was exhausted", solver.name));
                }
                continue;
            }
            Err(RecvTimeoutError::Disconnected) => {
                return Err("the thread of the planner ended without an answer".to_string());
            }
        }
        let told = PlannerReply { exhausted: environment.budget.exhausted(), used: environment.budget.used() };
        // If nothing waits for the answer, the planner has been interrupted.
        let _ = tell.send(told);
    }
}

/// Interrupts the planner's thread when it is abandoned, for any reason.
struct Interrupt {
    identity: Receiver<Option<u64>>,
    interrupt: Arc<Py<PyAny>>,
    armed: bool,
}

impl Drop for Interrupt {
    fn drop(&mut self) {
        if !self.armed {
            return;
        }
        let Ok(Some(identity)) = self.identity.recv_timeout(GRACE) else { return };
        // A thread that cannot be interrupted is abandoned; no caller can be informed.
        let _ = Python::attach(|python| self.interrupt.bind(python).call1((identity,)).map(|_| ()));
    }
}

fn thread_identity(python: Python<'_>) -> Option<u64> {
    python.import("threading").ok()?.call_method0("get_ident").ok()?.extract().ok()
}

/// Reads a plan from JSON, or for a surveillance problem from a JSON list of the names of targets in the order of visits.
fn read(name: &str, problem: &Problem, text: &str) -> Result<Plan, String> {
    let wrong = |why: String| format!("the planner {name} answered without a valid plan: {why}");
    if let (Problem::Surveillance(problem), Ok(order)) = (problem, serde_json::from_str::<Vec<String>>(text)) {
        let scenario = Scenario::new(problem)?;
        let index = |target: &String| {
            let found = problem.targets.iter().position(|known| known.name == *target);
            found.ok_or_else(|| wrong(format!("it visits {target}, which is not a target")))
        };
        let tour = order.iter().map(index).collect::<Result<Vec<usize>, String>>()?;
        return Ok(Plan::Surveillance(scenario.plan(name, tour)));
    }
    serde_json::from_str(text).map_err(|error| wrong(error.to_string()))
}

/// For each planner: its name, the kinds of problems that it serves, the function that calls it, and the function that interrupts its
/// thread.
pub(crate) type Planners = Vec<(String, Vec<String>, Py<PyAny>, Py<PyAny>)>;

/// Returns a registry of the planners that ship and of these.
pub(crate) fn registry(planners: Planners) -> PyResult<Registry> {
    let mut registry = apex_solvers::shipped();
    for (name, kinds, call, interrupt) in planners {
        let solver = PythonSolver { name, kinds, call: Arc::new(call), interrupt: Arc::new(interrupt) };
        registry.add(Arc::new(solver)).map_err(input)?;
    }
    Ok(registry)
}
