//! Makes mistakes, checks, applies fixes, counts.

use super::corpus::{Corpus, Place};
use super::mistake::Mistake;
use super::plan::KINDS;
use super::program::Program;
use super::rng::TestRng;
use apex_pdl::{Applicability, Checked, Diagnostic, Fix, Severity, apply, render};
use std::collections::BTreeMap;

/// Rounds of fixes for one mistake, because a fix may reveal further errors.
const ROUNDS_MAX: usize = 3;

/// Results of some mistakes.
#[derive(Clone, Copy, Default)]
pub struct Tally {
    pub made: usize,
    /// A message names a right line.
    pub placed: usize,
    /// Following the first fix offered, again and again, leaves a program without errors and warnings.
    pub fixed: usize,
    /// .. and the text equals the original, except for blanks.
    pub restored: usize,
    /// Safe fixes alone give a program without messages ..
    pub fixed_safely: usize,
    /// .. that differs from the original.
    pub changed_safely: usize,
    /// More than two messages.
    pub wordy: usize,
}

pub struct Score {
    pub all: Tally,
    pub kinds: BTreeMap<&'static str, Tally>,
    /// Failures, for authors of the checker.
    pub failures: String,
}

/// Makes `count` mistakes from `seed` and scores them.
pub fn score(corpus: &Corpus, seed: u64, count: usize) -> Score {
    let mut score = Score { all: Tally::default(), kinds: BTreeMap::new(), failures: String::new() };
    let mut rng = TestRng::new(seed);
    let programs: Vec<Program<'_>> = corpus.places.iter().map(|place| Program::new(corpus, place)).collect();
    let known: Vec<Vec<String>> = corpus
        .places
        .iter()
        .map(|place| messages(&corpus.check(place, &corpus.texts[&place.file])).collect())
        .collect();
    let weights: Vec<usize> = KINDS.iter().map(|(_, weight, _)| *weight).collect();
    while score.all.made < count {
        let (kind, _, make) = KINDS[rng.weighted(&weights)];
        let Some((at, mistake)) = attempt(&programs, &mut rng, make) else { continue };
        let tally = judge(corpus, &programs[at], &known[at], &mistake, kind, &mut score.failures);
        add(&mut score.all, tally);
        add(score.kinds.entry(kind).or_default(), tally);
    }
    score
}

