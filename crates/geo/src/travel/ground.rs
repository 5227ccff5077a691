//! Permitted positions and legs, by time: zones, corridors and the reach of landing places.
//!
//! Bound: a leg is compared with the zones whose boxes it meets, O(corners) each.

use super::boxes::Boxes;
use super::course::Block;
use super::error::TravelError;
use super::path_vertices::{PathVertex, path_vertices};
use super::solid::Solid;
use super::spans::{Span, gaps, merged};
use crate::direction::Direction;
use crate::landing::{self, Reach};
use crate::plane::{Plane, Point};
use apex_model::problem::Position;

/// All of time.
const ALWAYS: Span = (f64::NEG_INFINITY, f64::INFINITY);
/// Relative tolerance of margins: a path that touches a margin keeps it.
const TOUCH: f64 = 1e-9;

/// A zone on the plane.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Zone {
    pub(crate) name: String,
    /// True for a permitted zone, false for a restricted one.
    pub(crate) keep_in: bool,
    pub(crate) solid: Solid,
    /// Distance to be kept.
    pub(crate) margin: f64,
    /// Distance from its corners at which ways bend, no less than the margin.
    pub(crate) bend_radius: f64,
    /// Greatest number of units of the plane for a metre on the ground.
    pub(crate) stretch: f64,
    /// Active times, merged; infinite if they do not end in the considered time.
    pub(crate) active_s: Vec<Span>,
}

impl Zone {
    fn is_always_active(&self) -> bool {
        self.active_s.first() == Some(&ALWAYS)
    }
}

/// A place prepared for queries about legs.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PreparedPoint {
    pub(crate) position: Position,
    pub(crate) direction: Direction,
    pub(crate) point: Point,
    /// Zones closer than their margin, with their distance: a leg from this place need not keep more.
    close: Vec<(usize, f64)>,
    /// Bend at this place; `None` if paths may pass the place in every direction.
    bend: Option<PathVertex>,
    /// True for a destination, false for a point that is only passed.
    is_place: bool,
}

impl PreparedPoint {
    /// Returns true if a leg in direction `along`, to or from this place, can be part of a shortest path.
    pub(crate) fn takes(&self, along: Point) -> bool {
        self.bend.is_none_or(|bend| bend.takes(along))
    }
}

/// All constraints of paths.
#[derive(Clone, Debug)]
pub(crate) struct PathConstraints {
    zones: Vec<Zone>,
    tree: Boxes,
    /// The permitted zones: for each interval of time the active ones.
    corridors: Vec<(Span, Vec<usize>)>,
    reach: Option<Reach>,
    plane: Option<Plane>,
}

impl PathConstraints {
    pub(crate) fn new(
        zones: Vec<Zone>,
        must_stay: bool,
        reach: Option<Reach>,
        plane: Option<Plane>,
        (begin_s, end_s): Span,
    ) -> PathConstraints {
        let boxes = zones.iter().map(|zone| {
            // Permitted zones are checked for every leg, without boxes. Chords of turns keep slightly more than the margin
            // ([`PathConstraints::blocks_wider`]).
            let margin = zone.margin + 2.0 * super::turns::TOLERANCE_SHARE * zone.bend_radius;
            let margin = if zone.keep_in { f64::NEG_INFINITY } else { margin };
            let by = Point { x: margin, y: margin };
            (zone.solid.low.minus(by), zone.solid.high.plus(1.0, by))
        });
        let tree = Boxes::new(boxes);
        let mut changes_s: Vec<f64> = vec![f64::NEG_INFINITY, f64::INFINITY];
        let permitted = zones.iter().filter(|zone| zone.keep_in).flat_map(|zone| &zone.active_s);
        changes_s.extend(permitted.flat_map(|(from_s, until_s)| [*from_s, *until_s]));
        changes_s.sort_by(f64::total_cmp);
        changes_s.dedup();
        let active = |span: Span| {
            let middle_s = 0.5 * (span.0.max(begin_s) + span.1.min(end_s));
            let holds =
                |zone: &Zone| zone.active_s.iter().any(|(from_s, until_s)| *from_s <= middle_s && middle_s < *until_s);
            let numbers = zones.iter().enumerate().filter(|(_, zone)| zone.keep_in && holds(zone));
            (span, numbers.map(|(number, _)| number).collect::<Vec<usize>>())
        };
        let spans = changes_s.iter().copied().zip(changes_s.iter().copied().skip(1));
        let corridors = if must_stay { spans.map(active).collect() } else { Vec::new() };
        PathConstraints { zones, tree, corridors, reach, plane }
    }

