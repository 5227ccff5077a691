//! Travel times for surveillance problems from positions, speed, wind and zones.

use apex_geo::geodesy::Position;
use apex_geo::travel::{Air, Circling, EndpointId, Network, Setting, TravelError, Trip};
use apex_geo::wind::WindField;
use apex_model::problem::{AirspaceZone, LaterTimes, TravelTimes, UNREACHABLE_S};

/// Times and paths of the vehicle from place to place.
#[derive(Clone, Debug)]
pub struct Transit<'a> {
    /// Speed through the air.
    pub true_airspeed_mps: f64,
    /// Least radius of its turns through the air; 0 for a vehicle that can stop and turn on the spot. With a radius the vehicle circles
    /// around the start and the targets, and a path takes its time from the worst point of a circle.
    pub turn_radius_m: f64,
    /// Altitude at which the wind is taken.
    pub altitude_m: f64,
    /// The wind.
    pub wind: &'a WindField,
    /// Begin of the plan.
    pub time_s: f64,
    /// End of the plan: zones that are active before it are avoided all the time.
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
pub struct SurveillanceTravel {
    /// Their travel times, counted from the beginning of the plan; [`UNREACHABLE_S`] if no path exists. Asymmetric under wind, and
    /// dependent on the departure if the wind changes.
    pub times: TravelTimes,
    network: Network,
    begin_s: f64,
    ends: Ends,
    troubles: Vec<Option<TravelError>>,
}

/// The numbers of places in the network.
#[derive(Clone, Debug)]
struct Ends {
    start: EndpointId,
    base: EndpointId,
    targets: Vec<EndpointId>,
}

/// Permitted error of times that are interpolated between stored departures, as a share of the longest travel time; at least
/// [`ERROR_S_MAX`] is permitted.
const ERROR_SHARE: f64 = 0.005;
const ERROR_S_MAX: f64 = 1.0;
/// Greatest number of departures with stored times, and of numbers in all of them.
const DEPARTURES_MAX: usize = 128;
const NUMBERS_MAX: usize = 2_000_000;

impl SurveillanceTravel {
    /// Returns the ways between `targets`, from `start` and to `base`.
    ///
    /// # Errors
    /// An error message that names an invalid zone, or the start or base that is off the map or inside a zone.
    pub fn new(
        start: Position,
        targets: &[Position],
        base: Position,
        transit: &Transit<'_>,
    ) -> Result<SurveillanceTravel, String> {
        let mut around = vec![start, base];
        around.extend_from_slice(targets);
        // The plan repeats its cycle, so a zone that is active at any time of it is avoided at all times.
        let mut zones = transit.zones.to_vec();
        zones.retain(|zone| zone.active.overlaps(transit.time_s, transit.until_s));
        for zone in &mut zones {
            zone.active = apex_model::problem::TimeWindow::ALWAYS;
        }
        let setting = Setting {
            zones: &zones,
            margin_m: transit.margin_m,
            turn_radius_m: transit.turn_radius_m,
            circling: true,
            landing_places: &[],
            landing_distance_m_max: None,
            around: &around,
            altitudes_m: transit.altitudes_m,
            time_s: (transit.time_s, transit.until_s),
        };
        crate::validate::turn_radius(transit.turn_radius_m)?;
        let begin_s = transit.time_s;
        // A way that begins before the end of the plan may be flown after it: its wind counts until it ends.
        let air = Air::new(transit.wind, transit.altitude_m, transit.true_airspeed_mps, begin_s, f64::INFINITY);
        let changes_s: Vec<f64> = air.changes_s().iter().map(|change_s| change_s - begin_s).collect();
        let mut network = Network::new(&setting, air)?;
        let mut end = |position: Position, name: &str| {
            let place = network.add(position).map_err(|trouble| format!("the {name} cannot be used: {trouble}"))?;
            match network.place_trouble(place, (begin_s, begin_s)) {
                Some(trouble) => Err(format!("the {name} cannot be used: {trouble}")),
                None => Ok(place),
            }
        };
        let (start, base) = (end(start, "start")?, end(base, "base")?);
        network.circle(start);
        if !network.has_room_to_circle(start) {
            return Err(format!("the start cannot be used: {}", TravelError::NoRoomToTurn));
        }
        let mut troubles = Vec::with_capacity(targets.len());
        let mut places: Vec<EndpointId> = Vec::with_capacity(targets.len());
        for position in targets {
            let place = network.add(*position).map_err(|trouble| format!("a target cannot be used: {trouble}"))?;
            network.circle(place);
            let trouble = network.place_trouble(place, (begin_s, begin_s));
            troubles
                .push(trouble.or_else(|| (!network.has_room_to_circle(place)).then_some(TravelError::NoRoomToTurn)));
            places.push(place);
        }
        let ends = Ends { start, base, targets: places };
        let mut ways = SurveillanceTravel { times: TravelTimes::default(), network, begin_s, ends, troubles };
        ways.times = ways.at_departures(&changes_s, transit.until_s - begin_s);
        Ok(ways)
    }

