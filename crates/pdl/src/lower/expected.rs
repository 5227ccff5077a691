//! Permitted right sides of a constraint: dimensions of literals, units of bare numbers.

use super::Lowering;
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::fix::Fix;
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::RESOURCE_LEVEL;
use apex_model::quantity::{Dimension, Quantity, Unit, unit_named};
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use apex_model::value::Value;

/// Expectation of a constraint.
#[derive(Clone)]
pub(crate) struct Expected {
    /// For messages: `(altitude ..)` or `a duration`.
    pub(crate) subject: String,
    pub(crate) kind: ExpectedKind,
    /// Place of the declaration of the dimension.
    pub(crate) declared: Option<Span>,
    /// The declared type of the values.
    pub(crate) value_type: Option<Symbol>,
    /// The attribute of a state variable that nothing declares.
    pub(crate) undeclared: Option<Symbol>,
}

/// Treatment of literals.
#[derive(Clone, Copy)]
pub(crate) enum ExpectedKind {
    /// Any value: objects, results of predicates.
    Anything,
    /// An instant: neither number nor duration.
    Instant,
    /// A duration; 0 is one.
    Duration,
    /// A state variable that nothing declares; it accepts pure numbers only.
    Undeclared,
    /// A value of this dimension; bare numbers have the unit, if there is one.
    Measured(Dimension, Option<&'static Unit>),
    /// Change per second of values of this dimension.
    Rate(Dimension, Option<&'static Unit>),
    /// A value of this dimension; a bare number times the factor is its value in SI units.
    Scaled(Dimension, f64),
}

impl Expected {
    /// Returns an expectation that accepts everything.
    pub(crate) fn anything() -> Expected {
        Expected::plain("the object", ExpectedKind::Anything)
    }

    /// Returns the expectation of a pure number, such as a count.
    pub(crate) fn number(subject: &str) -> Expected {
        Expected::plain(subject, ExpectedKind::Measured(Dimension::NONE, None))
    }

    /// Returns an expectation of this kind that comes from no declaration.
    pub(crate) fn plain(subject: &str, kind: ExpectedKind) -> Expected {
        Expected { subject: subject.to_string(), kind, declared: None, value_type: None, undeclared: None }
    }

    /// Returns the expectation of the values of the state variable with this attribute.
    pub(crate) fn values_of(lowering: &Lowering, attribute: &Symbol) -> Expected {
        let subject = format!("`({attribute} ..)`");
        let Some((declaration, span)) = lowering.names.state_variables.get(attribute) else {
            // The unit of a level is that of its resource, which the object names and not the attribute.
            if attribute.is(RESOURCE_LEVEL) {
                return Expected::anything();
            }
            return Expected {
                subject,
                kind: ExpectedKind::Undeclared,
                undeclared: Some(attribute.clone()),
                declared: None,
                value_type: None,
            };
        };
        let unit = declaration.unit.as_ref().and_then(|unit| unit_named(unit.printed()));
        let is_number = declaration.unit.is_some() || declaration.value_type.as_ref().is_none_or(is_number_type);
        let kind = if is_number { ExpectedKind::Measured(declaration.dimension, unit) } else { ExpectedKind::Anything };
        Expected { subject, kind, declared: Some(*span), value_type: declaration.value_type.clone(), undeclared: None }
    }

    /// Returns the expectation of the change per second of such values.
    pub(crate) fn rate(&self) -> Expected {
        let (dimension, unit) = match self.kind {
            ExpectedKind::Measured(dimension, unit) => (dimension, unit),
            _ => (Dimension::NONE, None),
        };
        Expected {
            subject: format!("the rate of {}", self.subject),
            kind: ExpectedKind::Rate(dimension, unit),
            ..self.clone()
        }
    }

    /// Returns the expectation of the square of such values; bare numbers are squares of the unit.
    pub(crate) fn square(&self) -> Expected {
        let kind = match self.kind {
            ExpectedKind::Measured(dimension, unit) if dimension != Dimension::NONE => {
                ExpectedKind::Scaled(dimension.times(dimension), unit.map_or(1.0, |unit| unit.factor * unit.factor))
            }
            other => other,
        };
        Expected { kind, ..self.named("variance") }
    }

    /// Returns the expectation of a statistic of such values, which has their dimension.
    pub(crate) fn named(&self, name: &str) -> Expected {
        if let ExpectedKind::Undeclared = self.kind {
            return self.clone();
        }
        Expected { subject: format!("the {name} of {}", self.subject), ..self.clone() }
    }

    /// Returns the expectation of a computed real number of such values.
    pub(crate) fn real(&self) -> Expected {
        match self.value_type.as_ref().map(Symbol::folded) {
            Some("symbol" | "string" | "list") => self.clone(),
            _ => Expected { value_type: Some(Symbol::new("real")), ..self.clone() },
        }
    }

    fn dimension(&self) -> Option<Dimension> {
        match self.kind {
            ExpectedKind::Anything | ExpectedKind::Instant => None,
            ExpectedKind::Duration => Some(Dimension::TIME),
            ExpectedKind::Undeclared => Some(Dimension::NONE),
            ExpectedKind::Measured(dimension, _) | ExpectedKind::Scaled(dimension, _) => Some(dimension),
            ExpectedKind::Rate(dimension, _) => Some(dimension.over(Dimension::TIME)),
        }
    }

    /// Returns `number` without unit as a value of the expected kind.
    fn bare(&self, number: f64) -> Option<Value> {
        match self.kind {
            ExpectedKind::Duration => (number == 0.0).then_some(Value::Duration(Duration::ZERO)),
            ExpectedKind::Measured(dimension, unit) if dimension != Dimension::NONE => {
                let unit = unit.or_else(|| si_unit(dimension))?;
                Some(of_unit(number, unit))
            }
            ExpectedKind::Scaled(dimension, factor) => Some(Value::measured(number * factor, dimension)),
            ExpectedKind::Rate(dimension, unit) => {
                let factor = unit.map_or(1.0, |unit| unit.factor);
                Some(Value::measured(number * factor, dimension.over(Dimension::TIME)))
            }
            _ => None,
        }
    }
}

fn is_number_type(name: &Symbol) -> bool {
    matches!(name.folded(), "real" | "integer" | "number")
}

fn si_unit(dimension: Dimension) -> Option<&'static Unit> {
    Quantity::si(0.0, dimension).unit()
}

/// Returns `number` of `unit` as a value: a duration for units of time.
pub(crate) fn of_unit(number: f64, unit: &'static Unit) -> Value {
    if unit.dimension == Dimension::TIME {
        Value::Duration(Duration::from_seconds(number * unit.factor))
    } else {
        Value::Quantity(Quantity::of(number, unit))
    }
}

/// Returns the dimension of an expression as far as its text determines it; bare numbers have none.
pub(crate) fn dimension_of(expr: &Expr) -> Option<Dimension> {
    match &expr.kind {
        ExprKind::Constant(value) => value.as_number().map(|(_, dimension)| dimension),
        ExprKind::Call { function, arguments } => match (function.folded(), arguments.as_slice()) {
            ("+" | "-" | "max" | "min" | "mod" | "rem", all) => dimension_of_sum(all),
            ("abs", [one]) => dimension_of(one),
            ("*", all) => {
                all.iter().try_fold(Dimension::NONE, |product, part| Some(product.times(dimension_of(part)?)))
            }
            ("/", [first, rest @ ..]) if !rest.is_empty() => {
                rest.iter().try_fold(dimension_of(first)?, |quotient, part| Some(quotient.over(dimension_of(part)?)))
            }
            ("duration-of" | "elapsed", [_]) => Some(Dimension::TIME),
            ("asin" | "acos" | "atan", _) => Some(Dimension::ANGLE),
            ("length" | "in-unit" | "sin" | "cos" | "tan", _) => Some(Dimension::NONE),
            _ => None,
        },
        ExprKind::Indexical(name) if name.is("tot") => Some(Dimension::TIME),
        _ => None,
    }
}

/// Returns the dimension of a sum. If another part may be an instant, a duration does not make the sum a duration.
fn dimension_of_sum(parts: &[Expr]) -> Option<Dimension> {
    let known: Vec<Option<Dimension>> = parts.iter().map(dimension_of).collect();
    let found = known.iter().flatten().copied().find(|dimension| *dimension != Dimension::NONE);
    match found {
        Some(Dimension::TIME) if known.contains(&None) => None,
        Some(dimension) => Some(dimension),
        None if known.contains(&None) => None,
        None => Some(Dimension::NONE),
    }
}

/// Returns zero of `dimension` if the expression is the literal 0.
pub(crate) fn zero_of(expr: &Expr, dimension: Dimension) -> Option<Value> {
    match &expr.kind {
        ExprKind::Constant(Value::Integer(0)) => Some(Value::measured(0.0, dimension)),
        ExprKind::Constant(Value::Real(real)) if *real == 0.0 => Some(Value::measured(0.0, dimension)),
        _ => None,
    }
}

impl Lowering {
    /// Checks the literals of `expr` against the expectation, and gives bare numbers their unit.
    pub(crate) fn conform(&mut self, mut expr: Expr, span: Span, expected: &Expected) -> Option<Expr> {
        self.conform_in_place(&mut expr, span, expected)?;
        Some(expr)
    }

