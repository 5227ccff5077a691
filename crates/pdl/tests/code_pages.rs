//! Every code has a page, and the page's examples are true: the first yields the code, the corrected one does not.

use apex_model::host::HostFunctions;
use apex_model::interface::NameKind;
use apex_model::symbol::Symbol;
use apex_pdl::{
    CheckOptions, Checked, ErrorCode, KnownNames, Requirement, SourceText, check, check_names, error_code, error_codes,
    read_value, report_constants,
};

fn checked(text: &str) -> Checked {
    let mut resolve = |requirement| match requirement {
        Requirement::Library(name) if name == "vehicle" => {
            Ok(SourceText { name: "library/vehicle.pdl".to_string(), text: "(primitive (index (fly)))\n".to_string() })
        }
        _ => Err("there is no such file".into()),
    };
    let source = SourceText { name: "page.pdl".to_string(), text: text.to_string() };
    let mut checked = check(vec![source], CheckOptions { fragment: false, host: &[], resolve: &mut resolve });
    let library = std::sync::Arc::new(checked.library.clone());
    report_constants(&mut checked, apex_executive::failing_constants(&library, HostFunctions::default()));
    checked
}

/// Returns the codes of all messages about the example of this kind.
fn codes(kind: &str, text: &str) -> Vec<&'static str> {
    match kind {
        "value" => read_value(text).err().map(|diagnostic| diagnostic.code).into_iter().collect(),
        "mission" => {
            let names = |names: &[&str]| names.iter().map(|name| Symbol::new(name)).collect();
            let known = KnownNames {
                names: [(NameKind::Place, names(&["home"]))].into_iter().collect(),
                solvers: names(&["auto", "human"]),
                ..KnownNames::default()
            };
            let library = checked(text).library;
            check_names(&library, &known).iter().map(|diagnostic| diagnostic.code).collect()
        }
        _ => checked(text).diagnostics.iter().map(|diagnostic| diagnostic.code).collect(),
    }
}

/// Kind and text of the block of the page that is marked `mark`.
fn example<'p>(code: &ErrorCode, page: &'p str, mark: &str) -> (&'p str, &'p str) {
    let block = page.split("```").skip(1).step_by(2).find_map(|block| {
        let (head, text) = block.split_once('\n')?;
        let (kind, found) = head.split_once(' ')?;
        (found == mark).then_some((kind, text))
    });
    assert!(block.is_some(), "the page of {} has no example marked `{mark}`", code.code);
    block.unwrap_or_default()
}

#[test]
fn examples_yield_the_code_and_corrected_ones_do_not() {
    let mut wrongs = Vec::new();
    for code in error_codes().iter().filter(|code| code.code != "E0007") {
        let (kind, wrong) = example(code, code.page, "wrong");
        let told = codes(kind, wrong);
        if !told.contains(&code.code) {
            wrongs.push(format!("{}: its wrong example yields {told:?}", code.code));
        }
        let (kind, right) = example(code, code.page, "right");
        let told = codes(kind, right);
        if told.contains(&code.code) || told.iter().any(|told| told.starts_with('E')) {
            wrongs.push(format!("{}: its right example yields {told:?}", code.code));
        }
    }
    assert!(wrongs.is_empty(), "{}", wrongs.join("\n"));
}

#[test]
fn a_text_that_is_too_large_yields_its_code() {
    // The only example that no page can print.
    assert_eq!(codes("pdl", &";".repeat((16 << 20) + 1)), ["E0007"]);
}

#[test]
fn pages_are_headed_by_code_and_explanation_and_say_what_to_do() {
    for code in error_codes() {
        let (title, text) = code.page.split_once('\n').unwrap_or_default();
        assert_eq!(title, format!("# {}: {}", code.code, code.explanation));
        assert!(text.trim().len() > 40, "{} says nothing", code.code);
    }
}

#[test]
fn the_index_lists_all_pages() {
    let index = include_str!("../../../docs/reference/codes/index.md");
    let rows: Vec<&str> = index.lines().filter(|line| line.starts_with("| [")).collect();
    let row = |code: &ErrorCode| {
        let explanation = code.explanation.replace('|', "&#124;");
        format!("| [{0}]({0}.md) | {explanation} |", code.code)
    };
    assert_eq!(rows, error_codes().iter().map(row).collect::<Vec<_>>());
}

#[test]
fn codes_are_found_in_any_spelling() {
    for text in ["E0203", "e0203", " E203 "] {
        assert_eq!(error_code(text).map(|code| code.code), Some("E0203"));
    }
    assert_eq!(error_code("E9999"), None);
    assert_eq!(error_code(""), None);
    assert_eq!(error_code("0203"), None);
}

#[test]
fn the_first_fix_of_an_example_makes_its_message_go_away() {
    let mut tried = 0;
    let mut wrongs = Vec::new();
    for code in error_codes().iter().filter(|code| code.code != "E0007") {
        let (kind, wrong) = example(code, code.page, "wrong");
        let before = if kind == "pdl" { checked(wrong) } else { continue };
        let about = before.diagnostics.iter().find(|diagnostic| diagnostic.code == code.code);
        let Some(fix) = about.and_then(|diagnostic| diagnostic.fixes.first()) else { continue };
        let mut edits = fix.edits.clone();
        edits.sort();
        let mut fixed = wrong.to_string();
        for edit in edits.iter().rev() {
            fixed.replace_range(edit.start as usize..edit.end as usize, &edit.replacement);
        }
        tried += 1;
        let after = checked(&fixed);
        if after.diagnostics.iter().any(|diagnostic| diagnostic.code == code.code) || after.has_errors() {
            let told: Vec<&str> = after.diagnostics.iter().map(|diagnostic| diagnostic.message.as_str()).collect();
            wrongs.push(format!("{}: after \"{}\": {told:?}\n{fixed}", code.code, fix.title));
        }
    }
    assert!(wrongs.is_empty(), "{}", wrongs.join("\n"));
    assert!(tried >= 15, "only {tried} examples have a fix");
}
