//! Speeds of manoeuvres as predicted: short lines of a large aircraft begin at their speed, and a rotorcraft flies spirals whose middle
//! it cannot turn around at full speed.

use super::cases::{Case, STILL, WIND, all};
use apex_observation::manoeuvres::PayloadUse;

const STRONG: &str = "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr\n0,9000,0,8,0\n";

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
        ..Case::default()
    };
    all(std::iter::once(line.clone()), STILL, 0.05);
    all(std::iter::once(line), WIND, 0.10);
}

/// The first rings, and the outside of all of them, were flown up to 8 m outside of the path: the ground between them was not seen.
#[test]
fn a_rotorcraft_flies_the_rings_of_a_narrow_spiral() {
    let spirals = [
        ("rmax", 8.0, ("spiral", &[("from", 6.8), ("to", 52.0), ("spacing", 15.9), ("height", 39.0)][..])),
        ("quadrotor", 8.0, ("spiral", &[("from", 0.0), ("to", 50.0), ("spacing", 20.0), ("height", 40.0)][..])),
    ];
    let cases = spirals.map(|(model, speed_mps, form)| Case {
        model,
        form,
        speed_mps: Some(speed_mps),
        payload: PayloadUse::StillsEvery(6.4),
        ..Case::default()
    });
    all(cases.clone().into_iter(), STILL, 0.05);
    all(cases.into_iter(), STRONG, 0.10);
}
