//! Patterns over values: indexes of procedures, awaited events (`pdl.md`, Patterns). Paper: pattern matching service.

use crate::expression::Expr;
use crate::symbol::Symbol;
use crate::value::Value;
use serde::{Deserialize, Serialize};

/// A pattern. Matching yields bindings, a match without bindings, or failure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Pattern {
    /// Matches by [`Value::matches`]: numbers by value, strings and symbols in any case.
    Literal(Value),
    /// `?x`: binds the variable, or must match its value if it is bound. Stored without `?`.
    Variable(Symbol),
    /// `<?x>`: must be bound already.
    BoundVariable(Symbol),
    /// `?`: matches any one value.
    Anonymous,
    /// `+name+` or an unquoted `,EXPR`: matches the expression's value.
    Computed(Expr),
    /// A list, element by element; may contain [`Pattern::Segment`]s.
    List(Vec<Pattern>),
    /// `(?* ?x)`, `(?+ ?x)`, `(?? ?x)`: a run of elements of the surrounding list, bound as a list.
    Segment {
        /// The variable, if any.
        variable: Option<Symbol>,
        /// Least number of elements.
        minimum: u8,
        /// Maximum number of elements; `None` if it is unlimited.
        maximum: Option<u8>,
    },
    /// `(?if EXPR)`: matches no element; holds if the expression is true under the bindings so far.
    Guard(Expr),
    /// `(?is ?x pred)`: matches any one value for which the predicate of that name holds, and binds it.
    Is {
        /// The variable.
        variable: Symbol,
        /// The name of a predicate: built-in, `defun`, or host function.
        predicate: Symbol,
    },
    /// All patterns match the same value.
    And(Vec<Pattern>),
    /// The first pattern that matches.
    Or(Vec<Pattern>),
    /// The pattern does not match; binds nothing.
    Not(Box<Pattern>),
}
