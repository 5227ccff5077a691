//! Travel times for surveillance problems from positions, speed, wind and zones.

use apex_geo::geodesy::Position;
use apex_geo::travel::{Air, Network, PlaceId, Setting, Trip, Trouble};
use apex_geo::wind::WindField;
use apex_model::problem::{AirspaceZone, TravelTimes, UNREACHABLE_S};

/// How the vehicle gets from place to place.
#[derive(Clone, Debug)]
pub struct Transit<'a> {
    /// Speed through the air.
    pub true_airspeed_mps: f64,
    /// Altitude at which the wind is taken.
    pub altitude_m: f64,
    /// The wind.
    pub wind: &'a WindField,
    /// When the plan begins: the matrix is the one for leaving at this time.
    pub time_s: f64,
    /// When it ends: zones that are active before that are kept out of at all times.
    pub until_s: f64,
    /// Zones to keep out of and to stay in.
    pub zones: &'a [AirspaceZone],
    /// Distance kept from restricted ones.
    pub margin_m: f64,
    /// Lowest and highest altitude of the flight.
    pub altitudes_m: (f64, f64),
}

/// The ways between start, targets and base.
#[derive(Clone, Debug)]
pub struct Ways {
    /// Their times; [`UNREACHABLE_S`] where there is no way. Not symmetric under wind.
    pub times: TravelTimes,
    network: Network,
    from_start: Vec<Option<Trip>>,
    between: Vec<Vec<Option<Trip>>>,
    to_base: Vec<Option<Trip>>,
    troubles: Vec<Option<Trouble>>,
}

impl Ways {
    /// The ways between `targets`, from `start` and to `base`.
    ///
    /// # Errors
    /// A sentence that names a zone that makes no sense, or the start or base that is not on the map or inside a zone.
    pub fn new(start: Position, targets: &[Position], base: Position, transit: &Transit<'_>) -> Result<Ways, String> {
        let mut around = vec![start, base];
        around.extend_from_slice(targets);
        // The plan repeats its cycle, so a zone that is active at some time of it is kept out of at all times.
        let mut zones = transit.zones.to_vec();
        zones.retain(|zone| zone.active.overlaps(transit.time_s, transit.until_s));
        for zone in &mut zones {
            zone.active = apex_model::problem::TimeWindow::ALWAYS;
        }
        let setting = Setting {
            zones: &zones,
            margin_m: transit.margin_m,
            turn_radius_m: 0.0,
            landing_places: &[],
            landing_distance_m_max: None,
            around: &around,
            altitudes_m: transit.altitudes_m,
            time_s: (transit.time_s, transit.until_s),
        };
        let (from_s, until_s) = (transit.time_s, transit.until_s);
        let air = Air::new(transit.wind, transit.altitude_m, transit.true_airspeed_mps, from_s, until_s);
        let mut network = Network::new(&setting, air)?;
        let mut ends = Vec::with_capacity(2);
        for (position, name) in [(start, "start"), (base, "base")] {
            let place = network.add(position).map_err(|trouble| format!("The {name} cannot be used: {trouble}."))?;
            if let Some(trouble) = network.place_trouble(place, (from_s, from_s)) {
                return Err(format!("The {name} cannot be used: {trouble}."));
            }
            ends.push(place);
        }
        let mut troubles = Vec::with_capacity(targets.len());
        let mut places: Vec<PlaceId> = Vec::with_capacity(targets.len());
        for position in targets {
            let place = network.add(*position).map_err(|trouble| format!("A target cannot be used: {trouble}."))?;
            troubles.push(network.place_trouble(place, (from_s, from_s)));
            places.push(place);
        }
        let first = |rows: Vec<Vec<Option<Trip>>>| rows.into_iter().next().unwrap_or_default();
        let (start, base) = (ends.get(..1).unwrap_or_default(), ends.get(1..).unwrap_or_default());
        let from_start = first(network.matrix(start, &places, from_s));
        let to_base: Vec<Option<Trip>> =
            network.matrix(&places, base, from_s).into_iter().map(|row| row.into_iter().next().flatten()).collect();
        let between = network.matrix(&places, &places, from_s);
        let seconds = |trip: &Option<Trip>| trip.map_or(UNREACHABLE_S, |trip| trip.arrive_s - from_s);
        let times = TravelTimes {
            from_start_s: from_start.iter().map(seconds).collect(),
            between_s: between.iter().map(|row| row.iter().map(seconds).collect()).collect(),
            to_base_s: to_base.iter().map(seconds).collect(),
        };
        Ok(Ways { times, network, from_start, between, to_base, troubles })
    }