    fn conform_in_place(&mut self, expr: &mut Expr, span: Span, expected: &Expected) -> Option<()> {
        if let ExprKind::Call { function, arguments } = &mut expr.kind
            && matches!(function.folded(), "+" | "-" | "max" | "min" | "abs")
            && !matches!(expected.kind, ExpectedKind::Instant)
        {
            for argument in arguments {
                self.conform_in_place(argument, span, expected)?;
            }
            return Some(());
        }
        if let ExprKind::Constant(value) = &mut expr.kind {
            if let Some((number, Dimension::NONE)) = value.as_number() {
                if let Some(converted) = expected.bare(number) {
                    *value = converted;
                    return Some(());
                }
            } else if value.as_number().is_none() {
                return self.check_type(value, span, expected);
            }
        }
        self.check_dimension(expr, span, expected)
    }

    fn check_dimension(&mut self, expr: &Expr, span: Span, expected: &Expected) -> Option<()> {
        let Some(found) = dimension_of(expr) else { return Some(()) };
        if let ExpectedKind::Instant = expected.kind {
            let diagnostic =
                Diagnostic::error(codes::DIMENSION, span, format!("{found} is used where an instant is needed"))
                    .reason("a duration or a number is not an instant")
                    .fixes(self.since_start(span, found))
                    .help("add it to an instant: `(+ (start-of +this-task+) P10S)`");
            return self.refuse(diagnostic);
        }
        let Some(wanted) = expected.dimension().filter(|wanted| *wanted != found) else { return Some(()) };
        if let ExpectedKind::Undeclared = expected.kind {
            let message = format!("{found} is compared with {}, whose unit is not declared", expected.subject);
            let severity = self.undefined();
            let mut diagnostic = Diagnostic::new(severity, codes::UNDECLARED_UNIT, span, message)
                .reason("values of undeclared state variables are pure numbers");
            diagnostic.help.extend(expected.undeclared.as_ref().and_then(|attribute| self.declared_like(attribute)));
            let diagnostic = diagnostic.help(format!(
                "declare it: `(state-variable {} :unit ..)`",
                expected.subject.trim_matches('`').replace("..", "?object")
            ));
            self.report(diagnostic);
            return self.fragment.then_some(());
        }
        if let ExpectedKind::Duration = expected.kind {
            return self.duration_expected(span, found);
        }
        let message = format!("{} is {wanted}, but this is {found}", expected.subject);
        let mut diagnostic = Diagnostic::error(codes::DIMENSION, span, message);
        diagnostic = match expected.declared {
            Some(declared) => diagnostic.label(
                declared,
                match expected.kind {
                    ExpectedKind::Rate(..) | ExpectedKind::Scaled(..) => "its values are declared here".to_string(),
                    _ => format!("declared as {wanted} here"),
                },
            ),
            None => diagnostic.reason("only values of one dimension can be compared"),
        };
        if let ExpectedKind::Measured(_, Some(unit)) = expected.kind {
            diagnostic = self.in_unit(diagnostic, span, unit.name);
        }
        self.refuse(diagnostic)
    }

