//! Checks the groups of a record against their seals, in order, up to the first group that was changed.
//!
//! Bound: each row is read once. Rows are read in the order of the tables' own trees, whose keys must rise, so damaged pages cannot make
//! the check endless.

use super::seal::{ChainPosition, Seal, Sealer, counts_of};
use super::tables::{ALL, SCHEMA, TABLES, rows_after};
use apex_model::time::Time;
use rusqlite::{CachedStatement, Connection, Row, Rows};

/// Progress of the check of a record: everything before is unchanged.
#[derive(Clone, Debug, Default)]
pub(super) struct CheckProgress {
    pub(super) link: ChainPosition,
    /// Last key of each table.
    keys: Keys,
    /// Instant and number of the last batch.
    pub(super) now: Time,
    pub(super) batch: i64,
}

/// Keys by table; before the first row no key is too small.
#[derive(Clone, Copy, Debug)]
struct Keys([i64; TABLES]);

impl Default for Keys {
    fn default() -> Keys {
        Keys([i64::MIN; TABLES])
    }
}

/// The first damaged group.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Its number, from 1.
    pub group: i64,
    /// Number of the last batch in the checked part; 0 if no batch is valid.
    pub trusted_batches: i64,
    /// The instant of that batch.
    pub trusted_until: Time,
    /// Discrepancy.
    pub reason: String,
}

impl std::fmt::Display for Damage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Damage { group, trusted_batches, trusted_until, reason } = self;
        write!(f, "group {group} of its rows is not as it was written: {reason}. ")?;
        match trusted_batches {
            0 => f.write_str("No step before it can be trusted"),
            1 => write!(f, "Step 1, at {trusted_until}, can be trusted"),
            last => write!(f, "Steps 1 to {last}, up to {trusted_until}, can be trusted"),
        }
    }
}

/// Receives all rows that are read, and the seals of intact groups.
pub(super) trait Visitor {
    /// Receives a row of the table with this index; the seal of its group has not been compared yet.
    fn row(&mut self, table: usize, row: &Row<'_>) -> rusqlite::Result<()>;
    /// Receives a seal after it was found to fit the rows since the preceding one.
    fn sealed(&mut self, seal: &Seal) -> rusqlite::Result<()>;
}

/// A visitor that ignores all rows and seals.
pub(super) struct NoVisitor;

impl Visitor for NoVisitor {
    fn row(&mut self, _: usize, _: &Row<'_>) -> rusqlite::Result<()> {
        Ok(())
    }

