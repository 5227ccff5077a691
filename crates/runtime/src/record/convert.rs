//! Conversion of records of the preceding version: the same rows in the same sealed groups, with effects as bytes.
//!
//! Version 6 had a row for each effect (`effect`) and each task (`task`). Its effects are written in the present form; its texts and
//! tasks follow from them. Everything else is copied. The old record is checked group by group, and must be complete.

use super::check::{CheckProgress, Layout, Visitor, check_groups_of, check_schema_of};
use super::closing;
use super::connect::connect_to;
use super::effects::EffectEncoder;
use super::schema::{self, CONVERTIBLE_VERSION, SCHEMA_VERSION, write_error};
use super::seal::{ChainPosition, Seal, Sealer};
use super::store::SqlValue;
use super::tables::{ALL, SCHEMA, TABLES, Table};
use crate::error::RecordError;
use apex_model::effect::Effect;
use apex_model::time::Time;
use rusqlite::types::ToSqlOutput;
use rusqlite::{Connection, Row, params, params_from_iter};
use std::path::Path;

const EFFECT: (&str, &str, &str) = (
    "table",
    "effect",
    "CREATE TABLE effect (id INTEGER PRIMARY KEY, batch INTEGER, t_ns INTEGER, kind TEXT, task INTEGER, \
     from_state TEXT, to_state TEXT, outcome TEXT, subject TEXT, text TEXT, place TEXT, body BLOB, agent INTEGER, \
     method TEXT)",
);
const TASK: (&str, &str, &str) = (
    "table",
    "task",
    "CREATE TABLE task (position INTEGER PRIMARY KEY, id INTEGER, parent INTEGER, tag TEXT, goal TEXT, \
     created_ns INTEGER, place TEXT, agent INTEGER)",
);
const INDEXES: [(&str, &str, &str); 2] = [
    ("index", "effect_batch", "CREATE INDEX effect_batch ON effect (batch)"),
    ("index", "effect_task", "CREATE INDEX effect_task ON effect (task, id)"),
];

/// Returns the schema of version 6: that of this version with other tables for effects.
fn old_schema() -> Vec<(&'static str, &'static str, &'static str)> {
    let mut schema = Vec::new();
    for entry in SCHEMA {
        match entry.1 {
            "word" | "shape" => {}
            "effects" => schema.push(EFFECT),
            "note" => schema.extend([entry, TASK]),
            _ => schema.push(entry),
        }
    }
    schema.extend(INDEXES);
    schema
}

/// Returns the tables of version 6, and the present table of each.
fn old_tables() -> (Layout, Vec<Option<Table>>) {
    let mut layout = Layout::new();
    let mut now = Vec::new();
    for (kind, name, sql) in old_schema() {
        if kind == "table" && name != "seal" {
            let key = sql.split_once('(').and_then(|(_, columns)| columns.split(' ').next()).unwrap_or_default();
            layout.push((name, key));
            now.push(ALL.into_iter().find(|table| table.name() == name));
        }
    }
    (layout, now)
}

/// Writes the record of version 6 at `from` into a new one of the present version at `to`; returns the number of its steps.
///
/// # Errors
/// [`RecordError`] if `from` is not a record of version 6 or is damaged, and if `to` cannot be written.
pub fn convert(from: &Path, to: &Path) -> Result<i64, RecordError> {
    let (source, _, _copy) = connect_to(from, CONVERTIBLE_VERSION).map_err(|error| match error {
        RecordError::Newer { path, found: SCHEMA_VERSION, .. } => RecordError::Question(format!(
            "{} is written in version {SCHEMA_VERSION} of the record format already: there is nothing to convert",
            path.display()
        )),
        other => other,
    })?;
    let damaged = |what| RecordError::Damaged { path: from.to_path_buf(), what };
    check_schema_of(&source, &old_schema()).map_err(damaged)?;
    let target = schema::create(to)?;
    let fail = |error| write_error(to, "converting", error);
    let (layout, tables) = old_tables();
    let mut converter = Converter {
        target: &target,
        inserts: ALL.map(Table::insert),
        tables,
        encoder: EffectEncoder::default(),
        sealer: Sealer::default(),
        link: ChainPosition::default(),
        step: OldStep::default(),
        failure: None,
    };
    target.execute_batch("BEGIN").map_err(fail)?;
    let mut position = CheckProgress::default();
    let checked = check_groups_of(&source, &layout, &mut position, &mut converter);
    let failure = converter.failure.take();
    if failure.is_some() || checked.is_err() {
        drop(target);
        schema::remove(to);
    } else {
        target.execute_batch("COMMIT").map_err(fail)?;
        closing::close(target, to)?;
    }
    match failure {
        Some(Failure::Target(error)) => Err(fail(error)),
        Some(Failure::Source(what)) => Err(damaged(what)),
        None => checked.map(|()| position.batch).map_err(|damage| damaged(damage.to_string())),
    }
}

