//! Planted bugs: one typical mistake for each target, to show that the fuzzer finds such a mistake.
//!
//! With the feature `planted-bugs` each target makes its mistake after reading. Without the feature the mistakes do not exist. No file of
//! a corpus triggers one; `tests/corpus.rs` checks that under the feature, too.

/// True in a build with planted bugs.
pub const ARE_IN: bool = cfg!(feature = "planted-bugs");
