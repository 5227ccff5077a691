//! The worked examples of `docs/reference/observation.md`: the table of that page, and further ones.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test that cannot continue fails")]

mod support;

use apex_geo::geodesy::Position;
use apex_observation::assess::{AssessContext, assess};
use apex_observation::clarity::{AttitudeHold, ClarityWeights};
use apex_observation::footprint::FlatGround;
use apex_observation::grid::{GridSettings, TargetGrid};
use apex_observation::looks::{SeenGround, StripFacts, TargetLooks};
use apex_observation::predict::{
    AirConditions, PlannedLine, PredictedScanner, PredictionContext, gain_after, gain_points, is_worth_flying_again,
    predict,
};
use apex_observation::result::{LookResult, LossCause};
use apex_observation::score::{CostRow, CostTerm, failure_probability, mission_score};
use apex_observation::sensor::RollLimits;
use apex_observation::strip::ScannerSetting;
use apex_observation::target::{ObservedTarget, Polygon, TargetArea, WantedLook};
use apex_observation::timing::{LatencyNeed, LightNeed, OverpassNeed, WindowNeed};
use std::collections::BTreeMap;
use support::*;

const PAGE: &str = include_str!("../../../docs/reference/observation.md");

/// A line of an example: y, from x, until x, clarity.
type Line = (f64, f64, f64, f64);

fn number(text: &str) -> f64 {
    text.trim().parse().unwrap_or_else(|_| panic!("`{text}` is not a number"))
}

fn lines(text: &str, width_m: f64, clarity: f64) -> Vec<Line> {
    let line = |word: &str| {
        let (word, clarity) = word.split_once('@').map_or((word, clarity), |(word, own)| (word, number(own)));
        let (y, ends) = word.split_once(':').map_or((word, None), |(y, ends)| (y, ends.split_once('-')));
        let (from, until) = ends.map_or((0.0, width_m), |(from, until)| (number(from), number(until)));
        (number(y), from, until, clarity)
    };
    text.split_whitespace().map(line).collect()
}

/// Passes of a scanner with 43 degrees to either side, laid on the plane directly.
fn passes(grid: &TargetGrid, size: (f64, f64), height_m: f64, lines: &[Line], time_s: f64) -> TargetLooks {
    let mut looks = TargetLooks::default();
    let half_m = height_m * libm::tan(43f64.to_radians());
    // The plane's origin is the middle of the target.
    let at = |x: f64, y: f64| grid.plane().point(x - 0.5 * size.0, y - 0.5 * size.1);
    for (y, from, until, clarity) in lines {
        looks.begin_pass(grid);
        let polygon = [at(*from, y + half_m), at(*from, y - half_m), at(*until, y - half_m), at(*until, y + half_m)];
        let seen = SeenGround {
            polygon: &polygon,
            foot: [at(*from, *y), at(*until, *y)],
            altitude_m: [height_m, height_m],
            first_line: Some([polygon[0], polygon[1]]),
            last_left: polygon[3],
            pixel_rad: 1.25e-3,
            sun: None,
        };
        let weights = ClarityWeights { rates: *clarity, ..ClarityWeights::CLEAR };
        looks.add(grid, &seen, StripFacts { time_s, weights, is_flown: true, on_ground_s: None }, None);
    }
    looks.end_pass();
    looks
}

fn assessed(target: &ObservedTarget, grid: &TargetGrid, looks: &TargetLooks) -> Vec<LookResult> {
    let first_valid_s = BTreeMap::new();
    let context =
        AssessContext { zero_unix_s: ZERO_UNIX_S, products: &[], first_valid_s: &first_valid_s, is_explained: true };
    let results = assess(target, grid, &[looks], &context).looks;
    results.iter().for_each(losses_add_up);
    results
}

