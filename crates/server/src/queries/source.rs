//! `/api/source`: a few lines of the mission's own files around a place.

use crate::answer::{Answer, ApiError};
use crate::record::Reader;
use rusqlite::OptionalExtension;
use serde::{Deserialize, Serialize};

/// Lines shown before the place.
const LINES_BEFORE: usize = 2;
/// Lines shown in all.
const LINES: usize = 9;

/// Parameters.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SourceQuery {
    place: String,
}

/// The answer.
#[derive(Debug, PartialEq, Eq, Serialize)]
pub(crate) struct Snippet {
    /// The file's name as the record has it.
    name: String,
    /// The place's line, from 1.
    line: usize,
    /// The number of the first line given.
    first_line: usize,
    lines: Vec<String>,
}

/// Answers `/api/source`.
pub(crate) fn source(reader: &Reader, query: &SourceQuery) -> Answer<Snippet> {
    let (name, line) = parse_place(&query.place).ok_or_else(|| {
        ApiError::bad_request(format!("`{}` is no place", query.place), "a place is `file:line:column`")
    })?;
    let body: Option<Vec<u8>> = reader
        .connection
        .prepare_cached("SELECT CAST(body AS BLOB) FROM source WHERE name = ?1 ORDER BY position LIMIT 1")?
        .query_row([name], |row| row.get(0))
        .optional()?;
    let body = body.ok_or_else(|| {
        ApiError::not_found(
            format!("the record has no file `{name}`"),
            "procedures made from plans are in the record's events of kind `procedure-added`",
        )
    })?;
    Ok(cut(name, line, &String::from_utf8_lossy(&body)))
}

fn cut(name: &str, line: usize, text: &str) -> Snippet {
    let first_line = line.saturating_sub(LINES_BEFORE).max(1);
    let lines = text.lines().skip(first_line.saturating_sub(1)).take(LINES).map(str::to_owned).collect();
    Snippet { name: name.to_owned(), line, first_line, lines }
}

/// Splits `file:line:column`; the file's name may itself hold colons.
fn parse_place(place: &str) -> Option<(&str, usize)> {
    let (rest, column) = place.rsplit_once(':')?;
    let (name, line) = rest.rsplit_once(':')?;
    column.parse::<usize>().ok()?;
    Some((name, line.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_split_from_the_right() {
        assert_eq!(parse_place("a/fire.pdl:14:3"), Some(("a/fire.pdl", 14)));
        assert_eq!(parse_place("C:/fire.pdl:14:3"), Some(("C:/fire.pdl", 14)));
        assert_eq!(parse_place("fire.pdl"), None);
        assert_eq!(parse_place("fire.pdl:x:3"), None);
    }

    #[test]
    fn a_snippet_starts_two_lines_before_the_place_and_stops_at_the_end() {
        let snippet = cut("f", 3, "a\nb\nc\nd");
        assert_eq!((snippet.first_line, snippet.lines.len()), (1, 4));
        let snippet = cut("f", 1, "a\nb");
        assert_eq!((snippet.first_line, snippet.lines), (1, vec!["a".to_owned(), "b".to_owned()]));
    }
}
