//! Ways and times between the places of a single-visit problem, remembered: routes around airspace, legs through wind.

use apex_geo::airspace::{Airspace, Extent};
use apex_geo::geodesy::{self, Position};
use apex_geo::route::{NoRoute, Router};
use apex_geo::wind::{self, LegProfile};
use apex_model::problem::SingleVisitProblem;
use std::collections::BTreeMap;

/// Looks for a route whose time fits the span for which airspace was looked at.
const ROUTE_ROUNDS_MAX: usize = 4;

/// A place by name, for remembering.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Node {
    /// The start.
    Start,
    /// The base.
    Base,
    /// Where a manoeuvre (target, manoeuvre) begins.
    Entry(usize, usize),
    /// Where it ends.
    Exit(usize, usize),
}

/// A way with its time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Way {
    /// Both ends and the turning points between.
    pub(crate) route: Vec<Position>,
    /// Time from end to end.
    pub(crate) time_s: f64,
}

#[derive(Debug)]
struct Known {
    route: Vec<Position>,
    legs: Vec<LegProfile>,
    /// The time, where the wind is the same at all times.
    steady_s: Option<f64>,
}

type Key = (Node, Node, Vec<bool>);

/// The travel model with its memory.
pub(crate) struct Travel<'a> {
    problem: &'a SingleVisitProblem,
    router: Router,
    known: BTreeMap<Key, Result<Known, String>>,
    lines: BTreeMap<(usize, usize, Vec<bool>), Option<String>>,
    distances_m: BTreeMap<(Node, Node), f64>,
    steady_wind: bool,
    timed_zones: bool,
}