#[test]
fn the_table_of_the_reference_page() {
    let table = PAGE.split("## Worked examples").nth(1).unwrap();
    let rows = table.lines().filter(|line| line.starts_with("| E"));
    let mut checked = 0;
    for row in rows {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let (width, depth) = cells[1].split_once('x').unwrap();
        let size = (number(width), number(depth));
        let mut look = WantedLook::new("any", 100.0, number(cells[3]));
        if number(cells[6]) == 0.0 {
            look.windows.push(WindowNeed { from_s: 1_000.0, until_s: 2_000.0, ramp_s: 0.0 });
        }
        let target = rectangle("fire", size, vec![look]);
        let grid = TargetGrid::new(&target, GridSettings::default()).unwrap();
        let looks = passes(&grid, size, number(cells[2]), &lines(cells[4], size.0, number(cells[5])), 0.0);
        let result = &assessed(&target, &grid, &looks)[0];
        let factors = result.factors;
        let actual = [factors.coverage, factors.clarity, factors.resolution, factors.timing];
        for ((actual, cell), name) in actual.into_iter().zip(&cells[7..11]).zip(["c", "s", "r", "o"]) {
            assert!((actual - number(cell)).abs() < 0.001_5, "{row}: {name} is {actual}");
        }
        assert!((result.points - number(cells[11])).abs() < 0.12, "{row}: {} points", result.points);
        checked += 1;
    }
    assert_eq!(checked, 13, "rows of the table");
}

#[test]
fn the_grid_of_e1_converges_to_the_closed_form() {
    for cells in [500, 2_000, 20_000] {
        let target = rectangle("fire", (10_000.0, 8_000.0), vec![WantedLook::new("any", 100.0, 10.0)]);
        let grid = TargetGrid::new(&target, GridSettings { cells, ..GridSettings::default() }).unwrap();
        let looks = passes(&grid, (10_000.0, 8_000.0), 6_000.0, &[(4_000.0, 0.0, 10_000.0, 1.0)], 0.0);
        let factor = assessed(&target, &grid, &looks)[0].factors.resolution;
        assert!((factor - 0.994_55).abs() < 0.000_6, "{cells} cells: {factor}");
    }
}

#[test]
fn factors_of_windows_passes_and_latency() {
    // E8: a night window to 06:00 with a ramp of an hour.
    let window = WindowNeed { from_s: -14_400.0, until_s: 21_600.0, ramp_s: 3_600.0 };
    for (hours, factor) in [(5.0, 1.0), (6.0 + 20.0 / 60.0, 0.667), (7.5, 0.0)] {
        near(window.factor(hours * 3_600.0), factor, 0.001);
    }
    // E9: a satellite pass, full to 30 minutes, nothing from 60.
    let overpass = OverpassNeed { passes_s: vec![0.0], full_s: 1_800.0, zero_s: 3_600.0 };
    for (minutes, factor) in [(25.0, 1.0), (45.0, 0.5), (60.0, 0.0)] {
        near(overpass.factor(minutes * 60.0), factor, 1e-12);
        near(overpass.factor(-minutes * 60.0), factor, 1e-12);
    }
    // E10: 14 minutes until the image is on the ground.
    let latency = LatencyNeed { full_s: 600.0, zero_s: 3_600.0 };
    near(latency.factor(Some(840.0)), 0.92, 1e-12);
    assert_eq!(latency.factor(None), 0.0);
}

#[test]
fn costs_are_money_and_need_a_unit() {
    // E11.
    let work = |hours: f64, wage_per_hour: f64| CostRow {
        name: "crew".to_string(),
        term: CostTerm::Work { hours, wage_per_hour },
    };
    let risk = |share: f64, cost: f64| CostRow {
        name: "failure".to_string(),
        term: CostTerm::Risk { probability: 0.002, share, cost },
    };
    let costs =
        [work(20.0, 95.0), work(20.0, 95.0), work(20.0, 60.0), work(8.0, 75.0), risk(0.9, 9e6), risk(1.0, 120_000.0)];
    near(mission_score(&[], &costs, 1.0).total, -5_600.0 - 16_440.0, 1e-9);
    near(mission_score(&[], &costs, 100.0).total, -220.4, 1e-9);
    near(failure_probability(&[(0.01, 2.0), (0.02, 1.0)]), 1.0 - libm::exp(-0.04), 1e-12);
}

