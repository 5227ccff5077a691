//! `apex why`: why a task started, waits, was interrupted or ended.

use crate::options::WhyOptions;
use crate::telling::wrapped_line;
use crate::trouble::{Outcome, Trouble};
use crate::{output, recording, sources};
use apex_model::time::Time;
use apex_runtime::explain;

/// Explains one task at one instant.
pub fn run(options: &WhyOptions) -> Outcome {
    if options.task.trim().is_empty() {
        return Err(Trouble::user("the task to explain has no name")
            .help("give its number (T12), its tag, or words of its goal"));
    }
    let reader = recording::open(&options.record)?;
    let at = options.at.as_deref().map(|text| sources::parse_time(text, "--at")).transpose()?;
    let why = explain::why_of_any(&reader, &options.task, at.unwrap_or(Time::END), &sources::load_recorded)
        .map_err(|error| Trouble::user(error.to_string()))?;
    if options.json {
        let json = serde_json::to_string_pretty(&why)
            .map_err(|error| Trouble::failure("cannot write the explanation as JSON").because(error))?;
        output::print_line(json)?;
    } else {
        let lines: Vec<String> = why.to_string().trim_end().lines().map(wrapped_line).collect();
        output::print_line(lines.join("\n"))?;
    }
    Ok(())
}
