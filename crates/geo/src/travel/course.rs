//! A straight leg flown through changing wind: the position of the vehicle by time.
//!
//! Progress is computed exactly: in each step the ground speed is constant from one change of the wind to the next, also if a change
//! occurs within a step. Two vehicles on one leg therefore never overtake each other (first in, first out).
//! Bound: O(1) between changes once a leg is known, O(steps) across a change.

use super::air::{Air, WindStep};
use super::spans::{Span, merged};
use crate::direction::{ARC_RAD_MAX, Direction};
use crate::plane::Point;
use crate::wind::{LEG_STEP_M, LEG_STEPS_MAX};

/// A leg divided into steps of equal length.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Course {
    length: f64,
    steps: Vec<WindStep>,
}

/// Known times of a leg in one of its two directions.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Timing {
    /// For each interval between two changes of the wind the time for the leg; NaN where it has not been computed.
    totals_s: Vec<f64>,
    /// Departures at which the leg cannot be flown, once computed: open intervals, sorted.
    closed: Option<Vec<Span>>,
}

/// A part of a leg that must not be flown at some time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Block {
    /// Part, as shares of the length.
    pub(crate) part: Span,
    /// Interval of time; infinite if it has no end.
    pub(crate) time_s: Span,
}

/// Added to a departure after a closure, so that rounding does not let the vehicle arrive too early.
const LATE_S: f64 = 1e-6;

impl Course {
    /// Returns the course along the great circle between two directions; `None` if one is not finite.
    pub(crate) fn on_earth(from: Direction, to: Direction) -> Option<Course> {
        let length = from.distance_m(to);
        if !length.is_finite() {
            return None;
        }
        let Some(quarter) = from.quarter_turn_to(to).filter(|_| length > 0.0) else {
            return Some(Course { length: 0.0, steps: Vec::new() });
        };
        let angle_rad = from.angle_rad(to);
        let step_m = if angle_rad <= ARC_RAD_MAX { LEG_STEP_M } else { 2.0 * LEG_STEP_M };
        let count = ((length / step_m) as usize + 1).min(LEG_STEPS_MAX);
        let step = |index: usize| {
            let at_rad = (index as f64 + 0.5) / count as f64 * angle_rad;
            let (sine, cosine) = (libm::sin(at_rad), libm::cos(at_rad));
            let middle = from.blended(cosine, quarter, sine);
            let (east, north) = middle.east_north(from.blended(-sine, quarter, cosine));
            let one = libm::hypot(east, north);
            WindStep { middle, track: (east / one, north / one) }
        };
        Some(Course { length, steps: (0..count).map(step).collect() })
    }

    /// Returns the straight course on the plane, where wind is the same everywhere.
    pub(crate) fn on_plane(from: Point, to: Point) -> Option<Course> {
        let along = to.minus(from);
        let length = along.length();
        let step = along.unit().map(|unit| WindStep { middle: Direction::default(), track: (unit.x, unit.y) });
        length.is_finite().then(|| Course { length, steps: step.into_iter().collect() })
    }

    /// Returns the length of the leg.
    pub(crate) fn length(&self) -> f64 {
        self.length
    }

    fn step(&self, index: usize, backwards: bool) -> Option<&WindStep> {
        let index = if backwards { self.steps.len().checked_sub(index + 1)? } else { index };
        self.steps.get(index)
    }

    fn step_length(&self) -> f64 {
        self.length / self.steps.len().max(1) as f64
    }

    /// Returns the instant at which the vehicle that leaves at `depart_s` has passed `share` of the leg.
    pub(crate) fn advance(&self, air: &Air, backwards: bool, depart_s: f64, share: f64) -> f64 {
        let (mut now_s, mut span) = (depart_s, air.span_at(depart_s));
        self.walk(share, |index, whole| {
            let Some(step) = self.step(index, backwards) else { return };
            let mut left = whole;
            loop {
                let speed_mps = air.speed_or_crawl_mps(span, step, backwards);
                let change_s = air.span_ends_s(span).1;
                let end_s = now_s + left / speed_mps;
                if end_s <= change_s {
                    now_s = end_s;
                    return;
                }
                left = (left - (change_s - now_s) * speed_mps).max(0.0);
                (now_s, span) = (change_s, span + 1);
            }
        });
        now_s
    }

