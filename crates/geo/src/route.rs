//! Ways around airspace and within reach of landing places: shortest path over a visibility graph.
//!
//! Nodes are the two ends, the turning points of zones and the landing places. Legs are tested only when the search comes
//! to them. Bound: O(n^2) leg tests for n nodes, of which there are at most [`NODES_MAX`].

use crate::airspace::{Airspace, AirspaceTrouble, Extent};
use crate::direction::Direction;
use crate::geodesy::Position;
use crate::landing::{self, LandingPlace, Reach};
use crate::plane::Point;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Nodes of one search: fifty zones of ten corners.
pub const NODES_MAX: usize = 1_000;

/// A position made ready for questions about legs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Where it is.
    pub position: Position,
    /// The same as a direction.
    pub direction: Direction,
    /// On the airspace's plane; none too far away.
    point: Option<Point>,
}

/// What a way must obey.
#[derive(Clone, Debug)]
pub struct Router {
    airspace: Airspace,
    reach: Option<Reach>,
    /// Turning points, each with the number of its zone.
    turns: Vec<(usize, Spot)>,
    landings: Vec<Spot>,
}

/// Why there is no way.
#[derive(Clone, Debug, PartialEq)]
pub enum NoRoute {
    /// An end is not allowed, or every way leads through airspace.
    Airspace(AirspaceTrouble),
    /// An end or every way is too far from emergency landing places.
    Landing {
        /// Distance of the worse end from its nearest place; infinite where there is none.
        distance_m: f64,
    },
}

impl std::fmt::Display for NoRoute {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            NoRoute::Airspace(trouble) => trouble.fmt(f),
            NoRoute::Landing { distance_m } if distance_m.is_finite() => {
                write!(f, "the way leaves the reach of every emergency landing place ({:.0} km)", distance_m / 1000.0)
            }
            NoRoute::Landing { .. } => f.write_str("there is no emergency landing place"),
        }
    }
}

impl Router {
    /// A router over `airspace`, within `landing_distance_m_max` of `landing_places` where that is given.
    pub fn new(airspace: Airspace, landing_places: Vec<LandingPlace>, landing_distance_m_max: Option<f64>) -> Router {
        let plane = *airspace.plane();
        let turns = airspace.turning_points().into_iter();
        let turns = turns.map(|(zone, point)| (zone, spot_on(&airspace, plane.position(point)))).collect();
        let reach = landing_distance_m_max.map(|limit_m| Reach::new(landing_places, limit_m));
        let places = reach.as_ref().map_or(&[][..], Reach::places);
        let landings = places.iter().map(|place| spot_on(&airspace, place.position)).collect();
        Router { airspace, reach, turns, landings }
    }

    /// The airspace that ways obey.
    pub fn airspace(&self) -> &Airspace {
        &self.airspace
    }

    /// `position` made ready for this router.
    pub fn spot(&self, position: Position) -> Spot {
        spot_on(&self.airspace, position)
    }

    /// Why it is not allowed to be at `position`.
    pub fn place_trouble(&self, position: Position, extent: Extent) -> Option<NoRoute> {
        if let Some(trouble) = self.airspace.place_trouble(position, extent) {
            return Some(NoRoute::Airspace(trouble));
        }
        let reach = self.reach.as_ref()?;
        if reach.holds(position, Direction::of(position)) {
            return None;
        }
        let nearest = landing::nearest(reach.places(), position);
        Some(NoRoute::Landing { distance_m: nearest.map_or(f64::INFINITY, |(_, distance_m)| distance_m) })
    }

    /// Why the straight leg is not allowed.
    pub fn leg_trouble(&self, from: Position, to: Position, extent: Extent) -> Option<NoRoute> {
        self.trouble_between(&self.spot(from), &self.spot(to), extent)
    }

    /// [`Router::leg_trouble`] for positions made ready.
    pub fn trouble_between(&self, from: &Spot, to: &Spot, extent: Extent) -> Option<NoRoute> {
        let trouble = match (from.point, to.point) {
            _ if self.airspace.zones().next().is_none() => None,
            (Some(a), Some(b)) => self.airspace.segment_trouble(a, b, extent),
            _ => Some(AirspaceTrouble::TooFar),
        };
        if let Some(trouble) = trouble {
            return Some(NoRoute::Airspace(trouble));
        }
        let reach = self.reach.as_ref()?;
        (!reach.holds_leg((from.position, from.direction), (to.position, to.direction)))
            .then(|| NoRoute::Landing { distance_m: reach.distance_m_max() })
    }

