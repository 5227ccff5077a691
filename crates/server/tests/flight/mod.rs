//! Writes a plausible flight record with the schema of `docs/reference/flight-record.md`: a fire-mapping flight of some hours over the
//! western states. For tests of the server and for work on the page; not part of the product.

// Shared by a test and an example, of which each uses a part.
#![allow(unreachable_pub, dead_code, missing_docs, clippy::unwrap_used, clippy::indexing_slicing)]

pub mod story;

use apex_model::because::{Because, Cause};
use apex_model::effect::{CommandId, Decision, DecisionKind, Effect, Method, SolveRequest, SolveRequestId};
use apex_model::library::Library;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::record::{EffectRows, RecordOptions, Recorder, seal_rows};
use rusqlite::{Connection, params};
use std::collections::BTreeMap;
use std::path::Path;
use story::{Entry, Sample, Story};

/// A record on disk that can be written bit by bit, as a live flight does.
pub struct Writer {
    connection: Connection,
    effects: EffectRows,
    batches: i64,
    goals: BTreeMap<u64, String>,
}

impl Writer {
    /// Returns a new record at `path` with the mission's files and targets, and nothing flown.
    pub fn new(path: &Path, story: &Story) -> Writer {
        // The tables are the recorder's; the rows are invented.
        drop(Recorder::create(path, &Library::default(), RecordOptions::default()).unwrap());
        let connection = Connection::open(path).unwrap();
        let meta = [
            ("mission", "western-states"),
            ("agent", "pilot-1"),
            ("vehicle", "predator-b"),
            ("epoch_utc", "2007-09-08T01:00:00Z"),
        ];
        for (key, value) in meta {
            connection.execute("INSERT INTO meta (key, value) VALUES (?1, ?2)", [key, value]).unwrap();
        }
        let pdl = story::PDL.as_bytes();
        connection
            .execute(
                "INSERT INTO source (position, name, role, body) VALUES (1, 'western-states.pdl', 'pdl', ?1)",
                [pdl],
            )
            .unwrap();
        for target in &story.targets {
            let row = params![target.id, target.name, target.latitude_deg, target.longitude_deg, target.value, ""];
            connection
                .execute(
                    "INSERT INTO target (id, name, latitude_deg, longitude_deg, value, geometry) \
                     VALUES (?1, ?2, ?3, ?4, ?5, ?6)",
                    row,
                )
                .unwrap();
        }
        seal_rows(&connection).unwrap();
        Writer { connection, effects: EffectRows::default(), batches: 0, goals: BTreeMap::new() }
    }

    /// Writes everything of the story in `from_ns..to_ns`.
    pub fn write(&mut self, story: &Story, from_ns: i64, to_ns: i64) {
        let window = from_ns..to_ns;
        self.connection.execute_batch("BEGIN").unwrap();
        for (t_ns, entry) in story.entries.iter().filter(|(t_ns, _)| window.contains(t_ns)) {
            self.entry(*t_ns, entry);
        }
        for sample in story.samples.iter().filter(|sample| window.contains(&sample.t_ns)) {
            self.sample(sample);
        }
        seal_rows(&self.connection).unwrap();
        self.connection.execute_batch("COMMIT").unwrap();
    }

