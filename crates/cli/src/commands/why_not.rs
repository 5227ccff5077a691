//! `apex why-not`: explains why something was not created, started, resumed, chosen, granted or visited.

use super::why;
use crate::error::{CliError, CliResult};
use crate::options::WhyNotOptions;
use crate::{recording, sources};
use apex_model::source::SourceFile;
use apex_runtime::explain::Explainer;

/// Explains why something has not happened.
pub fn run(options: &WhyNotOptions) -> CliResult {
    if options.what.trim().is_empty() {
        return Err(CliError::user("the question is empty")
            .help("give a task (T12), a step's tag, a goal such as `(take picture ?x)`, a resource or a target"));
    }
    let reader = recording::open(&options.record)?;
    let question = why::question(&options.what, &options.explanation)?;
    let load = |texts: &[SourceFile]| sources::load_flown_program(&reader, texts);
    let explainer = Explainer::new(&reader, &load);
    let answer = explainer.why_not(&question).map_err(|error| CliError::user(error.to_string()))?;
    why::print(&answer, &answer.to_string(), options.explanation.json)
}
