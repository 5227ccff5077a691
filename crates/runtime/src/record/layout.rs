//! The layout of snapshots. Their bytes do not describe themselves, so only builds with the same types may read them; the steps of a record
//! suffice for all others.

use super::reader::RecordReader;
use crate::error::RecordError;

/// Key of the fact that identifies the source texts of the types in snapshots of agents.
pub(super) const STATE_LAYOUT: &str = "state_layout";
/// Key of the fact that identifies the source texts of the types in snapshots of situations.
pub const SITUATION_LAYOUT: &str = "situation_layout";
/// Value of such a fact for a build whose source texts could not be read.
const UNKNOWN: &str = "unknown";

impl RecordReader {
    /// Returns true if the snapshots of agents have the version and the layout of this program.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn has_own_states(&self) -> Result<bool, RecordError> {
        let version = self.meta("apex_version")?.is_some_and(|version| version == env!("CARGO_PKG_VERSION"));
        Ok(version && self.has_layout(STATE_LAYOUT, env!("APEX_STATE_LAYOUT"))?)
    }

    /// Returns true if the record states this layout under the key `fact`.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn has_layout(&self, fact: &str, layout: &str) -> Result<bool, RecordError> {
        Ok(layout != UNKNOWN && self.meta(fact)?.is_some_and(|stated| stated == layout))
    }
}