    /// The shortest way over ground that is allowed in all of `extent`: both ends and the turning points between.
    ///
    /// # Errors
    /// What stands in the way.
    pub fn route(&self, from: Position, to: Position, extent: Extent) -> Result<Vec<Position>, NoRoute> {
        self.route_between(&self.spot(from), &self.spot(to), extent).0
    }

    /// [`Router::route`] for positions made ready, with the number of legs tested.
    ///
    /// # Errors
    /// The first of the pair: what stands in the way.
    pub fn route_between(&self, from: &Spot, to: &Spot, extent: Extent) -> (Result<Vec<Position>, NoRoute>, usize) {
        let Some(direct) = self.trouble_between(from, to, extent) else {
            return (Ok(vec![from.position, to.position]), 1);
        };
        let end_trouble = self.place_trouble(from.position, extent);
        if let Some(trouble) = end_trouble.or_else(|| self.place_trouble(to.position, extent)) {
            return (Err(trouble), 1);
        }
        let turns = self.turns.iter().filter(|(zone, _)| self.airspace.is_turned_around(*zone, extent));
        let mut nodes = vec![from, to];
        nodes.extend(turns.map(|(_, spot)| spot).chain(&self.landings).take(NODES_MAX));
        let (path, tested) = self.shortest(&nodes, extent);
        (path.ok_or(direct), tested + 1)
    }

    /// A* from node 0 to node 1, with the number of legs tested: a leg is tested when it is the next best to take.
    fn shortest(&self, nodes: &[&Spot], extent: Extent) -> (Option<Vec<Position>>, usize) {
        let goal = nodes.get(1).map(|goal| goal.direction).unwrap_or_default();
        let mut travelled: Vec<Option<(f64, usize)>> = vec![None; nodes.len()];
        let mut open = BinaryHeap::from([Reverse((Length(0.0), 0, 0, Length(0.0)))]);
        let mut tested = 0;
        while let Some(Reverse((_, node, before, Length(total_m)))) = open.pop() {
            let (Some(here), Some(from)) = (nodes.get(node), nodes.get(before)) else { continue };
            let Some(slot @ None) = travelled.get_mut(node) else { continue };
            if node != 0 {
                tested += 1;
                if self.trouble_between(from, here, extent).is_some() {
                    continue;
                }
            }
            *slot = Some((total_m, before));
            if node == 1 {
                return (path_to(1, nodes, &travelled), tested);
            }
            for (next, there) in nodes.iter().enumerate() {
                // The direct leg is known to be refused.
                if travelled.get(next).is_some_and(Option::is_none) && (node, next) != (0, 1) {
                    let length_m = total_m + here.direction.distance_m(there.direction);
                    let hoped_m = length_m + there.direction.distance_m(goal);
                    if hoped_m.is_finite() {
                        open.push(Reverse((Length(hoped_m), next, node, Length(length_m))));
                    }
                }
            }
        }
        (None, tested)
    }
}

fn spot_on(airspace: &Airspace, position: Position) -> Spot {
    Spot { position, direction: Direction::of(position), point: airspace.plane().project(position) }
}

/// The nodes from node 0 to `last`.
fn path_to(last: usize, nodes: &[&Spot], travelled: &[Option<(f64, usize)>]) -> Option<Vec<Position>> {
    let mut path = vec![nodes.get(last)?.position];
    let mut node = last;
    while node != 0 && path.len() <= nodes.len() {
        node = (*travelled.get(node)?)?.1;
        path.push(nodes.get(node)?.position);
    }
    path.reverse();
    Some(path)
}

/// A length by which nodes are sorted.
#[derive(Clone, Copy, Debug)]
struct Length(f64);

