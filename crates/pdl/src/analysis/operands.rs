//! Operands of built-in functions: what a function takes, compared with the kinds that are known before the program runs; lists of
//! `forall` and instants of conditions. A mismatch fails at run time whenever the form is evaluated, so it is an error here.

use super::kinds::{Kind, Kinds};
use super::walk;
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::locate::Locator;
use apex_model::condition::{Condition, ConditionKind, Constraint, Timing};
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::Library;
use apex_model::procedure::{Activity, BuiltInActivity, PriorityClause, Step};
use apex_model::quantity::{Dimension, unit_named};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::value::Value;

/// A mismatch between an operand and the function or clause that takes it.
pub(super) struct OperandFinding {
    code: &'static str,
    place: Place,
    message: String,
    /// The place of the instant with which the operand cannot be combined.
    instant: Option<Place>,
    help: Option<&'static str>,
}

impl OperandFinding {
    /// Returns the diagnostic of this mismatch.
    pub(super) fn diagnostic(self, locator: &mut Locator<'_>) -> Diagnostic {
        let mut diagnostic = Diagnostic::error(self.code, locator.span(self.place), self.message);
        if let Some(instant) = self.instant {
            diagnostic = diagnostic.label(locator.span(instant), "this is an instant");
        }
        self.help.into_iter().fold(diagnostic, Diagnostic::help)
    }
}

/// Returns all mismatches in the library.
pub(super) fn findings(library: &Library) -> Vec<OperandFinding> {
    let mut found = Vec::new();
    walk::library(library, &mut |expr| call(library, expr, &mut found));
    for procedure in &library.procedures {
        walk::conditions_of(procedure, &mut |condition| {
            instants_of(condition, &mut |instant| needs_instant(library, instant, &mut found));
        });
        for step in &procedure.steps {
            if let Some((_, list)) = step.forall.as_deref() {
                needs(library, list, Operand::List, "`forall`", &mut found);
            }
            resource_names(library, step, &mut found);
            urgencies(step, &mut found);
        }
    }
    let profiles = library
        .procedures
        .iter()
        .flat_map(|each| std::iter::once(&each.profile).chain(each.steps.iter().map(|step| &step.profile)));
    let profiles = profiles.chain(library.primitives.iter().map(|each| &each.profile));
    for amount in profiles.flatten().filter_map(|need| need.amount.as_ref()) {
        needs(library, amount, Operand::Number, "a profile", &mut found);
    }
    found
}

/// Reports names of resources that are neither words, texts nor lists such as `(downlink 1)`: `(hold-resource storage 5)` does not hold
/// five units.
fn resource_names(library: &Library, step: &Step, found: &mut Vec<OperandFinding>) {
    let Activity::BuiltIn(BuiltInActivity::HoldResource | BuiltInActivity::ReleaseResource, arguments) = &step.activity
    else {
        return;
    };
    for argument in arguments {
        needs(library, argument, Operand::ResourceName, "the list of resources", found);
    }
}

/// Reports constant urgencies and importances that are not numbers from 0 to 10.
fn urgencies(step: &Step, found: &mut Vec<OperandFinding>) {
    let pairs = step.priority.iter().filter_map(|clause| match clause {
        PriorityClause::UrgencyImportance(urgency, importance) => Some([urgency, importance]),
        PriorityClause::Number(_) => None,
    });
    for expr in pairs.flatten() {
        if let ExprKind::Constant(value) = &expr.kind
            && let Some((number, _)) = value.as_number()
            && !(0.0..=10.0).contains(&number)
        {
            let message = format!("urgency and importance are numbers from 0 to 10, but this is {value}");
            let (code, place) = (codes::OPERAND, expr.place);
            found.push(OperandFinding { code, place, message, instant: None, help: None });
        }
    }
}

/// The kind of value that a function takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Operand {
    /// A number of any dimension.
    Number,
    /// A number without a dimension.
    Plain,
    Angle,
    List,
    ListOrText,
    /// A string or a symbol.
    Text,
    /// A string, a symbol or a list.
    ResourceName,
    /// A task, an interval, a result or an instant.
    Timed,
    Task,
}

