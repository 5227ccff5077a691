//! One case run by both, and the difference.

use crate::generate::{Case, UNTIL};
use crate::{executive, print};
use apex_reference::{Cut, Run};

/// What came of a case.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// Both did the same.
    Same(Box<Run>),
    /// The checker refused the program.
    Refused(String),
    /// Both did the same as far as the reference follows it; an instant does not come to rest, as both say, or there are
    /// more tasks than the reference follows.
    Cut(Cut),
    /// They differ.
    Different(String),
}

/// Runs both and compares.
pub fn judge(case: &Case) -> Verdict {
    let mut agent = match executive::loaded(&print::program(&case.program)) {
        Ok(agent) => agent,
        Err(messages) => return Verdict::Refused(messages),
    };
    let theirs = apex_reference::run(&case.program, &case.inputs, UNTIL);
    let mut again = agent.clone();
    let ours = executive::run(&mut agent, &case.inputs, UNTIL, false);
    if let Some(difference) = difference(&theirs, &ours) {
        return Verdict::Different(difference);
    }
    if let Some(cut) = theirs.cut {
        return Verdict::Cut(cut);
    }
    // How events are divided into batches must not matter, unless some come late: then it says how late they are.
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

fn difference(theirs: &Run, ours: &Run) -> Option<String> {
    if theirs.cut != Some(Cut::Long) && theirs.cut != ours.cut {
        return Some(format!("who gives up\n  reference: {:?}\n  executive: {:?}\n", theirs.cut, ours.cut));
    }
    let mut text = String::new();
    let mut told = 0;
    let length = match theirs.cut {
        None => theirs.lines.len().max(ours.lines.len()),
        Some(_) => theirs.lines.len(),
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
