//! Classifies the text of an atom: number, quantity, duration, variable, indexical or name.

use apex_model::quantity::{Dimension, Quantity, Unit, unit_named};
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, NANOSECONDS_PER_SECOND};

/// Kind of an atom. Names are slices of the text: the reader makes each symbol once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Atom<'t> {
    Integer(i64),
    Real(f64),
    Quantity(Quantity),
    Duration(Duration),
    Symbol(&'t str),
    Variable(&'t str),
    Bound(&'t str),
    Anonymous,
    Indexical(&'t str),
    /// A number that no real can hold.
    OutOfRange,
}

/// Classifies `text`. Every text has a kind; the last one is a symbol.
pub(crate) fn classify(text: &str) -> Atom<'_> {
    if is_plain_word(text) {
        return Atom::Symbol(text);
    }
    if text == "?" {
        return Atom::Anonymous;
    }
    if let Some(name) = text.strip_prefix('?') {
        return Atom::Variable(name);
    }
    if let Some(name) = text.strip_prefix("<?").and_then(|rest| rest.strip_suffix('>')).filter(|name| !name.is_empty())
    {
        return Atom::Bound(name);
    }
    if let Some(number) = number(text) {
        return number;
    }
    if let Some(name) = text.strip_prefix('+').and_then(|rest| rest.strip_suffix('+')).filter(|name| !name.is_empty()) {
        return Atom::Indexical(name);
    }
    if let Some(duration) = duration(text) {
        return Atom::Duration(duration);
    }
    if let Some(level) = flight_level(text) {
        return Atom::Quantity(level);
    }
    Atom::Symbol(text)
}

/// Returns true if the first letter permits only a symbol: a letter other than those of `P5S` and `FL120`. This holds for most words.
fn is_plain_word(text: &str) -> bool {
    text.bytes().next().is_some_and(|first| first.is_ascii_alphabetic() && !matches!(first, b'P' | b'p' | b'F' | b'f'))
}

/// Returns a number, or a number with a known unit.
fn number(text: &str) -> Option<Atom<'_>> {
    let length = number_length(text)?;
    let (digits, suffix) = text.split_at_checked(length)?;
    if suffix.is_empty() {
        if digits.bytes().all(|byte| byte.is_ascii_digit() || byte == b'-' || byte == b'+')
            && let Ok(integer) = digits.parse::<i64>()
        {
            return Some(Atom::Integer(integer));
        }
        return Some(real(digits).map_or(Atom::OutOfRange, Atom::Real));
    }
    if let Some(denominator) = suffix.strip_prefix('/').filter(|rest| rest.bytes().all(|byte| byte.is_ascii_digit())) {
        let ratio = real(digits)? / real(denominator)?;
        return Some(if ratio.is_finite() { Atom::Real(ratio) } else { Atom::OutOfRange });
    }
    let unit = unit_named(suffix)?;
    Some(real(digits).map_or(Atom::OutOfRange, |number| measured(number, unit)))
}

fn real(digits: &str) -> Option<f64> {
    digits.parse::<f64>().ok().filter(|number| number.is_finite())
}

/// Returns `number` of `unit`: a duration for units of time, otherwise a quantity.
fn measured(number: f64, unit: &'static Unit) -> Atom<'static> {
    if unit.dimension == Dimension::TIME {
        Atom::Duration(Duration::from_seconds(number * unit.factor))
    } else {
        Atom::Quantity(Quantity::of(number, unit))
    }
}

/// Returns the length of the number that `text` begins with.
fn number_length(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let at = |index: usize| bytes.get(index).copied().unwrap_or(0);
    let digits_from = |from: usize| bytes.iter().skip(from).take_while(|byte| byte.is_ascii_digit()).count();
    let mut end = usize::from(matches!(at(0), b'+' | b'-'));
    let whole = digits_from(end);
    end += whole;
    let mut fraction = 0;
    if at(end) == b'.' {
        fraction = digits_from(end + 1);
        if whole > 0 || fraction > 0 {
            end += 1 + fraction;
        }
    }
    if whole == 0 && fraction == 0 {
        return None;
    }
    if matches!(at(end), b'e' | b'E') {
        let sign = usize::from(matches!(at(end + 1), b'+' | b'-'));
        let exponent = digits_from(end + 1 + sign);
        if exponent > 0 {
            end += 1 + sign + exponent;
        }
    }
    Some(end)
}

/// Reads `FL120`.
fn flight_level(text: &str) -> Option<Quantity> {
    let (letters, digits) = text.split_at_checked(2)?;
    let is_number = letters.eq_ignore_ascii_case("fl")
        && digits.starts_with(|first: char| first.is_ascii_digit())
        && number_length(digits) == Some(digits.len());
    if !is_number {
        return None;
    }
    Some(Quantity::of(real(digits)?, unit_named("FL")?))
}

/// Parses `P1H3M4.5S`, `PT1H3M4.5S`, `P2DT3H`, `-P5S`. M is always minutes: missions do not last months.
fn duration(text: &str) -> Option<Duration> {
    let (negative, text) = match text.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, text),
    };
    let mut rest = text.strip_prefix(['P', 'p'])?;
    let mut total: i128 = 0;
    let mut order = 0;
    let mut parts = 0;
    let mut time_mark = false;
    while !rest.is_empty() {
        if let Some(after) = rest.strip_prefix(['T', 't']).filter(|_| !time_mark) {
            time_mark = true;
            rest = after;
            continue;
        }
        let digits = rest.find(|c: char| !c.is_ascii_digit() && c != '.')?;
        let (number, after) = rest.split_at_checked(digits)?;
        let letter = after.chars().next()?;
        let (rank, seconds) = match letter.to_ascii_uppercase() {
            'W' => (1, 604_800),
            'D' => (2, 86_400),
            'H' => (3, 3600),
            'M' => (4, 60),
            'S' => (5, 1),
            _ => return None,
        };
        if rank <= order {
            return None;
        }
        order = rank;
        total = total.checked_add(nanoseconds(number)?.checked_mul(seconds)?)?;
        parts += 1;
        rest = after.split_at_checked(1)?.1;
    }
    let signed = if negative { -total } else { total };
    (parts > 0).then_some(Duration(i64::try_from(signed).unwrap_or(i64::MAX)))
}

