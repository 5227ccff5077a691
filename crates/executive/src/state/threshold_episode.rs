//! Threshold episodes in episode indexes: their bounds, their runs and their updates.

use crate::state::clause::MonitorId;
use crate::state::monitors::monitor::ObjectRun;
use apex_model::quantity::Dimension;
use apex_model::time::{Duration, Time};
use serde::{Deserialize, Serialize};

/// Identity of an episode: monitor and leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct LeafId {
    /// The monitor.
    pub monitor: MonitorId,
    /// Number of the episode in written order; 0 if it is the only one.
    pub leaf: u32,
}

impl LeafId {
    /// Returns the episode that is all that `monitor` watches.
    pub fn whole(monitor: MonitorId) -> LeafId {
        LeafId { monitor, leaf: 0 }
    }
}

/// Values between two bounds, both included; infinite where there is no bound.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ThresholdBounds {
    /// The least value, in SI.
    pub least: f64,
    /// The greatest value, in SI.
    pub most: f64,
}

/// The fixed properties of a threshold episode in an episode index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThresholdEpisode {
    /// Values that satisfy it.
    pub band: ThresholdBounds,
    /// Their dimension.
    pub dimension: Dimension,
    /// Maximum gap between samples; the greatest duration means that there is no limit.
    pub gap_max: Duration,
    /// Minimum duration of the run.
    pub duration_min: Duration,
    /// Samples before this do not count.
    pub window_start: Time,
    /// Result that was reported while the run is open: only its end is watched for.
    pub open: Option<OpenResult>,
    /// True if it is below a `:not`: samples that contradict it must be reported.
    pub negated: bool,
}

/// A result whose run is open.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OpenResult {
    /// Instant of its recognition.
    pub recognised_at: Time,
    /// The newest sample at that time.
    pub newest: Time,
}

/// Run of an episode in an episode index.
#[derive(Clone, Debug, PartialEq)]
pub struct IndexedRun {
    /// The run in the form of its monitor, without the result.
    pub run: ObjectRun,
    /// Instant at which the result of the run before the newest sample was recognised; `None` if that run has none.
    pub found_at: Option<Time>,
    /// Instant at which the result of the run with the newest sample was recognised; `None` if that run has none.
    pub open_at: Option<Time>,
}

/// Kinds of changes of an episode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// The episode has a result from now on.
    Found,
    /// Its run, which had a result, is over.
    Over,
    /// The newest sample contradicts it, and the preceding one did not or lies before a gap; reported only below a `:not`.
    Contradicted,
}

/// Change of an episode by a sample or by time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EpisodeUpdate {
    /// The episode.
    pub leaf: LeafId,
    /// Kind of change.
    pub what: What,
    /// The run's first sample.
    pub start: Time,
    /// Its last sample so far; the last one of all if the run is over.
    pub last: Time,
    /// Number of samples.
    pub samples: u64,
    /// Instant at which its result was recognised.
    pub recognised_at: Time,
}

/// Episodes that left an episode index, with their state; `None` for one that has received no sample.
pub type Taken = Vec<(LeafId, Option<IndexedRun>)>;
