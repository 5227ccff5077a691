//! The matcher against the definition: all matches in order, by plain recursion over lists of bindings.

use crate::monitoring::pattern_matching::match_pattern;
use crate::monitoring::specificity::specificity;
use crate::state::bindings::Bindings;
use crate::test_support::TestView;
use apex_model::expression::{Expr, ExprKind};
use apex_model::pattern::Pattern;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use proptest::prelude::*;

fn variable(name: &str) -> Pattern {
    Pattern::Variable(Symbol::new(name))
}

fn literal(name: &str) -> Pattern {
    Pattern::Literal(Value::symbol(name))
}

fn segment(name: &str, minimum: u8, maximum: Option<u8>) -> Pattern {
    Pattern::Segment { variable: Some(Symbol::new(name)), minimum, maximum }
}

/// Returns all matches in order, by plain recursion over lists of bindings: the definition.
fn naive(pattern: &Pattern, value: &Value, bindings: &Bindings) -> Vec<Bindings> {
    match pattern {
        Pattern::Literal(literal) if literal.matches(value) => vec![bindings.clone()],
        Pattern::Anonymous => vec![bindings.clone()],
        Pattern::Variable(name) | Pattern::BoundVariable(name) => naive_bind(name, value, bindings),
        Pattern::Guard(test) if naive_test(test, bindings) => vec![bindings.clone()],
        Pattern::Is { variable, predicate } => {
            let number = matches!(value, Value::Integer(_));
            assert!(predicate.is("integerp"));
            if number { naive_bind(variable, value, bindings) } else { Vec::new() }
        }
        Pattern::And(parts) => parts.iter().fold(vec![bindings.clone()], |found, part| {
            found.iter().flat_map(|bindings| naive(part, value, bindings)).collect()
        }),
        Pattern::Or(parts) => parts.iter().flat_map(|part| naive(part, value, bindings)).collect(),
        Pattern::Not(part) if naive(part, value, bindings).is_empty() => vec![bindings.clone()],
        Pattern::List(parts) => match value.as_list() {
            Some(values) => naive_list(parts, values, bindings),
            None => Vec::new(),
        },
        _ => Vec::new(),
    }
}

fn naive_bind(name: &Symbol, value: &Value, bindings: &Bindings) -> Vec<Bindings> {
    match bindings.get(name) {
        Some(bound) if bound.matches(value) => vec![bindings.clone()],
        Some(_) => Vec::new(),
        None => {
            let mut extended = bindings.clone();
            extended.set(name.clone(), value.clone());
            vec![extended]
        }
    }
}

fn naive_list(parts: &[Pattern], values: &[Value], bindings: &Bindings) -> Vec<Bindings> {
    let Some((first, rest)) = parts.split_first() else {
        return if values.is_empty() { vec![bindings.clone()] } else { Vec::new() };
    };
    if let Pattern::Guard(test) = first {
        return if naive_test(test, bindings) { naive_list(rest, values, bindings) } else { Vec::new() };
    }
    if let Pattern::Segment { variable, minimum, maximum } = first {
        let most = maximum.map_or(values.len(), usize::from).min(values.len());
        return (usize::from(*minimum)..=most)
            .flat_map(|count| {
                let taken = Value::list(values[..count].iter().cloned());
                let bound = match variable {
                    Some(name) => naive_bind(name, &taken, bindings),
                    None => vec![bindings.clone()],
                };
                bound.into_iter().flat_map(move |bindings| naive_list(rest, &values[count..], &bindings))
            })
            .collect();
    }
    let Some((value, left)) = values.split_first() else { return Vec::new() };
    naive(first, value, bindings).iter().flat_map(|bindings| naive_list(rest, left, bindings)).collect()
}

/// Returns the truth of `(equalp ?x ?y)`, `(integerp ?x)` or `(listp ?y)`; both variables have values.
fn naive_test(test: &Expr, bindings: &Bindings) -> bool {
    let ExprKind::Call { function, arguments } = &test.kind else { return false };
    let of = |expr: &Expr| match &expr.kind {
        ExprKind::Variable { name, .. } => bindings.get(name).cloned().unwrap(),
        _ => Value::nil(),
    };
    let values: Vec<Value> = arguments.iter().map(of).collect();
    match function.folded() {
        "equalp" => values[0].matches(&values[1]),
        "integerp" => matches!(values[0], Value::Integer(_)),
        _ => values[0].as_list().is_some(),
    }
}

fn guards() -> impl Strategy<Value = Pattern> {
    prop_oneof![Just(("equalp", vec!["x", "y"])), Just(("integerp", vec!["x"])), Just(("listp", vec!["y"]))].prop_map(
        |(function, names)| {
            let variable = |name| Expr {
                kind: ExprKind::Variable { name: Symbol::new(name), must_be_bound: false },
                place: Place::default(),
            };
            let arguments = names.into_iter().map(variable).collect();
            let kind = ExprKind::Call { function: Symbol::new(function), arguments };
            Pattern::Guard(Expr { kind, place: Place::default() })
        },
    )
}

fn values() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        (0..3_i64).prop_map(Value::Integer),
        (0..3_i64).prop_map(|n| Value::Real(n as f64)),
        prop_oneof![Just("a"), Just("B")].prop_map(Value::symbol),
        prop_oneof![Just("Up"), Just("UP")].prop_map(Value::text),
    ];
    leaf.prop_recursive(3, 24, 5, |inner| proptest::collection::vec(inner, 0..5).prop_map(Value::list))
}

