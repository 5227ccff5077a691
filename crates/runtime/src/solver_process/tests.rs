//! Programs that misbehave in every way that a process can, and one that works correctly.

use super::*;
use crate::invocation::{Answer, Invocation, SolverLimits};
use crate::ports::CancelToken;
use apex_model::problem::{SingleVisitProblem, SurveillancePlan};
use std::time::Duration;

/// Runs a shell script as solver program of a single-visit problem and returns the answer.
fn ask(script: &str, limits: SolverLimits) -> Answer {
    let command = ["sh", "-c", script].map(OsString::from).to_vec();
    let problem = Arc::new(Problem::SingleVisit(SingleVisitProblem::default()));
    let solver = Arc::new(SolverProgram::new("mine", command));
    Invocation::begin(solver, problem, None, 7, limits).unwrap().finish(&CancelToken::new())
}

fn usual() -> SolverLimits {
    SolverLimits { units: 1_000, timeout: Duration::from_secs(60), memory_bytes: 256 << 20 }
}

/// Returns a plan without visits, as JSON.
fn empty_plan() -> String {
    serde_json::to_string(&Plan::Surveillance(SurveillancePlan {
        solver: "mine".into(),
        cycle: Vec::new(),
        visits: Vec::new(),
        return_s: None,
        expected_cost: 1.0,
        expected_cost_bound: None,
        left_out: Vec::new(),
        summary: "stays at home".into(),
    }))
    .unwrap()
}

#[test]
fn a_program_is_asked_and_answers() {
    let plan = empty_plan();
    let script = format!(
        "read request; echo \"$request\" >&2; echo '{{\"charge\": 40}}'; echo '{{\"report\": {plan}}}'; \
         echo '{{\"charge\": 2}}'; echo '{{\"plan\": {plan}}}'"
    );
    let answer = ask(&script, usual());
    assert!(answer.plan.is_ok(), "{answer:?}");
    assert_eq!((answer.used, answer.violation), (42, None));
    let answer = ask("read request; echo '{\"failed\": \"no way around\"}'", usual());
    assert_eq!((answer.plan.unwrap_err().as_str(), answer.violation), ("no way around", None));
}

#[test]
fn the_request_holds_everything() {
    // The program answers with its own request.
    let script = "read request; r=$(printf '%s' \"$request\" | sed 's/\\\\/\\\\\\\\/g; s/\"/\\\\\"/g'); echo \"{\\\"failed\\\": \\\"$r\\\"}\"";
    let request = ask(script, usual()).plan.unwrap_err();
    for member in [
        "\"apex_solver\":1",
        "\"solver\":\"mine\"",
        "\"seed\":7",
        "\"work_units\":1000",
        "\"problem\":{",
        "\"previous\":null",
    ] {
        assert!(request.contains(member), "{member}: {request}");
    }
}

#[test]
fn every_way_to_break_down_is_an_outcome_with_a_cause() {
    for (script, cause) in [
        ("exit 0", "ended with exit code 0 and without an answer"),
        ("echo 'I am lost' >&2; exit 3", "ended with exit code 3 and without an answer; its last output: `I am lost`"),
        ("kill -SEGV $$", "signal 11 (SIGSEGV"),
        ("kill -ABRT $$", "signal 6 (SIGABRT"),
        ("kill -KILL $$", "signal 9 (SIGKILL)"),
        ("echo hello", "does not follow the protocol (expected value at line 1 column 1): `hello`"),
        ("echo '{\"charge\": 1}'; echo '{\"plan\": 5}'", "no plan"),
        ("head -c 40000000 /dev/zero | tr '\\0' x >&2; sleep 60", "more than 16 MiB to standard error"),
        ("head -c 40000000 /dev/zero | tr '\\0' x; sleep 60", "a line of more than 16 MiB: `xxxx"),
        ("exec 1>&-; sleep 60", "closed its output without an answer"),
    ] {
        let answer = ask(script, usual());
        let violation = answer.violation.unwrap_or_default();
        assert!(violation.starts_with("the solver mine ") && violation.contains(cause), "{script}: {violation}");
        assert_eq!(answer.plan.unwrap_err(), violation, "{script}");
    }
    let unknown = Arc::new(SolverProgram::new("mine", vec!["/no/such/program".into()]));
    let problem = Arc::new(Problem::SingleVisit(SingleVisitProblem::default()));
    let answer = Invocation::begin(unknown, problem, None, 1, usual()).unwrap().finish(&CancelToken::new());
    assert!(answer.violation.unwrap().contains("`/no/such/program` cannot be started"));
}

