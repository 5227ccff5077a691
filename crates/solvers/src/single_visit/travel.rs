//! Ways and times between the places of a single-visit problem, remembered: routes around airspace, legs through wind.
//!
//! A way that keeps clear of every zone of any time serves at all times; others are remembered for each pair of instants
//! between which no zone opens or closes. Times are exact for every departure. Preparing a way is charged as work.

use apex_geo::airspace::{Airspace, Extent};
use apex_geo::geodesy::Position;
use apex_geo::passage::{ChangingWind, Passage};
use apex_geo::route::{Router, Spot};
use apex_geo::wind::LegProfile;
use apex_model::problem::{SingleVisitProblem, TravelTimes, UNREACHABLE_S};
use std::collections::BTreeMap;

/// Looks for a route whose time fits the span for which airspace was looked at.
const ROUTE_ROUNDS_MAX: usize = 4;
/// Work units (a tenth of a microsecond) of testing one leg against airspace and landing places.
const UNITS_PER_LEG_TEST: u64 = 15;
/// Work units of one sub-step of a leg: its place and its wind in each span.
const UNITS_PER_STEP: u64 = 3;
/// Work units of a way whatever its length: its geodesics.
const UNITS_PER_WAY: u64 = 30;

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
    passage: Passage,
}

/// Between which instants of the sorted times of zones a flight begins and ends.
type ZoneSpan = (usize, usize);

/// The ways from one node to another: numbers of known ways.
#[derive(Debug, Default)]
struct Ways {
    /// Serves at all times; `Some(None)` where there is none such.
    always: Option<Option<usize>>,
    timed: Vec<(ZoneSpan, usize)>,
}

