//! The limit on the time of a flight: endurance, fuel or the end of the mission, whichever comes first.

use apex_model::problem::{NamedLimit, SingleVisitProblem, TimeLimit};
use std::fmt;

/// A limit of the flight by name, with its cause if the problem states one.
#[derive(Clone, Debug)]
pub(crate) struct FlightLimit<'a> {
    name: &'a str,
    cause: Option<&'a str>,
    /// True if it is the time for which the energy lasts.
    is_energy: bool,
}

impl<'a> FlightLimit<'a> {
    fn of(named: Option<&'a NamedLimit>, otherwise: &'a str, is_energy: bool) -> FlightLimit<'a> {
        match named {
            Some(NamedLimit { name, cause }) => FlightLimit { name, cause: Some(cause), is_energy },
            None => FlightLimit { name: otherwise, cause: None, is_energy },
        }
    }

    /// Returns the latest end of the flight, and the limit that causes it.
    pub(crate) fn earliest(problem: &'a SingleVisitProblem) -> (f64, FlightLimit<'a>) {
        let vehicle = &problem.vehicle;
        let endurance = || FlightLimit::of(vehicle.endurance_limit.as_ref(), "endurance", true);
        let mut limits = vec![(problem.start_s + vehicle.endurance_s - vehicle.endurance_reserve_s, endurance())];
        if vehicle.fuel_flow_kg_per_s > 0.0 {
            let burn_s = (vehicle.fuel_kg - vehicle.fuel_reserve_kg) / vehicle.fuel_flow_kg_per_s;
            limits.push((problem.start_s + burn_s, FlightLimit::of(None, "fuel", true)));
        }
        let end = || FlightLimit::of(problem.end_limit.as_ref(), "the end of the mission", false);
        limits.extend(problem.end_s.map(|end_s| (end_s, end())));
        limits.into_iter().min_by(|(a, _), (b, _)| a.total_cmp(b)).unwrap_or_else(|| (problem.start_s, endurance()))
    }

    /// Returns the limit of a visit that comes too late.
    pub(crate) fn of_visit(&self) -> TimeLimit {
        let FlightLimit { name, cause, is_energy } = self;
        TimeLimit::Flight { name: (*name).to_owned(), cause: cause.map(str::to_owned), is_energy: *is_energy }
    }
}

impl fmt::Display for FlightLimit<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.cause {
            Some(cause) => write!(f, "{} ({cause})", self.name),
            None => f.write_str(self.name),
        }
    }
}