#[test]
fn a_night_look_and_a_day_look_take_their_own_passes() {
    // E12: night and day of 7 to 8 September 2007 near Zaca.
    let size = (10_000.0, 8_000.0);
    let night = WantedLook { light: LightNeed::NIGHT, ..WantedLook::new("night", 60.0, 10.0) };
    let day = WantedLook { light: LightNeed::DAY, ..WantedLook::new("day", 40.0, 10.0) };
    let target = rectangle("zaca", size, vec![night, day]);
    let grid = TargetGrid::new(&target, GridSettings::default()).unwrap();
    let two = [(2_000.0, 0.0, 10_000.0, 0.98), (6_000.0, 0.0, 10_000.0, 0.98)];
    // 22:00 PDT and 13:27 PDT.
    let mut looks = passes(&grid, size, 6_000.0, &two, 5.0 * 3_600.0);
    looks.passes.extend(passes(&grid, size, 6_000.0, &two[..1], 20.45 * 3_600.0).passes);
    let results = assessed(&target, &grid, &looks);
    near(results[0].points, 58.8, 0.05);
    near(results[1].points, 35.3, 0.1);
    near(results[1].factors.coverage, 0.950, 0.001_5);
    near(results[1].factors.timing, 1.0, 1e-12);
    // Without the day pass the day look is not seen, instead of seen in the wrong light.
    looks.passes.truncate(2);
    let results = assessed(&target, &grid, &looks);
    near(results[0].points, 58.8, 0.05);
    assert_eq!(results[1].factors.coverage, 0.0);
}

#[test]
fn intervals_between_looks_choose_the_passes() {
    let size = (10_000.0, 8_000.0);
    let interval = apex_observation::target::IntervalNeed { min_s: 7_200.0, max_s: f64::INFINITY, ramp_s: 0.0 };
    let first = WantedLook::new("first", 50.0, 20.0);
    let again = WantedLook { interval: Some(interval), ..WantedLook::new("again", 50.0, 20.0) };
    let target = rectangle("fire", size, vec![first, again]);
    let grid = TargetGrid::new(&target, GridSettings { cells: 400, ..GridSettings::default() }).unwrap();
    let line = [(4_000.0, 0.0, 10_000.0, 1.0)];
    let at = |hours: &[f64]| {
        let mut looks = TargetLooks::default();
        for hour in hours {
            looks.passes.extend(passes(&grid, size, 6_000.0, &line, hour * 3_600.0).passes);
        }
        assessed(&target, &grid, &looks).iter().map(|look| look.points).sum::<f64>()
    };
    near(at(&[0.0]), 50.0, 1e-6);
    near(at(&[0.0, 1.0]), 50.0, 1e-6);
    near(at(&[0.0, 1.0, 2.5]), 100.0, 1e-6);
    near(at(&[0.0, 2.5]), 100.0, 1e-6);
    near(at(&[0.0, 1.9, 3.8]), 100.0, 1e-6);
}

#[test]
fn one_pass_serves_two_looks_only_where_the_mission_lets_it() {
    let size = (10_000.0, 8_000.0);
    for (may_share, points) in [(false, 60.0), (true, 100.0)] {
        let first = WantedLook::new("map", 60.0, 20.0);
        let second = WantedLook { may_share, ..WantedLook::new("heat", 40.0, 20.0) };
        let target = rectangle("fire", size, vec![first, second]);
        let grid = TargetGrid::new(&target, GridSettings { cells: 400, ..GridSettings::default() }).unwrap();
        let looks = passes(&grid, size, 6_000.0, &[(4_000.0, 0.0, 10_000.0, 1.0)], 0.0);
        let total: f64 = assessed(&target, &grid, &looks).iter().map(|look| look.points).sum();
        near(total, points, 1e-6);
    }
}

