//! Looks of one cell in one pass that differ in time or angle: none of them is lost to a later one with finer or equal pixels.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test that cannot continue fails")]

mod support;

use apex_observation::attitude::Attitude;
use apex_observation::clarity::ClarityWeights;
use apex_observation::flown::{FlightSample, FlownObservation, FlownSettings, Picture};
use apex_observation::footprint::FlatGround;
use apex_observation::grid::GridSettings;
use apex_observation::sensor::GimbalAngles;
use apex_observation::target::{LookAngles, ObservedTarget, OrderNeed, TargetArea, WantedLook};
use apex_observation::timing::{LightNeed, ValueSlope, WindowNeed};
use support::*;

/// Returns a point target with one wanted look.
fn valve(name: &str, look: WantedLook) -> ObservedTarget {
    ObservedTarget { area: TargetArea::Point(CENTRE), ..rectangle(name, (10.0, 10.0), vec![look]) }
}

/// Returns a picture of the point from 60 m above it, taken from a place south of it.
fn picture(time_s: f64, south_m: f64) -> Picture {
    Picture {
        sample: FlightSample {
            time_s,
            position: offset(0.0, -south_m),
            altitude_m: 60.0,
            attitude: Some(Attitude::default()),
            ground_speed_mps: 0.0,
            clear_share: Some(1.0),
        },
        angles: GimbalAngles { pan_deg: 0.0, tilt_deg: -libm::atan2(60.0, south_m).to_degrees() },
        horizontal_field_deg: 40.0,
        vertical_field_deg: 30.0,
        pixel_mrad: 0.5,
        is_stabilised: true,
        weights: ClarityWeights::CLEAR,
    }
}

fn flown(targets: Vec<ObservedTarget>, pictures: &[(f64, f64)]) -> FlownObservation {
    let settings = FlownSettings { zero_unix_s: ZERO_UNIX_S, grid: GridSettings::default(), sample_gap_s_max: 2.0 };
    let mut flown = FlownObservation::new(targets, settings, &FlatGround::default()).unwrap();
    for (time_s, south_m) in pictures {
        flown.picture(&picture(*time_s, *south_m), &FlatGround::default());
    }
    flown
}

fn points(look: WantedLook, pictures: &[(f64, f64)]) -> f64 {
    let mut results = flown(vec![valve("valve", look)], pictures).results();
    results.swap_remove(0).looks.swap_remove(0).points
}

fn wanted() -> WantedLook {
    WantedLook::new("any", 100.0, 0.05)
}

#[test]
fn a_picture_after_the_window_does_not_replace_the_one_inside() {
    let window = |from_s: f64, until_s: f64| WindowNeed { from_s, until_s, ramp_s: 0.0 };
    let look = WantedLook { windows: vec![window(0.0, 100.0)], ..wanted() };
    assert_eq!(points(look.clone(), &[(95.0, 0.0)]), 100.0);
    assert_eq!(points(look, &[(95.0, 0.0), (105.0, 0.0)]), 100.0);
    let late = WantedLook { windows: vec![window(100.0, 200.0)], ..wanted() };
    assert_eq!(points(late, &[(95.0, 0.0), (105.0, 0.0), (150.0, 0.0), (205.0, 0.0)]), 100.0);
    let slope = Some(ValueSlope::Linear { since_s: 0.0, zero_after_s: 1_000.0 });
    near(points(WantedLook { slope, ..wanted() }, &[(100.0, 0.0), (130.0, 0.0), (170.0, 0.0)]), 90.0, 1e-9);
}

#[test]
fn pictures_through_the_dusk_keep_the_last_one_by_day() {
    // The sun sets about two hours after the beginning.
    let day = WantedLook { light: LightNeed::DAY, ..wanted() };
    let every_half_minute: Vec<(f64, f64)> = (0..400).map(|number| (30.0 * f64::from(number), 0.0)).collect();
    assert_eq!(points(day.clone(), &every_half_minute[..1]), 100.0);
    assert_eq!(points(day.clone(), &every_half_minute[399..]), 0.0);
    assert_eq!(points(day, &every_half_minute), 100.0);
}

#[test]
fn a_finer_picture_straight_down_does_not_replace_the_oblique_one_that_is_wanted() {
    let angles = Some(LookAngles { min_deg: 20.0, max_deg: 50.0, ramp_deg: 10.0 });
    let oblique = WantedLook { look_angles: angles, ..wanted() };
    assert_eq!(points(oblique.clone(), &[(10.0, 40.0)]), 100.0);
    assert_eq!(points(oblique.clone(), &[(20.0, 0.0)]), 0.0);
    assert_eq!(points(oblique.clone(), &[(10.0, 40.0), (20.0, 0.0)]), 100.0);
    assert_eq!(points(oblique, &[(10.0, 0.0), (20.0, 40.0)]), 100.0);
}

#[test]
fn the_first_picture_determines_whether_a_target_was_seen_before_another() {
    let second = ObservedTarget {
        area: TargetArea::Point(offset(0.0, 200.0)),
        after: vec![OrderNeed { target: "first".to_string(), discount: 0.0 }],
        ..valve("second", wanted())
    };
    // The picture of the first target at 30 s is finer than that at 10 s.
    let mut flown = flown(vec![valve("first", wanted()), second], &[(10.0, 40.0)]);
    let of_first = picture(20.0, 0.0);
    let of_second = Picture { sample: FlightSample { position: offset(0.0, 200.0), ..of_first.sample }, ..of_first };
    flown.picture(&of_second, &FlatGround::default());
    flown.picture(&picture(30.0, 0.0), &FlatGround::default());
    assert_eq!(flown.results().swap_remove(1).looks.swap_remove(0).points, 100.0);
}

#[test]
fn each_of_several_pictures_in_a_row_is_a_valid_look() {
    let flown = flown(vec![valve("valve", wanted())], &[(10.0, 0.0), (50.0, 0.0), (90.0, 40.0), (91.0, 200.0)]);
    assert_eq!(flown.valid_looks_s("valve"), [10.0, 50.0, 90.0], "the last one is too coarse");
}

#[test]
fn a_stare_keeps_few_looks() {
    let every_second: Vec<(f64, f64)> = (0..3_600).map(|number| (f64::from(number), 0.0)).collect();
    let flown = flown(vec![valve("valve", wanted())], &every_second);
    let (_, looks) = flown.look_counts().next().unwrap();
    assert!(looks <= 61, "{looks}");
}
