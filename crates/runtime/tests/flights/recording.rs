//! Uses of a record: traces, replay, restoration, plans that are not computed again.

use crate::support::{CAMERA, altitude, camera, camera_inputs, load, program, record};
use apex_model::effect::SolveRequest;
use apex_model::event::SolverReport;
use apex_model::planned::{PlannedActivity, PlannedProcedure, PlannedStep};
use apex_model::source::SourceFile;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_runtime::mission_loop::EndReason;
use apex_runtime::ports::{Deliberator, Posed, SolverAnswer};
use apex_runtime::program::NoDeliberator;
use apex_runtime::record::{RecordReader, seal_rows};
use apex_runtime::replay::replay;
use apex_runtime::trace::{TraceFilter, TraceFormat, Tracer, trace_record};
use rusqlite::{Connection, params};
use std::path::Path;
use std::sync::Arc;

fn transitions(reader: &RecordReader) -> String {
    let filter = TraceFilter { kinds: ["transition".to_owned(), "event".into()].into(), ..TraceFilter::default() };
    String::from_utf8(trace_record(reader, Vec::new(), TraceFormat::Text, filter).unwrap()).unwrap()
}

#[test]
fn a_program_runs_without_a_vehicle_and_its_trace_states_why() {
    let flight = camera();
    assert!(matches!(flight.end.reason, EndReason::Application { .. }), "{:?}", flight.end);
    assert_eq!(flight.end.at, Time::from_seconds(20.0));
    let text = transitions(&flight.reader());
    for line in [
        "3.5s  event (fire-seen)",
        "(look-at fire): enabled -> ongoing because it was granted flight-path",
        "(patrol): ongoing -> interrupted because",
        "8.5s  T2 (look-at fire): ongoing -> terminated (success) because its duration of P5S is over",
        "(patrol): interrupted -> ongoing because it was granted flight-path",
    ] {
        assert!(text.contains(line), "`{line}` is missing in\n{text}");
    }
    assert_eq!(text.matches("(looking fire)").count(), 1, "an inform is printed once:\n{text}");
}

#[test]
fn live_trace_and_recorded_trace_are_the_same() {
    let (library, _, _) = program(CAMERA);
    let mut tracer = Tracer::new(Vec::new(), TraceFormat::JsonLines, TraceFilter::default(), &library);
    let flight = record(CAMERA, camera_inputs(), &mut NoDeliberator, &mut [&mut tracer]);
    let live = String::from_utf8(tracer.into_inner().unwrap()).unwrap();
    let out = trace_record(&flight.reader(), Vec::new(), TraceFormat::JsonLines, TraceFilter::default()).unwrap();
    assert_eq!(live, String::from_utf8(out).unwrap());
    assert!(live.lines().count() > 20);
}

#[test]
fn replay_confirms_an_honest_record() {
    let flight = camera();
    let report = replay(&flight.reader(), &load).unwrap();
    assert_eq!(report.difference, None, "{report}");
    assert_eq!((report.batches, report.effects), (flight.end.steps, flight.end.effects));
    assert!(report.to_string().starts_with("The record is confirmed:"), "{report}");
}

/// Changes a record and seals it again, so that only replay can notice.
fn tamper(path: &Path, sql: &str, body: Option<Vec<u8>>) {
    let connection = Connection::open(path).unwrap();
    let changed = connection.execute(sql, params![body]).unwrap();
    assert_eq!(changed, 1, "the test must change something");
    reseal(&connection);
}

fn reseal(connection: &Connection) {
    connection.execute("DELETE FROM seal", []).unwrap();
    seal_rows(connection).unwrap();
}

