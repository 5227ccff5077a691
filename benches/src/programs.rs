//! Long programs, made of as many steps as a measurement asks for.

use std::fmt::Write as _;

/// One sequential procedure of `steps` steps.
pub fn sequence(steps: usize) -> String {
    let mut text = String::from("(procedure :sequential (index (do-domain))\n");
    for number in 0..steps {
        let _ = writeln!(text, "  (step s{number} (work on {number}))");
    }
    text.push_str(")\n(primitive (index (work on ?n)))\n");
    text
}

/// One concurrent procedure of `steps` steps, each of which waits for the one before.
pub fn chain(steps: usize) -> String {
    let mut text = String::from("(procedure (index (do-domain))\n  (step s0 (work on 0))\n");
    for number in 1..steps {
        let _ = writeln!(text, "  (step s{number} (work on {number}) (waitfor (terminated ?s{})))", number - 1);
    }
    let _ = writeln!(text, "  (step over (terminate) (waitfor (terminated ?s{}))))", steps.saturating_sub(1));
    text.push_str("(primitive (index (work on ?n)))\n");
    text
}

/// Procedures of four steps with everything that a checker has to look at, `steps` steps in all.
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