#[test]
fn a_program_that_hangs_is_killed_with_what_it_started() {
    let folder = tempfile::TempDir::new().unwrap();
    let file = folder.path().join("alive");
    // The grandchild would write the file later.
    let script = format!("(sleep 3; touch '{}') & trap '' TERM; while true; do sleep 0.05; done", file.display());
    let limits = SolverLimits { timeout: Duration::from_millis(300), ..usual() };
    let violation = ask(&script, limits).violation.unwrap();
    assert!(violation.contains("gave no answer within 0.3 s"), "{violation}");
    std::thread::sleep(Duration::from_millis(3_500));
    assert!(!file.exists(), "what the program started lives on");
}

#[test]
fn the_best_plan_of_a_program_that_breaks_down_counts() {
    let plan = empty_plan();
    let answer = ask(&format!("echo '{{\"report\": {plan}}}'; exit 9"), usual());
    assert!(answer.plan.is_ok() && answer.violation.unwrap().contains("exit code 9"));
}

#[test]
fn work_beyond_the_budget_and_memory_end_a_program() {
    let overran = ask("while true; do echo '{\"charge\": 100000}'; done", usual()).violation.unwrap();
    assert!(overran.contains("after its 1000 units of work"), "{overran}");
    let hoards = "x=xxxxxxxxxxxxxxxx; while true; do x=$x$x; done";
    let limits = SolverLimits { memory_bytes: 32 << 20, ..usual() };
    let violation = ask(hoards, limits).violation.unwrap();
    assert!(
        violation.contains("memory") || violation.contains("SIG") || violation.contains("exit code"),
        "{violation}"
    );
}

#[test]
fn a_program_is_notified_when_its_budget_is_used_up() {
    let plan = empty_plan();
    let script = r#"read request; echo '{"charge": 1000}'; read stop; echo "{\"plan\": $plan}""#.to_string();
    let answer = ask(&format!("plan='{plan}'; {script}"), usual());
    assert!(answer.plan.is_ok() && answer.violation.is_none(), "{answer:?}");
}

#[test]
fn a_solver_in_rust_serves_the_protocol() {
    struct Counts;
    impl Solver for Counts {
        fn name(&self) -> &str {
            "counts"
        }
        fn serves(&self, _: &Problem) -> bool {
            true
        }
        fn solve(&self, _: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String> {
            while !environment.budget.exhausted() {
                environment.budget.charge(7);
            }
            Err(format!("seed {}, {} units", environment.seed, environment.budget.used()))
        }
    }
    let request = ProgramRequest {
        apex_solver: VERSION,
        solver: "counts".into(),
        seed: 3,
        work_units: 25_000,
        problem: Problem::SingleVisit(SingleVisitProblem::default()),
        previous: None,
    };
    // The input does not end: a thread waits for its next line.
    let (reader, mut writer) = std::io::pipe().unwrap();
    std::io::Write::write_all(&mut writer, format!("{}\n", serde_json::to_string(&request).unwrap()).as_bytes())
        .unwrap();
    let mut output = Vec::new();
    serve(&Counts, std::io::BufReader::new(reader), &mut output).unwrap();
    std::mem::forget(writer);
    let lines = String::from_utf8(output).unwrap();
    let lines: Vec<&str> = lines.lines().collect();
    assert_eq!(
        lines,
        ["{\"charge\":10003}", "{\"charge\":10003}", "{\"charge\":4998}", "{\"failed\":\"seed 3, 25004 units\"}"]
    );
}
