//! A question about a run: `why TASK@T` records the run and queries the record, like the command `apex why`.

use crate::scenario::{self, PROGRAM_NAME, Scenario};
use apex_runtime::error::RecordError;
use apex_runtime::explain::{Explainer, Question};
use apex_runtime::record::{RecordOptions, RecordReader, Recorder, RestoredProgram};

/// Returns the answer of `apex why` or `apex why-not`, selected by `word`, about the scenario's run. `question` is a task, resource or
/// command, in the form that the command accepts, and an instant: `take-picture@2s`.
///
/// # Errors
/// The checker's messages, a bad input line, option or question, or a record that cannot be written or read.
pub fn answer(scenario: &Scenario, word: &str, question: &str) -> Result<String, String> {
    let parts = question.rsplit_once('@');
    let (task, at) = parts.ok_or_else(|| format!("`{word} {question}`: expected a task and an instant, `TASK@2s`"))?;
    let at = scenario::read_time(at).map_err(|reason| format!("`{word} {question}`: {reason}"))?;
    let Recorded { reader, program, .. } = &recorded(scenario)?;
    let question = Question::new(task.trim(), at);
    let load = |_: &[apex_model::source::SourceFile]| Ok(program.clone());
    let explainer = Explainer::new(reader, &load);
    match word {
        "why-not" => explainer.why_not(&question).map(|answer| answer.to_string()).map_err(told),
        _ => explainer.why(&question).map(|answer| answer.to_string()).map_err(told),
    }
}

/// A run with its record, which is deleted when this is dropped.
pub struct Recorded {
    /// Reads the record.
    pub reader: RecordReader,
    /// The program that was run.
    pub program: RestoredProgram,
    _folder: tempfile::TempDir,
}

/// Runs the scenario and records it.
///
/// # Errors
/// Like [`answer`].
pub fn recorded(scenario: &Scenario) -> Result<Recorded, String> {
    let program = scenario::program_of(scenario)?;
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let path = folder.path().join(PROGRAM_NAME).with_extension("apex");
    let mut recorder = Recorder::create(&path, &program.0, RecordOptions::default()).map_err(told)?;
    recorder.program(&program.0).map_err(told)?;
    let end = scenario::run_observed(scenario, &program, &mut [&mut recorder])?.map_err(|error| error.to_string())?;
    recorder.finish(end.at, &end.reason.text()).map_err(told)?;
    let reader = RecordReader::open(&path).map_err(told)?;
    Ok(Recorded { reader, program, _folder: folder })
}

fn told(error: RecordError) -> String {
    error.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PDL: &str = "(procedure (do-domain) (step a (print \"x\") (waitfor (go))))";

    #[test]
    fn a_question_without_an_instant_says_what_is_missing() {
        let scenario = Scenario { pdl: PDL.into(), ..Scenario::default() };
        let error = answer(&scenario, "why", "a").expect_err("no instant");
        assert!(error.contains("TASK@2s"), "{error}");
        assert!(answer(&scenario, "why", "a@soon").is_err());
    }

    #[test]
    fn the_record_is_asked() {
        let scenario = Scenario { pdl: PDL.into(), ..Scenario::default() };
        let text = answer(&scenario, "why", "a@2s").expect("a is known");
        assert!(text.contains("is pending at") && text.contains("waitfor (go)"), "{text}");
    }
}
