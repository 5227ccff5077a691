//! Flights of samples through the accumulation: known results, gaps, attitude, predicted against flown.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test that cannot continue fails")]

mod support;

use apex_geo::geodesy::{self, Position};
use apex_observation::assess::Product;
use apex_observation::attitude::Attitude;
use apex_observation::clarity::{AttitudeHold, ClarityWeights};
use apex_observation::flown::{FlightSample, FlownObservation, FlownSettings, ObservationError, Picture, SensorState};
use apex_observation::footprint::{FlatGround, Ground};
use apex_observation::grid::GridSettings;
use apex_observation::predict::{AirConditions, PlannedLine, PredictedScanner, PredictionContext, predict};
use apex_observation::result::{LookResult, LossCause, Remark};
use apex_observation::sensor::{GimbalAngles, RateLimits, RollLimits};
use apex_observation::strip::ScannerSetting;
use apex_observation::target::{ObservedTarget, OrderNeed, TargetArea, WantedLook};
use apex_observation::timing::{LatencyNeed, LightNeed};
use rand_chacha::{ChaCha8Rng, rand_core::Rng, rand_core::SeedableRng};
use std::collections::BTreeMap;
use support::*;

const SIZE: (f64, f64) = (10_000.0, 8_000.0);
const SPEED_MPS: f64 = 95.0;

fn flight(targets: Vec<ObservedTarget>, cells: usize) -> FlownObservation {
    let grid = GridSettings { cells, ..GridSettings::default() };
    let settings = FlownSettings { zero_unix_s: ZERO_UNIX_S, grid, sample_gap_s_max: 2.0 };
    FlownObservation::new(targets, settings, &FlatGround::default()).unwrap()
}

fn levelled() -> ScannerSetting {
    ScannerSetting { roll: Some(RollLimits { valid_deg: 3.0, zero_deg: None }), ..wide_scanner(&[]) }
}

/// Flies a line and gives samples every `step_s`; `change` alters a sample by its time since the beginning.
fn fly(
    flown: &mut FlownObservation,
    setting: &ScannerSetting,
    (from, to): (Position, Position),
    (altitude_m, from_s, step_s): (f64, f64, f64),
    mut change: impl FnMut(f64, &mut FlightSample),
) {
    let (length_m, azimuth_deg) = geodesy::inverse(from, to);
    flown.sensor(SensorState::Scanning(setting.clone()));
    let steps = (length_m / SPEED_MPS / step_s).ceil() as usize;
    for step in 0..=steps {
        let since_s = (step as f64 * step_s).min(length_m / SPEED_MPS);
        let mut sample = FlightSample {
            time_s: from_s + since_s,
            position: geodesy::destination(from, azimuth_deg, since_s * SPEED_MPS),
            altitude_m,
            attitude: Some(Attitude { heading_deg: azimuth_deg, pitch_deg: 0.0, roll_deg: 0.0 }),
            ground_speed_mps: SPEED_MPS,
            clear_share: Some(1.0),
        };
        change(since_s, &mut sample);
        flown.sample(sample, &FlatGround::default());
    }
    flown.sensor(SensorState::Off);
}

fn row(y: f64) -> (Position, Position) {
    (offset(-5_300.0, y - 4_000.0), offset(5_300.0, y - 4_000.0))
}

fn result(flown: &FlownObservation, target: usize) -> LookResult {
    let look = flown.results().swap_remove(target).looks.swap_remove(0);
    losses_add_up(&look);
    look
}

#[test]
fn a_night_fire_by_day_is_worth_nothing() {
    let night = WantedLook { light: LightNeed::NIGHT, ..WantedLook::new("night", 100.0, 10.0) };
    // 13:27 PDT on 8 September 2007.
    let from_s = 20.45 * 3_600.0;
    let mut flown = flight(vec![rectangle("fire", SIZE, vec![night])], 4_000);
    for y in [2_000.0, 6_000.0] {
        fly(&mut flown, &levelled(), row(y), (6_000.0, from_s + y, 0.2), |_, _| {});
    }
    let look = result(&flown, 0);
    assert_eq!(look.points, 0.0);
    near(look.factors.coverage, 1.0, 1e-9);
    assert_eq!(look.factors.timing, 0.0);
    assert!(look.losses.iter().all(|loss| loss.cause == LossCause::NoLight || loss.points < 0.1), "{:?}", look.losses);
}

