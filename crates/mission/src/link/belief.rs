//! The level that is assumed at a place: measured there, else as stated and corrected, else fitted to what was measured.
//!
//! Bound: O(cells) once for each plan, O(log cells + shadows) per place.

use super::learned::{Cells, Learned};
use crate::Mission;
use crate::link_map::StatedLink;
use crate::lost_link::LostLink;
use apex_geo::geodesy;
use apex_geo::link::LevelModel;
use apex_model::problem::Position;

/// Samples from which the mean of a cell is used.
const SAMPLES_MIN: u32 = 2;
/// Cells from which a level is corrected, and to which a law is fitted, at least.
const CORRECTED_MIN: usize = 3;
const FITTED_MIN: usize = 6;
/// Measured levels correct the stated ones by this at most: more is another radio.
const CORRECTION_MAX: f64 = 0.3;
/// Distances of a fit must differ by this factor (decimal logarithm).
const SPREAD_MIN: f64 = 0.1;
/// Near full level the law is not seen.
const SATURATED: f64 = 0.97;

/// A level and how it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Belief {
    /// Mean of the samples in the cell.
    Measured(f64),
    /// By the stated law and shadows, or a law fitted to the samples; at this distance from the station, m.
    Predicted(f64, f64),
}

impl Belief {
    pub(crate) fn level(self) -> f64 {
        let (Belief::Measured(level) | Belief::Predicted(level, _)) = self;
        level
    }
}

/// What is assumed of one link.
pub(crate) struct Beliefs<'a> {
    pub(crate) name: &'a str,
    pub(crate) cells: Cells,
    pub(crate) learned: Option<&'a Learned>,
    pub(crate) stated: Option<&'a LevelModel>,
    pub(crate) lost: &'a LostLink,
    station: Position,
    /// Added to stated levels.
    correction: f64,
    /// `level = a + b log10(distance in m)`.
    fit: Option<(f64, f64)>,
}

impl<'a> Beliefs<'a> {
    /// What is assumed of a link after what `learned` says.
    pub(crate) fn new(mission: &'a Mission, link: &'a StatedLink, learned: Option<&'a Learned>) -> Beliefs<'a> {
        let cells = Cells::new(mission.start, mission.model.true_airspeed_m_s_cruise);
        let stated = link.level.as_ref();
        let mut beliefs = Beliefs {
            name: &link.name,
            cells,
            learned,
            stated,
            lost: &mission.lost_link,
            station: link.station,
            correction: 0.0,
            fit: None,
        };
        // Shadows do not belong to the law: only cells where the link works count.
        let heard: Vec<(Position, f64, f64)> = learned
            .iter()
            .flat_map(|learned| learned.cells())
            .filter(|(_, measured)| measured.count() >= SAMPLES_MIN && measured.mean() >= mission.lost_link.nominal)
            .map(|(cell, measured)| {
                let (middle, altitude_m) = cells.middle(*cell);
                (middle, altitude_m, measured.mean())
            })
            .collect();
        match stated {
            Some(model) if heard.len() >= CORRECTED_MIN => {
                let off = heard.iter().map(|(place, altitude_m, level)| level - model.level(*place, *altitude_m));
                let mean = off.sum::<f64>() / heard.len() as f64;
                beliefs.correction = mean.clamp(-CORRECTION_MAX, CORRECTION_MAX);
            }
            Some(_) => {}
            None => {
                let points = heard
                    .iter()
                    .filter(|(.., level)| *level <= SATURATED)
                    .map(|(place, _, level)| (libm::log10(geodesy::distance_m(link.station, *place).max(1.0)), *level));
                beliefs.fit = line(&points.collect::<Vec<_>>());
            }
        }
        beliefs
    }

    /// The level at a place; `None` if nothing is known of it.
    pub(crate) fn at(&self, place: Position, altitude_m: f64) -> Option<Belief> {
        let measured = self.learned.and_then(|learned| learned.cells().get(&self.cells.of(place, altitude_m)));
        if let Some(measured) = measured.filter(|measured| measured.count() >= SAMPLES_MIN) {
            return Some(Belief::Measured(measured.mean()));
        }
        let distance_m = geodesy::distance_m(self.station, place);
        let predicted = match (self.stated, self.fit) {
            (Some(model), _) => {
                let level = model.level(place, altitude_m);
                if level > 0.0 { level + self.correction } else { level }
            }
            (None, Some((a, b))) => a + b * libm::log10(distance_m.max(1.0)),
            (None, None) => return None,
        };
        Some(Belief::Predicted(predicted.clamp(0.0, 1.0), distance_m))
    }

    /// As [`Beliefs::at`], where the link is weak.
    pub(crate) fn weak_at(&self, place: Position, altitude_m: f64) -> Option<Belief> {
        self.at(place, altitude_m).filter(|belief| belief.level() < self.lost.nominal)
    }
}

/// The line of least squares; `None` for too few points, all at about one distance, or a level that rises with it.
fn line(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let (low, high) = points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), (x, _)| (l.min(*x), h.max(*x)));
    if points.len() < FITTED_MIN || high - low < SPREAD_MIN {
        return None;
    }
    let count = points.len() as f64;
    let (x_mean, y_mean) = points.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0 / count, y + point.1 / count));
    let square: f64 = points.iter().map(|(x, _)| (x - x_mean) * (x - x_mean)).sum();
    let product: f64 = points.iter().map(|(x, y)| (x - x_mean) * (y - y_mean)).sum();
    let slope = product / square;
    (slope < 0.0).then_some((y_mean - slope * x_mean, slope))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_is_fitted_to_levels_that_fall_with_distance() {
        let points: Vec<(f64, f64)> =
            (1..=8).map(|step| (2.5 + 0.1 * f64::from(step), 0.9 - 0.06 * f64::from(step))).collect();
        let (a, b) = line(&points).unwrap_or_default();
        assert!((b + 0.6).abs() < 1e-9 && (a + b * 3.0 - 0.6).abs() < 1e-9, "{a} {b}");
        assert_eq!(line(&points[..4]), None, "too few");
        let rising: Vec<(f64, f64)> = points.iter().map(|(x, y)| (*x, 1.0 - y)).collect();
        assert_eq!(line(&rising), None);
        assert_eq!(line(&[(3.0, 0.5); 9]), None, "one distance");
    }
}
