//! The native half of the Python package `apex_autonomy`: translation only. The documentation of arguments and results for Python users
//! is in the package; the executive determines the meaning of conditions.

mod condition_status;
mod costs;
mod errors;
mod flight;
mod planner;
mod planning;
mod profile;
mod recorded;
mod results;
mod runs;
mod session;
mod source;
mod values;

use pyo3::prelude::*;

/// Native half of `apex_autonomy`.
#[pymodule]
fn _apex(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<session::Session>()?;
    module.add_class::<results::Results>()?;
    module.add_class::<results::Result>()?;
    module.add_class::<results::Evidence>()?;
    module.add_class::<condition_status::ConditionStatus>()?;
    module.add_class::<condition_status::Reason>()?;
    module.add_class::<values::Interval>()?;
    module.add_class::<values::Quantity>()?;
    module.add_class::<values::Symbol>()?;
    module.add_class::<values::Variable>()?;
    module.add_class::<planner::PlannerContext>()?;
    module.add_function(wrap_pyfunction!(instant_ns, module)?)?;
    module.add_class::<planning::LoadedMission>()?;
    module.add_class::<planning::Means>()?;
    module.add_function(wrap_pyfunction!(planning::plan_json, module)?)?;
    module.add_function(wrap_pyfunction!(planning::problem_json, module)?)?;
    module.add_function(wrap_pyfunction!(flight::fly_json, module)?)?;
    module.add_function(wrap_pyfunction!(runs::fly_runs_json, module)?)?;
    module.add_function(wrap_pyfunction!(recorded::replay_json, module)?)?;
    module.add_function(wrap_pyfunction!(recorded::trace_json, module)?)?;
    module.add_function(wrap_pyfunction!(recorded::fork_json, module)?)?;
    module.add_function(wrap_pyfunction!(recorded::report_json, module)?)?;
    module.add_function(wrap_pyfunction!(profile::cell_names, module)?)?;
    module.add_function(wrap_pyfunction!(profile::measured, module)?)?;
    module.add_function(wrap_pyfunction!(profile::merged_profile, module)?)?;
    module.add_function(wrap_pyfunction!(profile::profile_table, module)?)?;
    module.add_function(wrap_pyfunction!(costs::expected_cost_of, module)?)?;
    module.add_function(wrap_pyfunction!(costs::cost_points, module)?)?;
    errors::register(module)
}

/// Returns an instant in whole nanoseconds, by the rules of `Monitor`.
#[pyfunction]
fn instant_ns(instant: &Bound<'_, PyAny>) -> PyResult<i64> {
    values::nanoseconds_of(instant)
}