/// The travel model with its memory.
pub(crate) struct Travel<'a> {
    problem: &'a SingleVisitProblem,
    router: Router,
    wind: ChangingWind,
    /// The first manoeuvre of each target among all manoeuvres.
    offsets: Vec<usize>,
    /// Where each node is and at which altitude.
    places: Vec<(Spot, f64)>,
    /// For each node the ways to others.
    ways: Vec<BTreeMap<usize, Ways>>,
    known: Vec<Result<Known, String>>,
    lines: BTreeMap<(usize, usize, ZoneSpan), Option<String>>,
    /// When zones open or close during the flight, in order.
    zone_changes_s: Vec<f64>,
    /// Work done since it was last asked for.
    work: u64,
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
        let vehicle = &problem.vehicle;
        let until_s = problem.start_s + 2.0 * vehicle.endurance_s;
        let ends = problem.zones.iter().flat_map(|zone| [zone.active.from_s, zone.active.until_s]);
        let mut zone_changes_s: Vec<f64> =
            ends.filter(|time_s| *time_s > problem.start_s && *time_s <= until_s).collect();
        zone_changes_s.sort_by(f64::total_cmp);
        zone_changes_s.dedup();
        let wind = ChangingWind::new(
            &problem.wind,
            vehicle.cruise_altitude_m,
            vehicle.true_airspeed_mps,
            problem.start_s,
            until_s,
        );
        let router = Router::new(airspace, problem.landing_places.clone(), problem.landing_distance_m_max);
        let mut offsets = Vec::with_capacity(problem.targets.len());
        let mut nodes = vec![Node::Start, Node::Base];
        for (target, data) in problem.targets.iter().enumerate() {
            offsets.push((nodes.len() - 2) / 2);
            for manoeuvre in 0..data.manoeuvres.len() {
                nodes.extend([Node::Entry(target, manoeuvre), Node::Exit(target, manoeuvre)]);
            }
        }
        let places: Vec<(Spot, f64)> = nodes
            .iter()
            .map(|node| {
                let (position, altitude_m) = place(problem, *node);
                (router.spot(position), altitude_m)
            })
            .collect();
        let ways = nodes.iter().map(|_| BTreeMap::new()).collect();
        Ok(Travel {
            problem,
            router,
            wind,
            offsets,
            places,
            ways,
            known: Vec::new(),
            lines: BTreeMap::new(),
            zone_changes_s,
            work: 0,
        })
    }

    pub(crate) fn router(&self) -> &Router {
        &self.router
    }

    /// Work units done since the last call, for the budget.
    pub(crate) fn take_work(&mut self) -> u64 {
        std::mem::take(&mut self.work)
    }

    fn number(&self, node: Node) -> usize {
        let of = |target: usize, manoeuvre: usize| self.offsets.get(target).map_or(0, |first| first + manoeuvre);
        match node {
            Node::Start => 0,
            Node::Base => 1,
            Node::Entry(target, manoeuvre) => 2 + 2 * of(target, manoeuvre),
            Node::Exit(target, manoeuvre) => 3 + 2 * of(target, manoeuvre),
        }
    }

    /// Time from `from` to `to`, leaving at `depart_s`; none where there is no way.
    pub(crate) fn time_s(&mut self, from: Node, to: Node, depart_s: f64) -> Option<f64> {
        if let Some(travel) = &self.problem.travel {
            return given_s(travel, from, to);
        }
        self.find(from, to, depart_s).ok().map(|(_, time_s)| time_s)
    }

    /// No way from `from` to `to` takes less than this.
    pub(crate) fn time_s_min(&self, from: Node, to: Node) -> f64 {
        if let Some(travel) = &self.problem.travel {
            return given_s(travel, from, to).unwrap_or(f64::INFINITY);
        }
        let (Some((start, _)), Some((end, _))) = (self.places.get(self.number(from)), self.places.get(self.number(to)))
        else {
            return 0.0;
        };
        start.direction.distance_m_min(end.direction) / self.wind.ground_speed_mps_max()
    }

    /// The way from `from` to `to`, leaving at `depart_s`.
    ///
    /// # Errors
    /// A phrase that says what stands in the way, for example "inside restricted area R-2515".
    pub(crate) fn way(&mut self, from: Node, to: Node, depart_s: f64) -> Result<Way, String> {
        if let Some(travel) = &self.problem.travel {
            let time_s = given_s(travel, from, to).ok_or("no way leads there")?;
            return Ok(Way { route: vec![place(self.problem, from).0, place(self.problem, to).0], time_s });
        }
        let (known, time_s) = self.find(from, to, depart_s).map_err(|known| self.trouble(known))?;
        match self.known.get(known) {
            Some(Ok(known)) => Ok(Way { route: known.route.clone(), time_s }),
            _ => Err(self.trouble(Some(known))),
        }
    }

    /// Why the way of this number cannot be flown; without a number airspace is to blame.
    fn trouble(&self, known: Option<usize>) -> String {
        match known.and_then(|known| self.known.get(known)) {
            Some(Ok(_)) => "the wind is too strong on the way".to_string(),
            Some(Err(trouble)) => trouble.clone(),
            None => "airspace changes faster than the way can be flown".to_string(),
        }
    }

    /// The number of the way to take and its time.
    ///
    /// # Errors
    /// The number of the way that cannot be flown; none where airspace changes too fast.
    fn find(&mut self, from: Node, to: Node, depart_s: f64) -> Result<(usize, f64), Option<usize>> {
        let (from, to) = (self.number(from), self.number(to));
        if let Some(known) = self.always(from, to) {
            let time_s = self.flown_s(known, (from, to), depart_s).ok_or(Some(known))?;
            return Ok((known, time_s));
        }
        let (Some((start, _)), Some((end, _))) = (self.places.get(from), self.places.get(to)) else {
            return Err(None);
        };
        let distance_m = start.direction.distance_m(end.direction);
        let mut span_s = 1.5 * distance_m / self.problem.vehicle.true_airspeed_mps + 600.0;
        for _ in 0..ROUTE_ROUNDS_MAX {
            let known = self.timed(from, to, (depart_s, depart_s + span_s));
            let time_s = self.flown_s(known, (from, to), depart_s).ok_or(Some(known))?;
            if self.zone_changes_s.is_empty() || time_s <= span_s {
                return Ok((known, time_s));
            }
            span_s = 1.5 * time_s;
        }
        Err(None)
    }

    /// The direct way, where it is allowed at all times.
    fn always(&mut self, from: usize, to: usize) -> Option<usize> {
        let ways = self.ways.get(from).and_then(|ways| ways.get(&to));
        if let Some(always) = ways.and_then(|ways| ways.always) {
            return always;
        }
        let (Some((start, from_m)), Some((end, to_m))) = (self.places.get(from).copied(), self.places.get(to).copied())
        else {
            return None;
        };
        let last_s = self.zone_changes_s.last().copied().unwrap_or(self.problem.start_s);
        let extent = self.extent(from_m, to_m, self.problem.start_s, last_s.max(self.problem.start_s));
        self.work += UNITS_PER_LEG_TEST;
        let always = match self.router.trouble_between(&start, &end, extent) {
            Some(_) => None,
            None => Some(self.remember(Ok(vec![start.position, end.position]))),
        };
        if let Some(ways) = self.ways.get_mut(from) {
            ways.entry(to).or_default().always = Some(always);
        }
        always
    }

    /// The number of the way for a flight from and until these times.
    fn timed(&mut self, from: usize, to: usize, (from_s, until_s): (f64, f64)) -> usize {
        let span = self.zone_span(from_s, until_s);
        let ways = self.ways.get(from).and_then(|ways| ways.get(&to));
        let found = ways.and_then(|ways| ways.timed.iter().find(|(other, _)| *other == span));
        if let Some((_, known)) = found {
            return *known;
        }
        let ends = (self.places.get(from).copied(), self.places.get(to).copied());
        let route = match ends {
            (Some((start, from_m)), Some((end, to_m))) => {
                let extent = self.extent(from_m, to_m, from_s, until_s);
                let (route, tested) = self.router.route_between(&start, &end, extent);
                self.work += UNITS_PER_LEG_TEST * tested as u64;
                route.map_err(|trouble| trouble.to_string())
            }
            _ => Err("no way was found".to_string()),
        };
        let known = self.remember(route);
        if let Some(ways) = self.ways.get_mut(from) {
            ways.entry(to).or_default().timed.push((span, known));
        }
        known
    }

    fn remember(&mut self, route: Result<Vec<Position>, String>) -> usize {
        let known = route.and_then(|route| {
            let legs = route.iter().zip(route.iter().skip(1));
            let legs: Option<Vec<LegProfile>> = legs.map(|(from, to)| LegProfile::new(*from, *to)).collect();
            Ok(Known { passage: Passage::new(legs.ok_or("a position is not on the map")?), route })
        });
        let steps = known.as_ref().map_or(0, |known| known.passage.steps());
        self.work += UNITS_PER_WAY + UNITS_PER_STEP * steps as u64;
        self.known.push(known);
        self.known.len() - 1
    }

    /// Time to fly a known way: through the wind, and no less than climbs and descents take.
    fn flown_s(&mut self, known: usize, (from, to): (usize, usize), depart_s: f64) -> Option<f64> {
        let flown_s = self.known.get_mut(known)?.as_mut().ok()?.passage.time_s(&self.wind, depart_s)?;
        let (from_m, to_m) = (self.places.get(from)?.1, self.places.get(to)?.1);
        Some(flown_s.max(self.climb_s(from_m, to_m)))
    }

    /// Why the lines of a manoeuvre are not allowed from `begin_s` to `end_s`; none where they are.
    pub(crate) fn lines_trouble(
        &mut self,
        target: usize,
        manoeuvre: usize,
        begin_s: f64,
        end_s: f64,
    ) -> Option<String> {
        let key = (target, manoeuvre, self.zone_span(begin_s, end_s));
        if let Some(known) = self.lines.get(&key) {
            return known.clone();
        }
        let (entry, altitude_m) = place(self.problem, Node::Entry(target, manoeuvre));
        let extent = Extent { altitude_m_min: altitude_m, altitude_m_max: altitude_m, from_s: begin_s, until_s: end_s };
        let lines = self.problem.targets.get(target).and_then(|target| target.manoeuvres.get(manoeuvre));
        let lines = lines.map_or(&[][..], |manoeuvre| &manoeuvre.lines);
        self.work += 2 * UNITS_PER_LEG_TEST * lines.len() as u64;
        let turns = lines.iter().zip(lines.iter().skip(1)).map(|((_, from), (to, _))| (*from, *to));
        let mut legs = lines.iter().copied().chain(turns);
        let trouble = self.router.place_trouble(entry, extent);
        let trouble = trouble.or_else(|| legs.find_map(|(from, to)| self.router.leg_trouble(from, to, extent)));
        let trouble = trouble.map(|trouble| trouble.to_string());
        self.lines.insert(key, trouble.clone());
        trouble
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

    /// Between which changes of zones the times lie: which zones count is the same for all flights of one such span.
    fn zone_span(&self, from_s: f64, until_s: f64) -> ZoneSpan {
        let at = |time_s: f64| self.zone_changes_s.partition_point(|change_s| *change_s <= time_s);
        (at(from_s), at(until_s))
    }
}

