//! Evaluation: arithmetic, text, lists, limits. Expressions are built by hand; their text form belongs to the front end.

use super::*;
use crate::state::histories::history::Sample;
use crate::test_support::TestView;
use apex_model::event::StateVariable;
use apex_model::expression::{ExprKind, Parameters};
use apex_model::library::{Function, HostDeclaration};
use apex_model::quantity::{Quantity, unit_named};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use apex_model::time::{Duration, Time};
use std::sync::Arc;

fn expr(kind: ExprKind) -> Expr {
    Expr { kind, place: Place::default() }
}

fn value(value: Value) -> Expr {
    expr(ExprKind::Constant(value))
}

fn int(number: i64) -> Expr {
    value(Value::Integer(number))
}

fn real(number: f64) -> Expr {
    value(Value::Real(number))
}

fn text(text: &str) -> Expr {
    value(Value::text(text))
}

fn name(name: &str) -> Expr {
    value(Value::symbol(name))
}

fn local(name: &str) -> Expr {
    expr(ExprKind::Local(Symbol::new(name)))
}

fn seconds(seconds: f64) -> Expr {
    value(Value::Duration(Duration::from_seconds(seconds)))
}

fn unit(number: f64, name: &str) -> Expr {
    value(Value::Quantity(Quantity::of(number, unit_named(name).unwrap())))
}

fn call(function: &str, arguments: Vec<Expr>) -> Expr {
    expr(ExprKind::Call { function: Symbol::new(function), arguments })
}

fn list(items: Vec<Expr>) -> Expr {
    call("list", items)
}

fn lambda(parameters: &[&str], body: Expr) -> Expr {
    expr(ExprKind::Lambda {
        parameters: Parameters::fixed(parameters.iter().map(|name| Symbol::new(name))),
        body: vec![body],
    })
}

fn shown(expr: Expr) -> String {
    match evaluate(&expr, &TestView::default()) {
        Ok(value) => value.to_string(),
        Err(error) => format!("error: {}", error.message),
    }
}

#[test]
fn integers_stay_exact_or_say_that_they_cannot() {
    assert_eq!(shown(call("+", vec![int(1), int(2), int(3)])), "6");
    assert_eq!(shown(call("/", vec![int(6), int(3)])), "2");
    assert_eq!(shown(call("/", vec![int(7), int(2)])), "3.5");
    assert_eq!(shown(call("-", vec![int(5)])), "-5");
    assert_eq!(
        shown(call("+", vec![int(i64::MAX), int(1)])),
        "error: (+ ..): (+ 9223372036854775807 1) is too large for an integer; write one of them as a real number"
    );
    assert!(shown(call("*", vec![int(i64::MAX), int(2)])).contains("too large"));
    assert!(shown(call("/", vec![int(i64::MIN), int(-1)])).contains("too large"));
    assert_eq!(shown(call("/", vec![int(1), int(0)])), "error: (/ ..): division of 1 by zero");
    assert_eq!(shown(call("mod", vec![int(-7), int(3)])), "2");
    assert_eq!(shown(call("rem", vec![int(-7), int(3)])), "-1");
    assert_eq!(shown(call("mod", vec![int(i64::MIN), int(-1)])), "0");
    assert_eq!(shown(call("expt", vec![int(2), int(10)])), "1024");
}

#[test]
fn rounding_goes_where_its_name_says() {
    for (function, expected) in [("floor", [-3, 2]), ("ceiling", [-2, 3]), ("truncate", [-2, 2]), ("round", [-2, 2])] {
        for (number, expected) in [-5, 5].into_iter().zip(expected) {
            assert_eq!(
                shown(call(function, vec![int(number), int(2)])),
                expected.to_string(),
                "({function} {number} 2)"
            );
            assert_eq!(shown(call(function, vec![real(number as f64 / 2.0)])), expected.to_string());
        }
    }
    assert_eq!(shown(call("floor", vec![unit(350.0, "ft"), unit(100.0, "ft")])), "3");
    assert!(shown(call("floor", vec![unit(3.5, "ft")])).contains("3.5ft (length)"));
    assert!(shown(call("round", vec![real(1e300)])).contains("too large"));
}