#[test]
fn the_band_around_a_perimeter() {
    // E13: an ellipse of 10 x 8 km by a strip along its long axis.
    let corner = |index: usize| {
        let angle_rad = 2.0 * std::f64::consts::PI * index as f64 / 256.0;
        offset(5_000.0 * libm::cos(angle_rad), 4_000.0 * libm::sin(angle_rad))
    };
    let polygon = Polygon { outer: (0..256).map(corner).collect(), holes: Vec::new() };
    let area = TargetArea::Perimeter { polygons: vec![polygon.clone()], half_width_m: 250.0, interior_weight: 0.0 };
    let band = ObservedTarget { area, ..rectangle("fire", (1.0, 1.0), vec![WantedLook::new("any", 100.0, 20.0)]) };
    let grid = TargetGrid::new(&band, GridSettings::default()).unwrap();
    near(grid.total() / 1e6, 14.18, 0.03);
    let share = |grid: &TargetGrid| {
        let strip = [(-6_000.0, -2_500.0), (6_000.0, -2_500.0), (6_000.0, 2_500.0), (-6_000.0, 2_500.0)];
        let strip = strip.map(|(x, y)| grid.plane().point(x, y));
        let mut weight = 0.0;
        grid.rasterise(&strip, |cell, _| weight += grid.weights()[cell]);
        weight / grid.total()
    };
    near(share(&grid), 0.396, 0.003);
    let interior = ObservedTarget { area: TargetArea::Polygons(vec![polygon]), ..band };
    let grid = TargetGrid::new(&interior, GridSettings::default()).unwrap();
    near(grid.total() / 1e6, 62.83, 0.03);
    near(share(&grid), 0.740, 0.002);
}

fn scanner(roll_deg_per_edr: f64) -> PredictedScanner {
    PredictedScanner {
        setting: ScannerSetting {
            roll: Some(RollLimits { valid_deg: 3.0, zero_deg: None }),
            rates: None,
            ..wide_scanner(&[])
        },
        hold: AttitudeHold { roll_deg_per_edr, natural_frequency_rad_s: None, damping_ratio: 0.7 },
    }
}

fn planned(size: (f64, f64), y: f64, x: (f64, f64), altitude_m: f64, from_s: f64) -> PlannedLine {
    let at = |x: f64| offset(x - 0.5 * size.0, y - 0.5 * size.1);
    PlannedLine {
        from: at(x.0),
        to: at(x.1),
        altitude_m,
        from_s,
        ground_speed_mps: 95.0,
        crab_deg: 0.0,
        pitch_deg: 0.0,
        on_ground_s: None,
    }
}

fn predicted(target: &ObservedTarget, grid: &TargetGrid, lines: &[PlannedLine], air: AirConditions) -> LookResult {
    let first_valid_s = BTreeMap::new();
    let context = PredictionContext {
        zero_unix_s: ZERO_UNIX_S,
        ground: &FlatGround::default(),
        conditions: &air,
        seen: None,
        products: &[],
        first_valid_s: &first_valid_s,
        is_explained: true,
    };
    let result = predict(target, grid, lines, &scanner(10.0), &context).looks.remove(0);
    losses_add_up(&result);
    result
}

#[test]
fn climbing_for_clarity_pays_up_to_a_height() {
    let size = (10_000.0, 8_000.0);
    let target = rectangle("fire", size, vec![WantedLook::new("any", 100.0, 10.0)]);
    let grid = TargetGrid::new(&target, GridSettings::default()).unwrap();
    let points = |altitude_m: f64, edr: f64| {
        let two = [2_000.0, 6_000.0].map(|y| planned(size, y, (-200.0, 10_200.0), altitude_m, y));
        predicted(&target, &grid, &two, AirConditions { edr, ..AirConditions::STILL }).points
    };
    let [low, middle, high, highest] =
        [(5_000.0, 0.30), (6_000.0, 0.20), (7_000.0, 0.10), (8_000.0, 0.05)].map(|(h, edr)| points(h, edr));
    assert!(low < middle && middle < high && high > highest, "{low} {middle} {high} {highest}");
    near(highest, 97.9, 0.2);
    near(high, 99.9, 0.2);
    // A single line: one attempt for each cell.
    let one = [planned(size, 4_000.0, (-200.0, 10_200.0), 6_000.0, 0.0)];
    let result = predicted(&target, &grid, &one, AirConditions { edr: 0.45, ..AirConditions::STILL });
    near(result.factors.clarity, 0.495, 0.001);
    assert!(result.losses.iter().any(|loss| loss.cause == LossCause::Roll && loss.points > 50.0));
}