#[test]
fn one_line_over_300_000_acres_is_worth_a_fifth() {
    let side_m = (300_000.0_f64 * 4_046.856_422_4).sqrt();
    let target = rectangle("fire", (side_m, side_m), vec![WantedLook::new("any", 100.0, 20.0)]);
    for (altitude_m, points) in [(6_000.0, 20.3), (5_330.0, 18.0)] {
        let mut flown = flight(vec![target.clone()], 20_000);
        let line = (offset(-11_000.0, 0.0), offset(11_000.0, 0.0));
        fly(&mut flown, &levelled(), line, (altitude_m, 0.0, 1.0), |_, _| {});
        let look = result(&flown, 0);
        near(look.points, points, 0.25);
        let unseen: f64 =
            look.losses.iter().filter(|loss| loss.cause == LossCause::NotSeen).map(|loss| loss.points).sum();
        near(unseen, 100.0 - look.points, 0.05);
    }
}

#[test]
fn a_look_before_its_predecessor_gets_the_discount() {
    for (discount, points) in [(0.0, 0.0), (0.5, 49.75)] {
        let first = ObservedTarget {
            area: TargetArea::Point(offset(60_000.0, 0.0)),
            ..rectangle("first", SIZE, vec![WantedLook::new("any", 10.0, 20.0)])
        };
        let second = ObservedTarget {
            after: vec![OrderNeed { target: "first".to_string(), discount }],
            ..rectangle("second", SIZE, vec![WantedLook::new("any", 100.0, 10.0)])
        };
        let mut flown = flight(vec![first, second], 4_000);
        fly(&mut flown, &levelled(), row(4_000.0), (6_000.0, 0.0, 1.0), |_, _| {});
        near(result(&flown, 1).points, points, 0.1);
        let past = (offset(58_000.0, 0.0), offset(62_000.0, 0.0));
        fly(&mut flown, &levelled(), past, (6_000.0, 900.0, 1.0), |_, _| {});
        near(result(&flown, 0).points, 10.0, 1e-6);
        near(result(&flown, 1).points, points, 0.1);
        // After the target that must come first, a second look counts in full.
        fly(&mut flown, &levelled(), row(4_000.0), (6_000.0, 2_000.0, 1.0), |_, _| {});
        near(result(&flown, 1).points, 99.5, 0.1);
    }
}

#[test]
fn a_gap_in_the_record_is_not_seen_and_a_low_wing_is_seen_in_vain() {
    let target = || vec![rectangle("fire", SIZE, vec![WantedLook::new("any", 100.0, 10.0)])];
    // The kilometre from x = 3 to 4 km: 3.3 km to 4.3 km from the beginning of the line.
    let (from_s, until_s) = (3_300.0 / SPEED_MPS, 4_300.0 / SPEED_MPS);
    let mut gap = flight(target(), 20_000);
    fly(&mut gap, &levelled(), row(4_000.0), (6_000.0, 0.0, 0.2), |since_s, sample| {
        if (from_s..until_s).contains(&since_s) {
            sample.time_s = f64::NAN;
        }
    });
    let look = result(&gap, 0);
    near(look.factors.coverage, 0.9, 0.01);
    near(look.factors.clarity, 1.0, 1e-12);
    near(look.points, 89.5, 1.0);
    let mut low = flight(target(), 20_000);
    fly(&mut low, &levelled(), row(4_000.0), (6_000.0, 0.0, 0.2), |since_s, sample| {
        if let Some(attitude) = &mut sample.attitude
            && (from_s..until_s).contains(&since_s)
        {
            attitude.roll_deg = 4.0;
        }
    });
    let look = result(&low, 0);
    near(look.factors.coverage, 1.0, 1e-9);
    near(look.factors.clarity, 0.9, 0.01);
    near(look.points, 89.5, 1.0);
    let by_roll: f64 = look.losses.iter().filter(|loss| loss.cause == LossCause::Roll).map(|loss| loss.points).sum();
    near(by_roll, 10.0, 1.0);
}

#[test]
fn a_flight_without_attitude_is_not_known_to_be_clear() {
    let mut flown = flight(vec![rectangle("fire", SIZE, vec![WantedLook::new("any", 100.0, 10.0)])], 4_000);
    fly(&mut flown, &levelled(), row(4_000.0), (6_000.0, 0.0, 1.0), |_, sample| {
        sample.attitude = None;
        sample.clear_share = None;
    });
    let look = result(&flown, 0);
    assert_eq!(look.points, 0.0);
    near(look.factors.coverage, 1.0, 1e-9);
    assert!(look.remarks.contains(&Remark::AttitudeNotRecorded) && look.remarks.contains(&Remark::CloudNotKnown));
    assert_eq!(look.losses[0].cause, LossCause::AttitudeNotRecorded);
}