    /// Returns the times for a departure at the beginning. If the wind changes, also those for later departures, as many as linear
    /// interpolation needs up to `last_departure_s`.
    fn at_departures(&mut self, changes_s: &[f64], last_departure_s: f64) -> TravelTimes {
        let first = self.leaving_at(0.0);
        let mut known = vec![first];
        // Times are constant except for a vehicle that is on the way when the wind changes.
        for change_s in changes_s {
            let longest_s = |times: &LaterTimes| {
                let all = times.from_start_s.iter().chain(&times.to_base_s).chain(times.between_s.iter().flatten());
                all.copied().filter(|time_s| *time_s < UNREACHABLE_S).fold(0.0, f64::max)
            };
            let last_s = known.last().map_or(0.0, |times| times.depart_s);
            let longest = known.last().map_or(0.0, longest_s);
            // A vehicle that leaves at the end of the plan is there before this change, and before all later ones.
            if change_s - longest > last_departure_s.max(last_s) {
                break;
            }
            let after = self.leaving_at(*change_s);
            let open_s = (change_s - longest.max(longest_s(&after))).max(last_s);
            if open_s > last_s && open_s < *change_s {
                let before = self.leaving_at(open_s);
                known.push(before);
            }
            let from = known.len().saturating_sub(1);
            known.push(after);
            self.refine(&mut known, from, (ERROR_SHARE * longest).max(ERROR_S_MAX));
        }
        let mut later = known.into_iter();
        let LaterTimes { from_start_s, between_s, to_base_s, .. } = later.next().unwrap_or_default();
        TravelTimes { from_start_s, between_s, to_base_s, later: later.collect() }
    }

    /// Halves the intervals between departures, from number `from` on, until no time in the middle deviates by more than `error_s`.
    fn refine(&mut self, known: &mut Vec<LaterTimes>, mut from: usize, error_s: f64) {
        let count = self.ends.targets.len() + 1;
        let most = (NUMBERS_MAX / (count * count)).clamp(8, DEPARTURES_MAX);
        while let Some((before, after)) = known.get(from).zip(known.get(from + 1)) {
            let middle_s = 0.5 * (before.depart_s + after.depart_s);
            let middle = self.leaving_at(middle_s);
            let apart = known.get(from).zip(known.get(from + 1)).is_some_and(|(before, after)| {
                after.depart_s - before.depart_s > error_s && off_s(before, &middle, after) > error_s
            });
            if apart && known.len() < most {
                known.insert(from + 1, middle);
            } else {
                from += 1;
            }
        }
    }

    fn leaving_at(&mut self, depart_s: f64) -> LaterTimes {
        let ready_s = self.begin_s + depart_s;
        let Ends { start, base, targets } = &self.ends;
        let seconds = |trip: &Option<Trip>| trip.map_or(UNREACHABLE_S, |trip| trip.arrive_s - ready_s);
        let rows = |matrix: Vec<Vec<Option<Trip>>>| -> Vec<Vec<f64>> {
            matrix.iter().map(|row| row.iter().map(seconds).collect()).collect()
        };
        let from_start = rows(self.network.matrix(&[*start], targets, ready_s));
        LaterTimes {
            depart_s,
            from_start_s: from_start.into_iter().next().unwrap_or_default(),
            between_s: rows(self.network.matrix(targets, targets, ready_s)),
            to_base_s: rows(self.network.matrix(targets, &[*base], ready_s)).concat(),
        }
    }

    /// Returns the path to target `to` with both ends and its bends, departing from target `from` (`None`: the start)
    /// `depart_s` seconds after the beginning. Empty if no path exists.
    pub fn route(&mut self, from: Option<usize>, to: usize, depart_s: f64) -> Vec<Position> {
        let from = from.map_or(Some(self.ends.start), |from| self.ends.targets.get(from).copied());
        let to = self.ends.targets.get(to).copied();
        self.positions(from.zip(to), depart_s)
    }

    /// Returns the path from a target to the base.
    pub fn route_to_base(&mut self, from: usize, depart_s: f64) -> Vec<Position> {
        let ends = self.ends.targets.get(from).copied().map(|from| (from, self.ends.base));
        self.positions(ends, depart_s)
    }

    /// Returns the radius of the circles around start and targets; 0 for a vehicle that turns on the spot.
    pub fn circle_radius_m(&self) -> f64 {
        self.network.circle_radius_m()
    }

    /// Returns the time that turns add to the straight legs to a target in the worst case, departing from another
    /// target (`None`: the start) `depart_s` after the beginning.
    pub fn turns_s(&mut self, from: Option<usize>, to: usize, depart_s: f64) -> f64 {
        let from = from.map_or(Some(self.ends.start), |from| self.ends.targets.get(from).copied());
        self.turns_between_s(from.zip(self.ends.targets.get(to).copied()), depart_s)
    }