    /// Returns the declared state variable that was probably meant by an undeclared one.
    fn declared_like(&self, attribute: &Symbol) -> Option<String> {
        let declared = self.names.state_variables.keys().map(Symbol::printed);
        crate::suggest::nearest(attribute.printed(), declared)
            .map(|near| format!("`{near}` is declared: is that one meant?"))
    }

    /// Returns a fix for a duration where an instant is needed: the author probably counts from the start of the mission or of the task.
    fn since_start(&self, span: Span, found: Dimension) -> Option<Fix> {
        let written = self.text_at(span).filter(|_| found == Dimension::TIME)?;
        let title = format!("count from the start of the mission: `(+ +mission-start+ {written})`");
        Some(Fix::look(title).replace(span, format!("(+ +mission-start+ {written})")))
    }

    /// Reports a value of dimension `found` where a duration is needed.
    pub(crate) fn duration_expected<T>(&mut self, span: Span, found: Dimension) -> Option<T> {
        let diagnostic = Diagnostic::error(
            codes::DURATION_EXPECTED,
            span,
            format!("a duration is needed here, but this is {found}"),
        )
        .fixes(self.as_duration(span))
        .help("write a duration with its unit: `5s`, `P1M30S`, `(1 hr 30 min)`");
        self.refuse(diagnostic)
    }