#[test]
fn ground_swept_with_the_sensor_off_is_not_seen() {
    let mut flown = flight(vec![rectangle("fire", SIZE, vec![WantedLook::new("any", 100.0, 10.0)])], 4_000);
    let (from, to) = row(4_000.0);
    for step in 0..120 {
        let position = geodesy::interpolate(from, to, f64::from(step) / 119.0);
        let attitude = Some(Attitude { heading_deg: 90.0, ..Attitude::default() });
        let sample = FlightSample {
            time_s: f64::from(step),
            position,
            altitude_m: 6_000.0,
            attitude,
            ground_speed_mps: SPEED_MPS,
            clear_share: None,
        };
        flown.sample(sample, &FlatGround::default());
    }
    assert_eq!(result(&flown, 0).factors.coverage, 0.0);
}

#[test]
fn cloud_and_late_images_have_their_causes() {
    let look = WantedLook {
        latency: Some(LatencyNeed { full_s: 600.0, zero_s: 3_600.0 }),
        ..WantedLook::new("any", 100.0, 20.0)
    };
    let mut flown = flight(vec![rectangle("fire", SIZE, vec![look])], 4_000);
    let west_s = 5_300.0 / SPEED_MPS;
    fly(&mut flown, &levelled(), row(4_000.0), (6_000.0, 0.0, 1.0), |since_s, sample| {
        sample.clear_share = Some(if since_s < west_s { 0.0 } else { 1.0 });
    });
    let before = result(&flown, 0);
    assert_eq!(before.points, 0.0, "no image has arrived");
    assert!(before.remarks.contains(&Remark::ArrivalNotKnown));
    flown.product(Product { from_s: 0.0, until_s: 200.0, on_ground_s: 84.0 + 840.0 });
    let look = result(&flown, 0);
    near(look.factors.clarity, 0.5, 0.01);
    near(look.factors.timing, 0.92, 0.012);
    let by = |cause: LossCause| look.losses.iter().find(|loss| loss.cause == cause).map_or(0.0, |loss| loss.points);
    near(by(LossCause::Cloud), 50.0, 1.0);
    near(by(LossCause::LateOnGround), 4.0, 0.5);
}

#[test]
fn too_low_for_the_scan_rate_leaves_gaps() {
    let setting = ScannerSetting { scan_rate_hz: Some(12.5), ..levelled() };
    let setting = ScannerSetting { mode: wide_scanner(&[12.5]).mode, ..setting };
    let mut flown = flight(vec![rectangle("fire", SIZE, vec![WantedLook::new("any", 100.0, 20.0)])], 4_000);
    fly(&mut flown, &setting, row(4_000.0), (4_560.0, 0.0, 1.0), |_, _| {});
    let look = result(&flown, 0);
    // h_min is 6,080 m.
    near(look.factors.clarity, 0.75, 1e-6);
    assert!(look.losses.iter().any(|loss| loss.cause == LossCause::LineGaps && loss.points > 20.0));
}

#[test]
fn what_is_predicted_is_flown_in_still_air() {
    let target = rectangle("fire", SIZE, vec![WantedLook::new("any", 100.0, 8.0)]);
    let mut flown = flight(vec![target.clone()], 20_000);
    let rows = [1_500.0, 5_500.0];
    for y in rows {
        fly(&mut flown, &levelled(), row(y), (5_500.0, y, 0.2), |_, _| {});
    }
    let flown = result(&flown, 0);
    let line = |y: f64| {
        let (from, to) = row(y);
        PlannedLine {
            from,
            to,
            altitude_m: 5_500.0,
            from_s: y,
            ground_speed_mps: SPEED_MPS,
            crab_deg: 0.0,
            pitch_deg: 0.0,
            on_ground_s: None,
        }
    };
    let hold = AttitudeHold { roll_deg_per_edr: 10.0, natural_frequency_rad_s: Some(1.0), damping_ratio: 0.7 };
    let first_valid_s = BTreeMap::new();
    let context = PredictionContext {
        zero_unix_s: ZERO_UNIX_S,
        ground: &FlatGround::default(),
        conditions: &AirConditions::STILL,
        seen: None,
        products: &[],
        first_valid_s: &first_valid_s,
        is_explained: true,
    };
    for cells in [2_000, 20_000] {
        let settings = GridSettings { cells, ..GridSettings::default() };
        let grid = apex_observation::grid::TargetGrid::new(&target, settings).unwrap();
        let scanner = PredictedScanner { setting: levelled(), hold };
        let predicted = predict(&target, &grid, &rows.map(line), &scanner, &context).looks.swap_remove(0);
        near(predicted.points, flown.points, 0.01 * flown.points);
        near(predicted.factors.coverage, flown.factors.coverage, 0.01);
        near(predicted.factors.resolution, flown.factors.resolution, 0.01);
    }
}

