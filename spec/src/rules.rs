//! The table of the rules of conditions (`docs/reference/condition-rules.md`), and the checks of its rows.

use crate::page;
use std::path::{Path, PathBuf};

/// Number of rules of the design.
pub const RULES: u32 = 23;

/// A row: a rule, and the files that its links name, by columns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// The rule's number.
    pub number: u32,
    /// Files of the services that implement the rule.
    pub services: Vec<String>,
    /// Files that define it.
    pub definitions: Vec<String>,
    /// Pages that fail if the rule is broken.
    pub pages: Vec<String>,
}

/// Returns the path of the table.
pub fn table() -> PathBuf {
    root().join("docs/reference/condition-rules.md")
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Returns the rows of the table in `text`: lines `| NUMBER | RULE | SERVICES | DEFINITION | PAGES |`.
pub fn rows(text: &str) -> Vec<Row> {
    text.lines().filter_map(row).collect()
}

fn row(line: &str) -> Option<Row> {
    let mut cells = line.strip_prefix('|')?.split('|').map(str::trim);
    let number = cells.next()?.parse().ok()?;
    let _words = cells.next()?;
    let mut column = || Some(links(cells.next()?));
    Some(Row { number, services: column()?, definitions: column()?, pages: column()? })
}

/// Returns the targets of the links in a cell, without the leading `../`.
fn links(cell: &str) -> Vec<String> {
    let targets = cell.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    targets.map(|(target, _)| target.trim_start_matches("../").to_string()).collect()
}

/// Returns the defects of the row: a column without a file, a file that does not exist, a page that is not run.
pub fn faults(row: &Row) -> Vec<String> {
    let Row { number, services, definitions, pages } = row;
    let mut faults = Vec::new();
    for (column, files) in [("services", services), ("definitions", definitions), ("pages", pages)] {
        if files.is_empty() {
            faults.push(format!("rule {number}: nothing in the column of {column}"));
        }
        let missing = files.iter().filter(|file| !root().join(file).is_file());
        faults.extend(missing.map(|file| format!("rule {number}: there is no file {file}")));
    }
    let run: Vec<PathBuf> = page::files();
    let is_run =
        |file: &String| file.strip_prefix("spec/").is_some_and(|name| run.iter().any(|page| page.ends_with(name)));
    let idle = pages.iter().filter(|file| !is_run(file));
    faults.extend(idle.map(|file| format!("rule {number}: {file} is not a page that runs")));
    faults
}

#[cfg(test)]
mod tests {
    use super::{Row, faults, rows};

    #[test]
    fn rows_are_read_by_columns() {
        let text = "| | rule | services |\n|---|---|---|\n| 7 | whole runs | [a.rs](../../a/b.rs), [c](../../c.rs) | | [p](../../spec/README.md) |\n";
        let expected = Row {
            number: 7,
            services: vec!["a/b.rs".into(), "c.rs".into()],
            definitions: vec![],
            pages: vec!["spec/README.md".into()],
        };
        assert_eq!(rows(text), std::slice::from_ref(&expected));
        let faults = faults(&expected);
        let expected =
            ["no file a/b.rs", "no file c.rs", "in the column of definitions", "README.md is not a page that runs"];
        assert_eq!(faults.len(), expected.len(), "{faults:?}");
        assert!(faults.iter().zip(expected).all(|(fault, expected)| fault.ends_with(expected)), "{faults:?}");
    }
}
