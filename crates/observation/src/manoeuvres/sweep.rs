//! Sweep: parallel lines over an area, from the nearest corner, in alternate directions, along the track that is fastest in
//! the wind.
//!
//! A fixed wing turns between lines on the shortest path in the wind; if lines are nearer than two turn radii, it may fly every k-th line
//! instead, if that is faster. Bound: 60 directions with two orders of at most `apex_geo::coverage::SWEEP_LINES_MAX` lines.

use super::refusal::{Limit, Refusal, positive};
use super::scene::Scene;
use super::track::{Element, Sight, Track, lines_with_turns};
use super::{Craft, Instrument};
use apex_geo::coverage::{SweepSettings, sweep_rows};
use apex_geo::geodesy::RAD_PER_DEG;
use apex_geo::plane::Point;
use apex_geo::wind;
use serde::{Deserialize, Serialize};

/// Parallel lines over a polygon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// Corners of the area, metres east and north of the target, in order.
    pub corners: Vec<(f64, f64)>,
    /// Height above the target.
    pub height_m: f64,
    /// Width of the strip that one line sees.
    pub swath_m: f64,
    /// Share of the swath that is seen twice.
    pub sidelap: f64,
    /// Direction of the lines; `None`: the fastest one in the wind.
    pub track_deg: Option<f64>,
    /// Length recorded beyond both ends of each line.
    pub run_in_m: f64,
}

impl Sweep {
    /// Name in PDL.
    pub const NAME: &'static str = "sweep";
    /// Number of candidate directions in addition to those of the edges.
    const DIRECTIONS: u32 = 18;
    /// Difference of two directions that are both tried, degrees, at least.
    const APART_DEG: f64 = 0.5;
    /// Number of directions that are tried, at most.
    const DIRECTIONS_MAX: usize = 60;

    /// Returns the number of lines over a width across the track: `ceil((D - S) / S_p) + 1`; one if the swath is at least as wide.
    pub fn line_count(width_m: f64, swath_m: f64, spacing_m: f64) -> usize {
        if width_m <= swath_m { 1 } else { libm::ceil((width_m - swath_m) / spacing_m - 1e-9) as usize + 1 }
    }

    fn points(&self) -> Vec<Point> {
        self.corners.iter().map(|(x, y)| Point { x: *x, y: *y }).collect()
    }

    /// Returns the sidelap of lines spread evenly over the width: at least the wanted one.
    fn spread_sidelap(&self, track_deg: f64) -> f64 {
        let across = super::scene::along(track_deg + 90.0, 1.0);
        let sides = self.points().into_iter().map(|point| point.dot(across));
        let (low, high) =
            sides.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), side| (low.min(side), high.max(side)));
        let count = Self::line_count(high - low, self.swath_m, self.swath_m * (1.0 - self.sidelap));
        if count < 2 {
            return self.sidelap;
        }
        let spacing_m = (high - low - self.swath_m) / (count - 1) as f64 * (1.0 + SPREAD_SHARE);
        (1.0 - spacing_m / self.swath_m).max(self.sidelap)
    }

    /// Returns the lines in one direction, from the corner nearest to the approach.
    ///
    /// # Errors
    /// The area has no extent, or the lines are too many.
    pub fn lines(&self, track_deg: f64, scene: &Scene) -> Result<Vec<(Point, Point)>, Refusal> {
        let settings = SweepSettings {
            swath_m: self.swath_m,
            overlap: self.spread_sidelap(track_deg),
            track_deg: Some(track_deg),
            run_in_m: self.run_in_m,
        };
        sweep_rows(&self.points(), &settings, scene.approach).map_err(|why| {
            let limit = Limit { manoeuvre: Self::NAME, figure: "a swath", unit: "m" };
            limit.refusal(self.swath_m, 0.0, &why, "give an area of at least three corners".to_string())
        })
    }

    /// Returns the directions of edges, directions at right angles to them, and others.
    fn directions_deg(&self) -> Vec<f64> {
        let points = self.points();
        let edges = points.iter().zip(points.iter().cycle().skip(1)).filter_map(|(from, to)| {
            let step = to.minus(*from);
            (step.length() > 1e-6).then(|| libm::atan2(step.x, step.y) / RAD_PER_DEG)
        });
        let mut all: Vec<f64> = edges.flat_map(|edge| [edge, edge + 90.0]).map(|deg| deg.rem_euclid(180.0)).collect();
        all.extend((0..Self::DIRECTIONS).map(|index| f64::from(index) * 180.0 / f64::from(Self::DIRECTIONS)));
        all.sort_by(f64::total_cmp);
        all.dedup_by(|next, before| *next - *before < Self::APART_DEG);
        // Areas with many corners: directions from all around, so that each one left out is close to one that is tried.
        if all.len() > Self::DIRECTIONS_MAX {
            let apart_deg = 180.0 / Self::DIRECTIONS_MAX as f64;
            all.dedup_by(|next, before| *next - *before < apart_deg);
        }
        all
    }

    /// Returns the time of the lines and the turns between them; infinite if the wind is too strong.
    fn time_s(&self, lines: &[(Point, Point)], airspeed_mps: f64, craft: &Craft, scene: &Scene) -> f64 {
        let each = lines.iter().map(|(from, to)| {
            let step = to.minus(*from);
            let track_deg = libm::atan2(step.x, step.y) / RAD_PER_DEG;
            let triangle = wind::triangle(track_deg, airspeed_mps, scene.wind);
            triangle.map_or(f64::INFINITY, |triangle| step.length() / triangle.ground_speed_mps)
        });
        each.sum::<f64>() + turns_s(lines, airspeed_mps, craft, scene)
    }

    /// Returns the lines in the order flown, in the fastest direction.
    ///
    /// # Errors
    /// Like [`Sweep::lines`].
    pub fn best_lines(&self, airspeed_mps: f64, craft: &Craft, scene: &Scene) -> Result<Vec<(Point, Point)>, Refusal> {
        let directions = self.track_deg.map_or_else(|| self.directions_deg(), |track_deg| vec![track_deg]);
        let mut best: Option<(f64, Vec<(Point, Point)>)> = None;
        for track_deg in directions {
            let plain = self.lines(track_deg, scene)?;
            let skipping = skip_order(&plain, airspeed_mps, craft);
            for lines in std::iter::once(plain).chain(skipping) {
                let time_s = self.time_s(&lines, airspeed_mps, craft, scene);
                if best.as_ref().is_none_or(|(least_s, _)| time_s < *least_s - 1e-9) {
                    best = Some((time_s, lines));
                }
            }
        }
        Ok(best.map_or_else(Vec::new, |(_, lines)| lines))
    }

    pub(crate) fn check(&self) -> Result<(), Refusal> {
        positive(Self::NAME, "a height", "m", self.height_m)?;
        positive(Self::NAME, "a swath", "m", self.swath_m)?;
        let limit = Limit { manoeuvre: Self::NAME, figure: "a sidelap", unit: "" };
        limit.at_least(self.sidelap, 0.0, "lines would leave gaps", || "0 works".to_string())?;
        limit.at_most(self.sidelap, 0.9, "it would take too many lines", || "0.9 works".to_string())
    }

    pub(crate) fn track(
        &self,
        airspeed_mps: f64,
        craft: &Craft,
        _: &Instrument,
        scene: &Scene,
    ) -> Result<Track, Refusal> {
        self.check()?;
        let lines = self.best_lines(airspeed_mps, craft, scene)?;
        let elements: Vec<Element> = lines_with_turns(Self::NAME, &lines, self.height_m, airspeed_mps, craft, scene)?;
        Ok(Track { elements, sight: Sight::Down })
    }
}

