//! Explanation of a component's health by the tests that give evidence for it.

use super::{mode_names, test_names};
use crate::bits::Bits;
use crate::diagnoser::{Diagnoser, Health};
use crate::doubt::Doubt;
use crate::evidence::Outcome;
use crate::hitting::SearchEnd;
use serde_json::{Value, json};
use std::fmt::Write;

/// Explains the health of each failure mode of a component by tests; `None` if the model has no such component.
pub fn explain(diagnoser: &Diagnoser, component: &str) -> Option<String> {
    let model = diagnoser.model();
    let index = model.component(component)?;
    let found = model.components.get(index)?;
    let health = diagnoser.diagnosis().components.get(index).copied().unwrap_or_default();
    let mut text = format!("{component} ({}) is {health}", found.title);
    for mode in &found.modes {
        let reason = Reasons { diagnoser, mode: *mode }.text();
        let health = diagnoser.diagnosis().modes.get(*mode).copied().unwrap_or_default();
        // Writing to a string cannot fail.
        let _ = match found.modes.len() {
            1 => write!(text, "{reason}"),
            _ => write!(text, "\n{} is {health}{reason}", model.mode_name(*mode)),
        };
    }
    text.push('\n');
    Some(text)
}

/// Returns the facts of [`explain`] as JSON: `component`, `title`, `health`, and for each failure mode: its `name` and `health`; the
/// passed tests that clear it (`cleared_by`); the `failed` tests that give evidence against it, with the other possible causes (`open`)
/// and the excluded ones (`cleared`); the tests `not_run` that would give evidence; the `doubted` tests, which passed `seconds` before
/// another one `failed` that contradicts them; and its `candidates` (`count`, `of`, `share`; null if it is in none). `text` is the
/// explanation as text. `None` if the model has no such component.
pub fn explain_json(diagnoser: &Diagnoser, component: &str) -> Option<Value> {
    let text = explain(diagnoser, component)?;
    let model = diagnoser.model();
    let index = model.component(component)?;
    let found = model.components.get(index)?;
    let health = diagnoser.diagnosis().components.get(index).copied().unwrap_or_default();
    let modes: Vec<Value> = found.modes.iter().map(|mode| Reasons { diagnoser, mode: *mode }.json()).collect();
    Some(json!({
        "component": component,
        "title": found.title,
        "health": health.word(),
        "failure_modes": modes,
        "text": text,
    }))
}

/// Returns the age of a doubted pass, s, to a tenth.
fn seconds(doubt: &Doubt) -> f64 {
    libm::round(doubt.age_ns as f64 / 1e8) / 10.0
}

struct Reasons<'a> {
    diagnoser: &'a Diagnoser,
    mode: usize,
}

