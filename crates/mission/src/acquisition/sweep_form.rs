//! The sweep as a form: parallel lines over the ground of the target, or over a rectangle around its middle.
//!
//! Bound: O(corners of the ground).

use super::form::Form;
use apex_geo::geodesy;
use apex_geo::geodesy::RAD_PER_DEG;
use apex_model::quantity::Dimension;
use apex_observation::manoeuvres::{Instrument, Scene, Sweep};
use apex_observation::target::TargetArea;

/// Share of the swath that neighbouring lines both see, unless a form states another.
pub(super) const SIDELAP: f64 = 0.15;
/// Length of the lines beyond the ground as a share of the footprint along the track, with its limits.
const RUN_IN_SHARE: f64 = 0.3;
const RUN_IN_M: (f64, f64) = (2.0, 2_000.0);
/// Corners of the polygon around ground that is not a polygon.
const CORNERS: u32 = 8;

/// The ground that a form refers to, and the sensor that sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SweptGround<'a> {
    /// Name of the target.
    pub(crate) target: &'a str,
    /// Metres east and north of its middle; empty for a point.
    pub(crate) corners: &'a [(f64, f64)],
    pub(crate) instrument: &'a Instrument,
}

/// Returns the corners of an area around a place, metres east and north of it: those of its polygons, otherwise of a polygon that contains
/// everything within `radius_m`; none for a point.
pub(crate) fn corners_of(area: &TargetArea, scene: &Scene, radius_m: f64) -> Vec<(f64, f64)> {
    match area {
        TargetArea::Polygons(polygons) | TargetArea::Perimeter { polygons, .. } => {
            let outer = polygons.iter().flat_map(|polygon| polygon.outer.iter());
            outer.map(|corner| scene.point(*corner)).map(|point| (point.x, point.y)).collect()
        }
        TargetArea::Point(_) => Vec::new(),
        TargetArea::Circle { .. } | TargetArea::Line(_) => {
            let step_rad = 2.0 * std::f64::consts::PI / f64::from(CORNERS);
            let corner = |index: u32| {
                let angle = f64::from(index) * step_rad;
                (radius_m * libm::sin(angle), radius_m * libm::cos(angle))
            };
            (0..CORNERS).map(corner).collect()
        }
    }
}

/// Returns the greatest distance of the ground of a target from its middle.
pub(crate) fn radius_m(middle: geodesy::Position, grid: &apex_observation::grid::TargetGrid) -> f64 {
    grid.positions().map(|cell| geodesy::distance_m(middle, cell)).fold(0.0, f64::max)
}

/// Returns the length of lines beyond both ends of the ground, by which pictures at the ends are complete.
pub(super) fn run_in_m(instrument: &Instrument, height_m: f64) -> f64 {
    match instrument {
        Instrument::Camera(camera) => (camera.footprint_m(height_m).1 * RUN_IN_SHARE).clamp(RUN_IN_M.0, RUN_IN_M.1),
        Instrument::Scanner(_) => 0.0,
    }
}

/// Reads `(sweep :height H [:length L :width W [:axis A]] [:track A] [:sidelap S] [:swath W] [:run-in L])`.
///
/// # Errors
/// The missing or wrongly typed argument; a point without length and width.
pub(super) fn read_sweep(form: &mut Form<'_>, ground: &SweptGround<'_>) -> Result<Sweep, String> {
    let height_m = form.length("height")?;
    let metres = |form: &mut Form<'_>, key: &'static str| form.number(key, Dimension::LENGTH, 1.0);
    let (length_m, width_m) = (metres(form, "length")?, metres(form, "width")?);
    let axis_deg = form.angle_deg("axis", Some(0.0))?;
    let corners = match (length_m, width_m) {
        (Some(length_m), Some(width_m)) if length_m > 0.0 && width_m > 0.0 => rectangle(length_m, width_m, axis_deg),
        (None, None) if !ground.corners.is_empty() => ground.corners.to_vec(),
        (None, None) => {
            return Err(format!(
                "`{}` is a point; add `:length` and `:width` to `sweep`, such as `:length 200m :width 100m`",
                ground.target
            ));
        }
        _ => {
            return Err(
                "`:length` and `:width` of `sweep` are both positive, or both left out for the ground of the target"
                    .to_string(),
            );
        }
    };
    let swath_m = metres(form, "swath")?;
    let run_in = metres(form, "run-in")?;
    Ok(Sweep {
        corners,
        height_m,
        swath_m: swath_m.unwrap_or_else(|| ground.instrument.swath_m(height_m, f64::INFINITY)),
        sidelap: form.number("sidelap", Dimension::NONE, 1.0)?.unwrap_or(SIDELAP),
        track_deg: form.optional_angle_deg("track")?,
        run_in_m: run_in.unwrap_or_else(|| run_in_m(ground.instrument, height_m)),
    })
}

/// Returns the corners of a rectangle around the middle, its length along an azimuth.
fn rectangle(length_m: f64, width_m: f64, axis_deg: f64) -> Vec<(f64, f64)> {
    let (sine, cosine) = (libm::sin(axis_deg * RAD_PER_DEG), libm::cos(axis_deg * RAD_PER_DEG));
    let corner = |(along, across): (f64, f64)| {
        let (along_m, across_m) = (0.5 * along * length_m, 0.5 * across * width_m);
        (along_m * sine + across_m * cosine, along_m * cosine - across_m * sine)
    };
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(corner).to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_lies_along_its_axis() {
        let near = |found: (f64, f64), expected: (f64, f64)| {
            (found.0 - expected.0).abs() < 1e-9 && (found.1 - expected.1).abs() < 1e-9
        };
        let east = rectangle(200.0, 100.0, 90.0);
        assert!(
            [(-100.0, 50.0), (100.0, 50.0), (100.0, -50.0), (-100.0, -50.0)]
                .iter()
                .zip(&east)
                .all(|(a, b)| near(*b, *a)),
            "{east:?}"
        );
    }
}
