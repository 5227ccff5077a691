//! Properties of the score on random strips, and a naive twin that samples points instead of rasterising.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test that cannot continue fails")]

mod support;

use apex_observation::assess::{AssessContext, assess};
use apex_observation::clarity::ClarityWeights;
use apex_observation::grid::{GridSettings, TargetGrid};
use apex_observation::looks::{SeenGround, StripFacts, TargetLooks};
use apex_observation::plane::Point;
use apex_observation::result::{Factors, TargetResult};
use apex_observation::target::{ObservedTarget, WantedLook};
use apex_observation::timing::WindowNeed;
use proptest::prelude::*;
use std::collections::BTreeMap;
use support::*;

const SIZE: (f64, f64) = (10_000.0, 8_000.0);
const HALF_FIELD_DEG: f64 = 43.0;
const WANTED_M: f64 = 10.0;

/// A level strip in any direction: start, direction, length, height, clarity, time.
#[derive(Clone, Copy, Debug)]
struct Strip {
    x: f64,
    y: f64,
    track_deg: f64,
    length_m: f64,
    height_m: f64,
    clarity: f64,
    time_s: f64,
}

fn strips() -> impl Strategy<Value = Vec<Strip>> {
    let one = (-6_000.0..6_000.0, -5_000.0..5_000.0, 0.0..360.0, 500.0..9_000.0, 2_000.0..8_000.0, 0..5, 0.0..20_000.0);
    let strip = one.prop_map(|(x, y, track_deg, length_m, height_m, clarity, time_s)| Strip {
        x,
        y,
        track_deg,
        length_m,
        height_m,
        clarity: 0.25 * f64::from(clarity),
        time_s,
    });
    prop::collection::vec(strip, 1..5)
}

impl Strip {
    fn axes(&self) -> (Point, Point) {
        let angle_rad = self.track_deg.to_radians();
        let along = Point { x: libm::sin(angle_rad), y: libm::cos(angle_rad) };
        (along, Point { x: along.y, y: -along.x })
    }

    fn half_m(&self) -> f64 {
        self.height_m * libm::tan(HALF_FIELD_DEG.to_radians())
    }

    fn add_to(&self, looks: &mut TargetLooks, grid: &TargetGrid) {
        let (along, right) = self.axes();
        let from = Point { x: self.x, y: self.y };
        let to = from.plus(self.length_m, along);
        let half_m = self.half_m();
        let place = |point: Point| grid.plane().point(point.x, point.y);
        let polygon =
            [from.plus(-half_m, right), from.plus(half_m, right), to.plus(half_m, right), to.plus(-half_m, right)]
                .map(place);
        let seen = SeenGround {
            polygon: &polygon,
            foot: [place(from), place(to)],
            altitude_m: [self.height_m, self.height_m],
            first_line: Some([polygon[0], polygon[1]]),
            last_left: polygon[3],
            pixel_rad: 1.25e-3,
            sun: None,
        };
        let weights = ClarityWeights { rates: self.clarity, ..ClarityWeights::CLEAR };
        looks.begin_pass(grid);
        looks.add(grid, &seen, StripFacts { time_s: self.time_s, weights, is_flown: true, on_ground_s: None }, None);
        looks.end_pass();
    }

    /// Returns clarity and resolution of the strip at a point by another formula; `None` if the strip does not see it.
    fn naive(&self, point: Point) -> Option<(f64, f64)> {
        let (along, right) = self.axes();
        let relative = point.minus(Point { x: self.x, y: self.y });
        let (ahead, aside) = (relative.dot(along), relative.dot(right).abs());
        if !(0.0..=self.length_m).contains(&ahead) || aside > self.half_m() {
            return None;
        }
        let ratio = aside / self.height_m;
        let pixel_m = 1.25e-3 * self.height_m * (1.0 + ratio * ratio);
        let resolution = if pixel_m <= WANTED_M { 1.0 } else { (2.0 - pixel_m / WANTED_M).max(0.0) };
        Some((self.clarity, resolution))
    }
}

fn look() -> WantedLook {
    WantedLook::new("any", 100.0, WANTED_M)
}

fn looks_of(strips: &[Strip], grid: &TargetGrid) -> TargetLooks {
    let mut looks = TargetLooks::default();
    strips.iter().for_each(|strip| strip.add_to(&mut looks, grid));
    looks
}

