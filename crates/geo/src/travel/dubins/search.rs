//! The search for the first instant at which a path of one type, and of exactly that duration, reaches its end.

use super::{
    EXACT, Flyer, INSTANTS_MAX, INSTANTS_PER_CIRCLE, PathCandidate, PathEnds, PathSearch, PathType, Point, Pose, TAU,
    TurnPath, angle, unit,
};

impl<'a> PathSearch<'a> {
    /// Returns the search between poses with their headings.
    pub(super) fn new(flyer: &'a Flyer, from: (Pose, Option<f64>), to: (Pose, Option<f64>)) -> PathSearch<'a> {
        let is_still = flyer.wind_mps == Point::default();
        let direct_s = if is_still { None } else { flyer.straight_s(to.0.point.minus(from.0.point)) };
        PathSearch { flyer, from, to, direct_s }
    }

    /// Returns the length of a path of this type to where the end is when a straight flight arrives; infinite without one.
    pub(super) fn guess_m(&self, word: PathType) -> f64 {
        let (flyer, from, to) = (self.flyer, self.from.0.point, self.to.0.point);
        let direct_s = to.minus(from).length() / flyer.true_airspeed_mps;
        let parts = word.parts(&self.ends(word), to.plus(-direct_s, flyer.wind_mps));
        parts.map_or(f64::INFINITY, |(_, parts)| parts.iter().map(|part| part.length_m).sum())
    }

    fn ends(&self, word: PathType) -> PathEnds {
        PathEnds::new(word, self.flyer.turn_radius_m, (self.from.0.point, self.from.1), self.to.1)
    }

    /// Returns the first instant found at which a path of this type and exactly that duration reaches its end. No path is shorter than
    /// the straight one; from its duration on instants are examined in sequence. If the length jumps between two of them, because a turn
    /// vanishes or becomes a full circle, both sides of the jump are examined. Instants after `until_s` are not examined.
    pub(super) fn path(&self, word: PathType, until_s: f64) -> Option<TurnPath> {
        let (flyer, from, to) = (self.flyer, self.from.0, self.to.0);
        let circle_s = TAU * flyer.turn_radius_m / flyer.true_airspeed_mps;
        let ends = self.ends(word);
        let look = |time_s: f64| {
            let point = to.point.plus(-time_s, flyer.wind_mps);
            let (heading_rad, parts) = word.parts(&ends, point)?;
            let length_m: f64 = parts.iter().map(|part| part.length_m).sum();
            let missed_s = length_m / flyer.true_airspeed_mps - time_s;
            Some(PathCandidate { time_s, missed_s, heading_rad, parts })
        };
        let path = |look: PathCandidate| TurnPath {
            from: from.point,
            heading_rad: look.heading_rad,
            flyer: *flyer,
            parts: look.parts,
            time_s: look.time_s + look.missed_s,
        };
        if flyer.wind_mps == Point::default() {
            return look(0.0).map(path);
        }
        let direct_s = self.direct_s?;
        let wind_mps = flyer.wind_mps.length();
        // Three full circles more than the straight way, longer if the end moves away.
        let lasts_s = 3.0 * circle_s / (1.0 - wind_mps / flyer.true_airspeed_mps);
        let count = (libm::ceil(lasts_s / circle_s) * INSTANTS_PER_CIRCLE).min(INSTANTS_MAX);
        let exact_s = EXACT * (circle_s + direct_s);
        let moves = [direct_s, direct_s + lasts_s].map(|time_s| to.point.plus(-time_s, flyer.wind_mps));
        if word.is_out_of_reach(&ends, moves) {
            return None;
        }
        let instants = Instants { from_s: direct_s, lasts_s, count, exact_s, until_s };
        self.first_reached((word, &ends, to.point), &instants, &look).map(path)
    }

    /// Returns the candidate of the first instant at which its duration is exact. Instants at which it is surely not exact are not
    /// examined.
    fn first_reached(
        &self,
        (word, ends, to): (PathType, &PathEnds, Point),
        instants: &Instants,
        look: &impl Fn(f64) -> Option<PathCandidate>,
    ) -> Option<PathCandidate> {
        let Instants { lasts_s, count, until_s, exact_s, .. } = *instants;
        let flyer = self.flyer;
        let step_s = lasts_s / count;
        let (mut before, mut index) = (look(instants.from_s), 1);
        while index <= count as usize {
            let now_s = instants.at_s(index);
            if now_s - step_s > until_s + exact_s {
                break;
            }
            let idle = before.map_or(0, |before| flyer.idle_steps((word, ends, to), &before, step_s, exact_s));
            if idle > 1 {
                index += idle;
                before = look(instants.at_s(index - 1));
                continue;
            }
            let now = look(now_s);
            // If the path type exists only in a part of the interval, that part is searched.
            let since = match (before, now) {
                (None, Some(now)) => Some((now.outermost(now_s - step_s, look), now)),
                (Some(before), None) => Some((before, before.outermost(now_s, look))),
                (before, now) => before.zip(now),
            };
            let is_steady =
                |early: &PathCandidate, late: &PathCandidate| flyer.is_steady((word, ends, to), early, late.time_s);
            let drift = flyer.wind_mps.length() / flyer.true_airspeed_mps;
            let terms = (flyer.turn_radius_m, exact_s, drift);
            if let Some(found) = since.and_then(|pair| PathCandidate::reached(pair, look, &is_steady, terms)) {
                return Some(found);
            }
            (before, index) = (now, index + 1);
        }
        None
    }
}

impl Flyer {
    /// Returns the duration of the straight flight over a distance and direction; `None` if the wind permits none.
    fn straight_s(&self, apart: Point) -> Option<f64> {
        let track_rad = angle(apart);
        let speed_mps = self.heading_rad(track_rad).map(|heading_rad| {
            let track = unit(track_rad);
            self.true_airspeed_mps * unit(heading_rad).dot(track) + self.wind_mps.dot(track)
        });
        let apart_m = apart.length();
        if apart_m > 0.0 { Some(apart_m / speed_mps?) } else { Some(0.0) }
    }
}

/// The instants at which a path is examined.
struct Instants {
    from_s: f64,
    lasts_s: f64,
    /// Number of equal steps in `lasts_s`.
    count: f64,
    exact_s: f64,
    until_s: f64,
}

impl Instants {
    fn at_s(&self, index: usize) -> f64 {
        self.from_s + self.lasts_s * index as f64 / self.count
    }
}
