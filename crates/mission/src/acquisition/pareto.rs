//! Comparison of candidates that meet a goal: the Pareto front of points, time, energy, risk and turns, and the choice among it.

use super::candidates::ManoeuvreCandidate;
use super::goal::PERFECT_POINTS;
use super::risk::Risk;
use apex_observation::manoeuvres::{FlownPath, Forecast, Scene};

/// Maximum number of manoeuvres, and of misses, in an answer.
pub(super) const ANSWERS_MAX: usize = 8;
/// Candidates with at least this share of the best points count as equally good; the shortest time then decides.
const AS_GOOD: f64 = 0.99;
/// Share of the points that a candidate with all of them may lack: it is printed as 100.0 points.
const ALL_POINTS_SPARE: f64 = 5e-4;

/// A candidate with its predicted result.
#[derive(Clone, Debug)]
pub(crate) struct Predicted {
    pub(super) candidate: ManoeuvreCandidate,
    pub(super) scene: Scene,
    pub(super) forecast: Forecast,
    /// Flight time to its beginning.
    pub(super) travel_s: f64,
    pub(super) risk: Risk,
}

/// Figures of a candidate that need no prediction of what it sees, less is better: time, energy, risk, turns.
pub(super) type Cost = [f64; 4];

/// Returns the cost of a flown path that begins after `travel_s`.
pub(super) fn cost(flown: &FlownPath, travel_s: f64, risk: Risk) -> Cost {
    [travel_s + flown.time_s, flown.energy, risk.share, flown.turns as f64]
}

/// Returns the figures by which candidates are compared, less is better: negative points, then the cost. All perfect candidates have equal
/// points.
pub(super) fn figures(one: &Predicted) -> [f64; 5] {
    let points = if is_perfect(one) { PERFECT_POINTS } else { one.forecast.points };
    let [time_s, energy, risk, turns] = cost(&one.forecast.flown, one.travel_s, one.risk);
    [-points, time_s, energy, risk, turns]
}

/// Returns true if no figure of `a` is greater than that of `b`, and one is less.
pub(super) fn beats(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| a <= b) && a.iter().zip(b).any(|(a, b)| a < b)
}

/// Returns true for a candidate with all points, which no other one can exceed.
pub(super) fn is_perfect(one: &Predicted) -> bool {
    one.forecast.points >= (1.0 - ALL_POINTS_SPARE) * PERFECT_POINTS
}

/// Adds a candidate to a Pareto front, unless one on it beats or equals it; removes those that it beats. Bound: O(candidates on the front).
pub(super) fn add(front: &mut Vec<Predicted>, one: Predicted) {
    let own = figures(&one);
    if front.iter().map(figures).any(|other| beats(&other, &own) || other == own) {
        return;
    }
    front.retain(|other| !beats(&own, &figures(other)));
    front.push(one);
}

/// Returns the end of the last candidate of a full answer, if no candidate that ends later can change that answer: `front` has
/// [`ANSWERS_MAX`] candidates that are as good as the best one, whatever its points are, and the fastest come first. A candidate that is as
/// good as the best one up to now, and may not be as good as a better one that follows, leaves the answer open.
pub(super) fn full_at_s(front: &[Predicted]) -> Option<f64> {
    let surely_good = AS_GOOD * PERFECT_POINTS;
    let best = front.iter().map(|one| one.forecast.points).fold(0.0, f64::max);
    if front.iter().any(|one| (AS_GOOD * best..surely_good).contains(&one.forecast.points)) {
        return None;
    }
    let good = front.iter().filter(|one| one.forecast.points >= surely_good);
    let mut ends_s: Vec<f64> = good.map(|one| one.travel_s + one.forecast.time_s).collect();
    ends_s.sort_by(f64::total_cmp);
    ends_s.get(ANSWERS_MAX - 1).copied()
}

/// Returns a Pareto front of value, time, energy, risk and turns as an answer: the chosen manoeuvre first, at most [`ANSWERS_MAX`].
pub(super) fn answer(mut front: Vec<Predicted>) -> Vec<Predicted> {
    let best = front.iter().map(|one| one.forecast.points).fold(0.0, f64::max);
    let is_good = |one: &Predicted| one.forecast.points >= AS_GOOD * best;
    front.sort_by(|a, b| {
        let (a_s, b_s) = (a.travel_s + a.forecast.time_s, b.travel_s + b.forecast.time_s);
        let by_time = a_s.total_cmp(&b_s).then(a.forecast.turns.cmp(&b.forecast.turns));
        match (is_good(a), is_good(b)) {
            (true, true) => by_time,
            (one, other) => other.cmp(&one).then(b.forecast.points.total_cmp(&a.forecast.points)).then(by_time),
        }
    });
    front.truncate(ANSWERS_MAX);
    front
}