#[test]
fn replay_finds_a_changed_effect_and_reports_both() {
    let flight = camera();
    let connection = Connection::open(&flight.path).unwrap();
    let sql = "SELECT batch, body FROM effects WHERE instr(body, CAST('high' AS BLOB)) > 0 ORDER BY batch DESC";
    let read = |row: &rusqlite::Row<'_>| Ok((row.get::<_, i64>(0)?, row.get::<_, Vec<u8>>(1)?));
    let (batch, mut body) = connection.query_row(sql, [], read).unwrap();
    let said = body.windows(4).rposition(|bytes| bytes == b"high").unwrap();
    body[said..said + 4].copy_from_slice(b"deep");
    tamper(&flight.path, &format!("UPDATE effects SET body = ?1 WHERE batch = {batch}"), Some(body));
    let report = replay(&flight.reader(), &load).unwrap();
    let difference = report.difference.clone().unwrap();
    assert_eq!(difference.at, Time::from_seconds(20.0));
    assert!(difference.recorded.unwrap().ends_with("; deep"));
    assert!(difference.replayed.unwrap().ends_with("; high"));
    assert!(report.to_string().starts_with("The replay differs at 20s, batch "), "{report}");
}

/// Words, shapes, track and the like follow from inputs and effects; a record that was sealed again after a change still differs
/// from its replay.
#[test]
fn replay_finds_every_changed_derived_column() {
    for (sql, what) in [
        ("UPDATE effects SET first = first + 1 WHERE batch = 1", "column `first` of row effects 1"),
        ("INSERT INTO effects VALUES (9999, 9999, x'')", "row effects "),
        ("INSERT INTO word SELECT max(id) + 1, 'land' FROM word", "row word "),
        ("INSERT INTO shape SELECT max(id) + 1, layout, example FROM shape", "row shape "),
        ("UPDATE variable SET name = '(speed ac-1)' WHERE id = 1", "column `name` of row variable 1"),
        ("UPDATE agent SET name = 'anna' WHERE id = 0", "column `name` of row agent 1"),
    ] {
        let flight = camera();
        tamper_plainly(&flight.path, sql);
        let difference = replay(&flight.reader(), &load).unwrap().difference;
        let what_differs = difference.as_ref().map(|difference| difference.what.to_string()).unwrap_or_default();
        assert!(what_differs.starts_with(what), "{sql}: {difference:?}");
    }
}

fn tamper_plainly(path: &Path, sql: &str) {
    let connection = Connection::open(path).unwrap();
    assert_eq!(connection.execute(sql, []).unwrap(), 1, "the test must change something");
    reseal(&connection);
}

#[test]
fn replay_finds_missing_effects_and_changed_programs() {
    let flight = camera();
    let sql = "DELETE FROM effects WHERE ?1 IS NULL AND batch = (SELECT max(batch) FROM effects)";
    tamper(&flight.path, sql, None);
    let difference = replay(&flight.reader(), &load).unwrap().difference.unwrap();
    assert_eq!((difference.recorded.is_none(), difference.replayed.is_some()), (true, true));
    let flight = camera();
    let slower = CAMERA.replace("(duration 5s)", "(duration 6s)").into_bytes();
    tamper(&flight.path, "UPDATE source SET body = ?1", Some(slower));
    let difference = replay(&flight.reader(), &load).unwrap().difference.unwrap();
    assert!(difference.at <= Time::from_seconds(8.5), "{difference:?}");
    tamper(&flight.path, "UPDATE source SET body = ?1", Some(b"(procedure".to_vec()));
    let message = replay(&flight.reader(), &load).unwrap_err().to_string();
    assert!(message.starts_with("the mission inside "), "{message}");
}

