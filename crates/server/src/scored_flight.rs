//! The mission score if the flight ended at an instant, computed from the steps of the record.

use crate::answer::{ApiError, ApiResult};
use apex_mission::recorded::mission_of;
use apex_mission::score::{ScoreHistory, ScoreSoFar};
use apex_model::time::Time;
use apex_runtime::record::RecordReader;
use std::sync::{Mutex, PoisonError};

/// The state of the computation over the record's steps. A finished record is processed once.
#[derive(Default)]
pub(crate) struct ScoredFlight(Mutex<Option<Fold>>);

struct Fold {
    /// `None` if the mission is not measured by a score, or if the record holds no mission.
    history: Option<ScoreHistory>,
    last: (i64, Time),
}

impl ScoredFlight {
    /// Returns the score at `at`. Only one caller at a time extends the computation; the others wait for its result.
    pub(crate) fn at(&self, reader: &RecordReader, at: Time) -> ApiResult<Option<ScoreSoFar>> {
        let mut slot = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let fold = match slot.take() {
            Some(fold) => fold,
            None => Fold { history: history_of(reader)?, last: (0, Time::BEGINNING) },
        };
        let fold = slot.insert(fold);
        fold.advance(reader)?;
        let end = fold.last.1;
        Ok(fold.history.as_ref().and_then(|history| history.at(at.min(end))))
    }
}

fn history_of(reader: &RecordReader) -> ApiResult<Option<ScoreHistory>> {
    let Some(mission) = mission_of(reader)? else { return Ok(None) };
    ScoreHistory::new(mission)
        .map_err(|reason| ApiError::bad_request(reason, "check the targets of the record's mission"))
}

impl Fold {
    /// Takes the steps that were recorded since the last time.
    fn advance(&mut self, reader: &RecordReader) -> ApiResult<()> {
        let Some(history) = &mut self.history else { return Ok(()) };
        for step in reader.steps_between(self.last.1, Time::END)? {
            let step = step?;
            if step.batch_number > self.last.0 {
                let effects = step
                    .decoded_effects()
                    .map_err(|fault| ApiError::bad_request(fault.to_string(), "check the record with `apex verify`"))?;
                history.observe(0, &step.batch, &effects);
                self.last = (step.batch_number, step.batch.now);
            }
        }
        Ok(())
    }
}