#[test]
fn dimensions_are_checked_and_combined() {
    assert_eq!(shown(call("+", vec![unit(100.0, "ft"), unit(1.0, "nm")])), "6176.11548556ft");
    assert_eq!(
        shown(call("+", vec![unit(5.0, "ft"), seconds(2.0)])),
        "error: (+ ..): cannot add 5ft (length) and P2S (time)"
    );
    assert_eq!(
        shown(call("-", vec![unit(5.0, "ft"), int(3)])),
        "error: (- ..): cannot subtract 5ft (length) and 3 (a pure number)"
    );
    assert_eq!(shown(call("/", vec![unit(10.0, "m"), seconds(4.0)])), "2.5m/s");
    assert_eq!(shown(call("*", vec![unit(10.0, "m/s"), seconds(4.0)])), "40m");
    assert_eq!(shown(call("/", vec![unit(12.0, "m"), unit(4.0, "m")])), "3.0");
    assert_eq!(shown(call("*", vec![int(2), unit(35.0, "kt")])), "70kt");
    assert_eq!(shown(call("sqrt", vec![call("*", vec![unit(4.0, "m"), unit(4.0, "m")])])), "4m");
    assert_eq!(shown(call("in-unit", vec![unit(1.0, "nm"), name("m")])), "1852.0");
    assert_eq!(shown(call("quantity", vec![int(90), name("s")])), "P1M30S");
    assert_eq!(shown(call("<", vec![unit(1.0, "km"), unit(1.0, "nm"), unit(2.0, "mi")])), "t");
    assert!(
        shown(call("<", vec![unit(1.0, "km"), int(4)])).contains("cannot compare 1km (length) with 4 (a pure number)")
    );
    assert!(shown(call("=", vec![unit(1.0, "km"), int(1)])).contains("cannot compare"));
    assert_eq!(shown(call("<", vec![unit(1.0, "km"), value(Value::Real(f64::INFINITY))])), "t");
}

#[test]
fn time_points_and_durations_add_as_usual() {
    let start = value(Value::Time(Time::from_seconds(100.0)));
    assert_eq!(shown(call("+", vec![start.clone(), seconds(45.0)])), "0:02:25");
    assert_eq!(shown(call("-", vec![call("+", vec![start.clone(), seconds(45.0)]), start.clone()])), "P45S");
    assert!(shown(call("+", vec![start.clone(), start])).contains("an instant"));
    assert_eq!(shown(call("*", vec![seconds(1.5), int(3)])), "P4.5S");
    assert_eq!(shown(call("/", vec![seconds(9.0), seconds(4.0)])), "2.25");
    assert_eq!(shown(call("/", vec![seconds(9.0), int(3)])), "P3S");
}

#[test]
fn two_is_two_point_zero_and_nothing_equals_not_a_number() {
    assert_eq!(shown(call("=", vec![int(2), real(2.0)])), "t");
    assert_eq!(shown(call("=", vec![real(f64::NAN), real(f64::NAN)])), "nil");
    assert_eq!(shown(call("<", vec![real(f64::NAN), int(1)])), "nil");
    assert_eq!(shown(call("/=", vec![int(1), int(2), real(1.0)])), "nil");
    assert_eq!(shown(call("max", vec![int(1), real(2.5), int(2)])), "2.5");
}

#[test]
fn lists_are_zero_based_and_missing_items_are_nil() {
    let abc = || list(vec![name("a"), name("b"), name("c")]);
    assert_eq!(shown(call("nth", vec![int(1), abc()])), "b");
    assert_eq!(shown(call("nth", vec![int(7), abc()])), "nil");
    assert_eq!(shown(call("elt", vec![abc(), int(2)])), "c");
    assert_eq!(shown(call("rest", vec![abc()])), "(b c)");
    assert_eq!(shown(call("last", vec![abc()])), "(c)");
    assert_eq!(shown(call("append", vec![abc(), list(vec![int(1)])])), "(a b c 1)");
    assert_eq!(shown(call("member", vec![name("B"), abc()])), "(b c)");
    assert_eq!(shown(call("subseq", vec![abc(), int(1), int(2)])), "(b)");
    assert!(shown(call("subseq", vec![abc(), int(2), int(1)])).contains("does not lie within"));
    assert_eq!(shown(call("range", vec![int(1), int(8), int(3)])), "(1 4 7)");
    assert!(shown(call("range", vec![int(1), int(8), int(0)])).contains("never ends"));
    assert!(shown(call("range", vec![int(0), int(i64::MAX)])).contains("LIST_ITEMS_MAX"));
    assert_eq!(shown(call("getf", vec![list(vec![name(":a"), int(1), name(":b"), int(2)]), name(":b")])), "2");
    assert_eq!(shown(call("remove-duplicates", vec![list(vec![int(1), real(1.0), int(2)])])), "(1 2)");
    assert!(shown(call("first", vec![int(3)])).contains("expected a list, found 3"));
}

