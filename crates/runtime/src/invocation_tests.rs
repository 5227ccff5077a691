//! Solvers that misbehave in every way, and the answer that the caller receives.

use super::*;
use apex_model::problem::{SingleVisitPlan, SingleVisitProblem};

/// A misbehaving solver; its name selects the behaviour.
struct Bad(&'static str);

fn plan(score: f64) -> Plan {
    Plan::SingleVisit(SingleVisitPlan {
        solver: "bad".into(),
        visits: Vec::new(),
        return_route: Vec::new(),
        return_path: Vec::new(),
        return_depart_s: 0.0,
        end_s: 0.0,
        fuel_used_kg: 0.0,
        benefits: 0.0,
        costs: 0.0,
        score,
        benefits_bound: None,
        left_out: Vec::new(),
        summary: String::new(),
    })
}

fn score(plan: &Plan) -> f64 {
    match plan {
        Plan::SingleVisit(plan) => plan.score,
        Plan::Surveillance(_) => f64::NAN,
    }
}

impl Solver for Bad {
    fn name(&self) -> &str {
        self.0
    }
    fn serves(&self, _: &Problem) -> bool {
        true
    }
    fn solve(&self, problem: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String> {
        if self.0 != "mute" {
            (environment.report)(&plan(1.0));
        }
        let mut hoard: Vec<Vec<u8>> = Vec::new();
        match self.0 {
            "panics" | "mute" => panic!("ran out of ideas"),
            "overruns" => loop {
                environment.budget.charge(10);
            },
            "hoards" => loop {
                hoard.push(vec![7; 1 << 20]);
                environment.budget.charge(1);
                // A hoarder without a limit would fill the machine.
                assert!(hoard.len() < 2_000);
                thread::sleep(Duration::from_micros(100));
            },
            "patient" => {
                while !environment.budget.exhausted() {
                    environment.budget.charge(1);
                    thread::sleep(Duration::from_micros(50));
                }
                let start = match problem {
                    Problem::SingleVisit(problem) => problem.start_s,
                    Problem::Surveillance(_) => f64::NAN,
                };
                return Ok(plan(start + environment.previous.map_or(0.0, score)));
            }
            _ => {}
        }
        Err("no idea".into())
    }
}

/// Returns when the gate opens, and checks nothing before.
struct Sleeper(Arc<AtomicBool>);

impl Solver for Sleeper {
    fn name(&self) -> &str {
        "sleeps"
    }
    fn serves(&self, _: &Problem) -> bool {
        true
    }
    fn solve(&self, _: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String> {
        (environment.report)(&plan(1.0));
        while !self.0.load(Ordering::Relaxed) {
            thread::sleep(Duration::from_millis(1));
        }
        Ok(plan(2.0))
    }
}

fn problem(start_s: f64) -> Arc<Problem> {
    Arc::new(Problem::SingleVisit(SingleVisitProblem { start_s, ..SingleVisitProblem::default() }))
}

const LIMITS: SolverLimits = SolverLimits { units: 1_000, timeout: Duration::from_secs(60), memory_bytes: 1 << 40 };

fn solve_with(name: &'static str, limits: SolverLimits) -> Answer {
    let solver: Arc<dyn Solver> = Arc::new(Bad(name));
    Invocations::new().solve(&solver, &problem(0.0), None, 1, limits, &CancelToken::new())
}

#[test]
fn a_panic_is_named_and_the_best_plan_so_far_counts() {
    let answer = solve_with("panics", LIMITS);
    assert_eq!(answer.plan.map(|plan| score(&plan)), Ok(1.0));
    assert_eq!(answer.violation.as_deref(), Some("the solver panics failed: ran out of ideas"));
    let nothing = solve_with("mute", LIMITS);
    assert_eq!(nothing.plan, Err("the solver mute failed: ran out of ideas".into()));
}

#[test]
fn a_refusal_is_its_own_answer_unless_a_plan_was_reported() {
    let answer = solve_with("honest", LIMITS);
    assert_eq!((answer.plan.map(|plan| score(&plan)), answer.violation), (Ok(1.0), None));
}

#[test]
fn work_beyond_the_budget_ends_at_the_same_unit_in_every_run() {
    let answers = [(); 2].map(|()| solve_with("overruns", LIMITS));
    for answer in answers {
        assert_eq!(answer.plan.map(|plan| score(&plan)), Ok(1.0));
        assert_eq!(answer.used, 2 * LIMITS.units + SOLVER_OVERRUN_UNITS);
        assert_eq!(answer.violation.as_deref(), Some("the solver overruns continued after its 1000 units of work"));
    }
}

#[test]
fn a_solver_that_hangs_is_left_behind_and_others_are_served() {
    let mut invocations = Invocations::new();
    let limits = SolverLimits { timeout: Duration::from_millis(50), ..LIMITS };
    let gate = Arc::new(AtomicBool::new(false));
    let sleeper: Arc<dyn Solver> = Arc::new(Sleeper(Arc::clone(&gate)));
    let mut solve =
        |solver: &Arc<dyn Solver>| invocations.solve(solver, &problem(0.0), None, 1, limits, &CancelToken::new());
    let first = solve(&sleeper);
    assert_eq!(first.violation.as_deref(), Some("the solver sleeps gave no answer within 0.05 s and was abandoned"));
    assert_eq!(first.plan.map(|plan| score(&plan)), Ok(1.0), "its report counts");
    assert_eq!(solve(&sleeper).plan, Err("the solver sleeps still hangs at an earlier problem".into()));
    let other: Arc<dyn Solver> = Arc::new(Bad("honest"));
    assert!(solve(&other).plan.is_ok(), "another solver is served meanwhile");
    gate.store(true, Ordering::Relaxed);
    while Arc::strong_count(&sleeper) > 1 {
        thread::yield_now();
    }
    assert_eq!(solve(&sleeper).plan.map(|plan| score(&plan)), Ok(2.0), "it is asked again after it has returned");
}

#[test]
fn memory_beyond_the_limit_ends_the_work() {
    if resident_bytes().is_none() {
        return;
    }
    let answer = solve_with("hoards", SolverLimits { units: u64::MAX / 4, memory_bytes: 100 << 20, ..LIMITS });
    assert_eq!(answer.violation.as_deref(), Some("the solver hoards took more than 100 MiB of memory"));
    assert_eq!(answer.plan.map(|plan| score(&plan)), Ok(1.0));
}

#[test]
fn a_solver_is_polled_paused_and_cancelled() {
    let endless = SolverLimits { units: u64::MAX / 4, ..LIMITS };
    let begun = Invocation::begin(Arc::new(Bad("patient")), problem(0.0), None, 1, endless).unwrap();
    while begun.best().is_none() || begun.used() == 0 {
        thread::yield_now();
    }
    begun.pause();
    // One unit of work may be in progress.
    thread::sleep(Duration::from_millis(30));
    let used = begun.used();
    thread::sleep(Duration::from_millis(30));
    assert_eq!(begun.used(), used, "nothing is done in a pause");
    begun.resume();
    while begun.used() == used {
        thread::yield_now();
    }
    begun.cancel();
    let answer = begun.finish(&CancelToken::new());
    assert!(answer.plan.is_ok(), "the best plan until then");
    assert_eq!(answer.violation, None);
}

#[test]
fn a_cancelled_planner_returns_its_best_plan() {
    let endless = SolverLimits { units: u64::MAX / 4, ..LIMITS };
    let begun = Invocation::begin(Arc::new(Bad("patient")), problem(4.0), None, 1, endless).unwrap();
    let cancel = CancelToken::new();
    cancel.clone().cancel();
    let answer = begun.finish(&cancel);
    assert_eq!((answer.plan.map(|plan| score(&plan)), answer.violation), (Ok(4.0), None));
}

/// Does not return while the gate is shut.
struct Named(String, Arc<AtomicBool>);

impl Solver for Named {
    fn name(&self) -> &str {
        &self.0
    }
    fn serves(&self, _: &Problem) -> bool {
        true
    }
    fn solve(&self, problem: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String> {
        Sleeper(Arc::clone(&self.1)).solve(problem, environment)
    }
}

#[test]
fn not_more_than_a_few_are_left_behind() {
    let mut invocations = Invocations::new();
    let limits = SolverLimits { timeout: Duration::from_millis(10), ..LIMITS };
    let gate = Arc::new(AtomicBool::new(false));
    for number in 0..SOLVERS_LEFT_BEHIND_MAX {
        let sleeper: Arc<dyn Solver> = Arc::new(Named(format!("sleeper-{number}"), Arc::clone(&gate)));
        assert!(invocations.solve(&sleeper, &problem(0.0), None, 1, limits, &CancelToken::new()).plan.is_ok());
    }
    let honest: Arc<dyn Solver> = Arc::new(Bad("honest"));
    let refusal = invocations.solve(&honest, &problem(0.0), None, 1, limits, &CancelToken::new()).plan.unwrap_err();
    assert!(refusal.starts_with("4 solvers hang and were left behind (sleeper-0, sleeper-1,"), "{refusal}");
    gate.store(true, Ordering::Relaxed);
    while invocations.left_behind.values().any(|shared| !shared.ended.load(Ordering::Acquire)) {
        thread::yield_now();
    }
    assert!(invocations.solve(&honest, &problem(0.0), None, 1, LIMITS, &CancelToken::new()).plan.is_ok());
}