/// A seeded generator, so that every run has the same turbulence.
struct Generator(ChaCha8Rng);

impl Generator {
    fn uniform(&mut self) -> f64 {
        ((self.0.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * libm::log(self.uniform())).sqrt();
        radius * libm::cos(2.0 * std::f64::consts::PI * self.uniform())
    }
}

#[test]
fn predicted_clarity_is_the_mean_of_flown_clarity_in_turbulence() {
    // The roll angle as a damped oscillator driven by white noise, in steps of 0.02 s, recorded at 5 Hz.
    let (frequency, damping, edr, k) = (1.0, 0.7, 0.25, 10.0);
    let sigma_deg = k * edr;
    let (step_s, seeds) = (0.02_f64, 60);
    // Stationary variance of phi is q / (4 zeta omega^3).
    let kick = sigma_deg * (4.0 * damping * frequency * frequency * frequency * step_s).sqrt();
    let target = rectangle("fire", (10_000.0, 3_000.0), vec![WantedLook::new("any", 100.0, 20.0)]);
    let empty = flight(vec![target], 600);
    let mut sum = 0.0;
    for seed in 0..seeds {
        let mut air = Generator(ChaCha8Rng::seed_from_u64(seed));
        let (mut roll, mut rate) = (sigma_deg * air.normal(), frequency * sigma_deg * air.normal());
        let mut flown = empty.clone();
        let line = (offset(-5_300.0, 0.0), offset(5_300.0, 0.0));
        fly(&mut flown, &levelled(), line, (6_000.0, 0.0, 0.2), |_, sample| {
            for _ in 0..10 {
                let force = -frequency * frequency * roll - 2.0 * damping * frequency * rate;
                rate += force * step_s + kick * air.normal();
                roll += rate * step_s;
            }
            if let Some(attitude) = &mut sample.attitude {
                attitude.roll_deg = roll;
            }
        });
        sum += result(&flown, 0).factors.clarity;
    }
    let share = libm::erf(3.0 / (sigma_deg * std::f64::consts::SQRT_2));
    let (correlation_s, line_s) = (1.0 / (damping * frequency), 10_000.0 / SPEED_MPS);
    let deviation = (share * (1.0 - share) * 2.0 * correlation_s / line_s / seeds as f64).sqrt();
    near(sum / seeds as f64, share, 3.0 * deviation + 0.003);
}

#[test]
fn turns_lose_lines_by_roll_and_rates() {
    let setting = ScannerSetting {
        roll: None,
        rates: Some(RateLimits::default()),
        scan_rate_hz: Some(12.5),
        ..wide_scanner(&[12.5])
    };
    let mut flown = flight(vec![rectangle("fire", SIZE, vec![WantedLook::new("any", 100.0, 20.0)])], 2_000);
    // 4 pixels per line by roll rate: 0.716 degrees in 0.2 s are 4 x 0.895 degrees per second, half the worth.
    fly(&mut flown, &setting, row(4_000.0), (6_100.0, 0.0, 0.2), |since_s, sample| {
        if let Some(attitude) = &mut sample.attitude {
            let is_even = (since_s / 0.2).round() % 2.0 == 0.0;
            attitude.roll_deg = if is_even { 0.358_1 } else { -0.358_1 };
        }
    });
    let look = result(&flown, 0);
    let rates: f64 = look.losses.iter().filter(|loss| loss.cause == LossCause::Rates).map(|loss| loss.points).sum();
    near(rates / (rates + look.points), 0.5, 0.02);
}

/// A ridge of 2,000 m along the meridian east of the middle.
struct Ridge;

impl Ground for Ridge {
    fn elevation_m_at(&self, position: Position) -> Option<f64> {
        let east_m = (position.longitude_deg - CENTRE.longitude_deg) * 91_500.0;
        Some((2_000.0 - 2.0 * (east_m - 1_500.0).abs()).max(0.0))
    }

    fn elevation_range_m(&self) -> (f64, f64) {
        (0.0, 2_000.0)
    }

