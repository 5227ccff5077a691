//! A failing case as a page of the specification that can be read, corrected and kept.

use crate::compare::{Verdict, judge};
use crate::generate::{Case, UNTIL};
use crate::print;
use apex_reference::program::SECOND;
use std::fmt::Write;

/// Returns the page of a case. Its trace is empty: `UPDATE=1` fills it, and a reader must judge it.
pub fn of(seed: u64, case: &Case) -> String {
    let mut page = without_difference(seed, case);
    if let Verdict::Different(difference) = judge(case) {
        let _ = write!(page, "\n<!--\n{difference}-->\n");
    }
    page
}

/// Like `of`, for a case without a difference; nothing is run.
pub fn without_difference(seed: u64, case: &Case) -> String {
    let mut page = format!("# Random program {seed}\n\n```pdl\n{}```\n", print::program(&case.program));
    if !case.inputs.is_empty() {
        let _ = write!(page, "\n```inputs\n{}```\n", print::inputs(&case.inputs));
    }
    let until = UNTIL / SECOND;
    let _ = write!(
        page,
        "\n```options\nuntil {until}s\nshow enabled ongoing interrupted terminated pending print inform causes\n```\n"
    );
    page.push_str("\n```trace\n```\n");
    page
}