enum Failure {
    /// The new file cannot be written.
    Target(rusqlite::Error),
    /// The old record contains an effect that cannot be read.
    Source(String),
}

/// The effects of the step that is being read.
#[derive(Default)]
struct OldStep {
    batch: i64,
    now: Time,
    first: i64,
    effects: Vec<Effect>,
}

struct Converter<'c> {
    target: &'c Connection,
    inserts: [String; TABLES],
    tables: Vec<Option<Table>>,
    encoder: EffectEncoder,
    sealer: Sealer,
    link: ChainPosition,
    step: OldStep,
    failure: Option<Failure>,
}

/// Writes a row, and adds it to the seal.
fn store(
    target: &Connection,
    inserts: &[String; TABLES],
    sealer: &mut Sealer,
    table: Table,
    cells: &[SqlValue<'_>],
) -> rusqlite::Result<()> {
    let Some(sql) = inserts.get(table.index()) else { return Ok(()) };
    let row = cells.iter().map(|cell| ToSqlOutput::Borrowed(*cell));
    target.prepare_cached(sql)?.execute(params_from_iter(row))?;
    sealer.row(table.index(), cells.iter().copied());
    Ok(())
}

impl Converter<'_> {
    fn keep(&mut self, done: rusqlite::Result<()>) -> rusqlite::Result<()> {
        done.map_err(|error| {
            self.failure.get_or_insert(Failure::Target(error));
            rusqlite::Error::InvalidQuery
        })
    }

    /// Takes an effect of the old record.
    fn effect(&mut self, row: &Row<'_>) -> rusqlite::Result<()> {
        let (id, batch, now): (i64, i64, i64) = (row.get(0)?, row.get(1)?, row.get(2)?);
        if batch != self.step.batch {
            self.end_step()?;
            self.step = OldStep { batch, now: Time(now), first: id, effects: Vec::new() };
        }
        match postcard::from_bytes(row.get_ref(11)?.as_blob()?) {
            Ok(effect) => self.step.effects.push(effect),
            Err(error) => {
                self.failure = Some(Failure::Source(format!("effect {id} is garbled ({error})")));
                return Err(rusqlite::Error::InvalidQuery);
            }
        }
        Ok(())
    }

    /// Writes the effects of the step that has been read.
    fn end_step(&mut self) -> rusqlite::Result<()> {
        let OldStep { batch, now, first, effects } = std::mem::take(&mut self.step);
        if effects.is_empty() {
            return Ok(());
        }
        let mut bytes = Vec::new();
        if let Err(error) = self.encoder.encode(now, &effects, &mut bytes) {
            self.failure = Some(Failure::Source(format!("effect {first} cannot be written ({error})")));
            return Err(rusqlite::Error::InvalidQuery);
        }
        let (target, inserts, sealer) = (self.target, &self.inserts, &mut self.sealer);
        let stored =
            self.encoder.new_rows(|table, cells| store(target, inserts, sealer, table, cells)).and_then(|()| {
                let row = [SqlValue::Integer(batch), SqlValue::Integer(first), SqlValue::Blob(&bytes)];
                store(target, inserts, sealer, Table::Effects, &row)
            });
        self.keep(stored)
    }

    fn copy(&mut self, table: Table, row: &Row<'_>) -> rusqlite::Result<()> {
        let columns = row.as_ref().column_count();
        let cells: Vec<SqlValue<'_>> =
            (0..columns).map(|column| row.get_ref(column)).collect::<rusqlite::Result<_>>()?;
        let stored = store(self.target, &self.inserts, &mut self.sealer, table, &cells);
        self.keep(stored)
    }

    fn seal(&mut self, old: &Seal) -> rusqlite::Result<()> {
        let seal = self.sealer.seal(self.link, old.t_ns, old.batch);
        let row = params![seal.id, seal.t_ns, seal.batch, seal.count_bytes(), seal.chain];
        self.target.prepare_cached("INSERT INTO seal VALUES (?1, ?2, ?3, ?4, ?5)")?.execute(row)?;
        self.link = seal.link();
        self.target.execute_batch("COMMIT; BEGIN")
    }
}

