//! The instant between two examined ones at which a path of exactly that duration reaches its end.

use super::{HALVINGS, PathCandidate};

/// Maximum number of instants that are estimated before the crossing is searched by halving.
const ESTIMATES: usize = 4;
/// Share of the exactness within which rounding may decide on which side of the crossing an instant lies.
const ROUNDING_SHARE: f64 = 1e-3;
/// Two instants around any crossing.
const EVERYWHERE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

impl PathCandidate {
    /// Returns the last candidate between this one and the instant `until_s`, at which no candidate exists.
    pub(super) fn outermost(self, mut until_s: f64, look: &dyn Fn(f64) -> Option<PathCandidate>) -> PathCandidate {
        let mut known = self;
        for _ in 0..HALVINGS {
            let middle_s = 0.5 * (known.time_s + until_s);
            match look(middle_s) {
                Some(middle) => known = middle,
                None => until_s = middle_s,
            }
        }
        known
    }

    /// Returns the candidate between two instants whose duration is exact; `None` if there is none. `is_steady` tells whether the length
    /// neither jumps nor changes faster than its end moves between two instants; the end moves with `drift` times the airspeed.
    pub(super) fn reached(
        (early, late): (PathCandidate, PathCandidate),
        look: &dyn Fn(f64) -> Option<PathCandidate>,
        is_steady: &dyn Fn(&PathCandidate, &PathCandidate) -> bool,
        (radius, exact_s, drift): (f64, f64, f64),
    ) -> Option<PathCandidate> {
        let is_crossed = |early: &PathCandidate, late: &PathCandidate| (early.missed_s > 0.0) != (late.missed_s > 0.0);
        // In most intervals the length neither jumps nor becomes exact.
        if is_crossed(&early, &late) || early.jumps_to(&late, radius) {
            let halves = PathCandidate::parted(early, late, look, radius);
            for (early, late) in halves.into_iter().filter(|(early, late)| is_crossed(early, late)) {
                let surely = if early.missed_s > 0.0 && is_steady(&early, &late) {
                    PathCandidate::around_crossing(early, late, look, (exact_s, drift))
                } else {
                    EVERYWHERE
                };
                let left = PathCandidate::before_crossing(early, late, look, surely);
                if let Some(left) = left.filter(|left| left.missed_s.abs() <= exact_s) {
                    return Some(left);
                }
            }
        }
        (early.missed_s.abs() <= exact_s).then_some(early)
    }

    /// Returns two instants between which the crossing surely lies, near each other. In one second the duration falls behind the time by
    /// 1 plus or minus `drift` seconds at most, which bounds the crossing from each instant that is examined.
    fn around_crossing(
        early: PathCandidate,
        late: PathCandidate,
        look: &dyn Fn(f64) -> Option<PathCandidate>,
        (exact_s, drift): (f64, f64),
    ) -> (f64, f64) {
        let (fast, slow) = (1.0 + drift, 1.0 - drift);
        let rounding_s = ROUNDING_SHARE * exact_s / slow;
        let ((mut left, mut right), (mut from_s, mut until_s)) = ((early, late), (early.time_s, late.time_s));
        for _ in 0..ESTIMATES {
            let share = left.missed_s / (left.missed_s - right.missed_s);
            let middle_s = left.time_s + share * (right.time_s - left.time_s);
            if !(left.time_s < middle_s && middle_s < right.time_s) {
                break;
            }
            let Some(middle) = look(middle_s) else { return EVERYWHERE };
            let bounds_s = [fast, slow].map(|rate| middle_s + middle.missed_s / rate);
            let [one_s, other_s] = bounds_s;
            (from_s, until_s) = (one_s.min(other_s), one_s.max(other_s));
            if until_s - from_s <= rounding_s {
                break;
            }
            if middle.missed_s > 0.0 { left = middle } else { right = middle }
        }
        (from_s - rounding_s, until_s + rounding_s)
    }

    /// Returns the last candidate before the crossing of two candidates, by halving. Outside of `surely` the side of an instant is known,
    /// and it is not examined.
    fn before_crossing(
        early: PathCandidate,
        late: PathCandidate,
        look: &dyn Fn(f64) -> Option<PathCandidate>,
        surely: (f64, f64),
    ) -> Option<PathCandidate> {
        let above = early.missed_s > 0.0;
        let (mut low_s, mut high_s, mut low) = (early.time_s, late.time_s, Some(early));
        for _ in 0..HALVINGS {
            let middle_s = 0.5 * (low_s + high_s);
            // No number lies between these two.
            if middle_s == low_s || middle_s == high_s {
                break;
            }
            if middle_s < surely.0 {
                (low_s, low) = (middle_s, None);
            } else if middle_s > surely.1 {
                high_s = middle_s;
            } else {
                let Some(middle) = look(middle_s) else { break };
                if (middle.missed_s > 0.0) == above {
                    (low_s, low) = (middle_s, Some(middle));
                } else {
                    high_s = middle_s;
                }
            }
        }
        low.or_else(|| look(low_s))
    }

    /// Returns the interval between two candidates, in two parts if the length jumps within it.
    pub(super) fn parted(
        early: PathCandidate,
        late: PathCandidate,
        look: &dyn Fn(f64) -> Option<PathCandidate>,
        radius: f64,
    ) -> Vec<(PathCandidate, PathCandidate)> {
        if !early.jumps_to(&late, radius) {
            return vec![(early, late)];
        }
        let (left, right) = PathCandidate::narrowed(early, late, look, |middle| !early.jumps_to(middle, radius));
        vec![(early, left), (right, late)]
    }

    /// Returns the last instant at which a condition holds, and the first at which it does not, between two instants with different
    /// results.
    pub(super) fn narrowed(
        mut low: PathCandidate,
        mut high: PathCandidate,
        look: &dyn Fn(f64) -> Option<PathCandidate>,
        holds: impl Fn(&PathCandidate) -> bool,
    ) -> (PathCandidate, PathCandidate) {
        for _ in 0..HALVINGS {
            let middle_s = 0.5 * (low.time_s + high.time_s);
            // No number lies between these two.
            if middle_s == low.time_s || middle_s == high.time_s {
                break;
            }
            let Some(middle) = look(middle_s) else { break };
            if holds(&middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        (low, high)
    }
}
