//! The best look of a cell, and the expected best of predicted looks.
//!
//! Looks are sorted by value; look l counts with the probability that it is valid and no better one is: `E[best] = sum_l q_l P(l valid,
//! all better ones not)`. Turbulence is independent between looks. Cloud has one random state per hour, counted from the first look that it
//! may hide, so that looks that are all later by the same time have the same value: of two looks in the same hour, the one with the
//! smaller probability of a clear line is clear only if the other is. A flown look is certain, so only the best of them counts.

use super::by_cell::ByCell;
use super::worth::{CAUSES, LookWorth, StripWorth, add};
use crate::result::LossCause;

/// Sums of one cell for one wanted look.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CellWorth {
    pub(super) is_seen: bool,
    /// Expected clarity of the look that counts; 0 if none does.
    pub(super) s: f64,
    /// Expected clarity times resolution.
    pub(super) sr: f64,
    /// Expected clarity times resolution times timing.
    pub(super) sro: f64,
    /// The look with the greatest value.
    pub(super) best: Option<(u32, u32)>,
}

/// A look that may count.
#[derive(Clone, Copy, Debug)]
struct LookCandidate {
    entry: (u32, u32),
    interval: f64,
    worth: LookWorth,
    time_s: f64,
    hour: i64,
    /// Probability that this look counts.
    used: f64,
}

/// Memory that is used again for every cell.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    candidates: Vec<LookCandidate>,
}

/// Returns the sums of one cell over the looks in `entries`, each multiplied by the factor of its interval.
pub(super) fn outcome(
    by_cell: &ByCell<'_>,
    worth: &StripWorth<'_>,
    entries: impl Iterator<Item = ((u32, u32), f64)>,
    scratch: &mut Scratch,
) -> CellWorth {
    let candidates = &mut scratch.candidates;
    candidates.clear();
    let mut found = entries.filter_map(|(entry, interval)| {
        let look = by_cell.look(entry)?;
        let strip = by_cell.passes.get(entry.0 as usize)?.strip(look)?;
        let (time_s, worth) = (strip.time_s, worth.of(entry.0, look, strip, interval));
        Some(LookCandidate { entry, interval, worth, time_s, hour: 0, used: 0.0 })
    });
    let Some(first) = found.next() else { return CellWorth::default() };
    let Some(second) = found.next() else {
        let (only, sum) = alone(first);
        candidates.push(only);
        return sum;
    };
    candidates.extend([first, second]);
    candidates.extend(found);
    candidates.sort_by(|a, b| {
        let chance = |c: &LookCandidate| c.worth.valid * c.worth.clear;
        let by_worth = b.worth.sro.total_cmp(&a.worth.sro);
        let by_resolution = (chance(b) * b.worth.sr).total_cmp(&(chance(a) * a.worth.sr));
        by_worth.then(by_resolution).then((chance(b) * b.worth.s).total_cmp(&(chance(a) * a.worth.s)))
    });
    share_out(candidates);
    let mut sum =
        CellWorth { is_seen: true, best: candidates.first().map(|first| first.entry), ..CellWorth::default() };
    for candidate in candidates.iter() {
        sum.s += candidate.used * candidate.worth.s;
        sum.sr += candidate.used * candidate.worth.sr;
        sum.sro += candidate.used * candidate.worth.sro;
    }
    sum
}

/// Returns the only look of a cell, which counts if it is valid and clear, and the sums of the cell: most cells are seen once.
fn alone(look: LookCandidate) -> (LookCandidate, CellWorth) {
    let LookWorth { valid, clear, s, sr, sro } = look.worth;
    let used = if clear >= 1.0 { valid } else { clear * valid };
    let sum = CellWorth { is_seen: true, s: used * s, sr: used * sr, sro: used * sro, best: Some(look.entry) };
    (LookCandidate { used, ..look }, sum)
}

/// Computes the probability with which each candidate counts; candidates are sorted, best first.
fn share_out(candidates: &mut [LookCandidate]) {
    let is_plain = candidates.iter().all(|candidate| candidate.worth.clear >= 1.0);
    if !is_plain {
        let hidden_s = candidates.iter().filter(|look| look.worth.clear < 1.0).map(|look| look.time_s);
        let first_s = hidden_s.fold(f64::INFINITY, f64::min);
        candidates.iter_mut().for_each(|look| look.hour = libm::floor((look.time_s - first_s) / 3_600.0) as i64);
    }
    let mut left = 1.0;
    for index in 0..candidates.len() {
        let (better, rest) = candidates.split_at_mut(index);
        let Some(candidate) = rest.first_mut() else { return };
        let LookWorth { valid, clear, .. } = candidate.worth;
        if is_plain {
            candidate.used = left * valid;
            left -= candidate.used;
            continue;
        }
        // Better looks of the same hour, given that this line of sight is clear.
        let same = better.iter().filter(|other| other.hour == candidate.hour);
        let same_invalid = same.fold(1.0, |product, other| product * (1.0 - given_clear(other, clear)));
        candidate.used = clear * valid * same_invalid * other_hours_invalid(better, candidate.hour);
    }
}

