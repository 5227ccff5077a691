//! Configuration of a simulated world: vehicle, start, weather, ground, radios, places and scripted events, as plain data.

use crate::living::{BurnableSite, BurningTarget, LivingWorld};
use apex_geo::geodesy;
use apex_geo::link::{LevelLaw, LevelModel};
use apex_geo::terrain::Terrain;
use apex_model::event::StateVariable;
use apex_model::problem::{Position, WindField};
use apex_model::time::Time;
use apex_model::value::Value;
use apex_vehicle::VehicleModel;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Everything that [`crate::SimulatedWorld::new`] needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WorldConfig {
    /// The vehicle's name: the object of its state variables, for example `aircraft-1`.
    pub vehicle: String,
    /// Model of the vehicle.
    pub model: VehicleModel,
    /// Position and motion of the vehicle at mission time zero.
    pub start: Start,
    /// Seeds turbulence and radio fading.
    pub seed: u64,
    /// The wind that truly blows.
    pub wind: WindField,
    /// Elevation of the ground.
    pub ground: Ground,
    /// Radios.
    pub modems: Vec<Modem>,
    /// Targets, airfields and other places that commands may name.
    pub places: Vec<NamedPlace>,
    /// Scripted events of the world: fires that appear, grow or are sighted.
    pub events: Vec<ScheduledEvent>,
    /// Failures, moving weather, fires; `None` for a world without them.
    pub living: Option<LivingWorld>,
    /// Structures at which fires may break out.
    pub sites: Vec<BurnableSite>,
    /// Fires with an outline, which may grow.
    pub burning: Vec<BurningTarget>,
    /// Civil time of mission time zero, seconds since 1970-01-01T00:00Z; without it there is no sun.
    pub epoch_unix_s: Option<f64>,
}

impl WorldConfig {
    /// Returns a world with still air, without radios, over ground at the start's elevation (for a start in the air: at sea level).
    pub fn new(vehicle: &str, model: VehicleModel, start: Start) -> WorldConfig {
        let elevation_m = if start.airborne { 0.0 } else { start.altitude_m };
        WorldConfig {
            vehicle: vehicle.to_owned(),
            model,
            start,
            seed: 0,
            wind: WindField::default(),
            ground: Ground { elevation_m, ..Ground::default() },
            modems: Vec::new(),
            places: Vec::new(),
            events: Vec::new(),
            living: None,
            sites: Vec::new(),
            burning: Vec::new(),
            epoch_unix_s: None,
        }
    }

    /// Checks everything that a user may have written.
    ///
    /// # Errors
    /// A message that names the invalid value.
    pub(crate) fn check(&self) -> Result<(), String> {
        self.model.validate(&self.model.name).map_err(|error| error.to_string())?;
        if self.vehicle.trim().is_empty() {
            return Err("the vehicle needs a name".to_owned());
        }
        let start = &self.start;
        check_position("the vehicle's start", start.position)?;
        check_finite("the start's altitude_m", start.altitude_m)?;
        check_finite("the start's heading_deg", start.heading_deg)?;
        if start.airborne && start.altitude_m > self.model.ceiling_m {
            let (altitude, ceiling, name) = (start.altitude_m, self.model.ceiling_m, &self.model.name);
            return Err(format!("the start at {altitude} m is above the {ceiling} m that {name} can hold"));
        }
        if let Some(share) = start.fuel_share
            && !(0.0..=1.0).contains(&share)
        {
            return Err(format!("the start's fuel_share is {share}; it must be between 0 and 1"));
        }
        check_finite("the ground's elevation_m", self.ground.elevation_m)?;
        for patch in &self.ground.patches {
            check_position("a patch of ground", patch.position)?;
            check_finite("a ground patch's elevation_m", patch.elevation_m)?;
            check_finite("a ground patch's radius_m", patch.radius_m)?;
        }
        for place in &self.places {
            check_position(&format!("place `{}`", place.name), place.position)?;
        }
        self.modems.iter().try_for_each(Modem::check)?;
        self.check_living()
    }

    /// Checks the dynamic world against the vehicle, the radios and the structures.
    ///
    /// # Errors
    /// An error message with the field and a valid value.
    pub fn check_living(&self) -> Result<(), String> {
        self.living.as_ref().map_or(Ok(()), |living| living.check(self))
    }
}

