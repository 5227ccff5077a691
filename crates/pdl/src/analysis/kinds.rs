//! Kinds of values of expressions: a number of a dimension, an instant, or neither, as far as the program determines them.
//! Follows `let`, functions, indexicals and queries of declared state variables.

use super::walk::{self, QUERIES};
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::Library;
use apex_model::quantity::{Dimension, unit_named};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::collections::BTreeMap;

/// The kind of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Unknown before it is evaluated.
    Unknown,
    /// A number, quantity or span of time of this dimension.
    Number(Dimension),
    /// A point in time.
    Instant,
    /// Another kind, as text.
    Other(&'static str),
}

impl Kind {
    /// Returns the kind as text, with an article if it needs one.
    pub(crate) fn words(self) -> String {
        match self {
            Kind::Unknown => "unknown".to_string(),
            Kind::Number(Dimension::TIME) => "a span of time".to_string(),
            Kind::Number(dimension) => dimension.to_string(),
            Kind::Instant => "an instant".to_string(),
            Kind::Other(what) => what.to_string(),
        }
    }

    /// Returns the kind of both, where they agree.
    fn join(self, other: Kind) -> Kind {
        if self == other { self } else { Kind::Unknown }
    }
}

/// Maximum number of calls of functions and indexicals that are followed into each other.
const DEPTH_MAX: usize = 8;
/// Maximum number of expressions inspected for the kind of one expression.
const STEPS_MAX: usize = 2_000;

/// Finds kinds.
pub(crate) struct Kinds<'l> {
    library: &'l Library,
    /// Variables of functions and `let`s, innermost last.
    locals: Vec<(&'l Symbol, Kind)>,
    /// Variables of the procedure.
    variables: BTreeMap<&'l Symbol, Kind>,
    depth: usize,
    steps: usize,
    /// The number of branches around an expression: it may never be evaluated.
    branches: usize,
    /// The first sum or comparison of a called function that fails whenever the function is called so.
    mismatch: Option<SumMismatch>,
}

/// A sum or comparison of values of different dimensions.
pub(crate) struct SumMismatch {
    pub(crate) function: Symbol,
    pub(crate) kinds: [Kind; 2],
    pub(crate) place: Place,
}

/// Functions whose numeric arguments must have the same dimension.
pub(crate) const ONE_DIMENSION: &[&str] = &["+", "-", "/=", "<", "<=", "=", ">", ">=", "max", "min", "mod", "rem"];

impl<'l> Kinds<'l> {
    /// Returns the kind of `expr`, an expression outside of functions.
    pub(crate) fn of(library: &'l Library, expr: &'l Expr) -> Kind {
        Kinds::new(library).kind(expr)
    }

    /// Returns the kind of `expr` where variables of its procedure have known kinds.
    pub(crate) fn with(library: &'l Library, variables: BTreeMap<&'l Symbol, Kind>, expr: &'l Expr) -> Kind {
        Kinds { variables, ..Kinds::new(library) }.kind(expr)
    }

    /// Returns the first sum or comparison that fails if `function`, which the program defines, is called with arguments of these kinds.
    pub(crate) fn mismatch_in(library: &'l Library, function: &Symbol, arguments: &[Kind]) -> Option<SumMismatch> {
        let defined = library.functions.get(function)?;
        let locals = defined.parameters.required.iter().zip(arguments.iter().copied()).collect();
        let mut kinds = Kinds::new(library);
        kinds.apart(locals, &defined.body);
        kinds.mismatch
    }

