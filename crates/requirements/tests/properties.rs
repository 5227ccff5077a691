//! Properties of margins and predictions, against a naive twin: the route flown in steps of a hundredth of a second, with independent
//! arithmetic for distances.

#![allow(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    reason = "a failed test should stop; the twin has its own arithmetic"
)]

use apex_geo::plane::{Plane, Point};
use apex_geo::wind::Wind;
use apex_model::problem::{AirspaceZone, Position, TimeWindow, ZoneKind};
use apex_requirements::margin::zone::{KeepIn, LocalZone, ZoneBuffer};
use apex_requirements::route::{Motion, Route};
use proptest::prelude::*;

const NO_BUFFER: ZoneBuffer = ZoneBuffer { horizontal_m: 0.0, vertical_m: 0.0, time_s: 0.0 };

fn plane() -> Plane {
    Plane::new(Position::new(37.0, -117.0))
}

/// A box from `low` to `high`, as a zone and as the four numbers of the twin.
#[derive(Clone, Debug)]
struct Block {
    low: (f64, f64),
    high: (f64, f64),
    altitude_m: (f64, f64),
    active: TimeWindow,
}

impl Block {
    fn zone(&self, kind: ZoneKind) -> LocalZone {
        let (low, high) = (self.low, self.high);
        let corners = [(low.0, low.1), (high.0, low.1), (high.0, high.1), (low.0, high.1)];
        let zone = AirspaceZone {
            name: "block".into(),
            kind,
            corners: corners.iter().map(|(x, y)| plane().position(Point { x: *x, y: *y })).collect(),
            altitude_m_min: self.altitude_m.0,
            altitude_m_max: self.altitude_m.1,
            active: self.active,
        };
        LocalZone::new(0, &zone, &plane()).unwrap()
    }

    /// Returns the distance outside of the box, by clamping; 0 inside.
    fn outside_m(&self, x: f64, y: f64) -> f64 {
        let (dx, dy) = (x - x.clamp(self.low.0, self.high.0), y - y.clamp(self.low.1, self.high.1));
        (dx * dx + dy * dy).sqrt()
    }

    fn violated(&self, (x, y, altitude_m): (f64, f64, f64), at_s: f64, buffer: &ZoneBuffer) -> bool {
        self.outside_m(x, y) < buffer.horizontal_m
            && altitude_m > self.altitude_m.0 - buffer.vertical_m
            && altitude_m < self.altitude_m.1 + buffer.vertical_m
            && at_s >= self.active.from_s - buffer.time_s
            && at_s <= self.active.until_s + buffer.time_s
    }
}

fn block() -> impl Strategy<Value = Block> {
    (-20e3..20e3f64, -20e3..20e3f64, 500.0..15e3f64, 500.0..15e3f64, 0.0..3e3f64, 500.0..3e3f64, any::<bool>())
        .prop_map(|(x, y, width, depth, floor, height, always)| Block {
            low: (x, y),
            high: (x + width, y + depth),
            altitude_m: (floor, floor + height),
            active: if always { TimeWindow::ALWAYS } else { TimeWindow { from_s: 100.0, until_s: 200.0 } },
        })
}

fn motion(wind_east_mps: f64) -> Motion {
    let wind = Wind { east_mps: wind_east_mps, ..Wind::default() };
    Motion { true_airspeed_mps: 80.0, wind, turn_radius_m: 2_000.0, climb_mps: 5.0, descent_mps: 5.0 }
}

