//! The paper's example 2 in whole flights: a link is lost, and the aircraft returns, waits, obeys, and learns. Distances and levels
//! are computed here, from the recorded samples alone.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a failed test should stop")]
#![allow(clippy::disallowed_methods, reason = "this check computes distances apart from the product")]

#[path = "communication/flown.rs"]
mod flown;

use flown::{Flown, World};

const SHADOW: &str = ":shadows ((:around mill :radius 700m :factor 0.05))";

/// Three sites; the mill lies in a shadow that the mission does not state.
fn hidden_shadow(vehicle: &str) -> World {
    World::new(vehicle)
        .site("barn", 900.0, 300.0)
        .site("mill", 2_600.0, 0.0)
        .site("farm", 600.0, -900.0)
        .modem(&format!(":station home :full-level 1500m {SHADOW}"))
}

fn assert_returned(flown: &Flown) {
    let lost = flown.said("communication-lost");
    for (lost_s, _) in &lost {
        let good = flown.last_good_place(*lost_s);
        let until_s = flown.said("communication-regained").iter().map(|said| said.0).find(|at_s| at_s > lost_s);
        let nearest_m = flown.nearest_m(good, (*lost_s, until_s.unwrap_or(f64::INFINITY)));
        assert!(nearest_m <= 200.0, "nearest to the good place: {nearest_m:.0} m after the loss at {lost_s} s");
    }
}

#[test]
fn a_rotorcraft_returns_waits_and_resumes_around_the_shadow() {
    let flown = hidden_shadow("rmax").fly();
    assert_eq!(flown.said("communication-lost").len(), 1, "{}", flown.story());
    assert_returned(&flown);
    let at_s =
        |head: &str| flown.said(head).first().map(|said| said.0).unwrap_or_else(|| panic!("{head}: {}", flown.story()));
    let waited_s = at_s("instructed") - at_s("awaiting-instructions");
    assert!((waited_s - 120.0).abs() < 1.0, "the deadline: {waited_s}");
    assert!(at_s("communication-lost") < at_s("communication-regained"));
    assert!(at_s("communication-regained") <= at_s("awaiting-instructions"));
    flown.assert_replays();
}

#[test]
fn a_fixed_wing_circles_through_the_good_place() {
    let flown = hidden_shadow("fixed-wing-mapper").fly();
    assert_eq!(flown.said("communication-lost").len(), 1, "{}", flown.story());
    assert_returned(&flown);
    flown.assert_replays();
}
