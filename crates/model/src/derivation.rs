//! Derived state variables: values that are computed from samples of other state variables.

use crate::expression::Expr;
use crate::pattern::Pattern;
use crate::source::Place;
use crate::symbol::Symbol;
use crate::time::Duration;
use serde::{Deserialize, Serialize};

/// `(state-variable (ATTR ?object) .. :derived EXPR [:join J])`: how samples of the variable are computed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Derivation {
    /// The variable of the object, without `?`.
    pub object: Symbol,
    /// Inputs that the expression reads, each once.
    pub inputs: Vec<DerivationInput>,
    /// The value, in terms of the names of the inputs and of `object`.
    pub value: Expr,
    /// Rule by which samples of several variables are brought to one instant.
    pub join: Join,
    /// Rank: a derivation reads only derived variables of lower ranks; rank 0 reads measured ones.
    pub rank: u32,
    /// Place in the source.
    pub place: Place,
}

/// One input of a derivation: the value that it reads from a state variable.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DerivationInput {
    /// The variable in the expression, without `?`.
    pub name: Symbol,
    /// The attribute of the state variable.
    pub attribute: Symbol,
    /// Its object: the derivation's object variable or a literal.
    pub object: Pattern,
    /// Value that is read.
    pub reads: Reading,
}

/// Value that a derivation reads of a state variable at an instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Reading {
    /// Its value.
    Value,
    /// The value of the sample before the latest one.
    Previous,
    /// The difference of the latest two samples over the time between them, per second.
    Rate,
    /// True if the latest sample differs from the one before it.
    Changed,
}

/// Rule by which samples of several variables are brought to one instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Join {
    /// A variable has the value of its latest sample for at most this time; `None` is without limit.
    Hold(Option<Duration>),
    /// A number is interpolated linearly between the samples before and after, if they are at most this far apart; other values hold.
    Interpolate(Duration),
}