/// Makes one mistake of a kind; most places are unsuitable, and another one is then tried.
fn attempt(
    programs: &[Program<'_>],
    rng: &mut TestRng,
    make: fn(&Program<'_>, &mut TestRng) -> Option<Mistake>,
) -> Option<(usize, Mistake)> {
    (0..200).find_map(|_| {
        let at = rng.below(programs.len());
        make(&programs[at], rng).map(|mistake| (at, mistake))
    })
}

/// Returns the text of each message with the text of its lines, to distinguish new messages from those of the shipped text: line numbers
/// change, the text does not.
fn messages(checked: &Checked) -> impl Iterator<Item = String> {
    checked.diagnostics.iter().map(|each| {
        let source = checked.library.sources.get(each.span.file as usize);
        let text = source.map_or("", |source| &*source.text);
        let lines: Vec<&str> = text.lines().skip(each.span.line as usize - 1).take(2).collect();
        format!("{} {} {lines:?}", each.code, each.message)
    })
}

fn new_messages(checked: &Checked, known: &[String]) -> Vec<Diagnostic> {
    let texts = messages(checked).zip(&checked.diagnostics);
    texts.filter(|(text, _)| !known.contains(text)).map(|(_, each)| each.clone()).collect()
}

fn judge(
    corpus: &Corpus,
    program: &Program<'_>,
    known: &[String],
    mistake: &Mistake,
    kind: &str,
    failures: &mut String,
) -> Tally {
    let place = program.place;
    let checked = corpus.check(place, &mistake.text);
    let new = new_messages(&checked, known);
    let is_here = |each: &&Diagnostic| {
        let source = checked.library.sources.get(each.span.file as usize);
        let at = source.map(|source| (source.name.to_string(), each.span.line));
        at.is_some_and(|at| (at.0 == place.file && mistake.lines.contains(&at.1)) || mistake.elsewhere.contains(&at))
    };
    let placed = new.iter().any(|each| is_here(&each));
    let any = |fix: &Fix| !fix.edits.is_empty();
    let (fixed, text) = follow(corpus, place, known, &mistake.text, any);
    let is_safe = |fix: &Fix| fix.applicability == Applicability::Safe;
    let (fixed_safely, safe_text) = follow(corpus, place, known, &mistake.text, is_safe);
    let (fixed, fixed_safely) = (fixed && !new.is_empty(), fixed_safely && !new.is_empty());
    let restored = fixed && same(&text, program.text);
    let changed_safely = fixed_safely && !same(&safe_text, program.text);
    let tally = Tally {
        made: 1,
        placed: placed.into(),
        fixed: fixed.into(),
        restored: restored.into(),
        fixed_safely: fixed_safely.into(),
        changed_safely: changed_safely.into(),
        wordy: (new.len() > 2).into(),
    };
    let verdicts =
        [(!placed, "NOT PLACED"), (new.len() > 2, "WORDY"), (!fixed, "NOT FIXED"), (changed_safely, "CHANGED SAFELY")];
    let words: Vec<&str> = verdicts.iter().filter(|(bad, _)| *bad).map(|(_, word)| *word).collect();
    if !words.is_empty() {
        *failures += &format!(
            "== {} | {kind} | {} {:?} | {}\n{}",
            words.join(", "),
            place.file,
            mistake.lines,
            mistake.what,
            render(&new, &checked.library.sources, false)
        );
    }
    tally
}

/// Returns the text after applying, in each round, the first offered fix of this kind, and true if no messages remain.
fn follow(
    corpus: &Corpus,
    place: &Place,
    known: &[String],
    text: &str,
    wanted: impl Fn(&Fix) -> bool,
) -> (bool, String) {
    let mut text = text.to_string();
    for _ in 0..=ROUNDS_MAX {
        let checked = corpus.check(place, &text);
        let new = new_messages(&checked, known);
        let serious: Vec<&Diagnostic> =
            new.iter().filter(|each| each.severity != Severity::Note || each.code == "N0601").collect();
        if serious.is_empty() {
            return (true, text);
        }
        let Some(fix) = serious.iter().find_map(|each| each.fixes.iter().find(|fix| wanted(fix))) else { break };
        let applied = apply(&checked.library.sources, [fix]);
        let own = checked.library.sources.iter().position(|source| *source.name == *place.file);
        match own.and_then(|own| applied.texts.get(&(own as u32))) {
            Some(new) => text.clone_from(new),
            None => break,
        }
    }
    (false, text)
}

/// Equal except for blanks.
fn same(one: &str, other: &str) -> bool {
    one.split_whitespace().eq(other.split_whitespace())
}

fn add(sum: &mut Tally, one: Tally) {
    sum.made += one.made;
    sum.placed += one.placed;
    sum.fixed += one.fixed;
    sum.restored += one.restored;
    sum.fixed_safely += one.fixed_safely;
    sum.changed_safely += one.changed_safely;
    sum.wordy += one.wordy;
}

impl Score {
    /// Returns a table by kind.
    pub fn report(&self) -> String {
        let mut text = format!("{:36} made line fix same safe wrong wordy\n", "");
        let rows = self.kinds.iter().map(|(kind, tally)| (*kind, tally)).chain([("all", &self.all)]);
        for (kind, tally) in rows {
            text += &format!(
                "{kind:36} {:4} {:4} {:3} {:4} {:4} {:5} {:5}\n",
                tally.made,
                tally.placed,
                tally.fixed,
                tally.restored,
                tally.fixed_safely,
                tally.changed_safely,
                tally.wordy
            );
        }
        text
    }
}
