//! Costs of ignorance written in Python: called by the metrics, which check the rules of costs.

use crate::errors::{InputError, input, planning};
use apex_metrics::eci::Likelihoods;
use apex_metrics::tabulate::tabulate;
use apex_metrics::user_cost::{UserCost, expected_cost_with};
use apex_mission::plan::input::PlanInput;
use apex_model::problem::{Problem, SurveillanceVisit};
use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use std::cell::RefCell;
use std::collections::BTreeMap;

/// Exception that a cost function raised.
type Raised = RefCell<Option<PyErr>>;

/// Returns the callable as a function of Rust.
fn asking<'a>(cost: &'a Bound<'_, PyAny>, raised: &'a Raised) -> impl FnMut(f64) -> Result<f64, String> + 'a {
    move |age_s| {
        let answer = cost.call1((age_s,)).and_then(|cost| cost.extract::<f64>());
        answer.map_err(|error| {
            let why = error.to_string();
            *raised.borrow_mut() = Some(error);
            why
        })
    }
}

/// Returns an `InputError` with the raised exception as its cause. Returns an exception that is not an error, such as a keyboard interrupt,
/// unchanged.
fn told(python: Python<'_>, why: String, raised: &Raised) -> PyErr {
    match raised.take() {
        Some(error) if !error.is_instance_of::<PyException>(python) => error,
        cause => {
            let error = InputError::new_err(why);
            error.set_cause(python, cause);
            error
        }
    }
}

/// Name, expected cost, number of observations and longest gap in seconds of each target.
type TargetCosts = Vec<(String, f64, usize, f64)>;

/// Returns the score of visits, each a target and the end of its observation. Costs have the name of their target and the ages of jumps;
/// with `survival` only the first event after an observation counts.
#[pyfunction]
pub(crate) fn expected_cost_of(
    python: Python<'_>,
    problem: &str,
    visits: Vec<(String, f64)>,
    costs: Vec<(String, Bound<'_, PyAny>, Vec<f64>)>,
    survival: bool,
) -> PyResult<(f64, TargetCosts)> {
    let read = PlanInput::of_json(problem, "the problem").map_err(|failure| planning(python, failure))?;
    let problem = match read.problem {
        Problem::Surveillance(problem) => problem,
        Problem::SingleVisit(_) => return Err(input("only problems of surveillance have a cost of ignorance")),
    };
    let visit = |(target, end_s)| SurveillanceVisit { target, arrive_s: end_s, end_s };
    let visits: Vec<SurveillanceVisit> = visits.into_iter().map(visit).collect();
    let raised = Raised::default();
    let mut own = BTreeMap::new();
    for (name, cost, jumps_s) in &costs {
        let function = Box::new(asking(cost, &raised));
        own.insert(name.clone(), UserCost { function, jumps_s: jumps_s.clone() });
    }
    let likelihoods = if survival { Likelihoods::Survival } else { Likelihoods::Added };
    let cost =
        expected_cost_with(&problem, &visits, &mut own, likelihoods).map_err(|why| told(python, why, &raised))?;
    let row = |target: apex_metrics::eci::TargetCost| {
        (target.target, target.expected_cost, target.observations, target.longest_gap_s)
    };
    Ok((cost.total, cost.targets.into_iter().map(row).collect()))
}

/// Returns the points of a cost's table.
#[pyfunction]
pub(crate) fn cost_points(
    python: Python<'_>,
    cost: &Bound<'_, PyAny>,
    horizon_s: f64,
    relative_error: f64,
) -> PyResult<Vec<(f64, f64)>> {
    let raised = Raised::default();
    let points = tabulate(&mut asking(cost, &raised), horizon_s, relative_error);
    points.map_err(|why| told(python, why, &raised))
}
