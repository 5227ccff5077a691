//! Query parameters of the addresses. Times are whole nanoseconds of mission time.

use apex_runtime::record::view::{EventsQuery, SignalQuery, TasksQuery, TimelineQuery, TrackQuery};
use serde::Deserialize;

/// Parameters of `/api/track`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TrackParams {
    from: Option<i64>,
    to: Option<i64>,
    points: Option<usize>,
}

/// Parameters of `/api/tasks`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TasksParams {
    at: Option<i64>,
    /// False leaves out tasks that have ended.
    ended: Option<bool>,
    find: Option<String>,
    with: Option<u64>,
    limit: Option<usize>,
}

/// Parameters of `/api/timeline`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TimelineParams {
    from: Option<i64>,
    to: Option<i64>,
    at: Option<i64>,
    lanes: Option<usize>,
    px: Option<usize>,
    with: Option<u64>,
}

/// Parameters of `/api/events`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct EventsParams {
    from: Option<i64>,
    to: Option<i64>,
    /// Kinds of effects, separated by commas.
    kind: Option<String>,
    task: Option<u64>,
    find: Option<String>,
    limit: Option<usize>,
    /// Only effects with lower numbers.
    before: Option<i64>,
}

/// Parameters of `/api/why`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct WhyParams {
    /// The task's number.
    pub(crate) task: u64,
    pub(crate) at: i64,
    /// False answers from the record's decisions alone, without restoring the instant.
    pub(crate) explain: Option<bool>,
}

/// Parameters of `/api/monitors`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MonitorsParams {
    pub(crate) at: Option<i64>,
    /// Only this task's, with its variables.
    pub(crate) task: Option<u64>,
}

/// Parameters of `/api/program-text`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ProgramTextParams {
    /// The file's name in the record.
    pub(crate) name: String,
}

/// Parameters of the answers about a mission up to one instant, for example `/api/mission`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct AtParams {
    pub(crate) at: Option<i64>,
}

/// Parameters of `/api/footprints`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct WindowParams {
    pub(crate) from: Option<i64>,
    pub(crate) to: Option<i64>,
    pub(crate) at: Option<i64>,
}

/// Parameters of `/api/samples`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SamplesParams {
    /// Names of state variables, separated by commas.
    names: String,
    from: Option<i64>,
    to: Option<i64>,
    at: Option<i64>,
    px: Option<usize>,
}

/// Parameters of `/api/source`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SourceParams {
    pub(crate) place: String,
}

impl From<TrackParams> for TrackQuery {
    fn from(params: TrackParams) -> TrackQuery {
        TrackQuery { from_ns: params.from, to_ns: params.to, points: params.points }
    }
}

impl From<TasksParams> for TasksQuery {
    fn from(params: TasksParams) -> TasksQuery {
        let TasksParams { at, ended, find, with, limit } = params;
        TasksQuery { at_ns: at, alive_only: ended == Some(false), find, with, limit }
    }
}

impl From<TimelineParams> for TimelineQuery {
    fn from(params: TimelineParams) -> TimelineQuery {
        let TimelineParams { from, to, at, lanes, px, with } = params;
        TimelineQuery { from_ns: from, to_ns: to, at_ns: at, lanes, pixels: px, with }
    }
}

impl From<SamplesParams> for SignalQuery {
    fn from(params: SamplesParams) -> SignalQuery {
        let SamplesParams { names, from, to, at, px } = params;
        let names = names.split(',').map(|name| name.trim().to_owned()).filter(|name| !name.is_empty()).collect();
        SignalQuery { names, from_ns: from, to_ns: to, at_ns: at, pixels: px }
    }
}

impl From<EventsParams> for EventsQuery {
    fn from(params: EventsParams) -> EventsQuery {
        let EventsParams { from, to, kind, task, find, limit, before } = params;
        let kinds = kind.filter(|kinds| !kinds.is_empty());
        let kinds = kinds.iter().flat_map(|kinds| kinds.split(',')).map(|kind| kind.trim().to_owned()).collect();
        EventsQuery { from_ns: from, to_ns: to, kinds, task, find, limit, before, searched_max: None }
    }
}
