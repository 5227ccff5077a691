//! Fuzz targets: functions from arbitrary bytes that must neither panic nor hang, each with the properties that it checks.
//!
//! The functions do not depend on a fuzzer. The tests run them on the corpora, and `main.rs` runs one of them under libFuzzer.

#![allow(clippy::panic, reason = "a target reports a violated property by a panic, which the fuzzer catches")]

pub mod planted;
mod sample;
mod targets;

use std::path::PathBuf;

/// A fuzz target.
pub struct FuzzTarget {
    /// Its name, which is also that of its corpus.
    pub name: &'static str,
    /// Runs the target on one input; panics if a property is violated.
    pub run: fn(&[u8]),
}

/// All targets, in the order of the README.
pub const TARGETS: &[FuzzTarget] = &[
    FuzzTarget { name: "pdl", run: targets::pdl::run },
    FuzzTarget { name: "inputs", run: targets::inputs::run },
    FuzzTarget { name: "mission", run: targets::mission::run },
    FuzzTarget { name: "logs", run: targets::logs::run },
    FuzzTarget { name: "problems", run: targets::problems::run },
    FuzzTarget { name: "benchmarks", run: targets::benchmarks::run },
    FuzzTarget { name: "records", run: targets::records::run },
    FuzzTarget { name: "protocol", run: targets::protocol::run },
    FuzzTarget { name: "http", run: targets::http::run },
];

/// Returns the target called `name`.
pub fn find(name: &str) -> Option<&'static FuzzTarget> {
    TARGETS.iter().find(|target| target.name == name)
}

/// Returns the folder of the target's corpus.
pub fn corpus(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("corpus").join(name)
}
