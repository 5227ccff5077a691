//! Lines over ground of which a part lies below zones that stay closed: the open parts of a sweep, and lines along the edge of a zone, from
//! which a scanner sees some of the ground below it.
//!
//! A line is open where it keeps the distance that ways keep from zones. Where a zone ends it, space for turning away is left, and in front
//! of its beginning also the lead-in.
//! Bound: O(lines x edges of zones) for cutting, O(cells x lines) for the selection; lines are laid along at most [`CHORDS_MAX`] sides of
//! each zone.

use super::altitudes::zones_closed;
use super::open_spans::open_spans;
use super::wish::Wish;
use crate::vehicle::turn_radius_m;
use crate::ways::lead_in_s;
use apex_geo::plane::{Plane, Point, point_to_segment};
use apex_geo::wind;
use apex_model::problem::{AirspaceZone, Position};

/// Distance kept from a zone as a multiple of the margin of ways, and beyond it: ways to the line need some space.
const MARGIN_SHARE: f64 = 1.1;
const MARGIN_MORE_M: f64 = 100.0;
/// Space for turning away from a zone, in radii.
const TURN_RADII: f64 = 2.5;
/// Part of the distance to keep that a line is never nearer to a zone.
const KEPT_SHARE: f64 = 0.99;
/// Maximum number of sides of a zone along which lines are laid; consecutive edges of a zone with more corners count as one side.
const CHORDS_MAX: usize = 40;
/// A shorter part of a line is not flown.
const PART_M_MIN: f64 = 500.0;
/// Distance between lines along an edge, as a share of the swath; such a line begins and ends this far outside of the ground: the scanner
/// looks ahead, and is on after a second.
const SPACING: f64 = 0.9;
const RUN_IN_M: f64 = 700.0;
/// Maximum number of lines along one edge of a zone.
const ROWS_MAX: usize = 200;
/// Greatest number of parts of lines that are flown.
const PARTS_MAX: usize = 200;

/// A line on the plane of the target.
type FlatLine = (Point, Point);

/// Zones that stay closed at one altitude, next to the ground of a target.
pub(super) struct ClosedGround<'a> {
    wish: &'a Wish<'a>,
    plane: Plane,
    zones: Vec<Vec<Point>>,
    /// Distance kept from zones.
    keep_m: f64,
    /// Space for turning away, and length of the lead-in.
    turn_m: f64,
    lead_m: f64,
    /// Middles of the wanted cells with their weights.
    cells: Vec<(Point, f64)>,
}

