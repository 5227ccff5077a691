//! Fast path of runs (M&I)
//! What: extends a run in place in the common case: one known variable, fixed comparisons, still undecided.
//! Runs: before general episode detection, which handles every case that this service declines.
//! Reads: the episode part.
//! Writes: the run of the sample's object.
//! Bound: O(1), no allocation.
//! PDL: `:episode` with `:value` and a least `:duration`.
//! Paper: section IV example 1.

use crate::monitoring::constraints::satisfies_fixed;
use crate::monitoring::episodes::threshold_episode::is_plain;
use crate::monitoring::part::PartContext;
use crate::monitoring::samples::SampleView;
use crate::state::bindings::Bindings;
use crate::state::monitors::monitor::{EpisodePart, Keep, ObjectRun, Run, RunSample};
use apex_model::time::Time;

/// Processes the sample. Returns false if it needs general detection; then nothing has changed.
pub(crate) fn notice(part: &mut EpisodePart, site: PartContext, sample: SampleView<'_>) -> bool {
    let plain = part.settled.is_empty() && site.keep == Keep::First && is_plain(part);
    if !plain || !site.window.contains(sample.at, sample.sequence) {
        return false;
    }
    let Some(holds) = satisfies_fixed(&part.tests, sample.value) else { return false };
    let (gap_max, duration_min) = (part.gap_max, part.duration_min);
    // A known variable has one object.
    let Some(state) = part.runs.values_mut().next().filter(|state| state.newest.at < sample.at) else { return false };
    let ObjectRun { run, newest, found: None, contradicted, .. } = state else { return false };
    let last = run.as_ref().map_or(newest.at, |run| run.last);
    if gap_max.is_some_and(|most| newest.at - last > most || sample.at - newest.at > most) {
        return false;
    }
    match (&newest.holds, &mut *run) {
        (Some(_), Some(run)) if newest.joins && run.start + duration_min >= sample.at => {
            run.last = newest.at;
            run.samples = run.samples.saturating_add(1);
        }
        (Some(_), None) if newest.at + duration_min >= sample.at => {
            *run = Some(Run {
                start: newest.at,
                last: newest.at,
                samples: 1,
                bindings: Bindings::new(),
                first_holds: true,
                last_holds: true,
                instants: Vec::new(),
            });
        }
        (Some(_), _) => return false,
        (None, _) => {
            *run = None;
            *contradicted = true;
        }
    }
    let holds = holds.then(Bindings::new);
    *newest = RunSample { at: sample.at, holds, joins: true, first_holds: true, last_holds: true };
    true
}

/// Returns, for a run without a result at `now`, true if its outcome is unknown and false if it is contradicted; `None` if that needs the
/// full evaluation.
pub(crate) fn undecided(part: &EpisodePart, state: &ObjectRun, now: Time) -> Option<bool> {
    if part.any_pair || part.at_close || state.found.is_some() {
        return None;
    }
    let newest = &state.newest;
    let stale = part.gap_max.is_some_and(|most| now - newest.at > most);
    match (&newest.holds, &state.run) {
        (Some(_), Some(run)) => {
            let whole = newest.joins && part.gap_max.is_none_or(|most| newest.at - run.last <= most);
            let reached = run.start + part.duration_min;
            (whole && reached > newest.at && reached > now).then_some(!state.contradicted || stale)
        }
        (None, None) => Some(stale),
        _ => None,
    }
}