impl Visitor for Converter<'_> {
    fn row(&mut self, table: usize, row: &Row<'_>) -> rusqlite::Result<()> {
        match self.tables.get(table).copied().flatten() {
            Some(table) => self.copy(table, row),
            // Tasks follow from their effects.
            None if row.as_ref().column_count() == TASK.2.matches(", ").count() + 1 => Ok(()),
            None => self.effect(row),
        }
    }

    fn sealed(&mut self, seal: &Seal) -> rusqlite::Result<()> {
        self.end_step()?;
        let sealed = self.seal(seal);
        self.keep(sealed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::schema::APPLICATION_ID;
    use crate::record::tests::{place_for_record, record_samples};
    use crate::record::{RecordReader, RecordedStep};

    /// Writes a record of version 6 with the content of the record at `from`.
    fn old_record(from: &Path, to: &Path) {
        let reader = RecordReader::open(from).unwrap();
        let old = Connection::open(to).unwrap();
        for (_, _, sql) in old_schema() {
            old.execute_batch(sql).unwrap();
        }
        old.execute_batch(&format!(
            "PRAGMA application_id = {APPLICATION_ID}; PRAGMA user_version = {CONVERTIBLE_VERSION}"
        ))
        .unwrap();
        old.execute("ATTACH ?1 AS new", [from.to_str().unwrap()]).unwrap();
        let (layout, tables) = old_tables();
        for (name, table) in layout.iter().map(|(name, _)| name).zip(tables) {
            if table.is_some() {
                old.execute_batch(&format!("INSERT INTO main.{name} SELECT * FROM new.{name}")).unwrap();
            }
        }
        for step in reader.steps().unwrap() {
            let step = step.unwrap();
            for effect in &step.effects {
                let sql = "INSERT INTO main.effect (id, batch, t_ns, body, text) VALUES (?1, ?2, ?3, ?4, 'it was so')";
                old.execute(sql, params![effect.number, step.batch_number, step.batch.now.0, effect.body]).unwrap();
            }
        }
        old.execute_batch("INSERT INTO main.task (id, goal) VALUES (1, '(fly mission)')").unwrap();
        let mut sealer = Sealer::default();
        for (index, (name, key)) in layout.iter().enumerate() {
            let mut statement = old.prepare(&format!("SELECT * FROM main.{name} ORDER BY {key}")).unwrap();
            let columns = statement.column_count();
            let mut rows = statement.query([]).unwrap();
            while let Some(row) = rows.next().unwrap() {
                sealer.row(index, (0..columns).map(|column| row.get_ref(column).unwrap()));
            }
        }
        let seal = sealer.seal(ChainPosition::default(), 7, 3);
        let row = params![seal.id, seal.t_ns, seal.batch, seal.count_bytes(), seal.chain];
        old.execute("INSERT INTO main.seal VALUES (?1, ?2, ?3, ?4, ?5)", row).unwrap();
    }

    fn steps(path: &Path) -> Vec<RecordedStep> {
        RecordReader::open(path).unwrap().steps().unwrap().collect::<Result<_, _>>().unwrap()
    }

    #[test]
    fn a_record_of_the_version_before_is_converted() {
        let (folder, path) = place_for_record();
        let mut recorder = record_samples(&path);
        recorder.finish(Time::from_seconds(300.3), "the root task ended").unwrap();
        let (old, new) = (folder.path().join("old.apex"), folder.path().join("new.apex"));
        old_record(&path, &old);
        let refused = RecordReader::open(&old).err().unwrap().to_string();
        assert!(refused.contains("version 6") && refused.contains("apex convert"), "{refused}");
        convert(&old, &new).unwrap();
        assert_eq!(steps(&new), steps(&path));
        let reader = RecordReader::open(&new).unwrap();
        assert_eq!(reader.warning().unwrap(), None);
        assert_eq!(reader.tasks().unwrap(), RecordReader::open(&path).unwrap().tasks().unwrap());
        let again = convert(&new, &folder.path().join("again.apex")).unwrap_err().to_string();
        assert!(again.contains("nothing to convert"), "{again}");
    }

    #[test]
    fn a_damaged_record_of_the_version_before_is_not_converted() {
        let (folder, path) = place_for_record();
        drop(record_samples(&path));
        let (old, new) = (folder.path().join("old.apex"), folder.path().join("new.apex"));
        old_record(&path, &old);
        let connection = Connection::open(&old).unwrap();
        connection.execute("UPDATE effect SET text = 'as wished' WHERE id = 2", []).unwrap();
        drop(connection);
        let refused = convert(&old, &new).unwrap_err().to_string();
        assert!(refused.contains("group 1 of its rows is not as it was written"), "{refused}");
        assert!(!new.exists());
    }
}
