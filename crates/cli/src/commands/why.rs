//! `apex why`: explains why a task started, waits, was interrupted or ended, which task holds a resource, or why a command was sent.

use crate::error::{CliError, CliResult};
use crate::options::{ExplanationOptions, WhyOptions};
use crate::{output, recording, sources};
use apex_mission::text::wrapped_line;
use apex_model::source::SourceFile;
use apex_model::time::Time;
use apex_runtime::explain::{Explainer, Question};
use serde::Serialize;

/// Explains one task, resource or command at one instant.
pub fn run(options: &WhyOptions) -> CliResult {
    if options.task.trim().is_empty() {
        return Err(CliError::user("the task to explain is not given")
            .help("give its number (T12), its tag, or words of its goal"));
    }
    let reader = recording::open(&options.record)?;
    let question = question(&options.task, &options.explanation)?;
    if let Some(health) = apex_mission::diagnosis::why(&reader, &options.task, question.at)? {
        return print(&health.json, &health.text, options.explanation.json);
    }
    let load = |texts: &[SourceFile]| sources::load_flown_program(&reader, texts);
    let explainer = Explainer::new(&reader, &load);
    let answer = explainer.why(&question).map_err(|error| CliError::user(error.to_string()))?;
    print(&answer, &answer.to_string(), options.explanation.json)
}

/// Parses the question.
pub fn question(what: &str, explanation: &ExplanationOptions) -> CliResult<Question> {
    let at = explanation.at.as_deref().map(|text| sources::parse_time(text, "--at")).transpose()?;
    Ok(Question { what: what.to_owned(), at: at.unwrap_or(Time::END), depth: explanation.depth })
}

/// Prints an answer as JSON or as text.
pub fn print(answer: &impl Serialize, text: &str, json: bool) -> CliResult {
    if json {
        let json = serde_json::to_string_pretty(answer)
            .map_err(|error| CliError::failure("cannot write the explanation as JSON").because(error))?;
        return output::print_line(json);
    }
    let lines: Vec<String> = text.trim_end().lines().map(wrapped_line).collect();
    output::print_line(lines.join("\n"))
}
