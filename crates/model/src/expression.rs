//! Checked expressions: the small total language of `pdl.md` section 6, after loading.
//!
//! Evaluated by the executive; built by the PDL front end. Names are resolved: a [`ExprKind::Local`] is lexically
//! bound, a [`ExprKind::Call`] names a built-in, a `defun` of the library, or a declared host function.

use crate::source::Place;
use crate::symbol::Symbol;
use crate::value::Value;
use serde::{Deserialize, Serialize};

/// An expression and where it stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Expr {
    /// What it is.
    pub kind: ExprKind,
    /// Where it stands.
    pub place: Place,
}

/// The forms of expressions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ExprKind {
    /// A literal, a quoted datum, a `defconstant`'s value, or an unquoted symbol that names nothing else.
    Constant(Value),
    /// `?x`, or `<?x>` when `must_be_bound`. The name is stored without its question mark.
    Variable {
        /// The name without `?`.
        name: Symbol,
        /// Written `<?x>`: unbound is an error even where `?x` would be free.
        must_be_bound: bool,
    },
    /// A parameter or `let` variable, or a primitive's `locals` variable.
    Local(Symbol),
    /// `+name+`, stored without the plus signs; evaluated anew at each use.
    Indexical(Symbol),
    /// A call of a built-in, `defun` or host function.
    Call {
        /// The function's name.
        function: Symbol,
        /// The arguments in order; all are evaluated.
        arguments: Vec<Expr>,
    },
    /// `(if test then [else])`.
    If(Box<Expr>, Box<Expr>, Option<Box<Expr>>),
    /// `(cond (test form..)..)`; `(case ..)` is stored so too.
    Cond(Vec<(Expr, Vec<Expr>)>),
    /// `(case key ((datum..) form..) .. (otherwise form..))`; an empty list of data is `otherwise`.
    Case(Box<Expr>, Vec<(Vec<Value>, Vec<Expr>)>),
    /// `(and ..)`: the last value or nil.
    And(Vec<Expr>),
    /// `(or ..)`: the first true value or nil.
    Or(Vec<Expr>),
    /// `let`, or `let*` when `sequential`.
    Let {
        /// Later initial values see earlier variables.
        sequential: bool,
        /// Variables with initial values.
        bindings: Vec<(Symbol, Expr)>,
        /// The body; its last value is the result.
        body: Vec<Expr>,
    },
    /// `(lambda (parameter..) body..)`.
    Lambda {
        /// Parameter names.
        parameters: Vec<Symbol>,
        /// The body.
        body: Vec<Expr>,
    },
    /// `#'name` or a function name given to `map`, `filter` and the like.
    FunctionName(Symbol),
    /// `(setq name value)`; `(setq ?x value)` writes a variable of the task.
    Assign {
        /// The assigned name, without `?`.
        name: Symbol,
        /// Written `?x`: a variable of the task, not a local.
        of_task: bool,
        /// The new value.
        value: Box<Expr>,
    },
    /// `(progn ..)`.
    Sequence(Vec<Expr>),
    /// A quasi-quoted form.
    Template(Box<Template>),
}

/// A datum with holes: activities, quasi-quoted forms, event forms to send.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Template {
    /// A part without holes.
    Constant(Value),
    /// Replaced by the expression's value: a variable, an indexical, or `,EXPR`.
    Hole(Expr),
    /// `,@EXPR`: replaced by the items of the expression's value.
    Splice(Expr),
    /// A list with at least one hole inside.
    List(Vec<Template>),
}

/// A function value with what it captured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Closure {
    /// Parameter names.
    pub parameters: Vec<Symbol>,
    /// The body.
    pub body: Vec<Expr>,
    /// Captured local variables.
    pub captured: Vec<(Symbol, Value)>,
    /// Where the lambda stands.
    pub place: Place,
}