/// Returns the exact nanoseconds of a decimal number of seconds; digits beyond the ninth are dropped.
fn nanoseconds(number: &str) -> Option<i128> {
    let (whole, fraction) = number.split_once('.').unwrap_or((number, ""));
    if (whole.is_empty() && fraction.is_empty()) || fraction.contains('.') || whole.len() > 18 {
        return None;
    }
    let whole: i128 = if whole.is_empty() { 0 } else { whole.parse().ok()? };
    let padded: String = fraction.chars().chain("000000000".chars()).take(9).collect();
    let fraction: i128 = padded.parse().ok()?;
    Some(whole * i128::from(NANOSECONDS_PER_SECOND) + fraction)
}

/// Returns true for symbols that begin with a digit, such as `900MHzModem`.
pub(crate) fn is_number_like_symbol(symbol: &Symbol) -> bool {
    symbol.folded().starts_with(|first: char| first.is_ascii_digit()) && number_length(symbol.folded()).is_some()
}

/// Returns the two parts of a number with a known unit, as written.
pub(crate) fn number_and_unit(text: &str) -> Option<(&str, &str)> {
    let parts = text.split_at_checked(number_length(text)?)?;
    unit_named(parts.1).map(|_| parts)
}

/// Returns the number at the beginning of `symbol` and the rest, if the rest is probably a misspelt unit: `35knt`. `None` if the rest
/// resembles no unit.
pub(crate) fn parse_unit_misspelt(symbol: &Symbol) -> Option<(String, String)> {
    let text = symbol.printed();
    let (number, suffix) = text.split_at_checked(number_length(text)?)?;
    let is_word = !suffix.is_empty() && suffix.chars().count() <= UNIT_CHARACTERS_MAX;
    let is_word = is_word && suffix.chars().all(|c| c.is_alphabetic() || c == '/');
    (is_word && !crate::suggest::near_units(suffix).is_empty()).then(|| (number.to_string(), suffix.to_string()))
}

/// Characters beyond which nothing is a misspelt unit.
const UNIT_CHARACTERS_MAX: usize = 12;

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(text: &str) -> Option<f64> {
        match classify(text) {
            Atom::Duration(duration) => Some(duration.seconds()),
            _ => None,
        }
    }

    fn printed(text: &str) -> String {
        match classify(text) {
            Atom::Quantity(quantity) => quantity.to_string(),
            other => format!("{other:?}"),
        }
    }

    #[test]
    fn durations_in_every_spelling() {
        assert_eq!(seconds("P1H3M4.5S"), Some(3784.5));
        assert_eq!(seconds("PT1H3M4.5S"), Some(3784.5));
        assert_eq!(seconds("P1M30S"), Some(90.0));
        assert_eq!(seconds("P2DT1H"), Some(176_400.0));
        assert_eq!(seconds("-p2s"), Some(-2.0));
        assert_eq!(seconds("20s"), Some(20.0));
        assert_eq!(seconds("500ms"), Some(0.5));
        assert_eq!(seconds("P"), None);
        assert_eq!(seconds("P5"), None);
        assert_eq!(seconds("P1S1H"), None);
    }

    #[test]
    fn quantities_with_units_and_names_that_begin_with_digits() {
        for text in ["35kt", "400ft", "FL120", "2nm", "5deg", "900MHz", "21.5kg", "12V", "3deg/s"] {
            assert_eq!(printed(text), text);
        }
        assert_eq!(classify("900MHzModem"), Atom::Symbol("900MHzModem"));
        assert_eq!(classify("1+"), Atom::Symbol("1+"));
        assert_eq!(classify("flare"), Atom::Symbol("flare"));
    }

    #[test]
    fn numbers_variables_and_indexicals() {
        assert_eq!(classify("-12"), Atom::Integer(-12));
        assert_eq!(classify("+.5e1"), Atom::Real(5.0));
        assert_eq!(classify("1/4"), Atom::Real(0.25));
        assert_eq!(classify("1e999"), Atom::OutOfRange);
        assert_eq!(classify("<?x>"), Atom::Bound("x"));
        assert_eq!(classify("?"), Atom::Anonymous);
        assert_eq!(classify("+now+"), Atom::Indexical("now"));
        assert_eq!(classify("+/-"), Atom::Symbol("+/-"));
        assert_eq!(classify("+"), Atom::Symbol("+"));
        assert_eq!(classify("-"), Atom::Symbol("-"));
        assert_eq!(classify("..."), Atom::Symbol("..."));
    }
}