#[test]
fn functions_are_values() {
    let numbers = || list(vec![int(3), int(1), int(2)]);
    let double = || lambda(&["x"], call("*", vec![local("x"), int(2)]));
    assert_eq!(shown(call("mapcar", vec![double(), numbers()])), "(6 2 4)");
    assert_eq!(shown(call("mapcar", vec![name("+"), numbers(), numbers()])), "(6 2 4)");
    assert_eq!(shown(call("sort", vec![numbers(), name("<")])), "(1 2 3)");
    assert_eq!(shown(call("sort", vec![numbers(), name(">"), name(":key"), double()])), "(3 2 1)");
    assert_eq!(shown(call("reduce", vec![name("+"), numbers()])), "6");
    assert_eq!(shown(call("reduce", vec![name("max"), numbers(), int(9)])), "9");
    assert_eq!(shown(call("remove-if-not", vec![name("oddp"), numbers()])), "(3 1)");
    assert_eq!(shown(call("every", vec![name("plusp"), numbers()])), "t");
    assert_eq!(shown(call("some", vec![name("minusp"), numbers()])), "nil");
    assert_eq!(shown(call("apply", vec![name("-"), int(10), numbers()])), "4");
    let captured = expr(ExprKind::Let {
        sequential: true,
        bindings: vec![(Symbol::new("n"), int(10)), (Symbol::new("m"), call("1+", vec![local("n")]))],
        body: vec![call("mapcar", vec![lambda(&["x"], call("+", vec![local("x"), local("m")])), numbers()])],
    });
    assert_eq!(shown(captured), "(14 12 13)");
}

#[test]
fn sorting_is_stable() {
    let pairs = (0..20).map(|index| list(vec![int(index % 3), int(index)])).collect();
    let sorted = evaluate(&call("sort", vec![list(pairs), name("<"), name("first")]), &TestView::default()).unwrap();
    let mut expected: Vec<(i64, i64)> = (0..20).map(|index| (index % 3, index)).collect();
    expected.sort_by_key(|(key, _)| *key);
    let expected = Value::list(expected.iter().map(|(a, b)| Value::list([Value::Integer(*a), Value::Integer(*b)])));
    assert_eq!(sorted, expected);
}

#[test]
fn format_knows_its_directives() {
    let format = |control: &str, mut arguments: Vec<Expr>| {
        arguments.insert(0, text(control));
        evaluate(&call("format", arguments), &TestView::default())
            .map(|value| display(&value))
            .map_err(|error| error.message)
    };
    assert_eq!(format("~a and ~s~%", vec![text("x"), text("x")]).unwrap(), "x and \"x\"\n");
    assert_eq!(format("~,2f|~6,1f|~4d|~~", vec![real(3.14259), int(2), int(7)]).unwrap(), "3.14|   2.0|   7|~");
    assert_eq!(format("~f", vec![unit(35.0, "kt")]).unwrap(), "35");
    assert!(format("~a", vec![]).unwrap_err().contains("more arguments"));
    assert!(format("~q", vec![]).unwrap_err().contains("~q is not a directive"));
    assert!(format("~", vec![]).unwrap_err().contains("ends within"));
    assert!(format("~9999999d", vec![int(1)]).unwrap_err().contains("at most 200"));
    assert_eq!(shown(call("format", vec![value(Value::nil()), text("~a"), int(1)])), "\"1\"");
}

#[test]
fn text_counts_characters_not_bytes() {
    assert_eq!(shown(call("length", vec![text("Küste")])), "5");
    assert_eq!(shown(call("substring", vec![text("Küste"), int(1), int(3)])), "\"üs\"");
    assert_eq!(shown(call("search-string", vec![text("te"), text("Küste")])), "3");
    assert_eq!(shown(call("concatenate", vec![text("a"), int(1), name("B")])), "\"a1B\"");
}

