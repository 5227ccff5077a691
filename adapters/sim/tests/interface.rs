//! The commands of the simulator equal the declarations in `library/interface.pdl`, argument by argument.

#![allow(clippy::expect_used, reason = "a test stops at an unexpected result")]

use apex_model::interface::InterfaceDeclaration;
use apex_pdl::{CheckOptions, SourceText, check};
use std::collections::BTreeMap;

/// Name, fewest and most arguments, sorted options.
type Form = (String, (usize, usize), Vec<String>);

fn declared(name: &str, declaration: &InterfaceDeclaration) -> Form {
    let mut options: Vec<String> =
        declaration.options.iter().map(|option| option.name.folded().trim_start_matches(':').to_string()).collect();
    options.sort();
    (name.to_string(), (declaration.required, declaration.parameters.len()), options)
}

#[test]
fn the_simulator_takes_what_the_interface_declares() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../library/interface.pdl");
    let text = std::fs::read_to_string(path).expect("the interface is there");
    let source = SourceText { name: "interface.pdl".into(), text };
    let mut resolve = |_| Err("the interface requires nothing".into());
    let checked = check(vec![source], CheckOptions { fragment: false, host: &[], resolve: &mut resolve });
    assert!(!checked.has_errors(), "{}", apex_pdl::render(&checked.diagnostics, &checked.library.sources, false));
    let declarations = checked.library.commands.iter();
    let declared: BTreeMap<String, Form> = declarations
        .map(|(name, declaration)| (name.folded().to_string(), declared(name.folded(), declaration)))
        .collect();
    let taken: BTreeMap<String, Form> = apex_sim::command_forms()
        .map(|(name, arguments, keywords)| {
            let mut options: Vec<String> = keywords.iter().map(|keyword| (*keyword).to_string()).collect();
            options.sort();
            (name.to_string(), (name.to_string(), arguments, options))
        })
        .collect();
    assert_eq!(declared, taken, "declared, and what the simulator takes");
}
