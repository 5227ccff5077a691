//! Observations of a flight, computed only from the recorded measurements: position, attitude and switching of the sensor. `apex fly`
//! computes them during the flight, `apex score` again from the record.

mod arrivals;
mod deferred;
mod flown;
mod footprints;
mod growth;
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
pub use value::{Cost, CostKind, FlightScore, ScoredLook};
pub(crate) use value::{flight_score, is_complete};
