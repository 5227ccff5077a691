//! Outcomes that the language's pages promise.

mod support;

use support::{agent, answer, lines, message, printed, run, sample, story, value};

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

const RESPONDING: &str = "(procedure (index (do-domain))
      (step handle (look at ?where) (waitfor (alarm ?where)) (responding))
      (step stop (terminate) (waitfor (goodbye))))
    (primitive (index (look at ?where)) (duration 5s) (on-start (print \"looking\" ?where)))";

#[test]
fn two_events_of_one_instant_get_two_tasks() {
    let events = [message(2.0, "(alarm south)"), message(2.0, "(alarm west)"), message(9.0, "(goodbye)")];
    let effects = run(&mut agent(RESPONDING), &events, 60.0);
    assert_eq!(printed(&effects), ["looking south", "looking west"]);
}
