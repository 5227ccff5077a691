//! Assignment of the passes of a cell to wanted looks, where several looks are wanted.
//!
//! A pass serves one wanted look, or more if the mission permits it. Dynamic programming over the passes in order of time finds the
//! assignment with the greatest sum of values; its state is the set of served looks and the last pass that counts, from which the
//! interval to the next one is measured. So an additional pass never lowers the sum. The interval between two looks is evaluated by the
//! need of the later one or, if that has none, by the need of the earlier one. With a wanted share of coverage below 1, the assignment is
//! made before the best cells are chosen.
//! Bound: at most [`PASSES_MAX`] passes, the best ones, and [`WANTED_LOOKS_MAX`] looks.

use super::by_cell::ByCell;
use super::chance::Scratch;
use super::worth::StripWorth;
use crate::sensor::scanner::ramp_down;
use crate::target::{IntervalNeed, WANTED_LOOKS_MAX};

/// Maximum number of passes that are assigned to one cell; the passes with the least value are left out.
pub(super) const PASSES_MAX: usize = 10;

/// The entries (pass and look) of a cell that serve each wanted look.
pub(super) enum Chosen {
    /// There is a single wanted look, which every entry may serve.
    All,
    /// For each wanted look the passes that serve it, with the factor of their interval.
    Passes(Vec<Vec<(u32, f64)>>),
}

/// Returns the entries of a cell for wanted look `k` among those of its passes, each with the factor of its interval.
pub(super) fn serving<'a>(
    passes: &'a [Vec<(u32, f64)>],
    k: usize,
    entries: &'a [(u32, u32)],
) -> impl Iterator<Item = ((u32, u32), f64)> + 'a {
    entries.iter().filter_map(move |entry| {
        let chosen = passes.get(k)?.iter().find(|(pass, _)| *pass == entry.0)?;
        Some((*entry, chosen.1))
    })
}

/// A pass that sees the cell, with its expected value for each wanted look.
struct PassWorth {
    pass: u32,
    time_s: f64,
    worths: [f64; WANTED_LOOKS_MAX],
}

/// A partial assignment.
#[derive(Clone, Copy)]
struct PartialAssignment {
    served: usize,
    /// The last pass that counts, with the set of wanted looks that it serves.
    last: Option<(usize, usize)>,
    sum: f64,
    /// Pass of each wanted look, and the factor of its interval.
    chosen: [Option<(u32, f64)>; WANTED_LOOKS_MAX],
}

/// Assigns the passes that see a cell to the wanted looks.
pub(super) fn assign(by_cell: &ByCell<'_>, cell: usize, worths: &[StripWorth<'_>], _: &mut Scratch) -> Chosen {
    if worths.len() < 2 {
        return Chosen::All;
    }
    let passes = passes_of(by_cell, cell, worths);
    let mut chosen: Vec<Vec<(u32, f64)>> = worths.iter().map(|_| Vec::new()).collect();
    if passes.is_empty() {
        return Chosen::Passes(chosen);
    }
    let best = best_assignment(&passes, worths);
    let is_used = |pass: u32| best.chosen.iter().flatten().any(|(used, _)| *used == pass);
    for (served, assigned) in chosen.iter_mut().zip(best.chosen) {
        served.extend(assigned);
    }
    // A spare pass backs up the wanted look, among those without an interval need, for which it has the most value; a pass without value
    // shows what an unserved look lacks.
    for pass in passes.iter().filter(|pass| !is_used(pass.pass)) {
        let gain = |k: &usize| {
            let worth = pass.worths.get(*k).copied().unwrap_or(0.0);
            worths
                .get(*k)
                .map_or(0.0, |wanted| if wanted.look.interval.is_some() { 0.0 } else { wanted.look.value * worth })
        };
        let most = (0..worths.len()).max_by(|a, b| gain(a).total_cmp(&gain(b)).then(b.cmp(a)));
        let is_worthless = pass.worths.iter().all(|worth| *worth == 0.0);
        for (k, served) in chosen.iter_mut().enumerate() {
            let is_backup = Some(k) == most && gain(&k) > 0.0;
            let is_shown = is_worthless && best.chosen.get(k).is_none_or(|assigned| assigned.is_none());
            if is_backup || is_shown {
                served.push((pass.pass, 1.0));
            }
        }
    }
    Chosen::Passes(chosen)
}

