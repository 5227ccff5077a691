//! Arithmetic and comparison on numbers, quantities, durations and instants.
//!
//! Integers stay exact or fail; dimensions are checked: addition needs equal ones, products and quotients combine them.

pub(crate) use super::comparison::{compare, equal};
use super::result::FunctionResult;
use super::{comparison, rounding};
use apex_model::quantity::{Dimension, Quantity, unit_named};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

/// Calls the arithmetic function `name`; `None` if there is no such function.
pub(super) fn call(name: &str, arguments: &[Value]) -> Option<FunctionResult> {
    Some(match (name, arguments) {
        ("+", values) => fold(values, Value::Integer(0), add),
        ("*", values) => fold(values, Value::Integer(1), multiply),
        ("-", [value]) => negate(value),
        ("-", [first, rest @ ..]) => rest.iter().try_fold(first.clone(), |sum, value| subtract(&sum, value)),
        ("/", [value]) => divide(&Value::Integer(1), value),
        ("/", [first, rest @ ..]) => rest.iter().try_fold(first.clone(), |quotient, value| divide(&quotient, value)),
        ("1+", [value]) => add(value, &Value::Integer(1)),
        ("1-", [value]) => subtract(value, &Value::Integer(1)),
        ("abs", [value]) => absolute(value),
        ("mod" | "rem", [value, divisor]) => rounding::remainder(value, divisor, name == "mod"),
        ("round" | "floor" | "ceiling" | "truncate", [value]) => rounding::to_integer(name, value),
        ("round" | "floor" | "ceiling" | "truncate", [value, divisor]) => {
            rounding::divide_to_integer(name, value, divisor)
        }
        ("sqrt", [value]) => square_root(value),
        ("expt", [base, exponent]) => power(base, exponent),
        ("exp", [value]) => pure_number(value).map(|number| Value::Real(libm::exp(number))),
        ("log", [value]) => logarithm(value, None),
        ("log", [value, base]) => logarithm(value, Some(base)),
        ("sin", [value]) => angle(value).map(|angle| Value::Real(libm::sin(angle))),
        ("cos", [value]) => angle(value).map(|angle| Value::Real(libm::cos(angle))),
        ("tan", [value]) => angle(value).map(|angle| Value::Real(libm::tan(angle))),
        ("asin", [value]) => arc(value, libm::asin),
        ("acos", [value]) => arc(value, libm::acos),
        ("atan", [value]) => arc(value, libm::atan),
        ("atan", [y, x]) => arc_of_two(y, x),
        ("quantity", [number, unit]) => quantity(number, unit),
        ("in-unit", [value, unit]) => in_unit(value, unit),
        _ => return comparison::call(name, arguments),
    })
}

/// Returns a value with its dimension as in messages: `5ft (length)`.
pub(crate) fn described(value: &Value) -> String {
    match value {
        Value::Time(time) => format!("{time} (an instant)"),
        other => match other.as_number() {
            Some((_, dimension)) => format!("{other} ({dimension})"),
            None => format!("{other} (not a number)"),
        },
    }
}

/// Returns `left + right`.
///
/// # Errors
/// When dimensions differ or an integer overflows.
pub(crate) fn add(left: &Value, right: &Value) -> FunctionResult {
    match (left, right) {
        (Value::Integer(a), Value::Integer(b)) => a.checked_add(*b).map(Value::Integer).ok_or_else(overflow("+", a, b)),
        (Value::Duration(a), Value::Duration(b)) => Ok(Value::Duration(*a + *b)),
        (Value::Time(a), Value::Duration(b)) | (Value::Duration(b), Value::Time(a)) => Ok(Value::Time(*a + *b)),
        (Value::Time(_), zero) if is_zero(zero) => Ok(left.clone()),
        (zero, Value::Time(_)) if is_zero(zero) => Ok(right.clone()),
        _ => same_dimension("add", left, right, |a, b| a + b),
    }
}

