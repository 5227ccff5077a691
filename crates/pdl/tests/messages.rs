//! Messages for authors: every message in full. A change of wording is a change of these files.

use apex_pdl::{CheckOptions, HostSignature, Requirement, SourceText, Unresolved, check, error_codes, render};

fn host() -> Vec<HostSignature> {
    let pure = |name: &str, count| HostSignature {
        name: name.to_string(),
        parameters_min: count,
        parameters_max: Some(count),
        pure: true,
    };
    vec![pure("distance", 2), pure("within-p", 2)]
}

fn messages(text: &str) -> String {
    let source = SourceText { name: "fire.pdl".to_string(), text: text.to_string() };
    let mut resolve = |requirement| match requirement {
        Requirement::Library(name) if name == "vehicle" => Ok(SourceText {
            name: "library/vehicle.pdl".to_string(),
            text: "(state-variable (altitude ?aircraft) :unit ft :type real)\n(primitive (index (fly-to ?place)))\n"
                .to_string(),
        }),
        _ => Err("there is no such file".into()),
    };
    let checked = check(vec![source], CheckOptions { fragment: false, host: &host(), resolve: &mut resolve });
    render(&checked.diagnostics, &checked.library.sources, false)
}

macro_rules! message_tests {
    ($($name:ident: $text:expr;)*) => {
        $(
            #[test]
            fn $name() {
                insta::assert_snapshot!(messages($text));
            }
        )*

        /// Every text above, for checks over all of them.
        const TEXTS: &[&str] = &[$($text),*];
    };
}