/// Returns the passes that see a cell in order of time.
fn passes_of(by_cell: &ByCell<'_>, cell: usize, worths: &[StripWorth<'_>]) -> Vec<PassWorth> {
    let mut passes: Vec<PassWorth> = Vec::new();
    for entry in by_cell.of(cell) {
        let Some(look) = by_cell.look(*entry) else { continue };
        let Some(strip) = by_cell.passes.get(entry.0 as usize).and_then(|pass| pass.strip(look)) else { continue };
        if passes.last().is_none_or(|last| last.pass != entry.0) {
            passes.push(PassWorth { pass: entry.0, time_s: strip.time_s, worths: [0.0; WANTED_LOOKS_MAX] });
        }
        let Some(pass) = passes.last_mut() else { continue };
        for (best, worth) in pass.worths.iter_mut().zip(worths) {
            *best = best.max(worth.of(entry.0, look, strip, 1.0).expected());
        }
    }
    if passes.len() > PASSES_MAX {
        let most = |pass: &PassWorth| pass.worths.iter().copied().fold(0.0, f64::max);
        passes.sort_by(|a, b| most(b).total_cmp(&most(a)).then(a.pass.cmp(&b.pass)));
        passes.truncate(PASSES_MAX);
    }
    passes.sort_by(|a, b| a.time_s.total_cmp(&b.time_s).then(a.pass.cmp(&b.pass)));
    passes
}

fn best_assignment(passes: &[PassWorth], worths: &[StripWorth<'_>]) -> PartialAssignment {
    let start = PartialAssignment { served: 0, last: None, sum: 0.0, chosen: [None; WANTED_LOOKS_MAX] };
    let mut states = vec![start];
    for (index, pass) in passes.iter().enumerate() {
        for from in 0..states.len() {
            let Some(state) = states.get(from).copied() else { continue };
            for set in 1..(1_usize << worths.len()) {
                if set & state.served == 0
                    && let Some(next) = extended(&state, set, index, pass, passes, worths)
                {
                    keep_best(&mut states, next);
                }
            }
        }
    }
    states.into_iter().fold(start, |best, state| if state.sum > best.sum { state } else { best })
}

/// Returns the state in which this pass also serves the wanted looks in `set`; `None` if that is not permitted or has no value.
fn extended(
    state: &PartialAssignment,
    set: usize,
    index: usize,
    pass: &PassWorth,
    passes: &[PassWorth],
    worths: &[StripWorth<'_>],
) -> Option<PartialAssignment> {
    let members = || worths.iter().enumerate().filter(|(k, _)| set & (1 << k) != 0);
    if members().filter(|(_, worth)| !worth.look.may_share).count() > 1 {
        return None;
    }
    let before = state.last.and_then(|(last, served)| Some((pass.time_s - passes.get(last)?.time_s, served)));
    let mut next = PartialAssignment { served: state.served | set, last: Some((index, set)), ..*state };
    for (k, worth) in members() {
        let interval = before.map_or(1.0, |(since_s, last)| {
            let in_last = worths.iter().enumerate().filter(|(k, _)| last & (1 << k) != 0);
            let least = |least: f64, need: IntervalNeed| least.min(interval_factor(need, since_s));
            match worth.look.interval {
                Some(need) => interval_factor(need, since_s),
                None => in_last.filter_map(|(_, worth)| worth.look.interval).fold(1.0, least),
            }
        });
        let gain = pass.worths.get(k)? * interval * worth.look.value / worth.look.coverage_share.clamp(1e-9, 1.0);
        if gain.is_nan() || gain <= 0.0 {
            return None;
        }
        next.sum += gain;
        *next.chosen.get_mut(k)? = Some((pass.pass, interval));
    }
    Some(next)
}

fn interval_factor(need: IntervalNeed, since_s: f64) -> f64 {
    ramp_down((need.min_s - since_s).max(since_s - need.max_s), 0.0, need.ramp_s)
}

/// Keeps the best state of each set of served looks and last pass.
fn keep_best(states: &mut Vec<PartialAssignment>, next: PartialAssignment) {
    match states.iter_mut().find(|state| state.served == next.served && state.last == next.last) {
        Some(same) if same.sum < next.sum => *same = next,
        Some(_) => {}
        None => states.push(next),
    }
}
