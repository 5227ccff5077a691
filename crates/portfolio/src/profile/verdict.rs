//! Comparison of planners in a cell, and its significance.
//!
//! Two planners are compared by the mean over a cell's missions of the logarithm of their costs' ratio. One is *better*
//! if Wilcoxon's test rejects equality after Holm's correction over the family, and the effect is at least 1 %; there
//! is *no difference* if the 95 % interval of the mean lies within 1 %; everything else is *undecided*.

use super::Profile;
use super::statistics::{holm, mean_interval, signed_rank};

/// The least effect that makes a winner, and the bound within which there is no difference: the logarithm of 1.01.
pub const EFFECT_MIN: f64 = 0.009_950_330_853_168_083;
/// Probability of error below which a difference counts, over the whole family.
pub const ERROR_MAX: f64 = 0.05;

/// Verdict about two planners in one cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The first is better.
    First,
    /// The second is better.
    Second,
    /// Neither planner is better by more than 1 %.
    NoDifference,
    /// More missions would be needed.
    Undecided,
}

/// Two planners in one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Mean logarithm of the first's cost over the second's; below 0 the first is better.
    pub effect: f64,
    /// Half the width of its 95 % interval.
    pub half_width: f64,
    /// Wilcoxon's probability after Holm's correction.
    pub probability: f64,
    /// The verdict.
    pub verdict: Verdict,
}

/// The best planner of one cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Best {
    /// The planner with the least mean logarithm of costs, which selection chooses.
    pub planner: usize,
    /// The second best planner; `None` if there is only one planner.
    pub next: Option<(usize, Comparison)>,
    /// `First`: better than every other. `NoDifference`: no other differs by more than 1 %. Otherwise undecided.
    pub verdict: Verdict,
}

/// Compares planners `first` and `second` in every cell at `budget` (an index); the family is the cells.
pub fn pair(profile: &Profile, budget: usize, first: usize, second: usize) -> Vec<Comparison> {
    let each: Vec<(Vec<f64>, f64)> = profile
        .rows
        .iter()
        .map(|row| log_ratios(row.costs(first, budget), row.costs(second, budget)))
        .map(|ratios| {
            let probability = signed_rank(&ratios);
            (ratios, probability)
        })
        .collect();
    let adjusted = holm(&each.iter().map(|(_, probability)| *probability).collect::<Vec<f64>>());
    each.iter().zip(adjusted).map(|((ratios, _), probability)| judged(ratios, probability)).collect()
}

/// Returns the best planner of every cell at `budget` (an index); the family is every cell with every other planner.
pub fn best(profile: &Profile, budget: usize) -> Vec<Best> {
    let count = profile.planners.len();
    let leaders: Vec<usize> = profile
        .rows
        .iter()
        .map(|row| {
            let mean = |planner: usize| row.costs(planner, budget).iter().map(|cost| libm::log(*cost)).sum::<f64>();
            (0..count).min_by(|a, b| mean(*a).total_cmp(&mean(*b))).unwrap_or(0)
        })
        .collect();
    let mut ratios = Vec::new();
    for (row, leader) in profile.rows.iter().zip(&leaders) {
        let others = (0..count).filter(|other| other != leader);
        ratios.extend(others.map(|other| (other, log_ratios(row.costs(*leader, budget), row.costs(other, budget)))));
    }
    let adjusted = holm(&ratios.iter().map(|(_, ratios)| signed_rank(ratios)).collect::<Vec<f64>>());
    let compared: Vec<(usize, Comparison)> = ratios
        .iter()
        .zip(adjusted)
        .map(|((other, ratios), probability)| (*other, judged(ratios, probability)))
        .collect();
    let others = count.saturating_sub(1);
    let of_cell = |cell: usize| compared.get(cell * others..(cell + 1) * others).unwrap_or_default();
    leaders.iter().enumerate().map(|(cell, leader)| best_of(*leader, of_cell(cell))).collect()
}

fn best_of(planner: usize, others: &[(usize, Comparison)]) -> Best {
    let next = others.iter().max_by(|(_, a), (_, b)| a.effect.total_cmp(&b.effect)).copied();
    let all = |allowed: &[Verdict]| others.iter().all(|(_, one)| allowed.contains(&one.verdict));
    let verdict = if all(&[Verdict::First]) {
        Verdict::First
    } else if all(&[Verdict::First, Verdict::NoDifference]) {
        Verdict::NoDifference
    } else {
        Verdict::Undecided
    };
    Best { planner, next, verdict }
}

fn log_ratios(first: &[f64], second: &[f64]) -> Vec<f64> {
    first.iter().zip(second).map(|(first, second)| libm::log(first / second)).collect()
}

fn judged(ratios: &[f64], probability: f64) -> Comparison {
    let (effect, half_width) = mean_interval(ratios);
    let verdict = if effect.abs() + half_width < EFFECT_MIN {
        Verdict::NoDifference
    } else if probability >= ERROR_MAX || effect.abs() < EFFECT_MIN {
        Verdict::Undecided
    } else if effect < 0.0 {
        Verdict::First
    } else {
        Verdict::Second
    };
    Comparison { effect, half_width, probability, verdict }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the verdict on ratios that differ from `middle` by `noise`, up and down.
    fn verdict(middle: f64, noise: f64) -> Verdict {
        let ratios: Vec<f64> = (0..50).map(|at| middle + noise * (f64::from(at) - 24.5) / 14.4).collect();
        judged(&ratios, signed_rank(&ratios)).verdict
    }

    #[test]
    fn verdicts_need_proof_and_size() {
        assert_eq!(verdict(-0.02, 0.01), Verdict::First);
        assert_eq!(verdict(0.02, 0.01), Verdict::Second);
        assert_eq!(verdict(0.0, 0.01), Verdict::NoDifference);
        assert_eq!(verdict(-0.005, 0.001), Verdict::NoDifference, "certain, but too small to win");
        assert_eq!(verdict(-0.0095, 0.01), Verdict::Undecided, "certain, too small, and perhaps not");
        assert_eq!(verdict(-0.02, 0.3), Verdict::Undecided);
        assert_eq!(judged(&[-0.5], 1.0).verdict, Verdict::Undecided);
        assert_eq!(judged(&[0.0; 50], 1.0).verdict, Verdict::NoDifference);
    }
}