fn check_position(what: &str, position: Position) -> Result<(), String> {
    let Position { latitude_deg, longitude_deg } = position;
    if latitude_deg.is_nan() || latitude_deg.abs() > 89.9 {
        return Err(format!("{what} has latitude {latitude_deg}; it must be between -89.9 and 89.9 degrees"));
    }
    if longitude_deg.is_nan() || longitude_deg.abs() > 360.0 {
        return Err(format!("{what} has longitude {longitude_deg}; it must be between -180 and 180 degrees"));
    }
    Ok(())
}

fn check_finite(what: &str, number: f64) -> Result<(), String> {
    if number.is_finite() { Ok(()) } else { Err(format!("{what} is {number}; it must be a finite number")) }
}

/// Initial position and motion of the vehicle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Start {
    /// Position.
    pub position: Position,
    /// Altitude above mean sea level; for a start on the ground the field's elevation.
    pub altitude_m: f64,
    /// Direction of the nose, clockwise from true north.
    pub heading_deg: f64,
    /// True: in flight at cruise speed; false: parked.
    pub airborne: bool,
    /// Share of the fuel capacity on board; `None` is full.
    pub fuel_share: Option<f64>,
}

impl Start {
    /// Returns a start on a field at `elevation_m`, with the nose towards `heading_deg` (the direction of the take-off).
    pub fn on_ground(latitude_deg: f64, longitude_deg: f64, elevation_m: f64, heading_deg: f64) -> Start {
        let position = Position::new(latitude_deg, longitude_deg);
        Start { position, altitude_m: elevation_m, heading_deg, airborne: false, fuel_share: None }
    }

    /// Returns a start in flight at cruise speed.
    pub fn in_flight(latitude_deg: f64, longitude_deg: f64, altitude_m: f64, heading_deg: f64) -> Start {
        let position = Position::new(latitude_deg, longitude_deg);
        Start { position, altitude_m, heading_deg, airborne: true, fuel_share: None }
    }
}

/// Elevation of the ground: one value everywhere, overridden by terrain grids, which in turn are overridden by round patches. Where
/// patches overlap, the later patch applies.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ground {
    /// Elevation where no patch lies and the terrain is not known.
    pub elevation_m: f64,
    /// Terrain grids; they hold where no patch lies.
    pub terrain: Option<Arc<Terrain>>,
    /// Patches, for example one for each target.
    pub patches: Vec<GroundPatch>,
}

/// A round patch of ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GroundPatch {
    /// Its middle.
    pub position: Position,
    /// Its radius.
    pub radius_m: f64,
    /// Its elevation above mean sea level.
    pub elevation_m: f64,
}

impl Ground {
    /// Returns the elevation at `position`. O(patches); far patches are excluded without computing a geodesic.
    pub fn elevation_m_at(&self, position: Position) -> f64 {
        self.elevation_m_among(&self.patches, position)
    }

    /// Returns the elevation at `position` if only `patches` exist.
    pub(crate) fn elevation_m_among(&self, patches: &[GroundPatch], position: Position) -> f64 {
        // Lower bound on the length of a degree of latitude, and of a degree of longitude at the equator.
        const METRES_PER_DEGREE_MIN: f64 = 110_000.0;
        // Upper bounds on both.
        const METRES_PER_DEGREE_MAX: f64 = 111_700.0;
        let inside = |patch: &&GroundPatch| {
            let middle = patch.position;
            let north_deg = (middle.latitude_deg - position.latitude_deg).abs();
            let north_m = north_deg * METRES_PER_DEGREE_MIN;
            if north_m > patch.radius_m {
                return false;
            }
            let poleward_deg = middle.latitude_deg.abs().max(position.latitude_deg.abs());
            let parallel = libm::cos(poleward_deg * geodesy::RAD_PER_DEG);
            let east_deg = geodesy::wrap_180(middle.longitude_deg - position.longitude_deg).abs();
            // The distance along the parallel exceeds the geodesic by less than 1 % up to 10 degrees, hence the factor.
            let far = east_deg < 10.0 && 0.99 * east_deg * parallel * METRES_PER_DEGREE_MIN > patch.radius_m;
            // The way along the parallel nearer to the equator and along a meridian is not shorter than the geodesic.
            let equatorward_deg = middle.latitude_deg.abs().min(position.latitude_deg.abs());
            let near = || {
                let parallel = libm::cos(equatorward_deg * geodesy::RAD_PER_DEG);
                (north_deg + east_deg * parallel) * METRES_PER_DEGREE_MAX <= patch.radius_m
            };
            !far && (near() || geodesy::distance_m(middle, position) <= patch.radius_m)
        };
        let patch_m = patches.iter().rev().find(inside).map(|patch| patch.elevation_m);
        let terrain_m = || self.terrain.as_ref()?.elevation_m_at(position);
        patch_m.or_else(terrain_m).unwrap_or(self.elevation_m)
    }
}

