//! The lines that Apex and a solver program exchange over the program's standard input and output, one JSON object per line
//! (`docs/reference/solver-programs.md`).

use crate::solver_words::short;
use apex_model::problem::{Plan, Problem, SurveillanceProblem};
use apex_planning::surveillance::scenario::Scenario;
use serde::{Deserialize, Serialize};
use serde_json::Value as Json;

/// The version of the protocol, as the member `apex_solver` of a request.
pub(super) const VERSION: u32 = 1;

/// The request of Apex: the first line.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ProgramRequest {
    pub(super) apex_solver: u32,
    /// The requested planner, for programs that contain several.
    pub(super) solver: String,
    pub(super) seed: u64,
    /// Work allowed, in units that last a microsecond of the flight.
    pub(super) work_units: u64,
    pub(super) problem: Problem,
    /// The plan that is flown now.
    pub(super) previous: Option<Plan>,
}

/// The line that requests a program to end soon, because its budget is used up or its answer is no longer required.
pub(super) const STOP_LINE: &str = "{\"stop\":true}";

/// A line that the program writes.
#[derive(Debug, PartialEq)]
pub(super) enum ProgramLine {
    /// Work units since the last charge.
    Charge(u64),
    /// Its best plan so far.
    Report(Plan),
    /// Its answer.
    Plan(Plan),
    /// Its answer: there is no plan, for this reason.
    Failed(String),
}

impl ProgramLine {
    /// Returns the line, without its end.
    pub(super) fn line(&self) -> Result<String, String> {
        let json = match self {
            ProgramLine::Charge(units) => serde_json::to_string(&serde_json::json!({ "charge": units })),
            ProgramLine::Report(plan) => serde_json::to_string(&serde_json::json!({ "report": plan })),
            ProgramLine::Plan(plan) => serde_json::to_string(&serde_json::json!({ "plan": plan })),
            ProgramLine::Failed(reason) => serde_json::to_string(&serde_json::json!({ "failed": reason })),
        };
        json.map_err(|error| error.to_string())
    }

    /// Reads a line of the program `name`, whose request was `problem`.
    ///
    /// # Errors
    /// The error in the line, with its beginning.
    pub(super) fn read(line: &[u8], name: &str, problem: &Problem) -> Result<ProgramLine, String> {
        let text = String::from_utf8_lossy(line);
        let wrong =
            |why: String| format!("sent a line that does not follow the protocol ({why}): `{}`", excerpt(&text));
        let json = crate::unique_json::parse(&text).map_err(|error| wrong(error.to_string()))?;
        let Json::Object(members) = json else { return Err(wrong("expected a JSON object".into())) };
        let mut members = members.into_iter();
        let (Some((key, value)), None) = (members.next(), members.next()) else {
            return Err(wrong("expected one member".into()));
        };
        match (key.as_str(), value) {
            ("charge", value) => {
                value.as_u64().map(ProgramLine::Charge).ok_or_else(|| wrong("expected a whole number of units".into()))
            }
            ("report", value) => plan(value, name, problem).map(ProgramLine::Report).map_err(wrong),
            ("plan", value) => plan(value, name, problem).map(ProgramLine::Plan).map_err(wrong),
            ("failed", Json::String(reason)) => Ok(ProgramLine::Failed(short(&reason))),
            _ => Err(wrong("expected `charge`, `report`, `plan` or `failed`".into())),
        }
    }
}

/// Returns a plan in the program's notation: complete, or for surveillance the names of the targets in the order of visits.
fn plan(value: Json, name: &str, problem: &Problem) -> Result<Plan, String> {
    match (problem, value) {
        (Problem::Surveillance(problem), Json::Array(order)) => surveillance(order, name, problem),
        (_, value) => serde_json::from_value(value).map_err(|error| format!("no plan: {error}")),
    }
}

fn surveillance(order: Vec<Json>, name: &str, problem: &SurveillanceProblem) -> Result<Plan, String> {
    let scenario = Scenario::new(problem)?;
    let index = |target: Json| {
        let target = target.as_str().ok_or_else(|| format!("{target} is not the name of a target"))?;
        let found = problem.targets.iter().position(|known| known.name == target);
        found.ok_or_else(|| format!("it visits `{}`, which is not a target", excerpt(target)))
    };
    let word = order.into_iter().map(index).collect::<Result<Vec<usize>, String>>()?;
    Ok(Plan::Surveillance(scenario.plan(name, word)))
}

/// Returns the beginning of a text, for a message of one line.
pub(super) fn excerpt(text: &str) -> String {
    let mut shown: String = text.trim().chars().take(80).flat_map(char::escape_debug).collect();
    if text.trim().chars().nth(80).is_some() {
        shown.push_str("..");
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::problem::SingleVisitProblem;

    fn read(line: &str) -> Result<ProgramLine, String> {
        ProgramLine::read(line.as_bytes(), "mine", &Problem::SingleVisit(SingleVisitProblem::default()))
    }

    #[test]
    fn lines_are_of_the_protocol_or_named() {
        assert_eq!(read("{\"charge\": 7}"), Ok(ProgramLine::Charge(7)));
        assert_eq!(read("{\"failed\": \"no way\"}"), Ok(ProgramLine::Failed("no way".into())));
        for (line, why) in [
            ("hello", "expected value"),
            ("7", "expected a JSON object"),
            ("{}", "expected one member"),
            ("{\"charge\": 1, \"plan\": 2}", "expected one member"),
            ("{\"charge\": 1, \"charge\": 1}", "charge"),
            ("{\"charge\": -1}", "whole number"),
            ("{\"plan\": 3}", "no plan"),
            ("{\"plan\": [\"a\"]}", "no plan"),
            ("{\"answer\": 3}", "expected `charge`"),
            ("\u{1b}[2J", "\\u{1b}[2J"),
        ] {
            let fault = read(line).unwrap_err();
            assert!(fault.contains("does not follow the protocol") && fault.contains(why), "{line}: {fault}");
        }
        assert!(read(&"x".repeat(10_000)).unwrap_err().len() < 300);
    }
}
