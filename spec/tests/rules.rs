//! Every rule of conditions is in the table of `docs/reference/condition-rules.md`, with existing files and runnable pages.

use apex_spec::rules::{RULES, Row, faults, rows, table};

fn read() -> Vec<Row> {
    rows(&std::fs::read_to_string(table()).unwrap_or_default())
}

#[test]
fn every_rule_has_one_row() {
    let numbers: Vec<u32> = read().iter().map(|row| row.number).collect();
    assert_eq!(numbers, (1..=RULES).collect::<Vec<u32>>());
}

#[test]
fn what_the_rows_name_is_there() {
    let faults: Vec<String> = read().iter().flat_map(faults).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
