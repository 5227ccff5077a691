//! Signals: every recorded state variable over time, with the limits that the mission's PDL watches.
//!
//! An answer for an instant contains the samples that had arrived by then. Its statistics and extremes are those of all samples of the
//! window; only the drawing is thinned, to one bucket per pixel.
//! Bound: the first question reads all steps once; later ones read what was added.

mod limits;
mod sample;
mod store;
mod types;
mod window;

pub(super) use limits::Raised;
pub use limits::{Excursion, SignalLimit};
pub(super) use store::SampleIndex;
pub(super) use types::{PIXELS_DEFAULT, PIXELS_MAX};
pub use types::{SIGNALS_MAX, Signal, SignalKind, SignalQuery, SignalWindow, SignalWindows, Signals, Statistics};