impl Operand {
    fn words(self) -> &'static str {
        match self {
            Operand::Number => "a number",
            Operand::Plain => "a pure number",
            Operand::Angle => "an angle or a pure number",
            Operand::List => "a list",
            Operand::ListOrText => "a list or a text",
            Operand::Text => "a text or a name",
            Operand::ResourceName => "names",
            Operand::Timed => "a task, an interval or an instant",
            Operand::Task => "a task",
        }
    }

    /// Returns true if the operand accepts a value of this kind, as far as the kind is known.
    fn takes(self, kind: Kind) -> bool {
        match (self, kind) {
            (_, Kind::Unknown)
            | (Operand::Number, Kind::Number(_))
            | (Operand::Plain | Operand::Angle, Kind::Number(Dimension::NONE))
            | (Operand::Angle, Kind::Number(Dimension::ANGLE))
            | (Operand::List | Operand::ListOrText, Kind::Other("a list"))
            | (Operand::ListOrText, Kind::Other("a text"))
            | (Operand::Text, Kind::Other("a text" | "a name"))
            | (Operand::ResourceName, Kind::Other("a text" | "a name" | "a list"))
            | (Operand::Timed, Kind::Instant) => true,
            (_, Kind::Number(_) | Kind::Instant | Kind::Other(_)) => false,
        }
    }
}

/// Positions of operands: all of them, one, or the last.
#[derive(Clone, Copy, Debug)]
enum ArgumentPosition {
    All,
    At(usize),
    Last,
}

/// Operands of built-in functions. Sums and comparisons also take instants and are checked by [`instants`].
const OPERANDS: &[(&[&str], ArgumentPosition, Operand)] = &[
    (
        &["*", "/", "abs", "1+", "1-", "mod", "rem", "zerop", "plusp", "minusp", "sqrt"],
        ArgumentPosition::All,
        Operand::Number,
    ),
    (&["exp", "log", "asin", "acos", "evenp", "oddp"], ArgumentPosition::All, Operand::Plain),
    (&["sin", "cos", "tan"], ArgumentPosition::All, Operand::Angle),
    (&["quantity", "nth", "nthcdr"], ArgumentPosition::At(0), Operand::Plain),
    (&["expt", "elt"], ArgumentPosition::At(1), Operand::Plain),
    (&["in-unit"], ArgumentPosition::At(0), Operand::Number),
    (
        &["first", "second", "third", "fourth", "fifth", "rest", "last", "remove-duplicates"],
        ArgumentPosition::All,
        Operand::List,
    ),
    (&["elt", "sort", "getf"], ArgumentPosition::At(0), Operand::List),
    (
        &["nth", "nthcdr", "member", "assoc", "find", "find-if", "position", "remove", "remove-if", "remove-if-not"],
        ArgumentPosition::At(1),
        Operand::List,
    ),
    (&["mapcar", "every", "some", "reduce", "cons"], ArgumentPosition::At(1), Operand::List),
    (&["apply"], ArgumentPosition::Last, Operand::List),
    (&["append", "union", "intersection", "set-difference"], ArgumentPosition::All, Operand::List),
    (&["length", "reverse"], ArgumentPosition::All, Operand::ListOrText),
    (
        &["string-upcase", "string-downcase", "string=", "string-equal", "search-string", "symbol-name", "intern"],
        ArgumentPosition::All,
        Operand::Text,
    ),
    (&["substring"], ArgumentPosition::At(0), Operand::Text),
    (&["start-of", "end-of", "time-of", "duration-of", "elapsed"], ArgumentPosition::All, Operand::Timed),
    (&["task-state"], ArgumentPosition::All, Operand::Task),
];
/// Functions that compare or join numbers or instants.
const COMPARISONS: &[&str] = &["/=", "<", "<=", "=", ">", ">=", "max", "min"];
/// Comparisons that need an order: names, texts and lists have none.
const ORDERS: &[&str] = &["<", "<=", ">", ">=", "max", "min", "+", "-"];

