//! Explains a word of the language or of the shipped libraries, for `apex explain`.

use crate::read::{Datum, DatumKind, read_file};
use crate::reference_page;
use crate::suggest::nearest;
use crate::vocabulary::{ACTIVITIES, VOCABULARY};
use apex_model::builtins::{ALIASES, BUILT_INS, BuiltIn, INDEXICALS, SPECIAL_FORMS, built_in};
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// The libraries that ship, by name.
pub(crate) const LIBRARIES: &[(&str, &str)] = &[
    ("library/interface.pdl", include_str!("../../../library/interface.pdl")),
    ("library/vehicle.pdl", include_str!("../../../library/vehicle.pdl")),
    ("library/aerial-observation.pdl", include_str!("../../../library/aerial-observation.pdl")),
    ("library/manoeuvres.pdl", include_str!("../../../library/manoeuvres.pdl")),
    ("library/requirements.pdl", include_str!("../../../library/requirements.pdl")),
    ("library/contingencies.pdl", include_str!("../../../library/contingencies.pdl")),
    ("library/replanning.pdl", include_str!("../../../library/replanning.pdl")),
];
/// Forms whose heads are searched for a word.
const SPECIAL_SHAPES: &[(&str, &str)] = &[
    ("and", "(and FORM..) -> the last value, or nil as soon as one is nil"),
    ("case", "(case KEY (DATUM FORM..).. (t FORM..)) -> the value of the clause with the datum"),
    ("cond", "(cond (TEST FORM..)..) -> the value of the first clause whose test is true"),
    ("decf", "(decf PLACE [NUMBER]) -> the variable, less the number"),
    ("function", "#'NAME -> the function of that name"),
    ("if", "(if TEST THEN [ELSE]) -> the value of THEN, or of ELSE"),
    ("incf", "(incf PLACE [NUMBER]) -> the variable, plus the number"),
    ("lambda", "(lambda (PARAMETER..) FORM..) -> a function"),
    ("let", "(let ((NAME VALUE)..) FORM..) -> the last value, with these variables"),
    ("let*", "(let* ((NAME VALUE)..) FORM..) -> as let; each value sees the names before it"),
    ("or", "(or FORM..) -> the first true value, else nil"),
    ("progn", "(progn FORM..) -> the last value"),
    ("push", "(push VALUE PLACE) -> the list with the value before it"),
    ("quote", "'DATUM -> the datum, not evaluated"),
    ("setq", "(setq NAME VALUE) or (setq ?NAME VALUE) -> the value, which the variable has from now on"),
    ("unless", "(unless TEST FORM..) -> the last value if TEST is nil"),
    ("when", "(when TEST FORM..) -> the last value if TEST is true"),
];

/// Explains `word`: functions, forms, clauses, options, indexicals, and the definitions of that name in the shipped libraries: goals,
/// commands, messages, state variables. `None` for an unknown word.
pub fn explain_word(word: &str) -> Option<String> {
    let word = word.trim();
    // `+now+` is written between signs; `1+` and `+` are functions.
    let word =
        word.strip_prefix('+').and_then(|word| word.strip_suffix('+')).filter(|word| !word.is_empty()).unwrap_or(word);
    // A goal is looked for by its words, written as they are or with hyphens.
    let folded = word.trim_start_matches(['(', ':']).trim_end_matches(')').to_lowercase().replace(' ', "-");
    let mut text = String::new();
    if let Some(function) = built_in(&folded) {
        text.push_str(&of_function(&folded, function));
    }
    if let Some((name, shape)) = SPECIAL_SHAPES.iter().find(|(name, _)| *name == folded) {
        let _ = writeln!(text, "{name}: a form. {shape}");
    }
    if INDEXICALS.contains(&&*folded) {
        let _ = writeln!(text, "+{folded}+: an indexical that every agent has (docs/reference/pdl.md, \"Text\")");
    }
    for words in VOCABULARY.iter().filter(|words| words.words.contains(&&*folded)) {
        let _ = writeln!(text, "{folded}: {} (docs/reference/pdl.md)", words.kind);
    }
    if ACTIVITIES.contains(&&*folded) {
        let _ = writeln!(text, "{folded}: a built-in activity of steps (docs/reference/pdl.md, \"Steps\")");
    }
    for (name, library) in LIBRARIES {
        of_library(&folded, name, library, &mut text);
    }
    if let Some((_, row)) = mission_rows(&format!("`:{folded}`")).next() {
        let _ = writeln!(text, ":{folded}: an option of a mission (docs/reference/mission-data.md)\n  {row}");
    }
    for (section, row) in mission_rows(&format!("`{folded}`")) {
        let _ =
            writeln!(text, "{folded}: in a mission's data (docs/reference/mission-data.md, \"{section}\")\n  {row}");
    }
    if let Some(page) = reference_page::explain(&folded) {
        text.push_str(&page);
    }
    (!text.is_empty()).then_some(text)
}