#[test]
fn recursion_and_loops_end_with_a_reason() {
    let mut view = TestView::default();
    let endless = Function {
        parameters: Parameters::fixed([Symbol::new("n")]),
        body: vec![call("endless", vec![call("1+", vec![local("n")])])],
        pure: true,
        place: Place::default(),
    };
    view.library.functions.insert(Symbol::new("endless"), endless);
    let error = evaluate(&call("endless", vec![int(0)]), &view).unwrap_err();
    assert!(error.message.contains("EVALUATION_DEPTH_MAX"), "{}", error.message);
    let many = call("range", vec![int(0), int(2000)]);
    let inner = lambda(&["y"], call("reduce", vec![name("+"), many.clone()]));
    let work = call("mapcar", vec![lambda(&["x"], call("mapcar", vec![inner, many.clone()])), many]);
    assert!(shown(work).contains("EVALUATION_STEPS_MAX"));
    let doubling = call(
        "reduce",
        vec![lambda(&["x", "i"], list(vec![local("x"), local("x")])), call("range", vec![int(0), int(60)]), int(1)],
    );
    let value = evaluate(&doubling, &TestView::default()).unwrap();
    assert!(display(&value).ends_with(".."));
}

#[test]
fn indexicals_follow_time_and_definitions() {
    let mut view = TestView { now: Time::from_seconds(7.0), ..TestView::default() };
    view.library.indexicals.insert(Symbol::new("limit"), call("*", vec![int(2), int(21)]));
    let circular = expr(ExprKind::Indexical(Symbol::new("loop")));
    view.library.indexicals.insert(Symbol::new("loop"), circular.clone());
    let shown = |name: &str| {
        evaluate(&expr(ExprKind::Indexical(Symbol::new(name))), &view)
            .map(|value| value.to_string())
            .unwrap_or_else(|error| error.message)
    };
    assert_eq!(shown("limit"), "42");
    assert_eq!((shown("now").as_str(), shown("met").as_str(), shown("self").as_str()), ("7s", "P7S", "pilot"));
    assert_eq!(shown("this-task"), "T1");
    assert!(shown("loop").contains("EVALUATION_DEPTH_MAX"));
    assert!(shown("nowhere").contains("+nowhere+ is not defined"));
}

#[test]
fn histories_answer_strictly_or_inclusively_and_never_wrongly() {
    let mut view = TestView { now: Time::from_seconds(30.0), ..TestView::default() };
    let roll = StateVariable::new(Symbol::new("roll"), Value::symbol("uav"));
    view.histories.require_lookback(&Symbol::new("roll"), Duration::from_seconds(15.0));
    for at in [0, 10, 20, 30] {
        let sample =
            Sample { at: Time::from_seconds(f64::from(at)), sequence: 0, value: Value::Integer(i64::from(at)) };
        view.histories.record(&roll, sample, Duration::ZERO);
    }
    let query = |function: &str, rest: Vec<Expr>| {
        let mut arguments = vec![name("roll"), name("uav")];
        arguments.extend(rest);
        evaluate(&call(function, arguments), &view).map(|value| value.to_string()).unwrap_or_else(|error| error.message)
    };
    let at = |seconds: f64| value(Value::Time(Time::from_seconds(seconds)));
    assert_eq!(query("value-at", vec![at(20.0)]), "20");
    assert_eq!(query("value-before", vec![at(20.0)]), "10");
    assert_eq!(query("most-recent-svvalue", vec![name(":prior-to"), at(20.0)]), "10");
    assert_eq!(query("current-value", vec![]), "30");
    assert_eq!(query("mean-over", vec![seconds(10.0)]), "25.0");
    assert_eq!(query("max-over", vec![at(10.0), at(25.0)]), "20");
    assert_eq!(query("samples-over", vec![seconds(5.0)]), "((30s 30))");
    assert!(query("value-at", vec![at(5.0)]).contains("no longer kept"));
    assert!(query("mean-over", vec![seconds(30.0)]).contains("no longer kept"));
    let other = call("current-value", vec![name("roll"), name("other")]);
    assert_eq!(evaluate(&other, &view).unwrap().to_string(), "nil");
}

