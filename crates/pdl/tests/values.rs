//! Lexical rules, tested through the function that reads one value.

use apex_model::quantity::{Quantity, unit_named};
use apex_model::time::Duration;
use apex_model::value::Value;
use apex_pdl::read_value;

fn seconds(seconds: f64) -> Value {
    Value::Duration(Duration::from_seconds(seconds))
}

fn quantity(number: f64, unit: &str) -> Value {
    unit_named(unit).map_or_else(Value::nil, |unit| Value::Quantity(Quantity::of(number, unit)))
}

#[test]
fn every_spelling_of_a_duration_is_the_same_duration() {
    for text in ["P1H3M4.5S", "PT1H3M4.5S", "(1 hr 3 min 4 sec 500 ms)", "(1 h 3 minutes 4.5 s)", "3784.5s"] {
        assert_eq!(read_value(text).unwrap(), seconds(3784.5), "{text}");
    }
}

#[test]
fn quantities_are_written_with_a_suffix_or_as_a_list() {
    assert_eq!(read_value("(35 kt)").unwrap(), quantity(35.0, "kt"));
    assert_eq!(read_value("35KT").unwrap(), quantity(35.0, "kt"));
    assert_eq!(read_value("FL120").unwrap(), quantity(120.0, "FL"));
    assert_eq!(read_value("(fuel (21.5 kg))").unwrap(), Value::list([Value::symbol("fuel"), quantity(21.5, "kg")]));
    assert_eq!(read_value("(1 2)").unwrap(), Value::list([Value::Integer(1), Value::Integer(2)]));
    assert_eq!(read_value("(2 m 5 s)").unwrap().to_string(), "(2 m 5 s)");
}

#[test]
fn symbols_fold_case_and_keep_their_spelling() {
    let value = read_value("Fuel-Bay").unwrap();
    assert_eq!(value, Value::symbol("FUEL-BAY"));
    assert_eq!(value.to_string(), "Fuel-Bay");
    assert_eq!(read_value("900MHzModem").unwrap(), Value::symbol("900mhzmodem"));
}

#[test]
fn nil_is_the_empty_list_and_comments_are_nothing() {
    assert_eq!(read_value("NIL").unwrap(), Value::nil());
    assert_eq!(read_value("()").unwrap(), Value::nil());
    assert_eq!(read_value("; one\n#| two #| three |# |# t").unwrap(), Value::truth(true));
    assert_eq!(read_value(r#""a \"b\" \\ c""#).unwrap(), Value::text(r#"a "b" \ c"#));
}

#[test]
fn variables_stay_as_written_in_data() {
    assert_eq!(read_value("(a ?x <?y> ? +z+)").unwrap().to_string(), "(a ?x <?y> ? +z+)");
}

#[test]
fn exactly_one_value_is_read() {
    assert_eq!(read_value("").unwrap_err().code, "E0010");
    assert_eq!(read_value("a b").unwrap_err().code, "E0010");
    assert_eq!(read_value("(a").unwrap_err().code, "E0002");
}
