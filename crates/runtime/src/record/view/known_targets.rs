//! Identifiers of the targets of a record, kept in memory and extended with the record.
//!
//! Bound: each row is read once.

use super::goals::TargetNames;
use rusqlite::Connection;
use std::sync::Arc;

/// The identifiers of the targets whose rows were read. Each plan adds a row for each target, so rows are read once, not for each query.
#[derive(Default)]
pub(super) struct KnownTargets {
    names: Arc<TargetNames>,
    /// Position of the last row of the table of targets that was read.
    target: i64,
    /// Position of the last row of the table of their states that was read.
    state: i64,
}

impl KnownTargets {
    /// Returns the identifiers by their text in lower case.
    pub(super) fn names(&self) -> Arc<TargetNames> {
        Arc::clone(&self.names)
    }

    /// Reads the rows that were added since the last call.
    pub(super) fn refresh(&mut self, connection: &Connection) -> rusqlite::Result<()> {
        for (sql, read_to) in [
            ("SELECT position, id FROM target WHERE position > ?1 ORDER BY position", &mut self.target),
            ("SELECT position, target FROM target_state WHERE position > ?1 ORDER BY position", &mut self.state),
        ] {
            let mut statement = connection.prepare_cached(sql)?;
            let mut rows = statement.query([*read_to])?;
            while let Some(row) = rows.next()? {
                let id: String = row.get(1)?;
                let name = id.to_lowercase();
                if !self.names.contains_key(&name) {
                    Arc::make_mut(&mut self.names).insert(name, id);
                }
                *read_to = row.get(0)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_targets_are_those_of_both_tables_also_after_more_rows() {
        let connection = Connection::open_in_memory().unwrap();
        connection
            .execute_batch(
                "CREATE TABLE target (position INTEGER PRIMARY KEY, id TEXT);
                 CREATE TABLE target_state (position INTEGER PRIMARY KEY, target TEXT);",
            )
            .unwrap();
        let mut known = KnownTargets::default();
        for rows in [
            "INSERT INTO target (id) VALUES ('Barn'), ('mill')",
            "INSERT INTO target_state (target) VALUES ('Barn'), ('Barn'), ('fire/growth-1')",
            "INSERT INTO target (id) VALUES ('mill'), ('Lake'); INSERT INTO target_state (target) VALUES ('mill')",
            "",
        ] {
            connection.execute_batch(rows).unwrap();
            known.refresh(&connection).unwrap();
            let sql = "SELECT id FROM target UNION SELECT target FROM target_state";
            let mut every = connection.prepare(sql).unwrap();
            let ids = every.query_map([], |row| row.get::<_, String>(0)).unwrap().map(Result::unwrap);
            let naive: TargetNames = ids.map(|id| (id.to_lowercase(), id)).collect();
            assert_eq!(*known.names, naive, "{rows}");
        }
    }
}
