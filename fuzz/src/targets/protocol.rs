//! Lines of an external simulator (`docs/reference/foreign-simulators.md`), as a dialogue with one agent.
//!
//! Properties: every line is answered with one line of JSON, even after an error, and the dialogue ends.

use super::read_value;
use crate::planted;
use crate::sample;
use apex_executive::load;
use apex_runtime::foreign::{Cues, SimulatorLink, run as run_foreign};
use apex_runtime::mission_loop::RunSettings;
use apex_runtime::record::RestoredProgram;
use apex_spec::outside::{PagePlanner, PlannerManner};
use serde_json::Value as Json;
use std::io::BufReader;
use std::sync::{Arc, LazyLock};

const BYTES_MAX: usize = 65_536;

static PROGRAM: LazyLock<RestoredProgram> = LazyLock::new(|| {
    apex_spec::scenario::program(sample::PROGRAM).unwrap_or_else(|error| panic!("the program does not check: {error}"))
});

/// Runs the target.
pub(crate) fn run(bytes: &[u8]) {
    if bytes.len() > BYTES_MAX {
        return;
    }
    let (library, declaration, host) = PROGRAM.clone();
    let agent = load(Arc::clone(&library), &declaration, host);
    let mut agents = [agent.unwrap_or_else(|error| panic!("the agent does not load: {error}"))];
    let (mut input, mut output) = (BufReader::new(bytes), Vec::new());
    let mut link = SimulatorLink {
        input: &mut input,
        output: &mut output,
        read_value: &read_value,
        cues: Cues::default(),
        may_reset: true,
    };
    let mut planner = PagePlanner(PlannerManner::default());
    // A line that is not UTF-8 or too long ends the dialogue with an error.
    let _ = run_foreign(&mut agents, &mut link, &mut planner, &mut [], RunSettings::default());
    let lines = bytes.split(|byte| *byte == b'\n').count();
    let answers = output.split(|byte| *byte == b'\n').filter(|line| !line.is_empty());
    let mut count = 0;
    for answer in answers {
        count += 1;
        let answer =
            serde_json::from_slice::<Json>(answer).unwrap_or_else(|error| panic!("an answer is not JSON: {error}"));
        assert!(answer.is_object(), "an answer is not an object: {answer}");
        if planted::ARE_IN {
            // The bug: times of answers are taken to be whole seconds.
            assert!(answer.get("t").is_none_or(|time| time.as_i64().is_some()), "the time of {answer} is not whole");
        }
    }
    assert!(count <= lines + 1, "{count} answers to {lines} lines");
}
