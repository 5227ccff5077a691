//! Benchmark files of orienteering and touring: TOPTW, Solomon, OPLib, TSPLIB.
//!
//! Properties: a file that is read is a valid problem; a refusal names its place.

use crate::planted;
use apex_portfolio::formats;

/// Runs the target.
pub(crate) fn run(bytes: &[u8]) {
    let Some(text) = super::text(bytes) else { return };
    let is_one = formats::is_one(text);
    match formats::read("fuzz", text) {
        Ok(instance) => {
            assert!(is_one, "a file is read that is of no format");
            if planted::ARE_IN {
                // The bug: a mean over the legs between targets, but one target has no legs.
                let legs = instance.problem.targets.len() * (instance.problem.targets.len() - 1);
                assert!(legs > 0, "division by zero legs");
            }
        }
        Err(error) => assert!(!error.to_string().is_empty(), "a refusal without a message"),
    }
}
