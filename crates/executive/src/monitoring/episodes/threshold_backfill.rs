//! Backfill of threshold episodes (M&I)
//! What: processes remembered samples of a threshold episode with one comparison each, as an episode index does, without general detection.
//! Runs: when the monitor of a threshold episode is created over a past, or a late sample restarts it.
//! Reads: the samples that are remembered.
//! Writes: the episode part.
//! Bound: O(samples).
//! PDL: `:episode` with fixed bounds, `:quality` and a least `:duration`.
//! Paper: section III, histories; section IV example 1.

use crate::expression::EvalContext;
use crate::monitoring::episodes::threshold_episode::{band, give_back, is_plain, told_of};
use crate::monitoring::part::{ConditionFaults, PartContext, remember};
use crate::monitoring::samples::SampleView;
use crate::state::clause::MonitorId;
use crate::state::episode_index::{EpisodeIndex, EpisodeUpdate, LeafId, ThresholdEpisode, What};
use crate::state::monitors::monitor::{EpisodePart, Keep};
use apex_model::time::Duration;

/// The only episode of its index.
const ALONE: LeafId = LeafId { monitor: MonitorId(0), leaf: 0 };

/// Processes `samples` from the first on, up to one that needs general detection. Returns the number processed.
pub(crate) fn backfill(
    part: &mut EpisodePart,
    site: PartContext,
    samples: &[SampleView<'_>],
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) -> usize {
    let fresh = part.runs.is_empty() && part.settled.is_empty();
    if samples.is_empty() || !fresh || !is_plain(part) {
        return 0;
    }
    let Some((band, dimension)) = band(part, context) else { return 0 };
    let wanted = ThresholdEpisode {
        band,
        dimension,
        gap_max: part.gap_max.unwrap_or(Duration::MAX),
        duration_min: part.duration_min,
        window_start: site.window.start,
        open: None,
        negated: false,
    };
    let mut bank = EpisodeIndex::new(dimension);
    bank.insert(ALONE, &wanted, None);
    let (mut told, mut over, mut passed) = (Vec::new(), None, 0);
    for sample in samples {
        if let Some((due, _)) = bank.due().filter(|(due, _)| *due < sample.at) {
            bank.pass_time(due, &mut told);
        }
        // A monitor that needs one result only does not receive later samples.
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
    // The run that the newest sample ended is still stored, with its result.
    let before = part.runs.values().next().and_then(|run| run.found.as_ref()).map(|found| found.interval.0);
    settle(part, site, over.filter(|told| before != Some(told.start)), troubles);
    passed
}

fn settle(part: &mut EpisodePart, site: PartContext, over: Option<EpisodeUpdate>, troubles: &mut ConditionFaults) {
    if let Some(result) = over.and_then(|told| told_of(part, &told)) {
        remember(&mut part.settled, result, site, troubles);
    }
}