/// Returns the rows of the page of mission data whose first cell contains `name`: the section, and the cells after the first.
fn mission_rows(name: &str) -> impl Iterator<Item = (&'static str, String)> {
    let page = include_str!("../../../docs/reference/mission-data.md");
    let mut section = "";
    page.lines().filter_map(move |line| {
        if let Some(heading) = line.strip_prefix("## ") {
            section = heading;
        }
        let cells: Vec<&str> = line.strip_prefix('|')?.strip_suffix('|')?.split(" | ").map(str::trim).collect();
        let (first, rest) = cells.split_first()?;
        first.split_whitespace().any(|word| word == name).then(|| (section, rest.join("; ")))
    })
}

/// Returns the known word nearest to `word`.
pub fn nearest_word(word: &str) -> Option<&'static str> {
    let functions = BUILT_INS.iter().map(|each| each.name);
    let words = VOCABULARY.iter().flat_map(|words| words.words.iter().copied());
    nearest(&word.to_lowercase(), functions.chain(words).chain(SPECIAL_FORMS.iter().copied()))
}

fn of_function(name: &str, function: &BuiltIn) -> String {
    let count = match (function.arguments_min, function.arguments_max) {
        (0, Some(0)) => "no arguments".to_string(),
        (least, Some(most)) if least == most => format!("{least} argument{}", if least == 1 { "" } else { "s" }),
        (least, Some(most)) => format!("{least} to {most} arguments"),
        (least, None) => format!("at least {least} argument{}", if least == 1 { "" } else { "s" }),
    };
    let place = if function.pure {
        "may be used wherever a value is needed"
    } else {
        "has an effect: hooks and primitives only"
    };
    let mut text = format!("{}: a function. {}\n  takes {count}; {place}\n", function.name, function.summary);
    let others: Vec<&str> = ALIASES.iter().filter(|(_, own)| *own == function.name).map(|(alias, _)| *alias).collect();
    if name != function.name || !others.is_empty() {
        let _ = writeln!(text, "  other spellings: {}", others.join(" "));
    }
    text
}

