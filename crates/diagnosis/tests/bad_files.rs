//! Models and results that cannot be used: each error gives the place, the reason and advice.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "a test that cannot continue fails")]

use apex_diagnosis::{Model, Results};

const HEAD: &str = "\"format\": \"apex-diagnosis-1\", \"name\": \"m\"";
const A: &str = "{\"name\": \"a\", \"probability_per_hour\": 1e-4}";

fn model(components: &str, signals: &str, tests: &str) -> String {
    format!("{{{HEAD}, \"components\": [{components}], \"signals\": [{signals}], \"tests\": [{tests}]}}")
}

fn refused(text: &str) -> String {
    Model::parse("m.json", text).unwrap_err().to_string()
}

#[test]
fn models_that_cannot_be_used_are_refused_with_place_and_reason() {
    let test = "{\"name\": \"t\", \"needs\": [\"a\"]}";
    let rate = |rate: &str| model(&format!("{{\"name\": \"a\", \"probability_per_hour\": {rate}}}"), "", test);
    let circle = "{\"name\": \"s\", \"needs\": [\"r\"]}, {\"name\": \"r\", \"needs\": [\"a\", \"s\"]}";
    let pairs: Vec<String> = (0..10).map(|pair| format!("{{\"any_of\": [\"s{pair}\", \"a\"]}}")).collect();
    let cases = [
        ("{".to_string(), "m.json:1:1 cannot be read: EOF"),
        (
            model(A, "", test).replace("\"name\": \"m\"", "\"name\": 3"),
            "m.json:1:40 cannot be read: invalid type: integer `3`",
        ),
        (model("", "", test), "`components` is invalid: the model has no components"),
        (model(A, "", ""), "`tests` is invalid: the model has no tests"),
        (model(A, circle, test), "`signals[0].needs` is invalid: signals need each other in a circle: s -> r -> s"),
        (
            model(A, "", "{\"name\": \"t\", \"needs\": [\"bus\"]}"),
            "`tests[0].needs[0]` is invalid: `bus` is not a component or signal",
        ),
        (
            model(A, "", "{\"name\": \"t\", \"needs\": []}"),
            "`tests[0].needs` is invalid: `t` depends on nothing that can fail",
        ),
        (model(A, "", "{\"name\": \"a\", \"needs\": [\"a\"]}"), "`a` is declared twice, first as `components[0].name`"),
        (model(A, "", "{\"name\": \"T 1\", \"needs\": [\"a\"]}"), "`tests[0].name` is invalid: \"T 1\" is not a name"),
        (rate("-1e-4"), "`components[0].probability_per_hour` is invalid: the probability -0.0001 is not above 0"),
        (rate("1.5"), "the probability 1.5 is not above 0 and below 0.5"),
        (model("{\"name\": \"a\"}", "", test), "`components[0]` is invalid: `a` cannot fail"),
        (model(A, "", "{\"name\": \"t\", \"needs\": [{\"any_of\": [\"a\"]}]}"), "`any_of` names fewer than two"),
        (model(A, "", "{\"name\": \"t\", \"needs\": [{\"all\": [\"a\"]}]}"), "unknown field `all`"),
        (
            model(A, "", &format!("{{\"name\": \"t\", \"needs\": [{}]}}", pairs.join(","))),
            "`s0` is not a component or signal",
        ),
        (
            model(
                "{\"name\": \"a\", \"modes\": [{\"name\": \"x\", \"probability_per_hour\": 0.1, \"affects\": [\"q\"]}]}",
                "",
                test,
            ),
            "`components[0].modes[0].affects[0]` is invalid: `q` is not a signal or test",
        ),
        (
            model(A, "", test).replace("diagnosis-1", "diagnosis-9"),
            "`format` is invalid: expected \"apex-diagnosis-1\"",
        ),
    ];
    for (text, expected) in cases {
        let error = refused(&text);
        assert!(error.contains(expected), "{error}\nexpected {expected}");
    }
}

#[test]
fn redundancy_beyond_the_limit_is_refused() {
    let parts: Vec<String> =
        (0..20).map(|part| format!("{{\"name\": \"c{part}\", \"probability_per_hour\": 1e-4}}")).collect();
    let signals: Vec<String> = (0..10)
        .map(|pair| format!("{{\"name\": \"s{pair}\", \"needs\": [\"c{}\", \"c{}\"]}}", 2 * pair, 2 * pair + 1))
        .collect();
    let names: Vec<String> = (0..10).map(|pair| format!("\"s{pair}\"")).collect();
    let test = format!("{{\"name\": \"t\", \"needs\": [{{\"any_of\": [{}]}}]}}", names.join(","));
    let error = refused(&model(&parts.join(","), &signals.join(","), &test));
    assert!(error.contains("`tests[0].needs[0]` is invalid: its redundancy has more than 512 combinations"), "{error}");
}

#[test]
fn results_that_do_not_fit_the_model_are_refused() {
    let model = Model::parse("m.json", &model(A, "", "{\"name\": \"t\", \"needs\": [\"a\"]}")).unwrap();
    for (text, expected) in [
        ("{\"failed\": [\"u\"]}", "`failed[0]` is invalid: model `m` has no test `u`"),
        ("{\"failed\": [\"t\"], \"passed\": [\"t\"]}", "`failed[0]` is invalid: `t` already has an outcome"),
        ("{}", "it states no outcome of a test"),
        ("{\"failed\": \"t\"}", "r.json:1:14 cannot be read: invalid type: string"),
        ("{\"others\": \"fine\"}", "unknown variant `fine`"),
    ] {
        let error = Results::parse("r.json", text, &model).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}\nexpected {expected}");
    }
}