message_tests! {
    unmatched_close: "(primitive (index (stop))))\n";
    unclosed_list: "(procedure (index (a))\n  (step s1 (stop)\n  (step s2 (stop)))\n\n(primitive (index (stop)))\n";
    unclosed_string: "(primitive (index (stop)) (on-start (print \"abc)))\n";
    unclosed_comment: "(primitive (index (stop)))\n#| half a remark\n";
    dangling_prefix: "(defconstant place ')\n";
    number_too_large: "(defconstant far 1e999)\n";
    misspelt_unit: "(primitive (index (stop)) (duration (5 secnd)))\n";
    misspelt_quantity: "(primitive (index (stop)) (on-start (print (+ 2 35knt))))\n";
    unknown_form: "(proceduer (index (a)))\n";
    step_outside: "(primitive (index (stop)))\n(step s1 (stop))\n";
    missing_index: "(procedure (indx (a)) (step s1 (stop)))\n";
    same_index: "(procedure (index (look at ?x)))\n(procedure (index (look at ?y)))\n";
    equally_specific: "(procedure (index (go ?x to ?y fast)))\n(procedure (index (go ?x slowly ?y ?)))\n(procedure (index (go ?x ? ?y fast)))\n";
    two_definitions: "(defun f (x) x)\n(defun f (y) y)\n(defun length (x) x)\n";
    unknown_clause: "(procedure (index (a)) (step s1 (a) (witfor (ready camera-1))) (end-when (stop)))\n";
    infix_connective: "(procedure (index (a)) (step s1 (a) (waitfor ((go) :and (stop)))) (step s2 (a) (waitfor (go :or stop))) (end-when (b)))\n";
    typographic_quotes: "(primitive (index (stop)) (on-start (print “two words”)) (return ’done))\n";
    negative_duration: "(primitive (index (stop)) (duration -5s))\n(solver auto (index (go)) :budget -1s)\n";
    select_twice: "(procedure (index (a ?n)) (step s1 (b ?x) (select ?x 1) (select ?x (+ ?x ?n)) (select ?x 3)))\n(primitive (index (b ?x)))\n";
    awaited_otherwise: "(declare-event (go (?x number)))\n(procedure (index (a)) (step s1 (b) (waitfor (go 1 2))) (step s2 (b) (waitfor (go ?y))))\n(primitive (index (b)) (on-start (inform (go 1))))\n";
    misspelt_outcome: "(procedure (index (a)) (step s1 (b)) (step s2 (b) (waitfor (succeded ?s1))) (end-when (b)))\n(primitive (index (b)))\n";
    clause_twice: "(procedure (index (a)) (step s1 (a) (rank 1) (rank 2)) (end-when (b)))\n";
    waitfor_twice: "(procedure (index (a)) (step s1 (a) (waitfor (b)) (waitfor (c))) (end-when (b)))\n";
    unknown_option: "(procedure (index (a)) (step s1 (a) (repeating :with-recovry 5s)) (end-when (b)))\n";
    same_tag: "(procedure (index (a)) (step s1 (a)) (step s1 (a)) (end-when (b)))\n";
    responding_without_waitfor: "(procedure (index (a)) (step s1 (a) (responding)) (end-when (b)))\n";
    endless_repetition: "(procedure (index (a)) (step s1 (print \"again\") (repeating)) (end-when (b)))\n";
    missing_library: "(require-apex-library \"contingency\")\n";
    amount_of_unitary: "(resource radio)\n(primitive (index (talk)) (profile (radio 2)))\n";
    amount_of_other_dimension: "(resource fuel :depletable 180kg)\n(primitive (index (burn)) (profile (fuel 5s)))\n";
    unknown_function: "(primitive (index (stop)) (on-start (prnt 1) (prnt 2)))\n";
    undeclared_function: "(primitive (index (stop)) (on-start (xplane-set-channel 1)))\n";
    unknown_indexical: "(primitive (index (stop)) (on-start (print +nwo+ +setpoint+)))\n";
    unknown_tag: "(procedure (index (a)) (step first (a)) (step (a) (waitfor (end ?frist))) (end-when (b)))\n";
    unbound_variable: "(procedure (index (a ?target)) (step s1 (a ?tarrget)) (end-when (b)))\n";
    variable_of_another_step: "(procedure (index (a ?x))\n  (step s1 (a 1) (waitfor (seen ?fire)))\n  (step s2 (a ?fire))\n  (end-when (b)))\n";
    bound_in_index: "(procedure (index (a <?x>)))\n";
    variable_in_function: "(defun f (x) (+ x ?y))\n";
    wrong_arity: "(defun f (x) x)\n(primitive (index (stop)) (on-start (print (f 1 2) (first))))\n";
    effect_in_condition: "(defun shout (x) (print x))\n(procedure (index (a)) (step s1 (a) (waitfor (:function (shout 1)))) (end-when (b)))\n";
    unserved_goal: "(primitive (index (orient camera-1 to ?target)))\n(procedure (index (a ?target)) (step s3 (orient-camera-to ?target)) (step s4 (orient camera-1)) (end-when (b)))\n";
    misspelt_goal: "(primitive (index (take-picture ?camera)))\n(procedure (index (a)) (step (take-pictrue camera-1)) (end-when (b)))\n";
    unserved_initial_task: "(agent pilot :initial-task (fly mission))\n";
    missing_quality: "(procedure (index (a)) (step s1 (a) (waitfor (:episode (roll ac-1) :value (> 3)))) (end-when (b)))\n";
    unknown_condition: "(procedure (index (a)) (step s1 (a) (waitfor (:epsiode (roll ac-1)))) (end-when (b)))\n";
    plain_and: "(procedure (index (a)) (step s1 (a) (waitfor (and (b) (c)))) (end-when (b)))\n";
    symbol_as_condition: "(procedure (index (a)) (step s1 (a)) (step s2 (a) (waitfor s1)) (end-when (b)))\n";
    malformed_constraint: "(procedure (index (a)) (step s1 (a) (waitfor (:measurement (roll ac-1) :value 5))) (end-when (b)))\n";
    wrong_dimension: "(require-apex-library \"vehicle\")\n(procedure (index (a)) (end-when (altitude ac-1 > 30kt)))\n";
    undeclared_unit: "(procedure (index (a)) (end-when (altitude ac-1 > 300ft)))\n";
    wrong_type: "(require-apex-library \"vehicle\")\n(procedure (index (a)) (end-when (altitude ac-1 > high)))\n";
    added_dimensions: "(defindexical +margin+ (+ 5ft 3s))\n";
    duration_expected: "(primitive (index (stop)) (duration 5))\n";
    instant_expected: "(procedure (index (a)) (end-when (:measurement (flaps ac-1 = up) :timestamp (< 5s))))\n";
    real_equality: "(require-apex-library \"vehicle\")\n(procedure (index (a)) (end-when (altitude ac-1 = 300)))\n";
    unknown_state: "(procedure (index (a)) (restart-when (task-state +this-task+ = resumd)) (end-when (b)))\n";
    concurrent_without_end: "(primitive (index (stop)))\n(procedure (index (a)) (step (stop)))\n";
    two_conditions_in_a_clause: "(procedure (index (a)) (end-when (b) (c)))\n";
    malformed_let: "(defun f (x) (let x 5))\n";
    goals_of_shipped_libraries: "(procedure (index (a)) (step s1 (take off to 500m)) (step s2 (wait 5s)) (step s3 (ask pilot \"ok?\")) (end-when (b)))\n";
    names_of_things_that_are_alike: "(primitive (index (see bridge-1)))\n(procedure (index (a)) (step s1 (see bridge-1)) (step s2 (see bridge-2)) (end-when (b)))\n";
    sum_of_units_as_a_word: "(procedure (index (a)) (step s1 (print \"x\") (waitfor (:delay 1h30min))) (end-when (b)))\n";
    limit_below_zero: "(require-apex-library \"vehicle\")\n(procedure (index (a)) (end-when (:episode (altitude ac-1) :value (> 5m) :quality (:max-gap 5s) :timing (:duration (< 0s)))))\n";
    suspend_with_until_first: "(procedure (index (a)) (step s1 (print \"x\") (suspend (until (go)) (when (stop)))) (end-when (b)))\n";
    several_values_for_a_clause: "(primitive (index (stop)) (duration 5s 6s))\n";
}