/// Returns `left - right`.
///
/// # Errors
/// When dimensions differ or an integer overflows.
pub(crate) fn subtract(left: &Value, right: &Value) -> FunctionResult {
    match (left, right) {
        (Value::Integer(a), Value::Integer(b)) => a.checked_sub(*b).map(Value::Integer).ok_or_else(overflow("-", a, b)),
        (Value::Duration(a), Value::Duration(b)) => Ok(Value::Duration(*a - *b)),
        (Value::Time(a), Value::Time(b)) => Ok(Value::Duration(*a - *b)),
        (Value::Time(a), Value::Duration(b)) => Ok(Value::Time(*a - *b)),
        (Value::Time(_), zero) if is_zero(zero) => Ok(left.clone()),
        _ => same_dimension("subtract", left, right, |a, b| a - b),
    }
}

fn multiply(left: &Value, right: &Value) -> FunctionResult {
    match (left, right) {
        (Value::Integer(a), Value::Integer(b)) => a.checked_mul(*b).map(Value::Integer).ok_or_else(overflow("*", a, b)),
        (Value::Duration(duration), Value::Integer(factor)) | (Value::Integer(factor), Value::Duration(duration)) => {
            Ok(Value::Duration(Duration(duration.0.saturating_mul(*factor))))
        }
        _ => {
            let ((a, dimension_a), (b, dimension_b)) = (number(left)?, number(right)?);
            Ok(in_unit_of(a * b, dimension_a.times(dimension_b), left, right))
        }
    }
}

pub(super) fn divide(left: &Value, right: &Value) -> FunctionResult {
    let ((a, dimension_a), (b, dimension_b)) = (number(left)?, number(right)?);
    if b == 0.0 {
        return Err(format!("division of {left} by zero"));
    }
    match (left, right) {
        (Value::Integer(a), Value::Integer(b)) if a.wrapping_rem(*b) == 0 => {
            a.checked_div(*b).map(Value::Integer).ok_or_else(overflow("/", a, b))
        }
        (Value::Duration(duration), Value::Integer(divisor)) if duration.0.wrapping_rem(*divisor) == 0 => {
            Ok(Value::Duration(Duration(duration.0.checked_div(*divisor).unwrap_or(i64::MAX))))
        }
        (Value::Duration(a), Value::Duration(b)) => Ok(Value::Real(a.0 as f64 / b.0 as f64)),
        _ => Ok(in_unit_of(a / b, dimension_a.over(dimension_b), left, right)),
    }
}

/// Returns a result of `dimension`, printed in the unit of the argument that has that dimension too.
pub(super) fn in_unit_of(si: f64, dimension: Dimension, left: &Value, right: &Value) -> Value {
    for argument in [left, right] {
        if let Value::Quantity(quantity) = argument
            && quantity.dimension == dimension
        {
            return Value::Quantity(Quantity { si, ..*quantity });
        }
    }
    Value::measured(si, dimension)
}

fn same_dimension(verb: &str, left: &Value, right: &Value, operation: fn(f64, f64) -> f64) -> FunctionResult {
    match (left.as_number(), right.as_number()) {
        (Some((a, dimension)), Some((b, other))) if dimension == other => {
            Ok(in_unit_of(operation(a, b), dimension, left, right))
        }
        _ => Err(format!("cannot {verb} {} and {}", described(left), described(right))),
    }
}

fn negate(value: &Value) -> FunctionResult {
    match value {
        Value::Integer(integer) => {
            integer.checked_neg().map(Value::Integer).ok_or_else(|| format!("-({integer}) is too large for an integer"))
        }
        Value::Real(real) => Ok(Value::Real(-real)),
        Value::Quantity(quantity) => Ok(Value::Quantity(Quantity { si: -quantity.si, ..*quantity })),
        Value::Duration(duration) => Ok(Value::Duration(-*duration)),
        other => Err(format!("expected a number, found {}", described(other))),
    }
}