/// Tasks, samples and messages reach limits that the program itself has lowered: replay and restoration obey them too.
#[test]
fn limits_that_an_agent_has_lowered_are_those_of_the_replay() {
    let pdl = "(agent pilot :limits (:tasks 6 :history-samples 20 :event-history 3))
      (procedure (index (do-domain))
        (step all (photograph ?site) (forall ?site in (range 9)) (on-failure (photograph 0)))
        (step high (photograph 1) (waitfor (:measurement (altitude ac-1 > 6990) :timestamp (> (- +now+ P50S)))))
        (step said (photograph 2) (waitfor (:atomic-episode (go) :timing (:es (- +now+ P50S))) (never)))
        (step end (terminate) (waitfor (over))))
      (primitive (index (photograph ?site)) (duration 1s))";
    let mut inputs: Vec<_> =
        (0..2000_u32).map(|tick| altitude(f64::from(tick) * 0.05, 6000 + i64::from(tick % 900))).collect();
    inputs.extend([10.0, 20.0, 30.0, 40.0, 50.0].map(|at| crate::support::event(at, "(other)")));
    inputs.push(crate::support::event(99.0, "(over)"));
    inputs.sort_by_key(|input| input.at);
    let flight = record(pdl, inputs, &mut NoDeliberator, &mut []);
    let reader = flight.reader();
    let filter = TraceFilter { kinds: ["trouble".to_owned()].into(), ..TraceFilter::default() };
    let troubles = String::from_utf8(trace_record(&reader, Vec::new(), TraceFormat::Text, filter).unwrap()).unwrap();
    for limit in ["TASKS_MAX = 6", "more than 20 samples of (altitude ac-1)", "more than 3 messages"] {
        assert_eq!(
            troubles.lines().filter(|line| line.contains(limit)).count(),
            1,
            "{limit} is reported once:\n{troubles}"
        );
    }
    let report = replay(&reader, &load).unwrap();
    assert_eq!(report.difference, None, "{report}");
    let restored = |seconds| flight.reader().restore(Time::from_seconds(seconds), &load).unwrap();
    assert_eq!(restored(1e6), flight.agent, "the end is the agent that flew");
    let connection = Connection::open(&flight.path).unwrap();
    connection.execute("DELETE FROM snapshot", []).unwrap();
    reseal(&connection);
    assert_eq!(restored(1e6), flight.agent, "also from its inputs alone");
}

#[test]
fn any_instant_is_restored_from_snapshot_or_from_inputs() {
    let inputs =
        (0..3000_u32).map(|second| altitude(f64::from(second) * 0.03, 6000 + i64::from(second % 900))).collect();
    let flight = record(CAMERA, inputs, &mut NoDeliberator, &mut []);
    let connection = Connection::open(&flight.path).unwrap();
    let count = || connection.query_row("SELECT count(*) FROM snapshot", [], |row| row.get::<_, i64>(0)).unwrap();
    assert!(count() > 0, "this test needs snapshots");
    let at =
        |seconds| postcard::to_stdvec(&flight.reader().restore(Time::from_seconds(seconds), &load).unwrap()).unwrap();
    let from_snapshot = [at(10.0), at(40.0), at(89.0)];
    let last = postcard::to_stdvec(&flight.agent).unwrap();
    assert_eq!(at(1e6), last, "the end is the agent that flew");
    // Snapshots of builds with other types are not read, not even well-formed ones: here each instant has the state of the end.
    let stored = connection.query_row("SELECT value FROM meta WHERE key = 'state_layout'", [], |row| row.get(0));
    let layout: String = stored.unwrap();
    connection.execute("UPDATE snapshot SET body = ?1", [&last]).unwrap();
    reseal(&connection);
    assert_ne!(at(40.0), from_snapshot[1], "the snapshot is read");
    let other = "UPDATE meta SET value = '0' WHERE key = 'state_layout'";
    let older = "DELETE FROM meta WHERE key = 'state_layout'";
    for sql in [other, older, "UPDATE meta SET value = '0.0.1' WHERE key = 'apex_version'"] {
        connection.execute(sql, []).unwrap();
        reseal(&connection);
        assert_eq!(at(40.0), from_snapshot[1], "inputs are enough: {sql}");
    }
    connection.execute("UPDATE snapshot SET body = x'00'", []).unwrap();
    connection.execute("INSERT INTO meta (key, value) VALUES ('state_layout', ?1)", [layout]).unwrap();
    connection.execute("UPDATE meta SET value = ?1 WHERE key = 'apex_version'", [env!("CARGO_PKG_VERSION")]).unwrap();
    reseal(&connection);
    assert_eq!(at(40.0), from_snapshot[1], "a snapshot that cannot be read is skipped");
    connection.execute("DELETE FROM snapshot", []).unwrap();
    reseal(&connection);
    assert_eq!([at(10.0), at(40.0), at(89.0)], from_snapshot);
}

