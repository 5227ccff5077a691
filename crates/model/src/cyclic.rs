//! The condition `:cyclic`, as read from PDL.

use crate::condition::{Constraint, VariablePattern};
use crate::symbol::Symbol;
use serde::{Deserialize, Serialize};

/// Repeated swings of a state variable, with constraints by option.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CyclicCondition {
    /// The watched variable.
    pub variable: VariablePattern,
    /// Constraints by option, in the order in which they are written: `period`, `amplitude`, `cycles`, `hysteresis`.
    pub options: Vec<(Symbol, Vec<Constraint>)>,
}
