//! The mission score of single-visit missions (paper, section II.B):
//! `M = sum_j v_j c_j r_j s_j o_j(t) - (sum_k H_k W_k + P (R C_v + M C_m))`.
//!
//! Value, coverage, resolution, clarity and timing; hours and wages; probability of failure with what it would cost.
//! Every factor keeps its cause, so that a score can be explained target by target.

use apex_model::problem::{CrewMember, FailureTerm, QualityFactor, QualityFactors, SingleVisitProblem};
use std::fmt;

/// One observation as planned or as flown.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// The target's name.
    pub target: String,
    /// v: worth of a perfect observation.
    pub value: f64,
    /// c, r and s with their causes.
    pub quality: QualityFactors,
    /// o(t) with its cause.
    pub timing: QualityFactor,
}

/// Hours of one person.
#[derive(Clone, Debug, PartialEq)]
pub struct WorkedHours {
    /// What they do.
    pub role: String,
    /// H: hours.
    pub hours: f64,
    /// W: pay per hour, in units of target value.
    pub wage_per_hour: f64,
}

/// One target's share of the score.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetScore {
    /// The observation.
    pub observation: Observation,
    /// The product of value and factors.
    pub worth: f64,
}

impl fmt::Display for TargetScore {
    /// `Zaca: 10 x clarity 0.70 (roll 12 deg for 8 s on leg 3) = 7.00`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let observation = &self.observation;
        write!(f, "{}: {}", observation.target, observation.value)?;
        let factors = [
            ("coverage", &observation.quality.coverage),
            ("resolution", &observation.quality.resolution),
            ("clarity", &observation.quality.clarity),
            ("timing", &observation.timing),
        ];
        for (name, factor) in factors.into_iter().filter(|(_, factor)| factor.factor != 1.0) {
            write!(f, " x {name} {:.2}", factor.factor)?;
            if !factor.cause.is_empty() {
                write!(f, " ({})", factor.cause)?;
            }
        }
        write!(f, " = {:.2}", self.worth)
    }
}

/// The score with all its parts.
#[derive(Clone, Debug, PartialEq)]
pub struct MissionScore {
    /// Each observation's share.
    pub targets: Vec<TargetScore>,
    /// Sum of the shares.
    pub benefits: f64,
    /// Sum of hours times wages.
    pub personnel_cost: f64,
    /// P: probability of failure over the flight.
    pub failure_probability: f64,
    /// `P (R C_v + M C_m)`.
    pub failure_cost: f64,
    /// M: benefits minus costs.
    pub score: f64,
}

/// Scores a mission. A target observed more than once counts once, with its best observation.
pub fn mission_score(
    observations: &[Observation],
    hours: &[WorkedHours],
    failure: &FailureTerm,
    flight_hours: f64,
) -> MissionScore {
    let mut targets: Vec<TargetScore> = Vec::new();
    for observation in observations {
        let worth = observation.value * observation.quality.product() * observation.timing.factor;
        let score = TargetScore { observation: observation.clone(), worth };
        match targets.iter_mut().find(|earlier| earlier.observation.target == observation.target) {
            Some(earlier) if earlier.worth < worth => *earlier = score,
            Some(_) => {}
            None => targets.push(score),
        }
    }
    let benefits = targets.iter().map(|target| target.worth).sum();
    let personnel_cost = hours.iter().map(|person| person.hours * person.wage_per_hour).sum();
    let failure_probability = failure_probability(failure, flight_hours);
    let failure_cost = failure_probability
        * (failure.vehicle_share * failure.vehicle_cost + failure.mission_share * failure.mission_cost);
    let score = benefits - (personnel_cost + failure_cost);
    MissionScore { targets, benefits, personnel_cost, failure_probability, failure_cost, score }
}

/// P over a flight: failures come at a constant rate.
pub fn failure_probability(failure: &FailureTerm, flight_hours: f64) -> f64 {
    -libm::expm1(-failure.probability_per_hour * flight_hours.max(0.0))
}

/// Hours that a crew works for a flight.
pub fn crew_hours(crew: &[CrewMember], flight_hours: f64) -> Vec<WorkedHours> {
    let worked = |member: &CrewMember| WorkedHours {
        role: member.role.clone(),
        hours: member.fixed_hours + member.flight_share * flight_hours,
        wage_per_hour: member.wage_per_hour,
    };
    crew.iter().map(worked).collect()
}

/// Personnel and failure costs of a flight of `flight_s`.
pub fn flight_cost(problem: &SingleVisitProblem, flight_s: f64) -> f64 {
    let hours = flight_s / 3600.0;
    let score = mission_score(&[], &crew_hours(&problem.crew, hours), &problem.failure, hours);
    -score.score
}

#[cfg(test)]
mod tests {
    use super::*;

    fn observation(target: &str, clarity: f64) -> Observation {
        let cause = if clarity < 1.0 { "roll 12 deg for 8 s on leg 3" } else { "" };
        Observation {
            target: target.to_string(),
            value: 10.0,
            quality: QualityFactors {
                clarity: QualityFactor { factor: clarity, cause: cause.to_string() },
                ..QualityFactors::default()
            },
            timing: QualityFactor::default(),
        }
    }

    #[test]
    fn the_formula_of_the_paper() {
        let hours = [WorkedHours { role: "pilot".into(), hours: 2.0, wage_per_hour: 0.5 }];
        let failure = FailureTerm {
            probability_per_hour: 0.01,
            vehicle_share: 0.5,
            vehicle_cost: 100.0,
            mission_share: 1.0,
            mission_cost: 20.0,
        };
        let score = mission_score(&[observation("Zaca", 0.7), observation("Lick", 1.0)], &hours, &failure, 2.0);
        let probability = 1.0 - libm::exp(-0.02);
        assert!((score.benefits - 17.0).abs() < 1e-12 && score.personnel_cost == 1.0);
        assert!((score.failure_cost - probability * 70.0).abs() < 1e-12);
        assert!((score.score - (17.0 - 1.0 - probability * 70.0)).abs() < 1e-12);
    }

    #[test]
    fn every_factor_names_its_cause() {
        let score = mission_score(&[observation("Zaca", 0.7)], &[], &FailureTerm::default(), 1.0);
        assert_eq!(score.targets[0].to_string(), "Zaca: 10 x clarity 0.70 (roll 12 deg for 8 s on leg 3) = 7.00");
    }

    #[test]
    fn the_best_of_two_observations_counts_once() {
        let observations = [observation("Zaca", 0.7), observation("Zaca", 0.9), observation("Zaca", 0.2)];
        let score = mission_score(&observations, &[], &FailureTerm::default(), 1.0);
        assert_eq!((score.targets.len(), score.benefits), (1, 9.0));
    }
}