#[test]
fn every_code_is_listed() {
    let listed: Vec<&str> = error_codes().iter().map(|each| each.code).collect();
    for text in TEXTS {
        for line in messages(text).lines() {
            let code = line.split_once('[').and_then(|(_, rest)| rest.split_once("]: "));
            if let Some((code, _)) = code {
                assert!(listed.contains(&code), "{code}");
            }
        }
    }
}

#[test]
fn one_typo_gives_one_message() {
    for text in [
        "(procedure (index (a)) (step s1 (a) (witfor (ready ?x)) (select ?y ?x)) (end-when (b)))",
        "(proceduer (index (a)))\n(agent pilot :initial-task (a))",
        "(defun f (x) (lenght x))\n(primitive (index (stop)) (on-start (print (f 1))))",
        "(procedure (index (a)) (step s1 (b))\n\n(primitive (index (b)))\n(agent pilot :initial-task (a))",
        "(defun f (x)\n(primitive (index (stop)) (on-start (print (f 1))))",
    ] {
        let text = messages(text);
        assert_eq!(text.matches("error[").count(), 1, "{text}");
    }
}

/// Names that exist come from the resolver, not from the words of its reason: here `file` is one.
#[test]
fn a_word_of_the_reason_is_not_a_name_of_a_library() {
    let text = messages("(require-apex-library \"fille\")\n");
    assert!(text.contains("there is no such file") && !text.contains("fix:"), "{text}");
    let source = SourceText { name: "fire.pdl".to_string(), text: "(require-apex-library \"fille\")\n".to_string() };
    let mut resolve = |_| Err(Unresolved { reason: "not found".to_string(), names: vec!["fill".to_string()] });
    let checked = check(vec![source], CheckOptions { fragment: false, host: &[], resolve: &mut resolve });
    let text = render(&checked.diagnostics, &checked.library.sources, false);
    assert!(text.contains("`\"fill\"`"), "{text}");
}

#[test]
fn colours_are_only_in_coloured_text() {
    let source = SourceText { name: "a.pdl".to_string(), text: "(".to_string() };
    let mut resolve = |_| Err("nothing is required".into());
    let checked = check(vec![source], CheckOptions { fragment: false, host: &[], resolve: &mut resolve });
    let sources = &checked.library.sources;
    assert!(render(&checked.diagnostics, sources, true).contains('\u{1b}'));
    assert!(!render(&checked.diagnostics, sources, false).contains('\u{1b}'));
}

/// The unit of the indexical is misspelt; it is compared with a speed in two places, and with a height in a third one.
#[test]
fn an_indexical_of_the_wrong_type_is_one_error_for_each_variable() {
    let text = "(defindexical +limit+ 2/s)\n(state-variable (climb ?aircraft) :unit m/s)\n(state-variable (height ?aircraft) :unit m)\n\
        (procedure (index (watch))\n  (step up (wait-for-it) (waitfor (climb plane > +limit+)))\n  \
        (step down (wait-for-it) (waitfor (climb plane < +limit+)))\n  \
        (step high (wait-for-it) (waitfor (height plane > +limit+))))\n(primitive (index (wait-for-it)))\n";
    let told = messages(text);
    let of = |variable: &str| told.matches(&format!("error[E0307]: `({variable} ..)`")).count();
    assert_eq!((of("climb"), of("height")), (1, 1), "{told}");
}
