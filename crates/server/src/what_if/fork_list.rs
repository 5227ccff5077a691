//! The forks of a server, with their states.

use crate::flights::Failure;
use apex_runtime::Control;
use serde::Serialize;
use std::path::PathBuf;
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Maximum number of remembered forks.
pub(super) const FORKS_MAX: usize = 20;

/// The forks of a server.
#[derive(Default)]
pub(crate) struct Forks(Mutex<Vec<Arc<ForkFlight>>>);

/// A fork under way, or ended.
pub(super) struct ForkFlight {
    pub(super) id: usize,
    pub(super) at_ns: i64,
    pub(super) with: String,
    pub(super) path: PathBuf,
    pub(super) now_ns: AtomicI64,
    pub(super) controls: Mutex<Sender<Control>>,
    pub(super) end: Mutex<Option<ForkEnd>>,
}

/// End of a fork.
#[derive(Clone)]
pub(super) enum ForkEnd {
    /// The number of its record on the shelf, and both reports side by side.
    Ended(Option<usize>, String),
    Failed(Failure),
}

/// A fork in the form of the API.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct ForkState {
    id: usize,
    at_ns: i64,
    with: String,
    file: String,
    /// `flying`, `ended` or `failed`.
    #[cfg_attr(test, ts(type = "'flying' | 'ended' | 'failed'"))]
    state: &'static str,
    now_ns: i64,
    /// Its number in `/api/records`, once it has ended.
    record: Option<usize>,
    /// Comparison of both reports, in the form of `apex fork`.
    comparison: Option<String>,
    failure: Option<Failure>,
}

impl Forks {
    pub(super) fn list(&self) -> MutexGuard<'_, Vec<Arc<ForkFlight>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Requests all forks to end.
    pub(crate) fn close(&self) {
        self.list().iter().for_each(|flight| flight.stop());
    }
}

impl ForkFlight {
    pub(super) fn end(&self) -> MutexGuard<'_, Option<ForkEnd>> {
        self.end.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn stop(&self) {
        // A fork that has ended does not listen.
        self.controls.lock().unwrap_or_else(PoisonError::into_inner).send(Control::Stop).ok();
    }

    pub(super) fn state(&self) -> ForkState {
        let (state, record, comparison, failure) = match self.end().clone() {
            None => ("flying", None, None, None),
            Some(ForkEnd::Ended(record, text)) => ("ended", record, Some(text), None),
            Some(ForkEnd::Failed(failure)) => ("failed", None, None, Some(failure)),
        };
        ForkState {
            id: self.id,
            at_ns: self.at_ns,
            with: self.with.clone(),
            file: self.path.display().to_string(),
            state,
            now_ns: self.now_ns.load(Ordering::Relaxed),
            record,
            comparison,
            failure,
        }
    }
}
