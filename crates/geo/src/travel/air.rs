//! The air along a leg: wind at one altitude, divided at the instants at which it changes.
//!
//! Between two changes the wind at a place is constant, so that progress along a leg can be computed exactly, forwards and backwards.
//! Bound: O(layers) for a ground speed, O(1) if the wind is the same everywhere.

use crate::direction::Direction;
use crate::wind::{self, GROUND_SPEED_MPS_MIN, Wind};
use apex_model::problem::{Position, WindField, WindLayer};

/// A short piece of a leg, over which the wind is taken from its middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WindStep {
    pub(crate) middle: Direction,
    /// East and north parts of the track, of length 1.
    pub(crate) track: (f64, f64),
}

/// Wind between two changes.
#[derive(Clone, Debug, PartialEq)]
enum Blows {
    /// The same everywhere.
    Everywhere(Wind),
    /// Different by area: the field, and an instant between the changes at which it is queried.
    ByArea(WindField, f64),
}

/// The wind at one altitude, for flight at one airspeed.
#[derive(Clone, Debug, PartialEq)]
pub struct Air {
    altitude_m: f64,
    true_airspeed_mps: f64,
    changes_s: Vec<f64>,
    spans: Vec<Blows>,
    speed_mps_max: f64,
}

impl Air {
    /// Returns the wind of `field` at `altitude_m` from `from_s` to `until_s`, for flying at `true_airspeed_mps`. The first and
    /// last wind extend before and after.
    pub fn new(field: &WindField, altitude_m: f64, true_airspeed_mps: f64, from_s: f64, until_s: f64) -> Air {
        let heights = |layer: &&WindLayer| {
            field.blend || (layer.altitude_m_min <= altitude_m && altitude_m < layer.altitude_m_max)
        };
        let layers: Vec<&WindLayer> = field.layers.iter().filter(heights).collect();
        let ends = layers.iter().flat_map(|layer| [layer.from_s, layer.until_s]);
        let mut changes_s: Vec<f64> = ends.filter(|time_s| *time_s > from_s && *time_s < until_s).collect();
        changes_s.sort_by(f64::total_cmp);
        changes_s.dedup();
        let blows = |time_s: f64| {
            let now = layers.iter().filter(|layer| layer.from_s <= time_s && time_s < layer.until_s);
            let now = WindField { layers: now.map(|layer| **layer).collect(), blend: field.blend };
            if now.layers.iter().all(|layer| layer.area.is_none()) {
                Blows::Everywhere(wind::at(&now, Position::default(), altitude_m, time_s))
            } else {
                Blows::ByArea(now, time_s)
            }
        };
        let spans = [from_s].into_iter().chain(changes_s.iter().copied()).map(blows).collect();
        let speeds = layers.iter().map(|layer| libm::hypot(layer.wind_east_mps, layer.wind_north_mps));
        let speed_mps_max = speeds.fold(0.0, f64::max);
        Air { altitude_m, true_airspeed_mps, changes_s, spans, speed_mps_max }
    }

    /// Returns air without wind.
    pub fn still(true_airspeed_mps: f64) -> Air {
        Air::new(&WindField::default(), 0.0, true_airspeed_mps, 0.0, 0.0)
    }

    /// Returns the instants at which the wind changes, in order.
    pub fn changes_s(&self) -> &[f64] {
        &self.changes_s
    }

    /// Returns an upper bound on the ground speed.
    pub fn ground_speed_mps_max(&self) -> f64 {
        self.true_airspeed_mps + self.speed_mps_max
    }

    /// Returns true if a wind may keep the vehicle from flying some track.
    pub(crate) fn may_be_too_strong(&self) -> bool {
        let slowest_mps = self.true_airspeed_mps - self.speed_mps_max;
        slowest_mps.is_nan() || slowest_mps <= GROUND_SPEED_MPS_MIN
    }

    /// Returns the number of intervals between changes.
    pub(crate) fn spans(&self) -> usize {
        self.spans.len()
    }

    /// Returns the interval that contains `time_s`; a change belongs to the interval that it begins.
    pub(crate) fn span_at(&self, time_s: f64) -> usize {
        self.changes_s.partition_point(|change_s| *change_s <= time_s)
    }

    /// Returns the interval that contains the time just before `time_s`.
    pub(crate) fn span_before(&self, time_s: f64) -> usize {
        self.changes_s.partition_point(|change_s| *change_s < time_s)
    }

    /// Returns the beginning and the end of interval number `span`.
    pub(crate) fn span_ends_s(&self, span: usize) -> (f64, f64) {
        let begin_s = span.checked_sub(1).and_then(|before| self.changes_s.get(before));
        let end_s = self.changes_s.get(span);
        (begin_s.copied().unwrap_or(f64::NEG_INFINITY), end_s.copied().unwrap_or(f64::INFINITY))
    }

    /// Returns the speed through the air.
    pub(crate) fn true_airspeed_mps(&self) -> f64 {
        self.true_airspeed_mps
    }

    /// Returns the east and north parts of the wind at a place in interval `span`.
    pub(crate) fn wind(&self, span: usize, position: Position) -> (f64, f64) {
        let wind = match self.spans.get(span) {
            Some(Blows::Everywhere(wind)) => *wind,
            Some(Blows::ByArea(field, time_s)) => wind::at(field, position, self.altitude_m, *time_s),
            None => Wind::default(),
        };
        (wind.east_mps, wind.north_mps)
    }

    /// Returns the speed over ground in interval `span` along the track of `step`, or backwards; `None` if the step cannot be flown.
    pub(crate) fn speed_mps(&self, span: usize, step: &WindStep, backwards: bool) -> Option<f64> {
        let wind = match self.spans.get(span)? {
            Blows::Everywhere(wind) => *wind,
            Blows::ByArea(field, time_s) => wind::at(field, step.middle.position(), self.altitude_m, *time_s),
        };
        let (east, north) = step.track;
        let track = if backwards { (-east, -north) } else { (east, north) };
        wind::ground_speed_mps(track, self.true_airspeed_mps, wind)
    }

    /// Like [`Air::speed_mps`], with a very low speed where the step cannot be flown ([`super::course::Course::closed`] closes such
    /// intervals).
    pub(crate) fn speed_or_crawl_mps(&self, span: usize, step: &WindStep, backwards: bool) -> f64 {
        self.speed_mps(span, step, backwards).unwrap_or(GROUND_SPEED_MPS_MIN)
    }
}