/// Plans two visits after 4 s of planning time; counts the problems that it poses.
#[derive(Default)]
struct Planner(u32);

impl Deliberator for Planner {
    fn pose(&mut self, request: &SolveRequest, _: Time) -> Posed {
        self.0 += 1;
        let visit = |tag: &str, place: &str, line| PlannedStep {
            tag: Symbol::new(tag),
            activity: PlannedActivity::Goal(apex_pdl::read_value(&format!("(visit {place})")).unwrap()),
            line,
        };
        let text = format!("(procedure\n  (index {})\n  (step s1 (visit a))\n  (step s2 (visit b)))", request.goal);
        let plan = PlannedProcedure {
            solver: Symbol::new("two-opt"),
            summary: "2 sites".into(),
            steps: vec![visit("s1", "a", 3), visit("s2", "b", 4)],
            repeat: false,
            plan: None,
            source: SourceFile { name: Arc::from("<plan 1>"), text: Arc::from(text) },
        };
        let answer = SolverAnswer { result: Ok(plan), charged: Duration::from_seconds(4.0) };
        Posed::new(format!("{{\"number\":{}}}", self.0), move |_| answer)
    }
}

const TOUR: &str = r#"
(solver auto (index (tour ?sites)))
(procedure (index (do-domain)) (step t (tour (a b))) (step e (end-application) (waitfor ?t)))
(primitive (index (visit ?site)) (duration 10s))
"#;

#[test]
fn plans_are_flown_named_and_never_made_again() {
    let mut planner = Planner::default();
    let flight = record(TOUR, Vec::new(), &mut planner, &mut []);
    assert_eq!((planner.0, flight.end.at), (1, Time::from_seconds(24.0)));
    let reader = flight.reader();
    let report = replay(&reader, &load).unwrap();
    assert_eq!(report.difference, None, "{report}");
    let tasks = reader.tasks().unwrap();
    let visit = tasks.iter().find(|task| task.goal == "(visit b)").unwrap();
    assert_eq!(visit.place.as_deref(), Some("<plan 1>:4:1"));
    let tour = tasks.iter().find(|task| task.goal == "(tour (a b))").unwrap();
    assert_eq!(tour.method.as_ref().and_then(|method| method.place.as_deref()), Some("<plan 1>:1:1"));
}

/// An answer of a solver is in the record twice: as it arrived, for readers, and as the input of the agent.
#[test]
fn a_recorded_answer_that_the_agent_did_not_receive_is_a_difference() {
    let refusal = postcard::to_stdvec(&SolverReport::Failed("no sites".into())).unwrap();
    for (sql, what) in [
        ("UPDATE answer SET due_ns = due_ns + 1", "answer to request 0"),
        ("UPDATE answer SET request = 7", "answer to request 0"),
        ("UPDATE answer SET report = ?1, detail = 'no sites'", "answer to request 0"),
        ("INSERT INTO answer SELECT 2, request, due_ns, 'no sites', NULL, ?1 FROM answer", "answer to request 0"),
        ("DELETE FROM answer", "answer to request 0"),
        ("UPDATE answer SET plan = '{}'", "column `plan` of row answer 1"),
    ] {
        let flight = record(TOUR, Vec::new(), &mut Planner::default(), &mut []);
        match sql.contains("?1") {
            true => tamper(&flight.path, sql, Some(refusal.clone())),
            false => tamper_plainly(&flight.path, sql),
        }
        let difference = replay(&flight.reader(), &load).unwrap().difference;
        assert_eq!(difference.map(|difference| difference.what.to_string()).as_deref(), Some(what), "{sql}");
    }
}
