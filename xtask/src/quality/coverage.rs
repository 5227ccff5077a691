//! Coverage of lines and branches per crate, from the summary written by `llvm-cov export`. Tests do not count.

use super::rows;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Parts of crates with a minimum coverage of lines and of branches, in percent.
const BARS: &[(&str, f64, f64)] = &[
    ("crates/executive", 95.0, 90.0),
    ("crates/executive/src/monitoring", 95.0, 90.0),
    ("crates/runtime/src/record", 95.0, 90.0),
];

#[derive(Deserialize)]
struct Export {
    data: Vec<Data>,
}

#[derive(Deserialize)]
struct Data {
    files: Vec<File>,
}

#[derive(Deserialize)]
struct File {
    filename: String,
    summary: Summary,
}

#[derive(Deserialize)]
struct Summary {
    lines: Covered,
    branches: Covered,
}

#[derive(Clone, Copy, Default, Deserialize)]
struct Covered {
    count: u64,
    covered: u64,
}

impl Covered {
    fn add(&mut self, other: Covered) {
        self.count += other.count;
        self.covered += other.covered;
    }

    /// Returns the share in percent; `None` if there is nothing to cover.
    fn percent(self) -> Option<f64> {
        (self.count > 0).then(|| 100.0 * self.covered as f64 / self.count as f64)
    }
}

/// Returns the table; `root` is the project's folder, from which the names of files begin.
///
/// # Errors
/// The text is not the summary of `llvm-cov export`.
pub(super) fn table(json: &str, root: &str) -> Result<String, String> {
    let export: Export = serde_json::from_str(json).map_err(|error| format!("coverage.json: {error}"))?;
    let mut parts: BTreeMap<String, (Covered, Covered)> = BTreeMap::new();
    for file in export.data.iter().flat_map(|data| &data.files) {
        let Some(path) = file.filename.strip_prefix(root).map(|path| path.trim_start_matches('/')) else { continue };
        for part in parts_of(path) {
            let (lines, branches) = parts.entry(part).or_default();
            lines.add(file.summary.lines);
            branches.add(file.summary.branches);
        }
    }
    let shown = |percent: Option<f64>| percent.map_or("none".to_string(), |percent| format!("{percent:.1} %"));
    let lines: Vec<String> = parts
        .iter()
        .map(|(part, (lines, branches))| {
            let (lines, branches) = (lines.percent(), branches.percent());
            let bar = BARS.iter().find(|(name, ..)| name == part);
            let met = bar.map_or("", |(_, least_lines, least_branches)| {
                let is_met = lines.is_some_and(|lines| lines >= *least_lines)
                    && branches.is_some_and(|branches| branches >= *least_branches);
                if is_met { "95 % and 90 %: met" } else { "95 % and 90 %: not met" }
            });
            format!("{part}\t{}\t{}\t{met}", shown(lines), shown(branches))
        })
        .collect();
    Ok(rows::table(&["crate or part", "lines", "branches", "bar"], &lines.join("\n")))
}

/// Returns the crate of a source file, and its part with a minimum coverage; empty for tests.
fn parts_of(path: &str) -> Vec<String> {
    let is_test = path.split('/').any(|part| part == "tests" || part.ends_with("tests.rs"));
    let Some((folder, _)) = path.split_once("/src/").filter(|_| !is_test) else { return Vec::new() };
    let within = |name: &str| path.strip_prefix(name).is_some_and(|rest| rest.starts_with('/'));
    let with_bar = BARS.iter().map(|(name, ..)| *name).filter(|name| within(name));
    let mut parts: Vec<String> = with_bar.map(str::to_string).collect();
    if !parts.iter().any(|part| part == folder) {
        parts.push(folder.to_string());
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(name: &str, lines: (u64, u64), branches: (u64, u64)) -> String {
        let count = |(count, covered)| format!("{{\"count\": {count}, \"covered\": {covered}, \"percent\": 0}}");
        format!(
            "{{\"filename\": \"/p/{name}\", \"summary\": {{\"lines\": {}, \"branches\": {}}}}}",
            count(lines),
            count(branches)
        )
    }

    fn export(files: &[String]) -> String {
        format!("{{\"data\": [{{\"files\": [{}]}}], \"type\": \"llvm.coverage.json.export\"}}", files.join(", "))
    }

    #[test]
    fn files_are_summed_by_crate_and_by_part_with_a_bar() {
        let json = export(&[
            file("crates/executive/src/step.rs", (10, 9), (4, 4)),
            file("crates/executive/src/monitoring/part.rs", (10, 10), (6, 5)),
            file("crates/executive/src/monitoring/tests/mod.rs", (10, 0), (6, 0)),
            file("crates/geo/src/sun.rs", (4, 1), (0, 0)),
        ]);
        let table = table(&json, "/p").expect("a summary");
        assert!(table.contains("| crates/executive | 95.0 % | 90.0 % | 95 % and 90 %: met |"), "{table}");
        assert!(
            table.contains("| crates/executive/src/monitoring | 100.0 % | 83.3 % | 95 % and 90 %: not met |"),
            "{table}"
        );
        assert!(table.contains("| crates/geo | 25.0 % | none |  |"), "{table}");
    }

    #[test]
    fn another_text_is_refused_with_its_name() {
        assert!(table("{}", "/p").is_err_and(|message| message.starts_with("coverage.json: ")));
    }
}