fn call(library: &Library, expr: &Expr, found: &mut Vec<OperandFinding>) {
    let ExprKind::Call { function, arguments } = &expr.kind else { return };
    // A function of the program of the same name takes what its body takes.
    if library.functions.contains_key(function) {
        return;
    }
    exchanged(library, function, arguments, found);
    let name = function.folded();
    for (_, position, operand) in OPERANDS.iter().filter(|(names, ..)| names.contains(&name)) {
        let taken: &[Expr] = match position {
            ArgumentPosition::All => arguments,
            ArgumentPosition::At(at) => arguments.get(*at).map_or(&[], std::slice::from_ref),
            ArgumentPosition::Last => arguments.last().map_or(&[], std::slice::from_ref),
        };
        for argument in taken {
            if needs(library, argument, *operand, &format!("`{function}`"), found) {
                return;
            }
        }
    }
    if (name == "floor" || name == "ceiling" || name == "round" || name == "truncate")
        && let [only] = arguments.as_slice()
    {
        needs(library, only, Operand::Plain, &format!("`{function}` without a divisor"), found);
    }
    if name == "in-unit" {
        unit(library, arguments, found);
    }
    instants(library, function, arguments, found);
}

/// Reports queries whose second argument is a declared state variable and whose first argument is not: `(current-value ?uav altitude)`.
fn exchanged(library: &Library, function: &Symbol, arguments: &[Expr], found: &mut Vec<OperandFinding>) {
    let declared = |expr: &Expr| match &expr.kind {
        ExprKind::Constant(Value::Symbol(name)) => library.state_variables.contains_key(name),
        _ => false,
    };
    let [first, second, ..] = arguments else { return };
    if walk::QUERIES.contains(&function.folded()) && !declared(first) && declared(second) {
        let message = format!("`{function}` takes the attribute first and then its object");
        let help = Some("exchange the two arguments");
        found.push(OperandFinding { code: codes::OPERAND, place: first.place, message, instant: None, help });
    }
}

/// Reports `expr` if it is surely not what `taker` takes; true if it did.
fn needs(library: &Library, expr: &Expr, operand: Operand, taker: &str, found: &mut Vec<OperandFinding>) -> bool {
    let kind = Kinds::of(library, expr);
    if operand.takes(kind) {
        return false;
    }
    let message = format!("{taker} takes {}, but this is {}", operand.words(), kind.words());
    found.push(OperandFinding { code: codes::OPERAND, place: expr.place, message, instant: None, help: None });
    true
}

/// Reports a unit whose dimension differs from that of the value to be expressed in it.
fn unit(library: &Library, arguments: &[Expr], found: &mut Vec<OperandFinding>) {
    let [value, Expr { kind: ExprKind::Constant(name), place }] = arguments else { return };
    let Some(unit) = name.as_symbol().and_then(|name| unit_named(name.printed())) else { return };
    if let Kind::Number(dimension) = Kinds::of(library, value)
        && dimension != unit.dimension
    {
        let words = Kind::Number(dimension).words();
        let message = format!("{words} cannot be expressed in {}, which measures {}", unit.name, unit.dimension);
        found.push(OperandFinding { code: codes::DIMENSION, place: *place, message, instant: None, help: None });
    }
}