    /// Both ends and the bends of the way to a target, from another or from the start (none); empty where there is none.
    pub fn route(&self, from: Option<usize>, to: usize) -> Vec<Position> {
        let trip = match from {
            Some(from) => self.between.get(from).and_then(|row| row.get(to)),
            None => self.from_start.get(to),
        };
        self.positions(trip)
    }

    /// The way from a target to the base.
    pub fn route_to_base(&self, from: usize) -> Vec<Position> {
        self.positions(self.to_base.get(from))
    }

    /// Why a target cannot be visited at all: what it lies in.
    pub fn trouble(&self, target: usize) -> Option<&Trouble> {
        self.troubles.get(target).and_then(Option::as_ref)
    }

    fn positions(&self, trip: Option<&Option<Trip>>) -> Vec<Position> {
        trip.copied().flatten().map_or_else(Vec::new, |trip| self.network.positions(trip.way))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::problem::{TimeWindow, WindLayer, ZoneKind};

    #[test]
    fn times_go_around_obstacles_and_with_the_wind() {
        let corners = [(37.40, -121.11), (37.40, -121.09), (37.42, -121.09), (37.42, -121.11)];
        let wall = AirspaceZone {
            name: "wall".to_string(),
            kind: ZoneKind::Restricted,
            corners: corners.map(|(latitude, longitude)| Position::new(latitude, longitude)).to_vec(),
            altitude_m_min: 0.0,
            altitude_m_max: 200.0,
            active: TimeWindow::ALWAYS,
        };
        let layer = WindLayer {
            area: None,
            altitude_m_min: 0.0,
            altitude_m_max: 1000.0,
            from_s: 0.0,
            until_s: 1e9,
            wind_east_mps: 5.0,
            wind_north_mps: 0.0,
            turbulence: 0.0,
        };
        let wind = WindField { layers: vec![layer], blend: false };
        let targets = [Position::new(37.41, -121.12), Position::new(37.41, -121.08), Position::new(37.41, -121.10)];
        let (zones, home) = ([wall], Position::new(37.39, -121.12));
        let transit = |high_m: f64| Transit {
            true_airspeed_mps: 15.0,
            altitude_m: 100.0,
            wind: &wind,
            time_s: 0.0,
            until_s: 3600.0,
            zones: &zones,
            margin_m: 50.0,
            altitudes_m: (high_m, high_m),
        };
        let low = Ways::new(home, &targets, home, &transit(100.0)).unwrap();
        let high = Ways::new(home, &targets, home, &transit(300.0)).unwrap();
        let (low_s, high_s) = (&low.times.between_s, &high.times.between_s);
        assert!(low_s[0][1] > high_s[0][1] * 1.1 && low.route(Some(0), 1).len() > 2, "{low_s:?} {high_s:?}");
        assert!(low_s[1][0] > 1.5 * low_s[0][1], "against the wind");
        assert_eq!((low_s[0][2], low_s[0][0]), (UNREACHABLE_S, 0.0), "the third lies inside the wall");
        assert_eq!(low.trouble(2), Some(&Trouble::Inside("wall".into())));
        assert!(high_s[0][2] < 200.0 && high.trouble(2).is_none() && high.route(None, 2).len() == 2);
    }
}
