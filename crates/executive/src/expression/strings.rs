//! Text: `format`, concatenation, search, case.

use super::arithmetic::integer;
use super::display;
use super::lists::bounds;
use super::result::FunctionResult;
use apex_model::limits::TEXT_CHARACTERS_MAX;
use apex_model::quantity::format_rounded;
use apex_model::symbol::Symbol;
use apex_model::value::Value;

/// Calls the text function `name`; `None` if there is no such function.
pub(super) fn call(name: &str, arguments: &[Value]) -> Option<FunctionResult> {
    Some(match (name, arguments) {
        ("format", [Value::Text(control), rest @ ..]) => format(control, rest).and_then(bounded),
        ("format", [_, Value::Text(control), rest @ ..]) => format(control, rest).and_then(bounded),
        ("format", _) => Err("format needs a control string, for example (format \"~a of ~a\" ?x ?y)".into()),
        ("concatenate", values) => bounded(values.iter().map(display).collect()),
        ("intern", [text]) => text_of(text).map(|text| Value::Symbol(Symbol::new(text))),
        ("symbol-name", [symbol]) => text_of(symbol).map(Value::text),
        ("string-upcase", [text]) => text_of(text).map(|text| Value::text(&text.to_uppercase())),
        ("string-downcase", [text]) => text_of(text).map(|text| Value::text(&text.to_lowercase())),
        ("string=", [a, b]) => both(a, b, |a, b| a == b),
        ("string-equal", [a, b]) => both(a, b, |a, b| a.to_lowercase() == b.to_lowercase()),
        ("search-string", [part, text]) => search(part, text),
        ("substring" | "subseq", [text, start]) => substring(text, start, None),
        ("substring" | "subseq", [text, start, end]) => substring(text, start, Some(end)),
        _ => return None,
    })
}

/// Returns `text` as a value, within the limit.
///
/// # Errors
/// When it is too long.
pub(super) fn bounded(text: String) -> FunctionResult {
    let length = text.chars().count();
    if length > TEXT_CHARACTERS_MAX {
        return Err(format!(
            "a text of {length} characters is longer than the limit TEXT_CHARACTERS_MAX = {TEXT_CHARACTERS_MAX}"
        ));
    }
    Ok(Value::text(&text))
}

fn text_of(value: &Value) -> Result<&str, String> {
    match value {
        Value::Text(text) => Ok(text),
        Value::Symbol(symbol) => Ok(symbol.printed()),
        other => Err(format!("expected a string or a symbol, found {other}")),
    }
}

fn both(left: &Value, right: &Value, test: fn(&str, &str) -> bool) -> FunctionResult {
    Ok(Value::truth(test(text_of(left)?, text_of(right)?)))
}

fn search(part: &Value, text: &Value) -> FunctionResult {
    let (part, text) = (text_of(part)?, text_of(text)?);
    let index = text.find(part).and_then(|bytes| text.get(..bytes)).map(|before| before.chars().count());
    Ok(index.and_then(|index| i64::try_from(index).ok()).map_or_else(Value::nil, Value::Integer))
}

fn substring(text: &Value, start: &Value, end: Option<&Value>) -> FunctionResult {
    let text = text_of(text)?;
    let (start, end) = bounds(start, end, text.chars().count())?;
    Ok(Value::text(&text.chars().skip(start).take(end - start).collect::<String>()))
}

/// Returns the text of a control string. Directives: `~a` a value for display, `~s` a value as PDL reads it, `~d` an integer, `~f` a
/// real, `~,Nf` a real with N decimals, `~%` a new line, `~~` a tilde. A number before the letter is the least width: text is padded on
/// its right, numbers on their left.
fn format(control: &str, arguments: &[Value]) -> Result<String, String> {
    let mut text = String::new();
    let mut arguments = arguments.iter();
    let mut characters = control.chars();
    while let Some(character) = characters.next() {
        if character != '~' {
            text.push(character);
            continue;
        }
        let mut parameters = String::new();
        let letter = loop {
            match characters.next() {
                Some(next) if next.is_ascii_digit() || next == ',' => parameters.push(next),
                Some(letter) => break letter.to_ascii_lowercase(),
                None => return Err(format!("the control string {control:?} ends within a directive")),
            }
        };
        match letter {
            '%' => text.push('\n'),
            '~' => text.push('~'),
            'a' | 's' | 'd' | 'f' => {
                let argument = arguments
                    .next()
                    .ok_or_else(|| format!("the control string {control:?} needs more arguments than it is given"))?;
                let (width, decimals) = widths(&parameters)?;
                let part = directive(letter, argument, decimals)?;
                // Text is padded on the right and numbers on the left, so that columns align.
                match letter {
                    'a' | 's' => text.push_str(&format!("{part:<width$}")),
                    _ => text.push_str(&format!("{part:>width$}")),
                }
            }
            other => return Err(format!("~{other} is not a directive of format; there are ~a ~s ~d ~f ~,2f ~% ~~")),
        }
        if text.len() > 4 * TEXT_CHARACTERS_MAX {
            return Err(format!(
                "format makes a text longer than the limit TEXT_CHARACTERS_MAX = {TEXT_CHARACTERS_MAX}"
            ));
        }
    }
    Ok(text)
}

fn widths(parameters: &str) -> Result<(usize, Option<usize>), String> {
    let (width, decimals) = parameters.split_once(',').unwrap_or((parameters, ""));
    let number = |text: &str| match text {
        "" => Ok(None),
        digits => match digits.parse() {
            // A printed line is narrower than this limit.
            Ok(number) if number <= 200_usize => Ok(Some(number)),
            _ => Err(format!("~{parameters}: a width or number of decimals is at most 200")),
        },
    };
    Ok((number(width)?.unwrap_or(0), number(decimals)?))
}

fn directive(letter: char, argument: &Value, decimals: Option<usize>) -> Result<String, String> {
    match letter {
        'a' => Ok(display(argument)),
        's' => Ok(argument.to_string()),
        'd' => match argument {
            Value::Integer(_) | Value::Real(_) => {
                Ok(integer(argument).map_or_else(|_| display(argument), |n| n.to_string()))
            }
            other => Ok(display(other)),
        },
        _ => {
            let number = match argument {
                Value::Quantity(quantity) => quantity.unit().map_or(quantity.si, |unit| quantity.in_unit(unit)),
                Value::Time(time) => time.seconds(),
                other => other.as_number().ok_or_else(|| format!("~f needs a number, found {other}"))?.0,
            };
            Ok(decimals.map_or_else(|| format_rounded(number), |decimals| format!("{number:.decimals$}")))
        }
    }
}
