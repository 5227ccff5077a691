//! How a segment of a line is flown again.

use super::landing::on_line;
use super::limits::Limits;
use super::route::{MARGIN_SHARES, Strictness};
use super::{Request, Way};
use apex_geo::geodesy;
use apex_model::problem::Position;

/// Seconds of straight flight before a segment that is flown again: bank and roll settle in 5 s (time constants of a second,
/// roll rates of some degrees per second); the rest is for the end of the turn.
const SEGMENT_LEAD_IN_S: f64 = 10.0;
/// Less than this of a line is not worth coming back to.
const REST_M_MIN: f64 = 500.0;

/// A lost segment of a line, and the end of the line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Where the data are lost from.
    pub begin: Position,
    /// Where the loss ended.
    pub until: Position,
    /// Where the line ends.
    pub line_end: Position,
    /// Altitude of the line, above mean sea level.
    pub altitude_m: f64,
}

/// The way to fly a segment again.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentWay {
    /// The segment is flown from its end to its beginning.
    pub is_reversed: bool,
    /// Time until the vehicle is where the line continues.
    pub total_s: f64,
    /// The way to the end of the segment that comes first.
    pub way: Way,
}

impl Limits {
    /// The fastest way to fly a segment again, in the direction that costs least together with the rest of its line; none for a
    /// vehicle that needs no turns, and where no way is permitted.
    pub fn segment_again(&self, request: &Request, segment: &Segment) -> Option<SegmentWay> {
        let Segment { begin, until, line_end, altitude_m } = *segment;
        let segment_m = geodesy::distance_m(begin, until);
        if segment_m < 1.0 || self.turn_radius_m <= 0.0 {
            return None;
        }
        let lead_m = SEGMENT_LEAD_IN_S * self.true_airspeed_mps;
        let onto = |request: &Request, from: Position, to: Position| {
            let (gate, gate_deg) = on_line(from, to, -lead_m);
            let to_track_rad = Some(gate_deg.to_radians());
            let to_gate = Request { to: gate, to_altitude_m: altitude_m, to_track_rad, ..*request };
            let mut way = MARGIN_SHARES.iter().find_map(|share| self.way(&to_gate, &Strictness::all(*share)).ok())?;
            way.via.push(gate);
            Some(way)
        };
        let flown_s = (segment_m + lead_m) / self.true_airspeed_mps;
        let same = onto(request, begin, until).map(|way| (way.hold_s + way.time_s + flown_s, way));
        let reverse = onto(request, until, begin).and_then(|way| {
            let mut total_s = way.hold_s + way.time_s + flown_s;
            if geodesy::distance_m(until, line_end) > REST_M_MIN {
                let back_deg = geodesy::azimuth_deg(until, begin);
                let after = Request { from: begin, from_track_rad: Some(back_deg.to_radians()), ..*request };
                total_s += onto(&after, until, line_end).map(|way| way.hold_s + way.time_s)?;
            }
            Some((total_s, way))
        });
        match (same, reverse) {
            (Some((same_s, _)), Some((total_s, way))) if total_s < same_s => {
                Some(SegmentWay { is_reversed: true, total_s, way })
            }
            (Some((total_s, way)), _) => Some(SegmentWay { is_reversed: false, total_s, way }),
            (None, Some((total_s, way))) => Some(SegmentWay { is_reversed: true, total_s, way }),
            (None, None) => None,
        }
    }
}