/// Share by which lines are spread wider than the width: lengths on the plane of `sweep_lines` and on the ellipsoid differ by 0.3 %.
const SPREAD_SHARE: f64 = 6e-3;

/// Returns the time of the turns between successive lines, lead-ins included.
fn turns_s(lines: &[(Point, Point)], airspeed_mps: f64, craft: &Craft, scene: &Scene) -> f64 {
    let mut total_s = 0.0;
    for pair in lines.windows(2) {
        let [(from, exit), (next, to)] = pair else { continue };
        total_s += match craft.can_hover {
            true => next.minus(*exit).length() / airspeed_mps + airspeed_mps / craft.braking_mps2,
            false => turn_s((*from, *exit), (*next, *to), airspeed_mps, craft, scene),
        };
    }
    total_s
}

/// Returns the time of a fixed wing's fastest turn from the end of a line to the lead-in of another, plus that of the lead-in.
pub fn turn_s(
    (from, exit): (Point, Point),
    (next, to): (Point, Point),
    airspeed_mps: f64,
    craft: &Craft,
    scene: &Scene,
) -> f64 {
    let flyer = super::track::flyer(airspeed_mps, craft, scene);
    let (out, along) = (exit.minus(from), to.minus(next));
    let lead_m = craft.settle_s * airspeed_mps;
    let direction = along.unit().unwrap_or(Point { x: 0.0, y: 1.0 });
    let pose = |point: Point, toward: Point| apex_geo::travel::Pose {
        point,
        track_rad: Some(libm::atan2(toward.y, toward.x)),
    };
    let path = flyer.paths(pose(exit, out), pose(next.plus(-lead_m, direction), along));
    let track_deg = libm::atan2(along.x, along.y) / RAD_PER_DEG;
    let lead_s = wind::triangle(track_deg, airspeed_mps, scene.wind).map(|found| lead_m / found.ground_speed_mps);
    match (path.first(), lead_s) {
        (Some(path), Some(lead_s)) => path.time_s + lead_s,
        _ => f64::INFINITY,
    }
}

/// Returns an order that flies every k-th line first, so that turns are at least two radii wide; `None` if the lines are far enough apart
/// or few.
fn skip_order(lines: &[(Point, Point)], airspeed_mps: f64, craft: &Craft) -> Option<Vec<(Point, Point)>> {
    let (first, second) = (lines.first()?, lines.get(1)?);
    let along = first.1.minus(first.0).unit()?;
    let spacing_m = second.0.minus(first.0).cross(along).abs();
    let wanted_m = 2.0 * craft.turn_radius_m(airspeed_mps);
    if craft.can_hover || spacing_m >= wanted_m || spacing_m <= 0.0 || lines.len() < 3 {
        return None;
    }
    let step = (libm::ceil(wanted_m / spacing_m) as usize).min(lines.len() - 1);
    let mut order = Vec::new();
    for begin in 0..step {
        let column: Vec<usize> = (begin..lines.len()).step_by(step).collect();
        order.extend(if begin % 2 == 0 { column } else { column.into_iter().rev().collect() });
    }
    let towards = |line: &(Point, Point)| line.1.minus(line.0).dot(along) > 0.0;
    let flown = order.into_iter().enumerate().filter_map(|(number, index)| {
        let line = *lines.get(index)?;
        Some(if towards(&line) == (number % 2 == 0) { line } else { (line.1, line.0) })
    });
    Some(flown.collect())
}
