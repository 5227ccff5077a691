//! Speeds of manoeuvres as predicted: short lines of a large aircraft begin at their speed.

use super::cases::{Case, STILL, WIND, all};
use apex_observation::manoeuvres::PayloadUse;

/// The line was reached at 95 m/s and was over before the aircraft was slow: pictures that should have been sharp were smeared.
#[test]
fn a_large_fixed_wing_begins_a_short_line_at_the_speed_of_the_line() {
    let line = Case {
        model: "predator-b",
        form: ("straight-over", &[("track", 60.0), ("height", 300.0), ("length", 60.0)]),
        speed_mps: Some(52.0),
        payload: PayloadUse::StillsEvery(17.0),
        up_m: 1_000.0,
        away_m: 15_000.0,
        half_m: 20.0,
        compares_clarity: true,
        ..Case::default()
    };
    all(std::iter::once(line.clone()), STILL, 0.05);
    all(std::iter::once(line), WIND, 0.10);
}
