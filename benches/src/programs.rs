//! Long programs with any required number of steps.

use std::fmt::Write as _;

/// Returns one procedure of `kind`, with steps made by `step` from their numbers, and the primitive that serves them.
fn written(kind: &str, steps: usize, step: impl Fn(usize) -> String, primitive: &str) -> String {
    let mut text = format!("(procedure {kind} (index (do-domain))\n");
    for number in 0..steps {
        let _ = writeln!(text, "  {}", step(number));
    }
    let _ = write!(text, ")\n(primitive (index (work on ?n)) {primitive})\n");
    text
}

/// Steps that each wait for a sample of a separate variable, and then send a command.
pub fn waiting(steps: usize) -> String {
    let step = |number| format!("(step s{number} (work on {number}) (waitfor (level {number} > 10)))");
    written("", steps, step, "(on-start (command (act ?n)))")
}

/// Steps that each wait for one variable to exceed a separate bound, from 1,000 on, and then send a command.
pub fn bounds(steps: usize) -> String {
    let step = |number| format!("(step s{number} (work on {number}) (waitfor (level 0 > {})))", 1_000 + number);
    written("", steps, step, "(on-start (command (act ?n)))")
}

/// Tasks of one `forall`.
pub fn flat(tasks: usize) -> String {
    format!(
        "(procedure (index (do-domain)) (step all (work on ?n) (forall ?n in (range {tasks}))))
(primitive (index (work on ?n)))\n"
    )
}

/// Returns a program of `tasks` tasks in towers of fifty, in which each task but the lowest has one child.
pub fn nested(tasks: usize) -> String {
    const HEIGHT: usize = 50;
    let towers = (tasks / HEIGHT).max(1);
    let mut text = format!("(procedure (index (do-domain)) (step all (floor1 ?n) (forall ?n in (range {towers}))))\n");
    for floor in 1..HEIGHT {
        let _ = writeln!(text, "(procedure (index (floor{floor} ?n)) (step up (floor{} ?n)))", floor + 1);
    }
    let _ = writeln!(text, "(primitive (index (floor{HEIGHT} ?n)))");
    text
}

/// Returns one concurrent procedure of `steps` steps.
pub fn concurrent(steps: usize) -> String {
    written("", steps, |number| format!("(step s{number} (work on {number}))"), "")
}

/// Returns one ranked procedure of `steps` steps.
pub fn ranked(steps: usize) -> String {
    written(":ranked", steps, |number| format!("(step s{number} (work on {number}))"), "")
}

/// Returns one sequential procedure of `steps` steps.
pub fn sequence(steps: usize) -> String {
    let mut text = String::from("(procedure :sequential (index (do-domain))\n");
    for number in 0..steps {
        let _ = writeln!(text, "  (step s{number} (work on {number}))");
    }
    text.push_str(")\n(primitive (index (work on ?n)))\n");
    text
}

/// Returns one concurrent procedure of `steps` steps, each of which waits for the previous one.
pub fn chain(steps: usize) -> String {
    let mut text = String::from("(procedure (index (do-domain))\n  (step s0 (work on 0))\n");
    for number in 1..steps {
        let _ = writeln!(text, "  (step s{number} (work on {number}) (waitfor (terminated ?s{})))", number - 1);
    }
    let _ = writeln!(text, "  (step over (terminate) (waitfor (terminated ?s{}))))", steps.saturating_sub(1));
    text.push_str("(primitive (index (work on ?n)))\n");
    text
}

/// Procedures of four steps with everything that a checker has to examine, `steps` steps in all.
pub fn procedures(steps: usize) -> String {
    let mut text = String::from("(procedure (index (do-domain))\n  (step s (job 0 alpha))\n  (step t (terminate)))\n");
    for number in 0..steps / 4 {
        let _ = write!(
            text,
            "(procedure (index (job {number} ?target))
  (profile camera-{number})
  (step go (move to ?target for {number} => ?where))
  (step aim (aim camera-{number} at ?target 5deg)
    (waitfor (:and (ready camera-{number}) (location +self+ = ?where))))
  (step shoot (shoot {number})
    (waitfor (end ?aim)) (priority (+ 1 {number})))
  (step stop (terminate >> ?where)
    (waitfor (end ?shoot))))\n"
        );
    }
    text.push_str("(primitive (index (move to ?target for ?n)) (duration 5s) (return ?target))\n");
    text.push_str(
        "(primitive (index (aim ?camera at ?target ?angle)) (duration 1s))\n(primitive (index (shoot ?n)))\n",
    );
    text
}