impl Reasons<'_> {
    fn text(&self) -> String {
        let health = self.diagnoser.diagnosis().modes.get(self.mode).copied().unwrap_or_default();
        match health {
            Health::Good => format!(" because tests passed that it alone would have made fail: {}", self.clearing()),
            Health::Bad | Health::Suspect => format!("{}{}", self.accused(health), self.doubted()),
            Health::Unknown => format!("{}{}", self.unknown(), self.doubted()),
        }
    }

    /// Returns a line for each doubted test that depends on this failure mode.
    fn doubted(&self) -> String {
        let model = self.diagnoser.model();
        let line = |doubt: &Doubt| {
            let (test, failed) = (model.test_name(doubt.test), model.test_name(doubt.failed));
            format!(
                "\n  {test} is doubted: it passed {} s before {failed} failed, which contradicts it",
                seconds(doubt)
            )
        };
        self.doubts().map(line).collect()
    }

    fn json(&self) -> Value {
        let model = self.diagnoser.model();
        let diagnosis = self.diagnoser.diagnosis();
        let good = |mode: &usize| diagnosis.modes.get(*mode) == Some(&Health::Good);
        let modes = |modes: Vec<usize>| modes.iter().map(|mode| model.mode_name(*mode)).collect::<Vec<_>>();
        let tests = |tests: Vec<usize>| tests.iter().map(|test| model.test_name(*test)).collect::<Vec<_>>();
        let mut failed = Vec::new();
        for test in self.tests(Outcome::is_failure, |_| true) {
            let clauses = model.tests.get(test).map_or(&[][..], |test| test.clauses());
            for clause in clauses.iter().filter(|clause| clause.contains(self.mode)) {
                let others = || clause.iter().filter(|mode| *mode != self.mode);
                failed.push(json!({
                    "test": model.test_name(test),
                    "open": modes(others().filter(|mode| !good(mode)).collect()),
                    "cleared": modes(others().filter(good).collect()),
                }));
            }
        }
        let doubted = |doubt: &Doubt| {
            json!({
                "test": model.test_name(doubt.test),
                "failed": model.test_name(doubt.failed),
                "seconds": seconds(doubt),
            })
        };
        let group =
            diagnosis.groups.iter().find(|group| group.candidates.iter().any(|one| one.modes.contains(self.mode)));
        let candidates = group.map(|group| {
            let with = || group.candidates.iter().filter(|one| one.modes.contains(self.mode));
            let share: f64 = with().map(|one| one.share).sum();
            json!({ "count": with().count(), "of": group.candidates.len(), "share": share })
        });
        json!({
            "name": model.mode_name(self.mode),
            "health": diagnosis.modes.get(self.mode).copied().unwrap_or_default().word(),
            "cleared_by": tests(self.tests(|outcome| outcome == Outcome::Passed, |test| self.alone(test))),
            "failed": failed,
            "not_run": tests(self.tests(|outcome| outcome == Outcome::Unknown, |test| self.concerns(test) && !self.is_doubted(test))),
            "doubted": self.doubts().map(doubted).collect::<Vec<_>>(),
            "candidates": candidates,
        })
    }

    /// Returns the doubts of tests that depend on this failure mode.
    fn doubts(&self) -> impl Iterator<Item = &Doubt> {
        self.diagnoser.diagnosis().doubts.iter().filter(|doubt| self.concerns(doubt.test))
    }

    fn is_doubted(&self, test: usize) -> bool {
        self.diagnoser.diagnosis().doubts.iter().any(|doubt| doubt.test == test)
    }

    /// Returns true if the test depends on this failure mode.
    fn concerns(&self, test: usize) -> bool {
        let implicants = self.diagnoser.model().tests.get(test).map_or(&[][..], |test| test.implicants());
        implicants.iter().any(|implicant| implicant.contains(self.mode))
    }

    fn tests(&self, wanted: impl Fn(Outcome) -> bool, accuses: impl Fn(usize) -> bool) -> Vec<usize> {
        let outcomes = self.diagnoser.outcomes().iter().enumerate();
        outcomes.filter(|(test, outcome)| wanted(**outcome) && accuses(*test)).map(|(test, _)| test).collect()
    }

    fn alone(&self, test: usize) -> bool {
        let implicants = self.diagnoser.model().tests.get(test).map_or(&[][..], |test| test.implicants());
        implicants.iter().any(|implicant| implicant.len() == 1 && implicant.contains(self.mode))
    }

    fn clearing(&self) -> String {
        let tests = self.tests(|outcome| outcome == Outcome::Passed, |test| self.alone(test));
        test_names(self.diagnoser.model(), tests.into_iter())
    }

    /// Returns the failed tests that give evidence against the mode, each with the tests that clear every other possible cause.
    fn accused(&self, health: Health) -> String {
        let model = self.diagnoser.model();
        let diagnosis = self.diagnoser.diagnosis();
        let good = |mode: &usize| diagnosis.modes.get(*mode) == Some(&Health::Good);
        let mut text = String::new();
        for test in self.tests(Outcome::is_failure, |_| true) {
            let clauses = model.tests.get(test).map_or(&[][..], |test| test.clauses());
            for clause in clauses.iter().filter(|clause| clause.contains(self.mode)) {
                let others = || clause.iter().filter(|mode| *mode != self.mode);
                let cleared: Vec<usize> = others().filter(good).collect();
                let open: Vec<usize> = others().filter(|mode| !good(mode)).collect();
                let _ = write!(text, "\n  {} failed", model.test_name(test));
                if !open.is_empty() {
                    let _ = write!(text, "; {} could be the reason, too", mode_names(model, open.into_iter()));
                }
                if !cleared.is_empty() {
                    let by = test_names(model, self.tests_that_clear(&cleared).iter());
                    let _ = write!(text, "; {} cleared by {by}", mode_names(model, cleared.into_iter()));
                }
            }
        }
        let group = diagnosis
            .groups
            .iter()
            .find(|group| group.candidates.iter().any(|candidate| candidate.modes.contains(self.mode)));
        let limited = diagnosis.groups.iter().any(|group| group.end == SearchEnd::NodeLimit);
        let head = match (health, group) {
            (Health::Bad, _) => " because every candidate contains it".to_string(),
            (_, Some(group)) => {
                let with = group.candidates.iter().filter(|candidate| candidate.modes.contains(self.mode));
                let (count, share) = with.fold((0, 0.0), |(count, share), one| (count + 1, share + one.share));
                let all = group.candidates.len();
                let more = if group.end == SearchEnd::All { "" } else { " found" };
                format!(
                    " because it is in {count} of {all} candidates{more}, {:.1} % of their prior odds",
                    100.0 * share
                )
            }
            (_, None) if limited => " because it may be in a candidate; the search ended at its limit".to_string(),
            (_, None) => " because it may be in a candidate that is less likely than those kept".to_string(),
        };
        format!("{head}{text}")
    }

    /// Returns passed tests that clear these failure modes: for each mode, the first such test.
    fn tests_that_clear(&self, modes: &[usize]) -> Bits {
        let first = |mode: &usize| {
            let one = Reasons { diagnoser: self.diagnoser, mode: *mode };
            one.tests(|outcome| outcome == Outcome::Passed, |test| one.alone(test)).first().copied()
        };
        Bits::of(self.diagnoser.model().tests.len(), modes.iter().filter_map(first))
    }

    fn unknown(&self) -> String {
        let names = |tests: Vec<usize>| test_names(self.diagnoser.model(), tests.into_iter());
        let concerned = |test: usize| self.concerns(test);
        let failed = self.tests(Outcome::is_failure, concerned);
        let open = self.tests(|outcome| outcome == Outcome::Unknown, |test| concerned(test) && !self.is_doubted(test));
        if (0..self.diagnoser.model().tests.len()).all(|test| !concerned(test)) {
            return " because no test depends on it".to_string();
        }
        let mut text = " because no passed test clears it".to_string();
        if !failed.is_empty() {
            let _ = write!(text, " and others explain what it could: {}", names(failed));
        }
        if !open.is_empty() {
            let _ = write!(text, "; not run: {}", names(open));
        }
        text
    }
}