fn buffer() -> impl Strategy<Value = ZoneBuffer> {
    (10.0..1e3f64, 10.0..300.0f64, 0.0..60.0f64).prop_map(|(horizontal_m, vertical_m, time_s)| ZoneBuffer {
        horizontal_m,
        vertical_m,
        time_s,
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn margins_are_1_lipschitz(
        block in block(), buffer in buffer(), x in -30e3..30e3f64, y in -30e3..30e3f64, altitude_m in 0.0..6e3f64,
        turn in 0.0..6.2f64, rise in -1.0..1.0f64, step_m in 0.1..500.0f64,
    ) {
        let flat = (1.0 - rise * rise).sqrt() * step_m;
        let (here, there) = (Point { x, y }, Point { x: x + flat * turn.cos(), y: y + flat * turn.sin() });
        let zone = block.zone(ZoneKind::Restricted);
        let moved = zone.keep_out_m(there, altitude_m + rise * step_m, &buffer) - zone.keep_out_m(here, altitude_m, &buffer);
        prop_assert!(moved.abs() <= step_m * (1.0 + 1e-9) + 1e-6, "{moved} over {step_m}");
        let area = KeepIn::new(&[block.zone(ZoneKind::Permitted)], altitude_m, 150.0).unwrap();
        let moved = area.keep_in_m(there, altitude_m, &buffer) - area.keep_in_m(here, altitude_m, &buffer);
        if moved.is_finite() {
            prop_assert!(moved.abs() <= flat * (1.0 + 1e-9) + 1e-6 || area.keep_in_m(here, altitude_m, &NO_BUFFER) < 0.0
                || area.keep_in_m(there, altitude_m, &NO_BUFFER) < 0.0, "{moved} over {flat}");
        }
    }

    #[test]
    fn a_straight_leg_meets_a_long_edge_when_the_closed_form_says(
        distance_m in 2_000.0..25e3f64, buffer_m in 0.0..1e3f64, course in -1.0..1.0f64,
    ) {
        // An edge along the east-west direction; the course is within 57 degrees of north.
        let block = Block { low: (-300e3, distance_m), high: (300e3, distance_m + 5e3), altitude_m: (0.0, 9e3), active: TimeWindow::ALWAYS };
        let buffer = ZoneBuffer { horizontal_m: buffer_m, ..NO_BUFFER };
        let to = Point { x: 60e3 * course.sin(), y: 60e3 * course.cos() };
        let route = Route::begin(Point::default(), to, (5e3, 5e3), motion(0.0)).straight(to);
        let found_s = block.zone(ZoneKind::Restricted).first_entry(&route, &buffer, 0.0, 0.0, 1e4).unwrap().after_s;
        let closed_s = (distance_m - buffer_m) / (80.0 * course.cos());
        prop_assert!((found_s - closed_s).abs() <= 0.1, "{found_s}, closed form {closed_s}");
    }

    #[test]
    fn a_larger_buffer_is_never_met_later(
        block in block(), small in buffer(), more in 0.0..2e3f64, to in (-30e3..30e3f64, -30e3..30e3f64),
        altitude_m in 0.0..5e3f64, wind in -30.0..30.0f64,
    ) {
        let large = ZoneBuffer { horizontal_m: small.horizontal_m + more, vertical_m: small.vertical_m + more, time_s: small.time_s };
        let to = Point { x: to.0, y: to.1 };
        let route = Route::begin(Point::default(), Point { x: 0.0, y: 1.0 }, (altitude_m, altitude_m), motion(wind)).fly_to(to);
        let zone = block.zone(ZoneKind::Restricted);
        let entry_s = |buffer: &ZoneBuffer| zone.first_entry(&route, buffer, 0.0, 0.05, 600.0).map(|found| found.after_s);
        if let Some(small_s) = entry_s(&small) {
            let large_s = entry_s(&large).expect("a larger zone is met too");
            prop_assert!(large_s <= small_s + 0.02, "{large_s}, smaller zone {small_s}");
        }
    }

    #[test]
    fn the_prediction_is_what_a_flight_along_the_route_meets(
        block in block(), buffer in buffer(), to in (-30e3..30e3f64, -30e3..30e3f64), then in (-30e3..30e3f64, -30e3..30e3f64),
        altitude_m in (0.0..5e3f64, 0.0..5e3f64), wind in -30.0..30.0f64,
    ) {
        let route = Route::begin(Point::default(), Point { x: 0.0, y: 1.0 }, altitude_m, motion(wind))
            .fly_to(Point { x: to.0, y: to.1 })
            .fly_to(Point { x: then.0, y: then.1 });
        let found = block.zone(ZoneKind::Restricted).first_entry(&route, &buffer, 0.0, 0.0, 600.0);
        let mut flown = None;
        let mut last_s = 0.0;
        let mut violated_for_s = 0.0;
        for number in 0..=60_000 {
            let at_s = f64::from(number) * 0.01;
            let Some(state) = route.at(at_s) else { break };
            last_s = at_s;
            if block.violated((state.point.x, state.point.y, state.altitude_m), at_s, &buffer) {
                flown = flown.or(Some(at_s));
                violated_for_s += 0.01;
            } else if flown.is_some() {
                break;
            }
        }
        match (found, flown) {
            (Some(found), Some(flown_s)) => {
                // A first excursion shorter than the least step may be skipped in favour of a later one.
                prop_assert!((found.after_s - flown_s).abs() <= 0.05 || (violated_for_s < 1.0 && found.after_s > flown_s));
            }
            (Some(found), None) => prop_assert!(found.after_s > last_s - 0.05, "{found:?} is not flown"),
            (None, Some(_)) => prop_assert!(violated_for_s < 1.0, "a violation of {violated_for_s} s is missed"),
            (None, None) => {}
        }
    }

    #[test]
    fn a_zone_outside_of_its_time_or_band_changes_nothing(
        block in block(), to in (-30e3..30e3f64, -30e3..30e3f64), altitude_m in 0.0..5e3f64,
    ) {
        let to = Point { x: to.0, y: to.1 };
        let route = Route::begin(Point::default(), to, (altitude_m, altitude_m), motion(0.0)).fly_to(to);
        let past = Block { active: TimeWindow { from_s: -500.0, until_s: -200.0 }, ..block.clone() };
        let above = Block { altitude_m: (altitude_m + 151.0, altitude_m + 900.0), ..block };
        let buffer = ZoneBuffer { horizontal_m: 500.0, vertical_m: 150.0, time_s: 120.0 };
        for zone in [past.zone(ZoneKind::Restricted), above.zone(ZoneKind::Restricted)] {
            prop_assert_eq!(zone.first_entry(&route, &buffer, 0.0, 0.05, 600.0), None);
        }
    }
}
