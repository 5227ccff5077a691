//! Runs with input from outside: scripted and typed answers, wall-clock time, an external simulator.

#![allow(clippy::unwrap_used, reason = "a test that cannot start its program has failed")]

mod common;

use common::Desk;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};

const ASKING: &str = "(defapplication \"Ask\" :type KIND :agents ((agent pilot)))
(procedure :seq (index (do-domain))
  (step ask (ask operator \"Ready?\" :options (yes no) :by 60s :default no) => ?answer)
  (step tell (print \"the operator says\" ?answer)))
";

fn asking(kind: &str) -> Desk {
    let desk = Desk::new();
    desk.write("ask.pdl", &ASKING.replace("KIND", kind));
    desk
}

#[test]
fn scripted_answers_come_after_their_time() {
    let desk = asking("native-sim");
    desk.write("answers.jsonl", "{\"question\": \"READY\", \"value\": \"Yes\", \"after\": 5}\n");
    let said = desk.apex(&["run", "ask.pdl", "--answers", "answers.jsonl", "--text", "--record", "r.apex"]).well();
    said.told(&["  5s  operator answers question 0: \"Yes\"", "prints the operator says yes"]);
    desk.apex(&["replay", "r.apex"]).well().told(&["The record is confirmed: "]);
    desk.apex(&["why", "r.apex", "ask"]).well().told(&["the operator answered yes"]);
    desk.apex(&["run", "ask.pdl", "--text"]).well().told(&["0:01:00  ", "the operator says no"]);
    desk.write("answers.jsonl", "{\"question\": \"ready\"}\n");
    let answers = ["run", "ask.pdl", "--answers", "answers.jsonl"];
    desk.apex(&answers).complained(2, &["answers.jsonl:1: \"value\" is missing"]);
}

/// Starts a run and returns its lines on standard error.
fn started(desk: &Desk, arguments: &[&str]) -> (Child, impl Iterator<Item = String>) {
    let mut command = desk.command(arguments);
    let mut run = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let lines = BufReader::new(run.stderr.take().unwrap()).lines().map(Result::unwrap);
    (run, lines)
}

#[test]
fn questions_of_a_real_time_run_are_answered_on_its_input() {
    let desk = asking("realtime");
    let (mut run, mut lines) = started(&desk, &["run", "ask.pdl", "--text"]);
    assert_eq!(lines.next().unwrap(), "? 0: Ready? [yes, no] (no is taken at 0:01:00)");
    let mut input = run.stdin.take().unwrap();
    input.write_all(b"maybe\nyes\n").unwrap();
    let refused = lines.next().unwrap();
    assert!(refused.contains("the answer \"maybe\" to question 0 is not one of yes, no"), "{refused}");
    let output = run.wait_with_output().unwrap();
    assert!(output.status.success());
    assert!(String::from_utf8_lossy(&output.stdout).contains("the operator says yes"));
}

#[test]
fn a_real_time_run_takes_inputs_and_ends_when_it_is_asked_to() {
    let desk = Desk::new();
    desk.write(
        "live.pdl",
        "(defapplication \"Live\" :type realtime :agents ((agent pilot)))
(procedure :seq (index (do-domain))
  (on-end (print \"moored\"))
  (step wait (print \"it goes\" ?where) (waitfor (go ?where)))
  (step stay (stay 10h)))
(primitive (index (stay ?time)) (duration ?time))
",
    );
    let lines = "nonsense\n{\"event\": \"(go up)\"}\nstop\n";
    let phrases = ["it was stopped from outside", "no question is open that `nonsense` could answer"];
    desk.apex_hearing(&["run", "live.pdl", "--text"], lines).complained(0, &phrases).told(&["it goes up", "moored"]);
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_real_time_run_cleanly() {
    let desk = asking("realtime");
    let (mut run, mut lines) = started(&desk, &["run", "ask.pdl", "--text", "--record", "r.apex"]);
    assert!(lines.next().unwrap().contains("Ready?"));
    let killed = Command::new("kill").args(["-INT", &run.id().to_string()]).status().unwrap();
    assert!(killed.success());
    assert!(run.wait().unwrap().success());
    let trace = desk.apex(&["trace", "r.apex"]).well();
    trace.told(&["question 0 withdrawn", "(cut) because the application ends: it was stopped from outside"]);
    desk.apex(&["replay", "r.apex"]).well().told(&["The record is confirmed: "]);
}

#[test]
fn an_outside_simulator_owns_the_clock() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/foreign-sim");
    let python = Command::new("python3")
        .args([root.join("simulator.py").as_os_str(), env!("CARGO_BIN_EXE_apex").as_ref()])
        .arg(root.join("balloon.pdl"))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&python.stdout);
    assert!(python.status.success(), "{said}{}", String::from_utf8_lossy(&python.stderr));
    let expected = [
        "agents: balloonist - says: (balloon at 0m)",
        "\"form\": \"(burn-until 300m)\", \"t\": 0",
        "100 s, 300 m: {\"command\": 1, \"form\": \"(vent-until 0m)\", \"t\": 100}",
        "160 s, 0 m: {\"inform\": \"(landed)\", \"t\": 160}",
        "end: the initial task is done - says: (moor)",
    ];
    for line in expected {
        assert!(said.contains(line), "{line} is not in\n{said}");
    }
}

#[test]
fn a_simulators_mistakes_are_answered_and_change_nothing() {
    let desk = Desk::new();
    desk.write(
        "sim.pdl",
        "(defapplication \"Sim\" :type foreign-sim :reset (from the start) :agents ((agent a)))
(procedure :seq (index (do-domain))
  (step wait (print \"seen at\" +now+) (waitfor (seen)))
  (step work (work)))
(primitive (index (work)) (on-start (command (work))))
",
    );
    let lines = "nonsense
{\"advance\": 5}
{\"advance\": 3}
{\"advance\": 6, \"inputs\": [{\"t\": 9, \"event\": \"(seen)\"}]}
{\"advance\": 6, \"inputs\": [{\"agent\": \"b\", \"event\": \"(seen)\"}]}
{\"advance\": 6, \"inputs\": [{\"t\": 5.5, \"event\": \"(seen)\"}]}
{\"reset\": true}
{\"advance\": 1, \"inputs\": [{\"event\": \"(seen)\"}]}
{\"advance\": 2, \"inputs\": [{\"acknowledge\": 0}]}
";
    let said = desk.apex_hearing(&["run", "sim.pdl"], lines).well();
    let answers = said.json_lines();
    let error = |index: usize| answers[index]["error"].as_str().unwrap_or_default().to_string();
    assert_eq!(answers[0]["agents"][0], "a");
    assert!(error(1).contains("not JSON"), "{said:?}");
    assert_eq!(answers[2]["wake"], serde_json::Value::Null);
    assert!(error(3).contains("goes back from 5s to 3s"), "{said:?}");
    assert!(error(4).contains("9s is after 6s"), "{said:?}");
    assert!(error(5).contains("agent b, which does not exist"), "{said:?}");
    let effects: Vec<String> = answers[6]["effects"].as_array().unwrap().iter().map(ToString::to_string).collect();
    assert_eq!(effects, ["{\"print\":\"seen at 5.5s\",\"t\":5.5}", "{\"command\":0,\"form\":\"(work)\",\"t\":5.5}"]);
    assert_eq!(answers[7]["effects"][0]["withdraw"], 0, "a reset ends cleanly: {said:?}");
    assert_eq!(answers[8]["say"][0], "(from the start)");
    assert_eq!(answers[9]["effects"][0]["print"], "seen at 1s");
    assert_eq!(answers[10]["end"], "the initial task is done");
}

#[test]
fn options_without_a_meaning_are_refused() {
    let desk = asking("foreign-sim");
    desk.apex(&["run", "ask.pdl", "--interactive"]).complained(2, &["`--interactive` has no meaning", "foreign-sim"]);
    desk.apex(&["run", "ask.pdl", "--trace", "-"]).complained(2, &["mix the trace with the lines"]);
}

#[test]
fn a_port_takes_inputs_of_a_real_time_run() {
    let desk = asking("realtime");
    let (run, mut lines) = started(&desk, &["run", "ask.pdl", "--text", "--listen", "0"]);
    let told = lines.next().unwrap();
    let address = told.strip_prefix("listening on ").unwrap().to_string();
    assert!(lines.next().unwrap().contains("Ready?"));
    let mut stream = std::net::TcpStream::connect(address).unwrap();
    stream.write_all(b"{\"answer\": 0, \"value\": \"no\"}\n").unwrap();
    let output = run.wait_with_output().unwrap();
    assert!(output.status.success());
    assert!(String::from_utf8_lossy(&output.stdout).contains("the operator says no"));
}
