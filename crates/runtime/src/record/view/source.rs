//! Source lines: some lines of the mission's files around a place.

use super::RecordView;
use crate::error::RecordError;
use rusqlite::OptionalExtension;
use serde::Serialize;

/// Number of lines shown before the place.
const LINES_BEFORE: usize = 2;
/// Number of lines of a snippet.
const LINES: usize = 9;

/// Lines around a place.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Snippet {
    /// The file's name in the record.
    pub name: String,
    /// The place's line, from 1.
    pub line: usize,
    /// The number of the first of `lines`, from 1.
    pub first_line: usize,
    /// The lines.
    pub lines: Vec<String>,
}

/// A line of one of the mission's files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceLine {
    /// The file's name in the record.
    pub name: String,
    /// Its number, from 1.
    pub line: usize,
}

impl SourceLine {
    /// Returns the line of `file:line:column`; the file's name may itself contain colons. None for other texts.
    pub fn parse(place: &str) -> Option<SourceLine> {
        let (rest, column) = place.rsplit_once(':')?;
        let (name, line) = rest.rsplit_once(':')?;
        column.parse::<usize>().ok()?;
        Some(SourceLine { name: name.to_owned(), line: line.parse().ok()? })
    }
}

impl RecordView {
    /// Returns the lines around a place; `None` if the record does not contain the file.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn source(&self, place: &SourceLine) -> Result<Option<Snippet>, RecordError> {
        let body: Option<Vec<u8>> = self.query("the sources", |connection| {
            connection
                .prepare_cached("SELECT CAST(body AS BLOB) FROM source WHERE name = ?1 ORDER BY position LIMIT 1")?
                .query_row([&place.name], |row| row.get(0))
                .optional()
        })?;
        Ok(body.map(|body| cut(place, &String::from_utf8_lossy(&body))))
    }
}

fn cut(place: &SourceLine, text: &str) -> Snippet {
    let SourceLine { name, line } = place.clone();
    let first_line = line.saturating_sub(LINES_BEFORE).max(1);
    let lines = text.lines().skip(first_line.saturating_sub(1)).take(LINES).map(str::to_owned).collect();
    Snippet { name, line, first_line, lines }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(name: &str, line: usize) -> SourceLine {
        SourceLine { name: name.into(), line }
    }

    #[test]
    fn places_are_split_from_the_right() {
        assert_eq!(SourceLine::parse("a/fire.pdl:14:3"), Some(line("a/fire.pdl", 14)));
        assert_eq!(SourceLine::parse("C:/fire.pdl:14:3"), Some(line("C:/fire.pdl", 14)));
        assert_eq!(SourceLine::parse("fire.pdl"), None);
        assert_eq!(SourceLine::parse("fire.pdl:x:3"), None);
    }

    #[test]
    fn a_snippet_starts_two_lines_before_the_place_and_stops_at_the_end() {
        let snippet = cut(&line("f", 3), "a\nb\nc\nd");
        assert_eq!((snippet.first_line, snippet.lines.len()), (1, 4));
        let snippet = cut(&line("f", 1), "a\nb");
        assert_eq!((snippet.first_line, snippet.lines), (1, vec!["a".to_owned(), "b".to_owned()]));
    }
}
