//! Outcomes that the language reference states, and the paper's own listings as printed.

mod support;

use support::{agent, answer, lines, message, printed, run, sample, story};

#[test]
fn priorities_three_five_two_on_one_resource_run_b_a_c() {
    let pdl = "(procedure (index (do-domain))
      (step a (use a) (priority 3)) (step b (use b) (priority 5)) (step c (use c) (priority 2)))
      (primitive (index (use ?x)) (profile tool) (duration 1s) (on-start (print ?x)))";
    assert_eq!(printed(&run(&mut agent(pdl), &[], 60.0)), ["b", "a", "c"]);
}

#[test]
fn ranks_two_one_three_run_b_a_c() {
    let pdl = "(procedure (index (do-domain))
      (step a (use a) (rank 2)) (step b (use b) (rank 1)) (step c (use c) (rank 3)))
      (primitive (index (use ?x)) (profile tool) (duration 1s) (on-start (print ?x)))";
    assert_eq!(printed(&run(&mut agent(pdl), &[], 60.0)), ["b", "a", "c"]);
}

#[test]
fn a_restart_runs_the_start_action_again_and_the_end_action_only_at_the_end() {
    let pdl = "(procedure (index (do-domain)) (step work (work)))
      (procedure :sequential (index (work))
        (restart-when (again))
        (on-start (print 1)) (on-end (print 2))
        (step pause (pause)) (step x (print 3)) (step y (print 4)) (step z (print 5)))
      (primitive (index (pause)) (duration 10s))";
    let effects = run(&mut agent(pdl), &[message(0.2, "(again)")], 60.0);
    assert_eq!(printed(&effects), ["1", "1", "3", "4", "5", "2"]);
    assert!(story(&effects).contains(&"10.2s print 5".to_string()));
}

