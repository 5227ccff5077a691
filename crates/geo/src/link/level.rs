//! Signal level of a ground radio at a place: it falls with distance, and further inside of shadows.
//!
//! A level is 0 (no signal) to 1 (full). The simulated world and the planner's assumption are two values of the same type: the flight
//! learns the levels of the world that the mission does not state.
//! Bound: O(shadows x corners) per level.

use super::budget::FULL_LEVEL_DB;
use super::diffraction::{knife_edge_loss_db, knife_edge_nu};
use super::path_loss::wavelength_m;
use crate::geodesy::{self, Position};
use crate::plane::{self, Plane};
use serde::{Deserialize, Serialize};

/// Path-loss exponent of a radio over open ground: 2 is free space, 4 flat earth (Rappaport, "Wireless Communications", 4.9).
pub const EXPONENT: f64 = 2.4;
/// Carrier frequency of the paper's modem, Hz, which determines the loss at a ridge.
const FREQUENCY_HZ: f64 = 915e6;

/// Law by which a level falls with the distance from the station.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum LevelLaw {
    /// Full everywhere: a satellite link.
    Constant,
    /// Full up to `full_level_m`, then falls with the logarithm of the distance, 0 from `range_m` on.
    Logarithmic {
        /// Distance at which the level is still 1, m.
        full_level_m: f64,
        /// Distance from which on the level is 0, m; greater than `full_level_m`.
        range_m: f64,
    },
    /// Pairs `(distance_m, level)` by rising distance: straight lines between, constant before the first and after the last.
    Table(Vec<(f64, f64)>),
}

impl LevelLaw {
    /// Returns the logarithmic law of a path-loss exponent: [`FULL_LEVEL_DB`] from full level down to nothing.
    pub fn with_exponent(full_level_m: f64, exponent: f64) -> LevelLaw {
        LevelLaw::Logarithmic {
            full_level_m,
            range_m: full_level_m * libm::pow(10.0, FULL_LEVEL_DB / (10.0 * exponent)),
        }
    }

    /// Returns the level at a distance from the station.
    pub fn level(&self, distance_m: f64) -> f64 {
        match self {
            LevelLaw::Constant => 1.0,
            LevelLaw::Logarithmic { full_level_m, range_m } => {
                let ratio = (distance_m / full_level_m).max(1.0);
                (1.0 - libm::log(ratio) / libm::log(range_m / full_level_m)).clamp(0.0, 1.0)
            }
            LevelLaw::Table(points) => {
                let after = points.iter().position(|(far_m, _)| distance_m < *far_m);
                let before =
                    after.map_or(points.len(), |after| after).checked_sub(1).and_then(|index| points.get(index));
                match (before, after.and_then(|after| points.get(after))) {
                    (Some((near_m, near)), Some((far_m, far))) => {
                        near + (far - near) * (distance_m - near_m) / (far_m - near_m)
                    }
                    (Some((_, level)), None) | (None, Some((_, level))) => *level,
                    (None, None) => 0.0,
                }
            }
        }
    }
}

/// Area in which a radio link is weakened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shadow {
    /// Its place and shape.
    pub shape: ShadowShape,
    /// Above this altitude the station is in sight again, m above mean sea level; infinite for a shadow without upper end.
    pub altitude_m_max: f64,
    /// Factor of the level inside, 0 to 1; not used by a ridge, whose loss is computed.
    pub factor: f64,
}

/// Place and shape of a shadow.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ShadowShape {
    /// A disc.
    Disc {
        /// Its middle.
        position: Position,
        /// Its radius, m.
        radius_m: f64,
    },
    /// The inside of a polygon.
    Polygon(Vec<Position>),
    /// Directions seen from the station, clockwise from `from_deg` to `to_deg`, farther away than `beyond_m`.
    Sector {
        /// First direction, degrees from north.
        from_deg: f64,
        /// Last direction, degrees from north.
        to_deg: f64,
        /// Begin, m from the station.
        beyond_m: f64,
    },
    /// The edge of a hill: behind it, and below the line of sight over it, the level falls by diffraction at a knife edge
    /// (ITU-R P.526).
    Ridge {
        /// Its ends.
        ends: (Position, Position),
        /// Altitude of the edge above mean sea level, m.
        top_m: f64,
    },
}

/// Levels of one radio link by place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LevelModel {
    /// Position of the ground station; `None` for a satellite link.
    pub station: Option<Position>,
    /// Altitude of its antenna above mean sea level, m.
    pub station_altitude_m: f64,
    /// Fall of the level with distance.
    pub law: LevelLaw,
    /// Areas with a weakened signal.
    pub shadows: Vec<Shadow>,
}

impl LevelModel {
    /// Returns a satellite link.
    pub fn satellite() -> LevelModel {
        LevelModel { station: None, station_altitude_m: 0.0, law: LevelLaw::Constant, shadows: Vec::new() }
    }

    /// Returns a ground radio with its antenna at sea level and the exponent of open ground.
    pub fn at_station(station: Position, full_level_m: f64) -> LevelModel {
        let law = LevelLaw::with_exponent(full_level_m, EXPONENT);
        LevelModel { station: Some(station), station_altitude_m: 0.0, law, shadows: Vec::new() }
    }

    /// Returns the level at a place, 0 to 1.
    pub fn level(&self, here: Position, altitude_m: f64) -> f64 {
        let distance_m = self.station.map_or(0.0, |station| geodesy::distance_m(station, here));
        let mut level = self.law.level(distance_m);
        for shadow in self.shadows.iter().filter(|shadow| altitude_m < shadow.altitude_m_max) {
            if let ShadowShape::Ridge { ends, top_m } = &shadow.shape {
                level -= self.ridge_db(*ends, *top_m, here, altitude_m) / FULL_LEVEL_DB;
            } else if self.is_inside(&shadow.shape, here, distance_m) {
                level *= shadow.factor;
            }
        }
        level.clamp(0.0, 1.0)
    }

