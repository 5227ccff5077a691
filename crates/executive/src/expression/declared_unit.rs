//! Declared units of state variables: the unit that a bare number of a sample, or of a published value, has.

use super::arithmetic::{described, with_unit};
use apex_model::event::StateVariable;
use apex_model::library::Library;
use apex_model::quantity::{Dimension, Unit, unit_named};
use apex_model::symbol::Symbol;
use apex_model::value::Value;

/// Returns the unit that samples of `attribute` are declared with.
pub(crate) fn unit_of(attribute: &Symbol, library: &Library) -> Option<&'static Unit> {
    let declared = library.state_variables.get(attribute)?.unit.as_ref()?;
    unit_named(declared.printed())
}

/// Returns `value` as the history of `variable` holds it: a number without unit gets the declared unit of the variable.
///
/// # Errors
/// A message for the trace when the unit cannot measure the value.
pub(crate) fn in_declared_unit(library: &Library, variable: &StateVariable, value: Value) -> Result<Value, String> {
    in_unit(unit_of(&variable.attribute, library), variable, value)
}

/// Returns `value` in `unit`, the declared unit of `variable`; as it is without one.
///
/// # Errors
/// Like [`in_declared_unit`].
pub(crate) fn in_unit(unit: Option<&'static Unit>, variable: &StateVariable, value: Value) -> Result<Value, String> {
    let Some(unit) = unit else { return Ok(value) };
    match value.as_number() {
        Some((number, Dimension::NONE)) => Ok(with_unit(number, unit)),
        Some((_, dimension)) if dimension == unit.dimension => Ok(value),
        _ => Err(format!(
            "the sample {} of {variable} was refused: it is declared in {}, which measures {}",
            described(&value),
            unit.name,
            unit.dimension
        )),
    }
}
