//! Properties of every text: reading never panics, formatting keeps comments and data, printing loads again.
#![allow(
    clippy::indexing_slicing,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a helper that fails is a test that fails"
)]

use apex_model::expression::ExprKind;
use apex_model::library::Library;
use apex_model::procedure::{Primitive, Procedure};
use apex_model::value::Value;
use apex_pdl::{
    CheckOptions, Checked, PrintedPlan, SourceText, check, format, parse_condition, print_condition, print_plan,
    print_primitive, print_procedure, read_value, render,
};
use proptest::prelude::*;

fn checked(text: &str, fragment: bool) -> Checked {
    let source = SourceText { name: "generated.pdl".to_string(), text: text.to_string() };
    let mut resolve = |_| Err("nothing is required".into());
    check(vec![source], CheckOptions { fragment, host: &[], resolve: &mut resolve })
}

/// Returns the debug text of nouns with every place left out.
fn without_places(text: &str) -> String {
    let mut parts = text.split("Place {");
    let first = parts.next().unwrap_or_default().to_string();
    parts.filter_map(|part| part.split_once('}')).fold(first, |kept, (_, after)| kept + after)
}

fn procedure_key(procedure: &Procedure) -> String {
    without_places(&format!("{procedure:?}"))
}

fn primitive_key(primitive: &Primitive) -> String {
    without_places(&format!("{primitive:?}"))
}

/// Every procedure and primitive is unchanged, except for its places, after printing and loading.
fn round_trip(text: &str) {
    let first = checked(text, true);
    assert!(!first.has_errors(), "{}\n{text}", render(&first.diagnostics, &first.library.sources, false));
    let second = |printed: &str| -> Library {
        let again = checked(&(declarations(text) + printed), true);
        assert!(!again.has_errors(), "{}\n{printed}", render(&again.diagnostics, &again.library.sources, false));
        again.library
    };
    for procedure in &first.library.procedures {
        let bundle = procedure.bundle.as_ref().map_or(String::new(), |name| format!("(in-apex-bundle :{name})\n"));
        let printed = bundle + &print_procedure(procedure);
        assert_eq!(procedure_key(&second(&printed).procedures[0]), procedure_key(procedure), "{printed}");
    }
    for primitive in &first.library.primitives {
        let bundle = primitive.bundle.as_ref().map_or(String::new(), |name| format!("(in-apex-bundle :{name})\n"));
        let printed = bundle + &print_primitive(primitive);
        assert_eq!(primitive_key(&second(&printed).primitives[0]), primitive_key(primitive), "{printed}");
    }
}

/// Declarations that change how forms are read.
fn declarations(text: &str) -> String {
    let is_declaration = |line: &&str| {
        line.starts_with("(state-variable") || line.starts_with("(resource") || line.starts_with("(defun")
    };
    text.lines().filter(is_declaration).map(|line| format!("{line}\n")).collect()
}

const EVERYTHING: &str = include_str!("listings/everything.pdl");

#[test]
fn every_clause_prints_and_loads_again() {
    round_trip(EVERYTHING);
    for text in [
        include_str!("listings/camera.pdl"),
        include_str!("listings/xplane.pdl"),
        include_str!("listings/xplane-checked.pdl"),
        include_str!("listings/refly.pdl"),
        include_str!("listings/regain.pdl"),
    ] {
        round_trip(text);
    }
}

#[test]
fn every_condition_prints_and_loads_again() {
    for text in include_str!("listings/conditions.pdl").lines().filter(|line| line.starts_with('(')) {
        let parse = |text: &str| {
            let mut resolve = |_| Err("nothing is required".into());
            let parsed = parse_condition(text, CheckOptions { fragment: true, host: &[], resolve: &mut resolve });
            parsed.condition.unwrap_or_else(|| panic!("{text}: {:?}", parsed.diagnostics))
        };
        let condition = parse(text);
        let printed = print_condition(&condition);
        assert_eq!(
            without_places(&format!("{:?}", parse(&printed))),
            without_places(&format!("{condition:?}")),
            "{printed}"
        );
    }
}

#[test]
fn the_printed_form_is_canonical() {
    let library = checked(EVERYTHING, true).library;
    let printed: Vec<String> = library.procedures.iter().map(|procedure| print_procedure(procedure)).collect();
    insta::assert_snapshot!(printed.join("\n\n"));
}

#[test]
fn plans_are_procedures() {
    let goal = read_value("(survey western-fires)").unwrap();
    let step = |tag: &str, text: &str| (tag.into(), read_value(text).unwrap());
    let steps = [step("go", "(fly-to (34.7 -119.8 7010))"), step("look", "(scan zaca 400ft '?x)")];
    for repeat in [false, true] {
        let PrintedPlan { text, step_lines } = print_plan(&goal, &steps, repeat);
        let checked = checked(
            &format!("{text}\n(primitive (index (fly-to ?place)) (duration 1s))\n(primitive (index (scan ? ? ?)))"),
            false,
        );
        assert!(!checked.has_errors(), "{}\n{text}", render(&checked.diagnostics, &checked.library.sources, false));
        assert_eq!(checked.library.procedures.len(), if repeat { 2 } else { 1 });
        // The checker adds the end of a sequential procedure as a step.
        let steps = checked.library.procedures.last().unwrap().steps.iter().take(2);
        assert_eq!(step_lines, steps.map(|step| step.place.line).collect::<Vec<u32>>(), "{text}");
    }
}

