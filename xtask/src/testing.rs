//! `cargo xtask test ARGUMENTS..` builds tests in the same way as `cargo test`, and runs several test programs at a time. `cargo test`
//! runs them in sequence, so that a program with one long test leaves all other processors idle. The longest programs begin first, and
//! each reports its time.

use serde::Deserialize;
use std::collections::VecDeque;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::thread;
use std::time::Instant;

/// A line of `cargo test --no-run --message-format=json`.
#[derive(Deserialize)]
struct CargoMessage {
    reason: String,
    executable: Option<String>,
    manifest_path: Option<String>,
    profile: Option<ArtifactProfile>,
}

#[derive(Deserialize)]
struct ArtifactProfile {
    test: bool,
}

/// Names of the programs that take longest and begin first, because a long program that begins last keeps a single processor busy.
const LONGEST: &[&str] = &[
    "fault_simulator",
    "living_world",
    "odd_missions",
    "truth",
    "apex_solvers",
    "apex_executive",
    "guarded_flights",
    "mistakes",
    "random",
    "structure_watch",
    "contention_twin",
    "causes",
    "proofs",
    "communication",
    "plan_output",
    "budgets",
    "brute_force",
    "flights",
    "explanations",
];

/// Names of the programs whose tests mostly wait, such as paced flights. They run in sequence while the others run, since they
/// need little of a processor.
const WAITING: &[&str] = &["mission_simulators"];

/// A program of tests.
struct TestProgram {
    executable: String,
    /// The folder of its package, in which `cargo test` runs the program.
    folder: String,
}

/// Builds and runs the tests selected by `arguments` of `cargo test`. Prints the output of each program when it ends.
///
/// # Errors
/// A failed build; the names of the programs with failed tests.
pub(crate) fn run(root: &Path, arguments: &[&str]) -> Result<String, String> {
    let mut programs = build(root, arguments)?;
    let environment = environment(root)?;
    // The sort is stable: all others keep the order of cargo.
    programs.sort_by_key(|program| rank(&program.executable));
    let count = programs.len();
    let at_once = thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let (waiting, working) = programs.into_iter().partition(|program| WAITING.contains(&target(&program.executable)));
    let (waiting, working) = (Mutex::new(waiting), Mutex::new(working));
    let failed = Mutex::new(Vec::new());
    thread::scope(|scope| {
        scope.spawn(|| run_all(&waiting, &failed, &environment));
        for _ in 0..at_once {
            scope.spawn(|| run_all(&working, &failed, &environment));
        }
    });
    let failed = failed.into_inner().map_err(|_| "a thread that ran tests panicked".to_string())?;
    match failed.as_slice() {
        [] => Ok(format!("{count} programs of tests passed")),
        some => Err(format!("tests failed in {} of {count} programs:\n  {}", some.len(), some.join("\n  "))),
    }
}

/// Runs programs until none is left, and collects those with failed tests.
fn run_all(open: &Mutex<VecDeque<TestProgram>>, failed: &Mutex<Vec<String>>, environment: &[(String, String)]) {
    while let Some(program) = next(open) {
        if !passes(&program, environment)
            && let Ok(mut failed) = failed.lock()
        {
            failed.push(program.executable);
        }
    }
}

/// Returns the position of a program in [`LONGEST`]; programs that are not in the list come after these.
fn rank(executable: &str) -> usize {
    let name = target(executable);
    LONGEST.iter().position(|long| *long == name).unwrap_or(LONGEST.len())
}

/// Returns the name of a program's target; cargo appends a hash to it.
fn target(executable: &str) -> &str {
    let file = Path::new(executable).file_name().and_then(|name| name.to_str()).unwrap_or_default();
    file.rsplit_once('-').map_or(file, |(name, _)| name)
}

fn next(open: &Mutex<VecDeque<TestProgram>>) -> Option<TestProgram> {
    open.lock().ok()?.pop_front()
}

/// Returns the variables that `.cargo/config.toml` sets for programs run by cargo, such as the seed of property tests, because this
/// program may have been started without cargo. Variables that are already set keep their values.
fn environment(root: &Path) -> Result<Vec<(String, String)>, String> {
    let path = root.join(".cargo/config.toml");
    let text = std::fs::read_to_string(&path).map_err(|error| format!("cannot read {}: {error}", path.display()))?;
    let config: toml::Table = text.parse().map_err(|error| format!("{}: {error}", path.display()))?;
    let set = config.get("env").and_then(toml::Value::as_table).into_iter().flatten();
    let set = set.filter_map(|(name, value)| Some((name.clone(), value.as_str()?.to_string())));
    Ok(set.filter(|(name, _)| std::env::var_os(name).is_none()).collect())
}

/// Runs one program; true if all of its tests pass.
fn passes(program: &TestProgram, environment: &[(String, String)]) -> bool {
    let begin = Instant::now();
    let output = Command::new(&program.executable)
        .arg("--quiet")
        .current_dir(&program.folder)
        .env("CARGO_MANIFEST_DIR", &program.folder)
        .envs(environment.iter().map(|(name, value)| (name, value)))
        .stdin(Stdio::null())
        .output();
    match output {
        Ok(output) => {
            let text = [output.stdout, output.stderr].concat();
            let seconds = begin.elapsed().as_secs_f64();
            println!("{} ({seconds:.1} s)\n{}", program.executable, String::from_utf8_lossy(&text).trim());
            output.status.success()
        }
        Err(error) => {
            println!("{}: cannot be started: {error}", program.executable);
            false
        }
    }
}

/// Builds the test programs and returns them.
fn build(root: &Path, arguments: &[&str]) -> Result<Vec<TestProgram>, String> {
    let output = Command::new("cargo")
        .arg("test")
        .args(arguments)
        .args(["--no-run", "--message-format=json-render-diagnostics"])
        .current_dir(root)
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| format!("cannot run cargo test: {error}"))?;
    if !output.status.success() {
        return Err("the tests cannot be built".to_string());
    }
    let mut programs = Vec::new();
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        let message: CargoMessage =
            serde_json::from_str(line).map_err(|error| format!("cargo wrote an unknown line: {error}: {line}"))?;
        let is_test = message.reason == "compiler-artifact" && message.profile.is_some_and(|profile| profile.test);
        let folder = message.manifest_path.as_deref().and_then(|path| Path::new(path).parent());
        if let (true, Some(executable), Some(folder)) = (is_test, message.executable, folder) {
            programs.push(TestProgram { executable, folder: folder.display().to_string() });
        }
    }
    Ok(programs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_seed_of_property_tests_is_set_without_cargo() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let set = environment(&root).expect("the configuration of cargo is read");
        let is_set = |name: &str| std::env::var_os(name).is_some() || set.iter().any(|(known, _)| known == name);
        assert!(is_set("PROPTEST_RNG_SEED") && is_set("PROPTEST_DISABLE_FAILURE_PERSISTENCE"), "{set:?}");
    }

    #[test]
    fn artifacts_of_cargo_are_read() {
        let line = r#"{"reason":"compiler-artifact","package_id":"x","manifest_path":"/a/b/Cargo.toml","target":{},"profile":{"opt_level":"3","test":true},"executable":"/t/x-1","fresh":true}"#;
        let message: CargoMessage = serde_json::from_str(line).expect("a line of cargo");
        assert!(message.profile.is_some_and(|profile| profile.test));
        assert_eq!(message.executable.as_deref(), Some("/t/x-1"));
        let end: CargoMessage =
            serde_json::from_str(r#"{"reason":"build-finished","success":true}"#).expect("a line of cargo");
        assert!(end.executable.is_none());
    }
}
