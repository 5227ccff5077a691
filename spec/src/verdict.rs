//! A whole page: every block that states a result (`trace`, `why`, `check` and others), compared with the actual result.

use crate::data_file;
use crate::diagnosis;
use crate::diff;
use crate::observed;
use crate::page::{self, Block};
use crate::question;
use crate::scenario::{self, Scenario};
use apex_model::task::TaskState;
use std::collections::BTreeSet;

/// Result of a page.
#[derive(Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Everything is as stated in the page.
    Holds,
    /// Differences, readable.
    Differs(String),
}

/// Checks the page `text`.
pub fn judge(text: &str) -> Verdict {
    let mut differences = String::new();
    let mut compared = 0;
    for (block, actual) in results(text) {
        compared += 1;
        match actual {
            Ok(actual) => {
                if let Some(difference) = diff::lines(&block.body, &actual) {
                    differences.push_str(&format!("  line {}, {}:\n{difference}", block.line, block.kind));
                }
            }
            Err(reason) => differences.push_str(&format!("  line {}, {}: {reason}\n", block.line, block.kind)),
        }
    }
    if compared == 0 {
        differences
            .push_str("  the page compares nothing: it needs a `trace`, `why`, `check`, `memory` or `score` block\n");
    }
    if differences.is_empty() { Verdict::Holds } else { Verdict::Differs(differences) }
}

/// Returns the page with all compared blocks rewritten to the actual results.
///
/// # Errors
/// The reason why a block cannot be run.
pub fn updated(text: &str) -> Result<String, String> {
    let mut bodies = Vec::new();
    for (block, actual) in results(text) {
        bodies.push((block.line, actual.map_err(|reason| format!("  line {}: {reason}\n", block.line))?));
    }
    Ok(page::rewrite(text, &bodies))
}

/// Returns every change of a task's state in the page's runs.
pub fn transitions(text: &str) -> BTreeSet<(TaskState, TaskState)> {
    let scenarios = scenarios(text).into_iter().filter(|(block, _)| block.kind == "trace");
    scenarios
        .filter_map(|(_, scenario)| scenario::run(&scenario).ok())
        .flat_map(|told| told.transitions().clone())
        .collect()
}

/// Returns each compared block with its actual result, and each block that shows a file with the contents of the file.
fn results(text: &str) -> Vec<(Block, Result<String, String>)> {
    let files = page::blocks(text).into_iter().filter_map(|block| {
        let shown = data_file::text_of(&block)?.and_then(|text| data_file::shown(&block, &text));
        Some((block, shown))
    });
    let scenarios = scenarios(text).into_iter();
    let results = scenarios.map(|(block, scenario)| {
        let actual = match block.kind.as_str() {
            "trace" => scenario::run(&scenario).map(|told| told.text()),
            word @ ("why" | "why-not") => question::answer(&scenario, word, &block.argument),
            "check" => Ok(scenario::messages(&scenario::check(&scenario))),
            "testability" => diagnosis::report(&block.argument),
            "diagnosis" => diagnosis::answer(&block.argument, &scenario.outcomes),
            "memory" => Ok(apex_executive::memory::report(&scenario::check(&scenario).library)),
            "score" => observed::score(&scenario.look),
            other => Err(format!("a page has no blocks of kind `{other}`")),
        };
        (block, actual)
    });
    files.chain(results).collect()
}

/// Returns each block that is not a part of a scenario, with the scenario up to it. `pdl`, `inputs` and `options` apply until the next
/// block of the same kind; a new program starts without inputs and options, but with the files before it. Programs and inputs may be the
/// name of a file of this package.
pub fn scenarios(text: &str) -> Vec<(Block, Scenario)> {
    let mut scenario = Scenario::default();
    let mut files = Vec::new();
    let mut found = Vec::new();
    for mut block in page::blocks(text) {
        if let Some(Ok(text)) = data_file::text_of(&block) {
            block.body = text;
        }
        match block.kind.as_str() {
            "pdl" => scenario = Scenario { pdl: block.body, files: files.clone(), ..Scenario::default() },
            "file" => files.push((block.argument, block.body)),
            "inputs" => scenario.inputs = block.body,
            "options" => scenario.options = block.body,
            "outcomes" => scenario.outcomes = block.body,
            "look" => scenario.look = block.body,
            "" => {}
            _ => found.push((block, scenario.clone())),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_that_compares_nothing_does_not_hold() {
        assert_ne!(judge("# Title\n\nprose\n"), Verdict::Holds);
    }

    #[test]
    fn a_wrong_trace_does_not_hold_and_update_corrects_it() {
        let page = "```pdl\n(procedure (do-domain) (step a (print \"x\")))\n```\n\n```trace\n7s print y\n```\n";
        assert_ne!(judge(page), Verdict::Holds);
        let corrected = updated(page).expect("the program runs");
        assert!(corrected.contains("print x"), "{corrected}");
        assert_eq!(judge(&corrected), Verdict::Holds);
    }
}