    /// Closes the record properly.
    pub fn complete(self, story: &Story) {
        self.connection.execute_batch("BEGIN").unwrap();
        let end = story.end_ns().to_string();
        for (key, value) in [("end_ns", end.as_str()), ("end_reason", "the root task ended"), ("complete", "1")] {
            self.connection.execute("INSERT INTO meta (key, value) VALUES (?1, ?2)", [key, value]).unwrap();
        }
        let sections = [
            ("score", r#"{"score": 0.87, "value_observed": 38.5, "value_possible": 44.2}"#),
            ("coverage", r#"{"observed": 9, "skipped": 1, "of": 10}"#),
        ];
        for (position, (section, body)) in sections.into_iter().enumerate() {
            self.connection
                .execute("INSERT INTO report VALUES (?1, ?2, ?3)", params![position as i64 + 1, section, body])
                .unwrap();
        }
        seal_rows(&self.connection).unwrap();
        self.connection.execute_batch("COMMIT; PRAGMA wal_checkpoint(TRUNCATE)").unwrap();
    }

    fn entry(&mut self, t_ns: i64, entry: &Entry) {
        self.batches += 1;
        self.connection
            .execute("INSERT INTO batch (id, t_ns, events, agent) VALUES (?1, ?2, x'', 0)", params![self.batches, t_ns])
            .unwrap();
        let (task, kind, text, place) = match entry {
            Entry::Created { task, parent, tag, goal, place, text } => {
                self.goals.insert(*task, goal.clone());
                let (parent, tag, goal) = (parent.map(TaskId), Symbol::new(tag), Value::symbol(goal));
                let kind = DecisionKind::Created { parent, tag, goal, place: place_of(place) };
                (Some(*task), kind, text, place_of(place))
            }
            Entry::Selected { task, method, text } => {
                let goal = self.goals.get(task).cloned().unwrap_or_default();
                let method = method_of(method);
                (
                    Some(*task),
                    DecisionKind::Selected { method, goal: Value::symbol(&goal), alternatives: vec![] },
                    text,
                    None,
                )
            }
            Entry::Transition { task, from, to, outcome, text, place } => {
                let outcome = outcome.map(|word| match word {
                    "success" => Outcome::Success(Value::nil()),
                    "failure" => Outcome::Failure,
                    _ => Outcome::Cut,
                });
                let kind = DecisionKind::Transition { from: state(from), to: state(to), outcome };
                (Some(*task), kind, text, place_of(place))
            }
            Entry::Other { kind: "satisfied", task, subject, text } => {
                let now = Time(t_ns);
                let kind = DecisionKind::Satisfied { clause: subject.clone().into(), interval: (now, now) };
                (*task, kind, text, None)
            }
            Entry::Other { kind: "solve", task, subject, .. } => {
                let (request, task) = (SolveRequestId(1), TaskId(task.unwrap_or(0)));
                let (goal, solver) = (Value::symbol(subject), Symbol::new("2-Opt"));
                let is_failure_handled = false;
                let solve = SolveRequest { request, task, goal, solver, budget: None, is_failure_handled };
                self.effect(t_ns, Effect::Solve(solve));
                return;
            }
            Entry::Other { kind: "command", task, subject, .. } => {
                let (command, task) = (CommandId(self.batches as u64), TaskId(task.unwrap_or(0)));
                let because = Because::new(Cause::Repetition, None);
                self.effect(t_ns, Effect::Command { command, task, form: Value::symbol(subject), because });
                return;
            }
            Entry::Other { kind: "print", task, text, .. } => {
                let task = TaskId(task.unwrap_or(0));
                self.effect(t_ns, Effect::Print { task, text: text.clone() });
                return;
            }
            Entry::Other { task, subject, text, .. } => {
                (*task, DecisionKind::Trouble { message: subject.clone() }, text, None) // english: allow
            }
            Entry::Target { target, state, detail } => {
                let row = params![target, t_ns, state, detail];
                self.connection
                    .execute("INSERT INTO target_state (target, t_ns, state, detail) VALUES (?1, ?2, ?3, ?4)", row)
                    .unwrap();
                return;
            }
        };
        let cause = Cause::NobodyHears { message: text.clone() };
        let because = Because::new(cause, place);
        self.effect(t_ns, Effect::Decided(Decision { task: task.map(TaskId), kind, because }));
    }

    fn effect(&mut self, t_ns: i64, effect: Effect) {
        self.effects.insert(&self.connection, (self.batches, Time(t_ns)), &[effect]).unwrap();
    }

    fn sample(&self, s: &Sample) {
        let row = params![
            s.t_ns,
            s.latitude_deg,
            s.longitude_deg,
            s.altitude_m,
            s.heading_deg,
            s.roll_deg,
            s.ground_speed_mps,
            s.fuel_kg
        ];
        self.connection.execute("INSERT INTO track VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)", row).unwrap();
    }
}

/// `western-states.pdl:12:3`
fn place_of(text: &str) -> Option<Place> {
    let mut parts = text.rsplit(':');
    let (column, line) = (parts.next()?.parse().ok()?, parts.next()?.parse().ok()?);
    Some(Place { file: 0, line, column })
}

/// `procedure fly-mission`, `primitive land`, or words about a plan.
fn method_of(text: &str) -> Method {
    let line = |name: &str| story::PDL.lines().position(|line| line.contains(&format!("(index ({name}")));
    let place = |name: &str| Place { file: 0, line: line(name).map_or(1, |line| line as u32 + 1), column: 3 };
    match text.split_once(' ') {
        Some(("procedure", name)) => Method::Procedure(place(name)),
        Some(("primitive", name)) => Method::Primitive(place(name)),
        _ => Method::Solver(Symbol::new(text)),
    }
}

fn state(word: &str) -> TaskState {
    let all = [TaskState::Pending, TaskState::Enabled, TaskState::Ongoing, TaskState::Interrupted];
    all.into_iter().find(|state| state.word() == word).unwrap_or(TaskState::Terminated)
}

/// Writes a whole, properly closed record.
pub fn write_complete(path: &Path) -> Story {
    let story = Story::western_states();
    let mut writer = Writer::new(path, &story);
    writer.write(&story, i64::MIN, i64::MAX);
    writer.complete(&story);
    story
}