impl<'a> ClosedGround<'a> {
    /// Returns the zones around a target that stay closed at an altitude; `None` if there are none.
    pub(super) fn new(wish: &'a Wish<'a>, altitude_m: f64) -> Option<ClosedGround<'a>> {
        let plane = Plane::new(wish.target.position);
        let flat = |zone: &AirspaceZone| zone.corners.iter().filter_map(|corner| plane.project(*corner)).collect();
        let zones: Vec<Vec<Point>> = zones_closed(wish, altitude_m).map(flat).collect();
        if zones.is_empty() {
            return None;
        }
        let grid = &wish.fire.grid;
        let middles = grid.centres().zip(grid.weights()).filter(|(_, weight)| **weight > 0.0);
        let cells = middles.filter_map(|((x, y), weight)| {
            let position = grid.plane().position(Point { x, y });
            Some((plane.project(position)?, *weight))
        });
        let model = &wish.mission.model;
        let fastest_mps = model.true_airspeed_m_s_cruise + wind::speed_mps_max(&wish.mission.forecast);
        let cells = cells.collect();
        Some(ClosedGround {
            wish,
            plane,
            zones,
            keep_m: MARGIN_SHARE * wish.mission.requirements.zone_margin_m + MARGIN_MORE_M,
            turn_m: TURN_RADII * turn_radius_m(model),
            lead_m: if turn_radius_m(model) > 0.0 { lead_in_s(model) * fastest_mps } else { 0.0 },
            cells,
        })
    }

    /// Returns the open parts of the lines of a sweep, in the order in which they are flown, and the share of the ground within half a
    /// swath of them; `None` if no part is left.
    pub(super) fn cut(&self, lines: &[(Position, Position)], swath_m: f64) -> Option<OpenLines> {
        let flat = |(from, to): &(Position, Position)| Some((self.plane.project(*from)?, self.plane.project(*to)?));
        self.in_order(lines.iter().filter_map(flat), swath_m)
    }

    /// Returns lines along the edge of a zone from which most of the ground is seen, and their share of it; `None` without such lines.
    pub(super) fn along_edge(&self, swath_m: f64) -> Option<OpenLines> {
        let mut best: Option<OpenLines> = None;
        for side in self.zones.iter().flat_map(|corners| sides(corners)) {
            let (Some(from), Some(to)) = (side.first(), side.last()) else { continue };
            let Some(along) = to.minus(*from).unit() else { continue };
            let left = Point { x: -along.y, y: along.x };
            for out in [left, Point { x: -left.x, y: -left.y }] {
                let farthest_m = side.iter().map(|corner| out.dot(corner.minus(*from))).fold(0.0, f64::max);
                let from = from.plus(farthest_m, out);
                let rows = self.rows((from, along, out), swath_m);
                let Some(found) = self.in_order(rows.into_iter(), swath_m) else { continue };
                if best.as_ref().is_none_or(|best| found.share > best.share) {
                    best = Some(found);
                }
            }
        }
        best
    }

    /// Returns lines along the edge through `from`, the first as near to it as lines may be, each as long as the ground in its swath.
    fn rows(&self, (from, along, out): (Point, Point, Point), swath_m: f64) -> Vec<FlatLine> {
        let seen: Vec<(f64, f64)> =
            self.cells.iter().map(|(middle, _)| (along.dot(middle.minus(from)), out.dot(middle.minus(from)))).collect();
        let farthest_m = seen.iter().map(|(_, aside_m)| *aside_m).fold(f64::NEG_INFINITY, f64::max);
        let mut rows = Vec::new();
        for row in 0..ROWS_MAX {
            let aside_m = self.keep_m + row as f64 * SPACING * swath_m;
            let below = seen.iter().filter(|(_, cell_m)| (cell_m - aside_m).abs() <= 0.5 * swath_m);
            let (low_m, high_m) =
                below.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (at, _)| (low.min(*at), high.max(*at)));
            if low_m <= high_m {
                let at = |along_m: f64| from.plus(along_m, along).plus(aside_m, out);
                rows.push((at(low_m - RUN_IN_M), at(high_m + RUN_IN_M)));
            }
            if aside_m + 0.5 * swath_m >= farthest_m {
                break;
            }
        }
        rows
    }

    /// Cuts lines, and puts their parts in order. Parts between which a zone lies cannot be flown in sequence: of the groups that
    /// can, the one that sees most is returned; `None` if there is none.
    fn in_order(&self, lines: impl Iterator<Item = FlatLine>, swath_m: f64) -> Option<OpenLines> {
        let both = |(from, to): FlatLine| [(from, to), (to, from)].map(|line| self.can_begin(line).then_some(line));
        let parts = lines.flat_map(|line| self.parts(line)).map(both);
        let mut left: Vec<[Option<FlatLine>; 2]> =
            parts.filter(|part| part.iter().any(Option::is_some)).take(PARTS_MAX).collect();
        let approach = self.plane.project(self.wish.approach)?;
        let mut best: Option<(f64, Vec<FlatLine>)> = None;
        while !left.is_empty() {
            let group = self.group(&mut left, approach);
            let share = self.share(&group, swath_m);
            if share > best.as_ref().map_or(0.0, |(best, _)| *best) {
                best = Some((share, group));
            }
        }
        let (share, group) = best?;
        let positions = group.iter().map(|(from, to)| (self.plane.position(*from), self.plane.position(*to)));
        Some(OpenLines { lines: positions.collect(), share })
    }

    /// Takes the part whose beginning is nearest to `here`, then again and again the nearest of those to which the way is open.
    fn group(&self, left: &mut Vec<[Option<FlatLine>; 2]>, mut here: Point) -> Vec<FlatLine> {
        let mut group: Vec<FlatLine> = Vec::new();
        loop {
            let begins = left.iter().enumerate();
            let begins = begins.flat_map(|(number, part)| part.iter().flatten().map(move |line| (number, *line)));
            let away_m = |line: &FlatLine| line.0.minus(here).length();
            let mut begins: Vec<(usize, FlatLine)> = begins.collect();
            begins.sort_by(|(_, a), (_, b)| away_m(a).total_cmp(&away_m(b)));
            let in_reach = |(_, line): &(usize, FlatLine)| group.is_empty() || self.is_way_open(here, line.0);
            let Some((number, line)) = begins.into_iter().find(in_reach) else { return group };
            left.swap_remove(number);
            here = line.1;
            group.push(line);
        }
    }

    /// Returns the parts of a line that are open and long enough.
    fn parts(&self, (from, to): FlatLine) -> Vec<FlatLine> {
        let length_m = to.minus(from).length();
        let Some(along) = to.minus(from).unit() else { return Vec::new() };
        let runs = open_spans((from, to), &self.zones, KEPT_SHARE * self.keep_m);
        let shortened = runs.into_iter().map(|(begin_m, end_m)| {
            let begin_m = if begin_m > 0.0 { begin_m + self.turn_m } else { begin_m };
            (begin_m, if end_m < length_m { end_m - self.turn_m } else { end_m })
        });
        let kept = shortened.filter(|(begin_m, end_m)| end_m - begin_m >= PART_M_MIN.min(length_m));
        kept.map(|(begin_m, end_m)| (from.plus(begin_m, along), from.plus(end_m, along))).collect()
    }

    /// Returns true if the lead-in of a line is open.
    fn can_begin(&self, (from, to): FlatLine) -> bool {
        to.minus(from).unit().is_some_and(|along| self.is_way_open(from.plus(-self.lead_m, along), from))
    }

    fn is_way_open(&self, from: Point, to: Point) -> bool {
        let length_m = to.minus(from).length();
        let is_whole = |(begin_m, end_m): &(f64, f64)| *begin_m == 0.0 && *end_m == length_m;
        length_m == 0.0 || open_spans((from, to), &self.zones, KEPT_SHARE * self.keep_m).first().is_some_and(is_whole)
    }

    /// Returns the share of the ground within half a swath of lines.
    fn share(&self, lines: &[FlatLine], swath_m: f64) -> f64 {
        let is_near =
            |middle: &Point| lines.iter().any(|(from, to)| point_to_segment(*middle, *from, *to) <= 0.5 * swath_m);
        let total: f64 = self.cells.iter().map(|(_, weight)| weight).sum();
        let near: f64 = self.cells.iter().filter(|(middle, _)| is_near(middle)).map(|(_, weight)| weight).sum();
        if total > 0.0 { near / total } else { 0.0 }
    }
}

/// Returns the sides of a polygon: its edges, or runs of consecutive edges if it has many, each as its corners in order.
fn sides(corners: &[Point]) -> impl Iterator<Item = Vec<Point>> + '_ {
    let edges = corners.len().div_ceil(CHORDS_MAX).max(1);
    let side =
        move |first: usize| corners.iter().cycle().skip(first).take(edges.min(corners.len() - first) + 1).copied();
    (0..corners.len()).step_by(edges).map(move |first| side(first).collect())
}

/// Open lines in the order of their flight.
pub(super) struct OpenLines {
    /// The lines.
    pub(super) lines: Vec<(Position, Position)>,
    /// Share of the ground within half a swath of them.
    pub(super) share: f64,
}
