//! Forms in place of a goal: effects of hooks, clauses and special forms. No procedure is missing then.

use crate::diagnostic::Diagnostic;
use crate::read::Datum;

/// Effects of hooks that are not activities.
const EFFECTS: &[&str] = &["replenish", "setq", "incf", "decf", "push"];
/// Clauses of steps and procedures.
const CLAUSES: &[&str] = &[
    "end-when",
    "exit-when",
    "forall",
    "invariant",
    "on-end",
    "on-failure",
    "on-start",
    "precondition",
    "priority",
    "profile",
    "rank",
    "repeating",
    "responding",
    "restart-when",
    "select",
    "skip-when",
    "waitfor",
];
/// Clauses of primitives.
const OF_PRIMITIVES: &[&str] = &["duration", "locals", "on-completion", "update"];
/// Forms that choose or bind.
const SPECIAL: &[&str] = &["and", "case", "cond", "if", "let", "let*", "or", "progn", "unless", "when"];

/// Adds why `goal` is not a goal and what to write; `None` if it may be one.
pub(super) fn explained(diagnostic: &Diagnostic, goal: &Datum) -> Option<Diagnostic> {
    let name = goal.head_name();
    let (reason, help) = if name == "publish" {
        let help =
            "as a step write `(inform (ATTRIBUTE OBJECT = VALUE))`, or write it in a hook: `(on-start (publish ..))`";
        (format!("`{name}` is a form of hooks, not an activity"), help.to_string())
    } else if matches!(name, "command" | "complete") {
        let help = format!("write a primitive for the goal: `(primitive (index (GOAL)) (on-start ({name} ..)))`");
        (format!("`{name}` is a form of primitives, not an activity"), help)
    } else if EFFECTS.contains(&name) {
        let help = format!("write it in a hook of the step or of a primitive: `(on-start ({name} ..))`");
        (format!("`{name}` is a form of hooks, not an activity"), help)
    } else if CLAUSES.contains(&name) {
        let help = format!("write it behind the goal of a step: `(step TAG (GOAL) ({name} ..))`");
        (format!("`{name}` is a clause, not an activity"), help)
    } else if OF_PRIMITIVES.contains(&name) {
        let help = format!("write a primitive for the goal: `(primitive (index (GOAL)) ({name} ..))`");
        (format!("`{name}` is a clause of primitives, not an activity"), help)
    } else if SPECIAL.contains(&name) && goal.tail().len() > 1 {
        let help = "state when the step is done: `(waitfor (:function TEST))`, `(skip-when (:function TEST))`, or compute a word of \
                    its goal: `(go ,(if TEST 'north 'south))`";
        (format!("`{name}` computes a value and pursues no goal"), help.to_string())
    } else {
        return None;
    };
    Some(diagnostic.clone().reason(reason).help(help))
}
