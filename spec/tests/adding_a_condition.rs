//! The guide on adding a condition shows all lines that name its form outside its files, and these lines are few.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Names of the form and of its files contain this.
const FORM: &str = "cyclic";
/// Maximum number of lines for a form outside its own files.
const LINES_MAX: usize = 60;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Collects the source files below `folder` that are neither the form's own nor tests.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for path in fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() {
            if name != "tests" {
                sources(&path, found);
            }
        } else if name.ends_with(".rs") && !name.contains(FORM) && !["tests.rs", "planted.rs"].contains(&name.as_str())
        {
            found.push(path);
        }
    }
}

/// Returns lines of `text` that name the form, each up to where its brackets are closed; tests at the end do not count.
fn lines_of_form(text: &str) -> usize {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let (mut lines, mut depth) = (0, 0);
    for line in text.lines() {
        if depth > 0 || line.to_lowercase().contains(FORM) {
            lines += 1;
            let count = |brackets: &str| line.chars().filter(|character| brackets.contains(*character)).count() as i64;
            depth = (depth + count("({[") - count(")}]")).max(0);
        }
    }
    lines
}

/// Returns the lines by file in the table of the guide.
fn told() -> BTreeMap<String, usize> {
    let guide = fs::read_to_string(root().join("docs/guides/adding-a-condition.md")).unwrap_or_default();
    let row = |line: &str| {
        let (file, rest) = line.strip_prefix("| `")?.split_once("` | ")?;
        Some((file.to_string(), rest.split(' ').next()?.parse().ok()?))
    };
    guide.lines().filter_map(row).collect()
}

#[test]
fn the_guide_shows_all_lines_that_name_the_form() {
    let mut files = Vec::new();
    sources(&root().join("crates"), &mut files);
    let mut counted = BTreeMap::new();
    for file in files {
        let lines = lines_of_form(&fs::read_to_string(&file).unwrap_or_default());
        let name = file.strip_prefix(root()).unwrap_or(&file).to_string_lossy().replace('\\', "/");
        if lines > 0 {
            counted.insert(name, lines);
        }
    }
    assert_eq!(counted, told(), "the table of docs/guides/adding-a-condition.md");
    let all: usize = counted.values().sum();
    assert!(all < LINES_MAX, "{all} lines name the form `:{FORM}` outside its own files");
}

#[test]
fn a_line_counts_with_what_stands_in_its_brackets() {
    let text = "use cyclic;\nmatch part {\n    Cyclic(leaf) => {\n        look(leaf);\n    }\n    Other => {}\n}\n";
    assert_eq!(lines_of_form(text), 4);
    assert_eq!(lines_of_form("fn f() {}\n#[cfg(test)]\nmod tests {\n    // cyclic\n}\n"), 0);
}
