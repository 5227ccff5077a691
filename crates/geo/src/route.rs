//! Ways around airspace and within reach of landing places: shortest path over a visibility graph.
//!
//! Nodes are the two ends, the turning points of zones and the landing places. Bound: O(n^2) leg tests for n nodes, of
//! which there are at most [`NODES_MAX`].

use crate::airspace::{Airspace, AirspaceTrouble, Extent};
use crate::geodesy::{self, Position};
use crate::landing::{self, LandingPlace};

/// Nodes of one search: fifty zones of ten corners.
pub const NODES_MAX: usize = 1_000;

/// What a way must obey.
#[derive(Clone, Debug)]
pub struct Router {
    airspace: Airspace,
    landing_places: Vec<LandingPlace>,
    landing_distance_m_max: Option<f64>,
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
        Router { airspace, landing_places, landing_distance_m_max }
    }

    /// The airspace that ways obey.
    pub fn airspace(&self) -> &Airspace {
        &self.airspace
    }

    /// Why it is not allowed to be at `position`.
    pub fn place_trouble(&self, position: Position, extent: Extent) -> Option<NoRoute> {
        if let Some(trouble) = self.airspace.place_trouble(position, extent) {
            return Some(NoRoute::Airspace(trouble));
        }
        let limit_m = self.landing_distance_m_max?;
        let distance_m =
            landing::nearest(&self.landing_places, position).map_or(f64::INFINITY, |(_, distance_m)| distance_m);
        (distance_m > limit_m).then_some(NoRoute::Landing { distance_m })
    }

    /// Why the straight leg is not allowed.
    pub fn leg_trouble(&self, from: Position, to: Position, extent: Extent) -> Option<NoRoute> {
        if let Some(trouble) = self.airspace.leg_trouble(from, to, extent) {
            return Some(NoRoute::Airspace(trouble));
        }
        let limit_m = self.landing_distance_m_max?;
        (!landing::leg_is_within(&self.landing_places, from, to, limit_m))
            .then_some(NoRoute::Landing { distance_m: limit_m })
    }

    /// The shortest way over ground that is allowed in all of `extent`: both ends and the turning points between.
    ///
    /// # Errors
    /// What stands in the way.
    pub fn route(&self, from: Position, to: Position, extent: Extent) -> Result<Vec<Position>, NoRoute> {
        let Some(direct) = self.leg_trouble(from, to, extent) else { return Ok(vec![from, to]) };
        if let Some(trouble) = self.place_trouble(from, extent).or_else(|| self.place_trouble(to, extent)) {
            return Err(trouble);
        }
        let plane = *self.airspace.plane();
        let turns = self.airspace.turning_points(extent).into_iter().map(|point| plane.position(point));
        let places = self.landing_places.iter().map(|place| place.position);
        let mut nodes = vec![from, to];
        let usable = turns.chain(places.filter(|_| self.landing_distance_m_max.is_some()));
        nodes.extend(usable.filter(|node| self.place_trouble(*node, extent).is_none()).take(NODES_MAX));
        self.shortest(&nodes, extent).ok_or(direct)
    }

    /// A* from node 0 to node 1; legs are tested only when they could matter.
    fn shortest(&self, nodes: &[Position], extent: Extent) -> Option<Vec<Position>> {
        let goal = *nodes.get(1)?;
        let to_goal_m: Vec<f64> = nodes.iter().map(|node| geodesy::distance_m(*node, goal)).collect();
        let mut reached: Vec<(f64, usize)> = nodes.iter().map(|_| (f64::INFINITY, 0)).collect();
        *reached.first_mut()? = (0.0, 0);
        let mut open: Vec<usize> = (0..nodes.len()).collect();
        loop {
            let estimate = |node: usize| {
                let travelled_m = reached.get(node).map_or(f64::INFINITY, |(travelled_m, _)| *travelled_m);
                travelled_m + to_goal_m.get(node).copied().unwrap_or(f64::INFINITY)
            };
            let slot = (0..open.len()).min_by(|a, b| {
                let (a, b) = (open.get(*a).copied().unwrap_or(0), open.get(*b).copied().unwrap_or(0));
                estimate(a).total_cmp(&estimate(b)).then(a.cmp(&b))
            })?;
            let node = open.swap_remove(slot);
            let (travelled_m, _) = *reached.get(node)?;
            if !travelled_m.is_finite() {
                return None;
            }
            if node == 1 {
                break;
            }
            let here = *nodes.get(node)?;
            for next in &open {
                let there = *nodes.get(*next)?;
                let total_m = travelled_m + geodesy::distance_m(here, there);
                let entry = reached.get_mut(*next)?;
                if total_m < entry.0 && self.leg_trouble(here, there, extent).is_none() {
                    *entry = (total_m, node);
                }
            }
        }
        let mut path = vec![goal];
        let mut node = 1;
        while node != 0 && path.len() <= nodes.len() {
            node = reached.get(node)?.1;
            path.push(*nodes.get(node)?);
        }
        path.reverse();
        Some(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