/// Texts made of the pieces of PDL in any order, well formed or not.
fn any_pieces() -> impl Strategy<Value = String> {
    let piece = prop_oneof![
        Just("("),
        Just(")"),
        Just(" "),
        Just("\n"),
        Just("'"),
        Just("`"),
        Just(","),
        Just(",@"),
        Just("#'"),
        Just("\"s\\\"\""),
        Just("\""),
        Just("; c\n"),
        Just("#| b |#"),
        Just("#|"),
        Just("|#"),
        Just("?x"),
        Just("<?y>"),
        Just("?"),
        Just("+now+"),
        Just(":and"),
        Just(":episode"),
        Just("step"),
        Just("procedure"),
        Just("index"),
        Just("waitfor"),
        Just("35kt"),
        Just("5"),
        Just("P1M30S"),
        Just("=>"),
        Just("="),
        Just("+/-"),
        Just("é"),
        Just("defun"),
        Just("let"),
        Just("lambda"),
        Just("nil"),
        Just("(?* ?r)"),
        Just(":quality"),
        Just("forall"),
    ];
    proptest::collection::vec(piece, 0..60).prop_map(|pieces| pieces.join(" ").replace("  ", ""))
}

/// Well-formed data.
fn datum() -> impl Strategy<Value = String> {
    let atom = prop_oneof![
        "[a-z][a-z0-9-]{0,8}",
        "\\?[a-z]{1,4}",
        "[0-9]{1,4}",
        "[0-9]{1,3}(kt|ft|deg|s)",
        "\"[a-z \\n]{0,9}\"",
        Just(":quality".to_string()),
        Just("=>".to_string()),
    ];
    atom.prop_recursive(6, 80, 8, |inner| {
        let gap = prop_oneof![
            Just(" "),
            Just("\n"),
            Just("\n\n\n"),
            Just(" ; note\n"),
            Just("\n;; own line\n"),
            Just(" #| x |# ")
        ];
        let list = proptest::collection::vec((gap, inner.clone()), 0..8).prop_map(|items| {
            format!("({} )", items.into_iter().map(|(gap, item)| format!("{gap}{item}")).collect::<String>())
        });
        let long = inner.clone().prop_map(|item| format!("(procedure (index (a)) (step s {item}))"));
        prop_oneof![4 => list, 1 => inner.prop_map(|item| format!("'{item}")), 1 => long]
    })
}

/// Comments in order, without trailing blanks.
fn comments(text: &str) -> Vec<String> {
    let lines = text.lines().filter_map(|line| line.split_once(';').map(|(_, rest)| rest.trim_end().to_string()));
    let blocks = text.matches("#| x |#").map(str::to_string);
    lines.chain(blocks).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn any_text_is_checked_without_panic(text in any_pieces()) {
        for fragment in [false, true] {
            let result = checked(&text, fragment);
            render(&result.diagnostics, &result.library.sources, false);
        }
        let _ = read_value(&text);
        let _ = format(&text);
    }

    #[test]
    fn any_unicode_is_checked_without_panic(text in "\\PC{0,80}") {
        let result = checked(&text, true);
        render(&result.diagnostics, &result.library.sources, true);
        let _ = format(&text);
    }

    #[test]
    fn formatting_keeps_comments_and_data_and_is_idempotent(text in datum()) {
        let once = format(&text).unwrap();
        prop_assert_eq!(&format(&once).unwrap(), &once);
        prop_assert_eq!(read_value(&once), read_value(&text));
        prop_assert_eq!(comments(&once), comments(&text));
    }

    #[test]
    fn values_print_as_they_read(number in -1e6..1e6_f64, unit in prop_oneof![Just("kt"), Just("ft"), Just("deg"), Just("nm"), Just("s"), Just("kg"), Just("fpm")]) {
        let values = |text: &str| -> Vec<Value> {
            let library = checked(text, false).library;
            match &library.primitives[0].returns.as_ref().unwrap().kind {
                ExprKind::Call { arguments, .. } => arguments.iter().map(|argument| match &argument.kind {
                    ExprKind::Constant(value) => value.clone(),
                    other => panic!("{other:?}"),
                }).collect(),
                other => panic!("{other:?}"),
            }
        };
        let text = format!("(primitive (index (go)) (return (list {number}{unit} {number})))");
        let printed = print_primitive(&checked(&text, false).library.primitives[0]);
        prop_assert_eq!(values(&printed), values(&text), "{}", printed);
    }
}
