//! The assumed link level at a place, from the first available source: measured there; a shadow found next to it or above it; stated and
//! corrected; fitted to the measurements.
//!
//! Bound: O(cells x losses) once for each plan, O(log cells + shadows) per place.

use super::learned::{Cells, Learned, LinkCell, Loss, Measured};
use crate::Mission;
use crate::link_map::StatedLink;
use crate::lost_link::LostLink;
use apex_geo::geodesy;
use apex_geo::link::LevelModel;
use apex_model::problem::Position;
use std::collections::BTreeMap;

/// Minimum number of samples in a cell whose mean is used.
const SAMPLES_MIN: u32 = 2;
/// Minimum number of cells by which stated levels are corrected.
const CORRECTED_MIN: usize = 3;
/// Minimum number of cells to which a law is fitted.
const FITTED_MIN: usize = 6;
/// Greatest correction of stated levels by measured ones: a greater difference means another radio.
const CORRECTION_MAX: f64 = 0.3;
/// Least decimal logarithm of the ratio between the greatest and the smallest distance of a fit.
const SPREAD_MIN: f64 = 0.1;
/// Maximum number of cells by which a shadow is assumed to extend beyond its measurements.
const SHADOW_STEPS_MAX: i32 = 4;
/// Level above which a sample does not show how the level falls with distance, so the fit leaves it out.
const SATURATED: f64 = 0.97;

/// A level with its source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Belief {
    /// Mean of the samples in the cell.
    Measured(f64),
    /// Next to, or below, a place with this measured level that no law explains: a shadow has an extent.
    Shadow(f64),
    /// Level by the stated law and shadows, or by a law fitted to the samples; then the distance from the station, m.
    Predicted(f64, f64),
}

impl Belief {
    pub(crate) fn level(self) -> f64 {
        let (Belief::Measured(level) | Belief::Shadow(level) | Belief::Predicted(level, _)) = self;
        level
    }
}

/// Assumptions about one link.
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
    /// Columns of cells in an unknown shadow.
    shadow: BTreeMap<(i32, i32), Shade>,
}

/// A column of cells in a shadow up to a band of altitude, with the nearest measured level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shade {
    pub(crate) top: i32,
    steps: i32,
    level: f64,
}

impl<'a> Beliefs<'a> {
    /// Returns the assumptions about a link, given `learned`.
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
            shadow: BTreeMap::new(),
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
        beliefs.shadow = beliefs.shadows();
        beliefs
    }

    /// Returns the columns in shadows that are known only from measurements. The edge of such a shadow is unknown: for each loss near it,
    /// at most [`SHADOW_STEPS_MAX`], it is assumed one cell farther on all sides, except where the link was good.
    fn shadows(&self) -> BTreeMap<(i32, i32), Shade> {
        let mut shadow: BTreeMap<(i32, i32), Shade> = BTreeMap::new();
        let Some(learned) = self.learned else { return shadow };
        let nominal = self.lost.nominal;
        let is_known = |measured: &&Measured| measured.count() >= SAMPLES_MIN;
        for (cell, measured) in learned.cells() {
            let (middle, altitude_m) = self.cells.middle(*cell);
            let is_explained = || self.by_law(middle, altitude_m).is_some_and(|(level, _)| level < nominal);
            if Some(measured).filter(is_known).is_none() || measured.mean() >= nominal || is_explained() {
                continue;
            }
            let near_m = f64::from(SHADOW_STEPS_MAX + 1) * self.cells.side_m;
            let near = |loss: &&Loss| geodesy::distance_m(loss.here.position, middle) <= near_m;
            let losses = i32::try_from(learned.losses.iter().filter(near).count()).unwrap_or(i32::MAX);
            let reach = losses.min(SHADOW_STEPS_MAX);
            for north in -reach..=reach {
                for east in -reach..=reach {
                    let new = Shade { top: cell.2, steps: north.abs().max(east.abs()), level: measured.mean() };
                    let shade = shadow.entry((cell.0 + north, cell.1 + east)).or_insert(new);
                    let top = shade.top.max(new.top);
                    *shade = Shade { top, ..if new.steps < shade.steps { new } else { *shade } };
                }
            }
        }
        for (cell, _) in learned.cells().iter().filter(|(_, measured)| is_known(measured) && measured.mean() >= nominal)
        {
            let column = (cell.0, cell.1);
            if shadow.get(&column).is_some_and(|shade| shade.steps > 0 && cell.2 <= shade.top) {
                shadow.remove(&column);
            }
        }
        shadow
    }

    /// Returns the highest cell of each column in such a shadow.
    pub(crate) fn shaded(&self) -> impl Iterator<Item = LinkCell> {
        self.shadow.iter().map(|((north, east), shade)| (*north, *east, shade.top))
    }

    /// Returns the level by the stated or the fitted law, with the distance from the station.
    fn by_law(&self, place: Position, altitude_m: f64) -> Option<(f64, f64)> {
        let distance_m = geodesy::distance_m(self.station, place);
        let predicted = match (self.stated, self.fit) {
            (Some(model), _) => {
                let level = model.level(place, altitude_m);
                if level > 0.0 { level + self.correction } else { level }
            }
            (None, Some((a, b))) => a + b * libm::log10(distance_m.max(1.0)),
            (None, None) => return None,
        };
        Some((predicted.clamp(0.0, 1.0), distance_m))
    }

    /// Returns the level at a place; `None` if it is unknown.
    pub(crate) fn at(&self, place: Position, altitude_m: f64) -> Option<Belief> {
        let cell = self.cells.of(place, altitude_m);
        let measured = self.learned.and_then(|learned| learned.cells().get(&cell));
        if let Some(measured) = measured.filter(|measured| measured.count() >= SAMPLES_MIN) {
            return Some(Belief::Measured(measured.mean()));
        }
        if let Some(shade) = self.shadow.get(&(cell.0, cell.1)).filter(|shade| cell.2 <= shade.top) {
            return Some(Belief::Shadow(shade.level));
        }
        self.by_law(place, altitude_m).map(|(level, distance_m)| Belief::Predicted(level, distance_m))
    }

    /// Like [`Beliefs::at`], where the link is weak.
    pub(crate) fn weak_at(&self, place: Position, altitude_m: f64) -> Option<Belief> {
        self.at(place, altitude_m).filter(|belief| belief.level() < self.lost.nominal)
    }
}

/// Returns the least-squares line; `None` if there are too few points, all at about one distance, or the level rises with distance.
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
