//! The instant between two examined ones at which a path of exactly that duration reaches its end.

use super::{HALVINGS, PathCandidate};

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

    /// Returns the candidate between two instants whose duration is exact; `None` if there is none.
    pub(super) fn reached(
        (early, late): (PathCandidate, PathCandidate),
        look: &dyn Fn(f64) -> Option<PathCandidate>,
        radius: f64,
        exact_s: f64,
    ) -> Option<PathCandidate> {
        let is_crossed = |early: &PathCandidate, late: &PathCandidate| (early.missed_s > 0.0) != (late.missed_s > 0.0);
        // In most intervals the length neither jumps nor becomes exact.
        if is_crossed(&early, &late) || early.jumps_to(&late, radius) {
            let halves = PathCandidate::parted(early, late, look, radius);
            for (early, late) in halves.into_iter().filter(|(early, late)| is_crossed(early, late)) {
                let above = early.missed_s > 0.0;
                let (left, _) = PathCandidate::narrowed(early, late, look, |middle| (middle.missed_s > 0.0) == above);
                if left.missed_s.abs() <= exact_s {
                    return Some(left);
                }
            }
        }
        (early.missed_s.abs() <= exact_s).then_some(early)
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