    /// Returns the departure with which the vehicle has passed `share` of the leg at `at_s`: inverse of
    /// [`Course::advance`].
    pub(crate) fn retreat(&self, air: &Air, backwards: bool, at_s: f64, share: f64) -> f64 {
        let mut pieces = Vec::with_capacity(self.steps.len());
        self.walk(share, |index, whole| pieces.push((index, whole)));
        let (mut now_s, mut span) = (at_s, air.span_before(at_s));
        for (index, whole) in pieces.into_iter().rev() {
            let Some(step) = self.step(index, backwards) else { continue };
            let mut left = whole;
            loop {
                let speed_mps = air.speed_or_crawl_mps(span, step, backwards);
                let change_s = air.span_ends_s(span).0;
                let begin_s = now_s - left / speed_mps;
                if begin_s >= change_s {
                    now_s = begin_s;
                    break;
                }
                left = (left - (now_s - change_s) * speed_mps).max(0.0);
                (now_s, span) = (change_s, span.saturating_sub(1));
            }
        }
        now_s
    }

    /// Visits the steps up to `share` of the leg, each with its counted length.
    fn walk(&self, share: f64, mut visit: impl FnMut(usize, f64)) {
        let step_length = self.step_length();
        let mut left = share.clamp(0.0, 1.0) * self.length;
        for index in 0..self.steps.len() {
            let last = index + 1 == self.steps.len();
            let piece = if last && share >= 1.0 { step_length } else { left.min(step_length) };
            if piece <= 0.0 {
                return;
            }
            visit(index, piece);
            left -= piece;
        }
    }

    /// Like [`Course::advance`] to the end of the leg; stores the time of a flight between two changes.
    pub(crate) fn arrive(&self, air: &Air, backwards: bool, timing: &mut Timing, depart_s: f64) -> f64 {
        let span = air.span_at(depart_s);
        if timing.totals_s.is_empty() {
            timing.totals_s.resize(air.spans(), f64::NAN);
        }
        let Some(total_s) = timing.totals_s.get_mut(span) else { return f64::INFINITY };
        if total_s.is_nan() {
            let step_length = self.step_length();
            let steps = (0..self.steps.len()).filter_map(|index| self.step(index, backwards));
            *total_s = steps.map(|step| step_length / air.speed_or_crawl_mps(span, step, backwards)).sum();
        }
        let arrive_s = depart_s + *total_s;
        if arrive_s <= air.span_ends_s(span).1 { arrive_s } else { self.advance(air, backwards, depart_s, 1.0) }
    }

    /// Returns the departures at which the leg cannot be flown: the vehicle would be in a block while it is closed, or in a wind that is
    /// too strong.
    pub(crate) fn closed<'a>(
        &self,
        air: &Air,
        backwards: bool,
        blocks: &[Block],
        timing: &'a mut Timing,
    ) -> &'a [Span] {
        timing.closed.get_or_insert_with(|| {
            let winds = if air.may_be_too_strong() { self.winds_too_strong(air, backwards) } else { Vec::new() };
            let blocks = blocks.iter().map(|block| {
                let (from, until) = block.part;
                let part = if backwards { (1.0 - until, 1.0 - from) } else { (from, until) };
                Block { part, ..*block }
            });
            let spans = blocks.chain(winds).map(|block| self.closed_by(air, backwards, &block));
            merged(spans.collect(), 0.0)
        })
    }

    /// Returns the open interval of departures that a block closes. A vehicle that departs after the beginning of this interval has not
    /// passed the part when the block begins; one that departs before its end reaches the part before the block ends.
    fn closed_by(&self, air: &Air, backwards: bool, block: &Block) -> Span {
        let ((from, until), (shut_s, open_s)) = (block.part, block.time_s);
        let first_s = if shut_s.is_finite() { self.retreat(air, backwards, shut_s, until) } else { shut_s };
        let second_s = if open_s.is_finite() { self.retreat(air, backwards, open_s, from) + LATE_S } else { open_s };
        (first_s, second_s)
    }

    /// Returns the steps that cannot be flown while some wind blows.
    fn winds_too_strong(&self, air: &Air, backwards: bool) -> Vec<Block> {
        let count = self.steps.len() as f64;
        let mut found = Vec::new();
        for span in 0..air.spans() {
            for index in 0..self.steps.len() {
                let step = self.step(index, backwards);
                if step.is_some_and(|step| air.speed_mps(span, step, backwards).is_none()) {
                    let part = (index as f64 / count, (index as f64 + 1.0) / count);
                    found.push(Block { part, time_s: air.span_ends_s(span) });
                }
            }
        }
        found
    }
}