/// A radio link: signal level by position, with fading and drop-outs. Published levels lie between 0 (no signal) and 1 (full).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Modem {
    /// Its name: the object of `signal-level`, for example `900MHzModem`.
    pub name: String,
    /// True signal level by position.
    pub level: LevelModel,
    /// Standard deviation of the fading.
    pub fading_db: f64,
    /// Spans `(from_s, until_s)` without any signal.
    pub dropouts_s: Vec<(f64, f64)>,
}

impl Modem {
    /// Returns a ground radio with 3 dB of fading; its level is full within `full_level_m` and zero 40 dB below that.
    pub fn at_station(name: &str, station: Position, full_level_m: f64) -> Modem {
        let level = LevelModel::at_station(station, full_level_m);
        Modem { name: name.to_owned(), level, fading_db: 3.0, dropouts_s: Vec::new() }
    }

    /// Returns a satellite link: full level everywhere.
    pub fn satellite(name: &str) -> Modem {
        let level = LevelModel::satellite();
        Modem { name: name.to_owned(), level, fading_db: 1.0, dropouts_s: Vec::new() }
    }

    fn check(&self) -> Result<(), String> {
        let name = &self.name;
        if let Some(station) = self.level.station {
            check_position(&format!("the station of modem `{name}`"), station)?;
        }
        if let LevelLaw::Logarithmic { full_level_m, range_m } = self.level.law {
            for (field, value, least) in [("full_level_m", full_level_m, 0.0), ("range_m", range_m, full_level_m)] {
                if !(value.is_finite() && value > least) {
                    return Err(format!(
                        "modem `{name}`: {field} is {value}; it must be a number greater than {least}"
                    ));
                }
            }
        }
        check_finite(&format!("modem `{name}`: fading_db"), self.fading_db)
    }
}

/// A place that commands may call by name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NamedPlace {
    /// Name; upper and lower case are equal.
    pub name: String,
    /// Position of the place.
    pub position: Position,
    /// Altitude of the object itself, for pointing cameras; `None` is the ground.
    pub altitude_m: Option<f64>,
}

/// A scripted event at its time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScheduledEvent {
    /// Instant of publication.
    pub at: Time,
    /// Published content.
    pub what: Happening,
}

/// Content of a [`ScheduledEvent`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Happening {
    /// A message, for example `(fire-sighted site-4)`.
    Occurrence(Value),
    /// A sample, for example of `(likelihood site-4)`.
    Measurement(StateVariable, Value),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_are_found_up_to_their_edge_and_later_ones_win() {
        let patch =
            |radius_m, elevation_m| GroundPatch { position: Position::new(47.0, -114.0), radius_m, elevation_m };
        let ground =
            Ground { elevation_m: 5.0, patches: vec![patch(30_000.0, 100.0), patch(1_000.0, 200.0)], terrain: None };
        for azimuth_deg in [0.0, 45.0, 90.0, 135.0, 270.0] {
            let at = |distance_m| {
                ground.elevation_m_at(geodesy::destination(Position::new(47.0, -114.0), azimuth_deg, distance_m))
            };
            assert_eq!((at(900.0), at(29_990.0), at(30_010.0)), (200.0, 100.0, 5.0), "{azimuth_deg}");
        }
    }

    #[test]
    fn patches_are_found_as_by_the_geodesic_alone() {
        let mut inside = 0;
        for latitude_deg in [-89.95, -45.0, 0.0, 30.0, 62.0, 89.9] {
            for radius_m in [50.0, 20_000.0, 900_000.0] {
                let middle = Position::new(latitude_deg, 179.9);
                let patch = GroundPatch { position: middle, radius_m, elevation_m: 1.0 };
                let ground = Ground { elevation_m: 0.0, patches: vec![patch], terrain: None };
                for number in 0..400 {
                    let share = [0.3, 0.7, 0.9, 0.99, 0.999_99, 1.000_01, 1.1][number % 7];
                    let position = geodesy::destination(middle, 0.9 * number as f64, share * radius_m);
                    let by_definition = geodesy::distance_m(middle, position) <= radius_m;
                    inside += usize::from(by_definition);
                    assert_eq!(ground.elevation_m_at(position) > 0.0, by_definition, "{position:?}, {radius_m} m");
                }
            }
        }
        assert!(inside > 1_000, "{inside}");
    }
}
