//! Writes a plausible flight record of the schema in `docs/reference/flight-record.md`: a fire-mapping flight of some
//! hours over the western states. For tests of the server and for work on the page; no part of the product.

// Shared by a test and an example, of which each uses a part.
#![allow(unreachable_pub, dead_code, missing_docs, clippy::unwrap_used, clippy::indexing_slicing)]

pub mod story;

use apex_model::library::Library;
use apex_runtime::record::{RecordOptions, Recorder, seal_rows};
use rusqlite::{Connection, params};
use std::collections::BTreeMap;
use std::path::Path;
use story::{Entry, Sample, Story};

/// A record on disk that can be written bit by bit, as a live flight does.
pub struct Writer {
    connection: Connection,
    effects: i64,
    batches: i64,
    goals: BTreeMap<u64, String>,
}

impl Writer {
    /// A new record at `path` with the mission's files and targets, and nothing flown.
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
        Writer { connection, effects: 0, batches: 0, goals: BTreeMap::new() }
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
        match entry {
            Entry::Created { task, parent, tag, goal, place, text } => {
                let row = params![*task as i64, parent.map(|id| id as i64), tag, goal, t_ns, place];
                self.connection
                    .execute(
                        "INSERT INTO task (id, parent, tag, goal, created_ns, place, agent) \
                         VALUES (?1, ?2, ?3, ?4, ?5, ?6, 0)",
                        row,
                    )
                    .unwrap();
                self.goals.insert(*task, (*goal).to_string());
                self.effect(t_ns, "created", Some(*task), [None, None, None], goal, text, place);
            }
            Entry::Selected { task, method, text } => {
                let goal = self.goals.get(task).cloned().unwrap_or_default();
                self.effect(t_ns, "selected", Some(*task), [None, None, None], &goal, text, "");
                let sql = "UPDATE effect SET method = ?2 WHERE id = ?1";
                self.connection.execute(sql, params![self.effects, method]).unwrap();
            }
            Entry::Transition { task, from, to, outcome, text, place } => {
                self.effect(t_ns, "transition", Some(*task), [Some(from), Some(to), *outcome], "", text, place);
            }
            Entry::Other { kind, task, subject, text } => {
                self.effect(t_ns, kind, *task, [None, None, None], subject, text, "");
            }
            Entry::Target { target, state, detail } => {
                let row = params![target, t_ns, state, detail];
                self.connection
                    .execute("INSERT INTO target_state (target, t_ns, state, detail) VALUES (?1, ?2, ?3, ?4)", row)
                    .unwrap();
            }
        }
    }

    #[allow(clippy::too_many_arguments)]
    fn effect(
        &mut self,
        t_ns: i64,
        kind: &str,
        task: Option<u64>,
        [from, to, outcome]: [Option<&str>; 3],
        subject: &str,
        text: &str,
        place: &str,
    ) {
        self.effects += 1;
        let task = task.map(|id| id as i64);
        let row = params![self.effects, self.batches, t_ns, kind, task, from, to, outcome, subject, text, place];
        self.connection
            .execute("INSERT INTO effect VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, x'', 0, NULL)", row)
            .unwrap();
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

/// Writes a whole, properly closed record.
pub fn write_complete(path: &Path) -> Story {
    let story = Story::western_states();
    let mut writer = Writer::new(path, &story);
    writer.write(&story, i64::MIN, i64::MAX);
    writer.complete(&story);
    story
}
