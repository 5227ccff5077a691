//! Steps during which a path of one type surely neither reaches its end at the exact instant nor jumps in length.
//!
//! The end moves with the wind, so it moves little in a few steps, and lengths and turns change by no more than follows from that. For a
//! path with a line, the length changes by no more than its end moves: both ends of the line touch their circles. For three turns, the
//! circle in between moves by the derivative of its centre, and each turn by the angles under which the outer circles see it.

use super::{Flyer, PathCandidate, PathEnds, PathType};
use crate::plane::Point;
use std::f64::consts::TAU;

/// Share of a duration's excess that may be used up, and least distance of a turn from zero and from a full circle, so that rounding does
/// not decide.
const SURELY_LESS: f64 = 0.999;
const SURELY_APART_RAD: f64 = 1e-6;

/// Upper bounds of changes while an end moves by a certain distance.
struct ChangeBounds {
    length_m: f64,
    /// Bound on the change of each turn.
    turn_rad: f64,
}

impl Flyer {
    /// Returns the number of steps of `step_s` after `now` during which the path surely takes longer than the time until then, and none
    /// of its turns vanishes or becomes a full circle; 0 if that is uncertain.
    pub(super) fn idle_steps(
        &self,
        (word, ends, to): (PathType, &PathEnds, Point),
        now: &PathCandidate,
        step_s: f64,
        exact_s: f64,
    ) -> usize {
        let excess_s = SURELY_LESS * (now.missed_s - exact_s);
        let wind_mps = self.wind_mps.length();
        let end = to.plus(-now.time_s, self.wind_mps);
        let is_idle = |steps: f64| {
            let time_s = steps * step_s;
            word.changes(ends, end, wind_mps * time_s).is_some_and(|bounds| {
                bounds.length_m / self.true_airspeed_mps + time_s < excess_s && self.keeps_turns(now, &bounds)
            })
        };
        // The excess falls fastest if the end comes straight towards the path.
        let mut steps = libm::floor(excess_s / ((1.0 + wind_mps / self.true_airspeed_mps) * step_s));
        while steps > 1.0 && !is_idle(steps) {
            steps = libm::floor(0.5 * steps);
        }
        if steps > 1.0 { steps as usize } else { 0 }
    }

    /// Returns true if a path with a line surely exists from `now` until `until_s`, and none of its turns vanishes or becomes a full
    /// circle: its length then changes by no more than its end moves.
    pub(super) fn is_steady(
        &self,
        (word, ends, to): (PathType, &PathEnds, Point),
        now: &PathCandidate,
        until_s: f64,
    ) -> bool {
        let end = to.plus(-now.time_s, self.wind_mps);
        let moved_m = self.wind_mps.length() * (until_s - now.time_s);
        word.between == 0.0 && word.changes(ends, end, moved_m).is_some_and(|bounds| self.keeps_turns(now, &bounds))
    }

    /// Returns true if no turn of a path vanishes or becomes a full circle within these bounds.
    fn keeps_turns(&self, now: &PathCandidate, bounds: &ChangeBounds) -> bool {
        let apart_rad = bounds.turn_rad + SURELY_APART_RAD;
        let keeps = |turned_rad: f64| turned_rad > apart_rad && turned_rad < TAU - apart_rad;
        now.parts.iter().filter(|part| part.turn != 0.0).all(|part| keeps(part.length_m / self.turn_radius_m))
    }
}

impl PathType {
    /// Returns bounds of what changes while the end `to` moves by at most `moved_m`; `None` if the path type may then cease to exist.
    fn changes(self, ends: &PathEnds, to: Point, moved_m: f64) -> Option<ChangeBounds> {
        let radius = ends.radius;
        let distance_m = to.plus(radius * self.last, ends.last).minus(ends.first).length();
        let (near_m, far_m) = (SURELY_LESS * (distance_m - moved_m), distance_m + moved_m);
        if self.between == 0.0 {
            let beside_m = (radius * (self.first - self.last)).abs();
            let line_m2 = near_m * near_m - beside_m * beside_m;
            let exists = near_m > 0.0 && line_m2 > 0.0;
            return exists.then(|| ChangeBounds {
                length_m: moved_m,
                turn_rad: moved_m / near_m * (1.0 + beside_m / libm::sqrt(line_m2)),
            });
        }
        let high_m2 = SURELY_LESS * 4.0 * radius * radius - 0.25 * far_m * far_m;
        if near_m <= 0.0 || high_m2 <= 0.0 {
            return None;
        }
        let centre_m = moved_m * (0.5 + 0.25 * far_m / libm::sqrt(high_m2) + 2.0 * radius / near_m);
        Some(ChangeBounds { length_m: 2.0 * centre_m + moved_m, turn_rad: (2.0 * centre_m + moved_m) / (2.0 * radius) })
    }
}