/// Adds to `text` the forms of a library that define or use the word, each with its place.
fn of_library(word: &str, name: &str, library: &str, text: &mut String) {
    let mut told = BTreeSet::new();
    for form in &read_file(0, library).data {
        let kind = form.head_name();
        let index =
            form.tail().iter().find(|clause| clause.head_name() == "index").and_then(|clause| clause.tail().first());
        let mut say = |what: String| {
            if told.insert(what.clone()) {
                let _ = writeln!(text, "{what}\n  {name}:{}", form.span.line);
            }
        };
        match (kind, index) {
            ("procedure" | "primitive" | "solver", Some(index)) => {
                if begins_with(index, word) {
                    say(format!("{}: a goal that a {kind} serves", written(library, index)));
                }
                each_list(form, &mut |list| match (list.head_name(), list.tail().first()) {
                    ("command", Some(command)) if command.head_name() == word => {
                        let goal = written(library, index);
                        say(format!("{}: a command, sent for the goal {goal}", written(library, command)));
                    }
                    ("inform" | "cogevent", Some(message)) if message.head_name() == word => {
                        let goal = written(library, index);
                        say(format!("{}: a message, sent for the goal {goal}", written(library, message)));
                    }
                    _ => {}
                });
            }
            ("declare-event" | "declare-command", _)
                if form.tail().first().is_some_and(|each| each.head_name() == word) =>
            {
                let what = if kind == "declare-event" { "a message" } else { "a command" };
                let signature = form.tail().first().map_or_else(String::new, |each| written(library, each));
                let from = form.tail().iter().skip_while(|part| !part.is(":from")).nth(1);
                let from = from.map_or_else(String::new, |source| format!(" from {}", written(library, source)));
                say(format!("{signature}: {what}{from}"));
            }
            ("state-variable", _) if form.tail().first().is_some_and(|variable| variable.head_name() == word) => {
                say(format!("{}: a state variable", written(library, form)));
            }
            ("defun" | "declare-function", _) => {
                let first = form.tail().first();
                if first.is_some_and(|first| first.is(word) || first.head_name() == word) {
                    say(format!("{word}: a function of the library"));
                }
            }
            ("resource", _) if form.tail().first().is_some_and(|resource| resource.is(word)) => {
                say(format!("{}: a resource", written(library, form)));
            }
            _ => {}
        }
    }
}

/// Returns true if the words of a hyphenated name are the first words of the goal: `take-off` and `(take off to ?altitude)`.
fn begins_with(index: &Datum, word: &str) -> bool {
    let mut joined = String::new();
    for item in index.as_list().unwrap_or_default() {
        let Some(name) = item.as_symbol() else { return false };
        if !joined.is_empty() {
            joined.push('-');
        }
        joined.push_str(name.folded());
        if joined == word {
            return true;
        }
    }
    false
}

fn each_list(datum: &Datum, visit: &mut dyn FnMut(&Datum)) {
    if let DatumKind::List(items) = &datum.kind {
        visit(datum);
        items.iter().for_each(|item| each_list(item, visit));
    }
}

/// Returns the text of the datum on one line.
pub(crate) fn written(text: &str, datum: &Datum) -> String {
    let range = datum.span.start as usize..datum.span.end as usize;
    text.get(range).unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_the_language_and_of_the_libraries_are_explained() {
        let explained = |word: &str| explain_word(word).unwrap_or_default();
        assert!(explained("sqrt").starts_with("sqrt: a function. number -> square root"));
        assert!(explained("car").contains("other spellings: car"));
        assert!(explained("waitfor").contains("clause of a step"));
        assert!(explained("+now+").contains("indexical"));
        let take_off = explained("take-off");
        assert!(
            take_off.contains("(take off to ?altitude): a goal")
                && take_off.contains("(take-off (?altitude length) &key (:centre place)): a command")
        );
        assert!(take_off.contains("library/vehicle.pdl:"));
        assert!(explained("altitude").contains(":unit m"));
        assert!(explained("image-taken").contains("(image-taken (?camera camera) ?target): a message from vehicle"));
        assert!(explained("take-picture").contains(": a command\n"));
        assert!(explained("take off to").contains("(take off to ?altitude): a goal"));
        assert!(explained(":targets").contains("GeoJSON"));
        assert_eq!(explain_word("frobnicate"), None);
        assert_eq!(nearest_word("sqr"), Some("sqrt"));
    }

    #[test]
    fn every_function_and_form_has_an_explanation() {
        for name in BUILT_INS
            .iter()
            .map(|each| each.name)
            .chain(SPECIAL_FORMS.iter().copied())
            .chain(ALIASES.iter().map(|(alias, _)| *alias))
        {
            assert!(explain_word(name).is_some(), "{name}");
        }
    }
}
