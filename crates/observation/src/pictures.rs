//! Pictures: the ground that one picture sees, as flown and as planned.
//!
//! Planned and recorded pictures are accumulated by the same code ([`add_picture`]); only the source of position, attitude and
//! weights differs. Bound: O(cells of the footprint) per picture.

use crate::assess::{AssessContext, assess_factors};
use crate::attitude::Attitude;
use crate::clarity::ClarityWeights;
use crate::footprint::{self, Ground};
use crate::grid::TargetGrid;
use crate::look_needs::LookNeeds;
use crate::looks::{SeenGround, StripFacts, TargetLooks};
use crate::plane::Point;
use crate::predict::PredictionContext;
use crate::result::TargetResult;
use crate::sensor::GimbalAngles;
use crate::sensor::camera::sight_of;
use crate::target::ObservedTarget;
use crate::timing::sun::solar_position;
use apex_geo::geodesy::{Position, RAD_PER_DEG};

/// Position and sight line of a camera at the instant of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureView {
    /// Instant of the exposure.
    pub time_s: f64,
    /// Ground point of the vehicle.
    pub position: Position,
    /// Altitude above mean sea level.
    pub altitude_m: f64,
    /// Attitude of the body.
    pub attitude: Attitude,
    /// Angles of the mount.
    pub angles: GimbalAngles,
    /// True if tilt is measured from the horizon and pan from the heading, regardless of the body's attitude.
    pub is_stabilised: bool,
    /// Full field of view along the rows.
    pub wide_deg: f64,
    /// Full field of view along the columns.
    pub high_deg: f64,
    /// Angle of one pixel.
    pub pixel_mrad: f64,
}

/// A planned picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedPicture {
    /// Position and sight line of the camera.
    pub view: PictureView,
    /// Its weights as predicted.
    pub weights: ClarityWeights,
}

impl PictureView {
    /// Returns the positions of the footprint's corners on the ground; empty if the camera looks above the horizon.
    fn footprint(&self, ground: &dyn Ground, fallback_m: f64) -> impl Iterator<Item = Position> {
        let sight = sight_of(&self.attitude, self.angles, self.is_stabilised);
        let (wide_rad, high_rad) = (self.wide_deg * RAD_PER_DEG, self.high_deg * RAD_PER_DEG);
        let rays = footprint::picture_rays(sight, wide_rad, high_rad);
        rays.into_iter().filter_map(move |ray| {
            let hit = footprint::hit_terrain(ray, self.position, self.altitude_m, ground, fallback_m)?;
            Some(footprint::offset_position(self.position, hit.north_m, hit.east_m))
        })
    }
}

/// Adds the ground of a picture to the last pass of `looks`. Returns true if any cell of the target was seen.
pub fn add_picture(
    looks: &mut TargetLooks,
    (target, grid): (&ObservedTarget, &TargetGrid),
    view: &PictureView,
    facts: StripFacts,
    ground: &dyn Ground,
    zero_unix_s: f64,
) -> bool {
    let plane = grid.plane();
    let polygon: Vec<Point> = view.footprint(ground, target.elevation_m).map(|corner| plane.project(corner)).collect();
    let foot = plane.project(view.position);
    let sun = target.is_water.then(|| {
        let sun = solar_position(plane.centre(), zero_unix_s + view.time_s);
        (sun.azimuth_deg, 90.0 - sun.elevation_deg)
    });
    let seen = SeenGround {
        polygon: &polygon,
        foot: [foot, foot],
        altitude_m: [view.altitude_m, view.altitude_m],
        first_line: None,
        last_left: foot,
        pixel_rad: view.pixel_mrad * 1e-3,
        sun,
    };
    let terrain = (grid.slope_max() > 0.0).then_some(ground);
    let needs = LookNeeds { target, centre: plane.centre(), zero_unix_s };
    looks.add_needed(grid, &seen, facts, (terrain, Some(&needs)))
}

/// Returns the result of a target after planned pictures, without the figures of what is seen. Pictures of one pass succeed or fail
/// together, like those of one line; separate passes are independent.
pub fn predict_pictures(
    target: &ObservedTarget,
    grid: &TargetGrid,
    passes: &[Vec<PlannedPicture>],
    context: &PredictionContext<'_>,
) -> TargetResult {
    let mut looks = TargetLooks::default();
    for pass in passes {
        looks.begin_pass(grid);
        for PlannedPicture { view, weights } in pass {
            let air = context.conditions.at(view.position, view.altitude_m, view.time_s);
            let weights = ClarityWeights { clear_share: air.clear_share.clamp(0.0, 1.0), ..*weights };
            let facts = StripFacts { time_s: view.time_s, weights, is_flown: false, on_ground_s: None };
            add_picture(&mut looks, (target, grid), view, facts, context.ground, context.zero_unix_s);
        }
        looks.end_pass();
    }
    let assess_context = AssessContext {
        zero_unix_s: context.zero_unix_s,
        products: context.products,
        first_valid_s: context.first_valid_s,
        is_explained: context.is_explained,
    };
    match context.seen {
        Some(seen) => assess_factors(target, grid, &[seen, &looks], &assess_context),
        None => assess_factors(target, grid, &[&looks], &assess_context),
    }
}
