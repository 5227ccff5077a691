//! Pictures against a naive second witness, which casts a ray to the centre of every cell and tests whether it is inside the field of
//! view, without polygons, clipping or rasters; and against the footprints of `docs/reference/observation.md`.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a failed test should stop")]
#![allow(clippy::disallowed_methods, reason = "the witness has its own arithmetic")]

mod support;

use apex_geo::geodesy::{self, Position};
use apex_observation::attitude::Attitude;
use apex_observation::clarity::ClarityWeights;
use apex_observation::footprint::FlatGround;
use apex_observation::grid::{GridSettings, TargetGrid};
use apex_observation::looks::{StripFacts, TargetLooks};
use apex_observation::pictures::{PictureView, add_picture};
use apex_observation::plane::Point;
use apex_observation::sensor::{CameraSetting, ExposureMotion, Gimbal, GimbalAngles, RateLimits, RollLimits};
use apex_observation::target::{ObservedTarget, WantedLook};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use support::*;

type Axes = [[f64; 3]; 3];

/// Returns the rotation matrix by `degrees` about axis 0 (x), 1 (y) or 2 (z).
fn turn(axis: usize, degrees: f64) -> Axes {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    match axis {
        0 => [[1.0, 0.0, 0.0], [0.0, cosine, -sine], [0.0, sine, cosine]],
        1 => [[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]],
        _ => [[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]],
    }
}

fn times(a: Axes, b: Axes) -> Axes {
    std::array::from_fn(|row| std::array::from_fn(|column| (0..3).map(|k| a[row][k] * b[k][column]).sum()))
}

/// Returns the larger of a ground point's two offsets from the centre of the picture, in half fields of view: up to 1 is inside. `None`
/// behind the camera or if the view is too flat.
fn inside(view: &PictureView, north_m: f64, east_m: f64) -> Option<f64> {
    let Attitude { heading_deg, pitch_deg, roll_deg } = view.attitude;
    let body = match view.is_stabilised {
        true => turn(2, heading_deg),
        false => times(times(turn(2, heading_deg), turn(1, pitch_deg)), turn(0, roll_deg)),
    };
    let camera = times(times(body, turn(2, view.angles.pan_deg)), turn(1, view.angles.tilt_deg));
    let ray = [north_m, east_m, view.altitude_m];
    // The transpose converts north, east, down to the axes of the camera: ahead, right, down in the picture.
    let [ahead, right, down]: [f64; 3] = std::array::from_fn(|axis| (0..3).map(|k| camera[k][axis] * ray[k]).sum());
    let steep = north_m.hypot(east_m) < view.altitude_m * 75.0_f64.to_radians().tan();
    (ahead > 0.0 && steep).then(|| {
        let across = (right / ahead).abs() / (0.5 * view.wide_deg).to_radians().tan();
        let along = (down / ahead).abs() / (0.5 * view.high_deg).to_radians().tan();
        across.max(along)
    })
}

/// A seeded generator, so that every run has the same pictures.
struct Numbers(ChaCha8Rng);

