//! Checked expressions: the small total language of `pdl.md`, Forms, after loading.
//!
//! Evaluated by the executive; built by the PDL front end. Names are resolved: a [`ExprKind::Local`] is lexically
//! bound, a [`ExprKind::Call`] names a built-in, a `defun` of the library, or a declared host function.

use crate::source::Place;
use crate::symbol::Symbol;
use crate::value::Value;
use serde::{Deserialize, Serialize};

/// An expression with its place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Expr {
    /// Kind and operands.
    pub kind: ExprKind,
    /// Place in the source.
    pub place: Place,
}

/// The forms of expressions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ExprKind {
    /// A literal, a quoted datum, a `defconstant`'s value, or an unquoted symbol without another meaning.
    Constant(Value),
    /// `?x`, or `<?x>` when `must_be_bound`. The name is stored without its question mark.
    Variable {
        /// The name without `?`.
        name: Symbol,
        /// True if written `<?x>`: an unbound variable is then an error, even where `?x` would be free.
        must_be_bound: bool,
    },
    /// A parameter or `let` variable, or a primitive's `locals` variable.
    Local(Symbol),
    /// `+name+`, stored without the plus signs; evaluated again at each use.
    Indexical(Symbol),
    /// A `defconstant` whose value is computed, by its written name; a literal one is a [`ExprKind::Constant`].
    Named(Symbol),
    /// A call of a built-in, `defun` or host function.
    Call {
        /// The function's name.
        function: Symbol,
        /// The arguments in order; all are evaluated.
        arguments: Vec<Expr>,
    },
    /// `(if test then [else])`.
    If(Box<Expr>, Box<Expr>, Option<Box<Expr>>),
    /// `(cond (test form..)..)`; `(case ..)` is stored in the same way.
    Cond(Vec<(Expr, Vec<Expr>)>),
    /// `(case key ((datum..) form..) .. (otherwise form..))`; an empty list of data is `otherwise`.
    Case(Box<Expr>, Vec<(Vec<Value>, Vec<Expr>)>),
    /// `(and ..)`: the last value or nil.
    And(Vec<Expr>),
    /// `(or ..)`: the first true value or nil.
    Or(Vec<Expr>),
    /// `let`, or `let*` when `sequential`.
    Let {
        /// True for `let*`: later initial values see earlier variables.
        sequential: bool,
        /// Variables with initial values.
        bindings: Vec<(Symbol, Expr)>,
        /// The body; its last value is the result.
        body: Vec<Expr>,
    },
    /// `(lambda (parameter..) body..)`.
    Lambda {
        /// The parameters.
        parameters: Parameters,
        /// The body.
        body: Vec<Expr>,
    },
    /// `#'name` or a function name given to `map`, `filter` and the like.
    FunctionName(Symbol),
    /// `(setq name value)`; `(setq ?x value)` writes a variable of the task.
    Assign {
        /// The assigned name, without `?`.
        name: Symbol,
        /// True if written `?x`: a variable of the task, not a local.
        of_task: bool,
        /// The new value.
        value: Box<Expr>,
    },
    /// `(progn ..)`.
    Sequence(Vec<Expr>),
    /// A quasi-quoted form.
    Template(Box<Template>),
}

/// The parameters of a function: `(a b &optional c (d 2) &rest others)`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// Required parameters, in order.
    pub required: Vec<Symbol>,
    /// `&optional` parameters with their defaults; nil without an expression. The expression sees the parameters before it.
    pub optional: Vec<(Symbol, Option<Expr>)>,
    /// `&rest`: the list of all further arguments.
    pub rest: Option<Symbol>,
}

impl Parameters {
    /// Returns required parameters only.
    pub fn fixed(names: impl IntoIterator<Item = Symbol>) -> Parameters {
        Parameters { required: names.into_iter().collect(), ..Parameters::default() }
    }

    /// Returns all names in order of writing.
    pub fn names(&self) -> impl Iterator<Item = &Symbol> {
        self.required.iter().chain(self.optional.iter().map(|(name, _)| name)).chain(&self.rest)
    }

    /// Returns the least number of arguments.
    pub fn arguments_min(&self) -> usize {
        self.required.len()
    }

    /// Returns the greatest number of arguments; `None` is unlimited.
    pub fn arguments_max(&self) -> Option<usize> {
        self.rest.is_none().then_some(self.required.len() + self.optional.len())
    }
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

/// A function value with its captured variables.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Closure {
    /// The parameters.
    pub parameters: Parameters,
    /// The body.
    pub body: Vec<Expr>,
    /// Captured local variables.
    pub captured: Vec<(Symbol, Value)>,
    /// Place of the lambda in the source.
    pub place: Place,
}
