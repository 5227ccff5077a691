//! The method for a goal with its place, for readers of a record.

use apex_model::effect::Method;
use apex_model::source::Place;
use serde::Serialize;
use std::fmt;

/// Method for a goal.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct MethodDetail {
    /// `procedure`, `primitive`, `built-in` or `solver`.
    pub kind: &'static str,
    /// `file:line:column` of the procedure or primitive.
    pub place: Option<String>,
    /// The solver's name.
    pub name: Option<String>,
}

impl MethodDetail {
    /// Returns the detail of `method`; `place` describes a place.
    pub(crate) fn of(method: &Method, place: impl FnOnce(Place) -> String) -> MethodDetail {
        let (kind, place, name) = match method {
            Method::Procedure(at) => ("procedure", Some(place(*at)), None),
            Method::Primitive(at) => ("primitive", Some(place(*at)), None),
            Method::BuiltIn => ("built-in", None, None),
            Method::Solver(name) => ("solver", None, Some(name.to_string())),
        };
        MethodDetail { kind, place, name }
    }
}

/// Writes `procedure first-picture.pdl:3:1`, `built-in` or `solver wam`.
impl fmt::Display for MethodDetail {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.kind)?;
        match self.place.as_ref().or(self.name.as_ref()) {
            Some(rest) => write!(f, " {rest}"),
            None => Ok(()),
        }
    }
}
