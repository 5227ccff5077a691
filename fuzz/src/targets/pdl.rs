//! Texts of PDL: reading, checking, messages, fixes and layout.
//!
//! Properties: spans lie inside their text and at characters; a layout is stable; fixes can be applied.

use crate::planted;
use apex_pdl::{CheckOptions, Checked, SourceText, apply, check, format, render};

fn checked(text: &str) -> Checked {
    let source = SourceText { name: "fuzz.pdl".into(), text: text.into() };
    let mut resolve = |_| Err("nothing is required".into());
    check(vec![source], CheckOptions { fragment: true, host: &[], resolve: &mut resolve })
}

/// Runs the target.
pub(crate) fn run(bytes: &[u8]) {
    let Some(text) = super::text(bytes) else { return };
    let checked = checked(text);
    let shown = render(&checked.diagnostics, &checked.library.sources, false);
    assert_eq!(shown.is_empty(), checked.diagnostics.is_empty(), "messages are lost or invented");
    for diagnostic in &checked.diagnostics {
        let span = diagnostic.span;
        let source = checked.library.sources.get(span.file as usize).map_or("", |source| &*source.text);
        let cut = source.get(span.start as usize..span.end as usize);
        assert!(cut.is_some(), "the span {span:?} of `{}` is not inside the text", diagnostic.message);
        if planted::ARE_IN {
            // The bug: a column counts characters, a slice counts bytes.
            let line = source.lines().nth(span.line as usize - 1).unwrap_or_default();
            let _ = &line[span.column as usize - 1..];
        }
    }
    let fixes: Vec<_> = checked.diagnostics.iter().flat_map(|diagnostic| &diagnostic.fixes).collect();
    apply(&checked.library.sources, fixes);
    if let Ok(laid_out) = format(text) {
        let again = format(&laid_out).map(|again| again == laid_out);
        assert!(matches!(again, Ok(true)), "the layout of the layout differs:\n{laid_out}");
    }
}