    fn new(library: &'l Library) -> Kinds<'l> {
        let (locals, variables) = (Vec::new(), BTreeMap::new());
        Kinds { library, locals, variables, depth: 0, steps: 0, branches: 0, mismatch: None }
    }

    fn kind(&mut self, expr: &'l Expr) -> Kind {
        self.steps += 1;
        if self.steps > STEPS_MAX {
            return Kind::Unknown;
        }
        match &expr.kind {
            ExprKind::Constant(value) => of_value(value),
            ExprKind::Local(name) => {
                self.locals.iter().rev().find(|(local, _)| *local == name).map_or(Kind::Unknown, |(_, kind)| *kind)
            }
            ExprKind::Indexical(name) => self.indexical(name),
            ExprKind::Variable { name, .. } => self.variables.get(name).copied().unwrap_or(Kind::Unknown),
            ExprKind::Call { function, arguments } => {
                if self.depth > 0 && self.branches == 0 && ONE_DIMENSION.contains(&function.folded()) {
                    self.note_mismatch(function, arguments, expr.place);
                }
                self.call(function, arguments)
            }
            ExprKind::If(_, then, Some(otherwise)) => {
                self.branches += 1;
                let kind = self.kind(then).join(self.kind(otherwise));
                self.branches -= 1;
                kind
            }
            ExprKind::Let { sequential, bindings, body } => self.scoped(|kinds| {
                let mut found = Vec::new();
                let assigned = assigned(bindings, body);
                for (name, value) in bindings {
                    // A variable that is set again may have another kind by then.
                    let kind = if assigned.contains(&name) { Kind::Unknown } else { kinds.kind(value) };
                    if *sequential { kinds.locals.push((name, kind)) } else { found.push((name, kind)) }
                }
                kinds.locals.extend(found);
                kinds.body(body)
            }),
            ExprKind::Sequence(body) => self.body(body),
            ExprKind::Template(_) => Kind::Other("a list"),
            _ => Kind::Unknown,
        }
    }

    fn body(&mut self, body: &'l [Expr]) -> Kind {
        body.last().map_or(Kind::Unknown, |last| self.kind(last))
    }

    fn note_mismatch(&mut self, function: &Symbol, arguments: &'l [Expr], place: Place) {
        let mut first = None;
        for argument in arguments.iter().filter(|argument| !is_zero(argument)) {
            let kind @ Kind::Number(_) = self.kind(argument) else { continue };
            let known = *first.get_or_insert(kind);
            if known != kind && self.mismatch.is_none() {
                self.mismatch = Some(SumMismatch { function: function.clone(), kinds: [known, kind], place });
            }
        }
    }

    fn scoped(&mut self, action: impl FnOnce(&mut Self) -> Kind) -> Kind {
        let length = self.locals.len();
        let kind = action(self);
        self.locals.truncate(length);
        kind
    }

    /// Returns the kind of a body that sees only `locals`.
    fn apart(&mut self, locals: Vec<(&'l Symbol, Kind)>, body: &'l [Expr]) -> Kind {
        if self.depth >= DEPTH_MAX {
            return Kind::Unknown;
        }
        self.depth += 1;
        let outer = std::mem::replace(&mut self.locals, locals);
        let kind = self.body(body);
        self.locals = outer;
        self.depth -= 1;
        kind
    }

    fn indexical(&mut self, name: &Symbol) -> Kind {
        match name.folded() {
            "now" | "mission-start" | "beginning-of-time" | "end-of-time" => Kind::Instant,
            "tot" | "met" => Kind::Number(Dimension::TIME),
            "self" => Kind::Other("a name"),
            _ => match self.library.indexicals.get(name) {
                Some(expr) => self.apart(Vec::new(), std::slice::from_ref(expr)),
                None => Kind::Unknown,
            },
        }
    }

    fn call(&mut self, function: &Symbol, arguments: &'l [Expr]) -> Kind {
        if let Some(defined) = self.library.functions.get(function) {
            let kinds: Vec<Kind> = arguments.iter().map(|argument| self.kind(argument)).collect();
            let names = defined.parameters.required.iter();
            // Further parameters have no known kind.
            let locals: Vec<(&Symbol, Kind)> = names.zip(kinds).collect();
            return self.apart(locals, &defined.body);
        }
        match (function.folded(), arguments) {
            ("+" | "-", all) => {
                let kinds: Vec<Kind> = all.iter().map(|part| self.kind(part)).collect();
                sum(function.is("-"), &kinds)
            }
            ("max" | "min" | "mod" | "rem", [first, rest @ ..]) => {
                let first = self.kind(first);
                rest.iter().fold(first, |kind, part| kind.join(self.kind(part)))
            }
            // The value has the kind of the argument, also for texts and lists.
            ("abs" | "1+" | "1-" | "reverse", [one]) => self.kind(one),
            ("*", all) => self.product(all, Dimension::times),
            ("/", [first, rest @ ..]) if !rest.is_empty() => {
                match (self.kind(first), self.product(rest, Dimension::times)) {
                    (Kind::Number(above), Kind::Number(below)) => Kind::Number(above.over(below)),
                    _ => Kind::Unknown,
                }
            }
            ("floor" | "ceiling" | "round" | "truncate", [one]) => match self.kind(one) {
                Kind::Number(Dimension::NONE) => Kind::Number(Dimension::NONE),
                _ => Kind::Unknown,
            },
            ("length" | "in-unit" | "sin" | "cos" | "tan", _) => Kind::Number(Dimension::NONE),
            ("asin" | "acos" | "atan", _) => Kind::Number(Dimension::ANGLE),
            ("duration-of" | "elapsed", [_]) => Kind::Number(Dimension::TIME),
            ("start-of" | "end-of" | "time-of", [_]) => Kind::Instant,
            ("quantity", [_, unit]) => match &unit.kind {
                ExprKind::Constant(value) => {
                    let unit = value.as_symbol().and_then(|unit| unit_named(unit.printed()));
                    unit.map_or(Kind::Unknown, |unit| Kind::Number(unit.dimension))
                }
                _ => Kind::Unknown,
            },
            ("list" | "cons" | "append" | "range" | "mapcar" | "sort", _) => Kind::Other("a list"),
            ("format" | "concatenate" | "string-upcase" | "string-downcase" | "symbol-name", _) => {
                Kind::Other("a text")
            }
            (query, [attribute, ..]) if QUERIES.contains(&query) && query != "samples-over" => self.queried(attribute),
            _ => Kind::Unknown,
        }
    }

    fn product(&mut self, parts: &'l [Expr], times: impl Fn(Dimension, Dimension) -> Dimension) -> Kind {
        let mut product = Dimension::NONE;
        for part in parts {
            let Kind::Number(dimension) = self.kind(part) else { return Kind::Unknown };
            product = times(product, dimension);
        }
        Kind::Number(product)
    }

    /// Returns the values of a declared state variable.
    fn queried(&self, attribute: &Expr) -> Kind {
        let ExprKind::Constant(Value::Symbol(attribute)) = &attribute.kind else { return Kind::Unknown };
        match self.library.state_variables.get(attribute) {
            Some(declared) if declared.unit.is_some() => Kind::Number(declared.dimension),
            _ => Kind::Unknown,
        }
    }
}

/// Returns the names of locals that a `let` sets again.
fn assigned<'l>(bindings: &'l [(Symbol, Expr)], body: &'l [Expr]) -> Vec<&'l Symbol> {
    let mut names = Vec::new();
    walk::exprs(bindings.iter().map(|(_, value)| value).chain(body), &mut |expr| {
        if let ExprKind::Assign { name, of_task: false, .. } = &expr.kind {
            names.push(name);
        }
    });
    names
}

fn of_value(value: &Value) -> Kind {
    match value {
        Value::Time(_) => Kind::Instant,
        Value::Text(_) => Kind::Other("a text"),
        Value::Symbol(_) => Kind::Other("a name"),
        Value::List(items) if !items.is_empty() => Kind::Other("a list"),
        other => other.as_number().map_or(Kind::Unknown, |(_, dimension)| Kind::Number(dimension)),
    }
}

/// Returns the kind of a sum or difference whose parts agree.
fn sum(is_difference: bool, kinds: &[Kind]) -> Kind {
    let instants = kinds.iter().filter(|kind| **kind == Kind::Instant).count();
    match (kinds, instants) {
        ([Kind::Instant, Kind::Instant], _) if is_difference => Kind::Number(Dimension::TIME),
        (_, 0) => kinds.iter().copied().reduce(Kind::join).unwrap_or(Kind::Unknown),
        (_, 1) if kinds.iter().all(|kind| matches!(kind, Kind::Instant | Kind::Number(Dimension::TIME))) => {
            Kind::Instant
        }
        _ => Kind::Unknown,
    }
}

/// Returns true for literal numbers that may mean zero of any dimension.
pub(crate) fn is_zero(expr: &Expr) -> bool {
    match &expr.kind {
        ExprKind::Constant(value) => value.as_number().is_some_and(|(number, _)| number == 0.0),
        _ => false,
    }
}
