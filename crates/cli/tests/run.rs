//! `apex run`: inputs, trace, time limit, record.

mod common;

use common::{Desk, GO};

#[test]
fn the_trace_is_what_its_page_says() {
    let desk = Desk::with_greetings();
    let said = desk.apex(&["run", "greetings.pdl", "--inputs", "go.jsonl"]).well();
    let lines: Vec<&str> = said.out.lines().collect();
    let expected = [
        r#"{"t":0,"kind":"transition","task":"T1","goal":"(greet world)","from":"pending","state":"enabled","cause":"there is nothing to wait for","place":"greetings.pdl:3:3"}"#,
        r#"{"t":0,"kind":"event","task":"T1","goal":"(greet world)","form":"(greeted world)"}"#,
        r#"{"t":7,"kind":"event","form":"(go)"}"#,
        r#"{"t":7,"kind":"end","reason":"the initial task is done"}"#,
    ];
    let mut rest = lines.iter();
    for line in expected {
        assert!(rest.any(|found| *found == line), "{line}\nis not in, or not in order:\n{}", said.out);
    }
    assert_eq!(rest.next(), None, "the end is the end");
    let times: Vec<f64> = said.json_lines().iter().map(|line| line["t"].as_f64().unwrap()).collect();
    assert!(times.is_sorted(), "{times:?}");
    let printed: Vec<String> = said
        .json_lines()
        .iter()
        .filter(|line| line["kind"] == "print")
        .map(|line| line["text"].as_str().unwrap().split_whitespace().collect::<Vec<_>>().join(" "))
        .collect();
    assert_eq!(printed, ["hello world", "hello moon"]);
}

#[test]
fn the_same_run_gives_the_same_bytes() {
    let desk = Desk::with_greetings();
    let run = |trace: &str| {
        let arguments = ["run", "greetings.pdl", "--inputs", "go.jsonl", "--trace", trace];
        assert_eq!(desk.apex(&arguments).well().out, "");
        desk.read(trace)
    };
    assert_eq!(run("one.jsonl"), run("two.jsonl"));
    let heard = desk.apex_hearing(&["run", "greetings.pdl", "--inputs", "-", "--trace", "-"], GO).well();
    assert_eq!(heard.out, desk.read("one.jsonl"), "standard input is as good as a file");
}

#[test]
fn text_is_for_operators() {
    let desk = Desk::with_greetings();
    let said = desk.apex(&["run", "greetings.pdl", "--inputs", "go.jsonl", "--text"]).well();
    said.told(&["          7s  T2 (greet moon): pending -> enabled because ", "end: the initial task is done"]);
}

#[test]
fn the_time_limit_and_the_lack_of_anything_to_do_are_reported() {
    let desk = Desk::with_greetings();
    let early = ["run", "greetings.pdl", "--inputs", "go.jsonl", "--until", "3s"];
    let said = desk.apex(&early).complained(0, &["note: the run ended at 3s because the time limit was reached"]);
    assert!(!said.out.contains("(go)"), "{}", said.out);
    desk.apex(&["run", "greetings.pdl"]).complained(0, &["note: the run ended at 0s because nothing more can happen"]);
    let late = ["run", "greetings.pdl", "--inputs", "go.jsonl", "--until", "0:00:07"];
    desk.apex(&late).well().told(&["the initial task is done"]);
}

#[test]
fn a_run_can_be_recorded_replayed_and_explained() {
    let desk = Desk::with_greetings();
    desk.apex(&["run", "greetings.pdl", "--inputs", "go.jsonl", "--record", "r.apex", "--trace", "t"]).well();
    desk.apex(&["replay", "r.apex"]).well().told(&["The record is confirmed"]);
    let why = desk.apex(&["why", "r.apex", "b", "--at", "5"]).well();
    why.told(&["T2 (greet moon) is pending at 5s.", "What it waits for:", "(go)"]);
    let traced = desk.apex(&["trace", "r.apex", "--json"]).well();
    assert_eq!(traced.out, desk.read("t"), "live and recorded traces are the same");
}

#[test]
fn bad_inputs_are_named_line_by_line() {
    let desk = Desk::with_greetings();
    desk.write("bad.jsonl", "# fine\n{\"t\": 1, \"evnt\": \"(go)\"}\n{\"t\": -1, \"event\": \"(go)\"}\n{\"t\n");
    let phrases =
        ["bad.jsonl:2: expected exactly one of", "bad.jsonl:3: \"t\" is -1", "bad.jsonl:4:", "help: each line"];
    desk.apex(&["run", "greetings.pdl", "--inputs", "bad.jsonl"]).complained(2, &phrases);
    let heard = desk.apex_hearing(&["run", "greetings.pdl", "--inputs", "-"], "nonsense");
    heard.complained(2, &["<standard input>:1:"]);
    desk.apex(&["run", "greetings.pdl", "--inputs", "gone.jsonl"])
        .complained(2, &["cannot read gone.jsonl", "go.jsonl"]);
}