fn absolute(value: &Value) -> FunctionResult {
    let (number, _) = number(value)?;
    if number < 0.0 { negate(value) } else { Ok(value.clone()) }
}

fn fold(values: &[Value], neutral: Value, operation: fn(&Value, &Value) -> FunctionResult) -> FunctionResult {
    match values {
        [] => Ok(neutral),
        [Value::Time(time)] => Ok(Value::Time(*time)),
        [value] => number(value).map(|_| value.clone()),
        [first, rest @ ..] => rest.iter().try_fold(first.clone(), |result, value| operation(&result, value)),
    }
}

fn square_root(value: &Value) -> FunctionResult {
    let (number, dimension) = number(value)?;
    if number < 0.0 {
        return Err(format!("square root of {value}, which is negative"));
    }
    let d = dimension;
    let exponents = [d.length, d.mass, d.time, d.current, d.temperature, d.angle];
    if exponents.iter().any(|exponent| exponent % 2 != 0) {
        return Err(format!("square root of {}: half of its dimension has no whole exponents", described(value)));
    }
    let half = Dimension {
        length: d.length / 2,
        mass: d.mass / 2,
        time: d.time / 2,
        current: d.current / 2,
        temperature: d.temperature / 2,
        angle: d.angle / 2,
    };
    Ok(Value::measured(libm::sqrt(number), half))
}

fn power(base: &Value, exponent: &Value) -> FunctionResult {
    match (base, exponent) {
        (Value::Integer(a), Value::Integer(b)) if *b >= 0 => u32::try_from(*b)
            .ok()
            .and_then(|exponent| a.checked_pow(exponent))
            .map(Value::Integer)
            .ok_or_else(overflow("expt", a, b)),
        (Value::Quantity(_) | Value::Duration(_), Value::Integer(times)) if times.unsigned_abs() <= 8 => {
            let (number, dimension) = number(base)?;
            let mut result = Dimension::NONE;
            for _ in 0..times.unsigned_abs() {
                result = if *times > 0 { result.times(dimension) } else { result.over(dimension) };
            }
            Ok(Value::measured(libm::pow(number, *times as f64), result))
        }
        _ => {
            let result = libm::pow(pure_number(base)?, pure_number(exponent)?);
            if result.is_nan() {
                Err(format!("{base} to the power of {exponent} is not a real number"))
            } else {
                Ok(Value::Real(result))
            }
        }
    }
}

fn logarithm(value: &Value, base: Option<&Value>) -> FunctionResult {
    let number = pure_number(value)?;
    if number <= 0.0 {
        return Err(format!("logarithm of {value}, which is not above zero"));
    }
    match base.map(pure_number).transpose()? {
        None => Ok(Value::Real(libm::log(number))),
        Some(2.0) => Ok(Value::Real(libm::log2(number))),
        Some(10.0) => Ok(Value::Real(libm::log10(number))),
        Some(base) if base > 0.0 && base != 1.0 => Ok(Value::Real(libm::log(number) / libm::log(base))),
        Some(base) => Err(format!("logarithm to the base {base}: a base is above zero and not one")),
    }
}

fn angle(value: &Value) -> Result<f64, String> {
    match number(value)? {
        (number, Dimension::ANGLE | Dimension::NONE) => Ok(number),
        _ => Err(format!("expected an angle, found {}", described(value))),
    }
}

fn arc(value: &Value, function: fn(f64) -> f64) -> FunctionResult {
    let result = function(pure_number(value)?);
    if result.is_nan() {
        return Err(format!("{value} is not the sine or cosine of an angle: it must be between -1 and 1"));
    }
    Ok(Value::measured(result, Dimension::ANGLE))
}

fn arc_of_two(y: &Value, x: &Value) -> FunctionResult {
    match (number(y)?, number(x)?) {
        ((a, dimension_a), (b, dimension_b)) if dimension_a == dimension_b => {
            Ok(Value::measured(libm::atan2(a, b), Dimension::ANGLE))
        }
        _ => Err(format!("atan needs numbers of one dimension, found {} and {}", described(y), described(x))),
    }
}

