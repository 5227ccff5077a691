//! The ground that the sensors of a record have seen, computed from its steps.

use crate::answer::{ApiError, ApiResult};
use apex_mission::recorded::mission_of;
use apex_mission::score::{FlownScore, Footprints};
use apex_model::time::Time;
use apex_runtime::record::RecordReader;
use std::sync::{Mutex, PoisonError};

/// The state of the computation over the record's steps. A finished record is processed once.
#[derive(Default)]
pub(crate) struct SeenGround(Mutex<Option<Fold>>);

struct Fold {
    /// `None` if the mission observes nothing, or cannot be loaded.
    flown: Option<FlownScore>,
    last: (i64, Time),
}

impl SeenGround {
    /// Returns the footprints in a window, of the record that `reader` reads as its first agent. One caller at a time extends the
    /// computation; the others wait for its result.
    pub(crate) fn between(&self, reader: &RecordReader, from_ns: i64, to_ns: i64) -> ApiResult<Footprints> {
        let mut slot = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let fold = match slot.take() {
            Some(fold) => fold,
            None => Fold { flown: flown_of(reader)?, last: (0, Time::BEGINNING) },
        };
        let fold = slot.insert(fold);
        fold.advance(reader)?;
        let seen = fold.flown.as_ref().and_then(FlownScore::footprints);
        Ok(seen.map(|seen| seen.between(from_ns, to_ns)).unwrap_or_default())
    }
}

fn flown_of(reader: &RecordReader) -> ApiResult<Option<FlownScore>> {
    let Some(mission) = mission_of(reader)? else { return Ok(None) };
    let flown = FlownScore::new(&mission)
        .map_err(|reason| ApiError::bad_request(reason, "check the targets of the record's mission"))?;
    Ok(flown.map(|flown| flown.only_footprints().as_known_on_board()))
}

impl Fold {
    /// Takes the steps that were recorded since the last time.
    fn advance(&mut self, reader: &RecordReader) -> ApiResult<()> {
        let Some(flown) = &mut self.flown else { return Ok(()) };
        for step in reader.steps_between(self.last.1, Time::END)?.without_effects() {
            let step = step?;
            if step.batch_number > self.last.0 {
                flown.observe(&step.batch);
                self.last = (step.batch_number, step.batch.now);
            }
        }
        Ok(())
    }
}