fn patterns() -> impl Strategy<Value = Pattern> {
    let name = || prop_oneof![Just("x"), Just("y")].prop_map(Symbol::new);
    let leaf = prop_oneof![
        values().prop_map(Pattern::Literal),
        name().prop_map(Pattern::Variable),
        Just(Pattern::Anonymous),
        name().prop_map(|variable| Pattern::Is { variable, predicate: Symbol::new("integerp") }),
    ];
    let segment = (proptest::option::of(name()), prop_oneof![Just((0, None)), Just((1, None)), Just((0, Some(1)))])
        .prop_map(|(variable, (minimum, maximum))| Pattern::Segment { variable, minimum, maximum });
    leaf.prop_recursive(3, 24, 4, move |inner| {
        let several = proptest::collection::vec(inner.clone(), 1..4);
        prop_oneof![
            4 => proptest::collection::vec(prop_oneof![3 => inner.clone(), 1 => segment.clone()], 0..4).prop_map(Pattern::List),
            1 => several.clone().prop_map(Pattern::And),
            1 => several.prop_map(Pattern::Or),
            1 => inner.prop_map(|part| Pattern::Not(Box::new(part))),
        ]
    })
}

/// Patterns over variables that have values already: with guards, and with `<?x>`.
fn guarded_patterns() -> impl Strategy<Value = Pattern> {
    let bound = prop_oneof![Just("x"), Just("y")].prop_map(|name| Pattern::BoundVariable(Symbol::new(name)));
    let part = prop_oneof![3 => patterns(), 1 => guards(), 1 => bound];
    let list = proptest::collection::vec(part.clone(), 0..5).prop_map(Pattern::List);
    prop_oneof![list, proptest::collection::vec(part, 1..4).prop_map(Pattern::And)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]
    #[test]
    fn guards_agree_with_the_naive_matcher(pattern in guarded_patterns(), x in values(), y in values(), value in values()) {
        let whole = Pattern::List(vec![variable("x"), variable("y"), pattern]);
        let value = Value::list([x, y, value]);
        let expected = naive(&whole, &value, &Bindings::new()).into_iter().next();
        let mut bindings = Bindings::new();
        let matched = match_pattern(&whole, &value, &mut bindings, &TestView::default(), Place::default()).unwrap();
        prop_assert_eq!(matched.then(|| bindings.clone()), expected);
    }

    #[test]
    fn a_constant_in_the_place_of_a_variable_is_never_less_specific(
        parts in proptest::collection::vec(patterns(), 0..4),
        at in 0_usize..5,
        constant in values(),
    ) {
        let at = at.min(parts.len());
        let with = |part: Pattern| {
            let mut all = parts.clone();
            all.insert(at, part);
            specificity(&Pattern::List(all))
        };
        prop_assert!(with(Pattern::Literal(constant)) > with(variable("z")));
    }

    #[test]
    fn agrees_with_the_naive_matcher(pattern in patterns(), value in values()) {
        let expected = naive(&pattern, &value, &Bindings::new()).into_iter().next();
        let mut bindings = Bindings::new();
        let matched = match_pattern(&pattern, &value, &mut bindings, &TestView::default(), Place::default()).unwrap();
        prop_assert_eq!(matched.then(|| bindings.clone()), expected);
        prop_assert!(matched || bindings.is_empty());
    }
}

#[test]
fn a_choice_inside_a_nested_list_is_taken_back_when_something_after_it_fails() {
    let pattern = Pattern::List(vec![Pattern::List(vec![segment("x", 0, None), segment("y", 0, None)]), variable("x")]);
    let inner = Value::list([Value::Integer(1), Value::Integer(2)]);
    let value = Value::list([inner, Value::list([Value::Integer(1)])]);
    let mut bindings = Bindings::new();
    assert!(match_pattern(&pattern, &value, &mut bindings, &TestView::default(), Place::default()).unwrap());
    assert_eq!(bindings.get(&Symbol::new("y")), Some(&Value::list([Value::Integer(2)])));
}

#[test]
fn hopeless_backtracking_ends_with_a_reason() {
    let parts = (0..8).map(|index| segment(&format!("s{index}"), 0, None)).chain([literal("never")]).collect();
    let value = Value::list((0..40).map(Value::Integer));
    let result =
        match_pattern(&Pattern::List(parts), &value, &mut Bindings::new(), &TestView::default(), Place::default());
    assert!(result.unwrap_err().message.contains("MATCH_STEPS_MAX"));
}

#[test]
fn long_lists_without_segments_stay_within_the_limit() {
    let parts = (0..40_000).map(|index| Pattern::Literal(Value::Integer(index))).collect();
    let value = Value::list((0..40_000).map(|index| Value::Real(index as f64)));
    assert!(
        match_pattern(&Pattern::List(parts), &value, &mut Bindings::new(), &TestView::default(), Place::default())
            .unwrap()
    );
}

#[test]
fn variables_bound_before_must_match() {
    let view = TestView {
        variables: {
            let mut b = Bindings::new();
            b.set(Symbol::new("x"), Value::text("UP"));
            b
        },
        ..TestView::default()
    };
    let mut bindings = Bindings::new();
    let mut matched =
        |pattern: &Pattern, value: Value| match_pattern(pattern, &value, &mut bindings, &view, Place::default());
    assert!(matched(&variable("x"), Value::text("up")).unwrap());
    assert!(!matched(&variable("x"), Value::text("down")).unwrap());
    assert!(
        matched(&Pattern::BoundVariable(Symbol::new("y")), Value::Integer(1)).unwrap_err().message.contains("<?y>")
    );
}
