//! One question answered by the executive and the definition, and the difference.

use crate::executive::{Accepted, Refusal, Said, Watch, accepted};
use crate::generate::UNTIL;
use apex_definition::{Outcome, Question, Time, Verdict, first, instants, judge};

/// Result of the comparison of a question.
#[derive(Clone, Debug, PartialEq)]
pub enum Finding {
    /// Both give the same answer; with the result, if there is one.
    Same(Option<Outcome>),
    /// The checker calls the condition impossible, and it is never satisfied.
    Never,
    /// The checker refuses it.
    Refused(String),
    /// The answers differ.
    Different(String),
}

/// Compares both at every instant at which the answer may change, and runs the executive again with a single advance of time.
pub fn compare(question: &Question) -> Finding {
    let accepted = match accepted(question) {
        Ok(accepted) => accepted,
        // A condition that the checker calls impossible must be so by definition.
        Err(Refusal::Never) => {
            return match first(question, UNTIL) {
                None => Finding::Never,
                Some(outcome) => {
                    let outcome = shown(Some(&outcome));
                    Finding::Different(format!("the checker says that it can never hold\n  definition: {outcome}\n"))
                }
            };
        }
        Err(Refusal::Wrong(messages)) => return Finding::Refused(messages),
    };
    let told = match asked_often(question, &accepted) {
        Ok(told) => told,
        Err(message) => return Finding::Different(message),
    };
    match asked_once(question, &accepted) {
        Ok(once) if once == told => Finding::Same(told),
        Ok(once) => Finding::Different(format!(
            "advancing time once gives another result than advancing it often\n  often: {}\n  once:  {}\n",
            shown(told.as_ref()),
            shown(once.as_ref())
        )),
        Err(message) => Finding::Different(message),
    }
}

/// Compares both at every instant up to the first result.
fn asked_often(question: &Question, accepted: &Accepted) -> Result<Option<Outcome>, String> {
    let mut watch = Watch::new(accepted, question)?;
    for now in instants(question, UNTIL) {
        let theirs = judge(question, now);
        let ours = watch.say(now);
        match (&theirs, &ours) {
            (Verdict::Satisfied(theirs), Said::Satisfied(ours)) if theirs == ours => return Ok(Some(theirs.clone())),
            (Verdict::NotSatisfied, Said::NotSatisfied) | (Verdict::Unknown(_), Said::Unknown) => {}
            _ => return Err(difference(now, &theirs, &ours)),
        }
    }
    Ok(None)
}

/// Sends all arrivals first, then advances time once.
fn asked_once(question: &Question, accepted: &Accepted) -> Result<Option<Outcome>, String> {
    let mut watch = Watch::new(accepted, question)?;
    match watch.say(UNTIL) {
        Said::Satisfied(outcome) => Ok(Some(outcome)),
        Said::NotSatisfied | Said::Unknown => Ok(None),
    }
}

fn difference(now: Time, theirs: &Verdict, ours: &Said) -> String {
    let theirs = match theirs {
        Verdict::Satisfied(outcome) => shown(Some(outcome)),
        Verdict::NotSatisfied => "not satisfied".into(),
        Verdict::Unknown(reason) => format!("unknown: {reason}"),
    };
    let ours = match ours {
        Said::Satisfied(outcome) => shown(Some(outcome)),
        Said::NotSatisfied => "not satisfied".into(),
        Said::Unknown => "unknown".into(),
    };
    format!("at {}\n  definition: {theirs}\n  executive:  {ours}\n", seconds(now))
}

fn shown(outcome: Option<&Outcome>) -> String {
    let Some(outcome) = outcome else { return "no result".into() };
    let span = |(start, end): &(Time, Time)| format!("{} .. {}", seconds(*start), seconds(*end));
    let mut text = format!("{} @{}", span(&outcome.interval), seconds(outcome.recognised_at));
    for (name, value) in &outcome.variables {
        text.push_str(&format!(" ?{name} = {}", crate::print::value(value)));
    }
    for (name, interval) in &outcome.tags {
        text.push_str(&format!(" ?{name} = {}", span(interval)));
    }
    text
}

fn seconds(at: Time) -> String {
    format!("{}s", at as f64 / 1e9)
}
