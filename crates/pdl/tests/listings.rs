//! The checker accepts the listings and Table 1 of the paper as printed.

use apex_model::condition::{ConditionKind, Constraint};
use apex_model::pattern::Pattern;
use apex_model::procedure::Activity;
use apex_pdl::{CheckOptions, Checked, ParsedCondition, Severity, SourceText, check, parse_condition, render};

fn fragment(name: &str, text: &str) -> Checked {
    let source = SourceText { name: name.to_string(), text: text.to_string() };
    let mut resolve = |_| Err("a fragment has no libraries".into());
    check(vec![source], CheckOptions { fragment: true, host: &[], resolve: &mut resolve })
}

fn condition(text: &str) -> ParsedCondition {
    let mut resolve = |_| Err("none".into());
    parse_condition(text, CheckOptions { fragment: true, host: &[], resolve: &mut resolve })
}

fn loads(name: &str, text: &str) -> Checked {
    let checked = fragment(name, text);
    assert!(!checked.has_errors(), "{}", render(&checked.diagnostics, &checked.library.sources, false));
    checked
}

#[test]
fn every_listing_loads_as_a_fragment() {
    for (name, text, procedures, primitives) in [
        ("camera.pdl", include_str!("listings/camera.pdl"), 1, 0),
        ("xplane.pdl", include_str!("listings/xplane.pdl"), 0, 1),
        ("xplane-checked.pdl", include_str!("listings/xplane-checked.pdl"), 0, 1),
        ("refly.pdl", include_str!("listings/refly.pdl"), 1, 0),
        ("regain.pdl", include_str!("listings/regain.pdl"), 1, 0),
    ] {
        let checked = loads(name, text);
        assert_eq!(
            (checked.library.procedures.len(), checked.library.primitives.len()),
            (procedures, primitives),
            "{name}"
        );
    }
}

/// The listing of section IV as printed: a step with its select, outside of a procedure.
const REFLY_ALONE: &str = "(step (refly segment visited from ?loc to +current-location+)
  (waitfor
    (:episode roll-violation (roll-angle +this-aircraft+)
      :value (> +max-roll-angle-deviation+)
      :timing
        (:duration (> +max-off-nominal-roll-angle-duration+)))
    :quality (:no-constraints)))
(select ?loc
  (most-recent-SVvalue 'location +this-aircraft+
    :prior-to (start ?roll-violation)))";

#[test]
fn clauses_outside_of_a_procedure_load_as_a_fragment_only() {
    let checked = loads("refly-alone.pdl", REFLY_ALONE);
    let step = &checked.library.procedures[0].steps[0];
    assert!(step.select[0].0.is("loc"));
    let index = "(index (enable measurement (?is ?variable valid-variable-p)))";
    assert_eq!(loads("index.pdl", index).library.procedures.len(), 1);
    let both = format!("{REFLY_ALONE}\n{index}\n{}", TABLE_1.join("\n"));
    let unsupported = |each: &&apex_pdl::Diagnostic| each.severity == Severity::Error;
    assert_eq!(fragment("all.pdl", &both).diagnostics.iter().find(unsupported).map(|each| &each.message), None);
    let mut resolve = |_| Err("none".into());
    let source = SourceText { name: "whole.pdl".to_string(), text: REFLY_ALONE.to_string() };
    let whole = check(vec![source], CheckOptions { fragment: false, host: &[], resolve: &mut resolve });
    assert!(whole.has_errors(), "a whole application has no loose clauses");
}

#[test]
fn a_mistake_inside_of_a_loose_clause_is_still_reported() {
    let checked = fragment("loose.pdl", "(step a (print 1)\n  (waitfr (ready camera-1)))\n(procedur (index (x)))");
    let places: Vec<u32> =
        checked.diagnostics.iter().filter(|each| each.severity == Severity::Error).map(|each| each.span.line).collect();
    assert_eq!(places, [2, 3]);
}

