//! Division with whole results: remainders and rounding.

use super::arithmetic::{described, divide, in_unit_of, number, pure_number};
use super::result::FunctionResult;
use apex_model::time::Duration;
use apex_model::value::Value;
use std::cmp::Ordering;

pub(super) fn remainder(value: &Value, divisor: &Value, sign_of_divisor: bool) -> FunctionResult {
    let ((a, dimension_a), (b, dimension_b)) = (number(value)?, number(divisor)?);
    if dimension_a != dimension_b {
        return Err(format!("cannot divide {} by {} with a remainder", described(value), described(divisor)));
    }
    if b == 0.0 {
        return Err(format!("division of {value} by zero"));
    }
    let whole = |a: i64, b: i64| {
        let remainder = a.wrapping_rem(b);
        if sign_of_divisor && remainder != 0 && (remainder < 0) != (b < 0) { remainder + b } else { remainder }
    };
    match (value, divisor) {
        (Value::Integer(a), Value::Integer(b)) => Ok(Value::Integer(whole(*a, *b))),
        (Value::Duration(a), Value::Duration(b)) => Ok(Value::Duration(Duration(whole(a.0, b.0)))),
        _ => {
            let remainder = libm::fmod(a, b);
            let other_sign = remainder != 0.0 && (remainder < 0.0) != (b < 0.0);
            let result = if sign_of_divisor && other_sign { remainder + b } else { remainder };
            Ok(in_unit_of(result, dimension_a, value, divisor))
        }
    }
}

pub(super) fn to_integer(name: &str, value: &Value) -> FunctionResult {
    if let Value::Integer(_) = value {
        return Ok(value.clone());
    }
    let number = pure_number(value).map_err(|_| {
        format!("{name} needs a pure number or a divisor of the same dimension, found {}", described(value))
    })?;
    let whole = match name {
        "round" => libm::rint(number),
        "floor" => libm::floor(number),
        "ceiling" => libm::ceil(number),
        _ => libm::trunc(number),
    };
    // 2^63: every whole real below it in magnitude is a 64-bit integer.
    if whole.abs() < 9_223_372_036_854_775_808.0 {
        Ok(Value::Integer(whole as i64))
    } else {
        Err(format!("{number} is too large for an integer"))
    }
}

pub(super) fn divide_to_integer(name: &str, value: &Value, divisor: &Value) -> FunctionResult {
    if let (Value::Integer(a), Value::Integer(b)) = (value, divisor)
        && let (Some(quotient), Some(rest)) = (a.checked_div(*b), a.checked_rem(*b))
    {
        let negative = (rest < 0) != (*b < 0);
        let double = (i128::from(rest) * 2).abs().cmp(&i128::from(*b).abs());
        let away = match name {
            "floor" => rest != 0 && negative,
            "ceiling" => rest != 0 && !negative,
            "round" => double == Ordering::Greater || (double == Ordering::Equal && quotient % 2 != 0),
            _ => false,
        };
        let step = if negative { -1 } else { 1 };
        return Ok(Value::Integer(if away { quotient + step } else { quotient }));
    }
    to_integer(name, &divide(value, divisor)?)
}
