//! The words of the language outside of expressions, as tables that must be complete.

/// Words of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Words {
    /// Kind of word: `clause of a step`.
    pub kind: &'static str,
    /// The words; options without their colon.
    pub words: &'static [&'static str],
}

/// Every top-level form, clause and option of a repetition or an agent. Functions are in `apex_model::builtins`.
pub const VOCABULARY: &[Words] = &[
    Words { kind: "top-level form", words: FORMS },
    Words { kind: "clause of a procedure", words: PROCEDURE_CLAUSES },
    Words { kind: "clause of a step", words: STEP_CLAUSES },
    Words { kind: "clause of a primitive", words: PRIMITIVE_CLAUSES },
    Words { kind: "clause for readers", words: DOCUMENTATION_CLAUSES },
    Words { kind: "option of `repeating`", words: REPEATING_OPTIONS },
    Words { kind: "option of an agent", words: AGENT_OPTIONS },
];

/// Top-level forms.
pub(crate) const FORMS: &[&str] = &[
    "agent",
    "declare-command",
    "declare-event",
    "declare-function",
    "defapplication",
    "defconstant",
    "defindexical",
    "defun",
    "in-apex-bundle",
    "primitive",
    "procedure",
    "require-apex-file",
    "require-apex-library",
    "resource",
    "router",
    "solver",
    "state-variable",
];

/// Clauses of a procedure.
pub(crate) const PROCEDURE_CLAUSES: &[&str] = &[
    "index",
    "step",
    "profile",
    "log",
    "expected-duration",
    "interrupt-cost",
    "end-when",
    "exit-when",
    "invariant",
    "precondition",
    "terminate",
    "restart",
    "restart-when",
    "resume",
    "resume-when",
    "suspend",
    "suspend-when",
    "on-start",
    "on-end",
    "on-suspend",
    "on-resume",
    "select",
];

/// Clauses of a step.
pub(crate) const STEP_CLAUSES: &[&str] = &[
    "waitfor",
    "select",
    "forall",
    "priority",
    "rank",
    "interrupt-cost",
    "repeating",
    "responding",
    "profile",
    "on-start",
    "on-end",
    "on-suspend",
    "on-resume",
    "on-failure",
    "terminate",
    "end-when",
    "exit-when",
    "invariant",
    "precondition",
    "skip-when",
    "restart",
    "restart-when",
    "resume",
    "resume-when",
    "suspend",
    "suspend-when",
];

/// Clauses for readers only, in procedures, primitives and steps: `(author "..")`, also as `(:author "..")`.
pub(crate) const DOCUMENTATION_CLAUSES: &[&str] =
    &["author", "comment", "copyright", "date", "doc", "documentation", "version"];

/// Clauses of a primitive.
pub(crate) const PRIMITIVE_CLAUSES: &[&str] = &[
    "index",
    "profile",
    "locals",
    "duration",
    "on-enablement",
    "on-start",
    "update",
    "on-completion",
    "on-end",
    "on-suspend",
    "on-resume",
    "return",
];

/// Options of `repeating`; `responding` has some of them.
pub(crate) const REPEATING_OPTIONS: &[&str] =
    &["while", "until", "enabled", "with-recovery", "with-min-interval", "for-new", "missed-messages"];

/// Options of `agent`.
pub(crate) const AGENT_OPTIONS: &[&str] = &["initial-task", "use-bundles", "routers", "workload", "limits"];

/// Activities that need no definition, for suggestions.
pub(crate) const ACTIVITIES: &[&str] = &[
    "terminate",
    "reset",
    "suspend",
    "resume",
    "reprioritize",
    "cogevent",
    "inform",
    "hold-resource",
    "release-resource",
    "print",
    "end-application",
    "ask",
    "plan",
];