#[test]
fn no_output_replaces_a_flight_record() {
    let desk = Desk::with_greetings();
    desk.apex(&["run", "greetings.pdl", "--inputs", "go.jsonl", "--record", "kept.apex"]).well();
    let kept = std::fs::read(desk.path("kept.apex")).unwrap();
    for arguments in [
        &["run", "greetings.pdl", "--trace", "kept.apex"][..],
        &["export", "go.jsonl", "--format", "csv", "--out", "kept.apex"],
    ] {
        desk.apex(arguments).complained(2, &["kept.apex is a flight record, which would be overwritten"]);
    }
    assert_eq!(std::fs::read(desk.path("kept.apex")).unwrap(), kept);
}

#[test]
fn the_trace_is_never_written_over_what_is_run() {
    let desk = Desk::with_greetings();
    let program = desk.read("greetings.pdl");
    let arguments = ["run", "greetings.pdl", "--trace", "greetings.pdl"];
    desk.apex(&arguments).complained(2, &["would overwrite the program", "greetings.pdl"]);
    let arguments = ["run", "greetings.pdl", "--inputs", "go.jsonl", "--trace", "./go.jsonl"];
    desk.apex(&arguments).complained(2, &["would overwrite the file of inputs", "help: give `--trace` another file"]);
    assert_eq!((desk.read("greetings.pdl"), desk.read("go.jsonl")), (program, GO.to_string()));
    let both = ["run", "greetings.pdl", "--inputs", "go.jsonl", "--trace", "new", "--record", "./new"];
    desk.apex(&both).complained(2, &["would overwrite the flight record", "help: give `--trace` another file"]);
    let arguments = ["run", "greetings.pdl", "--trace", "no/such/trace"];
    desk.apex(&arguments).complained(2, &["cannot write the trace to no/such/trace", "why: ", "help: "]);
}

#[test]
fn a_failing_expression_is_a_failed_task_with_its_place() {
    let desk = Desk::new();
    desk.write(
        "z.pdl",
        "(procedure (index (do-domain)) (step a (divide 0)))\n(primitive (index (divide ?by)) (on-start (print (/ 1 ?by))))\n",
    );
    let said = desk.apex(&["run", "z.pdl", "--text"]).well();
    said.told(&["(failure) because", "by zero", "z.pdl:2:", "end: the initial task failed"]);
}

#[test]
fn a_model_that_no_flight_would_use_is_refused() {
    let desk = Desk::with_mission("first-picture");
    desk.change("m/mission.pdl", ":type native-sim", ":type native-sim :diagnosis \"model.json\"");
    let phrases = ["`:diagnosis` has no effect in this run", "help: fly it with `apex fly`"];
    desk.apex(&["run", "m"]).complained(2, &phrases);
}

#[test]
fn success_is_that_of_the_initial_task_whatever_the_words_of_the_end() {
    let desk = Desk::new();
    let program = |watch: &str| format!("(agent a)\n(procedure (index (do-domain)) (step s (watch)))\n{watch}\n");
    let ended = "(primitive (index (watch)) (on-enablement (end-application \"no camera failed\")))";
    desk.write("ended.pdl", &program(ended));
    desk.write("failed.pdl", &program("(procedure (index (watch)) (step b (terminate +self+ failure)))"));
    let ended = desk.apex(&["run", "ended.pdl", "--expect", "success"]).well();
    assert!(ended.out.contains("\"reason\":\"no camera failed\""), "{}", ended.out);
    let failed = desk.apex(&["run", "failed.pdl", "--expect", "success"]);
    failed.complained(1, &["expected the run to succeed, but it ended because the initial task failed"]);
}

#[test]
fn acknowledgements_without_a_command_are_noted() {
    let desk = Desk::new();
    desk.write(
        "shots.pdl",
        "(procedure :sequential (index (do-domain)) (step a (shoot)) (step b (shoot)))\n\
         (primitive (index (shoot)) (on-start (command (take-picture camera-1))))\n",
    );
    let inputs = [
        r#"{"t": 1, "acknowledge": "(take-picture camera-1)"}"#,
        r#"{"t": 2, "acknowledge": "(take-picture camera-2)", "error": "no card"}"#,
        r#"{"t": 3, "acknowledge": 1}"#,
        r#"{"t": 4, "acknowledge": 7}"#,
    ];
    desk.write("in.jsonl", &inputs.join("\n"));
    let said = desk.apex(&["run", "shots.pdl", "--inputs", "in.jsonl", "--text"]).complained(
        0,
        &[
            "note: an input acknowledges `(take-picture camera-2)` at 2s, but",
            "note: an input acknowledges command 7, but",
        ],
    );
    assert_eq!(said.err.matches("note: ").count(), 2, "{}", said.err);
    desk.write("in.jsonl", r#"{"t": 1, "acknowledge": "take-picture"}"#);
    let word = desk.apex(&["run", "shots.pdl", "--inputs", "in.jsonl"]);
    word.complained(2, &["in.jsonl:1: \"acknowledge\" is \"take-picture\"; expected the form of a command"]);
}
