//! Constructs in random programs and events in their runs, because a generator that has degenerated finds nothing.

use crate::generate::Case;
use crate::print;
use apex_reference::{Run, What};
use std::collections::BTreeMap;

/// Words of PDL; the programs that contain each are counted.
const CONSTRUCTS: &[&str] = &[
    "(procedure :sequential",
    "(procedure :ranked",
    "(procedure :soft-seq",
    "(resource shared",
    "(resource lanes",
    "(lanes 2)",
    "(resource fuel",
    "(waitfor",
    "(end ?",
    "(state ?",
    "(:and",
    "(:or",
    "(:not",
    "(:in-order",
    "(:delay",
    "(x v ",
    "(select",
    "(forall",
    "(repeating",
    "(responding",
    ":while",
    ":until",
    ":enabled",
    ":with-recovery",
    ":with-min-interval",
    ":for-new",
    "(priority",
    ":urgency",
    "(rank",
    "(interrupt-cost",
    "(expected-duration",
    "(profile",
    "(hold-resource",
    "(release-resource",
    "(end-when",
    "(restart-when",
    "(suspend-when",
    "(resume-when",
    "(skip-when",
    "(exit-when",
    "(precondition",
    "(invariant",
    "(failed ?",
    "(succeeded ?",
    "(skipped ?",
    ":refuse-if-busy",
    ":part-of",
    "(on-start",
    "(on-end",
    "(on-suspend",
    "(on-resume",
    "(on-completion",
    "(on-failure",
    "=> ?",
    "(locals",
    "(update",
    "(return",
    "(complete",
    "(setq",
    "(publish",
    "(terminate ?",
    "failure)",
    "(reset",
    "(suspend ?",
    "(resume ?",
    "(reprioritize",
    "(cogevent",
    "(inform",
    "(print",
    "(end-application)",
];

/// Number of occurrences of each item.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Coverage {
    /// Programs that contain a construct.
    pub constructs: BTreeMap<&'static str, u64>,
    /// Changes of state, by their ends and by the first words of their causes.
    pub moves: BTreeMap<String, u64>,
}

impl Coverage {
    /// Counts a case that both ran alike.
    pub fn add(&mut self, case: &Case, run: &Run) {
        let text = print::program(&case.program);
        for construct in CONSTRUCTS {
            *self.constructs.entry(construct).or_default() += u64::from(text.contains(construct));
        }
        *self.moves.entry("ends before its turn".to_string()).or_default() += run.early_ends;
        for line in &run.lines {
            if let What::Moved(from, to, _, cause) = &line.what {
                *self.moves.entry(format!("{from} -> {to}")).or_default() += 1;
                let numbered = |word: &&str| !word.starts_with('T');
                let words: Vec<&str> = cause.split(' ').take_while(numbered).collect();
                *self.moves.entry(format!("because {}", words.join(" "))).or_default() += 1;
            }
        }
    }

    /// Adds the counts of another thread.
    pub fn join(&mut self, other: &Coverage) {
        for (construct, count) in &other.constructs {
            *self.constructs.entry(construct).or_default() += count;
        }
        for (what, count) in &other.moves {
            *self.moves.entry(what.clone()).or_default() += count;
        }
    }

    /// Returns the table, for operators.
    pub fn text(&self) -> String {
        let constructs = self.constructs.iter().map(|(what, count)| format!("{count:>9} programs with {what}\n"));
        let moves = self.moves.iter().map(|(what, count)| format!("{count:>9} times {what}\n"));
        constructs.chain(moves).collect()
    }
}