/// A travel time given as a number; none where there is no way.
fn given_s(travel: &TravelTimes, from: Node, to: Node) -> Option<f64> {
    let time_s = match (from, to) {
        (Node::Start, Node::Entry(to, _)) => travel.start_to(to),
        (Node::Exit(from, _), Node::Entry(to, _)) => travel.between(from, to),
        (Node::Exit(from, _), Node::Base) => travel.to_base(from),
        _ => UNREACHABLE_S,
    };
    (time_s < UNREACHABLE_S).then_some(time_s)
}

/// Where a node is and at which altitude.
fn place(problem: &SingleVisitProblem, node: Node) -> (Position, f64) {
    let cruise_m = problem.vehicle.cruise_altitude_m;
    let of = |target: usize, manoeuvre: usize, entry: bool| {
        let target = problem.targets.get(target);
        let manoeuvre = target.and_then(|target| target.manoeuvres.get(manoeuvre));
        let overhead = target.map_or(problem.start, |target| target.position);
        let line = manoeuvre.and_then(|m| if entry { m.lines.first() } else { m.lines.last() });
        let position = line.map_or(overhead, |(from, to)| if entry { *from } else { *to });
        (position, manoeuvre.map_or(cruise_m, |manoeuvre| manoeuvre.altitude_m))
    };
    match node {
        Node::Start => (problem.start, problem.start_altitude_m),
        Node::Base => (problem.base.unwrap_or(problem.start), cruise_m),
        Node::Entry(target, manoeuvre) => of(target, manoeuvre, true),
        Node::Exit(target, manoeuvre) => of(target, manoeuvre, false),
    }
}
