//! The program side of the protocol: runs a Rust planner as a solver program.

use super::protocol::{ProgramLine, ProgramRequest, VERSION};
use crate::limits::SOLVER_OVERRUN_UNITS;
use crate::solver_words::panic_text;
use apex_planning::solver::{Budget, Environment, Solver};
use std::io::{self, BufRead, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

/// Work units between two charges that a program reports: ten to a thousand lines for usual budgets.
const CHARGE_STEP_UNITS: u64 = 10_000;

/// Answers the single request on `input` with `solver`, on `output`. When the input ends, Apex has ended, and this process ends too.
///
/// # Errors
/// An input that is not a request, and an output that nothing reads.
pub fn serve(
    solver: &dyn Solver,
    mut input: impl BufRead + Send + 'static,
    output: &mut (dyn Write + Send),
) -> io::Result<()> {
    let mut line = String::new();
    input.read_line(&mut line)?;
    let fault = |why: String| io::Error::new(io::ErrorKind::InvalidData, why);
    let request: ProgramRequest = serde_json::from_str(&line)
        .map_err(|error| fault(format!("the first line on standard input is not a request of Apex: {error}")))?;
    if request.apex_solver != VERSION {
        let found = request.apex_solver;
        return Err(fault(format!("the request is of version {found} of the protocol; this program knows {VERSION}")));
    }
    let stopped = Arc::new(AtomicBool::new(false));
    let listening = Arc::clone(&stopped);
    thread::Builder::new().name("stop".into()).spawn(move || {
        let mut line = String::new();
        match input.read_line(&mut line) {
            Ok(0) | Err(_) => std::process::exit(0),
            Ok(_) => listening.store(true, Ordering::Relaxed),
        }
        // The next line, or the end of Apex.
        let _ = io::copy(&mut input, &mut io::sink());
        std::process::exit(0);
    })?;
    let mut speaker = Speaker { output, failure: None };
    let answer = answer(solver, &request, &stopped, &mut speaker);
    speaker.say(&answer);
    speaker.failure.map_or(Ok(()), Err)
}

fn answer(
    solver: &dyn Solver,
    request: &ProgramRequest,
    stopped: &AtomicBool,
    speaker: &mut Speaker<'_>,
) -> ProgramLine {
    let speaker = std::cell::RefCell::new(speaker);
    let mut budget = SpokenBudget { speaker: &speaker, allowed: request.work_units, used: 0, told: 0, stopped };
    let mut report = |plan: &apex_model::problem::Plan| speaker.borrow_mut().say(&ProgramLine::Report(plan.clone()));
    let mut environment = Environment {
        seed: request.seed,
        budget: &mut budget,
        report: &mut report,
        previous: request.previous.as_ref(),
    };
    let solved = catch_unwind(AssertUnwindSafe(|| solver.solve(&request.problem, &mut environment)));
    budget.tell();
    match solved {
        Ok(Ok(plan)) => ProgramLine::Plan(plan),
        Ok(Err(reason)) => ProgramLine::Failed(reason),
        Err(payload) => {
            // A panic ends the process without an answer: Apex distinguishes this from a problem without a plan.
            eprintln!("{}", panic_text(&*payload));
            std::process::exit(101)
        }
    }
}

struct Speaker<'o> {
    output: &'o mut (dyn Write + Send),
    failure: Option<io::Error>,
}

impl Speaker<'_> {
    fn say(&mut self, said: &ProgramLine) {
        let line = said.line().map_err(io::Error::other);
        let spoken = line.and_then(|line| writeln!(self.output, "{line}").and_then(|()| self.output.flush()));
        if let Err(error) = spoken {
            self.failure.get_or_insert(error);
        }
    }
}

/// A budget whose charges are written to the output.
struct SpokenBudget<'a, 'o> {
    speaker: &'a std::cell::RefCell<&'a mut Speaker<'o>>,
    allowed: u64,
    used: u64,
    told: u64,
    stopped: &'a AtomicBool,
}

impl SpokenBudget<'_, '_> {
    fn tell(&mut self) {
        let units = self.used.saturating_sub(self.told);
        if units > 0 {
            self.told = self.used;
            self.speaker.borrow_mut().say(&ProgramLine::Charge(units));
        }
    }
}

impl Budget for SpokenBudget<'_, '_> {
    fn charge(&mut self, units: u64) {
        self.used = self.used.saturating_add(units);
        let is_over = self.used >= self.allowed.saturating_mul(2).saturating_add(SOLVER_OVERRUN_UNITS);
        if self.used - self.told >= CHARGE_STEP_UNITS || is_over {
            self.tell();
        }
        if is_over {
            // Apex ends the process now; until then it sleeps.
            thread::sleep(std::time::Duration::from_secs(1));
        }
    }

    fn exhausted(&self) -> bool {
        self.used >= self.allowed || self.stopped.load(Ordering::Relaxed)
    }

    fn used(&self) -> u64 {
        self.used
    }

    fn left(&self) -> Option<u64> {
        Some(self.allowed.saturating_sub(self.used))
    }
}
