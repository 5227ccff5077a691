//! What a flight has observed, computed from the recorded measurements alone: where the sensor was, how it was held, when
//! it was on. `apex fly` folds them while it flies, `apex score` folds them again from the record.

mod flown;
mod footprints;
mod samples;
mod telling;
mod value;

pub use crate::predicted::Predicted;
pub use flown::FlownScore;
pub(crate) use flown::told;
pub use footprints::{Footprints, SeenLine, SeenPicture, Swath};
pub(crate) use value::flight_score;
pub use value::{Cost, CostKind, FlightScore, ScoredLook};
