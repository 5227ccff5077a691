//! Observations of a flight, computed from the recorded measurements alone: position, attitude and switching of the sensor.
//! `apex fly` folds them while it flies, `apex score` folds them again from the record.

mod arrivals;
mod flown;
mod footprints;
mod samples;
mod so_far;
mod telling;
#[cfg(test)]
mod typescript;
mod value;

pub use crate::predicted::Predicted;
pub use flown::FlownScore;
pub(crate) use flown::told;
pub use footprints::{Footprints, SeenLine, SeenPicture, Swath};
pub use so_far::{ScoreHistory, ScoreSoFar};
pub(crate) use value::flight_score;
pub use value::{Cost, CostKind, FlightScore, ScoredLook};
