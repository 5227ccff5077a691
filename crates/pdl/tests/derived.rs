//! Declarations of derived state variables that are rejected, and the messages about them.

use apex_pdl::{CheckOptions, SourceText, check, render};

fn messages(text: &str) -> String {
    let source = SourceText { name: "derived.pdl".to_string(), text: text.to_string() };
    let mut resolve = |_| Err("nothing is required".into());
    let checked = check(vec![source], CheckOptions { fragment: false, host: &[], resolve: &mut resolve });
    render(&checked.diagnostics, &checked.library.sources, false)
}

#[test]
fn what_cannot_be_computed_is_refused_with_its_reason() {
    for (text, expected) in [
        ("(state-variable (e ?a) :derived (- (x ?a) (y ?a)))", "and has no `:join`"),
        ("(state-variable (e ?a) :derived (- 3 2))", "reads no state variable of `?a`"),
        ("(state-variable (e ?a) :derived (x uav))", "reads no state variable of `?a`"),
        ("(state-variable (e ?a) :derived (x ?b))", "the object of an input is `?a` or a name"),
        ("(state-variable (e ?a) :derived (abs (e ?a)))", "`e` is derived from itself"),
        (
            "(state-variable (e ?a) :derived (abs (f ?a))) (state-variable (f ?a) :derived (abs (e ?a)))",
            "is derived from itself",
        ),
        ("(state-variable (e uav) :derived (abs (x ?a)))", "has one object variable"),
        ("(state-variable (e ?a) :derived (rate-of 5))", "a state variable is written as `(ATTRIBUTE OBJECT)`"),
        ("(state-variable (e ?a) :derived (rate-of))", "`rate-of` takes one state variable"),
        (
            "(state-variable (e ?a) :derived (x ?a) :join (:hold 0s))",
            "the limit of `:join` is P0S, expected a duration above zero",
        ),
        ("(state-variable (e ?a) :derived (x ?a) :join (:spline 1s))", "this is not a join"),
        ("(state-variable (e ?a) :join :hold)", "`:join` is given without `:derived`"),
        ("(state-variable (e ?a) :derived (asb (x ?a)))", "`asb`"),
        ("(state-variable (e ?a) :derived (abs (x ?a) ?b))", "nothing binds `?b`"),
        ("(state-variable (e ?a) :derived (progn (print 1) (x ?a)))", "a derived state variable"),
    ] {
        let said = messages(text);
        assert!(said.contains(expected), "{text}\n{said}");
    }
}

#[test]
fn derivations_join_keep_places_and_are_ranked() {
    let text = "(state-variable (a ?o) :derived (let ((low (b ?o))) (if (> low 0) (previous (x ?o)) (value-of (min ?o)))) :join :hold)
        (state-variable (b ?o) :derived (rate-of (x ?o)))";
    assert_eq!(messages(text), "");
}
