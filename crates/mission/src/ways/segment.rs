//! Paths to fly a segment of a line again.

use super::landing::on_line;
use super::limits::Limits;
use super::route::{MARGIN_SHARES, Strictness};
use super::{Request, Way};
use apex_geo::{geodesy, wind};
use apex_model::problem::Position;

/// Seconds of straight flight before a segment that is flown again: bank and roll settle in 5 s (time constants of a second,
/// roll rates of some degrees per second); the rest is for the end of the turn.
const SEGMENT_LEAD_IN_S: f64 = 10.0;
/// Length in metres below which the rest of a line after the segment is not flown.
const REST_M_MIN: f64 = 500.0;

/// A lost segment of a line, and the end of the line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Point from which on data are lost.
    pub begin: Position,
    /// Point at which the loss ended.
    pub until: Position,
    /// End of the line.
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
    /// The path to the first end of the segment.
    pub way: Way,
}

impl Limits {
    /// Returns the fastest way to fly a segment again, in the direction with the least cost including the rest of its line; `None` for a
    /// vehicle that needs no turns, and if no path is permitted.
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
        // Over ground, from the beginning of the lead-in on.
        let flown_s = |from: Position, to: Position, way: &Way| {
            let (gate, _) = on_line(from, to, -lead_m);
            let at_s = request.at_s + way.hold_s + way.time_s;
            let leg_s = wind::leg_time_s(gate, to, altitude_m, self.true_airspeed_mps, &self.wind, at_s)?;
            Some(way.hold_s + way.time_s + leg_s)
        };
        let same = onto(request, begin, until).and_then(|way| Some((flown_s(begin, until, &way)?, way)));
        let reverse = onto(request, until, begin).and_then(|way| {
            let mut total_s = flown_s(until, begin, &way)?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mission;
    use apex_model::problem::{FOREVER_S, WindLayer};

    /// Wind along the track and across it, m/s, and the shortest time, s, from the end of 1 km until it has been flown again in either
    /// direction: an optimum of Dubins paths in wind from another program (95 m/s, bank 18 degrees, 5 s of straight flight before).
    const TABLE: [(f64, f64, f64); 11] = [
        (0.0, 0.0, 218.4),
        (10.0, 0.0, 232.2),
        (-10.0, 0.0, 209.4),
        (0.0, 10.0, 214.6),
        (20.0, 0.0, 222.9),
        (-20.0, 0.0, 211.8),
        (0.0, 20.0, 196.9),
        (30.0, 0.0, 210.6),
        (-30.0, 0.0, 202.4),
        (0.0, 30.0, 180.1),
        (15.0, 15.0, 203.5),
    ];
    /// The shortest times in still air for other lengths, m.
    const LENGTHS: [(f64, f64); 5] =
        [(300.0, 203.6), (600.0, 210.0), (2_000.0, 239.4), (3_000.0, 254.9), (5_000.0, 275.9)];
    const TIMES_MAX: f64 = 1.3;

    fn limits(along_mps: f64, across_mps: f64) -> Limits {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/western-states");
        let mut mission = Mission::load(&folder).unwrap();
        mission.zones.clear();
        mission.forecast.layers = vec![WindLayer {
            area: None,
            altitude_m_min: 0.0,
            altitude_m_max: 20_000.0,
            from_s: 0.0,
            until_s: FOREVER_S,
            wind_east_mps: across_mps,
            wind_north_mps: along_mps,
            edr: 0.0,
        }];
        Limits::of(&mission)
    }

    /// Returns the time for a segment on a track to the north, from its end.
    fn again_s(limits: &Limits, length_m: f64) -> f64 {
        let begin = Position::new(40.0, -120.0);
        let until = geodesy::destination(begin, 0.0, length_m);
        let request = Request {
            from: until,
            from_altitude_m: 7_000.0,
            from_track_rad: Some(0.0),
            at_s: 3_600.0,
            to: until,
            to_altitude_m: 7_000.0,
            to_track_rad: None,
            circle_radius_m: 0.0,
            stay_s: 0.0,
        };
        let segment = Segment { begin, until, line_end: until, altitude_m: 7_000.0 };
        limits.segment_again(&request, &segment).unwrap().total_s
    }

    #[test]
    fn a_segment_is_flown_again_in_at_most_1_3_times_the_shortest_time() {
        let mut slow = Vec::new();
        let by_wind =
            TABLE.map(|(along, across, best_s)| (again_s(&limits(along, across), 1_000.0), best_s, (along, across)));
        let still = limits(0.0, 0.0);
        let by_length = LENGTHS.map(|(length_m, best_s)| (again_s(&still, length_m), best_s, (length_m, 0.0)));
        for (found_s, best_s, case) in by_wind.into_iter().chain(by_length) {
            let times = found_s / best_s;
            println!("{case:?}: {found_s:.1} s, {times:.2} times the table");
            if !(1.0..=TIMES_MAX).contains(&times) {
                slow.push((case, found_s, best_s));
            }
        }
        assert_eq!(slow, []);
    }
}