    /// Returns the instants at which a zone opens or closes, in order.
    pub(crate) fn changes_s(&self) -> Vec<f64> {
        let ends = self.zones.iter().flat_map(|zone| &zone.active_s).flat_map(|(from_s, until_s)| [*from_s, *until_s]);
        let mut changes_s: Vec<f64> = ends.filter(|time_s| time_s.is_finite()).collect();
        changes_s.sort_by(f64::total_cmp);
        changes_s.dedup();
        changes_s
    }

    /// Prepares `position`.
    pub(crate) fn spot(&self, position: Position) -> Result<PreparedPoint, TravelError> {
        let direction = Direction::of(position);
        let point = match &self.plane {
            Some(plane) => plane.project(position).filter(|point| point.x.is_finite() && point.y.is_finite()),
            None => None,
        };
        // Without zones the projection does not matter.
        let point = match point {
            Some(point) => point,
            None if self.zones.is_empty() && direction.dot(direction).is_finite() => Point::default(),
            None => return Err(TravelError::TooFar),
        };
        Ok(self.spot_at(position, direction, point))
    }

    /// Prepares a point of the plane.
    pub(crate) fn spot_on_plane(&self, point: Point) -> Result<PreparedPoint, TravelError> {
        if !(point.x.is_finite() && point.y.is_finite()) {
            return Err(TravelError::TooFar);
        }
        Ok(self.spot_at(Position::default(), Direction::default(), point))
    }

    fn spot_at(&self, position: Position, direction: Direction, point: Point) -> PreparedPoint {
        let mut close = Vec::new();
        self.tree.any(point, point, |number| {
            if let Some(zone) = self.zones.get(number).filter(|zone| !zone.keep_in && zone.margin > 0.0) {
                let distance = zone.solid.distance(point);
                if distance < zone.margin {
                    close.push((number, distance));
                }
            }
            false
        });
        PreparedPoint { position, direction, point, close, bend: None, is_place: true }
    }

    /// Returns the places where ways may bend: around zones' corners and where the reaches of two landing places meet.
    pub(crate) fn path_vertices(&self) -> Vec<PreparedPoint> {
        let mut found = Vec::new();
        for zone in &self.zones {
            for bend in path_vertices(&zone.solid, zone.keep_in, zone.bend_radius) {
                let position = self.plane.map_or(Position::default(), |plane| plane.position(bend.point));
                let direction = self.plane.map_or(Direction::default(), |_| Direction::of(position));
                let spot = PreparedPoint {
                    position,
                    direction,
                    point: bend.point,
                    close: Vec::new(),
                    bend: Some(bend),
                    is_place: false,
                };
                if !self.is_always_shut(&spot) {
                    found.push(spot);
                }
            }
        }
        for position in self.reach.as_ref().map(Reach::crossings).unwrap_or_default() {
            if let Ok(spot) = self.spot(position) {
                let spot = PreparedPoint { close: Vec::new(), is_place: false, ..spot };
                if !self.is_always_shut(&spot) {
                    found.push(spot);
                }
            }
        }
        found
    }

    fn is_always_shut(&self, spot: &PreparedPoint) -> bool {
        let reach = self.reach.as_ref();
        self.open_s(spot).is_empty() || reach.is_some_and(|reach| !reach.holds(spot.position, spot.direction))
    }

    /// Returns the times at which `spot` is allowed.
    pub(crate) fn open_s(&self, spot: &PreparedPoint) -> Vec<Span> {
        let mut shut = Vec::new();
        self.tree.any(spot.point, spot.point, |number| {
            if let Some(zone) = self.zones.get(number).filter(|zone| !zone.keep_in) {
                let margin = self.margin(number, zone, spot, spot);
                if zone.solid.meets(spot.point, spot.point, margin) {
                    shut.extend(zone.active_s.iter().copied());
                }
            }
            false
        });
        shut.extend(self.corridors.iter().filter(|(_, among)| !self.permits(spot.point, among)).map(|(span, _)| *span));
        gaps(ALWAYS, &merged(shut, 0.0))
    }