    fn check_type(&mut self, value: &Value, span: Span, expected: &Expected) -> Option<()> {
        let wrong = matches!(
            (expected.value_type.as_ref().map(Symbol::folded), value),
            (Some("real" | "integer" | "number"), Value::Symbol(_) | Value::Text(_))
                | (Some("symbol"), Value::Text(_))
                | (Some("string"), Value::Symbol(_))
        );
        let is_number = matches!(expected.kind, ExpectedKind::Duration | ExpectedKind::Rate(..))
            && matches!(value, Value::Symbol(_) | Value::Text(_));
        if !wrong && !is_number {
            return Some(());
        }
        let type_name = expected.value_type.as_ref().map_or("number", Symbol::printed);
        let message = match expected.kind {
            ExpectedKind::Duration => format!("a duration is needed here, but this is `{value}`"),
            _ => format!("{} is of type {type_name}, but this is `{value}`", expected.subject),
        };
        let mut diagnostic = Diagnostic::error(codes::VALUE_TYPE, span, message);
        if let (ExpectedKind::Duration, Value::Symbol(name)) = (&expected.kind, value)
            && let Some(sum) = sum_of_units(name.printed())
        {
            let fix = Fix::safe(format!("write the sum of units in parentheses: `{sum}`")).replace(span, sum);
            diagnostic = diagnostic.reason("one number has one unit").fix(fix);
        }
        if let Some(declared) = expected.declared {
            diagnostic = diagnostic.label(declared, format!("declared as {type_name} here"));
        }
        self.refuse(diagnostic)
    }

    /// Lowers a duration that must not be negative.
    pub(crate) fn span_of_time(&mut self, datum: &crate::read::Datum) -> Option<Expr> {
        let expr = self.duration(datum)?;
        if let ExprKind::Constant(Value::Duration(duration)) = &expr.kind
            && *duration < Duration::ZERO
        {
            let message = format!("{duration} is a negative span of time");
            let diagnostic = Diagnostic::error(codes::DURATION_EXPECTED, datum.span, message)
                .reason("a wait cannot end in the past")
                .help("write a duration of at least 0");
            return self.refuse(diagnostic);
        }
        Some(expr)
    }

    /// Lowers an expression that must yield a duration.
    pub(crate) fn duration(&mut self, datum: &crate::read::Datum) -> Option<Expr> {
        let expr = self.expression(datum)?;
        self.conform(expr, datum.span, &Expected::plain("this duration", ExpectedKind::Duration))
    }
}

/// Returns the list of numbers and units that a word such as `4h30min` means: `(4 h 30 min)`. `None` for another word.
fn sum_of_units(word: &str) -> Option<String> {
    let mut parts = Vec::new();
    let mut rest = word;
    while !rest.is_empty() {
        let digits = rest.find(|c: char| !c.is_ascii_digit() && c != '.').filter(|end| *end > 0)?;
        let (number, tail) = rest.split_at(digits);
        let letters = tail.find(|c: char| !c.is_alphabetic()).unwrap_or(tail.len());
        let (unit, tail) = tail.split_at(letters);
        number.parse::<f64>().ok()?;
        unit_named(unit).filter(|unit| unit.dimension == Dimension::TIME)?;
        parts.push(format!("{number} {unit}"));
        rest = tail;
    }
    (parts.len() >= 2).then(|| format!("({})", parts.join(" ")))
}