#[test]
fn hooks_collect_actions_and_conditions_may_not_act() {
    let mut view = TestView::default();
    let declaration = HostDeclaration { parameters: vec![], pure: false, command: true, place: Place::default() };
    view.library.host_functions.insert(Symbol::new("fly-to"), declaration);
    view.host.register(
        "triple",
        Arc::new(|values| match values {
            [Value::Integer(n)] => Ok(Value::Integer(n * 3)),
            _ => Err("triple takes an integer".into()),
        }),
    );
    let mut locals = Bindings::new();
    locals.set(Symbol::new("count"), Value::Integer(1));
    let forms = [
        expr(ExprKind::Assign {
            name: Symbol::new("count"),
            of_task: false,
            value: Box::new(call("1+", vec![local("count")])),
        }),
        expr(ExprKind::Assign {
            name: Symbol::new("x"),
            of_task: true,
            value: Box::new(call("triple", vec![local("count")])),
        }),
        call("print", vec![text("x is"), expr(ExprKind::Variable { name: Symbol::new("x"), must_be_bound: false })]),
        call("fly-to", vec![int(1)]),
        call("publish", vec![value(Value::list([Value::symbol("altitude"), Value::symbol("uav")])), int(4)]),
        call("complete", vec![name("done")]),
    ];
    let mut actions = Vec::new();
    run(&forms, &view, &mut locals, &mut actions).unwrap();
    assert_eq!(locals.get(&Symbol::new("count")), Some(&Value::Integer(2)));
    assert_eq!(
        actions,
        [
            Action::SetTaskVariable(Symbol::new("x"), Value::Integer(6)),
            Action::Print("x is 6".into()),
            Action::Command {
                form: Value::list([Value::symbol("fly-to"), Value::Integer(1)]),
                timeout: None,
                place: Place::default()
            },
            Action::Publish {
                variable: StateVariable::new(Symbol::new("altitude"), Value::symbol("uav")),
                value: Value::Integer(4),
                router: None,
                place: Place::default(),
            },
            Action::Complete(Value::symbol("done")),
        ]
    );
    assert!(evaluate(&forms[3], &view).unwrap_err().message.contains("is allowed in hooks only"));
    let assign = expr(ExprKind::Assign { name: Symbol::new("x"), of_task: true, value: Box::new(int(1)) });
    assert!(evaluate(&assign, &view).unwrap_err().message.contains("is allowed in hooks only"));
    assert!(evaluate(&call("triple", vec![]), &view).unwrap_err().message.contains("triple takes an integer"));
}

#[test]
fn every_built_in_function_is_evaluated_here() {
    // A wrong argument may be refused, but never as a function that does not exist.
    let mut view = TestView::default();
    view.tasks.insert(TaskId(1), Default::default());
    for built_in in apex_model::builtins::BUILT_INS {
        let most = built_in.arguments_max.unwrap_or(built_in.arguments_min + 1);
        for count in built_in.arguments_min..=most {
            let arguments = vec![int(1); count];
            let mut actions = Vec::new();
            let result = run(&[call(built_in.name, arguments)], &view, &mut Bindings::new(), &mut actions);
            let refused = matches!(&result, Err(error) if error.message.contains("does not take these arguments"));
            let keyword_wanted =
                matches!((built_in.name, count), ("most-recent-svvalue", 3 | 4) | ("command", 2 | 3) | ("sort", 4));
            assert!(!refused || keyword_wanted, "{} with {count} arguments: {result:?}", built_in.name);
        }
    }
}

#[test]
fn templates_fill_their_holes_or_show_them() {
    let mut view = TestView::default();
    view.variables.set(Symbol::new("loc"), Value::list([Value::Integer(1), Value::Integer(2)]));
    let hole = |name: &str| expr(ExprKind::Variable { name: Symbol::new(name), must_be_bound: false });
    let template = Template::List(vec![
        Template::Constant(Value::symbol("fly-to")),
        Template::Splice(hole("loc")),
        Template::Hole(hole("speed")),
    ]);
    assert_eq!(instantiate_partially(&template, &view).to_string(), "(fly-to 1 2 ?speed)");
    assert_eq!(instantiate(&template, &view).unwrap_err().message, "?speed has no value here");
    view.variables.set(Symbol::new("speed"), Value::Integer(9));
    assert_eq!(instantiate(&template, &view).unwrap().to_string(), "(fly-to 1 2 9)");
}

#[test]
fn a_host_function_that_panics_has_failed() {
    let mut view = TestView::default();
    view.host.register("lookup", Arc::new(|arguments: &[Value]| Ok(arguments[7].clone())));
    let error = evaluate(&call("lookup", vec![int(1)]), &view).unwrap_err();
    assert!(error.message.contains("panicked: index out of bounds"), "{}", error.message);
    view.host.register("refuse", Arc::new(|_: &[Value]| panic!("no such aircraft")));
    let error = evaluate(&call("refuse", vec![]), &view).unwrap_err();
    assert!(
        error.message.contains("panicked: no such aircraft; this is a fault of that function"),
        "{}",
        error.message
    );
}
