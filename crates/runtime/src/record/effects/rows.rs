//! Rows of effects, for tools that write records without the recorder.

use super::EffectEncoder;
use crate::record::store::SqlValue;
use crate::record::tables::Table;
use apex_model::effect::Effect;
use apex_model::time::Time;
use rusqlite::types::ToSqlOutput;
use rusqlite::{Connection, params_from_iter};

/// Writes the effects of one record, step by step.
#[derive(Default)]
pub struct EffectRows {
    encoder: EffectEncoder,
    effects: i64,
}

impl EffectRows {
    /// Inserts the effects of the step `batch` at `now`; the caller seals them (`seal_rows`).
    ///
    /// # Errors
    /// SQLite's own; `InvalidQuery` for an effect that cannot be turned into bytes.
    pub fn insert(
        &mut self,
        connection: &Connection,
        (batch, now): (i64, Time),
        effects: &[Effect],
    ) -> rusqlite::Result<()> {
        let mut bytes = Vec::new();
        self.encoder.encode(now, effects, &mut bytes).map_err(|_| rusqlite::Error::InvalidQuery)?;
        let store = |table: Table, cells: &[SqlValue<'_>]| {
            let row = cells.iter().map(|cell| ToSqlOutput::Borrowed(*cell));
            connection.prepare_cached(&table.insert())?.execute(params_from_iter(row)).map(|_| ())
        };
        self.encoder.new_rows(store)?;
        store(
            Table::Effects,
            &[SqlValue::Integer(batch), SqlValue::Integer(self.effects + 1), SqlValue::Blob(&bytes)],
        )?;
        self.effects += effects.len() as i64;
        Ok(())
    }
}