    /// Returns a prepared point of a leg's turns: near zones it need not keep more distance than the leg's ends.
    pub(crate) fn between(
        &self,
        (from, to): (&PreparedPoint, &PreparedPoint),
        position: Position,
        point: Point,
    ) -> Option<PreparedPoint> {
        let direction = Direction::of(position);
        let point = match &self.plane {
            Some(plane) => plane.project(position).or(self.zones.is_empty().then(Point::default))?,
            None => point,
        };
        let mut close = from.close.clone();
        for (number, distance) in &to.close {
            match close.iter_mut().find(|(known, _)| known == number) {
                Some((_, known)) => *known = known.min(*distance),
                None => close.push((*number, *distance)),
            }
        }
        Some(PreparedPoint { position, direction, point, close, bend: None, is_place: false })
    }

    /// Returns the obstacle at `spot` at some time of the interval; `None` if flight is permitted there during the whole interval.
    pub(crate) fn place_trouble(&self, spot: &PreparedPoint, (from_s, until_s): Span) -> Option<TravelError> {
        let meets = |(begin_s, end_s): &Span| *begin_s <= until_s && from_s < *end_s;
        let mut inside = None;
        self.tree.any(spot.point, spot.point, |number| {
            let zone = self.zones.get(number).filter(|zone| !zone.keep_in && zone.active_s.iter().any(meets));
            inside =
                zone.filter(|zone| zone.solid.holds(spot.point)).map(|zone| TravelError::Inside(zone.name.clone()));
            inside.is_some()
        });
        if inside.is_some() {
            return inside;
        }
        let mut outside = self.corridors.iter().filter(|(span, _)| meets(span));
        if outside.any(|(_, among)| !self.permits(spot.point, among)) {
            return Some(TravelError::Outside);
        }
        let reach = self.reach.as_ref()?;
        if reach.holds(spot.position, spot.direction) {
            return None;
        }
        let nearest = landing::nearest(reach.places(), spot.position);
        Some(TravelError::NoLandingPlace(nearest.map_or(f64::INFINITY, |(_, distance_m)| distance_m)))
    }

    /// Returns the closed parts of the leg with their times; empty if no part is closed.
    ///
    /// # Errors
    /// The obstacle, if a part is closed forever.
    pub(crate) fn blocks(&self, from: &PreparedPoint, to: &PreparedPoint) -> Result<Vec<Block>, TravelError> {
        self.blocks_wider(from, to, 0.0)
    }

    /// Like [`PathConstraints::blocks`], where margins that the ends keep are wider by `more`.
    ///
    /// # Errors
    /// Like [`PathConstraints::blocks`].
    pub(crate) fn blocks_wider(
        &self,
        from: &PreparedPoint,
        to: &PreparedPoint,
        more: f64,
    ) -> Result<Vec<Block>, TravelError> {
        let mut blocks = Vec::new();
        let mut trouble = None;
        let (a, b) = (from.point, to.point);
        self.tree.any(a, b, |number| {
            let Some(zone) = self.zones.get(number).filter(|zone| !zone.keep_in) else { return false };
            let kept = self.margin(number, zone, from, to);
            let margin = if kept >= zone.margin * (1.0 - TOUCH) { kept + more } else { kept };
            if zone.is_always_active() {
                if zone.solid.meets(a, b, margin) {
                    trouble = Some(TravelError::Crosses(zone.name.clone()));
                }
            } else {
                for part in zone.solid.near(a, b, margin) {
                    blocks.extend(zone.active_s.iter().map(|time_s| Block { part, time_s: *time_s }));
                }
            }
            trouble.is_some()
        });
        if let Some(trouble) = trouble {
            return Err(trouble);
        }
        for (time_s, among) in &self.corridors {
            let outside = self.outside(a, b, among);
            if *time_s == ALWAYS && !outside.is_empty() {
                return Err(TravelError::LeavesPermitted);
            }
            blocks.extend(outside.into_iter().map(|part| Block { part, time_s: *time_s }));
        }
        let reach = self.reach.as_ref().filter(|reach| {
            let exact = from.is_place && to.is_place;
            !reach.holds_leg((from.position, from.direction), (to.position, to.direction), exact)
        });
        reach.map_or(Ok(blocks), |reach| Err(TravelError::LeavesReach(reach.distance_m_max())))
    }

