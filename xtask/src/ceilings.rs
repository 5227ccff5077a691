//! Ceilings: counts of things that should disappear. A count may fall but must not rise.
//!
//! Each rule has its table in `xtask/`: a key, a tab, the highest count that is allowed. A key
//! without a row has the ceiling zero. `--update` lowers ceilings to today's counts and removes rows that reach zero.

use crate::finding::Finding;
use crate::tree::{self, Text};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Counts by key.
pub(crate) type Counts = BTreeMap<String, usize>;

/// Returns findings for counts above the ceilings in the table at `path`; `advice` gives the remedy for a key.
pub(crate) fn check(
    texts: &[Text],
    path: &str,
    rule: &'static str,
    counts: &Counts,
    advice: impl Fn(&str) -> String,
) -> Vec<Finding> {
    let Some(table) = tree::find(texts, path) else {
        return vec![Finding::new(path, 1, rule, "missing: create it, empty if nothing is counted")];
    };
    let ceilings = parse(&table.body);
    let above = counts.iter().filter_map(|(key, count)| {
        let (line, ceiling) = ceilings.get(key).copied().unwrap_or((1, 0));
        (*count > ceiling).then(|| {
            Finding::new(path, line, rule, format!("{count} of `{key}`, the ceiling is {ceiling}: {}", advice(key)))
        })
    });
    above.collect()
}

/// The counts that may rise when a table is lowered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Keys {
    /// Each count may only fall.
    Fixed,
    /// The sum may only fall.
    Movable,
}

/// Lowers the ceilings of the table at `path` to `counts` and writes it.
///
/// # Errors
/// The counts above their ceilings, or the file that cannot be read or written.
pub(crate) fn lower(root: &Path, path: &str, counts: &Counts, keys: Keys) -> Result<String, String> {
    let file = root.join(path);
    let old = fs::read_to_string(&file).map_err(|error| format!("cannot read {path}: {error}"))?;
    let ceilings = parse(&old);
    let ceiling = |key: &String| ceilings.get(key).map_or(0, |(_, ceiling)| *ceiling);
    let risen: Vec<&str> =
        counts.iter().filter(|(key, count)| **count > ceiling(key)).map(|(key, _)| key.as_str()).collect();
    let (before, after) =
        (ceilings.values().map(|(_, ceiling)| ceiling).sum::<usize>(), counts.values().sum::<usize>());
    if !risen.is_empty() && (keys == Keys::Fixed || after > before) {
        return Err(format!("{path} is not lowered, because these counts have risen: {}", risen.join(", ")));
    }
    let rows: Vec<String> =
        counts.iter().filter(|(_, count)| **count > 0).map(|(key, count)| format!("{key}\t{count}\n")).collect();
    fs::write(&file, rows.concat()).map_err(|error| format!("cannot write {path}: {error}"))?;
    Ok(format!("{path}: from {before} to {after}"))
}

/// Returns the line and ceiling of each key.
fn parse(table: &str) -> BTreeMap<String, (usize, usize)> {
    let rows = table.lines().enumerate().filter_map(|(index, line)| {
        let (key, count) = line.rsplit_once('\t')?;
        Some((key.to_string(), (index + 1, count.trim().parse().ok()?)))
    });
    rows.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(rows: &[(&str, usize)]) -> Counts {
        rows.iter().map(|(key, count)| (key.to_string(), *count)).collect()
    }

    #[test]
    fn counts_may_fall_and_must_not_rise() {
        let texts = [Text::sample("t.tsv", "a b\t3\nc\t1\n")];
        let advice = |key: &str| format!("mend {key}");
        assert_eq!(check(&texts, "t.tsv", "x", &counts(&[("a b", 3), ("c", 0)]), advice), []);
        let found = check(&texts, "t.tsv", "x", &counts(&[("a b", 3), ("c", 2), ("new", 1)]), advice);
        assert_eq!(found.len(), 2);
        assert_eq!(found[0].line, 2);
        assert!(found[1].message.contains("ceiling is 0: mend new"), "{}", found[1]);
        assert_eq!(check(&[], "t.tsv", "x", &counts(&[]), advice).len(), 1);
    }

    #[test]
    fn an_update_lowers_and_never_raises() {
        let folder = std::env::temp_dir().join(format!("apex-ceilings-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("t.tsv"), "a\t3\nb\t2\n").unwrap();
        assert!(lower(&folder, "t.tsv", &counts(&[("a", 4)]), Keys::Fixed).unwrap_err().contains('a'));
        assert!(lower(&folder, "t.tsv", &counts(&[("c", 6)]), Keys::Movable).is_err());
        lower(&folder, "t.tsv", &counts(&[("c", 5)]), Keys::Movable).unwrap();
        fs::write(folder.join("t.tsv"), "a\t3\nb\t2\n").unwrap();
        lower(&folder, "t.tsv", &counts(&[("a", 1), ("b", 0)]), Keys::Fixed).unwrap();
        assert_eq!(fs::read_to_string(folder.join("t.tsv")).unwrap(), "a\t1\n");
        fs::remove_dir_all(&folder).unwrap();
    }
}