    fn sealed(&mut self, _: &Seal) -> rusqlite::Result<()> {
        Ok(())
    }
}

/// The tables of a version of the format, in the order in which seals refer to them: names and keys.
pub(super) type Layout = Vec<(&'static str, &'static str)>;

/// Returns the tables of this version.
pub(super) fn layout() -> Layout {
    ALL.iter().map(|table| (table.name(), table.column(0))).collect()
}

/// Compares the schema with that of every record: a foreign view or trigger never runs.
pub(super) fn check_schema(connection: &Connection) -> Result<(), String> {
    check_schema_of(connection, &SCHEMA)
}

/// Compares the schema with that of a version of the format.
pub(super) fn check_schema_of(connection: &Connection, schema: &[(&str, &str, &str)]) -> Result<(), String> {
    let unreadable = |error: rusqlite::Error| format!("its schema cannot be read ({error})");
    let sql = "SELECT type, name, sql FROM main.sqlite_schema ORDER BY rowid LIMIT 100";
    let mut statement = connection.prepare(sql).map_err(unreadable)?;
    let mut rows = statement.query([]).map_err(unreadable)?;
    let mut expected = schema.iter();
    while let Some(row) = rows.next().map_err(unreadable)? {
        let cell = |index| row.get::<_, Option<String>>(index).map(Option::unwrap_or_default).map_err(unreadable);
        let (kind, name, sql) = (cell(0)?, cell(1)?, cell(2)?);
        if expected.next() != Some(&(kind.as_str(), name.as_str(), sql.as_str())) {
            return Err(format!("its {kind} `{}` does not belong to a record", name.escape_debug()));
        }
    }
    expected.next().map_or(Ok(()), |(kind, name, _)| Err(format!("its {kind} `{name}` is missing")))
}

/// Compares the indexes with their tables.
pub(super) fn check_indexes(connection: &Connection) -> Result<(), String> {
    let found: rusqlite::Result<String> = connection.query_row("PRAGMA integrity_check(1)", [], |row| row.get(0));
    match found {
        Ok(word) if word == "ok" => Ok(()),
        Ok(fault) => Err(format!("its pages or indexes are damaged ({})", fault.trim().escape_debug())),
        Err(error) => Err(format!("its pages cannot be read ({error})")),
    }
}

/// Checks all groups after `position`, and advances it to the last valid group. All reads see one state of the record.
pub(super) fn check_groups(
    connection: &Connection,
    position: &mut CheckProgress,
    visitor: &mut dyn Visitor,
) -> Result<(), Damage> {
    check_groups_of(connection, &layout(), position, visitor)
}

/// Like [`check_groups`], for a format version with these tables.
pub(super) fn check_groups_of(
    connection: &Connection,
    layout: &Layout,
    position: &mut CheckProgress,
    visitor: &mut dyn Visitor,
) -> Result<(), Damage> {
    let own_transaction = connection.is_autocommit() && connection.execute_batch("BEGIN").is_ok();
    let checked = walk(connection, layout, position, visitor);
    if own_transaction {
        let _ = connection.execute_batch("COMMIT");
    }
    checked.map_err(|reason| Damage {
        group: position.link.id + 1,
        trusted_batches: position.batch,
        trusted_until: position.now,
        reason,
    })
}

fn walk(
    connection: &Connection,
    layout: &Layout,
    position: &mut CheckProgress,
    visitor: &mut dyn Visitor,
) -> Result<(), String> {
    let unreadable = |error: rusqlite::Error| format!("it cannot be read ({error})");
    let mut statements: Vec<CachedStatement<'_>> = Vec::with_capacity(TABLES);
    for (name, key) in layout {
        statements.push(connection.prepare_cached(&rows_after(name, key)).map_err(unreadable)?);
    }
    let mut tables: Vec<Rows<'_>> = Vec::with_capacity(TABLES);
    for (statement, key) in statements.iter_mut().zip(position.keys.0) {
        tables.push(statement.query([key]).map_err(unreadable)?);
    }
    let sql = "SELECT id, t_ns, batch, rows, chain FROM main.seal WHERE id > ?1 ORDER BY id";
    let mut statement = connection.prepare_cached(sql).map_err(unreadable)?;
    let mut seals = statement.query([position.link.id]).map_err(unreadable)?;
    let mut sealer = Sealer::default();
    while let Some(row) = seals.next().map_err(unreadable)? {
        let stored = read_seal(row).map_err(unreadable)?.ok_or("its seal is garbled")?;
        if stored.id != position.link.id + 1 {
            return Err("its seal is missing".into());
        }
        let mut keys = position.keys;
        for (index, ((name, _), rows)) in layout.iter().zip(&mut tables).enumerate() {
            let count = stored.counts.get(index).copied().unwrap_or(0);
            let key = keys.0.get_mut(index).ok_or("it has too many tables")?;
            take_rows((index, name), count, rows, key, &mut sealer, visitor)?;
        }
        let seal = sealer.seal(position.link, stored.t_ns, stored.batch);
        if seal != stored {
            return Err("its rows do not fit its seal".into());
        }
        visitor.sealed(&seal).map_err(unreadable)?;
        *position = CheckProgress { link: seal.link(), keys, now: Time(seal.t_ns), batch: seal.batch };
    }
    for ((name, _), rows) in layout.iter().zip(&mut tables) {
        if rows.next().map_err(unreadable)?.is_some() {
            return Err(format!("the table `{name}` has rows that no seal covers"));
        }
    }
    Ok(())
}

/// Adds the next `count` rows of a table to the sealer.
fn take_rows(
    (index, name): (usize, &str),
    count: u64,
    rows: &mut Rows<'_>,
    key: &mut i64,
    sealer: &mut Sealer,
    visitor: &mut dyn Visitor,
) -> Result<(), String> {
    let unreadable = |error: rusqlite::Error| format!("a row of `{name}` cannot be read ({error})");
    for _ in 0..count {
        let row = rows.next().map_err(unreadable)?;
        let row = row.ok_or_else(|| format!("the table `{name}` has fewer rows than were written"))?;
        let next: i64 = row.get(0).map_err(unreadable)?;
        if next <= *key {
            return Err(format!("the keys of the table `{name}` do not rise"));
        }
        *key = next;
        let columns = row.as_ref().column_count();
        sealer.row(index, (0..columns).filter_map(|column| row.get_ref(column).ok()));
        visitor.row(index, row).map_err(unreadable)?;
    }
    Ok(())
}

fn read_seal(row: &Row<'_>) -> rusqlite::Result<Option<Seal>> {
    let counts = counts_of(row.get_ref(3)?.as_blob()?);
    let chain = row.get_ref(4)?.as_blob()?.try_into().ok();
    let (id, t_ns, batch) = (row.get(0)?, row.get(1)?, row.get(2)?);
    Ok(counts.zip(chain).map(|(counts, chain)| Seal { id, t_ns, batch, counts, chain }))
}

/// Seals the rows after the last seal as one group, for tools that write records without the recorder.
///
/// # Errors
/// An error of SQLite. Rows that are sealed already and do not fit their seal are not detected here.
pub fn seal_rows(connection: &Connection) -> rusqlite::Result<()> {
    let mut sealer = Sealer::default();
    let sql = "SELECT id, t_ns, batch, rows, chain FROM seal ORDER BY id";
    let seals: Vec<Option<Seal>> = connection.prepare(sql)?.query_map([], read_seal)?.collect::<Result<_, _>>()?;
    let seals: Vec<Seal> = seals.into_iter().flatten().collect();
    for table in ALL {
        let sealed: u64 = seals.iter().filter_map(|seal| seal.counts.get(table.index())).sum();
        let sql = format!("SELECT * FROM {} ORDER BY {} LIMIT -1 OFFSET {sealed}", table.name(), table.column(0));
        let mut statement = connection.prepare(&sql)?;
        let columns = statement.column_count();
        let mut rows = statement.query([])?;
        while let Some(row) = rows.next()? {
            sealer.row(table.index(), (0..columns).filter_map(|column| row.get_ref(column).ok()));
        }
    }
    let before = seals.last().map(Seal::link).unwrap_or_default();
    let sql = "SELECT ifnull(max(t_ns), 0), ifnull(max(id), 0) FROM batch";
    let (t_ns, batch) = connection.query_row(sql, [], |row| Ok((row.get(0)?, row.get(1)?)))?;
    let seal = sealer.seal(before, t_ns, batch);
    let row = rusqlite::params![seal.id, seal.t_ns, seal.batch, seal.count_bytes(), seal.chain];
    connection.execute("INSERT INTO seal VALUES (?1, ?2, ?3, ?4, ?5)", row).map(|_| ())
}