    /// Returns true if everything within `width` of a leg keeps every zone's margin reduced by `slack`, at all times, however close its
    /// ends are. False if several permitted zones contain parts of the leg, or landing places limit it: these are evaluated for lines
    /// only.
    pub(crate) fn is_clear(&self, from: &PreparedPoint, to: &PreparedPoint, (width, slack): (f64, f64)) -> bool {
        let (a, b) = (from.point, to.point);
        let wide = |zone: &Zone| width * zone.stretch * (1.0 + super::turns::TOLERANCE_SHARE);
        let kept = |zone: &Zone| (zone.margin - slack * zone.stretch).max(0.0) * (1.0 - TOUCH);
        let mut restricted = self.zones.iter().filter(|zone| !zone.keep_in);
        if self.reach.is_some() || restricted.any(|zone| zone.solid.meets(a, b, kept(zone) + wide(zone))) {
            return false;
        }
        let mut permitted = self.zones.iter().filter(|zone| zone.keep_in && zone.is_always_active());
        self.corridors.is_empty()
            || permitted.any(|zone| {
                let corners = zone.solid.corners();
                crate::plane::inside(a, corners) && crate::plane::segment_to_edges(a, b, corners) >= wide(zone)
            })
    }

    /// Returns the obstacle of a leg at some time of `time_s`, even if a path leads around the obstacle; `None` if the leg is permitted.
    pub(crate) fn leg_trouble(
        &self,
        from: &PreparedPoint,
        to: &PreparedPoint,
        (from_s, until_s): Span,
    ) -> Option<TravelError> {
        let meets = |(begin_s, end_s): &Span| *begin_s <= until_s && from_s < *end_s;
        let mut crossed = None;
        self.tree.any(from.point, to.point, |number| {
            let zone = self.zones.get(number).filter(|zone| !zone.keep_in && zone.active_s.iter().any(meets));
            crossed = zone
                .filter(|zone| zone.solid.meets(from.point, to.point, self.margin(number, zone, from, to)))
                .map(|zone| TravelError::LegCrosses(zone.name.clone()));
            crossed.is_some()
        });
        if crossed.is_some() {
            return crossed;
        }
        let mut corridors = self.corridors.iter().filter(|(span, _)| meets(span));
        if corridors.any(|(_, among)| !self.outside(from.point, to.point, among).is_empty()) {
            return Some(TravelError::LegLeavesPermitted);
        }
        let reach = self.reach.as_ref()?;
        let held = reach.holds_leg((from.position, from.direction), (to.position, to.direction), true);
        (!held).then(|| TravelError::LeavesReach(reach.distance_m_max()))
    }

    /// Returns the margin of a zone for a leg: no more than its ends keep.
    fn margin(&self, number: usize, zone: &Zone, from: &PreparedPoint, to: &PreparedPoint) -> f64 {
        let kept = |spot: &PreparedPoint| {
            spot.close.iter().find(|(close, _)| *close == number).map_or(zone.margin, |(_, d)| *d)
        };
        kept(from).min(kept(to)) * (1.0 - TOUCH)
    }

    fn permits(&self, point: Point, among: &[usize]) -> bool {
        let mut solids = among.iter().filter_map(|number| self.zones.get(*number)).map(|zone| &zone.solid);
        solids.any(|solid| crate::plane::inside(point, solid.corners()) || solid.distance(point) <= solid.tolerance)
    }

    /// Returns the parts of the leg that are in none of the permitted zones `among`.
    fn outside(&self, a: Point, b: Point, among: &[usize]) -> Vec<Span> {
        let along = b.minus(a);
        let solids = || among.iter().filter_map(|number| self.zones.get(*number)).map(|zone| &zone.solid);
        let mut cuts: Vec<f64> = solids().flat_map(|solid| solid.pieces(a, b)).flat_map(|(s, t)| [s, t]).collect();
        cuts.extend([0.0, 1.0]);
        cuts.sort_by(f64::total_cmp);
        let blur = solids().fold(0.0, |most: f64, solid| most.max(2.0 * solid.tolerance)) / along.length();
        let pieces = cuts.iter().copied().zip(cuts.iter().copied().skip(1)).filter(|(s, t)| t - s > blur);
        let pieces: Vec<Span> = if along.length() > 0.0 { pieces.collect() } else { vec![(0.0, 1.0)] };
        let left = |(s, t): &Span| !self.permits(a.plus(0.5 * (s + t), along), among);
        merged(pieces.into_iter().filter(left).collect(), 1e-12)
    }
}
