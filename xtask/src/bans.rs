//! The ban list of core crates. Clippy uses the nearest `clippy.toml` and does not merge, so each file holds the whole list.

use crate::finding::Finding;
use crate::tree::{self, Text};

/// Packages that must be deterministic and never panic.
const CORE: &[&str] = &[
    "crates/model",
    "crates/forms",
    "crates/pdl",
    "crates/executive",
    "crates/geo",
    "crates/requirements",
    "crates/metrics",
    "crates/planning",
    "crates/solvers",
    "crates/mission",
    "crates/portfolio",
    "crates/vehicle",
    "adapters/sim",
];
/// Entries that the list must have: clocks, threads, platform mathematics, size.
const REQUIRED: &[&str] = &[
    "std::time::Instant::now",
    "std::time::SystemTime::now",
    "std::thread::sleep",
    "std::thread::spawn",
    "f64::sin",
    "f64::cos",
    "f64::atan2",
    "f64::exp",
    "f64::ln",
    "f64::powf",
    "std::time::SystemTime\"",
    "too-many-lines-threshold = 70",
];

/// Checks that every core crate has the same list and that the list is whole.
pub(crate) fn check(texts: &[Text]) -> Vec<Finding> {
    let reference = CORE.first().map(|folder| format!("{folder}/clippy.toml")).unwrap_or_default();
    let Some(list) = tree::find(texts, &reference) else {
        return vec![Finding::new(&reference, 1, "bans", "missing: the reference ban list lives here")];
    };
    let mut findings: Vec<Finding> = REQUIRED
        .iter()
        .filter(|entry| !list.body.contains(**entry))
        .map(|entry| Finding::new(&reference, 1, "bans", format!("`{entry}` is not on the list: put it back")))
        .collect();
    for path in CORE.iter().skip(1).map(|folder| format!("{folder}/clippy.toml")) {
        match tree::find(texts, &path) {
            Some(other) if other.body == list.body => {}
            Some(_) => {
                findings.push(Finding::new(&path, 1, "bans", format!("differs from {reference}: copy it whole")))
            }
            None => findings.push(Finding::new(&path, 1, "bans", format!("missing: copy {reference}"))),
        }
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    fn house(list: &str) -> Vec<Text> {
        CORE.iter().map(|folder| Text::sample(&format!("{folder}/clippy.toml"), list)).collect()
    }

    #[test]
    fn equal_and_whole_lists_pass() {
        assert_eq!(check(&house(&REQUIRED.join("\n"))), []);
    }

    #[test]
    fn a_shortened_or_missing_list_fails() {
        assert!(!check(&house("too-many-lines-threshold = 70")).is_empty());
        let mut texts = house(&REQUIRED.join("\n"));
        texts[2].body.push('\n');
        assert_eq!(check(&texts).len(), 1);
        texts.remove(2);
        assert!(check(&texts)[0].message.contains("missing"));
    }
}