impl<'a> Travel<'a> {
    /// Prepares airspace and wind of `problem`.
    ///
    /// # Errors
    /// A sentence that names a zone that makes no sense.
    pub(crate) fn new(problem: &'a SingleVisitProblem) -> Result<Travel<'a>, String> {
        let mut around = vec![problem.start];
        around.extend(problem.base);
        around.extend(problem.targets.iter().map(|target| target.position));
        let airspace = Airspace::new(&problem.zones, problem.zone_margin_m, &around)?;
        let until_s = problem.start_s + problem.vehicle.endurance_s;
        let always = |zone: &apex_model::problem::AirspaceZone| {
            let never = zone.active.until_s <= problem.start_s || zone.active.from_s > until_s;
            never || (zone.active.from_s <= problem.start_s && zone.active.until_s > 2.0 * until_s)
        };
        Ok(Travel {
            problem,
            router: Router::new(airspace, problem.landing_places.clone(), problem.landing_distance_m_max),
            known: BTreeMap::new(),
            lines: BTreeMap::new(),
            distances_m: BTreeMap::new(),
            steady_wind: wind::is_steady(&problem.wind, problem.start_s, until_s),
            timed_zones: !problem.zones.iter().all(always),
        })
    }

    pub(crate) fn router(&self) -> &Router {
        &self.router
    }

    /// Where a node is and at which altitude.
    pub(crate) fn place(&self, node: Node) -> (Position, f64) {
        let cruise_m = self.problem.vehicle.cruise_altitude_m;
        let of = |target: usize, manoeuvre: usize, entry: bool| {
            let target = self.problem.targets.get(target);
            let manoeuvre = target.and_then(|target| target.manoeuvres.get(manoeuvre));
            let overhead = target.map_or(self.problem.start, |target| target.position);
            let line = manoeuvre.and_then(|m| if entry { m.lines.first() } else { m.lines.last() });
            let position = line.map_or(overhead, |(from, to)| if entry { *from } else { *to });
            (position, manoeuvre.map_or(cruise_m, |manoeuvre| manoeuvre.altitude_m))
        };
        match node {
            Node::Start => (self.problem.start, self.problem.start_altitude_m),
            Node::Base => (self.problem.base.unwrap_or(self.problem.start), cruise_m),
            Node::Entry(target, manoeuvre) => of(target, manoeuvre, true),
            Node::Exit(target, manoeuvre) => of(target, manoeuvre, false),
        }
    }

    /// Time from `from` to `to`, leaving at `depart_s`; none where there is no way.
    pub(crate) fn time_s(&mut self, from: Node, to: Node, depart_s: f64) -> Option<f64> {
        self.find(from, to, depart_s).ok().map(|(_, time_s)| time_s)
    }

    /// The way from `from` to `to`, leaving at `depart_s`.
    ///
    /// # Errors
    /// A phrase that says what stands in the way, for example "inside restricted area R-2515".
    pub(crate) fn way(&mut self, from: Node, to: Node, depart_s: f64) -> Result<Way, String> {
        let (key, time_s) = self.find(from, to, depart_s)?;
        match self.known.get(&key) {
            Some(Ok(known)) => Ok(Way { route: known.route.clone(), time_s }),
            Some(Err(trouble)) => Err(trouble.clone()),
            None => Err("no way was found".to_string()),
        }
    }

    fn find(&mut self, from: Node, to: Node, depart_s: f64) -> Result<(Key, f64), String> {
        let (start, altitude_from_m) = self.place(from);
        let (end, altitude_to_m) = self.place(to);
        let mut span_s = 0.0;
        if self.timed_zones {
            let distance_m = *self.distances_m.entry((from, to)).or_insert_with(|| geodesy::distance_m(start, end));
            span_s = 1.5 * distance_m / self.problem.vehicle.true_airspeed_mps + 600.0;
        }
        for _ in 0..ROUTE_ROUNDS_MAX {
            let extent = self.extent(altitude_from_m, altitude_to_m, depart_s, depart_s + span_s);
            let key = (from, to, self.active_zones(extent));
            if !self.known.contains_key(&key) {
                let known = self.plot(start, end, extent);
                self.known.insert(key.clone(), known);
            }
            let known = match self.known.get(&key) {
                Some(Ok(known)) => known,
                Some(Err(trouble)) => return Err(trouble.clone()),
                None => return Err("no way was found".to_string()),
            };
            let flown_s = known.steady_s.or_else(|| self.legs_time_s(&known.legs, depart_s));
            let flown_s = flown_s.ok_or("the wind is too strong on the way")?;
            let time_s = flown_s.max(self.climb_s(altitude_from_m, altitude_to_m));
            if !self.timed_zones || time_s <= span_s {
                return Ok((key, time_s));
            }
            span_s = 1.5 * time_s;
        }
        Err("airspace changes faster than the way can be flown".to_string())
    }

    /// Why the lines of a manoeuvre are not allowed from `begin_s` to `end_s`; none where they are.
    pub(crate) fn lines_trouble(
        &mut self,
        target: usize,
        manoeuvre: usize,
        begin_s: f64,
        end_s: f64,
    ) -> Option<String> {
        let (entry, altitude_m) = self.place(Node::Entry(target, manoeuvre));
        let extent = Extent { altitude_m_min: altitude_m, altitude_m_max: altitude_m, from_s: begin_s, until_s: end_s };
        let key = (target, manoeuvre, self.active_zones(extent));
        if let Some(known) = self.lines.get(&key) {
            return known.clone();
        }
        let lines = self.problem.targets.get(target).and_then(|target| target.manoeuvres.get(manoeuvre));
        let lines = lines.map_or(&[][..], |manoeuvre| &manoeuvre.lines);
        let turns = lines.iter().zip(lines.iter().skip(1)).map(|((_, from), (to, _))| (*from, *to));
        let mut legs = lines.iter().copied().chain(turns);
        let trouble = self.router.place_trouble(entry, extent);
        let trouble = trouble.or_else(|| legs.find_map(|(from, to)| self.router.leg_trouble(from, to, extent)));
        let trouble = trouble.map(|trouble| trouble.to_string());
        self.lines.insert(key, trouble.clone());
        trouble
    }

    fn plot(&self, start: Position, end: Position, extent: Extent) -> Result<Known, String> {
        let route = self.router.route(start, end, extent).map_err(|trouble: NoRoute| trouble.to_string())?;
        let legs = route.iter().zip(route.iter().skip(1));
        let legs: Option<Vec<LegProfile>> = legs.map(|(from, to)| LegProfile::new(*from, *to)).collect();
        let legs = legs.ok_or("a position is not on the map")?;
        let steady_s = if self.steady_wind { self.legs_time_s(&legs, self.problem.start_s) } else { None };
        if self.steady_wind && steady_s.is_none() {
            return Err("the wind is too strong on the way".to_string());
        }
        Ok(Known { route, legs, steady_s })
    }

    fn legs_time_s(&self, legs: &[LegProfile], depart_s: f64) -> Option<f64> {
        let vehicle = &self.problem.vehicle;
        legs.iter().try_fold(0.0, |elapsed_s, leg| {
            let wind = &self.problem.wind;
            let leg_s = leg.time_s(vehicle.cruise_altitude_m, vehicle.true_airspeed_mps, wind, depart_s + elapsed_s)?;
            Some(elapsed_s + leg_s)
        })
    }

    /// Time to climb or descend from one altitude to cruise and on to the other: a leg takes no less.
    fn climb_s(&self, from_m: f64, to_m: f64) -> f64 {
        let vehicle = &self.problem.vehicle;
        let change_s = |from_m: f64, to_m: f64| {
            let rate_mps = if to_m > from_m { vehicle.climb_rate_mps } else { vehicle.descent_rate_mps };
            if rate_mps > 0.0 { (to_m - from_m).abs() / rate_mps } else { 0.0 }
        };
        change_s(from_m, vehicle.cruise_altitude_m) + change_s(vehicle.cruise_altitude_m, to_m)
    }

    /// The altitudes and times that a leg takes: it may be anywhere between its ends' altitudes and cruise.
    fn extent(&self, from_m: f64, to_m: f64, from_s: f64, until_s: f64) -> Extent {
        let cruise_m = self.problem.vehicle.cruise_altitude_m;
        Extent {
            altitude_m_min: from_m.min(to_m).min(cruise_m),
            altitude_m_max: from_m.max(to_m).max(cruise_m),
            from_s,
            until_s,
        }
    }

    /// Which zones count in `extent`: ways are remembered for each such set. Empty where zones never change.
    fn active_zones(&self, extent: Extent) -> Vec<bool> {
        if !self.timed_zones {
            return Vec::new();
        }
        let zones = self.router.airspace().zones();
        zones
            .flat_map(|zone| {
                let throughout = zone.active.from_s <= extent.from_s && extent.until_s < zone.active.until_s;
                [extent.meets(zone), throughout]
            })
            .collect()
    }
}
