//! Every target runs over its corpus without a violation, also in a build with planted bugs, so that only the fuzzer can find these.

use std::path::PathBuf;

/// Largest permitted corpus of a target, because it is committed.
const CORPUS_BYTES_MAX: u64 = 65_536;

fn files(target: &str) -> Vec<PathBuf> {
    let folder = apex_fuzz::corpus(target);
    let listed = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files: Vec<PathBuf> = listed.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.sort();
    files
}

#[test]
fn every_target_runs_over_its_corpus() {
    for target in apex_fuzz::TARGETS {
        let files = files(target.name);
        assert!(files.len() >= 3, "the corpus of `{}` has {} files", target.name, files.len());
        for file in files {
            let bytes = std::fs::read(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
            println!("{}: {}", target.name, file.display());
            (target.run)(&bytes);
        }
    }
}

#[test]
fn corpora_are_small() {
    for target in apex_fuzz::TARGETS {
        let bytes: u64 = files(target.name).iter().filter_map(|file| Some(file.metadata().ok()?.len())).sum();
        assert!(bytes <= CORPUS_BYTES_MAX, "the corpus of `{}` has {bytes} bytes", target.name);
    }
}

#[test]
fn the_readme_lists_every_target() {
    let readme = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("README.md");
    let readme = std::fs::read_to_string(readme).unwrap_or_default();
    for target in apex_fuzz::TARGETS {
        assert!(readme.contains(&format!("| `{}` |", target.name)), "the README does not list `{}`", target.name);
    }
}