fn scored(target: &ObservedTarget, grid: &TargetGrid, strips: &[Strip]) -> TargetResult {
    let first_valid_s = BTreeMap::new();
    let context =
        AssessContext { zero_unix_s: ZERO_UNIX_S, products: &[], first_valid_s: &first_valid_s, is_explained: true };
    let result = assess(target, grid, &[&looks_of(strips, grid)], &context);
    result.looks.iter().for_each(losses_add_up);
    result
}

fn grid(target: &ObservedTarget, cells: usize) -> TargetGrid {
    TargetGrid::new(target, GridSettings { cells, ..GridSettings::default() }).unwrap()
}

/// Returns the factors by points on a lattice, with the best look of each by value, then resolution, then clarity.
fn naive(strips: &[Strip]) -> Factors {
    const STEP_M: f64 = 40.0;
    let (mut points, mut seen, mut s, mut sr) = (0.0, 0.0, 0.0, 0.0);
    for column in 0..250 {
        for row in 0..200 {
            let point = Point {
                x: -5_000.0 + (f64::from(column) + 0.5) * STEP_M,
                y: -4_000.0 + (f64::from(row) + 0.5) * STEP_M,
            };
            points += 1.0;
            let best = strips.iter().filter_map(|strip| strip.naive(point)).reduce(|a, b| {
                let (first, second) = (a.0 * a.1, b.0 * b.1);
                if (second, b.0) > (first, a.0) { b } else { a }
            });
            if let Some((clarity, resolution)) = best {
                seen += 1.0;
                s += clarity;
                sr += clarity * resolution;
            }
        }
    }
    let ratio = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
    Factors {
        coverage: seen / points,
        clarity: ratio(s, seen),
        resolution: ratio(sr, s),
        timing: if sr > 0.0 { 1.0 } else { 0.0 },
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn the_grid_agrees_with_points(strips in strips()) {
        let target = rectangle("fire", SIZE, vec![look()]);
        let exact = scored(&target, &grid(&target, 20_000), &strips).looks[0].factors;
        let twin = naive(&strips);
        for (a, b) in [
            (exact.coverage, twin.coverage),
            (exact.coverage * exact.clarity, twin.coverage * twin.clarity),
            (exact.product(), twin.product()),
        ] {
            prop_assert!((a - b).abs() < 0.006, "{exact:?} {twin:?}");
        }
    }

    #[test]
    fn factors_are_shares_and_refining_changes_little(strips in strips()) {
        let target = rectangle("fire", SIZE, vec![look()]);
        let fine = scored(&target, &grid(&target, 20_000), &strips).looks[0].factors;
        let coarse = scored(&target, &grid(&target, 5_000), &strips).looks[0].factors;
        for factor in [fine.coverage, fine.clarity, fine.resolution, fine.timing, fine.product()] {
            prop_assert!((0.0..=1.0 + 1e-12).contains(&factor), "{fine:?}");
        }
        prop_assert!((fine.product() - coarse.product()).abs() < 0.01, "{fine:?} {coarse:?}");
    }

    #[test]
    fn more_looks_never_score_less(strips in strips(), share in 0.2..1.0f64, wanted in 1..4usize) {
        let only_share = if wanted == 1 { share } else { 1.0 };
        let looks: Vec<WantedLook> = (0..wanted)
            .map(|index| WantedLook {
                name: format!("look {index}"),
                value: 100.0 / (index + 1) as f64,
                coverage_share: only_share,
                windows: vec![WindowNeed { from_s: 0.0, until_s: 6_000.0 * (index + 1) as f64, ramp_s: 4_000.0 }],
                ..look()
            })
            .collect();
        let target = rectangle("fire", SIZE, looks);
        let grid = grid(&target, 600);
        let mut before = 0.0;
        for count in 1..=strips.len() {
            let points = scored(&target, &grid, &strips[..count]).points();
            prop_assert!(points >= before - 1e-9, "{points} after {before}");
            before = points;
        }
        let mut reversed = strips.clone();
        reversed.reverse();
        let other = scored(&target, &grid, &reversed).points();
        prop_assert!((other - before).abs() < 1e-9, "the order of passes matters: {other} {before}");
    }

    #[test]
    fn value_scales_and_worthless_looks_add_nothing(strips in strips()) {
        let target = rectangle("fire", SIZE, vec![look()]);
        let grid = grid(&target, 600);
        let points = scored(&target, &grid, &strips).points();
        let triple = rectangle("fire", SIZE, vec![WantedLook { value: 300.0, ..look() }]);
        prop_assert!((scored(&triple, &grid, &strips).points() - 3.0 * points).abs() < 1e-9);
        let invalid = Strip { x: -6_000.0, y: 0.0, track_deg: 90.0, length_m: 12_000.0, height_m: 6_000.0, clarity: 0.0, time_s: 0.0 };
        let with_invalid: Vec<Strip> = strips.iter().copied().chain([invalid]).collect();
        let result = scored(&target, &grid, &with_invalid);
        prop_assert!((result.points() - points).abs() < 1e-9, "an invalid line adds nothing");
        prop_assert!((result.looks[0].factors.coverage - 1.0).abs() < 1e-9, "though it is seen");
        let late = WantedLook { windows: vec![WindowNeed { from_s: 30_000.0, until_s: 40_000.0, ramp_s: 0.0 }], ..look() };
        prop_assert_eq!(scored(&rectangle("fire", SIZE, vec![late]), &grid, &strips).points(), 0.0);
        prop_assert_eq!(scored(&rectangle("fire", SIZE, Vec::new()), &grid, &strips).points(), 0.0);
    }

    #[test]
    fn benefit_is_additive_over_disjoint_targets(strips in strips()) {
        // West and east half, each with half the value, on grids whose cells do not align with the whole.
        let half = |east_m: f64| {
            let x = [east_m, east_m + 5_000.0];
            let outer = [(x[0], -4_000.0), (x[1], -4_000.0), (x[1], 4_000.0), (x[0], 4_000.0)];
            let mut target = rectangle("half", SIZE, vec![WantedLook { value: 50.0, ..look() }]);
            let polygon = apex_observation::target::Polygon {
                outer: outer.map(|(east, north)| offset(east, north)).to_vec(),
                holes: Vec::new(),
            };
            target.area = apex_observation::target::TargetArea::Polygons(vec![polygon]);
            target
        };
        let whole = rectangle("whole", SIZE, vec![look()]);
        let points = scored(&whole, &grid(&whole, 20_000), &strips).points();
        let parts: f64 = [-5_000.0, 0.0]
            .into_iter()
            .map(|east_m| {
                let target = half(east_m);
                let moved: Vec<Strip> =
                    strips.iter().map(|strip| Strip { x: strip.x - east_m - 2_500.0, ..*strip }).collect();
                scored(&target, &grid(&target, 10_000), &moved).points()
            })
            .sum();
        prop_assert!((points - parts).abs() < 0.6, "{points} {parts}");
    }

    #[test]
    fn cells_weigh_the_exact_area(corners in prop::collection::vec((0.3..1.0f64, 0.0..1.0f64), 3..12)) {
        // A star around the middle: the shoelace formula is the second witness.
        let count = corners.len() as f64;
        let points: Vec<(f64, f64)> = corners
            .iter()
            .enumerate()
            .map(|(index, (radius, _))| {
                let angle_rad = 2.0 * std::f64::consts::PI * index as f64 / count;
                (5_000.0 * radius * libm::cos(angle_rad), 5_000.0 * radius * libm::sin(angle_rad))
            })
            .collect();
        let mut target = rectangle("star", SIZE, vec![look()]);
        let outer = points.iter().map(|(east, north)| offset(*east, *north)).collect();
        let polygon = apex_observation::target::Polygon { outer, holes: Vec::new() };
        target.area = apex_observation::target::TargetArea::Polygons(vec![polygon]);
        let next = points.iter().skip(1).chain(points.first());
        let area_m2: f64 = points.iter().zip(next).map(|(a, b)| 0.5 * (a.0 * b.1 - a.1 * b.0)).sum();
        for cells in [50, 2_000] {
            let total_m2 = grid(&target, cells).total();
            prop_assert!((total_m2 / area_m2 - 1.0).abs() < 1e-3, "{total_m2} {area_m2}");
        }
    }
}

#[test]
fn independent_means_would_score_less_for_more_area() {
    // One perfect cell of ten, then a poor one: the chain rises from 0.100 to 0.101, independent means fall to 0.0605.
    let target = rectangle("fire", (10_000.0, 1_000.0), vec![WantedLook::new("any", 1.0, 20.0)]);
    let perfect =
        Strip { x: -5_000.0, y: 0.0, track_deg: 90.0, length_m: 1_000.0, height_m: 6_000.0, clarity: 1.0, time_s: 0.0 };
    let poor = Strip { x: -4_000.0, clarity: 0.01, ..perfect };
    let grid = grid(&target, 1_000);
    let one = scored(&target, &grid, &[perfect]).looks[0].factors;
    let two = scored(&target, &grid, &[perfect, poor]).looks[0].factors;
    near(one.product(), 0.1, 1e-3);
    near(two.product() - one.product(), 0.001, 5e-5);
    near(two.coverage, 0.2, 1e-3);
}