    fn cell_m(&self) -> f64 {
        30.0
    }
}

#[test]
fn a_ridge_hides_the_valley_behind_it() {
    let valley = ObservedTarget {
        area: TargetArea::Circle { centre: offset(3_000.0, 0.0), radius_m: 300.0 },
        ..rectangle("valley", SIZE, vec![WantedLook::new("any", 100.0, 20.0)])
    };
    let settings = FlownSettings {
        zero_unix_s: ZERO_UNIX_S,
        grid: GridSettings { cells: 200, ..GridSettings::default() },
        sample_gap_s_max: 2.0,
    };
    let mut flown = FlownObservation::new(vec![valley], settings, &Ridge).unwrap();
    flown.sensor(SensorState::Scanning(wide_scanner(&[])));
    // Northwards, 1.5 km west of the ridge and 3,000 m high: the line of sight at 3 km is 1,500 m high on the ridge.
    for step in 0..60 {
        let sample = FlightSample {
            time_s: f64::from(step),
            position: offset(0.0, -2_850.0 + SPEED_MPS * f64::from(step)),
            altitude_m: 3_200.0,
            attitude: Some(Attitude::default()),
            ground_speed_mps: SPEED_MPS,
            clear_share: Some(1.0),
        };
        flown.sample(sample, &Ridge);
    }
    assert_eq!(result(&flown, 0).factors.coverage, 0.0);
}

#[test]
fn a_picture_straight_down_sees_a_point() {
    let barn = ObservedTarget {
        area: TargetArea::Point(offset(10.0, 5.0)),
        ..rectangle("barn", SIZE, vec![WantedLook::new("any", 100.0, 0.05)])
    };
    let far = ObservedTarget { area: TargetArea::Point(offset(90.0, 0.0)), name: "far".to_string(), ..barn.clone() };
    let mut flown = flight(vec![barn, far], 100);
    let sample = FlightSample {
        time_s: 10.0,
        position: CENTRE,
        altitude_m: 60.0,
        attitude: Some(Attitude::default()),
        ground_speed_mps: 0.0,
        clear_share: Some(1.0),
    };
    let picture = Picture {
        sample,
        angles: GimbalAngles { pan_deg: 0.0, tilt_deg: -90.0 },
        horizontal_field_deg: 60.0,
        vertical_field_deg: 45.0,
        pixel_mrad: 0.5,
        is_stabilised: false,
        weights: ClarityWeights::CLEAR,
    };
    flown.picture(&picture, &FlatGround::default());
    let look = result(&flown, 0);
    near(look.points, 100.0, 1e-9);
    near(look.seen.pixel_m_mean.unwrap(), 0.03 * (1.0 + 125.0 / 3_600.0), 1e-4);
    assert_eq!(result(&flown, 1).points, 0.0);
    // Turned to the east and tilted up, the camera sees the far point.
    let east = Attitude { heading_deg: 90.0, ..Attitude::default() };
    let picture = Picture {
        sample: FlightSample { attitude: Some(east), time_s: 12.0, ..sample },
        angles: GimbalAngles { pan_deg: 0.0, tilt_deg: -40.0 },
        ..picture
    };
    flown.picture(&picture, &FlatGround::default());
    assert_eq!(result(&flown, 1).factors.coverage, 1.0);
}

#[test]
fn targets_that_cannot_be_observed_are_refused_by_name() {
    let settings = FlownSettings { zero_unix_s: 0.0, grid: GridSettings::default(), sample_gap_s_max: 2.0 };
    let refused = |targets: Vec<ObservedTarget>| {
        FlownObservation::new(targets, settings, &FlatGround::default()).unwrap_err().to_string()
    };
    let fire = || rectangle("fire", SIZE, vec![WantedLook::new("any", 1.0, 10.0)]);
    let area = |area: TargetArea| vec![ObservedTarget { area, ..fire() }];
    assert!(refused(area(TargetArea::Polygons(Vec::new()))).contains("`fire`"));
    assert!(refused(area(TargetArea::Circle { centre: CENTRE, radius_m: -1.0 })).contains("radius is -1 m"));
    assert!(refused(area(TargetArea::Point(Position::new(f64::NAN, 0.0)))).contains("latitude NaN"));
    assert!(refused(area(TargetArea::Line(vec![CENTRE, CENTRE]))).contains("no length"));
    assert!(refused(area(TargetArea::Circle { centre: CENTRE, radius_m: 2e6 })).contains("1,000 km"));
    assert!(refused(vec![fire(), fire()]).contains("two targets have the name `fire`"));
    let many = vec![ObservedTarget { looks: vec![WantedLook::new("any", 1.0, 10.0); 7], ..fire() }];
    let found = FlownObservation::new(many, settings, &FlatGround::default());
    assert!(matches!(found, Err(ObservationError::TooManyLooks { looks: 7, .. })));
}
