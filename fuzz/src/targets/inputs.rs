//! Lines of inputs: files of `apex run --inputs`, answers of the operator, and lines typed during a run.
//!
//! Properties: an accepted file is ordered by time; a refusal names the file.

use super::read_value;
use crate::planted;
use apex_model::time::Time;
use apex_runtime::answer_lines::read_answers;
use apex_runtime::input_lines::{read_inputs, read_live};
use apex_runtime::live_lines::OpenQuestions;

/// Runs the target.
pub(crate) fn run(bytes: &[u8]) {
    let Some(text) = super::text(bytes) else { return };
    match read_inputs("fuzz.jsonl", text, &read_value) {
        Ok(inputs) => {
            assert!(inputs.is_sorted_by_key(|input| input.at), "inputs are not in order of time");
            if planted::ARE_IN {
                // The bug: the duration of the file is computed without a check for overflow.
                let sum = inputs.iter().try_fold(0_i64, |sum, input| sum.checked_add(input.at.0));
                assert!(sum.is_some(), "the sum of instants overflows");
            }
        }
        Err(faults) => {
            let all_named = faults.0.iter().all(|fault| fault.starts_with("fuzz.jsonl"));
            assert!(!faults.0.is_empty() && all_named, "a refusal without its place: {:?}", faults.0);
        }
    }
    if let Err(faults) = read_answers("fuzz.jsonl", text, &read_value) {
        assert!(!faults.0.is_empty(), "a refusal without a reason");
    }
    let questions = OpenQuestions::default();
    questions.opened("pilot".into(), apex_model::effect::QuestionId(1), "land?");
    for line in text.lines() {
        let _ = read_live(line, Time::ZERO, &read_value);
        let _ = questions.understand(line, &read_value);
    }
}
