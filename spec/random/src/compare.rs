//! Runs one case with the executive and with the reference, and describes the difference.

use crate::generate::{Case, UNTIL};
use crate::{executive, print};
use apex_executive::Agent;
use apex_reference::trace::State;
use apex_reference::{Cut, Line, Run, What};

/// If more tasks than this were created at a restless instant and still exist when the reference stops, the comparison leaves that instant
/// out.
const MADE_MAX: usize = 10;

/// Result of a case.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// Both interpreters behaved the same.
    Same(Box<Run>),
    /// The checker refused the program.
    Refused(String),
    /// Both behaved the same as far as the reference runs: up to an instant that does not come to rest, or until there are more tasks
    /// than it handles.
    Cut(Cut),
    /// The interpreters differ.
    Different(String),
}

/// Runs a case with the executive and with the reference, and compares the runs.
pub fn judge(case: &Case) -> Verdict {
    let mut agent = match executive::loaded(&print::program(&case.program)) {
        Ok(agent) => agent,
        Err(messages) => return Verdict::Refused(messages),
    };
    let theirs = apex_reference::run(&case.program, &case.inputs, UNTIL);
    if let Some(cut) = theirs.cut {
        return judge_cut(&mut agent, case, &theirs, cut);
    }
    let mut again = agent.clone();
    let ours = executive::run(&mut agent, &case.inputs, UNTIL, false);
    if let Some(difference) = difference(&theirs, &ours) {
        return Verdict::Different(difference);
    }
    // The division of inputs into batches must not matter, unless some come late, because it then determines how late they are.
    if case.inputs.iter().any(|input| input.at < input.arrives) {
        return Verdict::Same(Box::new(theirs));
    }
    let together = executive::run(&mut again, &case.inputs, UNTIL, true);
    let untimed = |run: &Run| run.lines.iter().map(|line| (line.task, line.what.clone())).collect::<Vec<_>>();
    if untimed(&ours) != untimed(&together) {
        return Verdict::Different("one batch for all gives other decisions than one for each instant".into());
    }
    Verdict::Same(Box::new(theirs))
}

/// Returns the finding for a case in which the reference stopped. At a restless instant the executive must stop, too, but later, and both
/// must behave the same until then. An instant that creates tasks without end is left out, because the executive then searches thousands
/// of tasks for its end.
fn judge_cut(agent: &mut Agent, case: &Case, theirs: &Run, cut: Cut) -> Verdict {
    let last = match cut {
        Cut::Restless(at) => at,
        Cut::Long => theirs.lines.last().map_or(0, |line| line.at),
    };
    let lives = |task: usize| theirs.states.get(&task).is_some_and(|state| *state != State::Terminated);
    let made = |line: &&Line| line.at == last && matches!(line.what, What::Created(..)) && lives(line.task);
    if theirs.lines.iter().filter(made).count() > MADE_MAX {
        let ours = executive::run(agent, &case.inputs, last - 1, false);
        let before = theirs.lines.iter().filter(|line| line.at < last);
        let same = ours.cut.is_none() && before.eq(&ours.lines);
        let difference = || format!("before {last} ns, where the reference stops\n{}", told_last(theirs));
        return if same { Verdict::Cut(cut) } else { Verdict::Different(difference()) };
    }
    let ours = executive::run(agent, &case.inputs, last, false);
    let both = cut == Cut::Long || ours.cut == Some(cut);
    if both && ours.lines.starts_with(&theirs.lines) {
        return Verdict::Cut(cut);
    }
    Verdict::Different(difference(theirs, &ours).unwrap_or_else(|| "the executive reports less".into()))
}

/// Returns the last 40 lines of the run.
fn told_last(run: &Run) -> String {
    run.lines.iter().rev().take(40).rev().map(|line| format!("    {line}\n")).collect()
}

fn difference(theirs: &Run, ours: &Run) -> Option<String> {
    let mut text = String::new();
    let mut told = 0;
    let length = match (theirs.cut, ours.cut) {
        (None, None) => theirs.lines.len().max(ours.lines.len()),
        // A run that stops has reported everything before that; for a restless instant the executive reports more.
        (Some(_), _) => theirs.lines.len(),
        (None, Some(_)) => theirs.lines.len().min(ours.lines.len()),
    };
    let pair = |index: usize| (theirs.lines.get(index), ours.lines.get(index));
    let first = (0..length).find(|index| pair(*index).0 != pair(*index).1);
    if let Some(first) = first {
        for line in theirs.lines.iter().take(first) {
            text.push_str(&format!("    {line}\n"));
        }
        for index in first..length {
            let (reference, executive) = pair(index);
            if reference != executive && told < 8 {
                told += 1;
                let shown = |line: Option<&apex_reference::Line>| line.map_or("nothing".into(), ToString::to_string);
                text.push_str(&format!("  reference: {}\n  executive: {}\n", shown(reference), shown(executive)));
            }
        }
        return Some(text);
    }
    if theirs.cut != Some(Cut::Long) && theirs.cut != ours.cut {
        return Some(format!(
            "which side stops\n  reference: {:?}\n{}  executive: {:?}\n{}",
            theirs.cut,
            told_last(theirs),
            ours.cut,
            told_last(ours)
        ));
    }
    if theirs.cut.is_some() {
        return None;
    }
    if theirs.states != ours.states {
        return Some(format!("states at the end\n  reference: {:?}\n  executive: {:?}\n", theirs.states, ours.states));
    }
    if theirs.holders != ours.holders {
        return Some(format!(
            "holders at the end\n  reference: {:?}\n  executive: {:?}\n",
            theirs.holders, ours.holders
        ));
    }
    let differs = ours.totals.iter().any(|(name, total)| theirs.totals.get(name).is_some_and(|other| other != total));
    differs.then(|| format!("totals\n  reference: {:?}\n  executive: {:?}\n", theirs.totals, ours.totals))
}