/// Returns the first time from `ready_s` on that lies in none of the open intervals `closed`, which are sorted.
pub(crate) fn first_open(closed: &[Span], ready_s: f64) -> f64 {
    let next = closed.partition_point(|(_, until_s)| *until_s <= ready_s);
    match closed.get(next) {
        Some((from_s, until_s)) if *from_s < ready_s => *until_s,
        _ => ready_s,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geodesy;
    use crate::wind::{WindField, WindLayer, leg_time_s};
    use apex_model::problem::{Area, Position};
    use proptest::prelude::*;

    pub(super) fn layer(from_s: f64, until_s: f64, east: f64, north: f64, area: Option<Area>) -> WindLayer {
        let (wind_east_mps, wind_north_mps, edr) = (east, north, 0.0);
        let (altitude_m_min, altitude_m_max) = (0.0, 9000.0);
        WindLayer { area, altitude_m_min, altitude_m_max, from_s, until_s, wind_east_mps, wind_north_mps, edr }
    }

    fn course(from: Position, to: Position) -> Course {
        Course::on_earth(Direction::of(from), Direction::of(to)).unwrap()
    }

    #[test]
    fn a_wind_that_stops_on_the_way_is_flown_exactly() {
        let field = WindField { layers: vec![layer(0.0, 1000.0, -20.0, 0.0, None)], blend: false };
        let air = Air::new(&field, 7000.0, 50.0, 0.0, 1e6);
        let leg = Course::on_plane(Point { x: 0.0, y: 0.0 }, Point { x: 80_000.0, y: 0.0 }).unwrap();
        assert_eq!(leg.advance(&air, false, 0.0, 1.0), 1000.0 + 50_000.0 / 50.0, "30 m/s, then 50 m/s");
        assert_eq!(leg.advance(&air, true, 0.0, 1.0), 1000.0 + 10_000.0 / 50.0, "70 m/s, then 50 m/s");
        assert_eq!(leg.retreat(&air, false, 2000.0, 1.0), 0.0);
        assert_eq!(leg.retreat(&air, false, 1000.0, 0.375), 0.0, "30 km with head wind");
    }

    #[test]
    fn a_vehicle_that_would_be_in_a_closed_block_leaves_earlier_or_later() {
        let air = Air::still(10.0);
        let leg = Course::on_plane(Point { x: 0.0, y: 0.0 }, Point { x: 1000.0, y: 0.0 }).unwrap();
        let block = Block { part: (0.4, 0.6), time_s: (200.0, 300.0) };
        let there = leg.closed(&air, false, &[block], &mut Timing::default()).to_vec();
        assert_eq!(there, [(140.0, 260.0 + LATE_S)], "through by 200 s, or there from 300 s on");
        assert_eq!((first_open(&there, 140.0), first_open(&there, 141.0)), (140.0, 260.0 + LATE_S));
        let back = Block { part: (0.1, 0.2), ..block };
        assert_eq!(leg.closed(&air, true, &[back], &mut Timing::default()), [(110.0, 220.0 + LATE_S)]);
    }

    #[test]
    fn a_head_wind_that_is_too_strong_is_waited_for() {
        let field = WindField { layers: vec![layer(0.0, 1000.0, -60.0, 0.0, None)], blend: false };
        let air = Air::new(&field, 7000.0, 50.0, 0.0, 1e6);
        let leg = Course::on_plane(Point { x: 0.0, y: 0.0 }, Point { x: 5_000.0, y: 0.0 }).unwrap();
        let mut timing = Timing::default();
        assert_eq!(first_open(leg.closed(&air, false, &[], &mut timing), 0.0), 1000.0 + LATE_S);
        assert_eq!(leg.closed(&air, true, &[], &mut Timing::default()), []);
    }

    type Gust = (f64, f64, f64, f64, bool);

    fn gusts() -> impl Strategy<Value = Vec<Gust>> {
        let gust = (0.0..20_000.0f64, 500.0..20_000.0f64, -60.0..60.0f64, -60.0..60.0f64, any::<bool>());
        prop::collection::vec(gust, 0..6)
    }

    fn field(gusts: &[Gust], blend: bool) -> WindField {
        let west = Area { south_deg: 30.0, north_deg: 50.0, west_deg: -125.0, east_deg: -116.0 };
        let layers = gusts
            .iter()
            .map(|(from, lasts, east, north, part)| layer(*from, from + lasts, *east, *north, part.then_some(west)));
        WindField { layers: layers.collect(), blend }
    }

    proptest! {
        #[test]
        fn leaving_later_is_never_arriving_earlier(
            gusts in gusts(), blend in any::<bool>(), to in (34.0..44.0f64, -122.0..-110.0f64),
            departs in prop::collection::vec(0.0..30_000.0f64, 2..30), share in 0.0..1.0f64,
        ) {
            let air = Air::new(&field(&gusts, blend), 7000.0, 70.0, 0.0, 100_000.0);
            let leg = course(Position::new(38.0, -119.0), Position::new(to.0, to.1));
            for backwards in [false, true] {
                let mut timing = Timing::default();
                let mut departs = departs.clone();
                departs.sort_by(f64::total_cmp);
                let arrive: Vec<f64> = departs.iter().map(|s| leg.arrive(&air, backwards, &mut timing, *s)).collect();
                for (early, late) in arrive.iter().zip(arrive.iter().skip(1)) {
                    prop_assert!(*late >= early - 1e-6, "{early} {late}");
                }
                for (depart_s, arrive_s) in departs.iter().zip(&arrive) {
                    prop_assert!((leg.advance(&air, backwards, *depart_s, 1.0) - arrive_s).abs() < 1e-6);
                    let at_s = leg.advance(&air, backwards, *depart_s, share);
                    prop_assert!(at_s <= arrive_s + 1e-6);
                    let again_s = leg.retreat(&air, backwards, at_s, share);
                    prop_assert!((again_s - depart_s).abs() < 1e-6, "{again_s} {depart_s}");
                }
            }
        }

        // The naive twin: hundreds of short pieces, each in the wind of its beginning.
        #[test]
        fn a_leg_takes_as_long_as_many_short_ones(
            gusts in gusts(), to in (34.0..44.0f64, -122.0..-110.0f64), depart_s in 0.0..30_000.0f64,
        ) {
            let field = field(&gusts, false);
            let air = Air::new(&field, 7000.0, 130.0, 0.0, 100_000.0);
            let (from, to) = (Position::new(38.0, -119.0), Position::new(to.0, to.1));
            let took_s = course(from, to).arrive(&air, false, &mut Timing::default(), depart_s) - depart_s;
            let pieces = 400;
            let mut now_s = depart_s;
            let mut here = from;
            for piece in 1..=pieces {
                let there = geodesy::interpolate(from, to, f64::from(piece) / f64::from(pieces));
                now_s += leg_time_s(here, there, 7000.0, 130.0, &field, now_s).unwrap();
                here = there;
            }
            // A step of 25 km may lie on the wrong side of an area's edge, at speeds between 70 and 190 m/s.
            let loose_s = 25_000.0 / 70.0 + 1e-3 * took_s;
            prop_assert!((now_s - depart_s - took_s).abs() < loose_s, "{took_s} {}", now_s - depart_s);
        }
    }
}
