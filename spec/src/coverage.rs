//! The table of every construct and the page that shows it (`docs/reference/pdl-coverage.md`), and the checks of that table.

use crate::page;
use std::fs;
use std::path::{Path, PathBuf};

/// A row: a construct as written, and a page with a program that contains it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// The text to be found in a program of the page; `..` matches anything.
    pub construct: String,
    /// The page below `spec/`, without `.md`.
    pub page: String,
}

/// Returns the path of the table.
pub fn table() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/reference/pdl-coverage.md")
}

/// Returns the rows of the table in `text`: lines `| `CONSTRUCT` | [PAGE](..) |`.
pub fn rows(text: &str) -> Vec<Row> {
    text.lines().filter_map(row).collect()
}

fn row(line: &str) -> Option<Row> {
    let (construct, rest) = line.strip_prefix("| `")?.split_once("` | [")?;
    let (page, _) = rest.split_once(']')?;
    Some(Row { construct: construct.to_string(), page: page.to_string() })
}

/// Returns the reason if the row's page does not show its construct.
pub fn fault(row: &Row) -> Option<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("{}.md", row.page));
    let Ok(text) = fs::read_to_string(&path) else {
        return Some(format!("`{}`: there is no page {}", row.construct, row.page));
    };
    let blocks = page::blocks(&text);
    let programs = blocks.iter().filter(|block| block.kind == "pdl").map(|block| plain(&block.body));
    let shown = programs.into_iter().any(|program| shows(&program, &plain(&row.construct)));
    (!shown).then(|| format!("`{}`: no program on page {} has it", row.construct, row.page))
}

/// Returns the text in lower case with single spaces between words; programs and constructs are compared in this form.
fn plain(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ").to_lowercase()
}

/// Returns true if the program contains the construct. A bare name must be separate, written as `#'name` or after an opening parenthesis.
pub fn shows(program: &str, construct: &str) -> bool {
    if construct.chars().all(is_of_name) {
        return program.split(|character: char| !is_of_name(character)).any(|word| word == construct);
    }
    let mut parts = construct.split("..").map(str::trim);
    let first = parts.next().unwrap_or_default();
    let rest: Vec<&str> = parts.filter(|part| !part.is_empty()).collect();
    program.match_indices(first).any(|(at, _)| {
        let mut left = program.get(at + first.len()..).unwrap_or_default();
        rest.iter().all(|part| match left.find(part) {
            Some(found) => {
                left = left.get(found + part.len()..).unwrap_or_default();
                true
            }
            None => false,
        })
    })
}

fn is_of_name(character: char) -> bool {
    character.is_alphanumeric() || "-+*/<>=_&:".contains(character)
}

#[cfg(test)]
mod tests {
    use super::{Row, rows, shows};

    #[test]
    fn rows_are_read() {
        let text =
            "| written | page |\n|---|---|\n| `(restart (when` | [tasks/restart](../../spec/tasks/restart.md) |\n";
        let expected = Row { construct: "(restart (when".into(), page: "tasks/restart".into() };
        assert_eq!(rows(text), [expected]);
    }

    #[test]
    fn names_stand_alone_and_constructs_anywhere() {
        assert!(shows("(step a (print (max 1 2)))", "max") && !shows("(maximum 1)", "max"));
        assert!(shows("(suspend (when (a)) (until (b)))", "(suspend (when .. (until"));
        assert!(!shows("(until (b)) (suspend (when (a)))", "(suspend (when .. (until"));
    }
}
