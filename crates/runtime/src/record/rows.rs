//! Rows that a mission adds to its record: targets, their states, sections of the final report, sources, facts.

use super::writer::Recorder;
use crate::error::RecordError;
use crate::target_state::TargetChange;
use rusqlite::params;

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

impl Recorder {
    /// Stores a fact about the flight: `mission`, `agent`, `vehicle`, `epoch_utc`, ..; a later value replaces.
    ///
    /// # Errors
    /// [`RecordError`] when the file cannot be written.
    pub fn meta(&mut self, key: &str, value: &str) -> Result<(), RecordError> {
        self.store.write(
            "storing a fact about the flight",
            "INSERT OR REPLACE INTO meta VALUES (?1, ?2)",
            params![key, value],
        )
    }

    /// Stores a file that the mission was made from, after those stored before. Role `pdl` is for PDL in load order,
    /// which replay checks again; `data` is for everything else.
    ///
    /// # Errors
    /// [`RecordError`] when the file cannot be written.
    pub fn source(&mut self, name: &str, role: &str, body: &[u8]) -> Result<(), RecordError> {
        self.store.write(
            "storing a source file",
            "INSERT INTO source (name, role, body) VALUES (?1, ?2, ?3)",
            params![name, role, body],
        )
    }

    /// Adds or replaces a target.
    ///
    /// # Errors
    /// [`RecordError`] when the file cannot be written.
    pub fn target(&mut self, target: &TargetRow) -> Result<(), RecordError> {
        let TargetRow { id, name, latitude_deg, longitude_deg, value, geometry } = target;
        let sql = "INSERT OR REPLACE INTO target VALUES (?1, ?2, ?3, ?4, ?5, ?6)";
        self.store.write("storing a target", sql, params![id, name, latitude_deg, longitude_deg, value, geometry])
    }

    /// Stores the changes of targets' states after those that are stored already.
    ///
    /// # Errors
    /// [`RecordError`] when the file cannot be written.
    pub(super) fn target_changes(&mut self, changes: &[TargetChange]) -> Result<(), RecordError> {
        for TargetChange { target, at, state, detail } in changes.iter().skip(self.stored_changes) {
            let sql = "INSERT INTO target_state VALUES (?1, ?2, ?3, ?4)";
            self.store.write("storing a target's state", sql, params![target, at.0, state.word(), detail])?;
        }
        self.stored_changes = changes.len();
        Ok(())
    }

    /// Adds a section of the final report, as JSON text.
    ///
    /// # Errors
    /// [`RecordError`] when the file cannot be written.
    pub fn report(&mut self, section: &str, json: &str) -> Result<(), RecordError> {
        self.store.write(
            "storing the report",
            "INSERT INTO report (section, body) VALUES (?1, ?2)",
            params![section, json],
        )
    }
}