#[test]
fn the_gain_of_more_lines_is_the_difference_of_two_predictions() {
    let size = (10_000.0, 8_000.0);
    let target = rectangle("fire", size, vec![WantedLook::new("any", 100.0, 10.0), WantedLook::new("fine", 30.0, 5.0)]);
    let grid = TargetGrid::new(&target, GridSettings::default()).unwrap();
    let seen = passes(&grid, size, 6_000.0, &[(4_000.0, 0.0, 10_000.0, 1.0)], 0.0);
    let first_valid_s = BTreeMap::new();
    for (seen, is_explained) in [(None, false), (Some(&seen), true), (Some(&seen), false)] {
        let context = PredictionContext {
            zero_unix_s: ZERO_UNIX_S,
            ground: &FlatGround::default(),
            conditions: &AirConditions { edr: 0.3, clear_share: 0.8 },
            seen,
            products: &[],
            first_valid_s: &first_valid_s,
            is_explained,
        };
        let line = |y: f64, from_s: f64| planned(size, y, (-200.0, 10_200.0), 4_000.0, from_s);
        let all = [line(2_000.0, 900.0), line(6_000.0, 1_100.0), line(4_000.0, 1_300.0)];
        let points = |lines: &[PlannedLine]| predict(&target, &grid, lines, &scanner(10.0), &context).points();
        for count in 0..=all.len() {
            let (lines, more) = all.split_at(count);
            let gain = gain_after(&target, &grid, (lines, more), &scanner(10.0), &context);
            assert_eq!(gain.to_bits(), (points(&all) - points(lines)).to_bits(), "{count} lines before");
        }
    }
}

#[test]
fn flying_a_segment_again_pays_where_no_other_line_sees_it() {
    let size = (10_000.0, 8_000.0);
    let target = rectangle("fire", size, vec![WantedLook::new("any", 100.0, 10.0)]);
    let grid = TargetGrid::new(&target, GridSettings::default()).unwrap();
    let first_valid_s = BTreeMap::new();
    let gain = |seen: &TargetLooks, y: f64, edr: f64| {
        let context = PredictionContext {
            zero_unix_s: ZERO_UNIX_S,
            ground: &FlatGround::default(),
            conditions: &AirConditions { edr, ..AirConditions::STILL },
            seen: Some(seen),
            products: &[],
            first_valid_s: &first_valid_s,
            is_explained: false,
        };
        gain_points(&target, &grid, &[planned(size, y, (3_000.0, 4_000.0), 6_000.0, 900.0)], &scanner(10.0), &context)
    };
    // 1,207.5 points in 23.3 hours; 218 s to fly a kilometre again.
    let points_per_s = 1_207.5 / (23.3 * 3_600.0);
    let single = passes(
        &grid,
        size,
        6_000.0,
        &[(4_000.0, 0.0, 3_000.0, 1.0), (4_000.0, 3_000.0, 4_000.0, 0.0), (4_000.0, 4_000.0, 10_000.0, 1.0)],
        0.0,
    );
    let alone = gain(&single, 4_000.0, 0.0);
    near(alone, 9.95, 0.1);
    assert!(is_worth_flying_again(alone, points_per_s, 218.0));
    let double = passes(
        &grid,
        size,
        6_000.0,
        &[
            (2_000.0, 0.0, 3_000.0, 1.0),
            (2_000.0, 3_000.0, 4_000.0, 0.0),
            (2_000.0, 4_000.0, 10_000.0, 1.0),
            (6_000.0, 0.0, 10_000.0, 1.0),
        ],
        0.0,
    );
    let overlapped = gain(&double, 2_000.0, 0.0);
    near(overlapped, 1.0, 0.1);
    assert!(!is_worth_flying_again(overlapped, points_per_s, 218.0));
    // The turbulence that caused the loss persists.
    near(gain(&single, 4_000.0, 0.45), 0.495 * alone, 0.1);
}

#[test]
fn the_middle_of_the_examples_is_the_middle_of_the_plane() {
    let target = rectangle("fire", (10_000.0, 8_000.0), vec![WantedLook::new("any", 100.0, 10.0)]);
    let grid = TargetGrid::new(&target, GridSettings::default()).unwrap();
    let centre: Position = grid.plane().centre();
    near(centre.latitude_deg, CENTRE.latitude_deg, 1e-4);
    near(grid.total(), 8e7, 8e3);
    assert!((19_000..=21_000).contains(&grid.len()), "{} cells", grid.len());
}
