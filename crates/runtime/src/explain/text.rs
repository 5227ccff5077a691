//! Explanations as text. All text is taken from members of the answer, so that text and JSON agree.

use super::answer::{Answer, Blocked, CommandAnswer, Holder, ResourceAnswer, Subtask, Unmet, Why, WhyNot};
use super::{Link, Moment};
use apex_model::time::Time;
use std::fmt;

/// Maximum number of moments that a text shows; a step that repeats for hours has more than a reader needs.
const MOMENTS_MAX: usize = 40;
/// Number of the first moments shown when the history is shortened.
const MOMENTS_FIRST: usize = 8;

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Answer::Task(why) => fmt::Display::fmt(why, f),
            Answer::Resource(answer) => fmt::Display::fmt(answer, f),
            Answer::Command(answer) => fmt::Display::fmt(answer, f),
        }
    }
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let at = Time::from_seconds(self.about.t);
        writeln!(f, "{} {} is {} at {at}.", self.task, self.goal, self.state)?;
        if let Some(place) = &self.place {
            writeln!(f, "It is the step `{}` at {place}.", self.tag)?;
        }
        if let Some(method) = &self.method {
            writeln!(f, "Its method: {method}.")?;
        }
        if !self.holds.is_empty() {
            writeln!(f, "It holds {}.", self.holds.join(", "))?;
        }
        write_chain(f, self.because.as_ref())?;
        write_choices(self, f)?;
        write_history(&self.history, f)?;
        write_waiting(self, f)?;
        if !self.subtasks.is_empty() {
            writeln!(f, "\nIts subtasks:")?;
            self.subtasks
                .iter()
                .try_for_each(|Subtask { task, goal, state }| writeln!(f, "  {task} {goal}: {state}"))?;
        }
        Ok(())
    }
}

fn write_chain(f: &mut fmt::Formatter<'_>, because: Option<&Link>) -> fmt::Result {
    let Some(link) = because else { return Ok(()) };
    writeln!(f, "\nWhy:")?;
    link.write(f, 2, None)?;
    if link.is_cut() {
        writeln!(f, "  (`--depth` shows more of this)")?;
    }
    Ok(())
}

/// Writes the choice of a method, if a method was chosen.
fn write_choices(why: &Why, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    if why.choices.len() < 2 && why.choices.iter().all(|choice| choice.matches) {
        return Ok(());
    }
    writeln!(f, "\nWhat could pursue {}:", why.goal)?;
    for choice in &why.choices {
        let word = if choice.matches { "matches" } else { "does not match" };
        writeln!(f, "  {} {} {word}: {}", choice.method, choice.index, choice.because)?;
    }
    Ok(())
}

fn write_history(history: &[Moment], f: &mut fmt::Formatter<'_>) -> fmt::Result {
    writeln!(f, "\nWhat happened to it:")?;
    let (first, last) = match history.len() {
        few if few <= MOMENTS_MAX => (history, [].as_slice()),
        many => {
            let (first, rest) = history.split_at(MOMENTS_FIRST);
            (first, rest.get(many - MOMENTS_MAX..).unwrap_or_default())
        }
    };
    first.iter().try_for_each(|moment| writeln!(f, "{moment}"))?;
    let left_out = history.len() - first.len() - last.len();
    if left_out > 0 {
        writeln!(f, "  (and {left_out} more, which `--json` shows)")?;
    }
    last.iter().try_for_each(|moment| writeln!(f, "{moment}"))
}

fn write_waiting(why: &Why, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    if !why.waiting.is_empty() {
        writeln!(f, "\nWhat it waits for:")?;
        why.waiting.iter().try_for_each(|unmet| writeln!(f, "  {unmet}"))?;
    }
    if let Some(Blocked { by, goal, resource, since, strengths, .. }) = &why.blocked {
        let since = Time::from_seconds(*since);
        writeln!(f, "\nIt lost the conflict over {resource} to {by} {goal} at {since} ({strengths}).")?;
    }
    Ok(())
}

impl fmt::Display for Unmet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)?;
        if !self.now.is_empty() {
            write!(f, ": {}", self.now)?;
        }
        if let Some(since) = self.since {
            write!(f, ", since {}", Time::from_seconds(since))?;
        }
        match &self.place {
            Some(place) => write!(f, "; from {place}"),
            None => Ok(()),
        }
    }
}

impl fmt::Display for ResourceAnswer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let at = Time::from_seconds(self.about.t);
        match self.holders.as_slice() {
            [] => writeln!(f, "{} ({} of it) is held by no task at {at}.", self.resource, self.total)?,
            [one] => writeln!(f, "{} is held by {} {} at {at}.", self.resource, one.task, one.goal)?,
            some => {
                let names: Vec<String> = some.iter().map(|each| format!("{} {}", each.task, each.goal)).collect();
                writeln!(f, "{} is held by {} at {at}.", self.resource, names.join(" and "))?;
            }
        }
        write_holders(f, "Tasks that hold it", &self.holders)?;
        write_holders(f, "Tasks that wait for it", &self.waiting)
    }
}

fn write_holders(f: &mut fmt::Formatter<'_>, title: &str, holders: &[Holder]) -> fmt::Result {
    if holders.is_empty() {
        return Ok(());
    }
    writeln!(f, "\n{title}:")?;
    for Holder { task, goal, amount, priority, interrupt_cost, because, waits_for } in holders {
        let amount = amount.as_ref().map(|amount| format!(" {amount},")).unwrap_or_default();
        writeln!(f, "  {task} {goal}:{amount} priority {priority}, interrupt cost {interrupt_cost}")?;
        if let Some(link) = because {
            link.write(f, 4, None)?;
        }
        waits_for.iter().try_for_each(|unmet| writeln!(f, "    now it waits for {unmet}"))?;
    }
    Ok(())
}

impl fmt::Display for CommandAnswer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.form)?;
        write_chain(f, Some(&self.because))
    }
}

impl fmt::Display for WhyNot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.answer)?;
        if !self.target.is_empty() {
            writeln!(f, "\nOutcome:")?;
            for moment in &self.target {
                let line =
                    format!("  {:>12}  {} {}", Time::from_seconds(moment.t).to_string(), moment.state, moment.detail);
                writeln!(f, "{}", line.trim_end())?;
            }
        }
        if !self.missing.is_empty() {
            writeln!(f, "\nWhere it would come from:")?;
        }
        for (depth, missing) in self.missing.iter().enumerate() {
            let indent = 2 + 2 * depth;
            let source = missing.source.as_ref().map(|source| format!(" `{source}`")).unwrap_or_default();
            writeln!(f, "{:indent$}step `{}` at {}{source}: {}", "", missing.step, missing.place, missing.because)?;
        }
        if let Some(task) = &self.task {
            write_chain(f, task.because.as_ref())?;
            write_choices(task, f)?;
            write_waiting(task, f)?;
        }
        if !self.others.is_empty() {
            writeln!(f, "\nOthers that this may mean: {}.", self.others.join(", "))?;
        }
        Ok(())
    }
}
