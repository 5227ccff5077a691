//! Exceptions, all in one place.

use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyValueError};
use pyo3::prelude::*;

create_exception!(apex_autonomy, ApexError, PyException, "Base of all exceptions of this package.");
create_exception!(
    apex_autonomy,
    ConditionError,
    ApexError,
    "A condition or the library that it is read in cannot be used. The text says what is wrong, where, why and what to do."
);
create_exception!(
    apex_autonomy,
    InputError,
    ApexError,
    "Something handed over cannot be used: a name that is no state variable, a value that PDL has no word for, arrays of different lengths."
);

create_exception!(
    apex_autonomy,
    PlanningError,
    ApexError,
    "There is no plan: the problem cannot be read or makes no sense, nothing can be visited, or the planner's plan was refused."
);

/// Makes the exceptions known.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let python = module.py();
    module.add("ApexError", python.get_type::<ApexError>())?;
    module.add("ConditionError", python.get_type::<ConditionError>())?;
    module.add("InputError", python.get_type::<InputError>())?;
    module.add("PlanningError", python.get_type::<PlanningError>())
}

/// An [`InputError`].
pub(crate) fn input(message: impl Into<String>) -> PyErr {
    InputError::new_err(message.into())
}

/// A `ValueError`, for arguments that Python's own conventions name so.
pub(crate) fn value(message: impl Into<String>) -> PyErr {
    PyValueError::new_err(message.into())
}
