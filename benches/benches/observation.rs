//! Observation: prediction of a sweep of four lines (at most 1 ms), the score of a flight of 24 hours (at most 0.5 s), and the candidates
//! of 40 targets, each with heights, spacings, turns in the wind and predicted factors (at most 1 s).
#![allow(missing_docs, reason = "criterion's macros make public items")]

use apex_geo::geodesy::{self, Position};
use apex_observation::attitude::Attitude;
use apex_observation::clarity::AttitudeHold;
use apex_observation::flown::{FlightSample, FlownObservation, FlownSettings, SensorState};
use apex_observation::footprint::{FlatGround, offset_position};
use apex_observation::grid::{GridSettings, PLANNING_CELLS, TargetGrid};
use apex_observation::predict::{AirConditions, PlannedLine, PredictedScanner, PredictionContext, predict};
use apex_observation::sensor::{RateLimits, RollLimits, ScannerMode};
use apex_observation::strip::ScannerSetting;
use apex_observation::target::{ObservedTarget, Polygon, TargetArea, WantedLook};
use criterion::{Criterion, criterion_group, criterion_main};
use std::collections::BTreeMap;
use std::hint::black_box;

const SPEED_MPS: f64 = 95.0;
const ALTITUDE_M: f64 = 6_000.0;
/// Lines of the sweep: distance north of the middle.
const ROWS_M: [f64; 4] = [-7_500.0, -2_500.0, 2_500.0, 7_500.0];
const TARGETS: usize = 22;

fn fire(name: String, middle: Position) -> ObservedTarget {
    let corners = [(-10_000.0, -10_000.0), (-10_000.0, 10_000.0), (10_000.0, 10_000.0), (10_000.0, -10_000.0)];
    let outer = corners.map(|(north_m, east_m)| offset_position(middle, north_m, east_m)).to_vec();
    ObservedTarget {
        name,
        area: TargetArea::Polygons(vec![Polygon { outer, holes: Vec::new() }]),
        elevation_m: 0.0,
        is_water: false,
        looks: vec![WantedLook::new("any", 100.0, 10.0)],
        after: Vec::new(),
    }
}

fn setting() -> ScannerSetting {
    let mode = ScannerMode {
        name: "wide".to_string(),
        pixel_mrad: 1.25,
        field_of_view_deg: 86.0,
        scan_rates_hz: vec![12.5, 25.0],
        line_overlap: 0.0,
    };
    ScannerSetting {
        mode,
        roll: Some(RollLimits { valid_deg: 3.0, zero_deg: None }),
        rates: Some(RateLimits::default()),
        scan_rate_hz: None,
        is_ready: true,
    }
}

fn row(middle: Position, north_m: f64) -> (Position, Position) {
    (offset_position(middle, north_m, -10_500.0), offset_position(middle, north_m, 10_500.0))
}

fn prediction(c: &mut Criterion) {
    let middle = Position::new(40.0, -120.0);
    let target = fire("fire".to_string(), middle);
    let settings = GridSettings { cells: PLANNING_CELLS, ..GridSettings::default() };
    let Ok(grid) = TargetGrid::new(&target, settings) else { return };
    let lines = ROWS_M.map(|north_m| {
        let (from, to) = row(middle, north_m);
        PlannedLine {
            from,
            to,
            altitude_m: ALTITUDE_M,
            from_s: 300.0 + north_m / 100.0,
            ground_speed_mps: SPEED_MPS,
            crab_deg: 4.0,
            pitch_deg: 2.0,
            on_ground_s: Some(3_000.0),
        }
    });
    let hold = AttitudeHold { roll_deg_per_edr: 10.0, natural_frequency_rad_s: Some(1.0), damping_ratio: 0.7 };
    let scanner = PredictedScanner { setting: setting(), hold };
    let first_valid_s = BTreeMap::new();
    let context = PredictionContext {
        zero_unix_s: 0.0,
        ground: &FlatGround::default(),
        conditions: &AirConditions { edr: 0.15, clear_share: 1.0 },
        seen: None,
        products: &[],
        first_valid_s: &first_valid_s,
        is_explained: false,
    };
    c.bench_function("observation/predict a sweep of 4 lines", |b| {
        b.iter(|| black_box(predict(&target, &grid, black_box(&lines), &scanner, &context)));
    });
}

