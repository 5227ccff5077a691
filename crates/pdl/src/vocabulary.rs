//! The words of the language outside of expressions, as the checker knows them: for tables that must be complete.

use crate::check::FORMS;
use crate::lower::{AGENT_OPTIONS, PRIMITIVE_CLAUSES, PROCEDURE_CLAUSES, REPEATING_OPTIONS, STEP_CLAUSES};

/// Words of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Words {
    /// What they are: `clause of a step`.
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
    Words { kind: "option of `repeating`", words: REPEATING_OPTIONS },
    Words { kind: "option of an agent", words: AGENT_OPTIONS },
];