fn unit_of(unit: &Value) -> Result<&'static apex_model::quantity::Unit, String> {
    let name = match unit {
        Value::Symbol(symbol) => symbol.printed(),
        Value::Text(text) => text,
        other => return Err(format!("expected the name of a unit, found {other}")),
    };
    unit_named(name).ok_or_else(|| format!("{name} is not a known unit"))
}

fn quantity(number: &Value, unit: &Value) -> FunctionResult {
    Ok(with_unit(pure_number(number)?, unit_of(unit)?))
}

/// Returns `number` of `unit` as a value.
pub(crate) fn with_unit(number: f64, unit: &'static apex_model::quantity::Unit) -> Value {
    match unit.dimension {
        Dimension::TIME | Dimension::NONE => Value::measured(number * unit.factor, unit.dimension),
        _ => Value::Quantity(Quantity::of(number, unit)),
    }
}

fn in_unit(value: &Value, unit: &Value) -> FunctionResult {
    let unit = unit_of(unit)?;
    // Durations are whole nanoseconds, and so are most units of time: a division in seconds would not be exact.
    let tick_s = 1e-9;
    if let (Value::Duration(span), Dimension::TIME) = (value, unit.dimension)
        && unit.factor >= tick_s
    {
        return Ok(Value::Real(span.0 as f64 / libm::round(unit.factor * 1e9)));
    }
    match number(value)? {
        (number, dimension) if dimension == unit.dimension => Ok(Value::Real(number / unit.factor)),
        _ => {
            Err(format!("{} cannot be expressed in {}, which measures {}", described(value), unit.name, unit.dimension))
        }
    }
}

pub(super) fn number(value: &Value) -> Result<(f64, Dimension), String> {
    value.as_number().ok_or_else(|| format!("expected a number, found {}", described(value)))
}

pub(super) fn pure_number(value: &Value) -> Result<f64, String> {
    match number(value)? {
        (number, Dimension::NONE) => Ok(number),
        _ => Err(format!("expected a pure number, found {}", described(value))),
    }
}

/// Returns the integer that `value` represents; a whole real counts.
///
/// # Errors
/// When it is neither.
pub(super) fn integer(value: &Value) -> Result<i64, String> {
    match value {
        Value::Integer(integer) => Ok(*integer),
        Value::Real(real) if libm::trunc(*real) == *real && real.abs() < 9e15 => Ok(*real as i64),
        other => Err(format!("expected an integer, found {}", described(other))),
    }
}

/// Returns the duration that `value` represents; a plain zero counts.
///
/// # Errors
/// When it is neither.
pub(crate) fn duration(value: &Value) -> Result<Duration, String> {
    match value {
        Value::Duration(duration) => Ok(*duration),
        Value::Real(real) if *real == f64::INFINITY => Ok(Duration::MAX),
        zero if is_zero(zero) => Ok(Duration::ZERO),
        other => Err(format!("expected a duration such as P5S, found {}", described(other))),
    }
}

/// Returns the instant that `value` is; infinity is the end of time.
///
/// # Errors
/// When it is neither.
pub(crate) fn instant(value: &Value) -> Result<Time, String> {
    match value {
        Value::Time(time) => Ok(*time),
        Value::Duration(since_start) => Ok(Time::ZERO + *since_start),
        Value::Real(real) if *real == f64::INFINITY => Ok(Time::END),
        zero if is_zero(zero) => Ok(Time::ZERO),
        other => Err(format!("expected an instant such as +now+ or (end-of ?step), found {other}")),
    }
}

fn is_zero(value: &Value) -> bool {
    matches!(value, Value::Integer(0)) || matches!(value, Value::Real(real) if *real == 0.0)
}

fn overflow<'a>(operation: &'a str, a: &'a i64, b: &'a i64) -> impl FnOnce() -> String + 'a {
    move || format!("({operation} {a} {b}) is too large for an integer; write one of them as a real number")
}