    fn is_inside(&self, shape: &ShadowShape, here: Position, distance_m: f64) -> bool {
        match shape {
            ShadowShape::Disc { position, radius_m } => geodesy::distance_m(*position, here) < *radius_m,
            ShadowShape::Polygon(corners) => {
                let plane = Plane::around(corners);
                let flat: Option<Vec<_>> = corners.iter().map(|corner| plane.project(*corner)).collect();
                flat.zip(plane.project(here)).is_some_and(|(flat, here)| plane::inside(here, &flat))
            }
            ShadowShape::Sector { from_deg, to_deg, beyond_m } => self.station.is_some_and(|station| {
                let off_deg = geodesy::wrap_360(geodesy::azimuth_deg(station, here) - from_deg);
                distance_m > *beyond_m && off_deg <= geodesy::wrap_360(to_deg - from_deg)
            }),
            ShadowShape::Ridge { .. } => false,
        }
    }

    /// Returns the loss at a ridge between the station and a place, dB; 0 if the line of sight does not cross it.
    fn ridge_db(&self, ends: (Position, Position), top_m: f64, here: Position, altitude_m: f64) -> f64 {
        let Some(station) = self.station else { return 0.0 };
        let plane = Plane::new(station);
        let flat = plane.project(here).zip(plane.project(ends.0)).zip(plane.project(ends.1));
        let Some(((here, first), second)) = flat else { return 0.0 };
        let along = second.minus(first);
        let turn = here.cross(along);
        if turn == 0.0 {
            return 0.0;
        }
        // The line of sight is `share x here`, the ridge `first + part x along`.
        let (share, part) = (first.cross(along) / turn, first.cross(here) / turn);
        if !(0.0..1.0).contains(&share) || !(0.0..=1.0).contains(&part) || share == 0.0 {
            return 0.0;
        }
        let length_m = here.length();
        let line_m = self.station_altitude_m + share * (altitude_m - self.station_altitude_m);
        let (before_m, behind_m) = (share * length_m, (1.0 - share) * length_m);
        knife_edge_loss_db(knife_edge_nu(top_m - line_m, before_m, behind_m, wavelength_m(FREQUENCY_HZ)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn east(metres: f64) -> Position {
        geodesy::destination(station(), 90.0, metres)
    }

    fn station() -> Position {
        Position::new(36.0, -121.0)
    }

    #[test]
    fn levels_fall_with_distance_by_each_law() {
        let log = LevelLaw::with_exponent(1_000.0, 2.4);
        // 24 log10(10) = 24 dB of 40.
        assert!((log.level(10_000.0) - 0.4).abs() < 1e-12);
        assert_eq!((log.level(0.0), log.level(1_000.0), log.level(1e6)), (1.0, 1.0, 0.0));
        let table = LevelLaw::Table(vec![(1_000.0, 1.0), (2_000.0, 0.5), (3_000.0, 0.0)]);
        let levels = [0.0, 1_000.0, 1_500.0, 2_500.0, 3_000.0, 9_000.0].map(|far_m| table.level(far_m));
        assert_eq!(levels, [1.0, 1.0, 0.75, 0.25, 0.0, 0.0]);
        assert_eq!(LevelLaw::Constant.level(1e7), 1.0);
    }

    #[test]
    fn shadows_weaken_where_they_lie_and_below_their_top() {
        let mut model = LevelModel::at_station(station(), 5_000.0);
        let shadow = |shape| Shadow { shape, altitude_m_max: 200.0, factor: 0.25 };
        let corners = [(45.0, 2_000.0), (135.0, 2_000.0), (100.0, 4_000.0), (80.0, 4_000.0)];
        let corners = corners.map(|(deg, far_m)| geodesy::destination(station(), deg, far_m));
        let shapes = [
            ShadowShape::Disc { position: east(3_000.0), radius_m: 500.0 },
            ShadowShape::Polygon(corners.to_vec()),
            ShadowShape::Sector { from_deg: 350.0, to_deg: 100.0, beyond_m: 1_500.0 },
        ];
        for shape in shapes {
            model.shadows = vec![shadow(shape)];
            assert_eq!(model.level(east(3_000.0), 100.0), 0.25, "{model:?}");
            assert_eq!((model.level(east(3_000.0), 200.0), model.level(east(1_000.0), 100.0)), (1.0, 1.0), "{model:?}");
        }
    }

    #[test]
    fn a_ridge_shades_what_lies_behind_it_and_low() {
        let mut model = LevelModel::at_station(station(), 10_000.0);
        let side = |deg| geodesy::destination(east(1_000.0), deg, 500.0);
        let shape = ShadowShape::Ridge { ends: (side(0.0), side(180.0)), top_m: 40.0 };
        model.shadows = vec![Shadow { shape, altitude_m_max: f64::INFINITY, factor: 1.0 }];
        // The edge is 20 m above the line over 1 + 1 km: 19.9 dB (ITU-R P.526 with 915 MHz).
        let level = model.level(east(2_000.0), 40.0);
        assert!((level - (1.0 - 19.9 / 40.0)).abs() < 0.003, "{level}");
        assert_eq!((model.level(east(900.0), 40.0), model.level(east(2_000.0), 400.0)), (1.0, 1.0));
        assert_eq!(model.level(geodesy::destination(station(), 45.0, 2_000.0), 40.0), 1.0, "past its end");
    }
}
