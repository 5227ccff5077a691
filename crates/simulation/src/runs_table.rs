//! The table of a series of flights, as CSV or Parquet: a row for each flight, a column for each member of [`RunRow`].

use crate::runs::RunRow;
use apex_mission::error::{MissionError, MissionResult};
use apex_runtime::record::is_record;
use apex_tables::{Cells, write_columns};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A file for the table, opened before the flights, so that a series is not lost because its table cannot be written. Without a table, a
/// file that did not exist is removed again.
#[derive(Debug)]
pub struct RunsTable {
    path: PathBuf,
    file: File,
    is_parquet: bool,
    /// True for a file that this value has created, and that holds no table.
    is_new: bool,
}

impl Drop for RunsTable {
    fn drop(&mut self) {
        if self.is_new {
            // Nothing is lost if it stays: the file is empty.
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

impl RunsTable {
    /// Opens the file; the format follows from the end of its name, `.parquet` (or `.pq`) or `.csv`. A file that exists keeps its content until
    /// the table is written.
    ///
    /// # Errors
    /// The name has another end, the file is a flight record, or it cannot be written.
    pub fn open(path: &Path) -> MissionResult<RunsTable> {
        let end = path.extension().map(|end| end.to_string_lossy().to_ascii_lowercase());
        let is_parquet = match end.as_deref() {
            Some("parquet" | "pq") => true,
            Some("csv") => false,
            _ => {
                return Err(MissionError::setting(format!(
                    "the name {} does not determine the format",
                    path.display()
                ))
                .help("end the name in .parquet or .csv"));
            }
        };
        if is_record(path) {
            return Err(MissionError::setting(format!(
                "{} is a flight record, which would be overwritten",
                path.display()
            ))
            .help("name another file, or remove the record first"));
        }
        let is_new = !path.exists();
        let file = File::options().create(true).truncate(false).write(true).open(path);
        let file = file.map_err(|error| unwritten(path, &error))?;
        Ok(RunsTable { path: path.to_path_buf(), file, is_parquet, is_new })
    }

    /// Writes the rows.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(mut self, rows: &[RunRow]) -> MissionResult {
        self.is_new = false;
        self.put(rows).map_err(|error| unwritten(&self.path, &error))
    }

    fn put(&self, rows: &[RunRow]) -> io::Result<()> {
        // A pipe has no length.
        if self.file.metadata()?.is_file() {
            self.file.set_len(0)?;
        }
        let mut output = BufWriter::new(&self.file);
        write_columns(&mut output, self.is_parquet, &columns(rows))?;
        output.flush()
    }
}

fn unwritten(path: &Path, error: &io::Error) -> MissionError {
    MissionError::output(format!("cannot write {}", path.display()))
        .because(error)
        .help("check its folder and the free space there")
}

fn columns(rows: &[RunRow]) -> Vec<(&'static str, Cells)> {
    let integers = |cell: fn(&RunRow) -> u64| {
        Cells::Integers(rows.iter().map(|row| i64::try_from(cell(row)).unwrap_or(i64::MAX)).collect())
    };
    let numbers = |cell: fn(&RunRow) -> Option<f64>| Cells::Numbers(rows.iter().map(cell).collect());
    let texts = |cell: fn(&RunRow) -> String| Cells::Texts(rows.iter().map(cell).collect());
    vec![
        ("seed", integers(|row| row.seed)),
        ("outcome", texts(|row| row.outcome.word().to_string())),
        ("reason", texts(|row| row.reason.clone())),
        ("end_s", numbers(|row| Some(row.end_s))),
        ("score", numbers(|row| row.score)),
        ("benefits", numbers(|row| row.benefits)),
        ("expected_cost", numbers(|row| row.expected_cost)),
        ("fires", numbers(|row| row.fires.map(|fires| fires as f64))),
        ("fires_seen", numbers(|row| row.fires_seen.map(|fires| fires as f64))),
        ("realised_cost", numbers(|row| row.realised_cost)),
        ("expected_cost_stated", numbers(|row| row.expected_cost_stated)),
        ("observed", integers(|row| row.observed)),
        ("left_out", integers(|row| row.left_out)),
        ("reflies", integers(|row| row.reflies)),
        ("plans", integers(|row| row.plans)),
        ("positions", integers(|row| row.positions)),
        ("inside_zones", integers(|row| row.inside_zones)),
        ("outside_permitted", integers(|row| row.outside_permitted)),
        ("near_ground", integers(|row| row.near_ground)),
        ("beyond_landing_distance", integers(|row| row.beyond_landing_distance)),
        ("said_broken", integers(|row| row.said_broken)),
        ("not_landed", texts(|row| row.not_landed.clone().unwrap_or_default())),
        ("ended_early", integers(|row| u64::from(row.ended_early))),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runs::RunOutcome;

    /// Users read the names of the members in JSON and Python, and expect the same columns.
    #[test]
    fn every_member_of_a_row_has_a_column() {
        let row = RunRow::failed(7, &MissionError::flight("the task failed"));
        assert_eq!(row.outcome, RunOutcome::Error);
        let json = serde_json::to_value(&row).unwrap();
        let mut members: Vec<&str> = json.as_object().unwrap().keys().map(String::as_str).collect();
        let mut names: Vec<&str> = columns(&[row]).into_iter().map(|(name, _)| name).collect();
        members.sort_unstable();
        names.sort_unstable();
        assert_eq!(names, members);
    }
}