#[test]
fn the_camera_procedure_means_what_the_paper_says() {
    let library = loads("camera.pdl", include_str!("listings/camera.pdl")).library;
    let procedure = &library.procedures[0];
    assert_eq!(procedure.steps.len(), 4);
    assert_eq!(procedure.steps[0].binds.as_deref(), Some(&Pattern::Variable("loc".into())));
    let Activity::Goal(goal) = &procedure.steps[0].activity else { panic!("s1 pursues a goal") };
    assert!(!format!("{goal:?}").contains("=>"));
    let ConditionKind::And(parts, _) = &procedure.steps[2].waitfor[0].kind else { panic!("s3 waits for two things") };
    let ConditionKind::Measurement(location) = &parts[1].kind else { panic!("the second is a measurement") };
    assert_eq!(location.value, [Constraint::Matches(Pattern::BoundVariable("loc".into()))]);
    assert!(matches!(&procedure.steps[3].waitfor[0].kind, ConditionKind::TaskEnded(tag) if tag.is("s3")));
    assert!(procedure.transitions.restart_when.is_some() && procedure.transitions.end_when.is_some());
}

#[test]
fn a_select_at_procedure_level_serves_the_step_before_it() {
    let library = loads("refly.pdl", include_str!("listings/refly.pdl")).library;
    let step = &library.procedures[0].steps[0];
    assert!(step.tag.is("refly"));
    assert!(step.select[0].0.is("loc"));
    assert!(step.waitfor[0].tag.as_ref().is_some_and(|tag| tag.is("roll-violation")));
}

/// Table 1 of the paper, row by row; the trend row without its misprint.
const TABLE_1: [&str; 13] = [
    "(temperature engine-1 = +setpoint+)",
    "(:measurement (temperature engine-1 = +setpoint+) :timestamp (< (start-of +this-task+)))",
    "(temperature engine-1 = +setpoint+ +/- 2)",
    "(:measurement (temperature ?engine = +setpoint+) :object (tracked-p))",
    "(:measurement (temperature engine-1 = +setpoint+) :estimation :persist)",
    "(:measurement (temperature engine-1 = +setpoint+) :estimation :linear-regression :timestamp (< (start-of +this-task+)))",
    "(:episode (temperature engine-1) :quality :no-constraints :value (> +setpoint+))",
    "(:episode (temperature engine-1) :quality :no-constraints :stats (:stddev (> 2.5)))",
    "(:episode (temperature engine-1) :quality :no-constraints :trend (:rate :non-decreasing))",
    "(:and (:or (temperature engine-1 > +setpoint+) (temperature engine-2 > +setpoint+)) (position flaps = up))",
    "(:in-order (temperature engine-1 > +setpoint+) (temperature engine-2 > +setpoint+))",
    "(:during (temperature engine-1 > +setpoint+) (:episode (altitude +self+) :quality :no-constraints :trend (:rate :decreasing)))",
    "(:atomic-episode (ready camera-1) :timing (< (start-of +this-task+)))",
];

#[test]
fn every_row_of_table_1_is_a_condition() {
    for text in TABLE_1 {
        let parsed = condition(text);
        assert!(parsed.condition.is_some(), "{text}: {:?}", parsed.diagnostics);
        assert!(parsed.diagnostics.iter().all(|each| each.severity != Severity::Error), "{text}");
    }
}

#[test]
fn the_misprint_of_the_trend_row_is_named_and_the_row_loads() {
    let parsed =
        condition("(:episode (temperature engine-1) :quality :no-constraints :trend (:rate :non-decreasing)))");
    assert!(parsed.condition.is_some());
    let flaw = parsed.diagnostics.iter().find(|each| each.code == "E0001").unwrap();
    assert_eq!((flaw.message.as_str(), flaw.severity), ("superfluous `)`", Severity::Warning));
    assert_eq!((flaw.span.line, flaw.span.column), (1, 90));
}
