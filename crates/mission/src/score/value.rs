//! The mission score of a flight: points of every wanted look as flown and as predicted by the plan, and costs.

use super::flown::FlownScore;
use crate::predicted::Predicted;
use crate::situation::Situation;
use crate::{Mission, Target, TargetKind};
use apex_metrics::mission_score::{crew_hours, failure_cost, failure_probability};
use apex_observation::result::{LookResult, TargetResult};

/// `M = sum_j v_j c_j r_j s_j o_j(t) - (sum_k H_k W_k + P (R C_v + M C_m))` of a flight, in points.
#[derive(Clone, Debug, PartialEq)]
pub struct FlightScore {
    /// Wanted looks that were observed, or seen at least in part.
    pub looks: Vec<ScoredLook>,
    /// Points of all wanted looks.
    pub benefits: f64,
    /// Costs by row, including the cost of required looks that are missing.
    pub costs: Vec<Cost>,
    /// P: probability of failure over the flight.
    pub failure_probability: f64,
    /// Benefits less costs.
    pub score: f64,
    /// Reason for which the flight cannot be scored; empty if it can.
    pub trouble: String,
}

/// Share of its value from which on a look counts as complete.
const COMPLETE: f64 = 0.999;

/// Returns true if a look was seen so well that another visit would add almost nothing.
pub(crate) fn is_complete(seen: &LookResult) -> bool {
    seen.value > 0.0 && seen.factors.product() >= COMPLETE
}

/// A cost in points.
#[derive(Clone, Debug, PartialEq)]
pub struct Cost {
    /// Kind of cost.
    pub kind: CostKind,
    /// Cause of the cost.
    pub name: String,
    /// Hours, a probability, or a number of occurrences.
    pub quantity: f64,
    /// Points for one unit of the quantity.
    pub price: f64,
}

/// Kinds of costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CostKind {
    /// Hours worked.
    Personnel,
    /// Probability of a critical failure.
    Failure,
    /// A look that must not be missed and was.
    Missed,
}

impl CostKind {
    /// Returns the word in reports.
    pub fn word(self) -> &'static str {
        match self {
            CostKind::Personnel => "personnel",
            CostKind::Failure => "failure",
            CostKind::Missed => "missed",
        }
    }
}

impl Cost {
    /// Returns points.
    pub fn points(&self) -> f64 {
        self.quantity * self.price
    }
}

/// One wanted look as flown and as predicted.
#[derive(Clone, Debug, PartialEq)]
pub struct ScoredLook {
    /// Its name in plans.
    pub id: String,
    /// The target's human-readable name, with the look's if it has several looks.
    pub name: String,
    /// As flown.
    pub flown: LookResult,
    /// Prediction of the flown plan; `None` if no plan contained the look.
    pub predicted: Option<Predicted>,
}

/// Scores a flight that lasted `hours`, with the values of targets in `mission`.
pub(crate) fn flight_score(
    mission: &Mission,
    situation: &Situation,
    flown: Result<&FlownScore, &str>,
    hours: f64,
) -> FlightScore {
    let results = flown.map(FlownScore::results).unwrap_or_default();
    let Benefits { looks: valued, points: benefits, missed } = benefits_of(mission, results);
    let mut looks = Vec::new();
    for (target, id, flown) in valued {
        let visit = situation.observed().filter(|visit| visit.target == id).last();
        if flown.seen.seen > 0.0 || visit.is_some() {
            let several = id != target.id;
            let name = if several { format!("{} {}", target.name, flown.name) } else { target.name.clone() };
            let predicted = visit.and_then(|visit| visit.predicted.clone());
            looks.push(ScoredLook { id, name, flown, predicted });
        }
    }
    let (running, failure_probability) = running_costs(mission, hours);
    let costs = [missed, running].concat();
    let score = benefits - costs.iter().map(Cost::points).sum::<f64>();
    let trouble = flown.err().unwrap_or_default().to_string();
    FlightScore { looks, benefits, costs, failure_probability, score, trouble }
}

/// The wanted looks of a mission with their results.
pub(super) struct Benefits<'a> {
    /// Each look with its target and its name in plans.
    looks: Vec<(&'a Target, String, LookResult)>,
    /// Points of all of them.
    pub(super) points: f64,
    /// Costs of looks that must not be missed and were.
    pub(super) missed: Vec<Cost>,
}

/// Returns the benefits of the seen looks, with the values of targets in `mission`.
pub(super) fn benefits_of(mission: &Mission, results: Vec<TargetResult>) -> Benefits<'_> {
    let mut benefits = Benefits { looks: Vec::new(), points: 0.0, missed: Vec::new() };
    for result in results {
        let Some(target) = mission.targets.iter().find(|target| target.id == result.name) else { continue };
        for (id, flown) in looks_of(target, result.looks) {
            benefits.points += flown.points;
            if let Some(price) = flown.must_missed {
                benefits.missed.push(Cost { kind: CostKind::Missed, name: id.clone(), quantity: 1.0, price });
            }
            benefits.looks.push((target, id, flown));
        }
    }
    benefits
}

/// Returns the costs that grow with the length of a flight, and its probability of failure.
pub(super) fn running_costs(mission: &Mission, hours: f64) -> (Vec<Cost>, f64) {
    let crew = crew_hours(&mission.crew, hours).into_iter();
    let mut costs: Vec<Cost> = crew
        .map(|person| Cost {
            kind: CostKind::Personnel,
            name: person.role,
            quantity: person.hours,
            price: person.wage_per_hour,
        })
        .collect();
    let probability = failure_probability(&mission.failure, hours);
    let cost = failure_cost(&mission.failure, hours);
    let price = if probability > 0.0 { cost / probability } else { 0.0 };
    costs.push(Cost { kind: CostKind::Failure, name: "vehicle and mission".to_string(), quantity: probability, price });
    (costs, probability)
}

/// Returns the looks with their names in plans, and the present value of the target's looks.
fn looks_of(target: &Target, results: Vec<LookResult>) -> Vec<(String, LookResult)> {
    let TargetKind::Fire(fire) = &target.kind else { return Vec::new() };
    let valued = |result: LookResult| {
        let (id, look) = fire.looks().find(|(_, look)| look.name == result.name)?;
        Some((id, worth(result, look.value)))
    };
    results.into_iter().filter_map(valued).collect()
}

/// Returns the result for a look of value `value`: all points scale in proportion.
fn worth(result: LookResult, value: f64) -> LookResult {
    if result.value == value {
        return result;
    }
    let share = value / result.value;
    let points = result.factors.product() * value;
    let mut losses = result.losses.clone();
    losses.iter_mut().for_each(|loss| loss.points = if result.value > 0.0 { loss.points * share } else { 0.0 });
    LookResult { value, points, losses, ..result }
}

impl FlightScore {
    /// Returns the sum of the costs of a kind.
    pub fn cost_of(&self, kind: CostKind) -> f64 {
        // The sum of nothing would be -0.
        self.costs.iter().filter(|cost| cost.kind == kind).map(Cost::points).fold(0.0, std::ops::Add::add)
    }
}