    /// Returns the time that turns add on the way from a target to the base.
    pub fn turns_to_base_s(&mut self, from: usize, depart_s: f64) -> f64 {
        self.turns_between_s(self.ends.targets.get(from).map(|from| (*from, self.ends.base)), depart_s)
    }

    fn turns_between_s(&mut self, ends: Option<(EndpointId, EndpointId)>, depart_s: f64) -> f64 {
        let trip = ends.and_then(|(from, to)| self.network.trip(from, to, self.begin_s + depart_s).ok());
        trip.map_or(0.0, |trip| self.network.turns_s(trip.way))
    }

    /// Returns the path around a target of a vehicle with a turn radius during an observation, and its last position on the circle.
    pub fn look(&self, at: usize, from: Circling, (begin_s, end_s): (f64, f64)) -> (Vec<Position>, Circling) {
        let place = self.ends.targets.get(at).copied();
        let arc = place.map(|place| self.network.circling_arc(place, from, (self.begin_s + begin_s, end_s - begin_s)));
        arc.unwrap_or((Vec::new(), from))
    }

    /// Returns the path from a target (`None`: the start) to another (`None`: the base) with departure at `depart_s`, from the position
    /// on the circle in `left` (`None`: the best one), and the position on the next circle.
    pub fn flown(
        &mut self,
        (from, to): (Option<usize>, Option<usize>),
        left: Option<Circling>,
        depart_s: f64,
    ) -> (Vec<Position>, Option<Circling>) {
        let place = |number: Option<usize>, other: EndpointId| match number {
            Some(number) => self.ends.targets.get(number).copied(),
            None => Some(other),
        };
        let Some((from, to)) = place(from, self.ends.start).zip(place(to, self.ends.base)) else {
            return (Vec::new(), None);
        };
        match self.network.trip(from, to, self.begin_s + depart_s) {
            Ok(trip) => self.network.circling_path(trip.way, trip.depart_s, left),
            Err(_) => (Vec::new(), None),
        }
    }

    /// Returns the reason for which the target cannot be visited; `None` if it can.
    pub fn trouble(&self, target: usize) -> Option<&TravelError> {
        self.troubles.get(target).and_then(Option::as_ref)
    }

    fn positions(&mut self, ends: Option<(EndpointId, EndpointId)>, depart_s: f64) -> Vec<Position> {
        let trip = ends.and_then(|(from, to)| self.network.trip(from, to, self.begin_s + depart_s).ok());
        trip.map_or_else(Vec::new, |trip| self.network.positions(trip.way))
    }
}

/// Returns the greatest deviation of the middle times from linear interpolation between the earlier and later ones.
fn off_s(before: &LaterTimes, middle: &LaterTimes, after: &LaterTimes) -> f64 {
    let times = |of: &LaterTimes| -> Vec<f64> {
        of.from_start_s.iter().chain(&of.to_base_s).chain(of.between_s.iter().flatten()).copied().collect()
    };
    let (before, middle, after) = (times(before), times(middle), times(after));
    let off = before.iter().zip(&middle).zip(&after).map(|((before_s, middle_s), after_s)| {
        let known = before_s.max(*middle_s).max(*after_s) < UNREACHABLE_S;
        if known { (middle_s - 0.5 * (before_s + after_s)).abs() } else { 0.0 }
    });
    off.fold(0.0, f64::max)
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
            edr: 0.0,
        };
        let wind = WindField { layers: vec![layer], blend: false };
        let targets = [Position::new(37.41, -121.12), Position::new(37.41, -121.08), Position::new(37.41, -121.10)];
        let (zones, home) = ([wall], Position::new(37.39, -121.12));
        let transit = |high_m: f64| Transit {
            true_airspeed_mps: 15.0,
            turn_radius_m: 0.0,
            altitude_m: 100.0,
            wind: &wind,
            time_s: 0.0,
            until_s: 3600.0,
            zones: &zones,
            margin_m: 50.0,
            altitudes_m: (high_m, high_m),
        };
        let mut low = SurveillanceTravel::new(home, &targets, home, &transit(100.0)).unwrap();
        let mut high = SurveillanceTravel::new(home, &targets, home, &transit(300.0)).unwrap();
        let (low_s, high_s) = (low.times.between_s.clone(), high.times.between_s.clone());
        assert!(low.times.is_constant(), "the wind does not change");
        assert!(low_s[0][1] > high_s[0][1] * 1.1 && low.route(Some(0), 1, 0.0).len() > 2, "{low_s:?} {high_s:?}");
        assert!(low_s[1][0] > 1.5 * low_s[0][1], "against the wind");
        assert_eq!((low_s[0][2], low_s[0][0]), (UNREACHABLE_S, 0.0), "the third lies inside the wall");
        assert_eq!(low.trouble(2), Some(&TravelError::Inside("wall".into())));
        assert!(high_s[0][2] < 200.0 && high.trouble(2).is_none() && high.route(None, 2, 0.0).len() == 2);
    }
}
