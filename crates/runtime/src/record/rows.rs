//! Rows that a mission adds to its record, and reads again: targets, their states, sections of the final report, sources, facts.

use super::reader::RecordReader;
use super::store::{SqlValue, text};
use super::tables::Table;
use super::writer::Recorder;
use crate::error::RecordError;
use crate::target_state::TargetChange;

/// An observation target of the mission.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TargetRow {
    /// Its name in PDL.
    pub id: String,
    /// Its name for operators.
    pub name: String,
    /// Centre, degrees north.
    pub latitude_deg: f64,
    /// Centre, degrees east.
    pub longitude_deg: f64,
    /// Its value.
    pub value: f64,
    /// GeoJSON geometry, or empty.
    pub geometry: String,
}

impl RecordReader {
    /// Returns the targets of the mission, in order.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn target_rows(&self) -> Result<Vec<TargetRow>, RecordError> {
        let sql = "SELECT id, name, latitude_deg, longitude_deg, value, geometry FROM target ORDER BY position";
        self.rows("the targets", sql, |row| {
            Ok(TargetRow {
                id: row.get(0)?,
                name: row.get(1)?,
                latitude_deg: row.get(2)?,
                longitude_deg: row.get(3)?,
                value: row.get(4)?,
                geometry: row.get(5)?,
            })
        })
    }
}

impl Recorder {
    /// Stores a fact about the flight: `mission`, `agent`, `vehicle`, `epoch_utc`, ..; the latest value counts.
    ///
    /// # Errors
    /// [`RecordError`] when the file cannot be written.
    pub fn meta(&mut self, key: &str, value: &str) -> Result<(), RecordError> {
        self.store.insert("storing a fact about the flight", Table::Meta, &[text(Some(key)), text(Some(value))])
    }

    /// Stores a source file of the mission after those stored before. Role `pdl` is for PDL in load order, which replay checks again;
    /// `data` is for all other files.
    ///
    /// # Errors
    /// [`RecordError`] when the file cannot be written.
    pub fn source(&mut self, name: &str, role: &str, body: &[u8]) -> Result<(), RecordError> {
        self.store.insert(
            "storing a source file",
            Table::Source,
            &[text(Some(name)), text(Some(role)), SqlValue::Blob(body)],
        )
    }

    /// Adds a target; of two with one name the later one counts.
    ///
    /// # Errors
    /// [`RecordError`] when the file cannot be written.
    pub fn target(&mut self, target: &TargetRow) -> Result<(), RecordError> {
        let TargetRow { id, name, latitude_deg, longitude_deg, value, geometry } = target;
        let [latitude, longitude, value] = [*latitude_deg, *longitude_deg, *value].map(SqlValue::Real);
        let row = [text(Some(id)), text(Some(name)), latitude, longitude, value, text(Some(geometry))];
        self.store.insert("storing a target", Table::Target, &row)
    }

    /// Stores the changes of targets' states that are not stored yet.
    ///
    /// # Errors
    /// [`RecordError`] when the file cannot be written.
    pub(super) fn target_changes(&mut self, changes: &[TargetChange]) -> Result<(), RecordError> {
        for TargetChange { target, at, state, detail } in changes.iter().skip(self.stored_changes) {
            let row = [text(Some(target)), SqlValue::Integer(at.0), text(Some(state.word())), text(Some(detail))];
            self.store.insert("storing a target's state", Table::TargetState, &row)?;
        }
        self.stored_changes = changes.len();
        Ok(())
    }

    /// Adds a section of the final report, as JSON text.
    ///
    /// # Errors
    /// [`RecordError`] when the file cannot be written.
    pub fn report(&mut self, section: &str, json: &str) -> Result<(), RecordError> {
        self.store.insert("storing the report", Table::Report, &[text(Some(section)), text(Some(json))])
    }
}