#[test]
fn two_events_of_one_instant_get_two_tasks() {
    let pdl = "(procedure (index (do-domain))
        (step handle (look at ?where) (waitfor (alarm ?where)) (responding))
        (step stop (terminate) (waitfor (goodbye))))
      (primitive (index (look at ?where)) (duration 5s) (on-start (print \"looking\" ?where)))";
    let events = [message(2.0, "(alarm south)"), message(2.0, "(alarm west)"), message(9.0, "(goodbye)")];
    assert_eq!(printed(&run(&mut agent(pdl), &events, 60.0)), ["looking south", "looking west"]);
}

/// Section III of the paper as printed, with primitives for its steps.
const CAMERA: &str = "
(procedure
  (index (get hires image ?target))
  (profile camera-1)
  (step s1 (move-to best-imaging-loc for ?target => ?loc))
  (step s2 (power-up camera-1))
  (step s3 (orient-camera-to ?target)
    (waitfor (:and (ready camera-1)(location +self+ = ?loc))))
  (step s4 (take-picture camera-1)
    (waitfor (end ?s3)))
  (restart-when (task-state +this-task+ = resumed))
  (end-when (image-in-memory ?target)))
(procedure (index (do-domain))
  (step image (get hires image bridge))
  (step calibrate (calibrate camera-1) (waitfor (calibration-due)) (priority 5)))
(primitive (index (move-to best-imaging-loc for ?target)) (profile flight-path)
  (on-start (command (fly-to ?target))) (return 'over-bridge))
(primitive (index (power-up ?camera)) (duration 2s) (on-completion (inform (ready ?camera))))
(primitive (index (orient-camera-to ?target)) (duration 1s))
(primitive (index (take-picture ?camera)) (duration 1s) (on-completion (inform (image-in-memory bridge))))
(primitive (index (calibrate ?camera)) (profile ?camera) (duration 20s))";

#[test]
fn the_camera_procedure_as_printed() {
    let events = [answer(5.0, 0, Ok(apex_model::value::Value::nil())), sample(6.0, "(location pilot)", "over-bridge")];
    let effects = run(&mut agent(CAMERA), &events, 60.0);
    let wanted = ["s1", "s2", "s3", "s4", "image"];
    assert_eq!(
        lines(&effects, &wanted),
        [
            "0s image enabled",
            "0s image ongoing",
            "0s s1 enabled",
            "0s s2 enabled",
            "0s s1 ongoing",
            "0s s2 ongoing",
            "2s s2 terminated",
            "5s s1 terminated",
            "6s s3 enabled",
            "6s s3 ongoing",
            "7s s3 terminated",
            "7s s4 enabled",
            "7s s4 ongoing",
            "8s s4 terminated",
            "8s image terminated",
        ]
    );
}

#[test]
fn a_picture_interrupted_by_a_calibration_starts_over_when_it_resumes() {
    let ok = || Ok(apex_model::value::Value::nil());
    let events = [
        message(1.0, "(calibration-due)"),
        answer(5.0, 0, ok()),
        answer(26.0, 1, ok()),
        sample(27.0, "(location pilot)", "over-bridge"),
    ];
    let effects = run(&mut agent(CAMERA), &events, 100.0);
    assert_eq!(
        lines(&effects, &["image", "calibrate", "end", "command"]),
        [
            "0s image enabled",
            "0s image ongoing",
            "0s command 0 (fly-to bridge)",
            "1s calibrate enabled",
            "1s image interrupted",
            "1s calibrate ongoing",
            "21s calibrate terminated",
            "21s image ongoing",
            "21s image pending",
            "21s image enabled",
            "21s image ongoing",
            "21s command 1 (fly-to bridge)",
            "29s image terminated",
            "29s end",
        ]
    );
}

/// Section IV, example 1, as printed: the `select` follows the step and belongs to it.
const WINGS_LEVEL: &str = "
(defindexical +this-aircraft+ 'aircraft-1)
(defindexical +max-roll-angle-deviation+ 3)
(defindexical +max-off-nominal-roll-angle-duration+ P5S)
(defindexical +current-location+ (current-value 'location +this-aircraft+))
(procedure (index (do-domain))
(step (refly segment visited from ?loc to +current-location+)
  (waitfor
    (:episode roll-violation (roll-angle +this-aircraft+)
      :value (> +max-roll-angle-deviation+)
      :timing
        (:duration (> +max-off-nominal-roll-angle-duration+)))
    :quality (:no-constraints)))
(select ?loc
  (most-recent-SVvalue 'location +this-aircraft+
    :prior-to (start ?roll-violation))))
(primitive (index (refly segment visited from ?from to ?to)) (on-start (print ?from \"->\" ?to)))";

#[test]
fn a_wings_level_violation_reflies_the_segment() {
    let mut events = Vec::new();
    for second in 0..20_i32 {
        let at = f64::from(second);
        events.push(sample(at, "(location aircraft-1)", &format!("km-{second}")));
        events.push(sample(at, "(roll-angle aircraft-1)", if second < 8 { "1" } else { "7" }));
    }
    let effects = run(&mut agent(WINGS_LEVEL), &events, 60.0);
    let story = story(&effects);
    let refly = story.iter().find(|line| line.contains("print")).cloned();
    assert_eq!(refly.as_deref(), Some("14s print km-7 -> km-14"), "{story:#?}");
}

#[test]
fn a_resumed_command_is_sent_again_and_one_that_starts_over_only_once() {
    let commands = |clause: &str| {
        let pdl = format!(
            "(procedure (index (do-domain)) (step line (fly) {clause}) (step fire (look) (waitfor (fire)) (priority 5)))
             (primitive (index (fly)) (profile path) (on-start (command (fly))))
             (primitive (index (look)) (profile path) (duration 3s))"
        );
        let effects = run(&mut agent(&pdl), &[message(2.0, "(fire)")], 20.0);
        let told = story(&effects).into_iter().filter(|line| line.contains("command") || line.contains("withdraw"));
        told.collect::<Vec<_>>()
    };
    let expected = ["0s command 0 (fly)", "2s withdraw 0", "5s command 1 (fly)"];
    assert_eq!(commands(""), expected);
    assert_eq!(commands("(restart (when (state +this-task+ = resumed)))"), expected);
}
