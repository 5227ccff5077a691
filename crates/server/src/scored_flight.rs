//! The mission score if the flight ended at an instant, computed from the steps of the record.

use crate::answer::{ApiError, ApiResult};
use apex_mission::recorded::mission_of;
use apex_mission::score::{ScoreHistory, ScoreSoFar};
use apex_model::time::Time;
use apex_runtime::record::RecordReader;
use std::sync::{Mutex, PoisonError};

/// Number of steps of one turn: between turns, callers get the scores that are known already.
const TURN_STEPS: usize = 200;

/// The state of the computation over the record's steps. A finished record is processed once.
#[derive(Default)]
pub(crate) struct ScoredFlight(Mutex<Option<Fold>>);

struct Fold {
    /// `None` if the mission is not measured by a score, or if the record holds no mission.
    history: Option<ScoreHistory>,
    last: (i64, Time),
}

impl ScoredFlight {
    /// Returns the score at `at`, once the computation has passed that instant. One caller at a time extends it, in turns.
    pub(crate) fn at(&self, reader: &RecordReader, at: Time) -> ApiResult<Option<ScoreSoFar>> {
        loop {
            let mut slot = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            let fold = match slot.take() {
                Some(fold) => fold,
                None => Fold { history: history_of(reader)?, last: (0, Time::BEGINNING) },
            };
            let fold = slot.insert(fold);
            if fold.last.1 > at || !fold.advance(reader)? {
                let end = fold.last.1;
                return Ok(fold.history.as_ref().and_then(|history| history.at(at.min(end))));
            }
        }
    }
}

fn history_of(reader: &RecordReader) -> ApiResult<Option<ScoreHistory>> {
    let Some(mission) = mission_of(reader)? else { return Ok(None) };
    ScoreHistory::new(mission)
        .map_err(|reason| ApiError::bad_request(reason, "check the targets of the record's mission"))
}

impl Fold {
    /// Takes the next steps, at most [`TURN_STEPS`]. Returns true if there may be more.
    fn advance(&mut self, reader: &RecordReader) -> ApiResult<bool> {
        let Some(history) = &mut self.history else { return Ok(false) };
        let mut taken = 0;
        for step in reader.steps_between(self.last.1, Time::END)? {
            let step = step?;
            if step.batch_number > self.last.0 {
                let effects = step
                    .decoded_effects()
                    .map_err(|fault| ApiError::bad_request(fault.to_string(), "check the record with `apex verify`"))?;
                history.observe(0, &step.batch, &effects);
                self.last = (step.batch_number, step.batch.now);
                taken += 1;
                if taken == TURN_STEPS {
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }
}