impl PartialEq for Length {
    fn eq(&self, other: &Length) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Length {}

impl PartialOrd for Length {
    fn partial_cmp(&self, other: &Length) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Length {
    fn cmp(&self, other: &Length) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geodesy;
    use apex_model::problem::{AirspaceZone, TimeWindow, ZoneKind};
    use proptest::prelude::*;

    fn zone(kind: ZoneKind, corners: &[(f64, f64)]) -> AirspaceZone {
        AirspaceZone {
            name: "Z".to_string(),
            kind,
            corners: corners.iter().map(|(latitude, longitude)| Position::new(*latitude, *longitude)).collect(),
            altitude_m_min: 0.0,
            altitude_m_max: 20_000.0,
            active: TimeWindow::ALWAYS,
        }
    }

    fn router(zones: &[AirspaceZone], margin_m: f64) -> Router {
        let around = [Position::new(35.0, -121.0), Position::new(41.0, -115.0)];
        Router::new(Airspace::new(zones, margin_m, &around).unwrap(), Vec::new(), None)
    }

    fn length_m(route: &[Position]) -> f64 {
        route.windows(2).map(|pair| geodesy::distance_m(pair[0], pair[1])).sum()
    }

    #[test]
    fn a_box_is_passed_on_its_shorter_side() {
        let wall = zone(ZoneKind::Restricted, &[(36.0, -119.0), (36.0, -118.0), (38.0, -118.0), (38.0, -119.0)]);
        let router = router(&[wall], 2000.0);
        let (from, to) = (Position::new(37.6, -120.0), Position::new(37.6, -117.0));
        let route = router.route(from, to, Extent::at(7000.0, 0.0)).unwrap();
        assert!(route.len() > 2 && route.iter().all(|position| position.latitude_deg > 37.5));
        assert!(length_m(&route) < 1.12 * geodesy::distance_m(from, to), "{route:?}");
        for pair in route.windows(2) {
            assert_eq!(router.leg_trouble(pair[0], pair[1], Extent::at(7000.0, 0.0)), None);
        }
    }

    #[test]
    fn a_bent_corridor_is_followed() {
        let bent = [(36.0, -120.0), (36.0, -116.0), (40.0, -116.0), (40.0, -117.0), (37.0, -117.0), (37.0, -120.0)];
        let router = router(&[zone(ZoneKind::Permitted, &bent)], 500.0);
        let (from, to) = (Position::new(36.5, -119.5), Position::new(39.5, -116.5));
        let route = router.route(from, to, Extent::at(7000.0, 0.0)).unwrap();
        assert!(route.len() >= 3, "{route:?}");
        let outside = Position::new(39.0, -119.0);
        let refused = router.route(from, outside, Extent::at(7000.0, 0.0));
        assert_eq!(refused, Err(NoRoute::Airspace(AirspaceTrouble::Outside)));
    }

    #[test]
    fn a_gap_without_landing_places_is_flown_around_over_them() {
        let place = |name: &str, latitude, longitude| LandingPlace {
            name: name.into(),
            position: Position::new(latitude, longitude),
        };
        let places = vec![place("a", 37.0, -121.0), place("b", 38.5, -119.0), place("c", 37.0, -117.0)];
        let airspace = Airspace::new(&[], 0.0, &[]).unwrap();
        let router = Router::new(airspace, places, Some(130_000.0));
        let (from, to) = (Position::new(37.0, -121.0), Position::new(37.0, -117.0));
        let route = router.route(from, to, Extent::at(7000.0, 0.0)).unwrap();
        assert_eq!(route.len(), 3);
        let far = router.route(from, Position::new(30.0, -121.0), Extent::at(7000.0, 0.0));
        assert!(matches!(far, Err(NoRoute::Landing { .. })), "{far:?}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]
        #[test]
        fn routes_obey_what_they_were_made_for(
            boxes in prop::collection::vec((35.5..40.0f64, -120.5..-116.0f64, 0.2..1.2f64, 0.2..1.2f64), 1..5),
            from in (35.0..41.0f64, -121.0..-115.0f64), to in (35.0..41.0f64, -121.0..-115.0f64),
        ) {
            let zones: Vec<AirspaceZone> = boxes.iter().map(|(s, w, h, b)| {
                zone(ZoneKind::Restricted, &[(*s, *w), (*s, w + b), (s + h, w + b), (s + h, *w)])
            }).collect();
            let router = router(&zones, 1000.0);
            let extent = Extent::at(7000.0, 0.0);
            let (from, to) = (Position::new(from.0, from.1), Position::new(to.0, to.1));
            if let Ok(route) = router.route(from, to, extent) {
                for pair in route.windows(2) {
                    prop_assert_eq!(router.leg_trouble(pair[0], pair[1], extent), None);
                    // The naive twin: sample the leg and look for zones one at a time.
                    for step in 0..=50 {
                        let here = geodesy::interpolate(pair[0], pair[1], f64::from(step) / 50.0);
                        prop_assert!(!zones.iter().any(|zone| crate::airspace::inside(zone, here)));
                    }
                }
            } else {
                prop_assert!(router.leg_trouble(from, to, extent).is_some());
            }
        }
    }
}
