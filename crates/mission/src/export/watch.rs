//! Path of a surveillance plan: from place to place, or from circle to circle.

use super::chart::{ChartPoint, ChartVisit, Circle, bends};
use apex_geo::travel::Circling;
use apex_model::problem::{Position, SurveillanceVisit};
use apex_planning::surveillance::travel::SurveillanceTravel;

/// A plan of surveillance followed visit by visit.
pub(super) struct VisitFollower {
    ways: Option<SurveillanceTravel>,
    /// Last position of the vehicle.
    before: Option<ChartPoint>,
    from: Option<usize>,
    /// Position of the vehicle on the circle of the last target.
    on: Option<Circling>,
    depart_s: f64,
}

impl VisitFollower {
    /// Returns a path builder at the start, with the travel computation if it is known.
    pub(super) fn new(ways: Option<SurveillanceTravel>, start: Option<ChartPoint>) -> VisitFollower {
        VisitFollower { ways, before: start, from: None, on: None, depart_s: 0.0 }
    }

    /// Returns the next visit, to the target of number `to`.
    pub(super) fn visit(&mut self, (to, here): (usize, ChartPoint), visit: &SurveillanceVisit) -> ChartVisit {
        let route = self.ways.as_mut().map_or_else(Vec::new, |ways| ways.route(self.from, to, self.depart_s));
        let between: Vec<ChartPoint> = bends(&route, here.altitude_m).collect();
        let mut drawn = ChartVisit {
            target: visit.target.clone(),
            way: Vec::new(),
            lines: Vec::new(),
            circle: None,
            arrive_s: visit.arrive_s,
            begin_s: visit.arrive_s,
            end_s: visit.end_s,
        };
        let at = |position: Position| ChartPoint { position, altitude_m: here.altitude_m };
        let place = match self.ways.as_mut().filter(|ways| ways.circle_radius_m() > 0.0) {
            Some(ways) => {
                let (path, there) = ways.flown((self.from, Some(to)), self.on, self.depart_s);
                let look = there.map(|there| ways.look(to, there, (visit.arrive_s, visit.end_s)));
                let (look, after) = look.unzip();
                // A piece begins within a metre of the end of the previous one, because each is computed on its own plane.
                let joined = usize::from(self.from.is_some());
                drawn.way = self.before.into_iter().chain(path.into_iter().skip(joined).map(at)).collect();
                drawn.lines = look.unwrap_or_default().into_iter().skip(1).map(at).collect();
                drawn.circle = Some(Circle { centre: here, bends: between });
                self.on = after;
                drawn.lines.last().or(drawn.way.last()).copied().unwrap_or(here)
            }
            None => {
                drawn.way = self.before.into_iter().chain(between).chain([here]).collect();
                here
            }
        };
        (self.before, self.from, self.depart_s) = (Some(place), Some(to), visit.end_s);
        drawn
    }

    /// Returns the path from the last visit to the base; empty if nothing was visited.
    pub(super) fn home(&mut self, base: ChartPoint) -> Vec<ChartPoint> {
        let Some(before) = self.before else { return Vec::new() };
        let route = self.ways.as_mut().zip(self.from).map_or_else(Vec::new, |(ways, from)| {
            match ways.circle_radius_m() > 0.0 {
                true => ways.flown((Some(from), None), self.on, self.depart_s).0,
                false => ways.route_to_base(from, self.depart_s),
            }
        });
        [before].into_iter().chain(bends(&route, before.altitude_m)).chain([base]).collect()
    }
}
