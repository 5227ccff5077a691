//! Every construct of the language is in the table of `docs/reference/pdl-coverage.md`, and on the page named there.

use apex_model::agent_limits::Limit;
use apex_model::builtins::{ALIASES, BUILT_INS, INDEXICALS, SPECIAL_FORMS};
use apex_model::quantity::UNITS;
use apex_pdl::VOCABULARY;
use apex_spec::coverage::{Row, fault, rows, shows, table};

fn read() -> Vec<Row> {
    rows(&std::fs::read_to_string(table()).unwrap_or_default())
}

#[test]
fn every_row_is_shown_by_its_page() {
    let rows = read();
    assert!(rows.len() > 300, "the table has {} rows only", rows.len());
    let faults: Vec<String> = rows.iter().filter_map(fault).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn every_word_that_the_checker_knows_has_a_row() {
    let rows = read();
    let functions = BUILT_INS.iter().map(|each| each.name).chain(ALIASES.iter().map(|(alias, _)| *alias));
    let functions = functions.chain(SPECIAL_FORMS.iter().copied()).map(|name| ("function", name.to_string()));
    let indexicals = INDEXICALS.iter().map(|name| ("indexical", format!("+{name}+")));
    let units = UNITS.iter().map(|unit| ("unit", unit.name.to_string()));
    let words = VOCABULARY.iter().flat_map(|each| each.words.iter().map(|word| (each.kind, word.to_string())));
    let limits = Limit::ALL.iter().map(|limit| ("limit", limit.word().to_string()));
    let known = functions.chain(indexicals).chain(units).chain(words).chain(limits);
    let missing: Vec<String> = known
        .filter(|(kind, word)| !rows.iter().any(|row| has(row, kind, &word.to_lowercase())))
        .map(|(kind, word)| format!("{kind} {word}"))
        .collect();
    assert!(missing.is_empty(), "no row for: {}", missing.join(", "));
}

/// Returns true if the row is about the word. A unit follows a number.
fn has(row: &Row, kind: &str, word: &str) -> bool {
    let construct = row.construct.to_lowercase();
    if kind == "unit" {
        return construct
            .strip_prefix(|first: char| first.is_ascii_digit())
            .is_some_and(|unit| unit.trim_start_matches(|each: char| each.is_ascii_digit() || each == '.') == word)
            || construct.starts_with(word) && construct.len() > word.len() && word == "fl";
    }
    let option = format!(":{word}");
    construct.split(['(', ')', ' ', '\'', '#']).any(|part| part == word || part == option) || shows(&construct, word)
}
