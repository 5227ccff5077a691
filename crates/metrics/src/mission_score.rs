//! Costs of a flight in the score of single-visit missions (paper, section II.B): `M = sum_j v_j c_j r_j s_j o_j(t) - (sum_k H_k W_k + P
//! (R C_v + M C_m))`.
//!
//! These are hours and wages, and the probability of a failure with its cost. `apex-observation` scores the observations of a flight.

use apex_model::problem::{CrewMember, FailureTerm, SingleVisitProblem};

/// Hours of one crew member.
#[derive(Clone, Debug, PartialEq)]
pub struct WorkedHours {
    /// Role of the member.
    pub role: String,
    /// H: hours.
    pub hours: f64,
    /// W: pay per hour, in units of target value.
    pub wage_per_hour: f64,
}

/// Returns `P (R C_v + M C_m)` of a flight, in units of target value.
pub fn failure_cost(failure: &FailureTerm, flight_hours: f64) -> f64 {
    failure_probability(failure, flight_hours)
        * (failure.vehicle_share * failure.vehicle_cost + failure.mission_share * failure.mission_cost)
}

/// Returns P: the probability of a critical failure during a flight, with failures at a constant rate.
pub fn failure_probability(failure: &FailureTerm, flight_hours: f64) -> f64 {
    -libm::expm1(-failure.probability_per_hour * flight_hours.max(0.0))
}

/// Returns the hours that each crew member works for a flight.
pub fn crew_hours(crew: &[CrewMember], flight_hours: f64) -> Vec<WorkedHours> {
    let worked = |member: &CrewMember| WorkedHours {
        role: member.role.clone(),
        hours: member.fixed_hours + member.flight_share * flight_hours,
        wage_per_hour: member.wage_per_hour,
    };
    crew.iter().map(worked).collect()
}

/// Returns the personnel and failure costs of a flight of `flight_s`, in units of target value.
pub fn flight_cost(problem: &SingleVisitProblem, flight_s: f64) -> f64 {
    let hours = flight_s / 3600.0;
    let crew = crew_hours(&problem.crew, hours);
    let wages: f64 = crew.iter().map(|person| person.hours * person.wage_per_hour).sum();
    wages + failure_cost(&problem.failure, hours)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_costs_of_the_paper() {
        let failure = FailureTerm {
            probability_per_hour: 0.01,
            vehicle_share: 0.5,
            vehicle_cost: 100.0,
            mission_share: 1.0,
            mission_cost: 20.0,
        };
        let pilot = CrewMember { role: "pilot".into(), wage_per_hour: 0.5, fixed_hours: 1.0, flight_share: 0.5 };
        let problem = SingleVisitProblem { crew: vec![pilot], failure, ..SingleVisitProblem::default() };
        let probability = 1.0 - libm::exp(-0.02);
        assert!((failure_cost(&failure, 2.0) - probability * 70.0).abs() < 1e-12);
        assert!((flight_cost(&problem, 7200.0) - (1.0 + probability * 70.0)).abs() < 1e-12);
    }
}