impl Numbers {
    fn next(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * ((self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64)
    }
}

fn view(numbers: &mut Numbers) -> PictureView {
    PictureView {
        time_s: 10.0,
        position: geodesy::destination(CENTRE, numbers.next(0.0, 360.0), numbers.next(0.0, 150.0)),
        altitude_m: numbers.next(40.0, 200.0),
        attitude: Attitude {
            heading_deg: numbers.next(0.0, 360.0),
            pitch_deg: numbers.next(-12.0, 12.0),
            roll_deg: numbers.next(-20.0, 20.0),
        },
        angles: GimbalAngles { pan_deg: numbers.next(-180.0, 180.0), tilt_deg: numbers.next(-90.0, -20.0) },
        is_stabilised: numbers.next(0.0, 1.0) < 0.5,
        wide_deg: numbers.next(20.0, 80.0),
        high_deg: numbers.next(15.0, 60.0),
        pixel_mrad: 0.2,
    }
}

fn field() -> (ObservedTarget, TargetGrid) {
    let target = rectangle("field", (400.0, 300.0), vec![WantedLook::new("any", 100.0, 1.0)]);
    let grid = TargetGrid::new(&target, GridSettings::default()).unwrap().with_elevations(&FlatGround::default());
    (target, grid)
}

fn facts() -> StripFacts {
    StripFacts { time_s: 10.0, weights: ClarityWeights::CLEAR, is_flown: true, on_ground_s: None }
}

#[test]
fn a_picture_sees_the_cells_whose_rays_are_inside_its_field_of_view() {
    const PICTURES: u32 = 120;
    // Distance from the edge below which a cell centre may be on either side, because grid and witness use different planes.
    const EDGE: f64 = 2e-3;
    let (target, grid) = field();
    let mut numbers = Numbers(ChaCha8Rng::seed_from_u64(20));
    let (mut seen_in_all, mut at_edge) = (0, 0);
    for number in 0..PICTURES {
        let view = view(&mut numbers);
        let mut looks = TargetLooks::default();
        looks.begin_pass(&grid);
        add_picture(&mut looks, (&target, &grid), &view, facts(), &FlatGround::default(), 0.0);
        let seen: Vec<u32> = looks.passes[0].looks.iter().map(|look| look.cell).collect();
        seen_in_all += seen.len();
        for (cell, (x, y)) in grid.centres().enumerate() {
            let there: Position = grid.plane().position(Point { x, y });
            let (distance_m, azimuth_deg) = geodesy::inverse(view.position, there);
            let (sine, cosine) = azimuth_deg.to_radians().sin_cos();
            let expected = inside(&view, distance_m * cosine, distance_m * sine);
            if expected.is_some_and(|margin| (margin - 1.0).abs() < EDGE) {
                at_edge += 1;
                continue;
            }
            let is_seen = seen.contains(&(cell as u32));
            // The limit of flat rays is a polygon of 64 corners inside the circle.
            let (flat, limit) = (distance_m, view.altitude_m * 75.0_f64.to_radians().tan());
            if (flat - limit).abs() < 2e-3 * limit {
                continue;
            }
            assert_eq!(is_seen, expected.is_some_and(|margin| margin < 1.0), "picture {number}, cell {cell}: {view:?}");
        }
    }
    assert!(seen_in_all > 10_000, "the pictures see {seen_in_all} cells");
    assert!(at_edge * 100 < seen_in_all, "{at_edge} cells at edges");
}

#[test]
fn pixels_of_an_oblique_picture_grow_with_distance_and_slant() {
    let (target, grid) = field();
    let straight = PictureView {
        time_s: 10.0,
        position: CENTRE,
        altitude_m: 100.0,
        attitude: Attitude::default(),
        angles: GimbalAngles { pan_deg: 0.0, tilt_deg: -90.0 },
        is_stabilised: true,
        wide_deg: 5.0,
        high_deg: 5.0,
        pixel_mrad: 0.2,
    };
    let pixel = |view: &PictureView| {
        let mut looks = TargetLooks::default();
        looks.begin_pass(&grid);
        assert!(add_picture(&mut looks, (&target, &grid), view, facts(), &FlatGround::default(), 0.0));
        let middle = looks.passes[0].looks.iter().map(|look| (look.pixel_along_m, look.pixel_across_m));
        let count = looks.passes[0].looks.len() as f32;
        middle.fold((0.0, 0.0), |sum, pixel| (sum.0 + pixel.0 / count, sum.1 + pixel.1 / count))
    };
    let (along, across) = pixel(&straight);
    assert!((along - 0.02).abs() < 2e-4 && (across - 0.02).abs() < 2e-4, "{along} {across}");
    // 45 degrees off the vertical: sqrt 2 times as far, and twice as long on the ground.
    let (along, across) = pixel(&PictureView { angles: GimbalAngles { pan_deg: 0.0, tilt_deg: -45.0 }, ..straight });
    assert!((along / 0.02 - 1.414).abs() < 0.03 && (across / 0.02 - 2.0).abs() < 0.05, "{along} {across}");
}

fn camera(is_stabilised: bool) -> CameraSetting {
    CameraSetting {
        name: "camera-1".into(),
        wide_deg: 60.0,
        high_deg: 45.0,
        pixel_mrad: 0.2,
        exposure_s: 0.001,
        interval_s_min: 1.0,
        mount: Gimbal { tilt_deg: (-90.0, 30.0), pan_deg: (-180.0, 180.0), rate_deg_s: 90.0, settle_s: 0.4 },
        is_stabilised,
        roll: RollLimits { valid_deg: 10.0, zero_deg: Some(20.0) },
        smear: RateLimits { full_pixels: 1.0, zero_pixels: 4.0 },
        sun_deg_min: Some(0.0),
    }
}

#[test]
fn motion_roll_and_darkness_take_from_a_picture() {
    let motion = ExposureMotion {
        roll_deg: Some(0.0),
        ground_speed_mps: 10.0,
        rotation_rad_s: 0.0,
        slant_m: 50.0,
        sun_deg: Some(30.0),
    };
    let weights = |motion: ExposureMotion| camera(true).weights(&motion);
    assert_eq!(weights(motion), ClarityWeights::CLEAR);
    // 10 m/s past 10 mm pixels for a millisecond is one pixel; 25 m/s are 2.5, in the middle of the ramp.
    assert!((camera(true).smear_pixels(10.0, 0.0, 50.0) - 1.0).abs() < 1e-12);
    assert!((camera(true).ground_speed_mps_max(50.0) - 10.0).abs() < 1e-9);
    assert!((weights(ExposureMotion { ground_speed_mps: 25.0, ..motion }).smear - 0.5).abs() < 1e-9);
    assert_eq!(weights(ExposureMotion { roll_deg: Some(-15.0), ..motion }).roll, 0.5);
    assert_eq!(weights(ExposureMotion { roll_deg: None, ..motion }).attitude_known, 0.0);
    assert_eq!(weights(ExposureMotion { sun_deg: Some(-1.0), ..motion }).exposed, 0.0);
    assert_eq!(weights(ExposureMotion { sun_deg: None, ..motion }).exposed, 1.0);
    // A stabilised mount compensates the rotation of the body, a fixed one does not.
    let turning = ExposureMotion { rotation_rad_s: 0.5, ground_speed_mps: 0.0, ..motion };
    assert_eq!(weights(turning).smear, 1.0);
    assert!((camera(false).weights(&turning).smear - 0.5).abs() < 1e-9);
}