/// Reports sums and comparisons of instants with other values, and ordering of values that have no order.
fn instants(library: &Library, function: &Symbol, arguments: &[Expr], found: &mut Vec<OperandFinding>) {
    let name = function.folded();
    let is_sum = matches!(name, "+" | "-");
    if !is_sum && !COMPARISONS.contains(&name) || arguments.len() < 2 {
        return;
    }
    // Zero can be added to an instant: sums may begin with it.
    let kind = |argument: &Expr| if is_zero(argument) { Kind::Unknown } else { Kinds::of(library, argument) };
    let kinds: Vec<Kind> = arguments.iter().map(kind).collect();
    let is_other = |(kind, argument): &(Kind, &Expr)| matches!(kind, Kind::Other(_)) && !resembles_quantity(argument);
    if ORDERS.contains(&name)
        && let Some((Kind::Other(what), argument)) = kinds.iter().copied().zip(arguments).find(is_other)
    {
        let message = format!("`{function}` takes numbers or instants, but this is {what}");
        found.push(OperandFinding { code: codes::OPERAND, place: argument.place, message, instant: None, help: None });
        return;
    }
    let Some(first) = kinds.iter().position(|kind| *kind == Kind::Instant) else { return };
    let wrong = kinds.iter().copied().enumerate().find(|(at, kind)| match (name, kind) {
        ("+", Kind::Instant) => *at != first,
        ("+", Kind::Number(dimension)) => *dimension != Dimension::TIME,
        // An instant can be subtracted only from another instant.
        ("-", Kind::Instant) => *at == 1 && matches!(kinds.first(), Some(Kind::Number(_))),
        ("-", Kind::Number(dimension)) => *at > 0 && *dimension != Dimension::TIME,
        (_, Kind::Number(_)) => true,
        _ => false,
    });
    let Some((at, kind)) = wrong else { return };
    let (Some(argument), Some(instant)) = (arguments.get(at), arguments.get(first)) else { return };
    let message = match (name, kind) {
        ("+", Kind::Instant) => "cannot add two instants".to_string(),
        ("-", Kind::Instant) => "cannot subtract an instant from a number".to_string(),
        _ => format!("cannot apply `{function}` to an instant and {}", kind.words()),
    };
    let help = Some("the time since the start is `+met+`, and 5 s after the start is `(+ +mission-start+ 5s)`");
    let (place, instant) = (argument.place, Some(instant.place));
    found.push(OperandFinding { code: codes::DIMENSION, place, message, instant, help });
}

/// Visits the expressions of a condition that must yield instants.
fn instants_of<'c>(condition: &'c Condition, visit: &mut dyn FnMut(&'c Expr)) {
    let mut timing = |timing: &'c Timing| {
        timing.start.iter().chain(&timing.end).flat_map(sides).for_each(&mut *visit);
    };
    match &condition.kind {
        ConditionKind::Timestamp(first, last) => std::iter::once(first).chain(last).for_each(visit),
        ConditionKind::Measurement(measurement) => measurement.timestamp.iter().flat_map(sides).for_each(visit),
        ConditionKind::Episode(episode) => timing(&episode.timing),
        ConditionKind::Event { timing: limits, .. } => timing(limits),
        _ => {}
    }
}

fn is_zero(expr: &Expr) -> bool {
    matches!(&expr.kind, ExprKind::Constant(value) if value.as_number().is_some_and(|(number, _)| number == 0.0))
}

/// Returns true for a name that begins like a number, `35knt`: another warning reports it and says what was meant.
fn resembles_quantity(expr: &Expr) -> bool {
    let ExprKind::Constant(value) = &expr.kind else { return false };
    value.as_symbol().is_some_and(|name| name.printed().starts_with(|first: char| first.is_ascii_digit()))
}

fn sides(constraint: &Constraint) -> Vec<&Expr> {
    match constraint {
        Constraint::Compare { right, .. } => vec![right],
        Constraint::Range(low, high) => low.iter().chain(high).collect(),
        Constraint::Matches(_) | Constraint::Predicate(..) => Vec::new(),
    }
}

fn needs_instant(library: &Library, expr: &Expr, found: &mut Vec<OperandFinding>) {
    let kind = Kinds::of(library, expr);
    if matches!(kind, Kind::Unknown | Kind::Instant) {
        return;
    }
    let message = format!("an instant is needed here, but this is {}", kind.words());
    let help = Some(
        "5 s after the start of the mission is `(+ +mission-start+ 5s)`, 5 s after that of the task `(+ (start-of +this-task+) 5s)`",
    );
    found.push(OperandFinding { code: codes::DIMENSION, place: expr.place, message, instant: None, help });
}
