//! Comparison of candidates that meet a goal: the Pareto front of points, time, energy and turns, and the choice among it.

use super::candidates::ManoeuvreCandidate;
use super::goal::PERFECT_POINTS;
use apex_observation::manoeuvres::{Forecast, Scene};

/// Maximum number of manoeuvres, and of misses, in an answer.
pub(super) const ANSWERS_MAX: usize = 8;
/// Candidates with at least this share of the best points count as equally good; the shortest time then decides.
const AS_GOOD: f64 = 0.99;
/// Share of the points that a candidate with all of them may lack, by rounding.
const ALL_POINTS_SPARE: f64 = 1e-6;

/// A candidate with its predicted result.
#[derive(Clone, Debug)]
pub(crate) struct Predicted {
    pub(super) candidate: ManoeuvreCandidate,
    pub(super) scene: Scene,
    pub(super) forecast: Forecast,
    /// Flight time to its beginning.
    pub(super) travel_s: f64,
}

/// Returns the figures by which candidates are compared, less is better: negative points, time, energy, turns. All perfect candidates have
/// equal points.
pub(super) fn figures(one: &Predicted) -> [f64; 4] {
    let forecast = &one.forecast;
    let points = if is_perfect(one) { PERFECT_POINTS } else { forecast.points };
    [-points, one.travel_s + forecast.time_s, forecast.energy, forecast.turns as f64]
}

/// Returns true if no figure of `a` is greater than that of `b`, and one is less.
pub(super) fn beats(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| a <= b) && a.iter().zip(b).any(|(a, b)| a < b)
}

/// Returns true for a candidate with all points, which no other one can exceed.
pub(super) fn is_perfect(one: &Predicted) -> bool {
    one.forecast.points >= (1.0 - ALL_POINTS_SPARE) * PERFECT_POINTS
}

/// Returns the Pareto front of value, time, energy and turns; the chosen manoeuvre first.
pub(super) fn front(meeting: Vec<Predicted>) -> Vec<Predicted> {
    let all: Vec<[f64; 4]> = meeting.iter().map(figures).collect();
    let stays = |index: usize| {
        let own = all.get(index);
        own.is_some_and(|own| {
            let twin = |(other, figures): (usize, &[f64; 4])| {
                beats(figures.as_slice(), own) || (other < index && figures == own)
            };
            !all.iter().enumerate().any(twin)
        })
    };
    let mut front: Vec<Predicted> =
        meeting.into_iter().enumerate().filter(|(index, _)| stays(*index)).map(|(_, one)| one).collect();
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