/// Returns the probability that `other` is valid and clear, given that a line of sight of the same hour whose probability is `clear` is
/// clear.
fn given_clear(other: &LookCandidate, clear: f64) -> f64 {
    let share = if clear > 0.0 { (other.worth.clear / clear).min(1.0) } else { 1.0 };
    other.worth.valid * share
}

/// Returns the probability that no look of `better` in another hour than `hour` is valid and clear.
fn other_hours_invalid(better: &[LookCandidate], hour: i64) -> f64 {
    let mut product = 1.0;
    for (index, first) in better.iter().enumerate() {
        let is_new = better.iter().take(index).all(|earlier| earlier.hour != first.hour);
        if first.hour == hour || !is_new {
            continue;
        }
        // The first valid look of that hour, in the same order.
        let mut any = 0.0;
        for (position, look) in better.iter().enumerate().skip(index).filter(|(_, look)| look.hour == first.hour) {
            let earlier = better.iter().take(position).filter(|earlier| earlier.hour == first.hour);
            let invalid =
                earlier.fold(1.0, |product, earlier| product * (1.0 - given_clear(earlier, look.worth.clear)));
            any += look.worth.clear * look.worth.valid * invalid;
        }
        product *= (1.0 - any).max(0.0);
    }
    product
}

/// Adds the losses of the cell of the last [`outcome`] by cause; together with its value they sum to 1.
pub(super) fn losses(
    by_cell: &ByCell<'_>,
    worth: &StripWorth<'_>,
    outcome: &CellWorth,
    scratch: &Scratch,
) -> [f64; CAUSES] {
    let mut losses = [0.0; CAUSES];
    if !outcome.is_seen {
        add(&mut losses, LossCause::NotSeen, 1.0);
        return losses;
    }
    let mut missed = 1.0;
    for candidate in scratch.candidates.iter().filter(|candidate| candidate.used > 0.0) {
        missed -= candidate.used;
        let Some(look) = by_cell.look(candidate.entry) else { continue };
        let Some(strip) = by_cell.passes.get(candidate.entry.0 as usize).and_then(|pass| pass.strip(look)) else {
            continue;
        };
        worth.add_losses(candidate.entry.0, look, strip, (candidate.used, candidate.interval), &mut losses);
    }
    let best = scratch.candidates.first().and_then(|candidate| {
        let look = by_cell.look(candidate.entry)?;
        Some((look, by_cell.passes.get(candidate.entry.0 as usize)?.strip(look)?))
    });
    if missed > 0.0
        && let Some((look, strip)) = best
    {
        worth.add_missed(look, strip, missed, &mut losses);
    }
    losses
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_that_are_all_later_count_as_much() {
        let at = |time_s: f64, clear: f64| LookCandidate {
            entry: (0, 0),
            interval: 1.0,
            worth: LookWorth { valid: 0.9, clear, s: 1.0, sr: 1.0, sro: 1.0 },
            time_s,
            hour: 0,
            used: 0.0,
        };
        let shares = |first_s: f64, apart_s: f64| {
            let mut looks = [at(first_s, 0.6), at(first_s + apart_s, 0.5)];
            share_out(&mut looks);
            looks.map(|look| look.used)
        };
        // A minute apart, inside of an hour of the mission and on both sides of one.
        assert_eq!(shares(100.0, 60.0), shares(3_590.0, 60.0));
        // Of the looks in one state of the cloud the second helps less than in another state.
        assert!(shares(0.0, 60.0)[1] < shares(0.0, 4_000.0)[1]);
    }

    #[test]
    fn a_look_alone_counts_as_it_does_among_looks() {
        let shares = [0.0, 0.1, 0.37, 0.999, 1.0];
        for (valid, clear, s) in shares.iter().flat_map(|v| shares.map(|c| shares.map(|s| (*v, c, s)))).flatten() {
            let worth = LookWorth { valid, clear, s, sr: 0.7 * s, sro: 0.7 * 0.3 * s };
            let look = LookCandidate { entry: (3, 4), interval: 0.5, worth, time_s: 7_300.0, hour: 0, used: 0.0 };
            let mut all = [look];
            share_out(&mut all);
            let (only, sum) = alone(look);
            let used = all[0].used;
            let bits = |values: [f64; 4]| values.map(f64::to_bits);
            let sums = [used, 0.0 + used * s, 0.0 + used * worth.sr, 0.0 + used * worth.sro];
            assert_eq!(bits([only.used, sum.s, sum.sr, sum.sro]), bits(sums), "{worth:?}");
            assert_eq!((sum.is_seen, sum.best), (true, Some((3, 4))));
        }
    }
}
