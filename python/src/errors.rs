//! The exceptions of the package.

use apex_mission::error::MissionError as Failure;
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyUserWarning, PyValueError};
use pyo3::prelude::*;
use std::ffi::CString;

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
    "An argument cannot be used: a name that is not a state variable, a value that PDL cannot express, arrays of different lengths."
);

create_exception!(
    apex_autonomy,
    MissionError,
    ApexError,
    "A mission, a flight, a record or a profile failed. `message` says what failed, `place` where, `reason` why, `help` what to do;\n\
     the last three are None where there is nothing to say. The text of the exception holds all four."
);
create_exception!(
    apex_autonomy,
    PlanningError,
    MissionError,
    "There is no plan: the problem cannot be read or is invalid, nothing can be visited, or the planner's plan was refused."
);

create_exception!(
    apex_autonomy,
    RecordWarning,
    PyUserWarning,
    "A flight record whose content is used is incomplete, was changed, is not as it was signed, or is of another version of Apex."
);

/// Registers the exceptions in the module.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let python = module.py();
    module.add("ApexError", python.get_type::<ApexError>())?;
    module.add("ConditionError", python.get_type::<ConditionError>())?;
    module.add("InputError", python.get_type::<InputError>())?;
    let mission = python.get_type::<MissionError>();
    // Instances of failures have separate values; the class has these so that the attributes always exist.
    mission.setattr("message", "")?;
    for attribute in ["place", "reason", "help"] {
        mission.setattr(attribute, python.None())?;
    }
    module.add("MissionError", mission)?;
    module.add("PlanningError", python.get_type::<PlanningError>())?;
    module.add("RecordWarning", python.get_type::<RecordWarning>())
}

/// Warns of a record by Python's `warnings`, at the line that called the package.
///
/// # Errors
/// The exception that a filter of the program makes of the warning.
pub(crate) fn warn(python: Python<'_>, text: &str) -> PyResult<()> {
    let text = CString::new(text.replace('\0', " ")).unwrap_or_default();
    PyErr::warn(python, &python.get_type::<RecordWarning>(), &text, 2)
}

/// Returns an [`InputError`].
pub(crate) fn input(message: impl Into<String>) -> PyErr {
    InputError::new_err(message.into())
}

/// Returns a `ValueError`, for arguments for which Python's conventions require it.
pub(crate) fn value(message: impl Into<String>) -> PyErr {
    PyValueError::new_err(message.into())
}

/// Returns a failure of the mission crate as a [`MissionError`].
pub(crate) fn mission(python: Python<'_>, failure: Failure) -> PyErr {
    exception(python, MissionError::new_err, failure)
}

/// Returns a failure of the mission crate as a [`PlanningError`].
pub(crate) fn planning(python: Python<'_>, failure: Failure) -> PyErr {
    exception(python, PlanningError::new_err, failure)
}

fn exception(python: Python<'_>, new: impl FnOnce(String) -> PyErr, failure: Failure) -> PyErr {
    let mut failure = failure;
    if let Some(checked) = failure.diagnostics.take() {
        failure.reason =
            Some(apex_pdl::render(&checked.diagnostics, &checked.library.sources, false).trim_end().to_string());
    }
    let error = new(failure.to_string());
    let value = error.value(python);
    let attributes = [
        ("message", Some(failure.message)),
        ("place", failure.place),
        ("reason", failure.reason),
        ("help", failure.help),
    ];
    let set = attributes.into_iter().try_for_each(|(name, text)| value.setattr(name, text));
    // If the attributes of an exception cannot be set, Python itself has failed, and that error is more informative.
    set.err().unwrap_or(error)
}
