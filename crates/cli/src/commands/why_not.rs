//! `apex why-not`: why something was not created, started, resumed, chosen, granted, visited.

use super::why;
use crate::options::WhyNotOptions;
use crate::trouble::{Outcome, Trouble};
use crate::{recording, sources};
use apex_runtime::explain::Explainer;

/// Explains what is not.
pub fn run(options: &WhyNotOptions) -> Outcome {
    if options.what.trim().is_empty() {
        return Err(Trouble::user("the question names nothing")
            .help("give a task (T12), a step's tag, a goal such as `(take picture ?x)`, a resource or a target"));
    }
    let reader = recording::open(&options.record)?;
    let question = why::question(&options.what, &options.telling)?;
    let explainer = Explainer::new(&reader, &sources::load_recorded);
    let answer = explainer.why_not(&question).map_err(|error| Trouble::user(error.to_string()))?;
    why::print(&answer, &answer.to_string(), options.telling.json)
}
