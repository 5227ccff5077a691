//! `apex why`: why a task started, waits, was interrupted or ended.

use crate::options::WhyOptions;
use crate::sources;
use crate::trouble::{Outcome, Trouble};
use apex_model::time::Time;
use apex_runtime::explain;

/// Explains one task at one instant.
pub fn run(options: &WhyOptions) -> Outcome {
    let reader = super::replay::open(&options.record)?;
    let at = options.at.as_deref().map(|text| sources::parse_time(text, "--at")).transpose()?;
    let why = explain::why(&reader, &options.task, at.unwrap_or(Time::END), &sources::load_recorded)
        .map_err(|error| Trouble::user(error.to_string()))?;
    if options.json {
        let json = serde_json::to_string_pretty(&why)
            .map_err(|error| Trouble::failure("cannot write the explanation as JSON").because(error))?;
        println!("{json}");
    } else {
        println!("{why}");
    }
    Ok(())
}