/// Samples of 24 hours: from fire to fire at 1 Hz with the scanner off, along the lines at 5 Hz with the scanner on.
fn samples(middles: &[Position]) -> Vec<(bool, FlightSample)> {
    let mut samples = Vec::new();
    let mut time_s = 0.0;
    let mut here = Position::new(35.0, -118.0);
    let mut fly = |to: Position, step_s: f64, is_on: bool| {
        let (length_m, azimuth_deg) = geodesy::inverse(here, to);
        let steps = (length_m / SPEED_MPS / step_s) as usize + 1;
        for step in 0..steps {
            let attitude = Attitude { heading_deg: azimuth_deg, pitch_deg: 1.0, roll_deg: 0.02 * (step % 50) as f64 };
            let sample = FlightSample {
                time_s,
                position: geodesy::destination(here, azimuth_deg, step as f64 * step_s * SPEED_MPS),
                altitude_m: ALTITUDE_M,
                attitude: Some(attitude),
                ground_speed_mps: SPEED_MPS,
                clear_share: Some(1.0),
            };
            samples.push((is_on, sample));
            time_s += step_s;
        }
        here = to;
        time_s
    };
    for round in 0_usize.. {
        let Some(middle) = middles.get(round % middles.len()) else { break };
        let mut until_s = 0.0;
        for north_m in ROWS_M {
            let (from, to) = row(*middle, north_m);
            fly(from, 1.0, false);
            until_s = fly(to, 0.2, true);
        }
        if until_s > 86_400.0 {
            break;
        }
    }
    samples
}

fn score(c: &mut Criterion) {
    let middles: Vec<Position> =
        (0..TARGETS).map(|index| Position::new(35.0 + 0.6 * index as f64, -118.0 - 2.0 * (index % 2) as f64)).collect();
    let targets: Vec<ObservedTarget> =
        middles.iter().enumerate().map(|(index, middle)| fire(format!("fire {index}"), *middle)).collect();
    let samples = samples(&middles);
    let settings = FlownSettings { zero_unix_s: 0.0, grid: GridSettings::default(), sample_gap_s_max: 2.0 };
    let ground = FlatGround::default();
    let mut group = c.benchmark_group("observation");
    group.sample_size(10);
    group.bench_function("score a flight of 24 hours", |b| {
        b.iter(|| {
            let Ok(mut flown) = FlownObservation::new(targets.clone(), settings, &ground) else { return Vec::new() };
            let mut was_on = false;
            for (is_on, sample) in &samples {
                if *is_on != was_on {
                    flown.sensor(if *is_on { SensorState::Scanning(setting()) } else { SensorState::Off });
                    was_on = *is_on;
                }
                flown.sample(*sample, &ground);
            }
            black_box(flown.results())
        });
    });
    group.finish();
}

/// Returns a mission over 40 fires of different sizes, in the wind.
fn mission(folder: &std::path::Path) -> Option<apex_mission::Mission> {
    let fires = (0..40).map(|number| {
        let (row, column) = (f64::from(number / 8), f64::from(number % 8));
        format!(
            "{{\"type\": \"Feature\", \"properties\": {{\"id\": \"fire-{number}\", \"kind\": \"fire\", \"acres\": {}, \"value\": 50, \
             \"resolution_m\": 10, \"elevation_m\": {}}}, \"geometry\": {{\"type\": \"Point\", \"coordinates\": [{:.3}, {:.3}]}}}}",
            1_000 + 700 * number,
            400 + 40 * number,
            -120.0 + 0.5 * column,
            36.0 + 0.5 * row
        )
    });
    let home = "{\"type\": \"Feature\", \"properties\": {\"id\": \"home\", \"kind\": \"base\", \"elevation_m\": 700}, \"geometry\": \
                {\"type\": \"Point\", \"coordinates\": [-118.0, 35.0]}}";
    let features: Vec<String> = fires.chain([home.to_string()]).collect();
    let collection = format!("{{\"type\": \"FeatureCollection\", \"features\": [{}]}}", features.join(",\n"));
    let winds =
        "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr\n0,6000,250,8,0.15\n6000,18000,270,18,0.08\n";
    let program = "(defapplication \"Bench\" :type native-sim :libraries (\"vehicle\" \"aerial-observation\")\n\
                   :vehicle (sim :model predator-b :at home) :start \"2007-09-08T01:00:00Z\" :duration 20h\n\
                   :targets \"fires.geojson\" :forecast \"winds.csv\"\n\
                   :agents ((agent aircraft-1 :initial-task (map the fires))))\n\
                   (solver auto (index (map the fires)) :budget 1s)\n";
    for (name, text) in [("fires.geojson", collection.as_str()), ("winds.csv", winds), ("mission.pdl", program)] {
        std::fs::write(folder.join(name), text).ok()?;
    }
    apex_mission::Mission::load(folder).ok()
}

fn candidates(c: &mut Criterion) {
    let Ok(folder) = tempfile::tempdir() else { return };
    let Some(mission) = mission(folder.path()) else { return };
    let situation = apex_mission::situation::Situation::default();
    let mut group = c.benchmark_group("observation");
    group.sample_size(10);
    group.bench_function("candidates of 40 targets", |b| {
        b.iter(|| {
            black_box(apex_mission::problem::pose(&mission, &situation, None, apex_model::time::Time::ZERO).is_ok())
        });
    });
    group.finish();
}

criterion_group!(benches, prediction, score, candidates);
criterion_main!(benches);
