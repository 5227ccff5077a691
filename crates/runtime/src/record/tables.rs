//! The tables of a record. Rows are only appended, in the order of the first column, which is the key: the seal of a group (`seal.rs`)
//! can therefore state the number of its rows in each table.

/// A table of a record, except the table of the seals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(usize)]
pub(super) enum Table {
    Meta,
    Agent,
    Source,
    Variable,
    Batch,
    Word,
    Shape,
    Effects,
    Note,
    Snapshot,
    Problem,
    Answer,
    Situation,
    Track,
    Target,
    TargetState,
    Report,
}

/// Number of tables.
pub(super) const TABLES: usize = 17;

/// All tables; a seal refers to them by their index here.
pub(super) const ALL: [Table; TABLES] = [
    Table::Meta,
    Table::Agent,
    Table::Source,
    Table::Variable,
    Table::Batch,
    Table::Word,
    Table::Shape,
    Table::Effects,
    Table::Note,
    Table::Snapshot,
    Table::Problem,
    Table::Answer,
    Table::Situation,
    Table::Track,
    Table::Target,
    Table::TargetState,
    Table::Report,
];

/// The whole content of `sqlite_schema` of a record, in order. A record with other content is not read.
pub(super) const SCHEMA: [(&str, &str, &str); TABLES + 2] = [
    ("table", "meta", "CREATE TABLE meta (position INTEGER PRIMARY KEY, key TEXT, value TEXT)"),
    ("table", "agent", "CREATE TABLE agent (id INTEGER PRIMARY KEY, name TEXT)"),
    ("table", "source", "CREATE TABLE source (position INTEGER PRIMARY KEY, name TEXT, role TEXT, body BLOB)"),
    ("table", "variable", "CREATE TABLE variable (id INTEGER PRIMARY KEY, name TEXT, body BLOB)"),
    ("table", "batch", "CREATE TABLE batch (id INTEGER PRIMARY KEY, t_ns INTEGER, events BLOB, agent INTEGER)"),
    ("table", "word", "CREATE TABLE word (id INTEGER PRIMARY KEY, text TEXT)"),
    ("table", "shape", "CREATE TABLE shape (id INTEGER PRIMARY KEY, layout BLOB, example BLOB)"),
    ("table", "effects", "CREATE TABLE effects (batch INTEGER PRIMARY KEY, first INTEGER, body BLOB)"),
    ("table", "note", "CREATE TABLE note (position INTEGER PRIMARY KEY, batch INTEGER, t_ns INTEGER, text TEXT)"),
    ("table", "snapshot", "CREATE TABLE snapshot (batch INTEGER PRIMARY KEY, t_ns INTEGER, body BLOB, agent INTEGER)"),
    (
        "table",
        "problem",
        "CREATE TABLE problem (position INTEGER PRIMARY KEY, request INTEGER, batch INTEGER, t_ns INTEGER, goal TEXT, \
         solver TEXT, body TEXT)",
    ),
    (
        "table",
        "answer",
        "CREATE TABLE answer (position INTEGER PRIMARY KEY, request INTEGER, due_ns INTEGER, detail TEXT, plan TEXT, \
         report BLOB)",
    ),
    ("table", "situation", "CREATE TABLE situation (batch INTEGER PRIMARY KEY, t_ns INTEGER, body BLOB)"),
    (
        "table",
        "track",
        "CREATE TABLE track (t_ns INTEGER PRIMARY KEY, latitude_deg REAL, longitude_deg REAL, altitude_m REAL, \
         heading_deg REAL, roll_deg REAL, ground_speed_mps REAL, fuel_kg REAL)",
    ),
    (
        "table",
        "target",
        "CREATE TABLE target (position INTEGER PRIMARY KEY, id TEXT, name TEXT, latitude_deg REAL, longitude_deg REAL, \
         value REAL, geometry TEXT)",
    ),
    (
        "table",
        "target_state",
        "CREATE TABLE target_state (position INTEGER PRIMARY KEY, target TEXT, t_ns INTEGER, state TEXT, detail TEXT)",
    ),
    ("table", "report", "CREATE TABLE report (position INTEGER PRIMARY KEY, section TEXT, body TEXT)"),
    ("table", "seal", "CREATE TABLE seal (id INTEGER PRIMARY KEY, t_ns INTEGER, batch INTEGER, rows BLOB, chain BLOB)"),
    ("index", "batch_time", "CREATE INDEX batch_time ON batch (t_ns)"),
];

impl Table {
    /// Returns its place in [`ALL`].
    pub(super) fn index(self) -> usize {
        self as usize
    }

    /// Returns its name in SQL.
    pub(super) fn name(self) -> &'static str {
        SCHEMA.get(self.index()).map_or("", |(_, name, _)| name)
    }

    /// Returns true if the first column is the row's position, from 1, which the store fills in.
    pub(super) fn is_numbered(self) -> bool {
        match self {
            Table::Agent
            | Table::Variable
            | Table::Batch
            | Table::Word
            | Table::Shape
            | Table::Effects
            | Table::Snapshot
            | Table::Situation
            | Table::Track => false,
            Table::Meta
            | Table::Source
            | Table::Note
            | Table::Problem
            | Table::Answer
            | Table::Target
            | Table::TargetState
            | Table::Report => true,
        }
    }

    /// Returns the name of a row in messages: `batch 12`.
    pub(super) fn row_word(self) -> &'static str {
        match self {
            Table::Meta => "fact",
            Table::TargetState => "state of a target",
            other => other.name(),
        }
    }

    fn columns(self) -> usize {
        SCHEMA.get(self.index()).map_or(0, |(_, _, sql)| sql.matches(", ").count() + 1)
    }

    /// Returns the name of a column.
    pub(super) fn column(self, index: usize) -> &'static str {
        let (_, _, sql) = SCHEMA.get(self.index()).copied().unwrap_or_default();
        let inside = sql.split_once('(').map_or("", |(_, inside)| inside);
        inside.split(", ").nth(index).and_then(|column| column.split(' ').next()).unwrap_or("")
    }

    /// Returns the SQL statement that inserts one row with all of its columns.
    pub(super) fn insert(self) -> String {
        let places: Vec<String> = (1..=self.columns()).map(|place| format!("?{place}")).collect();
        format!("INSERT INTO {} VALUES ({})", self.name(), places.join(", "))
    }
}

/// Returns the rows of a table with keys above `?1`, in order. `main` cannot be covered by a temporary view.
pub(super) fn rows_after(name: &str, key: &str) -> String {
    format!("SELECT * FROM main.{name} NOT INDEXED WHERE {key} > ?1 ORDER BY {key}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_and_statements_agree() {
        for (index, table) in ALL.into_iter().enumerate() {
            assert_eq!(table.index(), index);
            assert!(SCHEMA[index].2.starts_with(&format!(
                "CREATE TABLE {} ({} INTEGER",
                table.name(),
                table.column(0)
            )));
            assert_eq!(table.is_numbered(), table.column(0) == "position", "{table:?}");
        }
        assert_eq!(Table::Agent.insert(), "INSERT INTO agent VALUES (?1, ?2)");
        assert_eq!(rows_after("track", "t_ns"), "SELECT * FROM main.track NOT INDEXED WHERE t_ns > ?1 ORDER BY t_ns");
        assert_eq!((Table::Effects.columns(), Table::Effects.column(1)), (3, "first"));
    }
}
