//! Looking back for plain episodes (M&I)
//! What: takes remembered samples in as a bank does, a comparison each, instead of one by one in the general way.
//! Runs: when the monitor of a plain episode is made over a past, or a late sample makes it begin again.
//! Reads: the samples that are remembered.
//! Writes: the episode part.
//! Bound: O(samples).
//! PDL: `:episode` with fixed bounds, `:quality` and a least `:duration`.
//! Paper: section III, histories; section IV example 1.

use crate::expression::Surroundings;
use crate::monitoring::episodes::plain_episode::{band, give_back, is_plain, told_of};
use crate::monitoring::part::{Site, Troubles, remember};
use crate::monitoring::samples::Seen;
use crate::state::clause::MonitorId;
use crate::state::episode_bank::{EpisodeBank, LeafId, PlainEpisode, Told, What};
use crate::state::monitors::monitor::{EpisodePart, Keep};
use apex_model::time::Duration;

/// The only episode of its bank.
const ALONE: LeafId = LeafId { monitor: MonitorId(0), leaf: 0 };

/// Takes in `samples` from the first on, up to one that must go the general way; how many these were.
pub(crate) fn look_back(
    part: &mut EpisodePart,
    site: Site,
    samples: &[Seen<'_>],
    surroundings: &dyn Surroundings,
    troubles: &mut Troubles,
) -> usize {
    let fresh = part.runs.is_empty() && part.settled.is_empty();
    if samples.is_empty() || !fresh || !is_plain(part) {
        return 0;
    }
    let Some((band, dimension)) = band(part, surroundings) else { return 0 };
    let wanted = PlainEpisode {
        band,
        dimension,
        gap_max: part.gap_max.unwrap_or(Duration::MAX),
        duration_min: part.duration_min,
        window_start: site.window.start,
        open: None,
        negated: false,
    };
    let mut bank = EpisodeBank::new(dimension);
    bank.insert(ALONE, &wanted, None);
    let (mut told, mut over, mut passed) = (Vec::new(), None, 0);
    for sample in samples {
        if let Some((due, _)) = bank.due().filter(|(due, _)| *due < sample.at) {
            bank.pass_time(due, &mut told);
        }
        // Whoever wants one result only is not told of what comes after it.
        if site.keep == Keep::First && !told.is_empty() {
            break;
        }
        told.clear();
        let Some(number) = bank.takes(sample.at, sample.value) else { break };
        bank.sample(sample.at, number, &mut told);
        passed += 1;
        if let Some(ended) = told.iter().find(|told| told.what == What::Over) {
            settle(part, site, over.replace(*ended), troubles);
        }
    }
    give_back(part, bank.take(ALONE).flatten());
    // The run that the newest sample ended is still there, with its result.
    let before = part.runs.values().next().and_then(|run| run.found.as_ref()).map(|found| found.interval.0);
    settle(part, site, over.filter(|told| before != Some(told.start)), troubles);
    passed
}

fn settle(part: &mut EpisodePart, site: Site, over: Option<Told>, troubles: &mut Troubles) {
    if let Some(result) = over.and_then(|told| told_of(part, &told)) {
        remember(&mut part.settled, result, site, troubles);
    }
}
